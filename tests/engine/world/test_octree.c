#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compile.h"
#include "numbers.h"

static pm_digest hash_of_scene(const pm_scene *scene, size_t *nodes)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    if (pm_world_compile(scene, &world, &err))
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    pm_digest hash = pm_world_hash(world);
    if (nodes) {
        pm_world_info info;
        pm_world_info_get(world, &info);
        *nodes = info.octree_nodes;
    }
    pm_world_free(world);
    return hash;
}

static pm_digest hash_of(const char *text)
{
    pm_scene *scene = scene_of(text);
    pm_digest hash = hash_of_scene(scene, NULL);
    pm_scene_free(scene);
    return hash;
}

static void assert_same(const char *a, const char *b)
{
    pm_digest x = hash_of(a), y = hash_of(b);
    assert_memory_equal(x.bytes, y.bytes, sizeof x.bytes);
}

static void assert_differ(const char *a, const char *b)
{
    pm_digest x = hash_of(a), y = hash_of(b);
    assert_memory_not_equal(x.bytes, y.bytes, sizeof x.bytes);
}

static void digest_ignores_white_space_comments_order_names_and_unused_modifiers(void **state)
{
    (void)state;
    const char *scene = "void plastic red 0 0 5 .7 0 0 0 0\n"
                        "void light lamp 0 0 3 1 1 1\n"
                        "red polygon floor 0 0 9 0 0 0 1 0 0 1 1 0\n"
                        "lamp sphere bulb 0 0 4 0 0 2 .1\n"
                        "lamp source sun 0 0 4 0 0 1 .5\n"
                        "lamp source sun2 0 0 4 0 1 1 .5\n";
    const char *other = "# another author\n"
                        "void   light\tlamp2 0\n0\n3 1 1.0 1e0 # watts\n"
                        "void glass unused 0 0 3 .9 .9 .9\n"
                        "lamp2 source south 0 0 4 -0 0 1 .5\n"
                        "lamp2 source north 0 0 4 0 1 1 .5\n"
                        "void plastic paint 0 0 5 .70 0 0 0 0\n"
                        "void alias same paint\n"
                        "lamp2 sphere pear 0 0 4 0 0 2 0.1\n"
                        "same polygon ground 0 0 9 -0 0 0 1 0 0 1 1 0\n";
    assert_same(scene, other);
}

/* A scene in which every number and every name of a material counts. */
static const char rich[] = "void plastic p 0 0 5 .7 .6 .5 .1 .2\n"
                           "void metal m 0 0 5 .7 .6 .5 .1 .2\n"
                           "void trans t 0 0 7 .7 .6 .5 .1 .2 .3 .4\n"
                           "void glass g 0 0 4 .9 .8 .7 1.5\n"
                           "void dielectric d 0 0 5 .9 .8 .7 1.5 .01\n"
                           "void mirror r 1 p 0 3 .9 .8 .7\n"
                           "void light l 0 0 3 1 2 3\n"
                           "void spotlight s 0 0 7 1 2 3 30 0 0 -1\n"
                           "void illum i 1 g 0 3 1 2 3\n"
                           "void glow w 0 0 4 1 2 3 -1\n"
                           "void mist f 0 0 7 .1 .2 .3 .4 .5 .6 .7\n"
                           "void antimatter a 2 p m 0 0\n"
                           "p polygon s1 0 0 9 0 0 0 1 0 0 1 1 0\n"
                           "m sphere s2 0 0 4 3 1 2 .1\n"
                           "t bubble s3 0 0 4 3 2 2 .1\n"
                           "g ring s4 0 0 8 3 3 2 .1 .2 .9 .1 .2\n"
                           "d cone s5 0 0 8 3 4 2 3.1 4.2 2.3 .1 .2\n"
                           "r cup s6 0 0 8 3 5 2 3.1 5.2 2.3 .1 .2\n"
                           "l cylinder s7 0 0 7 3 6 2 3.1 6.2 2.3 .1\n"
                           "s tube s8 0 0 7 3 7 2 3.1 7.2 2.3 .1\n"
                           "i polygon s9 0 0 12 0 0 1 1 0 1 1 1 1 0 1 1\n"
                           "w source s10 0 0 4 .1 .2 1 5\n"
                           "f sphere s11 0 0 4 3 1 5 .1\n"
                           "a sphere s12 0 0 4 3 2 5 .1\n";

static void digest_changes_with_every_light_relevant_argument(void **state)
{
    (void)state;
    pm_scene *scene = scene_of(rich);
    pm_digest first = hash_of_scene(scene, NULL);
    for (size_t i = 0; i < scene->count; i++) {
        const pm_primitive *p = &scene->primitives[i];
        double *reals = (double *)(uintptr_t)p->reals;
        for (uint32_t k = 0; k < p->real_count; k++) {
            double kept = reals[k];
            reals[k] = kept + fmax(fabs(kept), 1) * 0x1p-40;
            pm_digest changed = hash_of_scene(scene, NULL);
            assert_memory_not_equal(first.bytes, changed.bytes, sizeof first.bytes);
            reals[k] = kept;
        }
    }
    pm_digest again = hash_of_scene(scene, NULL);
    assert_memory_equal(first.bytes, again.bytes, sizeof first.bytes);
    pm_scene_free(scene);
}

static void digest_changes_with_types_modifiers_and_references(void **state)
{
    (void)state;
#define PAINTS "void plastic a 0 0 5 .5 .5 .5 0 0\nvoid plastic b 0 0 5 .4 .5 .5 0 0\n"
    const char *scene = PAINTS "void illum i 1 a 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n";
    assert_differ(scene, PAINTS "void illum i 1 b 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n");
    assert_differ(scene, PAINTS "void illum i 0 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n");
    assert_differ(scene, PAINTS "void light i 0 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n");
    assert_differ(scene, PAINTS "void illum i 1 a 0 3 1 1 1\ni bubble s 0 0 4 0 0 0 1\n");
    assert_differ(scene, PAINTS "void illum i 1 a 0 3 1 1 1\na sphere s 0 0 4 0 0 0 1\n");
    const char *mirror = PAINTS "void mirror i 1 a 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n";
    assert_differ(mirror, PAINTS "void mirror i 1 b 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n");
    assert_differ(mirror, PAINTS "void mirror i 0 0 3 1 1 1\ni sphere s 0 0 4 0 0 0 1\n");
}

/* Of two equal materials antimatter may list one: which surfaces have that one counts, though
 * their names do not. */
static void digest_tells_which_of_two_equal_materials_antimatter_lists(void **state)
{
    (void)state;
#define TWO                                                                                    \
    "void plastic a 0 0 5 .5 .5 .5 0 0\nvoid plastic b 0 0 5 .5 .5 .5 0 0\n"                   \
    "void antimatter c 1 %s 0 0\nc sphere cut 0 0 4 .5 0 0 1\n"                                \
    "%s sphere s 0 0 4 0 0 0 1\n%s sphere t 0 0 4 3 0 0 1\n"
    char cut_s[512], cut_t[512], renamed[512];
    snprintf(cut_s, sizeof cut_s, TWO, "a", "a", "b");
    snprintf(cut_t, sizeof cut_t, TWO, "b", "a", "b");
    snprintf(renamed, sizeof renamed, TWO, "b", "b", "a");
    assert_differ(cut_s, cut_t);
    assert_same(cut_s, renamed);
}

static void digest_changes_with_added_removed_and_repeated_surfaces(void **state)
{
    (void)state;
#define BALLS                                                                                  \
    "void plastic a 0 0 5 .5 .5 .5 0 0\na sphere s 0 0 4 0 0 0 1\na sphere t 0 0 4 2 2 2 1\n"
    assert_differ(BALLS, BALLS "a sphere u 0 0 4 1 1 1 .1\n");
    assert_differ(BALLS, BALLS "a sphere t 0 0 4 2 2 2 1\n");
    assert_differ(BALLS, BALLS "void light b 0 0 3 1 1 1\nb source u 0 0 4 1 1 1 1\n");
}

/* Five balls in each of eight far corners: the top holds 40 surfaces and is cut once. */
static void cubes_with_more_than_thirty_two_surfaces_are_cut(void **state)
{
    (void)state;
    struct text t = {0};
    size_t nodes;
    add(&t, "void plastic a 0 0 5 .5 .5 .5 0 0\n");
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 5; k++)
            add(&t, "a sphere s 0 0 4 %g %g %g .0625\n", (i & 1) * 10 + 1.0,
                (i >> 1 & 1) * 10 + 1., (i >> 2) * 10 + 1 + .25 * k);
    pm_scene *scene = scene_of(t.data);
    hash_of_scene(scene, &nodes);
    assert_int_equal(nodes, 9);
    pm_scene_free(scene);
    free(t.data);
}

/* Forty coincident polygons can never be parted, and a hundred that cross each other hardly.
 * Each cut adds eight nodes and 33 entries at least, of 1024 for each surface. */
static void surfaces_that_cannot_be_parted_do_not_cut_for_ever(void **state)
{
    (void)state;
    struct text same = {0}, crossing = {0};
    pm_rng rng;
    size_t nodes;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    add(&same, "void plastic a 0 0 5 .5 .5 .5 0 0\n");
    add(&crossing, "void plastic a 0 0 5 .5 .5 .5 0 0\n");
    for (int i = 0; i < 40; i++)
        add(&same, "a polygon s 0 0 12 0 0 .3 1 0 .3 1 1 .3 0 1 .3\n");
    for (int i = 0; i < 100; i++) {
        add(&crossing, "a polygon s 0 0 9");
        for (int k = 0; k < 9; k++)
            add(&crossing, " %.9g", pm_rng_uniform(&rng));
        add(&crossing, "\n");
    }
    pm_scene *scene = scene_of(same.data);
    hash_of_scene(scene, &nodes);
    assert_in_range(nodes, 9, 1 + 8 * 1024 * 40 / 33);
    pm_scene_free(scene);
    scene = scene_of(crossing.data);
    hash_of_scene(scene, &nodes);
    assert_in_range(nodes, 9, 1 + 8 * 1024 * 100 / 33);
    pm_scene_free(scene);
    free(same.data);
    free(crossing.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(digest_ignores_white_space_comments_order_names_and_unused_modifiers),
        cmocka_unit_test(digest_changes_with_every_light_relevant_argument),
        cmocka_unit_test(digest_changes_with_types_modifiers_and_references),
        cmocka_unit_test(digest_tells_which_of_two_equal_materials_antimatter_lists),
        cmocka_unit_test(digest_changes_with_added_removed_and_repeated_surfaces),
        cmocka_unit_test(cubes_with_more_than_thirty_two_surfaces_are_cut),
        cmocka_unit_test(surfaces_that_cannot_be_parted_do_not_cut_for_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
