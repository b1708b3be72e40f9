#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/maths.h"
#include "fields.h"
#include "photons/bias.h"
#include "photons/ranked.h"

static const pm_vec3 up = {0, 0, 1};

enum { FLOOR = 400000, LEAST = 50, MOST = 500 };
#define FLOOR_DENSITY (FLOOR / (1.8 * 1.8))

static const pm_bandwidth rules[] = {PM_BANDWIDTH_BIAS, PM_BANDWIDTH_CHI2};

static pm_gather_range range_of(pm_bandwidth rule)
{
    return (pm_gather_range){LEAST, MOST, rule};
}

/* ---- order ---- */

static int by_distance(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void expect_ascending(field_make *make, size_t photons, uint32_t wanted, pm_vec3 point)
{
    static pm_candidates found;
    static pm_ranked ranked;
    static double sorted[PM_GATHER_MAX];
    pm_photon_map *map = field_map(make, 7, photons);
    pm_search search = pm_search_volume(map, point);
    search.bound = INFINITY;
    double next2 = pm_search_nearest(&search, wanted, &found);
    pm_ranked_sort(&found, next2, &ranked);
    memcpy(sorted, found.distance2, found.count * sizeof *sorted);
    qsort(sorted, found.count, sizeof *sorted, by_distance);
    assert_int_equal(ranked.count, found.count);
    assert_memory_equal(ranked.distance2, sorted, found.count * sizeof *sorted);
    assert_true(ranked.distance2[ranked.count] == next2);
    for (uint32_t i = 0; i < ranked.count; i++) {
        uint32_t at = 0;
        while (at < found.count && found.index[at] != ranked.index[i])
            at++;
        assert_true(at < found.count && found.distance2[at] == ranked.distance2[i]);
    }
    pm_photon_map_free(map);
}

static void ranked_photons_ascend(void **state)
{
    (void)state;
    expect_ascending(field_floor, 20000, 500, (pm_vec3){.1, .2, -.5});
    expect_ascending(field_caustic, 20000, 5000, (pm_vec3){.2, .1, -.5});
    expect_ascending(field_ball, 3000, 1, (pm_vec3){0, 0, 0});
    /* from its middle all photons of a sphere are equally far, but for rounding */
    expect_ascending(field_sphere, 6000, 5000, (pm_vec3){0, 0, 0});
    expect_ascending(field_point, 2000, 100, (pm_vec3){.3, 0, 0});
    expect_ascending(field_floor, 10, 100, (pm_vec3){.3, 0, 0});
}

/* ---- even light ---- */

/* What a rule makes of even light. */
struct even {
    field_moments density;
    size_t points, chosen; /* where it took fewer than the most */
};

static void add(struct even *even, double density, const pm_estimate *e)
{
    assert_in_range(e->count, LEAST, MOST);
    field_add(&even->density, density);
    even->points++;
    even->chosen += e->count < MOST;
}

/* E_500 is unbiased in even light; E_k for a k that the photons choose is not. But it is chosen
 * at few points, and there E_k, of standard deviation 1 / sqrt(k), is off by less than 3 of
 * them: that is the bias allowed, beside 4 standard errors of the mean. At most a point in 20
 * may choose. */
static void expect_even(const struct even *even, double truth)
{
    double share = (double)even->chosen / (double)even->points;
    double error = sqrt(field_variance(&even->density) / even->density.count);
    double allowed = 4 * error + share * 3 / sqrt(LEAST) * truth;
    assert_true(share < .05);
    if (!(fabs(even->density.mean - truth) <= allowed))
        fail_msg("density %.6g instead of %.6g, allowed %.2g", even->density.mean, truth,
                 allowed);
}

static void even_light_is_estimated_right(void **state)
{
    (void)state;
    enum { SIDE = 20, MAPS = 3 }; /* so far apart that no photon counts at two points */
    for (int r = 0; r < 2; r++) {
        const pm_gather_range range = range_of(rules[r]);
        struct even even = {0};
        for (unsigned i = 0; i < MAPS * SIDE * SIDE; i++) {
            static pm_photon_map *map;
            unsigned x = i % SIDE, y = i / SIDE % SIDE;
            pm_vec3 p = {1.6 * (x + .5) / SIDE - .8, 1.6 * (y + .5) / SIDE - .8, -.5};
            if (x + y == 0) {
                pm_photon_map_free(map);
                map = field_map(field_floor, i, FLOOR);
            }
            pm_estimate e = pm_photon_map_adapted(map, p, up, &range, PM_PHOTONS_ALL, NULL);
            add(&even, e.irradiance.g, &e);
            if (i + 1 == MAPS * SIDE * SIDE) {
                pm_photon_map_free(map);
                map = NULL;
            }
        }
        expect_even(&even, FLOOR_DENSITY);
    }
}

/* Isotropic scattering: each photon weighs 1 / (4 pi). */
static void even_mist_is_estimated_right(void **state)
{
    (void)state;
    enum { PHOTONS = 600000, SIDE = 6 };
    pm_photon_map *map = field_map(field_ball, 3, PHOTONS);
    double truth = PHOTONS / (4 * PM_PI / 3 * .8 * .8 * .8) / (4 * PM_PI);
    for (int r = 0; r < 2; r++) {
        const pm_gather_range range = range_of(rules[r]);
        struct even even = {0};
        for (unsigned i = 0; i < SIDE * SIDE * SIDE; i++) {
            pm_vec3 p = {.13 * (i % SIDE) - .325, .13 * (i / SIDE % SIDE) - .325,
                         .13 * (i / SIDE / SIDE) - .325};
            pm_estimate e = pm_photon_map_volume_adapted(map, p, up, 0, &range);
            add(&even, e.irradiance.g, &e);
        }
        expect_even(&even, truth);
    }
    pm_photon_map_free(map);
}

/* ---- light that changes ---- */

/* All photons in the half x > 0 of the floor. */
static void field_step(pm_rng *rng, size_t i, pm_photon_record *out)
{
    field_floor(rng, i, out);
    out->position.x = fabs(out->position.x);
}

/* 2000 photons of the bright half reach .05, so a point .012 beside the edge loses four tenths
 * of its light to the dark by then, and a point as far in the dark sees only what is beyond the
 * edge. Both take fewer than a point in the middle, and in the light the estimate is nearer to
 * the truth than that of all 2000. */
static void few_photons_are_taken_beside_an_edge(void **state)
{
    (void)state;
    enum { POINTS = 30 };
    pm_photon_map *map = field_map(field_step, 1, FLOOR);
    for (int r = 0; r < 2; r++) {
        const uint32_t most = 2000;
        const pm_gather_range range = {LEAST, most, rules[r]};
        double dark = 0, bright = 0, plain = 0, middle = 0, truth = 2 * FLOOR_DENSITY;
        double error = 0, plain_error = 0;
        for (int i = 0; i < POINTS; i++) {
            double y = .05 * i - .75;
            const pm_vec3 at[3] = {{-.012, y, -.5}, {.012, y, -.5}, {.4, y, -.5}};
            pm_estimate e[3];
            for (int k = 0; k < 3; k++)
                e[k] = pm_photon_map_adapted(map, at[k], up, &range, PM_PHOTONS_ALL, NULL);
            pm_estimate all =
                pm_photon_map_nearest(map, at[1], up, most, INFINITY, PM_PHOTONS_ALL, NULL);
            dark += e[0].count;
            bright += e[1].count;
            middle += e[2].count;
            plain += all.count;
            error += pow(e[1].irradiance.g / truth - 1, 2);
            plain_error += pow(all.irradiance.g / truth - 1, 2);
        }
        assert_true(dark / POINTS < 2 * LEAST);
        assert_true(bright / POINTS < .85 * most);
        assert_true(middle / POINTS > .95 * most);
        assert_true(error < .9 * plain_error);
        assert_true(plain == POINTS * most);
    }
    pm_photon_map_free(map);
}

/* ---- ends of the range ---- */

static void expect_same(const pm_estimate *a, const pm_estimate *b)
{
    const double near = 1e-12; /* sums in another order */
    assert_int_equal(a->count, b->count);
    assert_true(fabs(a->radius - b->radius) <= near * b->radius);
    assert_true(fabs(a->irradiance.r - b->irradiance.r) <= near * b->irradiance.r);
    assert_true(fabs(a->irradiance.g - b->irradiance.g) <= near * b->irradiance.g);
    assert_true(fabs(a->variance.r - b->variance.r) <= near * b->variance.r);
}

static void a_range_of_one_count_is_that_count(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_caustic, 1, 20000);
    for (int r = 0; r < 2; r++)
        for (uint32_t k = 1; k < 3000; k = 3 * k + 1) {
            const pm_gather_range range = {k, k, rules[r]};
            pm_vec3 p = {.2, .11, -.5};
            pm_estimate e = pm_photon_map_adapted(map, p, up, &range, PM_PHOTONS_ALL, NULL);
            pm_estimate want =
                pm_photon_map_nearest(map, p, up, k, INFINITY, PM_PHOTONS_ALL, NULL);
            expect_same(&e, &want);
        }
    pm_photon_map_free(map);
}

static void maps_of_few_photons_give_what_they_have(void **state)
{
    (void)state;
    static field_make *const fields[] = {field_floor, field_point};
    for (int f = 0; f < 2; f++)
        for (size_t photons = 0; photons < 70; photons += 23) {
            pm_photon_map *map = field_map(fields[f], 1, photons);
            for (int r = 0; r < 2; r++) {
                const pm_gather_range range = range_of(rules[r]);
                pm_vec3 p = {.2, .1, -.5};
                pm_estimate e = pm_photon_map_adapted(map, p, up, &range, PM_PHOTONS_ALL, NULL);
                pm_estimate v = pm_photon_map_volume_adapted(map, p, up, .5, &range);
                assert_true(e.count <= photons && v.count <= photons);
                assert_true(pm_rgb_finite(e.irradiance) && pm_rgb_finite(v.irradiance));
                if (photons < LEAST) {
                    pm_estimate want = pm_photon_map_nearest(map, p, up, LEAST, INFINITY,
                                                             PM_PHOTONS_ALL, NULL);
                    expect_same(&e, &want);
                }
            }
            pm_photon_map_free(map);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranked_photons_ascend),
        cmocka_unit_test(even_light_is_estimated_right),
        cmocka_unit_test(even_mist_is_estimated_right),
        cmocka_unit_test(few_photons_are_taken_beside_an_edge),
        cmocka_unit_test(a_range_of_one_count_is_that_count),
        cmocka_unit_test(maps_of_few_photons_give_what_they_have),
    };
    return cmocka_run_group_tests_name("photons.bias", tests, NULL, NULL);
}
