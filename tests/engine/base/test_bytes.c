#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "base/bytes.h"

static void bytes_round_trip_little_endian(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    pm_bytes_u8(&bytes, 7);
    pm_bytes_u32(&bytes, 0x01020304U);
    pm_bytes_u64(&bytes, UINT64_C(0x1122334455667788));
    pm_bytes_f64(&bytes, -0.1);
    pm_bytes_format(&bytes, "%d photons", 12);
    assert_int_equal(pm_bytes_status(&bytes), PM_OK);
    assert_int_equal(bytes.size, 1 + 4 + 8 + 8 + 10);
    assert_int_equal(bytes.data[1], 0x04);

    pm_reader reader = {.data = bytes.data, .size = bytes.size};
    assert_int_equal(pm_reader_u8(&reader), 7);
    assert_int_equal(pm_reader_u32(&reader), 0x01020304U);
    assert_true(pm_reader_u64(&reader) == UINT64_C(0x1122334455667788));
    assert_true(pm_reader_f64(&reader) == -0.1);
    assert_memory_equal(pm_reader_take(&reader, 10), "12 photons", 10);
    assert_false(reader.failed);
    pm_bytes_clear(&bytes);
}

static void reader_stops_at_the_end(void **state)
{
    (void)state;
    const uint8_t data[3] = {1, 2, 3};
    pm_reader reader = {.data = data, .size = sizeof data};
    assert_int_equal(pm_reader_u32(&reader), 0);
    assert_true(reader.failed);
    assert_int_equal(pm_reader_u8(&reader), 0); /* and stays there */
    reader = (pm_reader){.data = data, .size = sizeof data};
    assert_null(pm_reader_take(&reader, SIZE_MAX));
}

static void bytes_growth_that_overflows_fails_once_and_for_all(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    pm_bytes_append(&bytes, "x", SIZE_MAX - 8);
    assert_int_equal(pm_bytes_status(&bytes), PM_E_MEMORY);
    pm_bytes_u8(&bytes, 1);
    assert_int_equal(bytes.size, 0);
    pm_bytes_clear(&bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_round_trip_little_endian),
        cmocka_unit_test(reader_stops_at_the_end),
        cmocka_unit_test(bytes_growth_that_overflows_fails_once_and_for_all),
    };
    return cmocka_run_group_tests_name("base.bytes", tests, NULL, NULL);
}
