#ifndef PM_PHOTONS_PRECOMPUTE_H
#define PM_PHOTONS_PRECOMPUTE_H

#include "photons/photon_map.h"

/* Precomputed maps: the irradiance at some photons of a global map, estimated once from all of
 * them. A look-up then takes that of the closest, instead of gathering. After Christensen,
 * "Faster photon map global illumination", Journal of Graphics Tools 4(3), 1999.
 *
 * Such a map is a pm_photon_map of kind PM_MAP_PRECOMPUTED. Its photons hold irradiance where
 * others hold flux and direction: three mantissas of 20 bits, the upper 10 of each where those
 * of a flux are, the lower ones in the direction; rounded to nearest, off by at most 2^-20 of
 * the largest channel. Its flux scale is in W/m^2 and is not divided by paths. The low 4 bits
 * of the flags are c of the standard deviation, 2^(-c/2) of the irradiance. Its storage
 * probability is the share of the photons that were kept. */

typedef struct pm_precompute {
    uint32_t gather_count; /* photons an estimate */
    double fraction;       /* share of the photons that are kept, > 0, <= 1 */
    pm_digest family;      /* pm_precompute_family */
    uint64_t seed;
    /* The estimate at the place of photon i, for who knows of edges and walls; NULL:
     * pm_photon_map_nearest. From any thread. */
    pm_estimate (*estimate)(const void *context, const pm_photon_map *global, pm_vec3 point,
                            pm_vec3 normal, uint32_t gather_count, uint64_t i);
    const void *context;
} pm_precompute;

/* SHA-256 over the global family, the photons wanted, gather count and fraction. */
pm_digest pm_precompute_family(const pm_digest *global, uint64_t count, uint32_t gather_count,
                               double fraction);

/* Keeps floor(fraction * count) photons of a global map, at least one if it has any: one of
 * each stretch of 1 / fraction of the stored order, drawn from the seed, so that they are
 * spread as the photons are. Each holds pm_photon_map_nearest at its place, itself included: on
 * the average over a surface that is what the closest one should say, as a place far from all
 * kept photons is one where photons happen to be few (with fraction * gather_count below some
 * 10 it says up to 1 / (gather_count - 1) too much). The same bytes for any number of threads.
 * `cancelled` may be NULL: PM_E_CANCELLED. PM_E_MEMORY.
 * Tests: precomputed_is_the_estimate_at_the_same_points, even_light_is_precomputed_right,
 * precomputed_bytes_do_not_depend_on_threads. */
PM_MUST_USE pm_status pm_photon_map_precompute(const pm_photon_map *global,
                                               const pm_precompute *how, pm_pool *pool,
                                               bool (*cancelled)(void *), void *waiting,
                                               pm_photon_map **out, pm_error *err);

/* Turns the header of a global map into that of the precomputed map made of it. */
void pm_precompute_header(pm_map_header *header, const pm_precompute *how);

/* The irradiance of the closest photon that counts at the point (photon_map.h); zeros if there
 * is none. */
pm_estimate pm_photon_map_precomputed(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal);
/* The same at many points, each within its query's radius: the very bytes of one call each.
 * Test: batches_of_precomputed_look_ups_have_the_bytes_of_single_ones. */
void pm_photon_map_precomputed_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                     size_t count, pm_estimate *out);

/* That of a photon of such a map. `count` is that of photons whose irradiance is as disjoint
 * from others as this. The radius is 0: nothing is left to correct at edges. */
pm_estimate pm_precomputed_estimate(const pm_photon_map *map, const pm_photon *photon);

/* [W/m^2], of a photon of such a map. */
pm_rgb pm_precomputed_irradiance(const pm_photon_map *map, const pm_photon *photon);

#endif
