#ifndef PM_TESTS_EYE_H
#define PM_TESTS_EYE_H

#include "../world_text.h"
#include "backward/backward.h"
#include "forward/forward.h"
#include "world/light.h"

/* What the tests of the backward pass share: sensors, passes, maps. Include after <cmocka.h>.
 */

static const pm_backward_maps no_maps = {.map = {NULL}};

static inline void run_passes(pm_accumulation *accumulation, const pm_backward_maps *maps,
                              uint32_t passes)
{
    pm_error err = PM_ERROR_INIT;
    pm_pool *pool = pm_pool_new(1);
    assert_non_null(pool);
    uint32_t first = pm_accumulation_passes(accumulation);
    for (uint32_t p = first; p < first + passes; p++)
        if (pm_backward_pass(accumulation, p, maps, pool, NULL, NULL, &err))
            fail_msg("%s", err.text);
    pm_pool_free(pool);
    assert_int_equal(pm_accumulation_nonfinite(accumulation), 0);
}

/* One value with its standard error, as replicates show it. */
struct measured {
    double value[3], error[3];
};

/* Half-widths are 2.131 standard errors: Student's t of 15 degrees of freedom. */
static inline struct measured measure(const pm_accumulation *accumulation)
{
    struct measured m;
    float mean[3], half[3];
    assert_int_equal(pm_accumulation_count(accumulation), 1);
    pm_accumulation_mean(accumulation, mean);
    pm_accumulation_half_width(accumulation, half);
    for (int c = 0; c < 3; c++) {
        m.value[c] = (double)mean[c];
        m.error[c] = (double)half[c] / 2.131;
    }
    return m;
}

static inline struct measured sense(const pm_world *world, const pm_backward_maps *maps,
                                    pm_quantity quantity, pm_sensor sensor, uint32_t passes)
{
    pm_accumulation *accumulation = NULL;
    pm_error err = PM_ERROR_INIT;
    if (pm_accumulation_for_sensors(world, &sensor, 1, quantity, 3, &accumulation, &err))
        fail_msg("%s", err.text);
    run_passes(accumulation, maps, passes);
    struct measured m = measure(accumulation);
    pm_accumulation_free(accumulation);
    return m;
}

/* k = 6 standard errors of 15 degrees of freedom (chance 2e-5), which must be below `sharpness`
 * of the value so that the test can fail; and 1e-6 for the rounding of floats. */
static inline void assert_measured(const struct measured *m, int channel, double want,
                                   double sharpness)
{
    double tolerance = 6 * m->error[channel];
    if (tolerance > sharpness * fabs(want))
        fail_msg("a blunt test: %g +- %g", m->value[channel], tolerance);
    if (!(fabs(m->value[channel] - want) <= tolerance + 1e-6 * fabs(want)))
        fail_msg("%.8g is not %.8g +- %g", m->value[channel], want, tolerance);
}

/* The photons of batches [first, first + count) as a map. */
static inline pm_photon_map *map_of(const pm_world *world, pm_map_kind kind, uint64_t first,
                                    size_t count)
{
    pm_error err = PM_ERROR_INIT;
    pm_forward_options options = pm_forward_defaults();
    pm_forward *forward = NULL;
    pm_pool *pool = pm_pool_new(2);
    assert_non_null(pool);
    if (pm_forward_new(world, &options, pool, &forward, &err))
        fail_msg("%s", err.text);
    pm_batch batches[16];
    assert_true(count <= 16);
    for (size_t i = 0; i < count; i++) {
        pm_batch out[PM_MAP_KINDS] = {0};
        if (pm_forward_batch(forward, first + i, 1U << kind, pool, NULL, NULL, out, &err))
            fail_msg("%s", err.text);
        batches[i] = out[kind];
    }
    pm_world_info info;
    pm_world_info_get(world, &info);
    const pm_map_header header = {.kind = kind,
                                  .scene = pm_world_hash(world),
                                  .family = pm_forward_family(forward, kind),
                                  .paths = count * PM_BATCH_PATHS,
                                  .flux_scale = pm_forward_flux_scale(forward),
                                  .world_scale = info.scale,
                                  .world_center = info.center,
                                  .seed = options.seed,
                                  .storage_probability =
                                      pm_forward_storage_probability(forward, kind),
                                  .emitted = pm_light_total_power(world)};
    pm_photon_map *map = NULL;
    if (pm_photon_map_build(&header, batches, count, pool, &map, &err))
        fail_msg("%s", err.text);
    for (size_t i = 0; i < count; i++)
        pm_batch_clear(&batches[i]);
    pm_forward_free(forward);
    pm_pool_free(pool);
    return map;
}

#endif
