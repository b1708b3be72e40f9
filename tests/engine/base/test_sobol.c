#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/sobol.h"

/* Dimensions 0 and 1 are a (0, 2)-sequence, and Owen scrambling keeps that: any 2^8 points from
 * a multiple of 2^8 on put exactly one into each dyadic box of area 2^-8. */
static void sobol_is_a_net(void **state)
{
    (void)state;
    for (uint32_t scramble = 0; scramble < 20; scramble++) {
        for (int bits = 0; bits <= 8; bits++) {
            bool taken[256] = {false};
            for (uint32_t i = 0; i < 256; i++) {
                uint32_t index = scramble * 256 + i;
                int x = (int)(pm_sobol(index, 0, scramble) * (1 << bits));
                int y = (int)(pm_sobol(index, 1, scramble) * (1 << (8 - bits)));
                int box = x * (1 << (8 - bits)) + y;
                assert_false(taken[box]);
                taken[box] = true;
            }
        }
    }
}

/* Each dimension alone is stratified: 2^k points, one in each interval of 2^-k. */
static void sobol_each_dimension_is_stratified(void **state)
{
    (void)state;
    for (unsigned d = 0; d < PM_SOBOL_DIMENSIONS; d++) {
        bool taken[1024] = {false};
        for (uint32_t i = 0; i < 1024; i++) {
            int cell = (int)(pm_sobol(i, d, 99) * 1024);
            assert_false(taken[cell]);
            taken[cell] = true;
        }
    }
}

/* One point under many scrambles is uniform: mean 1/2 with sigma = 1 / sqrt(12 n); 5 sigma; and
 * two dimensions are uncorrelated: mean product 1/4, sigma = sqrt(7) / 12 / sqrt(n). */
static void sobol_scrambles_are_independent(void **state)
{
    (void)state;
    enum { N = 20000 };
    double sum = 0, product = 0;
    for (uint32_t scramble = 0; scramble < N; scramble++) {
        double x = pm_sobol(5, 2, scramble), y = pm_sobol(5, 3, scramble);
        sum += x;
        product += x * y;
    }
    assert_true(fabs(sum / N - 0.5) < 5 / sqrt(12.0 * N));
    assert_true(fabs(product / N - 0.25) < 5 * sqrt(7.0) / 12 / sqrt(N));
}

static void sobol_points_are_their_numbers(void **state)
{
    (void)state;
    uint32_t hash[PM_SOBOL_DIMENSIONS];
    for (unsigned d = 0; d < PM_SOBOL_DIMENSIONS; d++)
        hash[d] = pm_hash_u32(7, d);
    for (uint32_t i = 0; i < 5000; i++) {
        double point[PM_SOBOL_DIMENSIONS];
        uint32_t index = i * 858993u;
        pm_sobol_point(index, hash, point);
        for (unsigned d = 0; d < PM_SOBOL_DIMENSIONS; d++)
            assert_true(point[d] == pm_sobol(index, d, 7));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sobol_is_a_net),
        cmocka_unit_test(sobol_points_are_their_numbers),
        cmocka_unit_test(sobol_each_dimension_is_stratified),
        cmocka_unit_test(sobol_scrambles_are_independent),
    };
    return cmocka_run_group_tests_name("base.sobol", tests, NULL, NULL);
}
