/* Estimates at edges: the share of a disc that lies on its surface. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "backward/backward_internal.h"
#include "base/maths.h"

/* A square of edge 1, a wall that stands on its edge x = 0, and a sheet 1e-3 below the other
 * half. */
#define SCENE                                                                                  \
    "void plastic p 0 0 5 .5 .5 .5 0 0\nvoid light l 0 0 3 1 1 1\n"                            \
    "p polygon floor 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n"                                         \
    "p polygon wall 0 0 12 0 0 0 0 1 0 0 1 1 0 0 1\n"                                          \
    "p polygon low 0 0 12 1 0 -.3 2 0 -.3 2 1 -.3 1 1 -.3\n"

static const pm_vec3 up = {0, 0, 1};

/* Mean over N draws and its standard error. */
static void measure(pm_vec3 point, double radius, double *mean, double *error)
{
    enum { N = 20000 };
    pm_world *world = world_of(SCENE);
    pm_world_info info;
    pm_world_info_get(world, &info);
    const struct pm_pass pass = {.world = world};
    const struct pm_spot spot = {.point = pm_world_from_scene(world, point),
                                 .from = PM_NO_PRIMITIVE};
    double sum = 0, square = 0;
    for (uint32_t i = 0; i < N; i++) {
        struct pm_sampler sampler;
        pm_sampler_init(&sampler, 5, 0, i);
        double f =
            pm_boundary_factor(&pass, &spot, up, radius / info.scale, NULL, &sampler.rng);
        sum += f, square += f * f;
    }
    *mean = sum / N;
    *error = sqrt((square / N - *mean * *mean) / N);
    pm_world_free(world);
}

/* 4 standard errors at a fixed seed. */
static void assert_factor(pm_vec3 point, double radius, double want)
{
    double mean, error;
    measure(point, radius, &mean, &error);
    assert_true(error <= .01 * want);
    assert_true(fabs(mean - want) <= 4 * error + 1e-12);
}

static void well_inside_a_surface_the_factor_is_one(void **state)
{
    (void)state;
    double mean, error;
    measure((pm_vec3){.5, .5, 0}, .4, &mean, &error);
    assert_true(mean == 1 && error == 0);
}

/* On an edge half the disc lies on the floor, in a corner a quarter; the wall and the sheet
 * below are other surfaces. */
static void edges_count_half_and_corners_a_quarter(void **state)
{
    (void)state;
    assert_factor((pm_vec3){.5, 0, 0}, .2, 2);
    assert_factor((pm_vec3){1, .5, 0}, .2, 2);
    assert_factor((pm_vec3){0, .5, 0}, .2, 2);
    assert_factor((pm_vec3){1e-9, 1e-9, 0}, .2, 4);
}

/* Half a radius from an edge: the segment of pi / 3 - sqrt(3) / 4 is missing. */
static void a_segment_is_missing_near_an_edge(void **state)
{
    (void)state;
    double segment = PM_PI / 3 - sqrt(3) / 4;
    assert_factor((pm_vec3){.5, .1, 0}, .2, PM_PI / (PM_PI - segment));
    assert_factor((pm_vec3){.1, .5, 0}, .2, PM_PI / (PM_PI - segment));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(well_inside_a_surface_the_factor_is_one),
        cmocka_unit_test(edges_count_half_and_corners_a_quarter),
        cmocka_unit_test(a_segment_is_missing_near_an_edge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
