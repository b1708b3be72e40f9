/* Light scattered by media on the way to the eye. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "backward/backward_internal.h"
#include "base/maths.h"
#include "eye.h"

static double channel_of(pm_rgb values, int c)
{
    return c == 0 ? values.r : c == 1 ? values.g : values.b;
}

/* The mean of extinction exp(-extinction s) / pdf(s) is 1 - exp(-extinction length) for every
 * channel. The balance heuristic bounds each sample to 3 times that, so sigma <= 1.5 / sqrt(n)
 * of it; k = 5. */
static void distances_estimate_every_extinction(void **state)
{
    (void)state;
    enum { N = 20000 };
    static const pm_rgb extinctions[] = {
        {1e-6, 1, 1e6}, {2, 2, 2}, {1e-12, 1e-9, 0}, {0, 0, 5}};
    static const double lengths[] = {1e-9, 1e-3, 1, 100, INFINITY};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 5; j++) {
            const pm_medium medium = {.extinction = extinctions[i], .albedo = {1, 1, 1}};
            double sum[3] = {0};
            for (uint32_t k = 0; k < N; k++) {
                struct pm_sampler sampler;
                double s, pdf;
                pm_sampler_init(&sampler, 1, k, 0);
                assert_true(pm_inscatter_distance(&medium, lengths[j], &sampler, &s, &pdf));
                assert_true(s >= 0 && s <= lengths[j] && pdf > 0);
                for (int c = 0; c < 3; c++) {
                    double e = channel_of(extinctions[i], c);
                    sum[c] += e * pm_exp(-e * s) / pdf / N;
                }
            }
            for (int c = 0; c < 3; c++) {
                double e = channel_of(extinctions[i], c);
                double want = e > 0 ? -expm1(-e * lengths[j]) : 0;
                assert_true(fabs(sum[c] - want) <= 5 * 1.5 / sqrt(N) * want);
            }
        }
}

static void medium_without_scattering_has_no_distance(void **state)
{
    (void)state;
    const pm_medium medium = {.extinction = {1, 2, 3}, .albedo = {0, 0, 0}};
    struct pm_sampler sampler;
    double s, pdf;
    pm_sampler_init(&sampler, 1, 0, 0);
    assert_false(pm_inscatter_distance(&medium, 1, &sampler, &s, &pdf));
}

/* A furnace: inside a shell of even radiance 2 nothing tells a scattering mist of albedo 1 from
 * empty space, so on a length d it takes exp(-sigma d) of the light away and adds 2 (1 -
 * exp(-sigma d)), for every sigma and every phase function. The photons asked
 * lie within .3 of the ray, .3 or more from the edge of the mist. k = 6 deviations as the map
 * states them. */
static void assert_furnace(const char *text)
{
    static const double extinction[3] = {1, 4, .25};
    enum { SAMPLES = 400 };
    const double length = .2;
    pm_world *world = world_of(text);
    pm_photon_map *map = map_of(world, PM_MAP_VOLUME, 0, 8);
    pm_world_info info;
    pm_world_info_get(world, &info);
    pm_backward_maps maps = {.map = {[PM_MAP_VOLUME] = map},
                             .radius = {[PM_MAP_VOLUME] = .3 / info.scale}};
    struct pm_pass pass;
    assert_int_equal(pm_pass_init(&pass, world, &maps, NULL), PM_OK);
    pm_rgb mean = {0, 0, 0}, deviation = {0, 0, 0}, passed = {0, 0, 0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        struct pm_sampler sampler;
        struct pm_value value = {0};
        pm_sampler_init(&sampler, 4, i, 0);
        struct pm_walk walk = {.ray = {.origin = pm_world_from_scene(world, (pm_vec3){0, 0, 0}),
                                       .direction = {0, 0, 1}},
                               .throughput = {1, 1, 1}};
        pm_media_at(world, walk.ray.origin, &walk.media);
        pm_inscatter(&pass, &walk, length / info.scale, &sampler, &value);
        mean = pm_rgb_madd(mean, 1.0 / SAMPLES, value.radiance);
        deviation.r += sqrt(value.variance.r) / SAMPLES;
        deviation.g += sqrt(value.variance.g) / SAMPLES;
        deviation.b += sqrt(value.variance.b) / SAMPLES;
        passed = walk.throughput;
    }
    for (int c = 0; c < 3; c++) {
        double left = exp(-extinction[c] * length), want = 2 * (1 - left);
        double tolerance = 6 * channel_of(deviation, c);
        assert_true(fabs(channel_of(passed, c) - left) < 1e-12);
        assert_true(tolerance < .15 * want);
        if (!(fabs(channel_of(mean, c) - want) < tolerance))
            fail_msg("%g is not %g +- %g", channel_of(mean, c), want, tolerance);
    }
    pm_photon_map_free(map);
    pm_world_free(world);
}

#define FURNACE                                                                                \
    "void light wall 0 0 3 2 2 2\nwall bubble shell 0 0 4 0 0 0 1\nfog sphere cloud 0 0 4 0 "  \
    "0 0 .8\n"

static void scattering_mist_is_invisible_in_a_furnace(void **state)
{
    (void)state;
    assert_furnace("void mist fog 0 0 7 1 4 .25 1 1 1 0\n" FURNACE);
    assert_furnace("void mist fog 0 0 7 1 4 .25 1 1 1 .6\n" FURNACE);
}

/* An absorbing mist alone: exp(-sigma d) of the lamp behind it. */
static void absorbing_mist_follows_beer_and_lambert(void **state)
{
    (void)state;
    pm_world *world = world_of("void mist fog 0 0 7 1 4 0 0 0 0 0\n"
                               "fog sphere cloud 0 0 4 0 0 0 .5\n"
                               "void light lamp 0 0 3 10 10 10\n"
                               "lamp ring l 0 0 8  0 0 2  0 0 -1  0 1\n");
    struct measured m =
        sense(world, &no_maps, PM_RADIANCE, (pm_sensor){{0, 0, -1}, {0, 0, 1}}, 2);
    assert_true(fabs(m.value[0] - 10 * exp(-1)) < 1e-5);
    assert_true(fabs(m.value[1] - 10 * exp(-4)) < 1e-5);
    assert_true(fabs(m.value[2] - 10) < 1e-5);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_estimate_every_extinction),
        cmocka_unit_test(medium_without_scattering_has_no_distance),
        cmocka_unit_test(scattering_mist_is_invisible_in_a_furnace),
        cmocka_unit_test(absorbing_mist_follows_beer_and_lambert),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
