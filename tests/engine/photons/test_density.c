#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/maths.h"
#include "fields.h"
#include "world/media.h"

/* Densities of known fields. In a field of n photons uniform over an area A, the share of A
 * within the (k+1)-th nearest is Beta(k + 1, n - k), so E[k / share] = n exactly; with n large
 * its relative variance is 1 / (k - 1). The green flux of each photon is 1, the red one 1, 2
 * or 3. */

static const pm_vec3 up = {0, 0, 1};

enum { FLOOR = 400000 };
#define FLOOR_DENSITY (FLOOR / (1.8 * 1.8))

/* Calls on a square lattice of side^2 points in [-.8, .8]^2 of the floor, so far apart that the
 * photons of two calls are nearly always different ones. */
static void over_floor(const pm_photon_map *map, unsigned side, uint32_t k, double max_radius,
                       void (*add)(void *context, const pm_estimate *e), void *context)
{
    for (unsigned i = 0; i < side * side; i++) {
        pm_vec3 p = {1.6 * (i % side + .5) / side - .8, 1.6 * (i / side + .5) / side - .8, -.5};
        pm_estimate e =
            k ? pm_photon_map_nearest(map, p, up, k, max_radius, PM_PHOTONS_ALL, NULL)
              : pm_photon_map_within(map, p, up, max_radius, PM_PHOTONS_ALL, NULL);
        add(context, &e);
    }
}

static void add_green(void *context, const pm_estimate *e)
{
    field_add(context, e->irradiance.g);
}

static void add_area(void *context, const pm_estimate *e)
{
    field_add(context, PM_PI * e->radius * e->radius);
}

/* For k = 1 the estimate has no variance, but the area that two photons need has: its mean is
 * 2 / (n + 1) of the floor. */
static void density_flat_floor_is_analytic(void **state)
{
    (void)state;
    static const struct {
        uint32_t k;
        unsigned side;
    } rows[] = {{3, 100}, {10, 70}, {50, 60}, {500, 20}};
    pm_photon_map *map = field_map(field_floor, 1, FLOOR);
    field_moments area = {0};
    over_floor(map, 100, 1, INFINITY, add_area, &area);
    field_assert_mean(&area, 2 * 1.8 * 1.8 / (FLOOR + 1));
    for (unsigned i = 0; i < sizeof rows / sizeof *rows; i++) {
        field_moments density = {0};
        over_floor(map, rows[i].side, rows[i].k, INFINITY, add_green, &density);
        field_assert_mean(&density, FLOOR_DENSITY);
    }
    pm_photon_map_free(map);
}

/* Between k / V and count / V_max: E is unbiased where both happen (about half and half here).
 */
static void density_with_a_largest_radius_is_unbiased(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 2, FLOOR);
    field_moments density = {0};
    double radius = sqrt(10 / (PM_PI * FLOOR_DENSITY));
    over_floor(map, 70, 10, radius, add_green, &density);
    field_assert_mean(&density, FLOOR_DENSITY);
    pm_photon_map_free(map);
}

static void density_within_a_radius_is_unbiased(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 3, FLOOR);
    for (double expected = .5; expected < 100; expected *= 4) {
        field_moments density = {0};
        over_floor(map, 60, 0, sqrt(expected / (PM_PI * FLOOR_DENSITY)), add_green, &density);
        field_assert_mean(&density, FLOOR_DENSITY);
    }
    pm_photon_map_free(map);
}

/* The squared relative error is 1 / (k - 1) on average. Its own spread is that of the fourth
 * moment of an inverse gamma variate of shape k + 1, whose excess kurtosis is 6 (5k - 6) / ((k
 * - 2)(k - 3)). */
static void density_error_falls_as_one_over_root_k(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 4, FLOOR);
    for (double k = 8; k <= 512; k *= 4) {
        field_moments density = {0};
        over_floor(map, 30, (uint32_t)k, INFINITY, add_green, &density);
        double relative = field_variance(&density) / (FLOOR_DENSITY * FLOOR_DENSITY);
        double kurtosis = 6 * (5 * k - 6) / ((k - 2) * (k - 3));
        double sigma = sqrt((2 + kurtosis) / density.count);
        assert_true(fabs(relative * (k - 1) - 1) <= 4 * sigma);
    }
    pm_photon_map_free(map);
}

struct variances {
    field_moments red, estimated;
};

static void add_variance(void *context, const pm_estimate *e)
{
    struct variances *v = context;
    field_add(&v->red, e->irradiance.r);
    field_add(&v->estimated, e->variance.r);
}

/* 4900 look-ups in each of two maps: the sample variance itself is known to 4 * sqrt(2.2 /
 * 9800) = 6 %. */
static void variance_estimate_is_that_of_many_estimates(void **state)
{
    (void)state;
    for (uint32_t k = 0; k <= 50; k += 50) {
        struct variances v = {{0, 0, 0}, {0, 0, 0}};
        for (uint64_t seed = 5; seed < 7; seed++) {
            pm_photon_map *map = field_map(field_floor, seed, FLOOR);
            double radius = sqrt(50 / (PM_PI * FLOOR_DENSITY));
            over_floor(map, 70, k, k ? INFINITY : radius, add_variance, &v);
            pm_photon_map_free(map);
        }
        assert_true(fabs(v.estimated.mean / field_variance(&v.red) - 1) < .1);
    }
}

/* The cap of a sphere within distance r of a point on it has exactly the area pi r^2
 * (Archimedes). With 100 of 2000 photons r is .45 of the sphere's radius. */
static void density_on_a_sphere_is_analytic(void **state)
{
    (void)state;
    field_moments nearest = {0}, within = {0};
    pm_rng rng;
    pm_rng_init(&rng, 9, PM_RNG_PATH, 0);
    for (uint64_t seed = 0; seed < 500; seed++) {
        pm_photon_map *map = field_map(field_sphere, seed, 2000);
        pm_vec3 n = field_direction(&rng), p = pm_vec3_scale(n, .5);
        pm_estimate e = pm_photon_map_nearest(map, p, n, 100, INFINITY, PM_PHOTONS_ALL, NULL);
        field_add(&nearest, e.irradiance.g);
        e = pm_photon_map_within(map, p, n, .2, PM_PHOTONS_ALL, NULL);
        field_add(&within, e.irradiance.g);
        pm_photon_map_free(map);
    }
    field_assert_mean(&nearest, 2000 / (4 * PM_PI * .25));
    field_assert_mean(&within, 2000 / (4 * PM_PI * .25));
}

static void assert_dark(const pm_photon_map *map, pm_vec3 p, pm_vec3 n, double radius)
{
    pm_estimate e = pm_photon_map_nearest(map, p, n, 50, radius, PM_PHOTONS_ALL, NULL);
    assert_int_equal(e.count, 0);
    assert_true(e.irradiance.g == 0 && e.variance.g == 0 && e.radius == 0);
    if (isfinite(radius)) {
        e = pm_photon_map_within(map, p, n, radius, PM_PHOTONS_ALL, NULL);
        assert_int_equal(e.count, 0);
    }
}

/* The floor has no thickness: its lower side is where its upper side is. */
static void other_side_of_a_thin_wall_is_dark(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 10, 10000);
    const pm_vec3 down = {0, 0, -1};
    for (double x = -.8; x < .9; x += .1) {
        assert_dark(map, (pm_vec3){x, .1, -.5}, down, INFINITY);
        assert_dark(map, (pm_vec3){x, .1, -.5}, down, .3);
        assert_int_equal(
            pm_photon_map_within(map, (pm_vec3){x, .1, -.5}, up, .3, PM_PHOTONS_ALL, NULL)
                    .count > 0,
            true);
    }
    pm_photon_map_free(map);
}

/* A wall stands on the lit floor at x = .5, and is not lit. */
static void corner_leaks_nothing(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 11, 10000);
    for (double z = -.5; z < .5; z += .01)
        assert_dark(map, (pm_vec3){.5, 0, z}, (pm_vec3){-1, 0, 0}, z < 0 ? .2 : INFINITY);
    pm_photon_map_free(map);
}

static void shelf_does_not_take_the_light_of_the_floor_below(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 12, 10000);
    for (double height = .001; height < .3; height *= 1.5)
        assert_dark(map, (pm_vec3){0, 0, -.5 + height}, up, 3.9 * height);
    pm_photon_map_free(map);
}

static void filter_splits_the_light_in_two(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_floor, 13, 10000);
    const pm_vec3 p = {0, 0, -.5};
    double r = .2, all = pm_photon_map_within(map, p, up, r, PM_PHOTONS_ALL, NULL).irradiance.r;
    double plain =
        pm_photon_map_within(map, p, up, r, PM_PHOTONS_NOT_SPECULAR, NULL).irradiance.r;
    double rest = pm_photon_map_within(map, p, up, r, PM_PHOTONS_SPECULAR, NULL).irradiance.r;
    assert_true(plain > 0 && rest > 0);
    assert_true(fabs(plain + rest - all) <= 1e-12 * all);
    pm_photon_map_free(map);
}

/* Directions are uniform, so the phase function's mean is 1 / (4 pi) whatever g. Points on a
 * lattice in a cube of side .7 inside the ball. */
static void volume_density_in_a_uniform_ball_is_analytic(void **state)
{
    (void)state;
    enum { COUNT = 200000, SIDE = 12 };
    pm_photon_map *map = field_map(field_ball, 14, COUNT);
    double truth = COUNT / (4.0 / 3 * PM_PI * .512) / (4 * PM_PI);
    for (int i = 0; i < 3; i++) {
        double g = .4 * i;
        field_moments nearest = {0}, within = {0};
        for (unsigned c = 0; c < SIDE * SIDE * SIDE; c++) {
            pm_vec3 p = {.06 * (c % SIDE) - .33, .06 * (c / SIDE % SIDE) - .33,
                         .06 * (c / SIDE / SIDE) - .33};
            pm_estimate e = pm_photon_map_volume(map, p, up, g, 20, INFINITY);
            field_add(&nearest, e.irradiance.g);
            e = pm_photon_map_volume_within(map, p, up, g, .03);
            field_add(&within, e.irradiance.g);
        }
        field_assert_mean(&nearest, truth);
        field_assert_mean(&within, truth);
    }
    pm_photon_map_free(map);
}

static pm_photon beam_photon(pm_vec3 position, pm_vec3 came_from)
{
    pm_photon photon;
    pm_photon_record record = {.position = position, .direction = came_from, .flux = {1, 1, 1}};
    pm_photon_pack(&record, 1, &photon);
    return photon;
}

/* Light that goes along +x scatters forward into +x: cosine 1, and backward into -x. */
static void volume_photons_scatter_the_way_they_go(void **state)
{
    (void)state;
    pm_photon photon = beam_photon((pm_vec3){0, 0, 0}, (pm_vec3){-1, 0, 0});
    pm_photon_map *map = field_map_of(&photon, 1);
    double volume = 4.0 / 3 * PM_PI * .001;
    for (double x = -1; x <= 1; x += 2) {
        pm_vec3 to = {x, 0, 0};
        pm_estimate e = pm_photon_map_volume_within(map, (pm_vec3){.05, 0, 0}, to, .6, .1);
        double truth = pm_phase(.6, x) / volume;
        assert_true(fabs(e.irradiance.g - truth) <= 1e-12 * truth);
    }
    pm_photon_map_free(map);
}

/* Powers of two: scaling fluxes and paths scales estimates exactly. */
static void estimates_scale_with_flux_and_paths(void **state)
{
    (void)state;
    pm_photon *photons = field_photons(field_floor, 15, 1000);
    pm_batch batch = {.paths = 1, .count = 1000, .photons = photons};
    pm_photon_map *map[2] = {NULL, NULL};
    pm_map_header plain = {.paths = 1, .flux_scale = 1, .world_scale = 1}, scaled = plain;
    scaled.paths = 8;
    scaled.flux_scale = 0x1p-40;
    scaled.world_scale = 1024;
    assert_int_equal(pm_photon_map_build(&plain, &batch, 1, NULL, &map[0], NULL), PM_OK);
    assert_int_equal(pm_photon_map_build(&scaled, &batch, 1, NULL, &map[1], NULL), PM_OK);
    pm_estimate e[2];
    for (int i = 0; i < 2; i++)
        e[i] = pm_photon_map_nearest(map[i], (pm_vec3){0, 0, -.5}, up, 50, INFINITY,
                                     PM_PHOTONS_ALL, NULL);
    assert_true(e[1].irradiance.r == e[0].irradiance.r * 0x1p-43);
    assert_true(e[1].variance.r == e[0].variance.r * 0x1p-86);
    assert_true(e[1].radius == e[0].radius);
    assert_true(pm_photon_map_mean_flux(map[1]).r ==
                pm_photon_map_mean_flux(map[0]).r * 0x1p-23); /* 2^-43 * 1024^2 */
    pm_photon_map_free(map[0]);
    pm_photon_map_free(map[1]);
    free(photons);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(density_flat_floor_is_analytic),
        cmocka_unit_test(density_with_a_largest_radius_is_unbiased),
        cmocka_unit_test(density_within_a_radius_is_unbiased),
        cmocka_unit_test(density_error_falls_as_one_over_root_k),
        cmocka_unit_test(variance_estimate_is_that_of_many_estimates),
        cmocka_unit_test(density_on_a_sphere_is_analytic),
        cmocka_unit_test(other_side_of_a_thin_wall_is_dark),
        cmocka_unit_test(corner_leaks_nothing),
        cmocka_unit_test(shelf_does_not_take_the_light_of_the_floor_below),
        cmocka_unit_test(filter_splits_the_light_in_two),
        cmocka_unit_test(volume_density_in_a_uniform_ball_is_analytic),
        cmocka_unit_test(volume_photons_scatter_the_way_they_go),
        cmocka_unit_test(estimates_scale_with_flux_and_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
