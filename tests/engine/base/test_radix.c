#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/radix.h"
#include "base/rng.h"

/* Keys of so many random bits at a place; values say where an item was. */
static void check(size_t count, int bits, int shift)
{
    pm_keyed *items = malloc((count + 1) * sizeof *items);
    assert_non_null(items);
    pm_rng rng;
    pm_rng_init(&rng, 7, PM_RNG_PATH, count);
    for (size_t i = 0; i < count; i++) {
        uint64_t mask = bits == 64 ? UINT64_MAX : (UINT64_C(1) << bits) - 1;
        uint64_t high = pm_rng_u32(&rng), key = high << 32 | pm_rng_u32(&rng);
        items[i] = (pm_keyed){(key & mask) << shift, (uint32_t)i};
    }
    assert_int_equal(pm_radix_sort(items, count), PM_OK);
    for (size_t i = 1; i < count; i++) {
        assert_true(items[i - 1].key <= items[i].key);
        if (items[i - 1].key == items[i].key)
            assert_true(items[i - 1].value < items[i].value);
    }
    free(items);
}

static void sorts_stably_whatever_the_bits(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, 2, 15, 16, 17, 33, 100, 4095, 4097, 100000};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        check(counts[i], 64, 0);
        check(counts[i], 3, 0);
        check(counts[i], 3, 61);
        check(counts[i], 12, 20);
        check(counts[i], 1, 63);
    }
}

static void an_even_number_of_passes_and_an_odd_one_end_in_place(void **state)
{
    (void)state;
    for (int bits = 1; bits < 64; bits += 11)
        check(5000, bits, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sorts_stably_whatever_the_bits),
        cmocka_unit_test(an_even_number_of_passes_and_an_odd_one_end_in_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
