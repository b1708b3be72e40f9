#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"
#include "photons/part.h"

static pm_part_coder *coder;

/* Packs, unpacks, compares; returns bytes a photon. */
static double round_trip(const pm_photon *photons, size_t count, bool in_order)
{
    uint8_t *marks = calloc(count + 1, 1); /* paths of three photons */
    for (size_t i = 0; i < count; i += 3)
        marks[i] = 1;
    const uint8_t *first = in_order ? NULL : marks;
    pm_bytes packed = {0};
    pm_photon *again = malloc(count * sizeof *again + 1);
    pm_part_pack(coder, photons, count, first, &packed);
    assert_int_equal(pm_bytes_status(&packed), PM_OK);
    pm_reader reader = {.data = packed.data, .size = packed.size};
    assert_true(pm_part_unpack(coder, &reader, count, first, again));
    assert_memory_equal(photons, again, count * sizeof *again);
    assert_true(packed.size >= PM_PART_LEAST * count);
    double bytes = (double)packed.size / (double)count;
    pm_bytes_clear(&packed);
    free(again);
    free(marks);
    return bytes;
}

static void photons_come_back_as_they_were(void **state)
{
    (void)state;
    field_make *fields[] = {field_room, field_ball, field_sphere, field_caustic, field_point};
    for (unsigned f = 0; f < sizeof fields / sizeof *fields; f++)
        for (size_t count = 0; count <= PM_PART_PHOTONS; count = count * 3 + 1) {
            pm_photon *photons = field_photons(fields[f], f, count);
            round_trip(photons, count, false);
            round_trip(photons, count, true); /* any order comes back */
            pm_photons_sort(photons, count, NULL);
            round_trip(photons, count, true);
            free(photons);
        }
}

/* A million photons in order: 16 bytes each at most, on walls, on a curved surface, in a
 * volume, with directions as random as they can be. */
static void photons_in_order_take_at_most_16_bytes(void **state)
{
    (void)state;
    enum { COUNT = 1000000, FIRST = 400000 };
    field_make *fields[] = {field_room, field_ball, field_sphere, field_caustic};
    for (unsigned f = 0; f < sizeof fields / sizeof *fields; f++) {
        pm_photon *photons = field_photons(fields[f], f, COUNT);
        pm_rng rng;
        pm_rng_init(&rng, f, PM_RNG_PATH, 1);
        for (size_t i = 0; i < COUNT; i++) {
            photons[i].direction[0] = (uint16_t)pm_rng_u32(&rng);
            photons[i].direction[1] = (uint16_t)pm_rng_u32(&rng);
        }
        pm_photons_sort(photons, COUNT, NULL);
        assert_true(round_trip(photons + FIRST, PM_PART_PHOTONS, true) <= 16);
        free(photons);
    }
}

/* Paths of three photons in mist, each but the first seen from the one before: two thirds of
 * the directions are told by the places. */
static void directions_along_paths_take_no_bytes(void **state)
{
    (void)state;
    enum { COUNT = 60000 };
    pm_photon *photons = field_photons(field_ball, 1, COUNT);
    double apart = round_trip(photons, COUNT, false);
    for (size_t i = 0; i < COUNT; i++)
        if (i % 3)
            pm_photon_direction_code(pm_vec3_sub(pm_photon_position(&photons[i - 1]),
                                                 pm_photon_position(&photons[i])),
                                     photons[i].direction);
    double along = round_trip(photons, COUNT, false);
    assert_true(along < apart - 2. / 3 * 4 + .2); /* .2: for the plane that says so */
    free(photons);
}

static void numbers_come_back_as_they_were(void **state)
{
    (void)state;
    uint32_t numbers[1000], again[1000];
    for (uint32_t i = 0; i < 1000; i++)
        numbers[i] = i % 5 ? i % 3 : i * 0x10001;
    pm_bytes packed = {0};
    pm_part_pack_numbers(coder, numbers, 1000, &packed);
    pm_reader reader = {.data = packed.data, .size = packed.size};
    assert_true(pm_part_unpack_numbers(coder, &reader, 1000, again));
    assert_memory_equal(numbers, again, sizeof numbers);
    pm_bytes_clear(&packed);
}

/* Without the checksum that files have: what is damaged is found or gives other photons, but
 * nothing is written or read beyond its place (a sanitizer watches). */
static void damaged_parts_are_harmless(void **state)
{
    (void)state;
    enum { COUNT = 500 };
    pm_photon *photons = field_photons(field_room, 1, COUNT), *again = malloc(COUNT * 24);
    pm_bytes packed = {0};
    pm_part_pack(coder, photons, COUNT, NULL, &packed);
    for (size_t size = 0; size < packed.size; size++) {
        uint8_t *copy = malloc(size + 1);
        memcpy(copy, packed.data, size);
        pm_reader reader = {.data = copy, .size = size};
        assert_false(pm_part_unpack(coder, &reader, COUNT, NULL, again));
        free(copy);
    }
    for (size_t i = 0; i < 8 * packed.size; i++) {
        pm_reader reader = {.data = packed.data, .size = packed.size};
        packed.data[i / 8] ^= (uint8_t)(1U << i % 8);
        (void)pm_part_unpack(coder, &reader, COUNT, NULL, again);
        packed.data[i / 8] ^= (uint8_t)(1U << i % 8);
    }
    pm_reader longer = {.data = packed.data, .size = packed.size};
    assert_false(pm_part_unpack(coder, &longer, COUNT - 1, NULL, again));
    pm_bytes_clear(&packed);
    free(photons);
    free(again);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photons_come_back_as_they_were),
        cmocka_unit_test(photons_in_order_take_at_most_16_bytes),
        cmocka_unit_test(directions_along_paths_take_no_bytes),
        cmocka_unit_test(numbers_come_back_as_they_were),
        cmocka_unit_test(damaged_parts_are_harmless),
    };
    coder = pm_part_coder_new();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    pm_part_coder_free(coder);
    return failed;
}
