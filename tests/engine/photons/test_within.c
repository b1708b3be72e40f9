#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/maths.h"
#include "fields.h"
#include "world/media.h"

/* Fixed-radius sums in volumes against a plain loop; those on surfaces are in test_nearest.c.
 */

struct sums {
    double green, square;
    uint32_t count;
};

static struct sums brute_force(const pm_photon_map *map, pm_vec3 p, pm_vec3 to, double g,
                               double radius)
{
    struct sums sums = {0, 0, 0};
    for (size_t i = 0; i < pm_photon_map_count(map); i++) {
        pm_photon photon;
        pm_photon_map_photon(map, i, &photon);
        if (pm_vec3_distance(pm_photon_position(&photon), p) > radius)
            continue;
        double cosine = -pm_vec3_dot(pm_photon_direction(&photon), to);
        double flux = pm_photon_flux(&photon).g * pm_phase(g, cosine);
        sums.green += flux;
        sums.square += flux * flux;
        sums.count++;
    }
    return sums;
}

static void volume_sums_equal_brute_force(void **state)
{
    (void)state;
    pm_photon_map *map = field_map(field_ball, 1, 5000);
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    for (int i = 0; i < 300; i++) {
        pm_vec3 p = pm_vec3_scale(field_direction(&rng), pm_rng_uniform(&rng) * 2);
        pm_vec3 to = field_direction(&rng);
        double g = field_uniform(&rng, -.9, .9), radius = i % 2 ? .1 : 1.1;
        struct sums truth = brute_force(map, p, to, g, radius);
        pm_estimate e = pm_photon_map_volume_within(map, p, to, g, radius);
        double volume = 4.0 / 3 * PM_PI * radius * radius * radius;
        assert_int_equal(e.count, truth.count);
        assert_true(fabs(e.irradiance.g * volume - truth.green) <= 1e-12 * truth.green);
        assert_true(fabs(e.variance.g * volume * volume - truth.square) <=
                    1e-12 * truth.square);
    }
    pm_photon_map_free(map);
}

/* Fluxes from 2^-100 to 2^40 of the scale in one sum: nothing under- or overflows. Sums are
 * begun in floats: 2^-20 is 16 of their roundings. */
static void sums_keep_the_whole_range_of_fluxes(void **state)
{
    (void)state;
    pm_photon photons[36];
    pm_photon_record record = {.normal = {0, 0, 1}, .direction = {0, 0, 1}};
    double sum = 0, square = 0;
    for (int i = 0; i < 36; i++) {
        record.flux = pm_rgb_grey(ldexp(1, 4 * i - 100));
        pm_photon_pack(&record, 1, &photons[i]);
        sum += record.flux.g;
        square += record.flux.g * record.flux.g;
    }
    pm_photon_map *map = field_map_of(photons, 36);
    const pm_vec3 here = {0, 0, 0}, up = {0, 0, 1};
    for (int i = 0; i < 2; i++) {
        pm_estimate e = i ? pm_photon_map_nearest(map, here, up, 100, 1, PM_PHOTONS_ALL, NULL)
                          : pm_photon_map_within(map, here, up, 1, PM_PHOTONS_ALL, NULL);
        assert_int_equal(e.count, 36);
        assert_true(fabs(e.irradiance.g * PM_PI - sum) <= 0x1p-20 * sum);
        assert_true(fabs(e.variance.g * PM_PI * PM_PI - square) <= 0x1p-20 * square);
    }
    pm_photon_map_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(volume_sums_equal_brute_force),
        cmocka_unit_test(sums_keep_the_whole_range_of_fluxes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
