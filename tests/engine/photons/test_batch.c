#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"
#include "photons/search.h"

/* The bytes of look-ups do not depend on how they are put together, nor on the machine. */

enum { PHOTONS = 20000, QUERIES = 1500 };

struct answers {
    pm_estimate within[QUERIES], nearest[QUERIES];
    size_t closest[QUERIES];
};

static pm_rgb from_above(const void *context, const pm_photon *photon)
{
    (void)context;
    pm_vec3 wi = pm_photon_direction(photon);
    return pm_rgb_grey(wi.z * wi.z);
}

static const pm_photon_weight weight = {from_above, NULL};

/* Near photons in stored order, then anywhere; some with a weight, or far outside. */
static void make_queries(const pm_photon_map *map, pm_photon_query queries[QUERIES])
{
    pm_rng rng;
    pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
    for (size_t i = 0; i < QUERIES; i++) {
        bool sorted = i < QUERIES / 2;
        pm_photon photon;
        size_t k = sorted ? i * PHOTONS / (QUERIES / 2) : pm_rng_u32(&rng) % PHOTONS;
        pm_photon_map_photon(map, k, &photon);
        queries[i].point =
            pm_vec3_madd(pm_photon_position(&photon), .003, field_direction(&rng));
        queries[i].normal = i % 5 ? pm_photon_normal(&photon) : field_direction(&rng);
        queries[i].radius = i % 7 ? .05 : i % 4 ? .001 : .9;
        queries[i].weight = i % 11 ? NULL : &weight;
        if (i % 101 == 0)
            queries[i].point = pm_vec3_scale(queries[i].point, i % 2 ? 3 : 1000);
    }
}

/* Bytes of padding are no part of an answer. */
static void assert_same_estimate(const pm_estimate *a, const pm_estimate *b)
{
    assert_memory_equal(&a->irradiance, &b->irradiance, sizeof a->irradiance);
    assert_memory_equal(&a->variance, &b->variance, sizeof a->variance);
    assert_memory_equal(&a->radius, &b->radius, sizeof a->radius);
    assert_int_equal(a->count, b->count);
}

static void assert_same_answers(const struct answers *a, const struct answers *b)
{
    for (size_t i = 0; i < QUERIES; i++) {
        assert_same_estimate(&a->within[i], &b->within[i]);
        assert_same_estimate(&a->nearest[i], &b->nearest[i]);
        assert_true(a->closest[i] == b->closest[i]);
    }
}

static void ask(const pm_photon_map *map, const pm_photon_query *queries, size_t step,
                pm_photon_filter filter, struct answers *out)
{
    for (size_t i = 0; i < QUERIES; i += step) {
        size_t count = QUERIES - i < step ? QUERIES - i : step;
        pm_photon_map_within_batch(map, queries + i, count, filter, out->within + i);
        pm_photon_map_nearest_batch(map, queries + i, count, 40, filter, out->nearest + i);
        pm_photon_map_closest_batch(map, queries + i, count, out->closest + i);
    }
}

static const struct field {
    field_make *make;
    pm_photon_filter filter;
} fields[] = {{field_room, PM_PHOTONS_ALL},
              {field_sphere, PM_PHOTONS_NOT_SPECULAR},
              {field_caustic, PM_PHOTONS_SPECULAR},
              {field_point, PM_PHOTONS_ALL}};

static void each_field(void (*check)(pm_photon_map *, const pm_photon_query *, pm_photon_filter,
                                     struct answers *, struct answers *))
{
    pm_photon_query *queries = malloc(QUERIES * sizeof *queries);
    struct answers *a = malloc(sizeof *a), *b = malloc(sizeof *b);
    assert_true(queries && a && b);
    for (size_t f = 0; f < sizeof fields / sizeof *fields; f++) {
        pm_photon_map *map = field_map(fields[f].make, f, PHOTONS);
        make_queries(map, queries);
        check(map, queries, fields[f].filter, a, b);
        pm_photon_map_free(map);
    }
    free(queries);
    free(a);
    free(b);
}

static void check_steps(pm_photon_map *map, const pm_photon_query *queries,
                        pm_photon_filter filter, struct answers *a, struct answers *b)
{
    ask(map, queries, 1, filter, a);
    ask(map, queries, 5, filter, b);
    assert_same_answers(a, b);
    ask(map, queries, QUERIES, filter, b);
    assert_same_answers(a, b);
}

static void batches_have_the_bytes_of_single_calls(void **state)
{
    (void)state;
    each_field(check_steps);
}

/* Instruction sets that this machine lacks are left out. */
static void check_kernels(pm_photon_map *map, const pm_photon_query *queries,
                          pm_photon_filter filter, struct answers *a, struct answers *b)
{
    const pm_kernel *kernels[] = {&pm_kernel_avx2, &pm_kernel_avx512}, *best = map->kernel;
    map->kernel = &pm_kernel_sse2;
    ask(map, queries, QUERIES, filter, a);
    for (size_t k = 0; k < 2 && map->kernel != best; k++) {
        map->kernel = kernels[k];
        ask(map, queries, QUERIES, filter, b);
        assert_same_answers(a, b);
    }
}

static void instruction_sets_give_the_same_bytes(void **state)
{
    (void)state;
    each_field(check_kernels);
}

/* A room of which one half is so faint that squares of fluxes are too small for a float, with
 * some photons before two of its walls. Points lie exactly in the walls, then each third one a
 * grid unit off: alone they see flat blocks, in groups they do not. */
static void points_in_planes_have_the_same_bytes(void **state)
{
    (void)state;
    pm_photon *photons = field_photons(field_room, 5, PHOTONS);
    for (size_t i = 0; i < PHOTONS; i++) {
        photons[i].position[1] += i % 8 ? 0 : UINT32_C(1) << 22;
        if (photons[i].position[0] < UINT32_C(1) << 31)
            photons[i].exponent = (uint8_t)(photons[i].exponent - 84);
    }
    pm_photon_map *map = field_map_of(photons, PHOTONS);
    pm_photon_query *queries = malloc(QUERIES * sizeof *queries);
    struct answers *a = malloc(sizeof *a), *b = malloc(sizeof *b);
    assert_true(queries && a && b);
    for (unsigned off = 0; off < 2; off++) {
        for (size_t i = 0; i < QUERIES; i++) {
            pm_photon photon;
            pm_photon_map_photon(map, i * PHOTONS / QUERIES, &photon);
            pm_vec3 n = pm_photon_normal(&photon), p = pm_photon_position(&photon);
            p = pm_vec3_madd(p, off && i % 3 == 0 ? 0x1p-31 : 0, n);
            queries[i] = (pm_photon_query){.point = p, .normal = n, .radius = .05};
        }
        check_steps(map, queries, PM_PHOTONS_ALL, a, b);
        check_kernels(map, queries, PM_PHOTONS_ALL, a, b);
    }
    free(a);
    free(b);
    free(queries);
    free(photons);
    pm_photon_map_free(map);
}

/* Photons on both faces of a floor: those of the other one are
 * never counted, in whatever group. */
static void batches_do_not_see_the_other_face(void **state)
{
    (void)state;
    pm_photon *photons = field_photons(field_floor, 1, PHOTONS);
    for (size_t i = 0; i < PHOTONS; i += 2)
        photons[i].normal[0] = photons[i].normal[1] = 0; /* down */
    pm_photon_map *map = field_map_of(photons, PHOTONS);
    pm_photon_query *queries = malloc(QUERIES * sizeof *queries);
    struct answers *a = malloc(sizeof *a);
    size_t count[2] = {0, 0};
    for (size_t i = 0; i < QUERIES; i++)
        queries[i] = (pm_photon_query){.point = {-.8 + 1.6 * (double)i / QUERIES, .1, -.5},
                                       .normal = {0, 0, i % 2 ? 1 : -1},
                                       .radius = .1};
    ask(map, queries, QUERIES, PM_PHOTONS_ALL, a);
    for (size_t i = 0; i < QUERIES; i++) {
        pm_photon photon;
        count[i % 2] += a->within[i].count;
        assert_true(a->closest[i] != SIZE_MAX);
        pm_photon_map_photon(map, a->closest[i], &photon);
        assert_true(pm_photon_normal(&photon).z == queries[i].normal.z);
    }
    /* PHOTONS / 2 * .01 pi / 3.24 = 97 on each side, some 10 more or less at one place */
    assert_true(count[0] > 90 * QUERIES / 2 && count[0] < 104 * QUERIES / 2);
    assert_true(count[1] > 90 * QUERIES / 2 && count[1] < 104 * QUERIES / 2);
    free(a);
    free(queries);
    free(photons);
    pm_photon_map_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_have_the_bytes_of_single_calls),
        cmocka_unit_test(instruction_sets_give_the_same_bytes),
        cmocka_unit_test(points_in_planes_have_the_same_bytes),
        cmocka_unit_test(batches_do_not_see_the_other_face),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
