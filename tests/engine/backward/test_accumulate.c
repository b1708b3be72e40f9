/* Passes and their sums. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "eye.h"

#define ROOM                                                                                   \
    "void light lamp 0 0 3 10 10 10\nlamp sphere ball 0 0 4 0 0 .5 .1\n"                       \
    "void dielectric clear 0 0 5 1 1 1 1.5 0\nclear sphere glass 0 0 4 .3 0 -.5 .3\n"          \
    "void plastic gloss 0 0 5 .5 .4 .3 .1 .1\n" TEST_BOX("gloss")

static const pm_view view = {.point = {0, -.9, 0},
                             .direction = {0, 1, 0},
                             .up = {0, 0, 1},
                             .horizontal = 80,
                             .vertical = 60};

static pm_accumulation *picture_of(const pm_world *world, uint32_t width, uint32_t height)
{
    pm_accumulation *accumulation = NULL;
    assert_int_equal(
        pm_accumulation_for_picture(world, &view, width, height, 7, &accumulation, NULL),
        PM_OK);
    return accumulation;
}

/* Means and half-widths after three passes, [2][count][3]. */
static float *render(const pm_world *world, const pm_backward_maps *maps, unsigned threads)
{
    pm_accumulation *accumulation = picture_of(world, 37, 23);
    pm_pool *pool = pm_pool_new(threads);
    size_t values = 3 * pm_accumulation_count(accumulation);
    float *out = malloc(2 * values * sizeof *out);
    for (uint32_t pass = 0; pass < 3; pass++)
        assert_int_equal(pm_backward_pass(accumulation, pass, maps, pool, NULL, NULL, NULL),
                         PM_OK);
    pm_accumulation_mean(accumulation, out);
    pm_accumulation_half_width(accumulation, out + values);
    pm_pool_free(pool);
    pm_accumulation_free(accumulation);
    return out;
}

static void values_are_the_same_bytes_for_1_2_and_7_threads(void **state)
{
    (void)state;
    pm_world *world = world_of(ROOM);
    pm_photon_map *global = map_of(world, PM_MAP_GLOBAL, 0, 1);
    pm_photon_map *caustic = map_of(world, PM_MAP_CAUSTIC, 0, 1);
    pm_backward_maps maps = {
        .map = {global, caustic}, .gather_count = {50, 50}, .ambient_bounces = 1};
    size_t size = (size_t)2 * 37 * 23 * 3 * sizeof(float);
    float *one = render(world, &maps, 1);
    float *two = render(world, &maps, 2);
    float *seven = render(world, &maps, 7);
    assert_memory_equal(one, two, size);
    assert_memory_equal(one, seven, size);
    free(one);
    free(two);
    free(seven);
    pm_photon_map_free(global);
    pm_photon_map_free(caustic);
    pm_world_free(world);
}

static bool stop_at_second_question(void *context)
{
    return ++*(int *)context > 1;
}

/* 400 tiles are two rounds of work: the pass is stopped between them. */
static void cancelled_pass_leaves_the_sums(void **state)
{
    (void)state;
    pm_world *world = world_of(ROOM);
    pm_accumulation *accumulation = picture_of(world, 320, 320);
    pm_pool *pool = pm_pool_new(2);
    size_t values = 3 * pm_accumulation_count(accumulation);
    float *before = malloc(values * sizeof *before), *after = malloc(values * sizeof *after);
    int questions = 0;
    assert_int_equal(pm_backward_pass(accumulation, 0, &no_maps, pool, NULL, NULL, NULL),
                     PM_OK);
    pm_accumulation_mean(accumulation, before);
    assert_int_equal(pm_backward_pass(accumulation, 1, &no_maps, pool, stop_at_second_question,
                                      &questions, NULL),
                     PM_E_CANCELLED);
    pm_accumulation_mean(accumulation, after);
    assert_int_equal(pm_accumulation_passes(accumulation), 1);
    assert_memory_equal(before, after, values * sizeof *before);
    assert_int_equal(pm_backward_pass(accumulation, 1, &no_maps, pool, NULL, NULL, NULL),
                     PM_OK);
    free(before);
    free(after);
    pm_pool_free(pool);
    pm_accumulation_free(accumulation);
    pm_world_free(world);
}

static void passes_ascend(void **state)
{
    (void)state;
    pm_world *world = world_of(ROOM);
    pm_accumulation *accumulation = picture_of(world, 2, 2);
    pm_pool *pool = pm_pool_new(1);
    static const struct {
        uint32_t pass;
        pm_status status;
    } calls[] = {{3, PM_OK}, {3, PM_E_RANGE}, {1, PM_E_RANGE}, {9, PM_OK}};
    for (int i = 0; i < 4; i++)
        assert_int_equal(
            pm_backward_pass(accumulation, calls[i].pass, &no_maps, pool, NULL, NULL, NULL),
            calls[i].status);
    assert_int_equal(pm_accumulation_passes(accumulation), 2);
    pm_pool_free(pool);
    pm_accumulation_free(accumulation);
    pm_world_free(world);
}

/* Passes 0..7 at once equal 0..3 and then 4..7. */
static void passes_continue_where_they_stopped(void **state)
{
    (void)state;
    pm_world *world = world_of(ROOM);
    pm_accumulation *a = picture_of(world, 5, 5), *b = picture_of(world, 5, 5);
    float x[75], y[75];
    run_passes(a, &no_maps, 8);
    run_passes(b, &no_maps, 4);
    run_passes(b, &no_maps, 4);
    pm_accumulation_mean(a, x);
    pm_accumulation_mean(b, y);
    assert_memory_equal(x, y, sizeof x);
    pm_accumulation_free(a);
    pm_accumulation_free(b);
    pm_world_free(world);
}

static void error_is_unknown_until_two_passes_and_falls_with_more(void **state)
{
    (void)state;
    pm_world *world = world_of(ROOM);
    pm_accumulation *accumulation = picture_of(world, 24, 24);
    assert_true(pm_accumulation_error(accumulation) == INFINITY);
    run_passes(accumulation, &no_maps, 1);
    assert_true(pm_accumulation_error(accumulation) == INFINITY);
    run_passes(accumulation, &no_maps, 15);
    double early = pm_accumulation_error(accumulation);
    run_passes(accumulation, &no_maps, 16 * 15);
    double late = pm_accumulation_error(accumulation);
    /* 16 times the passes: a quarter of the error, or less where Sobol points help */
    assert_true(late > 0 && early < INFINITY);
    assert_true(late < early / 4 * 1.5);
    pm_accumulation_free(accumulation);
    pm_world_free(world);
}

/* The lamp lights another place: what was never lit gets a bound from the values that were. */
static void dark_values_have_a_bound_that_is_not_0(void **state)
{
    (void)state;
    pm_world *world =
        world_of("void light lamp 0 0 3 10 10 10\nlamp sphere ball 0 0 4 0 0 2 .1\n");
    const pm_sensor sensors[2] = {{{0, 0, 0}, {0, 0, 1}}, {{0, 0, 0}, {0, 0, -1}}};
    pm_accumulation *accumulation = NULL;
    float mean[6], half[6];
    assert_int_equal(
        pm_accumulation_for_sensors(world, sensors, 2, PM_IRRADIANCE, 0, &accumulation, NULL),
        PM_OK);
    run_passes(accumulation, &no_maps, 30);
    pm_accumulation_mean(accumulation, mean);
    pm_accumulation_half_width(accumulation, half);
    assert_true(mean[0] > 0 && mean[3] == 0);
    assert_true(fabsf(half[3] - mean[0] / 10) < 1e-6F * mean[0]);
    pm_accumulation_free(accumulation);
    pm_world_free(world);
}

static void scene_without_lights_is_known_to_be_dark(void **state)
{
    (void)state;
    pm_world *world = world_of("void plastic grey 0 0 5 .5 .5 .5 0 0\n" TEST_BOX("grey"));
    pm_accumulation *accumulation = picture_of(world, 2, 1);
    float half[6];
    run_passes(accumulation, &no_maps, 2);
    assert_true(pm_accumulation_error(accumulation) == 0);
    pm_accumulation_half_width(accumulation, half);
    for (int i = 0; i < 6; i++)
        assert_true(half[i] == 0);
    pm_accumulation_free(accumulation);
    pm_world_free(world);
}

static void impossible_requests_are_refused(void **state)
{
    (void)state;
    pm_world *world = world_of(ROOM);
    pm_accumulation *accumulation = NULL;
    const pm_sensor zero = {{0, 0, 0}, {0, 0, 0}}, nan = {{0, (double)NAN, 0}, {0, 0, 1}};
    pm_view flat = view;
    flat.vertical = 0;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(
        pm_accumulation_for_sensors(world, &zero, 1, PM_RADIANCE, 0, &accumulation, &err),
        PM_E_RANGE);
    assert_non_null(strstr(err.text, "sensor 1"));
    assert_int_equal(
        pm_accumulation_for_sensors(world, &nan, 1, PM_RADIANCE, 0, &accumulation, NULL),
        PM_E_RANGE);
    assert_int_equal(
        pm_accumulation_for_sensors(world, &zero, 0, PM_RADIANCE, 0, &accumulation, NULL),
        PM_E_RANGE);
    assert_int_equal(pm_accumulation_for_picture(world, &flat, 8, 8, 0, &accumulation, NULL),
                     PM_E_RANGE);
    assert_int_equal(pm_accumulation_for_picture(world, &view, 8, 0, 0, &accumulation, NULL),
                     PM_E_RANGE);
    assert_int_equal(
        pm_accumulation_for_picture(world, &view, 65535, 65535, 0, &accumulation, NULL),
        PM_E_LIMIT);
    assert_int_equal(
        pm_accumulation_for_picture(world, &view, 16384, 16384, 0, &accumulation, NULL),
        PM_E_LIMIT);
    assert_null(accumulation);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_the_same_bytes_for_1_2_and_7_threads),
        cmocka_unit_test(cancelled_pass_leaves_the_sums),
        cmocka_unit_test(passes_ascend),
        cmocka_unit_test(passes_continue_where_they_stopped),
        cmocka_unit_test(error_is_unknown_until_two_passes_and_falls_with_more),
        cmocka_unit_test(dark_values_have_a_bound_that_is_not_0),
        cmocka_unit_test(scene_without_lights_is_known_to_be_dark),
        cmocka_unit_test(impossible_requests_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
