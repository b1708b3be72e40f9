#include "scene_test.h"

#define WALL "void plastic wall 0 0 5 .7 .6 .5 .1 .2\n"
#define BALL "wall sphere ball 0 0 4 1 2 3 4\n"

static void a_primitive_keeps_what_was_written_and_where(void **state)
{
    (void)state;
    pm_scene *scene = scene_of("# walls\n" WALL "wall sphere\n ball 0 0 4 1 2 3 4\n", NULL);
    assert_int_equal(scene->count, 2);
    const pm_primitive *wall = &scene->primitives[0], *ball = &scene->primitives[1];
    assert_int_equal(wall->type, PM_PLASTIC);
    assert_int_equal(wall->modifier, PM_VOID);
    assert_int_equal(wall->line, 2);
    assert_int_equal(wall->column, 6);
    ASSERT_REALS(wall, .7, .6, .5, .1, .2);
    assert_int_equal(ball->type, PM_SPHERE);
    assert_int_equal(ball->modifier, 0);
    assert_int_equal(ball->line, 3);
    assert_string_equal(ball->name, "ball");
    assert_string_equal(scene->files[ball->file], "main.rad");
    ASSERT_REALS(ball, 1, 2, 3, 4);
    pm_scene_free(scene);
}

static void white_space_and_comments_mean_nothing(void **state)
{
    (void)state;
    pm_scene *a = scene_of(WALL BALL, NULL);
    pm_scene *b =
        scene_of("#\n\n  void\nplastic\twall\r\n0\n0\n5\n.7 .6\n.5\n.1 .2 # end\n#end\n"
                 "wall sphere ball 0 0 4 1 2 3 4",
                 NULL);
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; i++) {
        assert_int_equal(a->primitives[i].type, b->primitives[i].type);
        assert_reals(&b->primitives[i], a->primitives[i].reals, a->primitives[i].real_count);
    }
    pm_scene_free(a);
    pm_scene_free(b);
}

static void an_empty_file_is_an_empty_scene(void **state)
{
    (void)state;
    pm_scene *scene = scene_of("", NULL);
    assert_int_equal(scene->count, 0);
    pm_scene_free(scene);
    scene = scene_of("# nothing yet", NULL);
    assert_int_equal(scene->count, 0);
    pm_scene_free(scene);
    pm_scene_free(NULL);
}

static void a_modifier_is_its_latest_definition(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL BALL "void metal wall 0 0 5 .9 .9 .9 1 0\n"
                                         "wall sphere ball2 0 0 4 1 2 3 4\n",
                               NULL);
    assert_int_equal(named(scene, "ball")->modifier, 0);
    assert_int_equal(named(scene, "ball2")->modifier, 2);
    pm_scene_free(scene);
}

/* A surface's name is no modifier, so it hides none (src/common/modobject.c). */
static void a_surface_does_not_hide_a_material(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "wall sphere wall 0 0 4 1 2 3 4\n" BALL, NULL);
    assert_int_equal(named(scene, "ball")->modifier, 0);
    pm_scene_free(scene);
}

static void an_alias_is_what_it_means(void **state)
{
    (void)state;
    pm_scene *scene =
        scene_of(WALL "void alias paint wall\ninherit alias coat paint\n"
                      "void metal wall 0 0 5 .9 .9 .9 1 0\n"
                      "coat sphere a 0 0 4 1 2 3 4\npaint sphere b 0 0 4 1 2 3 4\n",
                 NULL);
    assert_int_equal(scene->count, 4);
    assert_int_equal(named(scene, "a")->modifier, 0);
    assert_int_equal(named(scene, "b")->modifier, 0);
    pm_scene_free(scene);
}

static void string_arguments_are_resolved(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "void metal steel 0 0 5 .9 .9 .9 1 0\n"
                                    "void illum window 1 steel 0 3 1 1 1\n"
                                    "void illum open 0 0 3 1 1 1\n"
                                    "void mirror m 1 void 0 3 1 1 1\n"
                                    "void antimatter hole 3 steel void wall 0 0\n"
                                    "void mist fog 2 lamp 'm>lamp' 0 3 1 1 1\n",
                               NULL);
    assert_int_equal(named(scene, "window")->references[0], 1);
    assert_string_equal(named(scene, "window")->strings[0], "steel");
    assert_int_equal(named(scene, "open")->string_count, 0);
    assert_int_equal(named(scene, "m")->references[0], PM_VOID);
    const pm_primitive *hole = named(scene, "hole"), *fog = named(scene, "fog");
    assert_int_equal(hole->string_count, 3);
    assert_int_equal(hole->references[0], 1);
    assert_int_equal(hole->references[1], PM_VOID);
    assert_int_equal(hole->references[2], 0);
    assert_null(fog->references);
    assert_string_equal(fog->strings[1], "m>lamp");
    pm_scene_free(scene);
}

static void negative_radii_turn_surfaces_inside_out(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "wall sphere a 0 0 4 1 2 3 -4\n"
                                    "wall bubble b 0 0 4 1 2 3 -4\n"
                                    "wall cylinder c 0 0 7 0 0 0 0 0 1 -2\n"
                                    "wall tube d 0 0 7 0 0 0 0 0 1 -2\n"
                                    "wall cone e 0 0 8 0 0 0 0 0 1 -2 -1\n"
                                    "wall cup f 0 0 8 0 0 0 0 0 1 -2 0\n",
                               NULL);
    static const pm_primitive_type types[] = {PM_BUBBLE,   PM_SPHERE, PM_TUBE,
                                              PM_CYLINDER, PM_CUP,    PM_CONE};
    for (size_t i = 0; i < 6; i++)
        assert_int_equal(scene->primitives[i + 1].type, types[i]);
    ASSERT_REALS(named(scene, "a"), 1, 2, 3, 4);
    ASSERT_REALS(named(scene, "c"), 0, 0, 0, 0, 0, 1, 2);
    ASSERT_REALS(named(scene, "e"), 0, 0, 0, 0, 0, 1, 2, 1);
    ASSERT_REALS(named(scene, "f"), 0, 0, 0, 0, 0, 1, 2, 0);
    pm_scene_free(scene);
}

static void a_cone_with_equal_radii_is_a_cylinder(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "wall cone a 0 0 8 0 0 0 0 0 1 2 2\n"
                                    "wall cone b 0 0 8 0 0 0 0 0 1 -2 -2\n"
                                    "wall ring c 0 0 8 0 0 0 0 0 1 2 1\n",
                               NULL);
    assert_int_equal(named(scene, "a")->type, PM_CYLINDER);
    ASSERT_REALS(named(scene, "a"), 0, 0, 0, 0, 0, 1, 2);
    assert_int_equal(named(scene, "b")->type, PM_TUBE);
    ASSERT_REALS(named(scene, "c"), 0, 0, 0, 0, 0, 1, 1, 2);
    pm_scene_free(scene);
}

static void commands_are_split_like_a_shell_does(void **state)
{
    (void)state;
    pm_scene *scene =
        scene_of(WALL "  !xform -n 'a b' -t 1 \\\n  0 0 \"par\"t.rad # a comment\n" BALL
                      "!xform -n \"c\\\"d\" part\\.rad",
                 "wall sphere s 0 0 4 0 0 0 1\n");
    assert_int_equal(scene->count, 4);
    ASSERT_REALS(named(scene, "a b.s"), 1, 0, 0, 1);
    ASSERT_REALS(named(scene, "c\"d.s"), 0, 0, 0, 1);
    pm_scene_free(scene);
}

static void surfaces_take_the_modifier_and_the_prefix_of_xform(void **state)
{
    (void)state;
    pm_scene *scene = scene_of("void metal steel 0 0 5 .9 .9 .9 1 0\n" WALL
                               "!xform -n box -m steel -m wall part.rad\n",
                               "void plastic p 0 0 5 .5 .5 .5 0 0\n"
                               "nowhere sphere s 0 0 4 0 0 0 1\n");
    assert_int_equal(named(scene, "box.s")->modifier, 0);  /* the first -m counts */
    assert_int_equal(named(scene, "p")->type, PM_PLASTIC); /* modifiers keep their names */
    pm_scene_free(scene);
}

static pm_bundle *nested_bundle(void)
{
    static const char desk[] =
        "!xform -n leg -a 2 -t 2 0 0 leg.rad\n!xform -m wall -mx leg.rad\n";
    static const char leg[] = "steel cylinder c 0 0 7 1 0 0 1 0 1 .1\n";
    static const char other[] = "steel sphere not_this_one 0 0 4 0 0 0 1\n";
    pm_bundle *bundle = bundle_of("void metal steel 0 0 5 .9 .9 .9 1 0\n" WALL
                                  "!xform -n desk -m steel -t 0 0 10 -s 2 parts/desk.rad\n",
                                  NULL);
    assert_int_equal(pm_bundle_add(bundle, "parts/desk.rad", desk, strlen(desk), NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "parts/leg.rad", leg, strlen(leg), NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "leg.rad", other, strlen(other), NULL), PM_OK);
    return bundle;
}

/* The inner transform comes first; the outer -m wins; a file is looked for beside the one that
 * names it. */
static void nested_files_are_transformed_from_the_inside(void **state)
{
    (void)state;
    pm_bundle *bundle = nested_bundle();
    pm_scene *scene = NULL;
    assert_int_equal(pm_scene_parse(bundle, "main.rad", NULL, &scene, NULL), PM_OK);
    pm_bundle_free(bundle);
    assert_int_equal(scene->count, 5);
    ASSERT_REALS(named(scene, "desk.leg.0.c"), 2, 0, 20, 2, 0, 22, .2);
    ASSERT_REALS(named(scene, "desk.leg.1.c"), 6, 0, 20, 6, 0, 22, .2);
    ASSERT_REALS(named(scene, "desk.c"), -2, 0, 20, -2, 0, 22, .2);
    assert_int_equal(named(scene, "desk.c")->modifier, 0);
    assert_string_equal(scene->files[named(scene, "desk.c")->file], "parts/leg.rad");
    pm_scene_free(scene);
}

static pm_status parse_within(const char *main_text, const char *part_text,
                              pm_scene_limits limits, pm_error *err)
{
    pm_bundle *bundle = bundle_of(main_text, part_text);
    pm_scene *scene = NULL;
    pm_status st = pm_scene_parse(bundle, "main.rad", &limits, &scene, err);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return st;
}

static void limits_are_kept_exactly(void **state)
{
    (void)state;
    static const char part[] = "wall sphere s 0 0 4 0 0 0 1\n";
    static const char array[] = WALL "!xform -a 9 -t 1 0 0 part.rad\n";
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.primitives = 10}, NULL),
                     PM_OK);
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.primitives = 9}, &err),
                     PM_E_LIMIT);
    assert_int_equal(err.line, 2);
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.reals = 41}, NULL), PM_OK);
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.reals = 40}, NULL),
                     PM_E_LIMIT);
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.bytes = 5000}, NULL),
                     PM_E_LIMIT);
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.nesting = 2}, NULL), PM_OK);
    assert_int_equal(parse_within(array, part, (pm_scene_limits){.nesting = 1}, NULL),
                     PM_E_LIMIT);
    assert_int_equal(parse_within(WALL BALL, NULL, (pm_scene_limits){.primitives = 2}, NULL),
                     PM_OK);
    assert_int_equal(
        parse_within(WALL BALL BALL, NULL, (pm_scene_limits){.primitives = 2}, &err),
        PM_E_LIMIT);
    assert_int_equal(parse_within(WALL BALL, NULL, (pm_scene_limits){.reals = 8}, NULL),
                     PM_E_LIMIT);
}

/* Empty files count, too: 10^12 readings of nothing would take days. */
static void an_array_of_nothing_is_refused(void **state)
{
    (void)state;
    pm_scene_limits none = {0};
    assert_int_equal(parse_within("!xform -a 1000000 -a 1000000 part.rad\n", "", none, NULL),
                     PM_E_LIMIT);
    assert_int_equal(parse_within("!xform -a 99999999999999999 -a 99999999999999999 part.rad\n",
                                  "", none, NULL),
                     PM_E_LIMIT);
}

static void a_main_file_that_is_not_there_is_missing(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = bundle_of("", NULL);
    pm_scene *scene = NULL;
    assert_int_equal(pm_scene_parse(bundle, "other.rad", NULL, &scene, &err), PM_E_MISSING);
    assert_null(scene);
    assert_string_equal(err.text, "there is no file 'other.rad' in the bundle");
    pm_bundle_free(bundle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_primitive_keeps_what_was_written_and_where),
        cmocka_unit_test(white_space_and_comments_mean_nothing),
        cmocka_unit_test(an_empty_file_is_an_empty_scene),
        cmocka_unit_test(a_modifier_is_its_latest_definition),
        cmocka_unit_test(a_surface_does_not_hide_a_material),
        cmocka_unit_test(an_alias_is_what_it_means),
        cmocka_unit_test(string_arguments_are_resolved),
        cmocka_unit_test(negative_radii_turn_surfaces_inside_out),
        cmocka_unit_test(a_cone_with_equal_radii_is_a_cylinder),
        cmocka_unit_test(commands_are_split_like_a_shell_does),
        cmocka_unit_test(surfaces_take_the_modifier_and_the_prefix_of_xform),
        cmocka_unit_test(nested_files_are_transformed_from_the_inside),
        cmocka_unit_test(limits_are_kept_exactly),
        cmocka_unit_test(an_array_of_nothing_is_refused),
        cmocka_unit_test(a_main_file_that_is_not_there_is_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
