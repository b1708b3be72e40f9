#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/sobol.h"
#include "numbers.h"
#include "world/light.h"
#include "world/media.h"

enum { SAMPLES = 1 << 16 };

/* ---- irradiance against closed formulas ---- */

/* The next-event estimate on a horizontal element that looks up, lamp unobstructed. */
static void estimate(const pm_world *world, pm_vec3 scene_point, double *mean, double *sigma)
{
    pm_vec3 point = pm_world_from_scene(world, scene_point);
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[3];
        pm_light_sample s;
        for (unsigned d = 0; d < 3; d++)
            u[d] = pm_sobol(i, d, 5 + d);
        if (!pm_light_sample_at(world, point, u, &s))
            continue;
        assert_true(s.pdf > 0 && isfinite(s.pdf) && s.distance > 0);
        double value = s.radiance.r * fmax(s.wi.z, 0) / s.pdf;
        sum += value;
        squares += value * value;
    }
    *mean = sum / SAMPLES;
    *sigma = sqrt(fmax(squares / SAMPLES - *mean * *mean, 0) / SAMPLES);
}

static void check_irradiance(const char *text, pm_vec3 point, double wanted)
{
    pm_world *world = world_of(text);
    double mean, sigma;
    estimate(world, point, &mean, &sigma);
    if (!(fabs(mean - wanted) <= 4 * sigma + 1e-9 * wanted))
        fail_msg("%s: %.9g is not %.9g within 4 * %g", text, mean, wanted, sigma);
    pm_world_free(world);
}

/* A disc over its axis: pi L sin^2 of the half angle. */
static void next_event_equals_the_disc_formula(void **state)
{
    (void)state;
    check_irradiance("void light m 0 0 3 2 2 2 m ring a 0 0 8 0 0 3 0 0 -1 0 4",
                     (pm_vec3){0, 0, 0}, 2 * PM_PI * 16 / 25);
    check_irradiance("void light m 0 0 3 2 2 2 m ring a 0 0 8 0 0 3 0 0 -1 2 4",
                     (pm_vec3){0, 0, 0}, 2 * PM_PI * (16. / 25 - 4. / 13)); /* less the hole */
    check_irradiance("void light m 0 0 3 2 2 2 m ring a 0 0 8 0 0 3 0 0 1 0 4",
                     (pm_vec3){0, 0, 0}, 0); /* turned away */
}

/* Of lamps that coincide only the first is seen, so only that one lights. */
static void lamps_one_on_the_other_light_as_one(void **state)
{
    (void)state;
    check_irradiance("void light m 0 0 3 2 2 2 m ring a 0 0 8 0 0 3 0 0 -1 0 4"
                     " m ring b 0 0 8 0 0 3 0 0 -1 0 4 m ring c 0 0 8 0 0 3 0 0 1 0 4",
                     (pm_vec3){0, 0, 0}, 2 * PM_PI * 16 / 25);
    check_irradiance("void light m 0 0 3 2 2 2 m ring a 0 0 8 0 0 3 0 0 -1 0 4"
                     " m ring b 0 0 8 0 0 3 0 0 -1 0 2",
                     (pm_vec3){0, 0, 0}, 2 * PM_PI * 16 / 25);
    check_irradiance(
        "void light m 0 0 3 2 2 2 m sphere a 0 0 4 3 0 4 2 m sphere b 0 0 4 3 0 4 2",
        (pm_vec3){0, 0, 0}, 2 * PM_PI * 4 / 25 * .8);
}

/* A sphere at distance d, wholly above the horizon: pi L (r/d)^2 cos. */
static void next_event_equals_the_sphere_formula(void **state)
{
    (void)state;
    const char *near = "void light m 0 0 3 2 2 2 m sphere a 0 0 4 3 0 4 2";
    check_irradiance(near, (pm_vec3){0, 0, 0}, 2 * PM_PI * 4 / 25 * .8);
    const char *touching = "void light m 0 0 3 2 2 2 m sphere a 0 0 4 0 0 1 .999999";
    check_irradiance(touching, (pm_vec3){0, 0, 0}, 2 * PM_PI * pow(.999999, 2));
    /* solid angle 3e-18: differences of squares would be noise */
    const char *far = "void light m 0 0 3 2e18 0 0 m sphere a 0 0 4 0 0 1e3 1e-6\n"
                      "void plastic p 0 0 5 0 0 0 0 0 p sphere b 0 0 4 0 0 -1e3 1";
    check_irradiance(far, (pm_vec3){0, 0, 0}, 2 * PM_PI);
    check_irradiance(near, (pm_vec3){3, 0, 4.5}, 0); /* inside: its front looks away */
}

/* Within a bubble light every point sees radiance L all around: half a sphere gives pi L. */
static void next_event_equals_the_furnace_in_a_bubble(void **state)
{
    (void)state;
    check_irradiance("void glow m 0 0 4 2 2 2 0 m bubble a 0 0 4 0 0 0 2", (pm_vec3){.5, 0, 1},
                     2 * PM_PI);
}

/* A rectangle over one of its corners (Howell's catalogue, B-4), in parallel planes:
 * F = (X atan(Y / X) ... ) with X = a / sqrt(a^2 + c^2) etc. */
static double corner_form_factor(double a, double b, double c)
{
    double x = sqrt(a * a + c * c), y = sqrt(b * b + c * c);
    return (a / x * atan(b / x) + b / y * atan(a / y)) / (2 * PM_PI);
}

static void next_event_equals_the_rectangle_formula(void **state)
{
    (void)state;
    const char *lamp = "void light m 0 0 3 2 2 2\n"
                       "m polygon a 0 0 12 0 0 1 0 5 1 3 5 1 3 0 1";
    check_irradiance(lamp, (pm_vec3){0, 0, 0}, 2 * PM_PI * corner_form_factor(3, 5, 1));
    double inside = corner_form_factor(1, 2, 1) + corner_form_factor(2, 2, 1) +
                    corner_form_factor(1, 3, 1) + corner_form_factor(2, 3, 1);
    check_irradiance(lamp, (pm_vec3){1, 2, 0}, 2 * PM_PI * inside);
    double close = corner_form_factor(1, 2, .01) + corner_form_factor(2, 2, .01) +
                   corner_form_factor(1, 3, .01) + corner_form_factor(2, 3, .01);
    check_irradiance(lamp, (pm_vec3){1, 2, .99}, 2 * PM_PI * close);
}

/* A distant cone: pi L sin^2 cos; and a whole sky: pi L. */
static void next_event_equals_the_distant_formula(void **state)
{
    (void)state;
    double sine = sin(.25 * PM_PI / 180);
    check_irradiance("void light m 0 0 3 2e4 0 0 m source a 0 0 4 0 3 4 .5", (pm_vec3){0, 0, 0},
                     2e4 * PM_PI * sine * sine * .8);
    check_irradiance("void glow m 0 0 4 2 0 0 0 m source a 0 0 4 0 0 1 180", (pm_vec3){0, 0, 0},
                     2 * PM_PI);
    check_irradiance("void glow m 0 0 4 2 0 0 0 m source a 0 0 4 1 0 0 360", (pm_vec3){0, 0, 0},
                     2 * PM_PI);
    /* a sun hides the sky behind it */
    sine = sin(PM_PI / 6);
    check_irradiance("void glow m 0 0 4 2 0 0 0 m source a 0 0 4 0 0 1 180\n"
                     "void light s 0 0 3 10 0 0 s source b 0 0 4 0 0 1 60",
                     (pm_vec3){0, 0, 0}, PM_PI * (2 + 8 * sine * sine));
}

/* A cylinder seen across: compared with the radiance integrated over directions that hit it,
 * which the exact ray query tells. The grid's error at the outline is below 1e-3 of the lamp.
 */
static void next_event_equals_quadrature(void **state)
{
    (void)state;
    const char *lamps[] = {
        "m cylinder a 0 0 7 -1 .5 2 1 .5 2 .4", "m cone a 0 0 8 0 1 1 0 0 2 .6 .1",
        "m cup a 0 0 8 0 .2 1 0 0 2 .9 .1", "m tube a 0 0 7 0 0 1 0 .1 1.5 .8"};
    enum { STEPS = 1000 };
    for (int k = 0; k < 4; k++) {
        char text[200];
        snprintf(text, sizeof text, "void light m 0 0 3 2 2 2 %s", lamps[k]);
        pm_world *world = world_of(text);
        pm_vec3 point = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
        double sum = 0;
        for (int i = 0; i < STEPS * STEPS; i++) {
            pm_vec3 w = pm_warp_cosine((i / STEPS + .5) / STEPS, (i % STEPS + .5) / STEPS);
            pm_ray ray = {point, w, INFINITY, PM_NO_PRIMITIVE};
            pm_hit hit;
            if (pm_world_intersect(world, &ray, &hit))
                sum += pm_light_radiance(world, &hit, pm_vec3_negate(w)).r;
        }
        double wanted = sum * PM_PI / (STEPS * STEPS), mean = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            pm_light_sample s;
            double u[3] = {pm_sobol(i, 0, 1), pm_sobol(i, 1, 2), pm_sobol(i, 2, 3)};
            pm_media media = {0};
            if (!pm_light_sample_at(world, point, u, &s))
                continue;
            pm_ray ray = {point, s.wi, s.distance, PM_NO_PRIMITIVE};
            double seen = pm_world_transmittance(world, &ray, &media, s.weak).r;
            mean += seen * s.radiance.r * fmax(s.wi.z, 0) / s.pdf / SAMPLES;
        }
        assert_near(mean, wanted, 4e-3 * wanted);
        pm_world_free(world);
    }
}

/* ---- densities ---- */

static const char *const scenes[] = {
    "void light m 0 0 3 1 1 1 m sphere a 0 0 4 .3 .2 1 .5",
    "void light m 0 0 3 1 1 1 m polygon a 0 0 12 -1 -1 .6 -1 1 .6 1 1 .6 1 -1 .6",
    "void light m 0 0 3 1 1 1 m ring a 0 0 8 0 0 .5 .2 0 -1 .1 .9",
    "void light m 0 0 3 1 1 1 m cylinder a 0 0 7 -1 .5 .8 1 .5 .8 .4",
    "void glow m 0 0 4 1 1 1 0 m bubble a 0 0 4 .1 .2 .1 .9",
    "void light m 0 0 3 1 1 1 m sphere a 0 0 4 .3 .2 1 .5 m sphere b 0 0 4 0 -1 .4 .3\n"
    "void light n 0 0 3 9 9 9 n source c 0 0 4 1 0 1 60 n source d 0 0 4 0 1 1 80",
};
enum { SCENES = sizeof scenes / sizeof *scenes };

/* Density of a direction as a bounce would ask for it. All surfaces along the direction count,
 * for next event draws hidden points too. */
static double density_by_bounce(void *context, pm_vec3 w)
{
    const pm_world *world = context;
    pm_vec3 point = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
    double sum = 0;
    pm_light_distant(world, w, &sum);
    pm_ray ray = {point, w, INFINITY, PM_NO_PRIMITIVE};
    pm_hit hit;
    while (pm_world_intersect(world, &ray, &hit)) {
        sum += pm_light_pdf_surface(world, point, w, &hit);
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    return sum;
}

static void frequency_equals_the_density_that_bounces_ask_for(void **state)
{
    (void)state;
    for (int k = 0; k < SCENES; k++) {
        pm_world *world = world_of(scenes[k]);
        pm_vec3 point = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
        struct histogram h = {.samples = 15000};
        pm_rng rng;
        pm_rng_init(&rng, 9, PM_RNG_PATH, (uint64_t)k);
        for (int i = 0; i < h.samples; i++) {
            double u[3];
            pm_light_sample s;
            draw(&rng, u, 3);
            if (!pm_light_sample_at(world, point, u, &s))
                continue;
            histogram_add(&h, s.wi);
            double by_bounce = density_by_bounce(world, s.wi);
            assert_true(by_bounce > .999 * s.pdf);
        }
        histogram_expect(&h, density_by_bounce, world);
        histogram_check(&h);
        pm_world_free(world);
    }
}

/* A sample, followed by a ray, meets the lamp that it names just behind its end, with the same
 * density. */
static void samples_lie_on_the_lamp_that_they_name(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        pm_world *world = world_of(scenes[k]);
        pm_vec3 point = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
        for (uint32_t i = 0; i < 10000; i++) {
            double u[3] = {pm_sobol(i, 0, 1), pm_sobol(i, 1, 2), pm_sobol(i, 2, 3)};
            pm_light_sample s;
            pm_hit hit;
            if (!pm_light_sample_at(world, point, u, &s))
                continue;
            pm_ray ray = {point, s.wi, INFINITY, PM_NO_PRIMITIVE};
            if (!pm_world_intersect(world, &ray, &hit)) {
                assert_near(pm_sobol(i, 1, 2), 1,
                            1e-4); /* the sphere's rim, missed by rounding */
                continue;
            }
            assert_true(hit.surface == s.surface);
            if (fabs(hit.t - s.distance) > 1e-4 * hit.t)
                continue; /* the near wall of the cylinder */
            assert_true(s.distance < hit.t);
            assert_near(pm_light_pdf_surface(world, point, s.wi, &hit), s.pdf, 1e-6 * s.pdf);
        }
        pm_world_free(world);
    }
}

/* ---- many lights ---- */

/* The sun, a million times stronger, leaves a lamp half of the even share. */
static void lamp_beside_the_sun_is_found(void **state)
{
    (void)state;
    pm_world *world = world_of("void light s 0 0 3 1e12 1e12 1e12 s source a 0 0 4 0 0 1 .5\n"
                               "void light m 0 0 3 1 1 1 m sphere b 0 0 4 0 0 1 .1");
    pm_vec3 point = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
    int found = 0;
    for (int i = 0; i < 1000; i++) {
        double u[3] = {(i + .5) / 1000, .5, .5};
        pm_light_sample s;
        assert_true(pm_light_sample_at(world, point, u, &s));
        found += s.surface != PM_NO_PRIMITIVE;
    }
    assert_int_equal(found, 250);
    pm_world_free(world);
}

/* 10^5 distant sources: a sample must not look at each of them. */
static void sky_of_many_patches_is_uniform(void **state)
{
    (void)state;
    enum { PATCHES = 20000 };
    char *text = malloc(PATCHES * 80 + 100), *at = text;
    assert_non_null(text);
    at += sprintf(at, "void light m 0 0 3 1 1 1\n");
    for (int i = 0; i < PATCHES; i++) { /* a spiral over the hemisphere */
        pm_vec3 d = polar((i + .5) / PATCHES, i * 2.399963229728653);
        at += sprintf(at, "m source s 0 0 4 %.9f %.9f %.9f .8\n", d.x, d.y, d.z);
    }
    pm_world *world = world_of(text);
    free(text);
    double mean, sigma;
    estimate(world, (pm_vec3){0, 0, 0}, &mean, &sigma);
    /* sum over patches of pi sin^2 cos, cos being (i + .5) / PATCHES */
    double wanted = PM_PI * pow(sin(.4 * PM_PI / 180), 2) * PATCHES / 2;
    assert_near(mean, wanted, 4 * sigma);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_one_on_the_other_light_as_one),
        cmocka_unit_test(next_event_equals_the_disc_formula),
        cmocka_unit_test(next_event_equals_the_sphere_formula),
        cmocka_unit_test(next_event_equals_the_furnace_in_a_bubble),
        cmocka_unit_test(next_event_equals_the_rectangle_formula),
        cmocka_unit_test(next_event_equals_the_distant_formula),
        cmocka_unit_test(next_event_equals_quadrature),
        cmocka_unit_test(frequency_equals_the_density_that_bounces_ask_for),
        cmocka_unit_test(samples_lie_on_the_lamp_that_they_name),
        cmocka_unit_test(lamp_beside_the_sun_is_found),
        cmocka_unit_test(sky_of_many_patches_is_uniform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
