#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "photons/photon_map.h"

enum { PHOTONS = 300 };

static double uniform(pm_rng *rng)
{
    return 2 * pm_rng_uniform(rng) - 1;
}

static pm_photon *make_photons(size_t count)
{
    pm_rng rng;
    pm_photon *photons = calloc(count + 1, sizeof *photons);
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (size_t i = 0; i < count; i++) {
        pm_photon_record record = {.position = {uniform(&rng), uniform(&rng), uniform(&rng)},
                                   .normal = {0, 0, 1},
                                   .direction = {0, 0, 1},
                                   .flux = {.5, .25, 1},
                                   .specular = i % 3 == 0,
                                   .replicate = i % PM_REPLICATES};
        pm_photon_pack(&record, 1, &photons[i]);
    }
    return photons;
}

static pm_photon_map *make_map(size_t count)
{
    pm_map_header header = {.kind = PM_MAP_CAUSTIC,
                            .scene = pm_digest_of("scene", 5),
                            .family = pm_digest_of("family", 6),
                            .paths = 1234,
                            .flux_scale = 2.5,
                            .world_scale = 4,
                            .world_center = {1, 2, 3},
                            .seed = 7,
                            .storage_probability = .5,
                            .emitted = {1, 2, 3},
                            .note = "a note"};
    pm_batch batch = {.kind = PM_MAP_CAUSTIC, .paths = 1, .count = count};
    pm_photon_map *map = NULL;
    batch.photons = make_photons(count);
    assert_int_equal(pm_photon_map_build(&header, &batch, 1, NULL, &map, NULL), PM_OK);
    free(batch.photons);
    return map;
}

static void map_file_round_trip(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, PHOTONS, 100000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        pm_photon_map *map = make_map(counts[c]), *again = NULL;
        pm_bytes file = {0}, second = {0};
        char *command = NULL;
        assert_int_equal(pm_photon_map_write(map, "mkpmap -apc x 300", &file, NULL), PM_OK);
        assert_int_equal(
            pm_photon_map_read(file.data, file.size, "x.cpm", &again, &command, NULL), PM_OK);
        assert_string_equal(command, "mkpmap -apc x 300");
        assert_int_equal(pm_photon_map_count(again), counts[c]);
        const pm_map_header *a = pm_photon_map_header(map), *b = pm_photon_map_header(again);
        assert_int_equal(a->kind, b->kind);
        assert_true(pm_digest_equal(&a->scene, &b->scene));
        assert_true(a->paths == b->paths && a->world_center.z == b->world_center.z);
        assert_string_equal(a->note, b->note);
        assert_int_equal(pm_photon_map_write(again, command, &second, NULL), PM_OK);
        assert_int_equal(file.size, second.size);
        assert_memory_equal(file.data, second.data, file.size);
        free(command);
        pm_bytes_clear(&file);
        pm_bytes_clear(&second);
        pm_photon_map_free(map);
        pm_photon_map_free(again);
    }
}

/* Every byte of the file is under a checksum or a magic: each truncation and each flipped bit
 * is refused, and says which file it is. */
static void map_file_damage_is_found(void **state)
{
    (void)state;
    pm_photon_map *map = make_map(PHOTONS), *again = NULL;
    pm_bytes file = {0};
    assert_int_equal(pm_photon_map_write(map, "mkpmap", &file, NULL), PM_OK);
    for (size_t size = 0; size < file.size; size++) {
        pm_error err = PM_ERROR_INIT;
        uint8_t *copy = malloc(size + 1); /* exact, so that a sanitizer sees a read too far */
        memcpy(copy, file.data, size);
        assert_int_not_equal(pm_photon_map_read(copy, size, "x.cpm", &again, NULL, &err),
                             PM_OK);
        assert_string_equal(err.file, "x.cpm");
        free(copy);
    }
    for (size_t i = 0; i < file.size; i++) {
        file.data[i] ^= (uint8_t)(1U << (i % 8));
        assert_int_not_equal(
            pm_photon_map_read(file.data, file.size, "x.cpm", &again, NULL, NULL), PM_OK);
        file.data[i] ^= (uint8_t)(1U << (i % 8));
    }
    pm_bytes_u8(&file, 0);
    assert_int_equal(pm_photon_map_read(file.data, file.size, "x.cpm", &again, NULL, NULL),
                     PM_E_CORRUPT);
    pm_bytes_clear(&file);
    pm_photon_map_free(map);
}

static void map_file_of_a_newer_version_is_refused(void **state)
{
    (void)state;
    pm_photon_map *map = make_map(1), *again = NULL;
    pm_bytes file = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_photon_map_write(map, "", &file, NULL), PM_OK);
    file.data[8]++;
    assert_int_equal(pm_photon_map_read(file.data, file.size, "x.cpm", &again, NULL, &err),
                     PM_E_UNSUPPORTED);
    assert_int_equal(pm_photon_map_read("#?RADIANCE\n", 11, "a.hdr", &again, NULL, NULL),
                     PM_E_SYNTAX);
    pm_bytes_clear(&file);
    pm_photon_map_free(map);
}

static void batch_file_round_trip_and_damage(void **state)
{
    (void)state;
    uint32_t ends[4] = {0, 100, 100, PHOTONS};
    pm_batch batch = {.kind = PM_MAP_GLOBAL,
                      .index = 5,
                      .paths = 4,
                      .ends = ends,
                      .count = PHOTONS,
                      .photons = make_photons(PHOTONS),
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
    for (size_t size = 0; size < file.size; size += 7)
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
        cmocka_unit_test(map_file_round_trip),
        cmocka_unit_test(map_file_damage_is_found),
        cmocka_unit_test(map_file_of_a_newer_version_is_refused),
        cmocka_unit_test(batch_file_round_trip_and_damage),
    };
    return cmocka_run_group_tests_name("photons.map_file", tests, NULL, NULL);
}
