#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"

static void assert_same_map(const pm_photon_map *a, const pm_photon_map *b)
{
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->node_count, b->node_count);
    assert_memory_equal(a->blocks, b->blocks, a->block_count * sizeof *a->blocks);
    assert_memory_equal(a->nodes, b->nodes, a->node_count * sizeof *a->nodes);
    assert_memory_equal(&a->flux_sum, &b->flux_sum, sizeof a->flux_sum);
}

/* The photons cut into batches at `cuts` places, in the order given by `step`. */
static pm_photon_map *map_in_batches(pm_photon *photons, size_t count, size_t pieces,
                                     size_t step, pm_pool *pool)
{
    pm_map_header header = {.paths = 1, .flux_scale = 1, .world_scale = 1};
    pm_batch *batches = calloc(pieces, sizeof *batches);
    for (size_t i = 0; i < pieces; i++) {
        size_t k = i * step % pieces, first = k * count / pieces;
        batches[i].photons = photons + first;
        batches[i].count = (k + 1) * count / pieces - first;
    }
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_build(&header, batches, pieces, pool, &map, NULL), PM_OK);
    free(batches);
    return map;
}

static void map_bytes_do_not_depend_on_batches_or_threads(void **state)
{
    (void)state;
    enum { COUNT = 200000 };
    pm_photon *photons = field_photons(field_room, 1, COUNT);
    pm_photon_map *first = map_in_batches(photons, COUNT, 1, 1, NULL);
    for (unsigned threads = 1; threads < 8; threads += 3) {
        pm_pool *pool = pm_pool_new(threads);
        pm_photon_map *map = map_in_batches(photons, COUNT, 37, 5 + threads, pool);
        assert_same_map(first, map);
        pm_photon_map_free(map);
        pm_pool_free(pool);
    }
    pm_photon_map_free(first);
    free(photons);
}

static void map_gives_back_each_photon_in_stored_order(void **state)
{
    (void)state;
    for (size_t count = 0; count < 100; count += 9) {
        pm_photon *photons = field_photons(field_sphere, count, count);
        pm_photon_map *map = field_map_of(photons, count);
        qsort(photons, count, sizeof *photons, pm_photon_order);
        assert_int_equal(pm_photon_map_count(map), count);
        for (size_t i = 0; i < count; i++) {
            pm_photon photon;
            pm_photon_map_photon(map, i, &photon);
            assert_memory_equal(&photon, &photons[i], sizeof photon);
        }
        pm_photon_map_free(map);
        free(photons);
    }
}

static void photon_takes_at_most_25_bytes(void **state)
{
    (void)state;
    enum { COUNT = 1000000 };
    pm_photon *photons = field_photons(field_room, 1, COUNT);
    struct mallinfo2 before = mallinfo2();
    pm_photon_map *map = map_in_batches(photons, COUNT, 16, 1, NULL);
    struct mallinfo2 after = mallinfo2();
    size_t taken = after.uordblks + after.hblkhd - before.uordblks - before.hblkhd;
    assert_true(pm_photon_map_bytes(map) <= 25 * COUNT);
    assert_true(taken <= 25 * COUNT); /* 0 where a sanitizer owns malloc */
    assert_true(taken == 0 || taken >= pm_photon_map_bytes(map));
    pm_photon_map_free(map);
    free(photons);
}

/* A line of /proc/self/status, in bytes; 0 where there is none. */
static double memory_line(const char *name)
{
    char line[256];
    double kilobytes = 0;
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file))
        if (!strncmp(line, name, strlen(name)))
            kilobytes = strtod(line + strlen(name) + 1, NULL);
    if (file)
        fclose(file);
    return 1024 * kilobytes;
}

/* From here on VmHWM is the peak since now. */
static bool forget_peak(void)
{
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file)
        return false;
    bool written = fputs("5", file) >= 0;
    return !fclose(file) && written;
}

static void building_takes_at_most_25_bytes_a_photon(void **state)
{
    (void)state;
    enum { COUNT = 4000000, OTHER_BYTES = 1 << 20 }; /* stacks, code, what malloc keeps */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* their shadow memory counts */
#endif
    pm_map_header header = {.paths = 1, .flux_scale = 1, .world_scale = 1};
    pm_photon *photons = field_photons(field_room, 1, COUNT);
    pm_photon_list list = {0};
    pm_photon_map *map = NULL;
    pm_pool *pool = pm_pool_new(2);
    if (!forget_peak())
        skip();
    double before = memory_line("VmRSS:");
    assert_int_equal(pm_photon_list_reserve(&list, COUNT, NULL), PM_OK);
    assert_int_equal(pm_photon_list_append(&list, photons, COUNT, NULL), PM_OK);
    assert_int_equal(pm_photon_map_take(&header, &list, pool, &map, NULL), PM_OK);
    assert_true(memory_line("VmHWM:") - before <= 25. * COUNT + OTHER_BYTES);
    pm_photon_map_free(map);
    pm_pool_free(pool);
    free(photons);
}

static void mean_flux_is_in_scene_units(void **state)
{
    (void)state;
    pm_photon *photons = field_photons(field_floor, 1, 3);
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += pm_photon_flux(&photons[i]).r;
    pm_map_header header = {.paths = 10, .flux_scale = .5, .world_scale = 4};
    pm_batch batch = {.count = 3, .photons = photons};
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_build(&header, &batch, 1, NULL, &map, NULL), PM_OK);
    double mean = sum / 3 * .5 / 10 * 16; /* W / scale^2 a path, times scale^2 */
    assert_true(fabs(pm_photon_map_mean_flux(map).r - mean) <= 1e-15 * mean);
    pm_photon_map_free(map);
    free(photons);
}

static void empty_map_keeps_its_note(void **state)
{
    (void)state;
    pm_map_header header = {.kind = PM_MAP_CAUSTIC, .note = "no specular surface"};
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_build(&header, NULL, 0, NULL, &map, NULL), PM_OK);
    assert_string_equal(pm_photon_map_header(map)->note, "no specular surface");
    assert_int_equal(pm_photon_map_count(map), 0);
    assert_true(pm_photon_map_mean_flux(map).r == 0);
    pm_photon_map_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(map_bytes_do_not_depend_on_batches_or_threads),
        cmocka_unit_test(map_gives_back_each_photon_in_stored_order),
        cmocka_unit_test(photon_takes_at_most_25_bytes),
        cmocka_unit_test(building_takes_at_most_25_bytes_a_photon),
        cmocka_unit_test(mean_flux_is_in_scene_units),
        cmocka_unit_test(empty_map_keeps_its_note),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
