#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/maths.h"
#include "fields.h"

/* Searches against a plain loop over all photons, written from the header's words alone. */

struct found {
    double distance2;
    size_t index;
};

struct query {
    pm_vec3 point, normal;
    pm_photon_filter filter;
    uint32_t gather_count;
    double max_radius;
};

static int by_distance(const void *a, const void *b)
{
    const struct found *p = a, *q = b;
    if (p->distance2 != q->distance2)
        return p->distance2 < q->distance2 ? -1 : 1;
    return p->index < q->index ? -1 : 1;
}

static bool counts(const pm_photon *photon, const struct query *q)
{
    bool specular = photon->flags & PM_PHOTON_SPECULAR;
    if (q->filter != PM_PHOTONS_ALL && specular != (q->filter == PM_PHOTONS_SPECULAR))
        return false;
    pm_vec3 normal = pm_photon_normal(photon);
    pm_vec3 d = pm_vec3_sub(pm_photon_position(photon), q->point);
    double h = fabs(pm_vec3_dot(pm_vec3_add(normal, q->normal), d)) / 2;
    return pm_vec3_dot(normal, q->normal) >= .5 && h <= pm_vec3_length(d) / 4 + 0x1p-30;
}

/* The photons that count, nearest first. */
static size_t brute_force(const pm_photon_map *map, const struct query *q, struct found *out)
{
    size_t count = 0;
    for (size_t i = 0; i < pm_photon_map_count(map); i++) {
        pm_photon photon;
        pm_photon_map_photon(map, i, &photon);
        pm_vec3 d = pm_vec3_sub(pm_photon_position(&photon), q->point);
        double distance2 = pm_vec3_dot(d, d);
        if (distance2 <= q->max_radius * q->max_radius && counts(&photon, q))
            out[count++] = (struct found){distance2, i};
    }
    qsort(out, count, sizeof *out, by_distance);
    return count;
}

static pm_rgb flux_of(const pm_photon_map *map, const struct found *found, size_t count)
{
    pm_rgb sum = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        pm_photon photon;
        pm_photon_map_photon(map, found[i].index, &photon);
        sum = pm_rgb_add(sum, pm_photon_flux(&photon));
    }
    return sum;
}

/* Distances are floats: 2^-20 covers the area of their radius. */
static void assert_close(double a, double b, double slack)
{
    assert_true(fabs(a - b) <= 0x1p-20 * fabs(b) + slack);
}

/* Fluxes are small whole numbers here, so sums are exact in any order. */
static void assert_estimate(pm_estimate e, pm_rgb flux, size_t count, double radius,
                            double slack)
{
    double area = PM_PI * radius * radius;
    assert_int_equal(e.count, count);
    if (!count) {
        assert_true(e.irradiance.r == 0 && e.irradiance.g == 0 && e.irradiance.b == 0);
        return;
    }
    assert_close(e.radius, radius, 0);
    assert_close(e.irradiance.r * area, flux.r, slack);
    assert_close(e.irradiance.g * area, flux.g, slack);
    assert_close(e.irradiance.b * area, flux.b, slack);
}

/* What photons at nearly the distance of found[at] may change: floats do not tell which is
 * nearer. They carry 1 to 3 in a channel, or 0 to 2. */
static double tie_slack(const struct found *found, size_t count, size_t at)
{
    size_t near = 0;
    for (size_t i = 0; i < count; i++)
        near += i != at && found[i].distance2 != found[at].distance2 &&
                fabs(found[i].distance2 - found[at].distance2) <= 0x1p-21 * found[at].distance2;
    return 2.0 * (double)near;
}

static void check_nearest(const pm_photon_map *map, const struct query *q, struct found *found)
{
    size_t count = brute_force(map, q, found), all = count, used = count;
    double radius = q->max_radius, slack = 0;
    if (count > q->gather_count || !isfinite(radius)) {
        if (count > (size_t)q->gather_count + 1)
            count = (size_t)q->gather_count + 1;
        used = count ? count - 1 : 0;
        radius = count ? fmax(sqrt(found[used].distance2), 0x1p-31) : 0;
        slack = count ? tie_slack(found, all, used) : 0;
    }
    pm_estimate e = pm_photon_map_nearest(map, q->point, q->normal, q->gather_count,
                                          q->max_radius, q->filter, NULL);
    assert_estimate(e, flux_of(map, found, used), used, radius, slack);
}

static void check_within(const pm_photon_map *map, const struct query *q, struct found *found)
{
    size_t count = brute_force(map, q, found);
    pm_estimate e =
        pm_photon_map_within(map, q->point, q->normal, q->max_radius, q->filter, NULL);
    assert_estimate(e, flux_of(map, found, count), count, q->max_radius, 0);
}

static void check_closest(const pm_photon_map *map, const struct query *q, struct found *found)
{
    struct query all = *q;
    all.filter = PM_PHOTONS_ALL;
    size_t index, count = brute_force(map, &all, found);
    bool any = pm_photon_map_closest(map, q->point, q->normal, q->max_radius, &index);
    assert_int_equal(any, count > 0);
    if (any)
        assert_int_equal(index, found[0].index);
}

/* Searches round points to the grid of stored positions; here they lie on it. */
static pm_vec3 on_grid(pm_vec3 p)
{
    return (pm_vec3){rint(p.x * 0x1p31) * 0x1p-31, rint(p.y * 0x1p31) * 0x1p-31,
                     rint(p.z * 0x1p31) * 0x1p-31};
}

/* A query on a photon, next to one, or anywhere in and around the cube. */
static struct query make_query(const pm_photon_map *map, pm_rng *rng, unsigned i)
{
    static const uint32_t gather[] = {1, 2, 10, 50, 51, 500, 3000};
    static const double radius[] = {INFINITY, .012, .1, .5, INFINITY, 3};
    pm_photon photon;
    struct query q = {
        .filter = i % 3, .gather_count = gather[i % 7], .max_radius = radius[i % 6]};
    if (pm_photon_map_count(map)) {
        pm_photon_map_photon(map, pm_rng_u32(rng) % pm_photon_map_count(map), &photon);
        q.point = pm_photon_position(&photon);
        q.normal = pm_photon_normal(&photon);
    }
    if (i % 5 == 1)
        q.point = pm_vec3_madd(q.point, .01, field_direction(rng));
    if (i % 5 == 2)
        q.point = pm_vec3_scale(field_direction(rng), i % 4 ? 1 : 1000);
    if (i % 5 >= 2)
        q.normal = field_direction(rng);
    q.point = on_grid(q.point);
    return q;
}

static void check_map(const pm_photon_map *map, unsigned queries)
{
    pm_rng rng;
    pm_rng_init(&rng, 5, PM_RNG_PATH, 1);
    struct found *found = malloc((pm_photon_map_count(map) + 1) * sizeof *found);
    assert_non_null(found);
    for (unsigned i = 0; i < queries; i++) {
        struct query q = make_query(map, &rng, i);
        check_nearest(map, &q, found);
        check_closest(map, &q, found);
        if (isfinite(q.max_radius))
            check_within(map, &q, found);
    }
    free(found);
}

static void nearest_equals_brute_force(void **state)
{
    (void)state;
    field_make *fields[] = {field_floor, field_room, field_sphere, field_ball, field_caustic};
    for (unsigned f = 0; f < sizeof fields / sizeof *fields; f++) {
        pm_photon_map *map = field_map(fields[f], f, 6000);
        check_map(map, 300);
        pm_photon_map_free(map);
    }
}

static void nearest_equals_brute_force_in_small_maps(void **state)
{
    (void)state;
    for (size_t count = 0; count < 40; count++) {
        pm_photon_map *map = field_map(count & 1 ? field_sphere : field_room, count, count);
        check_map(map, 60);
        pm_photon_map_free(map);
    }
}

static void nearest_equals_brute_force_when_all_photons_are_in_one_point(void **state)
{
    (void)state;
    for (size_t count = 1; count < 6000; count *= 5) {
        pm_photon_map *map = field_map(field_point, 1, count);
        check_map(map, 100);
        pm_photon_map_free(map);
    }
}

/* Rings of equal distance: the ones first in stored order are summed. */
static void nearest_takes_ties_in_stored_order(void **state)
{
    (void)state;
    pm_photon *photons = field_photons(field_floor, 3, 4096);
    for (unsigned i = 0; i < 4096; i++) {
        photons[i].position[0] = 0x80000000U + (i % 64 - 32) * 0x10000U;
        photons[i].position[1] = 0x80000000U + (i / 64 - 32) * 0x10000U;
    }
    pm_photon_map *map = field_map_of(photons, 4096);
    struct found *found = malloc(4096 * sizeof *found);
    struct query q = {{0, 0, -.5}, {0, 0, 1}, PM_PHOTONS_ALL, 0, INFINITY};
    for (q.gather_count = 1; q.gather_count < 400; q.gather_count++)
        check_nearest(map, &q, found);
    free(found);
    free(photons);
    pm_photon_map_free(map);
}

static void closest_equals_brute_force(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_sphere, 7, 3000);
    struct found *found = malloc(3000 * sizeof *found);
    pm_rng rng;
    pm_rng_init(&rng, 6, PM_RNG_PATH, 1);
    assert_non_null(found);
    for (unsigned i = 0; i < 300; i++) {
        struct query q = make_query(map, &rng, i);
        check_closest(map, &q, found);
    }
    free(found);
    pm_photon_map_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_equals_brute_force),
        cmocka_unit_test(nearest_equals_brute_force_in_small_maps),
        cmocka_unit_test(nearest_equals_brute_force_when_all_photons_are_in_one_point),
        cmocka_unit_test(closest_equals_brute_force),
        cmocka_unit_test(nearest_takes_ties_in_stored_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
