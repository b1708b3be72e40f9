/* Next event: irradiance of lamps against closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/maths.h"
#include "eye.h"

#define DISC "void light lamp 0 0 3 10 5 0\nlamp ring disc 0 0 8  0 0 2  0 0 -1  0 .5\n"

static const pm_sensor facing_up = {{0, 0, 0}, {0, 0, 7}};

/* A disc of radius R at height h over a parallel receiver: E = pi L R^2 / (R^2 + h^2). */
static void disc_light_gives_the_analytic_irradiance(void **state)
{
    (void)state;
    pm_world *world = world_of(DISC);
    struct measured m = sense(world, &no_maps, PM_IRRADIANCE, facing_up, 512);
    double share = PM_PI * .25 / (.25 + 4);
    assert_measured(&m, 0, 10 * share, .01);
    assert_measured(&m, 1, 5 * share, .01);
    assert_true(m.value[2] == 0);
    pm_world_free(world);
}

/* A small sphere of radius r at distance d is L pi r^2 / d^2 cos(theta), exactly, while all of
 * it stands over the receiver's horizon. */
static void irradiance_falls_with_the_square_and_the_cosine(void **state)
{
    (void)state;
    pm_world *world = world_of("void light lamp 0 0 3 100 100 100\n"
                               "lamp sphere ball 0 0 4 0 0 0 .1\n");
    static const double distances[] = {.5, 1, 2, 8};
    static const double angles[] = {0, 30, 60, 75};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double d = distances[i], theta = angles[j] * PM_PI / 180;
            pm_sensor sensor = {{0, 0, d}, {pm_sin(theta), 0, -pm_cos(theta)}};
            struct measured m = sense(world, &no_maps, PM_IRRADIANCE, sensor, 256);
            assert_measured(&m, 0, 100 * PM_PI * .01 / (d * d) * pm_cos(theta), .03);
        }
    pm_world_free(world);
}

/* Half of the sky (a source of 180 degrees overhead) of radiance 1: pi; tilted by theta, the
 * share (1 + cos theta) / 2 of it. */
static void even_sky_gives_pi_times_the_part_in_view(void **state)
{
    (void)state;
    pm_world *world = world_of("void glow sky 0 0 4 1 1 1 0\nsky source up 0 0 4 0 0 1 180\n"
                               "void plastic floor 0 0 5 0 0 0 0 0\n"
                               "floor sphere far 0 0 4 0 0 -50 1\n");
    for (int i = 0; i < 4; i++) {
        double theta = i * 30 * PM_PI / 180;
        pm_sensor sensor = {{0, 0, 0}, {pm_sin(theta), 0, pm_cos(theta)}};
        struct measured m = sense(world, &no_maps, PM_IRRADIANCE, sensor, 1024);
        assert_measured(&m, 0, PM_PI * (1 + pm_cos(theta)) / 2, .05);
    }
    pm_world_free(world);
}

/* A pane of transmissivity t between: Radiance's thin glass at normal incidence passes
 * (1 - r)^2 t / (1 - r^2 t^2) with r = ((1 - n) / (1 + n))^2, n = 1.52. The lamp is so small
 * and far that incidence is normal to 1e-4 rad. */
static void next_event_passes_straight_through_glass(void **state)
{
    (void)state;
    pm_world *world = world_of("void light lamp 0 0 3 1e6 1e6 1e6\n"
                               "lamp sphere ball 0 0 4 0 0 10 .001\n"
                               "void glass pane 0 0 3 .9 .5 0\n"
                               "pane ring window 0 0 8  0 0 5  0 0 1  0 4\n");
    struct measured m = sense(world, &no_maps, PM_IRRADIANCE, facing_up, 64);
    double r = pow(.52 / 2.52, 2), bare = 1e6 * PM_PI * 1e-6 / 100;
    const double t[2] = {.9, .5};
    for (int c = 0; c < 2; c++) {
        double passed = (1 - r) * (1 - r) * t[c] / (1 - r * r * t[c] * t[c]);
        assert_true(fabs(m.value[c] - bare * passed) < 1e-4 * bare);
    }
    assert_true(m.value[2] == 0);
    pm_world_free(world);
}

/* A black plate with nothing behind it. */
static void shadow_is_black(void **state)
{
    (void)state;
    pm_world *world = world_of(DISC "void plastic black 0 0 5 0 0 0 0 0\n"
                                    "black ring plate 0 0 8  0 0 1  0 0 1  0 3\n");
    struct measured m = sense(world, &no_maps, PM_IRRADIANCE, facing_up, 64);
    for (int c = 0; c < 3; c++)
        assert_true(m.value[c] == 0);
    pm_world_free(world);
}

/* The same room in nanometres and in light years from the origin. */
static void units_and_place_do_not_matter(void **state)
{
    (void)state;
    static const struct {
        double scale, offset;
    } cases[] = {{1e-6, 0}, {1e6, 0}, {1, 1048576}, {1e-6, 1}};
    for (int i = 0; i < 4; i++) {
        char text[400];
        double s = cases[i].scale, o = cases[i].offset;
        snprintf(text, sizeof text,
                 "void light lamp 0 0 3 10 10 10\nlamp ring disc 0 0 8  %.17g %.17g %.17g  "
                 "0 0 -1  0 %.17g\n",
                 o, o, o + 2 * s, .5 * s);
        pm_world *world = world_of(text);
        pm_sensor sensor = {{o, o, o}, {0, 0, 1}};
        struct measured m = sense(world, &no_maps, PM_IRRADIANCE, sensor, 256);
        /* an offset of a million sizes leaves the place of the lamp 2^-33 of its size to round
         * to */
        assert_measured(&m, 0, 10 * PM_PI * .25 / 4.25, .02);
        pm_world_free(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(disc_light_gives_the_analytic_irradiance),
        cmocka_unit_test(irradiance_falls_with_the_square_and_the_cosine),
        cmocka_unit_test(even_sky_gives_pi_times_the_part_in_view),
        cmocka_unit_test(next_event_passes_straight_through_glass),
        cmocka_unit_test(shadow_is_black),
        cmocka_unit_test(units_and_place_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
