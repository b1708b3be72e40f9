#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "compile.h"
#include "numbers.h"
#include "world/world_internal.h"

#define GREY "void plastic grey 0 0 5 .5 .5 .5 0 0\nvoid light lamp 0 0 3 1 2 3\n"

/* The place and text of the refusal of a scene whose third line is `surface`. */
static void assert_refused(const char *surface, const char *why)
{
    char text[1024];
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    snprintf(text, sizeof text, GREY " %s\n", surface);
    assert_int_equal(compile_text(text, &world, &err), PM_E_RANGE);
    assert_null(world);
    assert_string_equal(err.file, "test.rad");
    assert_int_equal(err.line, 3);
    assert_int_equal(err.column, 7);
    if (!strstr(err.text, why))
        fail_msg("\"%s\" does not say \"%s\"", err.text, why);
}

static void surfaces_without_extent_are_refused_with_their_place(void **state)
{
    (void)state;
    assert_refused("grey polygon s 0 0 12 0 0 0 2 2 0 2 0 0 0 1 0", "cross");
}

/* The parser lets them pass: it does not know how large the scene is. */
static void surfaces_too_small_beside_the_scene_are_refused(void **state)
{
    (void)state;
#define LARGE "grey sphere large 0 0 4 1e140 0 0 1e140"
    assert_refused("grey sphere s 0 0 4 0 0 0 1e-140 " LARGE, "too small");
    assert_refused("grey ring s 0 0 8 0 0 0 0 0 1 0 1e-140 " LARGE, "too small");
    assert_refused("grey tube s 0 0 7 0 0 0 0 0 1e-250 1e130 " LARGE, "too short");
    assert_refused("grey cone s 0 0 8 0 0 0 1e130 0 0 0 1e-250 " LARGE, "too small");
    assert_refused("grey polygon s 0 0 9 0 0 0 1e100 0 0 0 1e100 0 " LARGE, "no area");
}

static void the_first_bad_surface_of_the_file_is_named(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    struct text t = {0};
    add(&t, GREY);
    for (int i = 0; i < 20; i++)
        add(&t, "grey polygon s%d 0 0 12 0 0 %d 2 %d %d 2 %d %d 0 1 %d\n", i, i, i < 7 ? 0 : 2,
            i, i < 7 ? 2 : 0, i, i);
    assert_int_equal(compile_text(t.data, &world, &err), PM_E_RANGE);
    assert_int_equal(err.line, 3 + 7);
    free(t.data);
}

/* CAD programs write many; Radiance passes over them with a warning. */
static void polygons_without_area_are_not_there(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_world *plain = NULL, *cluttered = NULL;
    static const char floor[] = GREY "grey polygon f 0 0 9 0 0 0 1 0 0 0 1 0\n";
    char text[1024];
    snprintf(text, sizeof text,
             "%sgrey polygon line 0 0 9 0 0 0 1 1 1 2 2 2\n"
             "grey polygon point 0 0 9 0 0 5 0 0 5 0 0 5\n"
             "lamp polygon tenths 0 0 9 .1 .1 .1 .2 .2 .2 .7 .7 .7\n",
             floor);
    assert_int_equal(compile_text(floor, &plain, &err), PM_OK);
    assert_int_equal(compile_text(text, &cluttered, &err), PM_OK);
    const pm_digest a = pm_world_hash(plain), b = pm_world_hash(cluttered);
    assert_true(pm_digest_equal(&a, &b));
    pm_world_free(plain);
    pm_world_free(cluttered);
}

static void a_scene_without_surfaces_is_refused(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    assert_int_equal(compile_text(GREY, &world, &err), PM_E_RANGE);
    assert_non_null(strstr(err.text, "no surface"));
}

static void negative_radii_turn_shapes_inside_out(void **state)
{
    (void)state;
    const char *const pairs[][2] = {
        {"sphere s 0 0 4 0 0 0 -1", "bubble s 0 0 4 0 0 0 1"},
        {"bubble s 0 0 4 0 0 0 -1", "sphere s 0 0 4 0 0 0 1"},
        {"cylinder s 0 0 7 0 0 0 0 0 1 -1", "tube s 0 0 7 0 0 0 0 0 1 1"},
        {"cone s 0 0 8 0 0 0 0 0 1 -1 -.5", "cup s 0 0 8 0 0 0 0 0 1 1 .5"},
        {"cup s 0 0 8 0 0 0 0 0 1 -1 0", "cone s 0 0 8 0 0 0 0 0 1 1 0"},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        char a[256], b[256];
        snprintf(a, sizeof a, GREY "grey %s\n", pairs[i][0]);
        snprintf(b, sizeof b, GREY "grey %s\n", pairs[i][1]);
        pm_world *x = world_of(a), *y = world_of(b);
        assert_int_equal(x->shapes[0].inward, y->shapes[0].inward);
        assert_true(x->shapes[0].r0 == y->shapes[0].r0 && x->shapes[0].r1 == y->shapes[0].r1);
        pm_world_free(x);
        pm_world_free(y);
    }
}

/* The exact bounds; a cube whose edge is a power of two, snapped to a quarter of it. */
static void the_cube_is_snapped_and_does_not_move_with_small_edits(void **state)
{
    (void)state;
    pm_world_info a, b;
    pm_world *world = world_of(GREY "grey sphere s 0 0 4 10 0 0 1\n"
                                    "grey ring r 0 0 8 12 1 0 1 0 0 0 2\n");
    pm_world_info_get(world, &a);
    assert_true(a.low.x == 9 && a.high.x == 12 && a.low.y == -1 && a.high.y == 3);
    assert_true(a.low.z == -2 && a.high.z == 2);
    /* 4 wide, but -1..3 and 9..12 need no more: corner (9, -1, -2), edge 4 */
    assert_true(a.scale == 2);
    assert_true(a.center.x == 11 && a.center.y == 1 && a.center.z == 0);
    pm_world_free(world);
    world = world_of(GREY "grey sphere s 0 0 4 10.01 0 0 .9\n"
                          "grey ring r 0 0 8 12.3 1 0 1 0 0 0 1.95\n");
    pm_world_info_get(world, &b);
    assert_true(b.scale == a.scale && b.center.x == a.center.x && b.center.y == a.center.y &&
                b.center.z == a.center.z);
    pm_world_free(world);
}

static void coordinates_go_there_and_back(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "grey sphere s 0 0 4 1000 2000 3000 1e-3\n");
    pm_vec3 p = {1000.0001, 2000.0002, 2999.9997};
    pm_vec3 q = pm_world_from_scene(world, p);
    assert_true(fabs(q.x) <= 1 && fabs(q.y) <= 1 && fabs(q.z) <= 1);
    assert_at_most(pm_vec3_distance(pm_world_to_scene(world, q), p), 1e-12);
    pm_world_free(world);
}

static void sizes_and_places_beyond_doubles_are_refused(void **state)
{
    (void)state;
    const char *const bad[] = {
        GREY "grey sphere s 0 0 4 0 0 0 1e200\n",
        GREY "grey sphere s 0 0 4 0 0 0 1e-200\n",
        GREY "grey sphere s 0 0 4 1e308 0 0 1\ngrey sphere t 0 0 4 -1e308 0 0 1\n",
        GREY "grey sphere s 0 0 4 1e15 0 0 1\n",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        pm_error err = PM_ERROR_INIT;
        pm_world *world = NULL;
        assert_int_equal(compile_text(bad[i], &world, &err), PM_E_RANGE);
        assert_null(world);
    }
}

static void info_counts_what_is_there(void **state)
{
    (void)state;
    pm_world_info info;
    pm_world *world = world_of(
        GREY "void metal mirr 0 0 5 .9 .9 .9 1 0\nvoid mist fog 0 0 7 .1 .1 .1 .5 .5 .5 0\n"
             "grey sphere a 0 0 4 0 0 0 1\nmirr sphere b 0 0 4 3 0 0 1\n"
             "lamp polygon c 0 0 12 0 0 5 2 0 5 2 3 5 0 3 5\nfog sphere d 0 0 4 0 0 0 9\n"
             "lamp source e 0 0 4 0 0 1 .5\n");
    pm_world_info_get(world, &info);
    assert_int_equal(info.surfaces, 4);
    assert_int_equal(info.lights, 2);
    assert_int_equal(info.specular_surfaces, 1);
    assert_int_equal(info.diffuse_surfaces, 1);
    assert_int_equal(info.mist_surfaces, 1);
    assert_true(info.octree_nodes >= 1);
    pm_world_free(world);

    world = world_of(GREY "lamp polygon c 0 0 12 0 0 5 2 0 5 2 3 5 0 3 5\n");
    pm_world_info_get(world, &info);
    assert_near(info.power.g, 2 * 6 * PM_PI, 1e-13);
    pm_world_free(world);
}

static void a_scene_of_sources_alone_has_a_world(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "lamp source e 0 0 4 0 3e100 4e100 90\n");
    pm_world_info info;
    pm_world_info_get(world, &info);
    assert_true(info.scale == 1 && info.surfaces == 0 && info.lights == 1);
    assert_int_equal(world->distant_count, 1);
    assert_near(world->distants[0].direction.z, .8, 1e-15);
    assert_near(world->distants[0].half_angle, PM_PI / 4, 1e-15);
    assert_near(world->distants[0].versine, 1 - sqrt(.5), 1e-15);
    pm_ray ray = {{0, 0, 0}, {0, 0, 1}, INFINITY, PM_NO_PRIMITIVE};
    pm_hit hit;
    assert_false(pm_world_intersect(world, &ray, &hit));
    pm_world_free(world);
}

/* Equal materials are one, and what equal hashes share is in the same place. */
static void equal_scenes_have_equal_tables(void **state)
{
    (void)state;
    pm_world *a =
        world_of("void plastic p 0 0 5 .1 .2 .3 0 0\nvoid metal m 0 0 5 .4 .5 .6 0 0\n"
                 "p sphere s 0 0 4 0 0 0 1\nm sphere t 0 0 4 3 0 0 1\n");
    pm_world *b =
        world_of("void metal m 0 0 5 .4 .5 .6 0 0\nvoid plastic p 0 0 5 .1 .2 .3 0 0\n"
                 "void plastic q 0 0 5 .1 .2 .3 0 0\n"
                 "m sphere t 0 0 4 3 0 0 1\nq sphere s 0 0 4 0 0 0 1\n");
    assert_int_equal(a->material_count, 2);
    assert_int_equal(b->material_count, 2);
    for (uint32_t i = 0; i < 2; i++) {
        assert_true(
            pm_digest_equal(pm_world_surface_digest(a, i), pm_world_surface_digest(b, i)));
        assert_int_equal(a->shapes[i].material, b->shapes[i].material);
        assert_true(a->shapes[i].center.x == b->shapes[i].center.x);
    }
    pm_world_free(a);
    pm_world_free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_without_extent_are_refused_with_their_place),
        cmocka_unit_test(surfaces_too_small_beside_the_scene_are_refused),
        cmocka_unit_test(the_first_bad_surface_of_the_file_is_named),
        cmocka_unit_test(polygons_without_area_are_not_there),
        cmocka_unit_test(a_scene_without_surfaces_is_refused),
        cmocka_unit_test(negative_radii_turn_shapes_inside_out),
        cmocka_unit_test(the_cube_is_snapped_and_does_not_move_with_small_edits),
        cmocka_unit_test(coordinates_go_there_and_back),
        cmocka_unit_test(sizes_and_places_beyond_doubles_are_refused),
        cmocka_unit_test(info_counts_what_is_there),
        cmocka_unit_test(a_scene_of_sources_alone_has_a_world),
        cmocka_unit_test(equal_scenes_have_equal_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
