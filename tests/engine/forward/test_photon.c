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

static pm_photon pack_flux(pm_rgb flux, double scale)
{
    pm_photon_record record = {.normal = {0, 0, 1}, .direction = {0, 0, 1}, .flux = flux};
    pm_photon photon;
    pm_photon_pack(&record, scale, &photon);
    return photon;
}

/* With 10 bits of mantissa and e the power of two above the largest channel, nearest means off
 * by at most e 2^-11 (a carry to 1024 doubles e). Rounding errors in units of the last bit are
 * uniform in
 * [-1/2, 1/2]: their mean has sigma sqrt(1/12 / n); k = 5. Truncation would give a mean of
 * -1/2. */
static void photon_packing_rounds_to_nearest(void **state)
{
    (void)state;
    pm_rng rng = make_rng(1);
    double scale = 3.7, sum = 0;
    for (int i = 0; i < TRIALS; i++) {
        pm_rgb flux = random_flux(&rng);
        pm_photon photon = pack_flux(flux, scale);
        pm_photon_record out;
        pm_photon_unpack(&photon, scale, &out);
        int e;
        frexp(pm_rgb_max(flux) / scale * (1 + 0x1p-11), &e);
        double bound = ldexp(scale, e - 11) * (1 + 1e-12), unit = ldexp(scale, e - 10);
        pm_rgb error = pm_rgb_sub(out.flux, flux);
        assert_true(fabs(error.r) <= bound && fabs(error.g) <= bound && fabs(error.b) <= bound);
        sum += (error.r + error.g + error.b) / unit;
    }
    assert_true(fabs(sum / (3 * TRIALS)) < 5 * sqrt(1 / 12. / (3 * TRIALS)));
}

static void flux_that_rounds_up_to_a_power_of_two_carries(void **state)
{
    (void)state;
    pm_photon photon = pack_flux(pm_rgb_make(1 - 0x1p-20, 0.5, 0), 1);
    pm_rgb flux = pm_photon_flux(&photon);
    assert_true(flux.r == 1 && flux.g == 0.5 && flux.b == 0);
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
        cmocka_unit_test(photon_packing_rounds_to_nearest),
        cmocka_unit_test(flux_that_rounds_up_to_a_power_of_two_carries),
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
