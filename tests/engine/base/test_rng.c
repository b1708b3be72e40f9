#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "base/rng.h"

/* Random123's published known answer for Philox 4x32-10 with counter and key zero. */
static void rng_philox_known_answers(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 0, (pm_rng_purpose)0, 0);
    assert_int_equal(pm_rng_u32(&rng), 0x6627e8d5U);
    assert_int_equal(pm_rng_u32(&rng), 0xe169c58dU);
    assert_int_equal(pm_rng_u32(&rng), 0xbc57ac4cU);
    assert_int_equal(pm_rng_u32(&rng), 0x9b00dbd8U);
}

static void rng_bounce_does_not_depend_on_earlier_draws(void **state)
{
    (void)state;
    pm_rng a, b;
    pm_rng_init(&a, 5, PM_RNG_PATH, 77);
    pm_rng_init(&b, 5, PM_RNG_PATH, 77);
    for (int i = 0; i < 13; i++)
        (void)pm_rng_u32(&a);
    pm_rng_bounce(&a, 3);
    pm_rng_bounce(&b, 3);
    for (int i = 0; i < 9; i++)
        assert_int_equal(pm_rng_u32(&a), pm_rng_u32(&b));
}

/* 10 bins, 1e5 draws: each bin is binomial with sigma = sqrt(1e5 * .1 * .9) = 94.9; 5 sigma. */
static void rng_uniform_fills_the_unit_interval(void **state)
{
    (void)state;
    int bins[10] = {0};
    for (uint64_t path = 0; path < 10000; path++) {
        pm_rng rng;
        pm_rng_init(&rng, 1, PM_RNG_PATH, path);
        for (int i = 0; i < 10; i++) {
            double u = pm_rng_uniform(&rng);
            assert_true(u >= 0 && u < 1);
            bins[(int)(u * 10)]++;
        }
    }
    for (int i = 0; i < 10; i++)
        assert_true(fabs((double)bins[i] - 10000) < 5 * 94.9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rng_philox_known_answers),
        cmocka_unit_test(rng_bounce_does_not_depend_on_earlier_draws),
        cmocka_unit_test(rng_uniform_fills_the_unit_interval),
    };
    return cmocka_run_group_tests_name("base.rng", tests, NULL, NULL);
}
