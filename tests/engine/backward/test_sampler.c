/* Numbers of a sample. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "backward/backward_internal.h"

/* 16 consecutive points of one replicate's sequence hit each sixteenth of the unit interval in
 * each of their dimensions, and each square of 4 x 4 in the first two: a (0, 4, 2)-net. */
static void passes_of_a_replicate_are_one_sobol_sequence(void **state)
{
    (void)state;
    for (uint32_t item = 0; item < 8; item++) {
        unsigned strata[3] = {0}, squares = 0;
        for (uint32_t j = 0; j < 16; j++) {
            struct pm_sampler sampler;
            double lens[3], light[3];
            pm_sampler_init(&sampler, 5, 3 + 16 * j, item);
            pm_sampler_draw(&sampler, PM_SAMPLE_LENS, lens);
            pm_sampler_draw(&sampler, PM_SAMPLE_LIGHT, light);
            strata[0] |= 1U << (int)(16 * lens[0]);
            strata[1] |= 1U << (int)(16 * lens[1]);
            strata[2] |= 1U << (int)(16 * light[2]);
            squares |= 1U << (4 * (int)(4 * lens[0]) + (int)(4 * lens[1]));
        }
        for (int d = 0; d < 3; d++)
            assert_int_equal(strata[d], 0xFFFF);
        assert_int_equal(squares, 0xFFFF);
    }
}

/* Uniform over replicates and pixels: mean .5 to k = 4 sigma of 1 / sqrt(12 n). */
static void replicates_and_pixels_have_scrambles_of_their_own(void **state)
{
    (void)state;
    enum { N = 16 * 1024 };
    double sum = 0, product = 0, last = .5;
    for (uint32_t i = 0; i < N; i++) {
        struct pm_sampler sampler;
        double u[3];
        pm_sampler_init(&sampler, 9, i % 16, i / 16);
        pm_sampler_draw(&sampler, PM_SAMPLE_LENS, u);
        sum += u[0];
        product += (u[0] - .5) * (last - .5);
        last = u[0];
    }
    assert_true(fabs(sum / N - .5) < 4 / sqrt(12.0 * N));
    assert_true(fabs(product / N) < 4 / (12 * sqrt((double)N)));
}

static void later_draws_of_a_use_are_fresh(void **state)
{
    (void)state;
    struct pm_sampler sampler;
    double first[3], second[3], third[3];
    pm_sampler_init(&sampler, 9, 0, 0);
    pm_sampler_draw(&sampler, PM_SAMPLE_LIGHT, first);
    pm_sampler_draw(&sampler, PM_SAMPLE_LIGHT, second);
    pm_sampler_draw(&sampler, PM_SAMPLE_LIGHT, third);
    for (int i = 0; i < 3; i++) {
        assert_true(first[i] != second[i]);
        assert_true(second[i] != third[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_of_a_replicate_are_one_sobol_sequence),
        cmocka_unit_test(replicates_and_pixels_have_scrambles_of_their_own),
        cmocka_unit_test(later_draws_of_a_use_are_fresh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
