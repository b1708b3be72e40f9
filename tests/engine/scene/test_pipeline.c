#include "scene_test.h"

#include <math.h>

#define WALL "void plastic wall 0 0 5 .7 .7 .7 0 0\n"

static const double tiny = 64 * 0x1p-53;

static void assert_reals_near(const pm_primitive *p, const double *want, size_t count)
{
    assert_int_equal(p->real_count, count);
    for (size_t i = 0; i < count; i++)
        if (!(fabs(p->reals[i] - want[i]) <= tiny))
            fail_msg("real %zu of %s is %.17g, not %.17g", i, p->name, p->reals[i], want[i]);
}

static void a_generators_primitives_are_those_of_its_text(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "!genblinds wall slat .1 2 1 1 0\n", NULL);
    assert_int_equal(scene->count, 2);
    ASSERT_REALS(named(scene, "slat.1.0"), 0, 0, .5, 0, 2, .5, .1, 2, .5, .1, 0, .5);
    pm_scene_free(scene);
}

static void a_pipes_xform_moves_what_comes_through_it(void **state)
{
    (void)state;
    pm_scene *scene =
        scene_of(WALL "!genworm wall w 2*t 0 0 .5 1 | xform -rz 90 | xform -t 0 0 3\n", NULL);
    const double want[] = {0, 2, 3, .5};
    assert_reals_near(named(scene, "w.s1"), want, 4);
    pm_scene_free(scene);
}

static void files_go_through_pipes_too(void **state)
{
    (void)state;
    static const char ball[] = "wall sphere s 0 0 4 1 0 0 .5\n";
    pm_scene *first = scene_of(WALL "!xform -t 1 0 0 part.rad|xform -s 2\n", ball);
    pm_scene *second = scene_of(WALL "!cat part.rad | xform -t 1 0 0 | xform -s 2\n", ball);
    pm_scene *third = scene_of(WALL "!cat part.rad part.rad\n", ball);
    ASSERT_REALS(named(first, "s"), 4, 0, 0, 1);
    ASSERT_REALS(named(second, "s"), 4, 0, 0, 1);
    ASSERT_REALS(named(third, "s"), 1, 0, 0, .5);
    assert_int_equal(third->count, 3);
    pm_scene_free(first);
    pm_scene_free(second);
    pm_scene_free(third);
}

/* The last xform's array varies slowest, and its prefix stands in front. */
static void arrays_of_arrays_multiply(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "!genworm wall w 0 0 t .1 1 | xform -n a -a 3 -t 1 0 0 | "
                                    "xform -n b -a 2 -t 0 5 0\n",
                               NULL);
    assert_int_equal(scene->count, 1 + 3 * 2 * 3);
    ASSERT_REALS(named(scene, "b.1.a.2.w.s1"), 2, 5, 1, .1);
    assert_string_equal(scene->primitives[1].name, "b.0.a.0.w.s0");
    assert_string_equal(scene->primitives[4].name, "b.0.a.1.w.s0");
    pm_scene_free(scene);
}

static void the_outer_modifier_counts(void **state)
{
    (void)state;
    pm_scene *scene =
        scene_of(WALL "void metal steel 0 0 5 .7 .7 .7 1 0\n"
                      "!genbox wall b 1 1 1 | xform -m wall | xform -m steel -I\n",
                 NULL);
    const pm_primitive *side = named(scene, "b.1540");
    assert_int_equal(side->modifier, 1);
    ASSERT_REALS(side, 0, 0, 0, 0, 0, 1, 1, 0, 1, 1, 0, 0);
    pm_scene_free(scene);
}

static void primitives_have_the_place_of_their_command(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "\n  !genbox wall b 1 1 1 | \\\n xform -t 0 0 2\n", NULL);
    for (size_t i = 1; i < scene->count; i++) {
        assert_string_equal(scene->files[scene->primitives[i].file], "main.rad");
        assert_int_equal(scene->primitives[i].line, 3);
        assert_int_equal(scene->primitives[i].column, 4);
    }
    pm_scene_free(scene);
}

static void words_are_quoted_as_in_a_shell(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "!genworm 'wall' \"w\" 2\\*t '0' \"if(t-.5,1,0)\" .1 1\n"
                                    "!genrev wall \\\n r t '.5' 1 # upright\n",
                               NULL);
    assert_int_equal(scene->count, 1 + 3 + 1);
    pm_scene_free(scene);
}

static void a_sky_is_a_pattern_and_a_sun(void **state)
{
    (void)state;
    pm_scene *scene = scene_of("!gensky -ang 45 0 | xform -rz 90\n"
                               "skyfunc glow sky_glow 0 0 4 1 1 1 0\n"
                               "sky_glow source sky 0 0 4 0 0 1 180\n",
                               NULL);
    const double want[] = {.707107, 0, .707107, .5};
    assert_int_equal(named(scene, "solar")->type, PM_LIGHT);
    assert_int_equal(named(scene, "skyfunc")->type, PM_BRIGHTFUNC);
    assert_reals_near(named(scene, "sun"), want, 4);
    pm_scene_free(scene);
}

/* As Radiance names them: the first -n with the copy's number, or i and the number. */
static void a_list_makes_a_copy_for_each_line(void **state)
{
    (void)state;
    static const char places[] =
        "# two chairs\n-t 1 0 0\n\n!xform -t 2 0 0 \\\n -a 2 -t 0 1 0\n";
    pm_scene *plain =
        scene_of(WALL "!genworm wall w 0 0 t .5 1 | xform -f part.rad -s 2\n", places);
    pm_scene *called =
        scene_of(WALL "!genworm wall w 0 0 t .5 1 | xform -n chair -f part.rad\n", places);
    assert_int_equal(plain->count, 1 + 3 * 3);
    ASSERT_REALS(named(plain, "i0.w.s0"), 2, 0, 0, 1);
    /* What follows the list belongs to its array. */
    ASSERT_REALS(named(plain, "i1.0.w.s0"), 2, 0, 0, .5);
    ASSERT_REALS(named(called, "chair.0.w.s0"), 1, 0, 0, .5);
    ASSERT_REALS(named(called, "chair.1.1.w.s1"), 2, 1, 1, .5);
    pm_scene_free(plain);
    pm_scene_free(called);
}

/* Its text of 20 MB is made and read a piece at a time. */
static void a_large_surface_is_read_in_pieces(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(WALL "!gensurf wall s s t s*t 300 200\n", NULL);
    assert_int_equal(scene->count, 1 + 2 * 300 * 200);
    assert_string_equal(scene->primitives[scene->count - 1].name, "s.120000");
    pm_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_generators_primitives_are_those_of_its_text),
        cmocka_unit_test(a_pipes_xform_moves_what_comes_through_it),
        cmocka_unit_test(files_go_through_pipes_too),
        cmocka_unit_test(arrays_of_arrays_multiply),
        cmocka_unit_test(the_outer_modifier_counts),
        cmocka_unit_test(primitives_have_the_place_of_their_command),
        cmocka_unit_test(words_are_quoted_as_in_a_shell),
        cmocka_unit_test(a_sky_is_a_pattern_and_a_sun),
        cmocka_unit_test(a_list_makes_a_copy_for_each_line),
        cmocka_unit_test(a_large_surface_is_read_in_pieces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
