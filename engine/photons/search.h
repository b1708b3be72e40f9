#ifndef PM_PHOTONS_SEARCH_H
#define PM_PHOTONS_SEARCH_H

#include "photons/map_internal.h"

/* Finding the photons around a point, in stored order. */

/* Which photons belong to the surface asked, as photon_map.h says. */
#define PM_NORMAL_COSINE 0.5
#define PM_TANGENT_SLOPE 0.25
#define PM_TANGENT_SLACK                                                                       \
    2.0 /* [grid units]; stored positions are off by half a unit an axis                       \
         */

typedef struct pm_search {
    const pm_photon_map *map;
    _Alignas(32) double point[4]; /* grid units */
    float normal[3];
    bool surface; /* test normals and tangent plane */
    bool careful; /* and leave out nodes off the plane: dear, but saves walking through them */
    pm_photon_filter filter;
    unsigned content[2];   /* which pm_contents a node must hold to be entered */
    double bound;          /* greatest squared distance, inclusive [grid units^2] */
    double radius;         /* its root */
    uint32_t known_normal; /* code of the last block with a single normal, or none */
    bool known_accepted;
    double known_mean[3];
} pm_search;

pm_search pm_search_surface(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                            pm_photon_filter filter);
pm_search pm_search_volume(const pm_photon_map *map, pm_vec3 point);

/* The bound, and what follows from it. */
static inline void pm_search_set_bound(pm_search *search, double bound)
{
    search->bound = bound;
    search->radius = sqrt(fmax(bound, 0));
}

enum { PM_TAKE_MAX = 256 };

/* Takes a list of up to PM_TAKE_MAX blocks that may hold photons within the bound, in stored
 * order. It may lower the bound. */
typedef void pm_take_blocks(void *context, pm_search *search, const uint32_t *blocks,
                            size_t count);

/* Hands out all such blocks, a few hundred at a time. */
void pm_search_walk(pm_search *search, pm_take_blocks *take, void *context);

/* A squared radius that probably holds somewhat more than the wanted photons, from the boxes
 * where the point would be stored; sets `careful` if they are far. Only speed depends on it. */
double pm_search_guess(pm_search *search, uint32_t wanted);

/* Sums of packed fluxes over photons found; squares for the variance. */
typedef struct pm_flux_sum {
    pm_rgb sum, square;
    uint32_t count;
} pm_flux_sum;

/* Sums the photons within search->bound. */
pm_flux_sum pm_search_sum(pm_search *search);

pm_flux_sum pm_search_sum_weighted(pm_search *search, const pm_photon_weight *weight);

enum { PM_CANDIDATES = PM_GATHER_MAX + PM_GATHER_MAX / 2 + 128 };

/* Photons found. */
typedef struct pm_candidates {
    uint32_t wanted, count;
    double limit;                                 /* none is farther [grid units^2] */
    _Alignas(32) double distance2[PM_CANDIDATES]; /* [grid units^2] */
    uint32_t index[PM_CANDIDATES];
} pm_candidates;

/* Finds the `wanted` photons nearest to the point; of equally distant ones those first in
 * stored order. Returns the squared distance of the next one, or INFINITY if no more than
 * `wanted` lie within search->bound: then all of them are found. */
double pm_search_nearest(pm_search *search, uint32_t wanted, pm_candidates *out);

/* Drops the farthest candidate and returns its squared distance; 0 if there is none. */
double pm_candidates_drop_farthest(pm_candidates *candidates);

/* Sums over the candidates. */
pm_flux_sum pm_candidates_sum(const pm_photon_map *map, const pm_candidates *candidates);
pm_flux_sum pm_candidates_sum_weighted(const pm_photon_map *map,
                                       const pm_candidates *candidates,
                                       const pm_photon_weight *weight);

#endif
