#include <assert.h>
#include <math.h>

#include "base/maths.h"
#include "photons/density.h"
#include "world/media.h"

/* Density estimates from the photons that a search finds. */

/* Stored positions are multiples of this, so no smaller radius means anything: photons in one
 * point give a finite density. */
#define RESOLUTION (1 / PM_GRID_PER_WORLD)

static double squared_bound(double radius)
{
    double r = radius * PM_GRID_PER_WORLD;
    return r * r;
}

bool pm_photon_counts(pm_vec3 point, pm_vec3 normal, pm_vec3 photon, pm_vec3 photon_normal)
{
    pm_vec3 way = pm_vec3_sub(photon, point);
    pm_vec3 mean = pm_vec3_scale(pm_vec3_add(normal, photon_normal), .5);
    double height = fabs(pm_vec3_dot(mean, way)) - PM_TANGENT_SLACK / PM_GRID_PER_WORLD;
    return pm_vec3_dot(normal, photon_normal) >= PM_NORMAL_COSINE &&
           height <= PM_TANGENT_SLOPE * pm_vec3_length(way);
}

/* Turns sums of packed fluxes into a density over `measure` [world units^2 or ^3]. */
static pm_estimate estimate(const pm_photon_map *map, const pm_flux_sum *sums, double radius,
                            double measure)
{
    double scale = map->header.flux_scale / (double)map->header.paths / measure;
    return (pm_estimate){
        .irradiance = pm_rgb_scale(sums->sum, scale),
        .variance = pm_rgb_scale(pm_rgb_scale(sums->square, scale), scale),
        .radius = radius,
        .count = sums->count,
    };
}

pm_estimate pm_density_over_disc(const pm_photon_map *map, const pm_flux_sum *sums,
                                 double radius)
{
    if (!sums->count)
        return (pm_estimate){.count = 0};
    radius = fmax(radius, RESOLUTION);
    return estimate(map, sums, radius, PM_PI * radius * radius);
}

pm_estimate pm_density_over_ball(const pm_photon_map *map, const pm_flux_sum *sums,
                                 double radius)
{
    if (!sums->count)
        return (pm_estimate){.count = 0};
    radius = fmax(radius, RESOLUTION);
    return estimate(map, sums, radius, 4.0 / 3 * PM_PI * radius * radius * radius);
}

double pm_density_find(pm_search *search, uint32_t gather_count, double max_radius,
                       pm_candidates *found)
{
    assert(gather_count >= 1 && gather_count <= PM_GATHER_MAX && max_radius > 0);
    search->bound = squared_bound(max_radius);
    double next2 = pm_search_nearest(search, gather_count, found);
    if (isinf(next2) && isfinite(max_radius))
        return max_radius;
    if (isinf(next2))
        next2 = pm_candidates_drop_farthest(found);
    return sqrt(next2) / PM_GRID_PER_WORLD;
}

pm_estimate pm_photon_map_nearest(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                  uint32_t gather_count, double max_radius,
                                  pm_photon_filter filter, const pm_photon_weight *weight)
{
    pm_search search = pm_search_surface(map, point, normal, filter);
    pm_candidates found;
    double radius = pm_density_find(&search, gather_count, max_radius, &found);
    pm_flux_sum sums = weight ? pm_candidates_sum_weighted(map, &found, weight)
                              : pm_candidates_sum(map, &found);
    return pm_density_over_disc(map, &sums, radius);
}

pm_estimate pm_photon_map_within(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                 double radius, pm_photon_filter filter,
                                 const pm_photon_weight *weight)
{
    assert(radius > 0 && isfinite(radius));
    pm_search search = pm_search_surface(map, point, normal, filter);
    search.bound = squared_bound(radius);
    pm_flux_sum sums =
        weight ? pm_search_sum_weighted(&search, weight) : pm_search_sum(&search);
    return pm_density_over_disc(map, &sums, radius);
}

bool pm_photon_map_closest(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                           double max_radius, size_t *index)
{
    assert(max_radius > 0);
    pm_search search = pm_search_surface(map, point, normal, PM_PHOTONS_ALL);
    search.bound = squared_bound(max_radius);
    pm_candidates found;
    pm_search_nearest(&search, 1, &found);
    if (found.count)
        *index = found.index[0];
    return found.count != 0;
}

pm_rgb pm_density_phase(const void *context, pm_vec3 wi)
{
    const pm_phase_towards *phase = context;
    /* the photon came from wi, so it was going the other way */
    return pm_rgb_grey(pm_phase(phase->g, -pm_vec3_dot(wi, phase->direction)));
}

pm_estimate pm_photon_map_volume(const pm_photon_map *map, pm_vec3 point, pm_vec3 direction,
                                 double g, uint32_t gather_count, double max_radius)
{
    pm_search search = pm_search_volume(map, point);
    pm_candidates found;
    double radius = pm_density_find(&search, gather_count, max_radius, &found);
    const pm_phase_towards phase = {direction, g};
    pm_flux_sum sums =
        pm_candidates_sum_weighted(map, &found, &(pm_photon_weight){pm_density_phase, &phase});
    return pm_density_over_ball(map, &sums, radius);
}

pm_estimate pm_photon_map_volume_within(const pm_photon_map *map, pm_vec3 point,
                                        pm_vec3 direction, double g, double radius)
{
    assert(radius > 0 && isfinite(radius));
    pm_search search = pm_search_volume(map, point);
    search.bound = squared_bound(radius);
    const pm_phase_towards phase = {direction, g};
    pm_flux_sum sums =
        pm_search_sum_weighted(&search, &(pm_photon_weight){pm_density_phase, &phase});
    return pm_density_over_ball(map, &sums, radius);
}
