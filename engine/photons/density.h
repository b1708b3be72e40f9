#ifndef PM_PHOTONS_DENSITY_H
#define PM_PHOTONS_DENSITY_H

#include "photons/search.h"

/* What density.c and bias.c share: from photons found to an estimate. */

/* Finds what an estimate from the nearest sums, and returns the radius that holds it [world
 * units]: of one photon more than is summed, or max_radius if there are not so many; with
 * INFINITY the farthest then sets the radius and is dropped. */
double pm_density_find(pm_search *search, uint32_t gather_count, double max_radius,
                       pm_candidates *found);

/* Sums of packed fluxes over the disc's area, over the ball's volume; zeros without photons. */
pm_estimate pm_density_over_disc(const pm_photon_map *map, const pm_flux_sum *sums,
                                 double radius);
pm_estimate pm_density_over_ball(const pm_photon_map *map, const pm_flux_sum *sums,
                                 double radius);

/* Weight of volume photons: light that goes on towards `direction`. */
typedef struct pm_phase_towards {
    pm_vec3 direction;
    double g;
} pm_phase_towards;

pm_rgb pm_density_phase(const void *towards, const pm_photon *photon);

#endif
