/* The specular chain: what the eye sees through mirrors, panes, slabs and rough gloss. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/maths.h"
#include "base/warp.h"
#include "eye.h"
#include "world/surface.h"

/* Up at 45 degrees to a mirror overhead, down to one below, up to the lamp: .9 * .8 * 10. */
static void mirrors_multiply_their_reflectances(void **state)
{
    (void)state;
    pm_world *world = world_of("void mirror m9 0 0 3 .9 .9 0\nvoid mirror m8 0 0 3 .8 .4 1\n"
                               "m9 polygon over 0 0 12  0 -1 1  0 1 1  2 1 1  2 -1 1\n"
                               "m8 polygon under 0 0 12  1 -1 0  3 -1 0  3 1 0  1 1 0\n"
                               "void light lamp 0 0 3 10 10 10\n"
                               "lamp polygon l 0 0 12  4 -1 0  4 -1 3  4 1 3  4 1 0\n");
    pm_sensor sensor = {{0, 0, 0}, {1, 0, 1}};
    struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 4);
    assert_true(fabs(m.value[0] - 7.2) < 1e-5);
    assert_true(fabs(m.value[1] - 3.6) < 1e-5);
    assert_true(m.value[2] == 0);
    pm_world_free(world);
}

/* Radiance's thin glass, as in test_direct.c; reflection and passage are drawn, so the answer
 * scatters: passage has the chance T / (T + R). */
static void pane_shows_the_lamp_behind_it_dimmed(void **state)
{
    (void)state;
    pm_world *world = world_of("void glass pane 0 0 3 .9 .9 .9\n"
                               "pane ring window 0 0 8  0 0 1  0 0 1  0 4\n"
                               "void light lamp 0 0 3 10 10 10\n"
                               "lamp ring l 0 0 8  0 0 2  0 0 -1  0 4\n");
    pm_sensor sensor = {{0, 0, 0}, {0, 0, 1}};
    struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 4096);
    double r = pow(.52 / 2.52, 2);
    assert_measured(&m, 0, 10 * (1 - r) * (1 - r) * .9 / (1 - r * r * .81), .05);
    pm_world_free(world);
}

/* A slab of index 1.5 with all internal reflections passes (1 - r) / (1 + r), r = .04. */
static void slab_passes_light_with_all_internal_reflections(void **state)
{
    (void)state;
    pm_world *world = world_of("void dielectric clear 0 0 5 1 1 1 1.5 0\n"
                               "clear ring near 0 0 8  0 0 1  0 0 -1  0 4\n"
                               "clear ring far 0 0 8  0 0 1.5  0 0 1  0 4\n"
                               "void light lamp 0 0 3 10 10 10\n"
                               "lamp ring l 0 0 8  0 0 2  0 0 -1  0 4\n");
    pm_sensor sensor = {{0, 0, 0}, {0, 0, 1}};
    struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 4096);
    assert_measured(&m, 0, 10 * .96 / 1.04, .05);
    pm_world_free(world);
}

/* Water is a single surface, .5 of the light left a unit: from 2 below a lamp of 10 shows as
 * 10 (1 - r) n^2 .5^2, r = .04, n = 1.5; the surface is too narrow for the slanting ways by
 * which pm_media_at looks for it. */
static void water_under_one_surface_dims_what_is_seen_from_within(void **state)
{
    (void)state;
    pm_world *world = world_of("void dielectric water 0 0 5 .5 .5 .5 1.5 0\n"
                               "water ring surface 0 0 8  0 0 2  0 0 1  0 .1\n"
                               "void light lamp 0 0 3 10 10 10\n"
                               "lamp ring l 0 0 8  0 0 3  0 0 -1  0 4\n");
    pm_sensor sensor = {{0, 0, 0}, {0, 0, 1}};
    struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 4096);
    assert_measured(&m, 0, 10 * .96 * 2.25 * .25, .05);
    pm_world_free(world);
}

/* Between perfect mirrors a walk ends by roulette alone; from a dark hall comes nothing. */
static void perfect_hall_of_mirrors_ends(void **state)
{
    (void)state;
    pm_world *world = world_of("void metal perfect 0 0 5 1 1 1 1 0\n" TEST_BOX("perfect"));
    pm_sensor sensor = {{.1, .2, .3}, {1, .3, .2}};
    struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 256);
    for (int c = 0; c < 3; c++)
        assert_true(m.value[c] == 0);
    pm_world_free(world);
}

/* A walk with slope 40 between mirrors 2 apart is reflected 20 times, at heights 1, 3 .. 39 of
 * its unfolded way, before it comes to the lamp at x = 1. */
static void roulette_keeps_the_mean(void **state)
{
    (void)state;
    pm_world *world = world_of("void metal m 0 0 5 .9 .9 .9 1 0\n"
                               "m polygon a 0 0 12 -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1\n"
                               "m polygon b 0 0 12 -1 -1 1  -1 1 1  1 1 1  1 -1 1\n"
                               "void light lamp 0 0 3 1 1 1\n"
                               "lamp polygon l 0 0 12  1 -1 -1  1 -1 1  1 1 1  1 1 -1\n");
    pm_sensor sensor = {{0, 0, 0}, {1, 0, 40}};
    struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 65536);
    assert_measured(&m, 0, pow(.9, 20), .1);
    pm_world_free(world);
}

/* ---- gloss ---- */

/* Radiance of a rough surface at the origin under a disc, by the midpoint rule over the disc:
 * the integral of f cos L over its solid angle. */
static double gloss_by_quadrature(const pm_world *world, pm_vec3 wo, double radius)
{
    enum { RINGS = 800, SPOKES = 800 };
    pm_ray ray = {.origin = pm_world_from_scene(world, pm_vec3_scale(wo, .1)),
                  .direction = pm_vec3_negate(wo),
                  .t_max = INFINITY,
                  .from = PM_NO_PRIMITIVE};
    pm_hit hit;
    pm_media none = {.count = 0};
    pm_surface surface;
    assert_true(pm_world_intersect(world, &ray, &hit));
    pm_surface_at(world, &hit, wo, &none, &surface);
    double sum = 0;
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < SPOKES; j++) {
            double r = radius * (i + .5) / RINGS, phi = 2 * PM_PI * (j + .5) / SPOKES;
            pm_vec3 to = {r * pm_cos(phi), r * pm_sin(phi), 1};
            double square = pm_vec3_dot(to, to);
            pm_vec3 wi = pm_vec3_normalize(to);
            double solid = r * radius / RINGS * 2 * PM_PI / SPOKES * wi.z / square;
            sum += pm_surface_value(&surface, PM_EVENT_GLOSSY, wi).r * solid;
        }
    return sum;
}

/* Multiple importance sampling adds up to the integral for sharp and blunt lobes under small
 * and large lamps, seen from above and from aside. Quadrature is off by (lobe width / step)^2 /
 * 24 < 1e-4. */
static void gloss_under_a_lamp_equals_quadrature(void **state)
{
    (void)state;
    static const double roughnesses[] = {.05, .2}, radii[] = {.05, .5, 3};
    static const pm_vec3 eyes[] = {{0, 0, 1}, {.6, 0, .8}};
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 2; k++) {
                char text[400];
                snprintf(text, sizeof text,
                         "void plastic gloss 0 0 5 0 0 0 .5 %g\n"
                         "gloss ring plate 0 0 8  0 0 0  0 0 1  0 .2\n"
                         "void light lamp 0 0 3 1 1 1\n"
                         "lamp ring disc 0 0 8  0 0 1  0 0 -1  0 %g\n",
                         roughnesses[i], radii[j]);
                pm_world *world = world_of(text);
                pm_vec3 wo = eyes[k];
                /* the eye stands just over the plate, below the lamp */
                pm_sensor sensor = {pm_vec3_scale(wo, .1), pm_vec3_negate(wo)};
                double want = gloss_by_quadrature(world, wo, radii[j]);
                struct measured m = sense(world, &no_maps, PM_RADIANCE, sensor, 8192);
                if (want > 1e-3)
                    assert_measured(&m, 0, want, .2);
                pm_world_free(world);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mirrors_multiply_their_reflectances),
        cmocka_unit_test(pane_shows_the_lamp_behind_it_dimmed),
        cmocka_unit_test(slab_passes_light_with_all_internal_reflections),
        cmocka_unit_test(water_under_one_surface_dims_what_is_seen_from_within),
        cmocka_unit_test(perfect_hall_of_mirrors_ends),
        cmocka_unit_test(roulette_keeps_the_mean),
        cmocka_unit_test(gloss_under_a_lamp_equals_quadrature),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
