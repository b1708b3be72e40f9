#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"
#include "photons/precompute.h"

static const pm_vec3 up = {0, 0, 1};

static pm_photon_map *precompute(const pm_photon_map *global, uint32_t gather_count,
                                 double fraction, pm_pool *pool)
{
    const pm_precompute how = {.gather_count = gather_count, .fraction = fraction, .seed = 5};
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_precompute(global, &how, pool, NULL, NULL, &map, NULL),
                     PM_OK);
    assert_int_equal(pm_photon_map_header(map)->kind, PM_MAP_PRECOMPUTED);
    return map;
}

/* ---- what is kept ---- */

/* Off by half a unit, 2^-20 of the power of two above the largest channel at most. */
static void assert_stored(pm_rgb got, pm_rgb want)
{
    double step = 0x1p-20 * pm_rgb_max(want);
    assert_true(fabs(got.r - want.r) <= step);
    assert_true(fabs(got.g - want.g) <= step);
    assert_true(fabs(got.b - want.b) <= step);
}

static void precomputed_is_the_estimate_at_the_same_points(void **state)
{
    (void)state;
    static field_make *const fields[] = {field_floor, field_room, field_sphere, field_caustic};
    for (int f = 0; f < 4; f++) {
        pm_photon_map *global = field_map(fields[f], 1, 20000);
        pm_photon_map *map = precompute(global, 50, .1, NULL);
        assert_int_equal(pm_photon_map_count(map), 2000);
        for (size_t i = 0; i < pm_photon_map_count(map); i++) {
            pm_photon photon;
            pm_photon_map_photon(map, i, &photon);
            pm_vec3 point = pm_photon_position(&photon), normal = pm_photon_normal(&photon);
            pm_estimate want = pm_photon_map_nearest(global, point, normal, 50, INFINITY,
                                                     PM_PHOTONS_ALL, NULL);
            pm_estimate asked = pm_photon_map_precomputed(map, point, normal);
            assert_stored(pm_precomputed_irradiance(map, &photon), want.irradiance);
            assert_stored(asked.irradiance, want.irradiance);
            assert_true(asked.radius == 0);
            /* the deviation is kept to half a power of 2^-1/2, the variance to one */
            double kept = pm_rgb_max(asked.variance) / pm_rgb_max(want.variance);
            assert_true(kept > .7 && kept < 1.42);
        }
        pm_photon_map_free(map);
        pm_photon_map_free(global);
    }
}

static void batches_of_precomputed_look_ups_have_the_bytes_of_single_ones(void **state)
{
    (void)state;
    enum { QUERIES = 1000 };
    pm_photon_map *global = field_map(field_room, 1, 20000);
    pm_photon_map *map = precompute(global, 50, .1, NULL);
    pm_photon_query queries[QUERIES];
    pm_estimate out[QUERIES];
    for (size_t i = 0; i < QUERIES; i++) {
        pm_photon photon;
        pm_photon_map_photon(global, 20 * i, &photon);
        queries[i] = (pm_photon_query){.point = pm_photon_position(&photon),
                                       .normal = pm_photon_normal(&photon),
                                       .radius = i % 50 ? INFINITY : 0x1p-30};
    }
    pm_photon_map_precomputed_batch(map, queries, QUERIES, out);
    for (size_t i = 0; i < QUERIES; i++) {
        pm_estimate one = pm_photon_map_precomputed(map, queries[i].point, queries[i].normal);
        if (i % 50 || out[i].count)
            assert_memory_equal(&one.irradiance, &out[i].irradiance, sizeof one.irradiance);
        assert_true(i % 50 == 0 || out[i].count == one.count);
    }
    pm_photon_map_free(map);
    pm_photon_map_free(global);
}

static bool same_place(const pm_photon *a, const pm_photon *b)
{
    return !memcmp(a->position, b->position, sizeof a->position);
}

/* Kept photon i is one of stretch i of the stored order. */
static void each_stretch_keeps_one(void **state)
{
    (void)state;
    enum { PHOTONS = 1000 };
    static const double fractions[] = {1, .25, .3, .0017, 1e-9};
    static const size_t kept[] = {1000, 250, 300, 1, 1};
    pm_photon_map *global = field_map(field_room, 1, PHOTONS);
    for (int f = 0; f < 5; f++) {
        pm_photon_map *map = precompute(global, 5, fractions[f], NULL);
        assert_int_equal(pm_photon_map_count(map), kept[f]);
        double stretch = (double)PHOTONS / (double)kept[f];
        for (size_t i = 0; i < kept[f]; i++) {
            pm_photon photon, old;
            bool found = false;
            pm_photon_map_photon(map, i, &photon);
            for (size_t k = (size_t)((double)i * stretch);
                 k < (size_t)((double)(i + 1) * stretch + 1) && k < PHOTONS; k++) {
                pm_photon_map_photon(global, k, &old);
                found = found || same_place(&photon, &old);
            }
            assert_true(found);
        }
        pm_photon_map_free(map);
    }
    pm_photon_map_free(global);
}

static void precomputed_bytes_do_not_depend_on_threads(void **state)
{
    (void)state;
    pm_photon_map *global = field_map(field_caustic, 1, 50000);
    pm_bytes one = {0};
    for (unsigned threads = 1; threads < 5; threads += 2) {
        pm_pool *pool = pm_pool_new(threads);
        pm_bytes bytes = {0};
        pm_photon_map *map = precompute(global, 20, .3, pool);
        assert_int_equal(pm_photon_map_write(map, NULL, &bytes, NULL), PM_OK);
        if (threads == 1) {
            one = bytes;
        } else {
            assert_int_equal(bytes.size, one.size);
            assert_memory_equal(bytes.data, one.data, one.size);
            pm_bytes_clear(&bytes);
        }
        pm_photon_map_free(map);
        pm_pool_free(pool);
    }
    pm_bytes_clear(&one);
    pm_photon_map_free(global);
}

static void files_of_precomputed_maps_give_them_back(void **state)
{
    (void)state;
    pm_photon_map *global = field_map(field_room, 1, 5000), *read = NULL;
    pm_photon_map *map = precompute(global, 20, .3, NULL);
    pm_bytes bytes = {0};
    assert_int_equal(pm_photon_map_write(map, "mkpmap", &bytes, NULL), PM_OK);
    assert_int_equal(pm_photon_map_read(bytes.data, bytes.size, "map", &read, NULL, NULL),
                     PM_OK);
    assert_int_equal(pm_photon_map_header(read)->kind, PM_MAP_PRECOMPUTED);
    assert_int_equal(pm_photon_map_count(read), pm_photon_map_count(map));
    for (size_t i = 0; i < pm_photon_map_count(map); i++) {
        pm_photon a, b;
        pm_photon_map_photon(map, i, &a);
        pm_photon_map_photon(read, i, &b);
        assert_memory_equal(&a, &b, sizeof a);
    }
    pm_bytes_clear(&bytes);
    pm_photon_map_free(read);
    pm_photon_map_free(map);
    pm_photon_map_free(global);
}

/* ---- what is looked up ---- */

/* Look-ups at places that have nothing to do with the photons. An estimate at a photon counts
 * that one, which makes it 1 / (K - 1) too great; but the place was closest to it because no
 * other kept photon is nearer, which costs one photon again if the estimate's disc holds that
 * empty neighbourhood, of 1 / fraction photons; else less. So the bias is between nothing and
 * 1 / (K - 1). Photons within about a look-up's radius share their noise, so the mean's is that
 * of `islands` independent estimates, each of relative variance 1 / K: 5 sigma of it. */
static void even_light_is_precomputed_right(void **state)
{
    (void)state;
    enum { PHOTONS = 200000, MAPS = 4, POINTS = 20000, GATHER = 50 };
    static const double fractions[] = {1, .25, .05};
    const double truth = PHOTONS / (1.8 * 1.8);
    for (int f = 0; f < 3; f++) {
        field_moments density = {0};
        for (uint64_t seed = 1; seed <= MAPS; seed++) {
            pm_photon_map *global = field_map(field_floor, seed, PHOTONS);
            pm_photon_map *map = precompute(global, GATHER, fractions[f], NULL);
            pm_rng rng;
            pm_rng_init(&rng, 100 + seed, PM_RNG_PATH, 0);
            for (int i = 0; i < POINTS; i++) {
                pm_vec3 p = {field_uniform(&rng, -.8, .8), 0, -.5};
                p.y = field_uniform(&rng, -.8, .8);
                field_add(&density, pm_photon_map_precomputed(map, p, up).irradiance.g);
            }
            pm_photon_map_free(map);
            pm_photon_map_free(global);
        }
        double islands = MAPS * PHOTONS * (1.6 * 1.6) / (1.8 * 1.8) / GATHER;
        double bias = fractions[f] * GATHER > 10 ? .1 / GATHER : 1. / (GATHER - 1);
        double allowed = 5 / sqrt(GATHER * islands) + bias;
        if (!(fabs(density.mean / truth - 1) <= allowed))
            fail_msg("fraction %g: %+.4f, allowed %.4f", fractions[f], density.mean / truth - 1,
                     allowed);
    }
}

/* A wall without thickness: blue flux falls on its lower face alone. */
static void field_two_faces(pm_rng *rng, size_t i, pm_photon_record *out)
{
    field_floor(rng, i, out);
    out->normal.z = i & 1 ? -1 : 1;
}

static void faces_of_a_thin_wall_stay_apart(void **state)
{
    (void)state;
    pm_photon_map *global = field_map(field_two_faces, 1, 20000);
    pm_photon_map *map = precompute(global, 20, .25, NULL);
    for (int i = 0; i < 100; i++) {
        pm_vec3 p = {.017 * i - .85, .3, -.5};
        pm_rgb above = pm_photon_map_precomputed(map, p, up).irradiance;
        pm_rgb below = pm_photon_map_precomputed(map, p, pm_vec3_negate(up)).irradiance;
        assert_true(above.g > 0 && above.b == 0 && below.b > 0);
        assert_int_equal(pm_photon_map_precomputed(map, p, (pm_vec3){1, 0, 0}).count, 0);
    }
    pm_photon_map_free(map);
    pm_photon_map_free(global);
}

static void maps_of_no_or_crowded_photons_are_precomputed(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, 300};
    for (int i = 0; i < 3; i++) {
        pm_photon_map *global = field_map(field_point, 1, counts[i]);
        pm_photon_map *map = precompute(global, 50, .5, NULL);
        pm_estimate e = pm_photon_map_precomputed(map, (pm_vec3){.3, .2, .1}, up);
        assert_true(pm_rgb_finite(e.irradiance) && pm_rgb_finite(e.variance));
        pm_photon_map_free(map);
        pm_photon_map_free(global);
    }
}

static bool is_cancelled(void *context)
{
    return --*(int *)context < 0;
}

static void precomputing_can_be_cancelled(void **state)
{
    (void)state;
    const pm_precompute how = {.gather_count = 10, .fraction = 1};
    pm_photon_map *global = field_map(field_floor, 1, 40000), *map = NULL;
    int asked = 1;
    assert_int_equal(
        pm_photon_map_precompute(global, &how, NULL, is_cancelled, &asked, &map, NULL),
        PM_E_CANCELLED);
    assert_null(map);
    pm_photon_map_free(global);
}

static void families_tell_maps_apart(void **state)
{
    (void)state;
    pm_digest global = pm_digest_of("a", 1), other = pm_digest_of("b", 1);
    const pm_digest all[] = {pm_precompute_family(&global, 1000, 50, .25),
                             pm_precompute_family(&other, 1000, 50, .25),
                             pm_precompute_family(&global, 1001, 50, .25),
                             pm_precompute_family(&global, 1000, 51, .25),
                             pm_precompute_family(&global, 1000, 50, .2501)};
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 5; k++)
            assert_true(pm_digest_equal(&all[i], &all[k]) == (i == k));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(precomputed_is_the_estimate_at_the_same_points),
        cmocka_unit_test(batches_of_precomputed_look_ups_have_the_bytes_of_single_ones),
        cmocka_unit_test(each_stretch_keeps_one),
        cmocka_unit_test(precomputed_bytes_do_not_depend_on_threads),
        cmocka_unit_test(files_of_precomputed_maps_give_them_back),
        cmocka_unit_test(even_light_is_precomputed_right),
        cmocka_unit_test(faces_of_a_thin_wall_stay_apart),
        cmocka_unit_test(maps_of_no_or_crowded_photons_are_precomputed),
        cmocka_unit_test(precomputing_can_be_cancelled),
        cmocka_unit_test(families_tell_maps_apart),
    };
    return cmocka_run_group_tests_name("photons.precompute", tests, NULL, NULL);
}
