#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "numbers.h"
#include "world/light_table.h"

/* ---- functions over the square ---- */

static double even(const void *context, double u, double v)
{
    (void)context, (void)u, (void)v;
    return 2;
}

static double dark(const void *context, double u, double v)
{
    (void)context, (void)u, (void)v;
    return 0;
}

static double slope(const void *context, double u, double v)
{
    (void)context;
    return u * u * v;
}

/* 2^-14 of the square is bright: one cell in 128 x 128. */
static double pixel(const void *context, double u, double v)
{
    const double *contrast = context;
    bool inside = floor(u * 128) == 37 && floor(v * 128) == 90;
    return inside ? *contrast : 1;
}

static double steep(const void *context, double u, double v)
{
    (void)context;
    return pm_pow(1e9, u * v); /* nine orders of magnitude */
}

static double broken(const void *context, double u, double v)
{
    (void)context;
    if (u < .25)
        return v < .5 ? -INFINITY : NAN;
    return v < .5 ? INFINITY : 4;
}

static const double contrasts[] = {1e3, 1e12};

static const struct {
    double (*value)(const void *context, double u, double v);
    const void *context;
    uint32_t detail;
} functions[] = {
    {even, NULL, 32},
    {dark, NULL, 32},
    {slope, NULL, 64},
    {pixel, &contrasts[0], 128},
    {pixel, &contrasts[1], 256},
    {pixel, &contrasts[1], 4}, /* too small to be found */
    {steep, NULL, 128},
    {broken, NULL, 64},
    {slope, NULL, 0},
};
enum { FUNCTIONS = sizeof functions / sizeof *functions };

static struct pm_light_table *table_of(int i, pm_arena *arena)
{
    pm_error err = PM_ERROR_INIT;
    struct pm_light_table *table = NULL;
    const struct pm_light_function f = {functions[i].value, functions[i].context,
                                        functions[i].detail};
    assert_int_equal(pm_light_table_build(&f, arena, &table, &err), PM_OK);
    return table;
}

/* Counts in 16 x 16 cells against the density integrated over them; chi-squared, p > .001. */
static void frequency_equals_density(void **state)
{
    (void)state;
    enum { STEPS = 128 };
    for (int i = 0; i < FUNCTIONS; i++) {
        pm_arena arena = {0};
        struct pm_light_table *table = table_of(i, &arena);
        struct histogram h = {.samples = 200000};
        pm_rng rng;
        pm_rng_init(&rng, 3, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < h.samples; k++) {
            double u[2];
            draw(&rng, u, 2);
            double density = pm_light_table_warp(table, &u[0], &u[1]);
            assert_true(u[0] >= 0 && u[0] < 1 && u[1] >= 0 && u[1] < 1);
            assert_near(pm_light_table_density(table, u[0], u[1]), density, 1e-12 * density);
            h.found[(int)(u[1] * 16) * 16 + (int)(u[0] * 16)]++;
        }
        double whole = 0;
        for (int b = 0; b < 256; b++) {
            double sum = 0;
            for (int k = 0; k < STEPS * STEPS; k++)
                sum += pm_light_table_density(table, (b % 16 + (k % STEPS + .5) / STEPS) / 16,
                                              ((int)(b / 16) + (k / STEPS + .5) / STEPS) / 16);
            h.wanted[b] = h.samples * sum / (STEPS * STEPS) / 256;
            whole += sum / (STEPS * STEPS) / 256;
        }
        assert_near(whole, 1, 1e-6);
        histogram_check(&h);
        pm_arena_clear(&arena);
    }
}

/* Rounding of shares to floats takes up to 2^-24 a level. */
static void density_never_falls_below_its_floor(void **state)
{
    (void)state;
    for (int i = 0; i < FUNCTIONS; i++) {
        pm_arena arena = {0};
        struct pm_light_table *table = table_of(i, &arena);
        for (int k = 0; k < 1 << 16; k++) {
            double density = pm_light_table_density(table, (k % 256 + .5) / 256,
                                                    ((int)(k / 256) + .5) / 256);
            assert_true(density >= (1 - 1e-5) * PM_LIGHT_TABLE_FLOOR && density < 1e6);
        }
        pm_arena_clear(&arena);
    }
}

/* The sample's weight value / density, whose mean is the integral, varies by the table's own
 * steps alone: relative variance of a smooth function below (SMOOTH / 2)^2, and the floor adds
 * up to 1/15. A lone pixel's eight neighbours get 1/64 of its weight each, 1/7 of the rest. */
static void samples_of_smooth_and_spiked_functions_are_nearly_equal(void **state)
{
    (void)state;
    for (int i = 2; i < 7; i++) {
        if (functions[i].detail < 64)
            continue;
        pm_arena arena = {0};
        struct pm_light_table *table = table_of(i, &arena);
        double sum = 0, squares = 0;
        enum { N = 1 << 14 };
        for (int k = 0; k < N; k++) {
            double u = (k % 128 + .5) / 128, v = ((int)(k / 128) + .5) / 128;
            double density = pm_light_table_warp(table, &u, &v);
            double x = functions[i].value(functions[i].context, u, v) / density;
            sum += x / N;
            squares += x * x / N;
        }
        assert_at_most(squares / (sum * sum) - 1, 1. / 64 + 1. / 15 + 1. / 7);
        pm_arena_clear(&arena);
    }
}

/* ---- directions ---- */

static double towards_sun(const void *context, pm_vec3 w)
{
    const pm_vec3 *sun = context;
    return pm_exp(50 * (pm_vec3_dot(w, *sun) - 1));
}

static double beam_density(void *context, pm_vec3 w)
{
    const struct pm_light_beam *beam = context;
    return pm_vec3_dot(w, beam->frame.z) >= 1 - beam->versine ? pm_light_beam_pdf(beam, w) : 0;
}

/* Directions of cones of any width have the density that is told of them. */
static void directions_follow_their_density(void **state)
{
    (void)state;
    static const double versines[] = {2, 1, .5, 1.7};
    const pm_vec3 sun = {0, .6, .8};
    for (int i = 0; i < 4; i++) {
        pm_arena arena = {0};
        pm_error err = PM_ERROR_INIT;
        struct pm_light_beam beam;
        const struct pm_light_directions f = {towards_sun, &sun, 64};
        pm_vec3 axis = pm_vec3_normalize((pm_vec3){.3, .2, 1});
        assert_int_equal(pm_light_beam_build(&f, axis, versines[i], &arena, &beam, &err),
                         PM_OK);
        struct histogram h = {.samples = 20000};
        pm_rng rng;
        pm_rng_init(&rng, 4, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < h.samples; k++) {
            double u[2], pdf;
            draw(&rng, u, 2);
            pm_vec3 w = pm_light_beam_sample(&beam, u[0], u[1], &pdf);
            assert_near(pm_light_beam_pdf(&beam, w), pdf, 1e-9 * pdf);
            histogram_add(&h, w);
        }
        histogram_expect(&h, beam_density, &beam);
        histogram_check(&h);
        pm_arena_clear(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frequency_equals_density),
        cmocka_unit_test(density_never_falls_below_its_floor),
        cmocka_unit_test(samples_of_smooth_and_spiked_functions_are_nearly_equal),
        cmocka_unit_test(directions_follow_their_density),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
