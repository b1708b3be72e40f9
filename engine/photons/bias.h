#ifndef PM_PHOTONS_BIAS_H
#define PM_PHOTONS_BIAS_H

#include "photons/photon_map.h"

/* Estimates that choose their own number of photons: many where light is even, for less noise,
 * few where it changes, for less bias. */

typedef enum pm_bandwidth {
    PM_BANDWIDTH_BIAS, /* bias compensation */
    PM_BANDWIDTH_CHI2, /* chi-squared hold */
    PM_BANDWIDTHS,
} pm_bandwidth;

const char *pm_bandwidth_name(pm_bandwidth bandwidth); /* "bias", "chi2" */

typedef struct pm_gather_range {
    uint32_t least, most; /* photons an estimate: 1 <= least <= most <= PM_GATHER_MAX */
    pm_bandwidth bandwidth;
} pm_gather_range;

/* pm_photon_map_nearest without a greatest radius, with `least` to `most` photons.
 *
 * PM_BANDWIDTH_BIAS: with E_k the estimate from k photons, those of k <= least, weighted with
 * k^2, begin a running mean and variance. A binary search goes up, and takes E_k into the mean,
 * when E_k differs from it by no more than 2.25 standard deviations, summed over the channels:
 * noise; else it goes down: bias. The deviation is that of the running estimates or that of the
 * last estimate's own photons, whichever is greater, as the running ones hold the same photons
 * and differ by less than they are wrong. (Source: Schregle, "Bias Compensation for Photon
 * Maps", CGF 22(4), 2003, who draws whether to go up, from the running variance alone.)
 *
 * PM_BANDWIDTH_CHI2: the number of photons grows in steps of a fifth for as long as they are
 * spread over eight equal sectors of the disc (octants of the ball) as evenly as chance allows:
 * chi-squared of 7 degrees of freedom under its quantile 1 - 1e-4. (Source: Lin et al., "CPPM:
 * chi-squared progressive photon mapping", TOG 39(6), 2020, with one map in place of passes.)
 *
 * Measured on the caustic of a glass ball: RMSE over mean at 48 x 48 points of the floor, with
 * 10k, 50k and 200k caustic photons, against 12 maps of 4 million:
 * - 50 nearest .539 .637 .623, 500 nearest .566 .298 .239;
 * - from 50 to 500: bias .334 .255 .235, chi2 .289 .229 .225;
 * - Kaplanyan and Dachsbacher (TOG 32(2), 2013; the Laplacian from the photons' mean squared
 *   distance) .288 .240 .243, not offered.
 *
 * In even light both are right on average but for what chance makes them choose: less than half
 * a percent at 50..500. Tests: even_light_is_estimated_right, tests/physics/test_bias.c. */
pm_estimate pm_photon_map_adapted(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                  const pm_gather_range *range, pm_photon_filter filter,
                                  const pm_photon_weight *weight);

/* The same in a medium: as pm_photon_map_volume. */
pm_estimate pm_photon_map_volume_adapted(const pm_photon_map *map, pm_vec3 point,
                                         pm_vec3 direction, double g,
                                         const pm_gather_range *range);

#endif
