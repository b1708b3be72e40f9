#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"

enum { PHOTONS = 300 };

static void batch_file_round_trip_and_damage(void **state)
{
    (void)state;
    uint32_t ends[4] = {0, 100, 100, PHOTONS};
    pm_batch batch = {.kind = PM_MAP_GLOBAL,
                      .index = 5,
                      .paths = 4,
                      .ends = ends,
                      .count = PHOTONS,
                      .photons = field_photons(field_room, 1, PHOTONS),
                      .emitted = {3, 2, 1}};
    pm_bytes file = {0};
    pm_batch again = {0};
    assert_int_equal(pm_batch_write(&batch, &file, NULL), PM_OK);
    assert_int_equal(pm_batch_read(file.data, file.size, &again, NULL), PM_OK);
    assert_int_equal(again.index, 5);
    assert_memory_equal(again.ends, ends, sizeof ends);
    assert_memory_equal(again.photons, batch.photons, PHOTONS * sizeof(pm_photon));
    assert_true(again.emitted.r == 3);
    pm_batch_clear(&again);
    for (size_t size = 0; size < file.size; size++)
        assert_int_not_equal(pm_batch_read(file.data, size, &again, NULL), PM_OK);
    for (size_t i = 0; i < file.size; i++) {
        file.data[i] ^= (uint8_t)(1U << (i % 8));
        assert_int_not_equal(pm_batch_read(file.data, file.size, &again, NULL), PM_OK);
        file.data[i] ^= (uint8_t)(1U << (i % 8));
    }
    pm_bytes_clear(&file);
    free(batch.photons);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batch_file_round_trip_and_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
