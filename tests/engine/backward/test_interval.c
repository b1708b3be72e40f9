/* Means and intervals from synthetic samples. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "backward/backward_internal.h"

/* Sums of `passes` samples of mean 3, as replicates get them. */
static struct pm_interval sample(pm_rng *rng, uint32_t passes)
{
    double sum[PM_REPLICATES] = {0};
    uint32_t count[PM_REPLICATES] = {0};
    for (uint32_t p = 0; p < passes; p++) {
        double bell = 0; /* nearly normal: four uniform numbers of variance 1/12 each */
        for (int i = 0; i < 4; i++)
            bell += pm_rng_uniform(rng) - .5;
        sum[p % PM_REPLICATES] += 3 + bell;
        count[p % PM_REPLICATES]++;
    }
    return pm_interval_of(sum, count);
}

/* 20000 trials of 95 %: 19000 hits, sigma = sqrt(20000 .95 .05) = 30.8; k = 4, and .3 % of the
 * trials for the sum of four uniform numbers not being normal. Passes that fill no round of
 * replicates give unequal weights. */
static void intervals_cover_the_truth_in_95_of_100_cases(void **state)
{
    (void)state;
    static const uint32_t passes[] = {2, 3, 7, 16, 19, 47, 64};
    enum { TRIALS = 20000 };
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) {
        pm_rng rng;
        pm_rng_init(&rng, 11, PM_RNG_PATH, i);
        int covered = 0;
        for (int t = 0; t < TRIALS; t++) {
            struct pm_interval interval = sample(&rng, passes[i]);
            double half = pm_student_quantile(interval.freedom) * sqrt(interval.variance);
            covered += fabs(interval.mean - 3) <= half;
        }
        assert_true(fabs(covered - .95 * TRIALS) < 4 * 30.8 + .003 * TRIALS);
    }
}

/* The standard error of n independent samples of variance 1/3 is sqrt(1 / (3 n)); its mean over
 * 20000 trials is known to sigma = sqrt(2 / 1 / 20000) = .01 of it at worst; k = 4. */
static void estimated_variance_is_unbiased(void **state)
{
    (void)state;
    static const uint32_t passes[] = {2, 5, 16, 23, 40};
    enum { TRIALS = 20000 };
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) {
        pm_rng rng;
        pm_rng_init(&rng, 12, PM_RNG_PATH, i);
        double sum = 0;
        for (int t = 0; t < TRIALS; t++)
            sum += sample(&rng, passes[i]).variance;
        double want = 1 / (3.0 * passes[i]);
        assert_true(fabs(sum / TRIALS - want) < 4 * .01 * want);
    }
}

static void one_replicate_is_no_evidence(void **state)
{
    (void)state;
    double sum[PM_REPLICATES] = {[3] = 6};
    uint32_t passes[PM_REPLICATES] = {[3] = 2};
    struct pm_interval interval = pm_interval_of(sum, passes);
    assert_true(interval.mean == 3);
    assert_true(interval.variance == INFINITY);
}

/* prod (k + 2/3) / (k + 1) for k = 1..n is Gamma(n + 5/3) / (Gamma(5/3) (n + 1)!). */
static void progressive_radius_follows_the_product(void **state)
{
    (void)state;
    static const uint32_t passes[] = {0, 1, 2, 10, 100, 5000};
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) {
        double n = passes[i];
        double square = exp(lgamma(n + 5.0 / 3) - lgamma(5.0 / 3) - lgamma(n + 2));
        double radius = pm_progressive_radius(.25, passes[i]);
        assert_true(fabs(radius - .25 * sqrt(square)) < 1e-9 * radius);
    }
    /* shrinks as n^((alpha - 1) / 2): by 2^(-1/6) for twice the passes */
    double ratio = pm_progressive_radius(1, 20000) / pm_progressive_radius(1, 10000);
    assert_true(fabs(ratio - pow(2, -1.0 / 6)) < 1e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(intervals_cover_the_truth_in_95_of_100_cases),
        cmocka_unit_test(estimated_variance_is_unbiased),
        cmocka_unit_test(one_replicate_is_no_evidence),
        cmocka_unit_test(progressive_radius_follows_the_product),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
