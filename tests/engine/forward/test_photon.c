#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "base/warp.h"
#include "forward/photon.h"

enum { TRIALS = 100000 };

static pm_rng make_rng(uint64_t index)
{
    pm_rng rng;
    pm_rng_init(&rng, 7, PM_RNG_CAMERA, index);
    return rng;
}

/* A flux whose channels span nine octaves around a magnitude between 2^-60 and 2^20. */
static pm_rgb random_flux(pm_rng *rng)
{
    double magnitude = ldexp(1 + pm_rng_uniform(rng), (int)(80 * pm_rng_uniform(rng)) - 60);
    double c[3];
    for (int i = 0; i < 3; i++)
        c[i] = ldexp(magnitude * (1 + pm_rng_uniform(rng)), -(int)(9 * pm_rng_uniform(rng)));
    return pm_rgb_make(c[0], c[1], c[2]);
}

static pm_photon pack_flux_at(pm_vec3 position, pm_rgb flux, double scale)
{
    pm_photon_record record = {position, {0, 0, 1}, {0, 0, 1}, flux, false, 0};
    pm_photon photon;
    pm_photon_pack(&record, scale, &photon);
    return photon;
}

static pm_photon pack_flux(pm_rgb flux, double scale)
{
    return pack_flux_at(pm_vec3_make(.1, .2, .3), flux, scale);
}

static pm_vec3 random_place(pm_rng *rng)
{
    double c[3];
    for (int i = 0; i < 3; i++)
        c[i] = 2 * pm_rng_uniform(rng) - 1;
    return pm_vec3_make(c[0], c[1], c[2]);
}

/* 10 bits of mantissa: with e the power of two above the largest channel a step is e 2^-10 (a
 * largest channel above 1023 / 1024 e takes the next e). */
static double step_of(pm_rgb flux)
{
    int e;
    frexp(pm_rgb_max(flux) * (1024. / 1023), &e);
    return ldexp(1, e - 10);
}

static void photon_packing_is_off_by_less_than_a_step(void **state)
{
    (void)state;
    pm_rng rng = make_rng(1);
    double scale = 3.7;
    for (int i = 0; i < TRIALS; i++) {
        pm_rgb flux = random_flux(&rng);
        pm_photon photon = pack_flux_at(random_place(&rng), flux, scale);
        pm_photon_record out;
        pm_photon_unpack(&photon, scale, &out);
        double step = step_of(pm_rgb_scale(flux, 1 / scale)) * scale * (1 + 1e-12);
        pm_rgb error = pm_rgb_sub(out.flux, flux);
        assert_true(fabs(error.r) < step && fabs(error.g) < step && fabs(error.b) < step);
    }
}

/* The same flux at n places. A channel of (whole + f) steps is rounded up with the probability
 * f: sigma of the mean is sqrt(f (1 - f) / n) <= 1 / (2 sqrt(n)) steps; k = 5. Probabilities
 * come in 1024ths, which adds at most 1 / 2048 step. */
static void check_mean(pm_rng *rng, pm_rgb flux)
{
    pm_rgb sum = {0, 0, 0};
    for (int i = 0; i < TRIALS; i++) {
        pm_photon photon = pack_flux_at(random_place(rng), flux, 1);
        sum = pm_rgb_add(sum, pm_photon_flux(&photon));
    }
    pm_rgb error = pm_rgb_sub(pm_rgb_scale(sum, 1. / TRIALS), flux);
    double bound = step_of(flux) * (5 * .5 / sqrt(TRIALS) + 1. / 2048);
    assert_true(fabs(error.r) < bound && fabs(error.g) < bound && fabs(error.b) < bound);
}

static void photon_packing_keeps_the_mean_flux(void **state)
{
    (void)state;
    pm_rng rng = make_rng(4);
    check_mean(&rng, pm_rgb_make(1, .1, .00125));
    check_mean(&rng, pm_rgb_make(.00047, .63, .065));
    check_mean(&rng, pm_rgb_make(.1 / 3, .2 / 3, 2.9 / 3));
}

static void flux_in_whole_steps_is_exact(void **state)
{
    (void)state;
    pm_rng rng = make_rng(5);
    for (int i = 0; i < 1000; i++) {
        pm_photon photon =
            pack_flux_at(random_place(&rng), pm_rgb_make(1023. / 1024, 0x1p-10, 0), 1);
        pm_rgb flux = pm_photon_flux(&photon);
        assert_true(flux.r == 1023. / 1024 && flux.g == 0x1p-10 && flux.b == 0);
    }
}

/* A mantissa that may round up to 1024 takes the next exponent. */
static void flux_just_below_a_power_of_two_carries(void **state)
{
    (void)state;
    pm_photon photon = pack_flux(pm_rgb_make(1 - 0x1p-20, 0.5, 0), 1);
    pm_rgb flux = pm_photon_flux(&photon);
    assert_true((flux.r == 1 || flux.r == 1 - 0x1p-9) && flux.g == 0.5 && flux.b == 0);
}

static void flux_beyond_the_exponent_is_zero_or_kept(void **state)
{
    (void)state;
    pm_photon dark = pack_flux(pm_rgb_grey(0), 1), faint = pack_flux(pm_rgb_grey(1e-300), 1);
    assert_true(pm_rgb_is_black(pm_photon_flux(&dark)));
    assert_true(pm_rgb_is_black(pm_photon_flux(&faint)));
    pm_photon least = pack_flux(pm_rgb_grey(0x1p-200), 1);
    assert_true(pm_photon_flux(&least).r == 0x1p-200);
    pm_photon large = pack_flux(pm_rgb_grey(0x1p60), 1);
    assert_true(pm_photon_flux(&large).g == 0x1p60);
}

static void axis_directions_and_normals_are_exact(void **state)
{
    (void)state;
    for (int axis = 0; axis < 6; axis++) {
        double v[3] = {0, 0, 0};
        v[axis / 2] = axis % 2 ? -1 : 1;
        pm_vec3 d = {v[0], v[1], v[2]};
        pm_photon_record record = {.normal = d, .direction = d, .flux = {1, 1, 1}};
        pm_photon photon;
        pm_photon_pack(&record, 1, &photon);
        pm_vec3 n = pm_photon_normal(&photon), w = pm_photon_direction(&photon);
        assert_true(n.x == d.x && n.y == d.y && n.z == d.z);
        assert_true(w.x == d.x && w.y == d.y && w.z == d.z);
    }
}

/* Codes are off by at most 1 / (2 half) an axis. On the octahedron that moves the point by at
 * most sqrt(1 + 1 + 2^2) / (2 half); its distance from the centre is at least 1 / sqrt(3), so
 * the direction turns by at most sqrt(18) / (2 half), which bounds the chord as well. */
static void directions_are_kept_to_the_step_of_the_code(void **state)
{
    (void)state;
    pm_rng rng = make_rng(2);
    for (int i = 0; i < TRIALS; i++) {
        double u = pm_rng_uniform(&rng), v = pm_rng_uniform(&rng);
        pm_vec3 d = pm_warp_sphere(u, v);
        pm_photon_record record = {.normal = d, .direction = d, .flux = {1, 1, 1}};
        pm_photon photon;
        pm_photon_pack(&record, 1, &photon);
        pm_vec3 n = pm_photon_normal(&photon), w = pm_photon_direction(&photon);
        assert_true(pm_vec3_distance(n, d) <= sqrt(18) / (2 * 127));
        assert_true(pm_vec3_distance(w, d) <= sqrt(18) / (2 * 32767));
        assert_true(fabs(pm_vec3_length(n) - 1) < 1e-15 && fabs(pm_vec3_length(w) - 1) < 1e-15);
    }
}

/* Half a step of 2^-31, except at the upper faces of the cube, which clamp to the last code. */
static void positions_are_kept_to_half_a_step(void **state)
{
    (void)state;
    pm_rng rng = make_rng(3);
    for (int i = 0; i < TRIALS; i++) {
        double x = 2 * pm_rng_uniform(&rng) - 1 + pm_rng_uniform(&rng) * 0x1p-40;
        pm_photon_record record = {.position = {x, -x, i % 2 ? 1 : -1}, .flux = {1, 1, 1}};
        pm_photon photon;
        pm_photon_pack(&record, 1, &photon);
        pm_vec3 p = pm_photon_position(&photon);
        assert_true(fabs(p.x - x) <= 0x1p-32 && fabs(p.y + x) <= 0x1p-32);
        assert_true(fabs(p.z - record.position.z) <= 0x1p-31);
    }
}

static void flags_survive_packing(void **state)
{
    (void)state;
    for (unsigned replicate = 0; replicate < PM_REPLICATES; replicate++) {
        pm_photon_record in = {.replicate = replicate, .specular = replicate % 3 == 0}, out;
        pm_photon photon;
        pm_photon_pack(&in, 1, &photon);
        pm_photon_unpack(&photon, 1, &out);
        assert_int_equal(out.replicate, in.replicate);
        assert_int_equal(out.specular, in.specular);
    }
}

static void names_are_those_of_the_command_line(void **state)
{
    (void)state;
    assert_string_equal(pm_map_kind_name(PM_MAP_GLOBAL), "global");
    assert_string_equal(pm_map_kind_name(PM_MAP_CAUSTIC), "caustic");
    assert_string_equal(pm_map_kind_name(PM_MAP_VOLUME), "volume");
}

static void a_cleared_batch_is_empty(void **state)
{
    (void)state;
    pm_batch batch = {.kind = PM_MAP_CAUSTIC, .paths = 1, .count = 1};
    batch.ends = malloc(sizeof *batch.ends);
    batch.photons = malloc(sizeof *batch.photons);
    pm_batch_clear(&batch);
    assert_true(!batch.ends && !batch.photons && !batch.count && !batch.paths);
    pm_batch_clear(&batch); /* once more is harmless */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photon_packing_is_off_by_less_than_a_step),
        cmocka_unit_test(photon_packing_keeps_the_mean_flux),
        cmocka_unit_test(flux_in_whole_steps_is_exact),
        cmocka_unit_test(flux_just_below_a_power_of_two_carries),
        cmocka_unit_test(flux_beyond_the_exponent_is_zero_or_kept),
        cmocka_unit_test(axis_directions_and_normals_are_exact),
        cmocka_unit_test(directions_are_kept_to_the_step_of_the_code),
        cmocka_unit_test(positions_are_kept_to_half_a_step),
        cmocka_unit_test(flags_survive_packing),
        cmocka_unit_test(names_are_those_of_the_command_line),
        cmocka_unit_test(a_cleared_batch_is_empty),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
