#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/crc.h"
#include "base/rng.h"
#include "photons/map_internal.h"

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

static void map_file_of_another_version_is_refused(void **state)
{
    (void)state;
    pm_photon_map *map = make_map(1), *again = NULL;
    pm_bytes file = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_photon_map_write(map, "", &file, NULL), PM_OK);
    file.data[8]++;
    assert_int_equal(pm_photon_map_read(file.data, file.size, "x.cpm", &again, NULL, &err),
                     PM_E_UNSUPPORTED);
    file.data[8] = 1;
    err = (pm_error)PM_ERROR_INIT;
    assert_int_equal(pm_photon_map_read(file.data, file.size, "x.cpm", &again, NULL, &err),
                     PM_E_UNSUPPORTED);
    assert_string_equal(err.text, "is an older file, of version 1 (now 2): make the map again "
                                  "with mkpmap");
    assert_int_equal(pm_photon_map_read("#?RADIANCE\n", 11, "a.hdr", &again, NULL, NULL),
                     PM_E_SYNTAX);
    pm_bytes_clear(&file);
    pm_photon_map_free(map);
}

/* Appends to `file`, as a worker would send it. */
static pm_status put(void *context, const void *data, size_t size, pm_error *err)
{
    (void)err;
    pm_bytes_append(context, data, size);
    return pm_bytes_status(context);
}

static void threads_do_not_change_the_bytes(void **state)
{
    (void)state;
    pm_photon_map *map = make_map(700000); /* more parts than are packed at a time */
    pm_pool *pool = pm_pool_new(3);
    pm_bytes one = {0}, three = {0};
    const pm_sink sink = {&three, put};
    assert_int_equal(pm_photon_map_write(map, "c", &one, NULL), PM_OK);
    assert_int_equal(pm_photon_map_stream(map, "c", pool, &sink, NULL), PM_OK);
    assert_int_equal(one.size, three.size);
    assert_memory_equal(one.data, three.data, one.size);
    pm_bytes_clear(&one);
    pm_bytes_clear(&three);
    pm_pool_free(pool);
    pm_photon_map_free(map);
}

/* ---- sequences ---- */

static pm_photon_map *make_pass(uint32_t pass)
{
    pm_map_header header = {.paths = 100 + pass,
                            .first_path = (uint64_t)65536 * pass,
                            .pass = pass,
                            .flux_scale = 1,
                            .world_scale = 1,
                            .storage_probability = 1};
    pm_photon *photons = make_photons((pass + 1) * PHOTONS);
    pm_batch batch = {.count = PHOTONS, .photons = photons + (size_t)pass * PHOTONS};
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_build(&header, &batch, 1, NULL, &map, NULL), PM_OK);
    free(photons);
    return map;
}

static pm_bytes make_sequence(uint32_t passes)
{
    pm_bytes file = {0};
    const pm_sink sink = {&file, put};
    for (uint32_t pass = 0; pass < passes; pass++) {
        pm_photon_map *map = make_pass(pass);
        assert_int_equal(pm_photon_map_stream(map, NULL, NULL, &sink, NULL), PM_OK);
        pm_photon_map_free(map);
    }
    assert_int_equal(pm_sequence_end("mkpmap --passes", &sink, NULL), PM_OK);
    return file;
}

static void sequence_is_read_as_one_map_of_all_its_paths(void **state)
{
    (void)state;
    pm_bytes file = make_sequence(3);
    pm_photon_map *map = NULL;
    char *command = NULL;
    assert_int_equal(pm_photon_map_read(file.data, file.size, "s", &map, &command, NULL),
                     PM_OK);
    assert_string_equal(command, "mkpmap --passes");
    assert_int_equal(pm_photon_map_count(map), 3 * PHOTONS);
    assert_int_equal(pm_photon_map_header(map)->paths, 100 + 101 + 102);
    for (size_t i = 1; i < 3 * PHOTONS; i++) {
        pm_photon a, b;
        pm_photon_map_photon(map, i - 1, &a);
        pm_photon_map_photon(map, i, &b);
        assert_true(pm_photon_order(&a, &b) <= 0);
    }
    free(command);
    pm_photon_map_free(map);
    pm_bytes_clear(&file);
}

static void longer_sequence_starts_with_the_shorter_one(void **state)
{
    (void)state;
    pm_bytes two = make_sequence(2), four = make_sequence(4), end = {0};
    const pm_sink sink = {&end, put};
    assert_int_equal(pm_sequence_end("mkpmap --passes", &sink, NULL), PM_OK);
    assert_true(four.size > two.size);
    assert_memory_equal(two.data, four.data, two.size - end.size);
    pm_bytes_clear(&two);
    pm_bytes_clear(&four);
    pm_bytes_clear(&end);
}

/* Cut behind its first pass it is that pass's map; cut anywhere else, or with a wrong bit, it
 * is damaged. */
static void damage_of_a_sequence_is_found(void **state)
{
    (void)state;
    pm_bytes file = make_sequence(3), first = {0};
    pm_photon_map *map = make_pass(0), *again = NULL;
    const pm_sink sink = {&first, put};
    assert_int_equal(pm_photon_map_stream(map, NULL, NULL, &sink, NULL), PM_OK);
    pm_photon_map_free(map);
    for (size_t size = 0; size < file.size; size++) {
        if (size == first.size)
            continue;
        assert_int_not_equal(pm_photon_map_read(file.data, size, "s", &again, NULL, NULL),
                             PM_OK);
    }
    for (size_t i = 0; i < file.size; i += 5) {
        file.data[i] ^= 4;
        assert_int_not_equal(pm_photon_map_read(file.data, file.size, "s", &again, NULL, NULL),
                             PM_OK);
        file.data[i] ^= 4;
    }
    pm_bytes_clear(&first);
    pm_bytes_clear(&file);
}

static void passes_of_two_families_are_no_sequence(void **state)
{
    (void)state;
    pm_bytes file = {0};
    const pm_sink sink = {&file, put};
    pm_photon_map *map = make_map(PHOTONS), *pass = make_pass(1), *again = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_photon_map_stream(map, NULL, NULL, &sink, NULL), PM_OK);
    assert_int_equal(pm_photon_map_stream(pass, NULL, NULL, &sink, NULL), PM_OK);
    assert_int_equal(pm_sequence_end("", &sink, NULL), PM_OK);
    assert_int_equal(pm_photon_map_read(file.data, file.size, "s", &again, NULL, &err),
                     PM_E_MISMATCH);
    pm_bytes_clear(&file);
    pm_photon_map_free(map);
    pm_photon_map_free(pass);
}

/* A header may speak of more photons than its file can hold: no memory is asked for them. */
static void photons_that_a_file_cannot_hold_are_refused_at_once(void **state)
{
    (void)state;
    enum { COUNT_AT = 8 + 4 + 8 + 64 + 16 + 40 + 16 + 24 + 160 };
    pm_photon_map *map = make_map(PHOTONS), *again = NULL;
    pm_bytes file = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_photon_map_write(map, "", &file, NULL), PM_OK);
    uint64_t count = file.size; /* two bytes each at least */
    memcpy(file.data + COUNT_AT, &count, sizeof count);
    uint32_t sum = pm_crc32c(file.data, COUNT_AT + 8);
    memcpy(file.data + COUNT_AT + 8, &sum, sizeof sum);
    assert_int_equal(pm_photon_map_read(file.data, file.size, "s", &again, NULL, &err),
                     PM_E_CORRUPT);
    assert_string_equal(err.text,
                        "is damaged or cut short in its photons; make or fetch it again");
    pm_bytes_clear(&file);
    pm_photon_map_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(map_file_round_trip),
        cmocka_unit_test(map_file_damage_is_found),
        cmocka_unit_test(map_file_of_another_version_is_refused),
        cmocka_unit_test(threads_do_not_change_the_bytes),
        cmocka_unit_test(sequence_is_read_as_one_map_of_all_its_paths),
        cmocka_unit_test(longer_sequence_starts_with_the_shorter_one),
        cmocka_unit_test(damage_of_a_sequence_is_found),
        cmocka_unit_test(passes_of_two_families_are_no_sequence),
        cmocka_unit_test(photons_that_a_file_cannot_hold_are_refused_at_once),
    };
    return cmocka_run_group_tests_name("photons.map_file", tests, NULL, NULL);
}
