#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "compile.h"
#include "octrees.h"
#include "world/selection.h"

#define SQUARE(modifier, name, z)                                                              \
    modifier " polygon " name " 0 0 12 0 0 " z " 1 0 " z " 1 1 " z " 0 1 " z "\n"
#define PLASTIC " 0 0 5 .5 .5 .5 0 0\n"

static const char three_walls[] = "void brightfunc dirt 2 1 . 0 0\n"
                                  "void plastic red" PLASTIC "dirt plastic grey" PLASTIC
                                  "void alias pane red\n" SQUARE("red", "low", "0")
                                      SQUARE("pane", "middle", "1") SQUARE("grey", "high", "2");

/* The surface that a ray down from height z meets first. */
static uint32_t below(const pm_world *world, double z)
{
    pm_hit hit;
    pm_vec3 from = pm_world_from_scene(world, pm_vec3_make(.5, .5, z));
    pm_ray ray = {from, {0, 0, -1}, INFINITY, PM_NO_PRIMITIVE};
    assert_true(pm_world_intersect(world, &ray, &hit));
    return hit.surface;
}

static pm_selection choose(const pm_world *world, const char *name)
{
    pm_error err = PM_ERROR_INIT;
    pm_selection selection;
    if (pm_selection_make(world, &name, 1, "-ae", &selection, &err))
        fail_msg("%s", err.text);
    return selection;
}

static void assert_chosen(const pm_world *world, const char *name, bool low, bool middle,
                          bool high)
{
    pm_selection s = choose(world, name);
    assert_int_equal(pm_selection_has(&s, world, below(world, .5)), low);
    assert_int_equal(pm_selection_has(&s, world, below(world, 1.5)), middle);
    assert_int_equal(pm_selection_has(&s, world, below(world, 2.5)), high);
    pm_selection_clear(&s);
}

static pm_world *world_of(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    if (compile_text(text, &world, &err))
        fail_msg("%s", err.text);
    return world;
}

/* Two modifiers of equal content are one material, and yet two names. */
static void a_name_in_the_chain_chooses(void **state)
{
    (void)state;
    pm_world *world = world_of(three_walls);
    assert_chosen(world, "red", true, true, false);
    assert_chosen(world, "pane", false, true, false);
    assert_chosen(world, "grey", false, false, true);
    assert_chosen(world, "dirt", false, false, true);
    pm_world_free(world);
}

static void unknown_names_are_refused_with_the_known_ones(void **state)
{
    (void)state;
    pm_world *world = world_of(three_walls);
    const char *names[] = {"red", "window"};
    pm_error err = PM_ERROR_INIT;
    pm_selection s;
    assert_int_equal(pm_selection_make(world, names, 2, "-apo", &s, &err), PM_E_MISSING);
    assert_non_null(strstr(err.text, "-apo"));
    assert_non_null(strstr(err.text, "'window'"));
    assert_non_null(strstr(err.text, "red, pane, grey"));
    pm_world_free(world);
}

/* The digest says what is chosen, not how it is called. */
static void digests_are_by_what_is_chosen(void **state)
{
    (void)state;
    static const char renamed[] =
        "void brightfunc dirt 2 1 . 0 0\n"
        "dirt plastic gris" PLASTIC "void plastic rot" PLASTIC SQUARE("gris", "c", "2")
            SQUARE("rot", "b", "1") SQUARE("rot", "a", "0");
    pm_world *world = world_of(three_walls), *other = world_of(renamed);
    pm_selection red = choose(world, "red"), rot = choose(other, "rot");
    pm_selection pane = choose(world, "pane"), grey = choose(world, "grey");
    pm_selection dirt = choose(other, "dirt");
    assert_true(pm_digest_equal(&red.digest, &rot.digest));
    assert_true(pm_digest_equal(&grey.digest, &dirt.digest));
    assert_false(pm_digest_equal(&red.digest, &pane.digest));
    assert_false(pm_digest_equal(&red.digest, &grey.digest));
    pm_selection_clear(&red);
    pm_selection_clear(&rot);
    pm_selection_clear(&pane);
    pm_selection_clear(&grey);
    pm_selection_clear(&dirt);
    pm_world_free(world);
    pm_world_free(other);
}

/* What an octree holds goes by its own names, unless the instance's modifier replaces them. */
static void surfaces_of_instances_are_chosen(void **state)
{
    (void)state;
    static const char main[] = "void plastic blue" PLASTIC "void instance own 1 tree.oct 0 0\n"
                               "blue instance painted 5 tree.oct -t 0 0 1 0 0\n";
    const struct file tree = {
        "tree", "void plastic red 0 0 5 .1 .1 .1 0 0\n" SQUARE("red", "leaf", "0")};
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    pm_scene *scene = scene_of_files(main, &tree, 1);
    if (pm_world_compile(scene, &world, &err))
        fail_msg("%s", err.text);
    pm_scene_free(scene);
    pm_selection red = choose(world, "red"), blue = choose(world, "blue");
    assert_true(pm_selection_has(&red, world, below(world, .5)));
    assert_false(pm_selection_has(&red, world, below(world, 1.5)));
    assert_false(pm_selection_has(&blue, world, below(world, .5)));
    assert_true(pm_selection_has(&blue, world, below(world, 1.5)));
    assert_false(pm_digest_equal(&red.digest, &blue.digest));
    pm_selection_clear(&red);
    pm_selection_clear(&blue);
    pm_world_free(world);
}

/* As rtrace -osmM prints them. */
static void surfaces_are_called_as_in_the_file(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(three_walls);
    pm_world *world = NULL;
    assert_int_equal(pm_world_compile(scene, &world, NULL), PM_OK);
    pm_surface_names middle = pm_world_surface_names(world, below(world, 1.5));
    assert_string_equal(scene->primitives[middle.primitive].name, "middle");
    assert_string_equal(middle.modifier, "pane");
    assert_string_equal(middle.material, "red");
    pm_surface_names high = pm_world_surface_names(world, below(world, 2.5));
    assert_string_equal(high.modifier, "grey");
    assert_string_equal(high.material, "grey");
    pm_world_free(world);
    pm_scene_free(scene);
}

/* Those of instances come as often as they are placed; too many are refused. */
static void chosen_surfaces_are_listed(void **state)
{
    (void)state;
    static const char main[] =
        "void plastic blue" PLASTIC "void instance own 1 tree.oct 0 0\n"
        "void instance next 5 tree.oct -t 0 0 2 0 0\n"
        "blue instance painted 5 tree.oct -t 0 0 1 0 0\n" SQUARE("blue", "a", "7");
    const struct file tree = {
        "tree", "void plastic red 0 0 5 .1 .1 .1 0 0\n" SQUARE("red", "leaf", "0")};
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    pm_scene *scene = scene_of_files(main, &tree, 1);
    assert_int_equal(pm_world_compile(scene, &world, &err), PM_OK);
    pm_scene_free(scene);
    for (int i = 0; i < 2; i++) {
        pm_selection s = choose(world, i ? "red" : "blue");
        uint32_t *list;
        size_t count;
        assert_int_equal(pm_selection_list(&s, world, 2, &list, &count, &err), PM_OK);
        assert_int_equal(count, 2);
        assert_true(list[0] < list[1]);
        for (size_t k = 0; k < count; k++)
            assert_true(pm_selection_has(&s, world, list[k]));
        free(list);
        assert_int_equal(pm_selection_list(&s, world, 1, &list, &count, NULL), PM_E_LIMIT);
        pm_selection_clear(&s);
    }
    pm_world_free(world);
}

static void no_names_choose_nothing(void **state)
{
    (void)state;
    pm_world *world = world_of(three_walls);
    pm_selection s;
    assert_int_equal(pm_selection_make(world, NULL, 0, "-ae", &s, NULL), PM_OK);
    assert_false(pm_selection_has(&s, world, 0));
    pm_selection_clear(&s);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_name_in_the_chain_chooses),
        cmocka_unit_test(unknown_names_are_refused_with_the_known_ones),
        cmocka_unit_test(digests_are_by_what_is_chosen),
        cmocka_unit_test(surfaces_of_instances_are_chosen),
        cmocka_unit_test(surfaces_are_called_as_in_the_file),
        cmocka_unit_test(chosen_surfaces_are_listed),
        cmocka_unit_test(no_names_choose_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
