#include <assert.h>
#include <math.h>

#include "base/maths.h"
#include "photons/density.h"
#include "world/media.h"

/* Density estimates from the photons that a search finds. */

/* Stored positions are multiples of this, so no smaller radius means anything: photons in one
 * point give a finite density. */
#define RESOLUTION (1 / PM_GRID_PER_WORLD)

bool pm_photon_counts(pm_vec3 point, pm_vec3 normal, pm_vec3 photon, pm_vec3 photon_normal)
{
    pm_vec3 way = pm_vec3_sub(photon, point);
    pm_vec3 mean = pm_vec3_scale(pm_vec3_add(normal, photon_normal), .5);
    double slack = (double)PM_TANGENT_SLACK / PM_GRID_PER_WORLD;
    double height = fabs(pm_vec3_dot(mean, way)) - slack;
    return pm_vec3_dot(normal, photon_normal) >= (double)PM_NORMAL_COSINE &&
           height <= (double)PM_TANGENT_SLOPE * pm_vec3_length(way);
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

/* ---- within a fixed radius ---- */

enum { QUESTIONS = 64 };

struct questions {
    size_t count;
    pm_search searches[QUESTIONS];
    const pm_photon_weight *weights[QUESTIONS];
    pm_flux_sum sums[QUESTIONS];
};

static bool same_normal(const pm_photon_query *a, const pm_photon_query *b)
{
    return a->normal.x == b->normal.x && a->normal.y == b->normal.y &&
           a->normal.z == b->normal.z;
}

static void put_questions(const pm_photon_map *map, const pm_photon_query *queries,
                          size_t count, pm_photon_filter filter, struct questions *out)
{
    out->count = count < QUESTIONS ? count : QUESTIONS;
    for (size_t i = 0; i < out->count; i++) {
        assert(queries[i].radius > 0);
        if (i && same_normal(&queries[i], &queries[i - 1]))
            out->searches[i] = pm_search_beside(&out->searches[i - 1], queries[i].point);
        else
            out->searches[i] =
                pm_search_surface(map, queries[i].point, queries[i].normal, filter);
        pm_search_set_bound(&out->searches[i], pm_search_bound(queries[i].radius));
        out->weights[i] = queries[i].weight;
    }
}

void pm_photon_map_within_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                size_t count, pm_photon_filter filter, pm_estimate *out)
{
    struct questions q;
    for (size_t i = 0; i < count; i += q.count) {
        put_questions(map, queries + i, count - i, filter, &q);
        pm_sum_within(q.searches, q.count, q.weights, q.sums);
        for (size_t k = 0; k < q.count; k++)
            out[i + k] = pm_density_over_disc(map, &q.sums[k], queries[i + k].radius);
    }
}

pm_estimate pm_photon_map_within(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                 double radius, pm_photon_filter filter,
                                 const pm_photon_weight *weight)
{
    assert(isfinite(radius));
    const pm_photon_query query = {point, normal, radius, weight};
    pm_estimate out;
    pm_photon_map_within_batch(map, &query, 1, filter, &out);
    return out;
}

/* ---- from the nearest ---- */

/* The radius that holds what was summed: that of the photon behind them, or max_radius if there
 * is none, or without it that of the farthest, which is then left out. */
static double radius_of(pm_search *search, double next2, double max_radius,
                        const pm_photon_weight *weight, pm_nearest *work, pm_flux_sum *sums)
{
    if (isinf(next2) && isfinite(max_radius))
        return max_radius;
    if (isinf(next2) && sums->count < 2) {
        *sums = (pm_flux_sum){.count = 0};
        return 0;
    }
    if (isinf(next2)) {
        pm_guess guess = {.bound = 0};
        pm_search_set_bound(search, INFINITY);
        pm_nearest_sum(search, 1, sums->count - 1, &weight, &guess, work, sums, &next2);
    }
    return sqrt(next2) / PM_GRID_PER_WORLD;
}

void pm_photon_map_nearest_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                 size_t count, uint32_t gather_count, pm_photon_filter filter,
                                 pm_estimate *out)
{
    assert(gather_count >= 1 && gather_count <= PM_GATHER_MAX);
    struct questions q;
    double next2[QUESTIONS];
    pm_guess guess = {.bound = 0};
    pm_nearest work;
    for (size_t i = 0; i < count; i += q.count) {
        put_questions(map, queries + i, count - i, filter, &q);
        pm_nearest_sum(q.searches, q.count, gather_count, q.weights, &guess, &work, q.sums,
                       next2);
        for (size_t k = 0; k < q.count; k++) {
            double radius = radius_of(&q.searches[k], next2[k], queries[i + k].radius,
                                      q.weights[k], &work, &q.sums[k]);
            out[i + k] = pm_density_over_disc(map, &q.sums[k], radius);
        }
    }
}

pm_estimate pm_photon_map_nearest(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                  uint32_t gather_count, double max_radius,
                                  pm_photon_filter filter, const pm_photon_weight *weight)
{
    const pm_photon_query query = {point, normal, max_radius, weight};
    pm_estimate out;
    pm_photon_map_nearest_batch(map, &query, 1, gather_count, filter, &out);
    return out;
}

void pm_photon_map_closest_batch(const pm_photon_map *map, const pm_photon_query *queries,
                                 size_t count, size_t *index)
{
    struct questions q;
    pm_guess guess = {.bound = 0};
    pm_list list;
    for (size_t i = 0; i < count; i += q.count) {
        put_questions(map, queries + i, count - i, PM_PHOTONS_ALL, &q);
        pm_nearest_one(q.searches, q.count, &guess, &list, index + i);
    }
}

bool pm_photon_map_closest(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                           double max_radius, size_t *index)
{
    const pm_photon_query query = {point, normal, max_radius, NULL};
    size_t found;
    pm_photon_map_closest_batch(map, &query, 1, &found);
    if (found != SIZE_MAX)
        *index = found;
    return found != SIZE_MAX;
}

/* ---- photons for other estimates ---- */

static void drop_farthest(pm_candidates *c, double limit)
{
    uint32_t last = 0;
    for (uint32_t i = 0; i < c->count; i++)
        last = c->distance2[i] == limit ? i : last;
    c->count -= c->count != 0;
    for (uint32_t i = last; i < c->count; i++) {
        c->distance2[i] = c->distance2[i + 1];
        c->index[i] = c->index[i + 1];
    }
}

double pm_density_find(pm_search *search, uint32_t gather_count, double max_radius,
                       pm_candidates *found)
{
    assert(gather_count >= 1 && gather_count <= PM_GATHER_MAX && max_radius > 0);
    pm_search_set_bound(search, pm_search_bound(max_radius));
    double next2 = pm_search_nearest(search, gather_count, found);
    if (isinf(next2) && isfinite(max_radius))
        return max_radius;
    if (isinf(next2)) {
        next2 = 0;
        for (uint32_t i = 0; i < found->count; i++)
            next2 = fmax(next2, found->distance2[i]);
        drop_farthest(found, next2);
    }
    return sqrt(next2) / PM_GRID_PER_WORLD;
}

/* ---- in a medium ---- */

pm_rgb pm_density_phase(const void *context, const pm_photon *photon)
{
    const pm_phase_towards *phase = context;
    /* the photon came from wi, so it was going the other way */
    return pm_rgb_grey(
        pm_phase(phase->g, -pm_vec3_dot(pm_photon_direction(photon), phase->direction)));
}

pm_estimate pm_photon_map_volume(const pm_photon_map *map, pm_vec3 point, pm_vec3 direction,
                                 double g, uint32_t gather_count, double max_radius)
{
    assert(max_radius > 0 && gather_count >= 1 && gather_count <= PM_GATHER_MAX);
    pm_search search = pm_search_volume(map, point);
    pm_search_set_bound(&search, pm_search_bound(max_radius));
    const pm_phase_towards phase = {direction, g};
    const pm_photon_weight weight = {pm_density_phase, &phase}, *weights = &weight;
    pm_guess guess = {.bound = 0};
    pm_nearest work;
    pm_flux_sum sums;
    double next2;
    pm_nearest_sum(&search, 1, gather_count, &weights, &guess, &work, &sums, &next2);
    double radius = radius_of(&search, next2, max_radius, &weight, &work, &sums);
    return pm_density_over_ball(map, &sums, radius);
}

pm_estimate pm_photon_map_volume_within(const pm_photon_map *map, pm_vec3 point,
                                        pm_vec3 direction, double g, double radius)
{
    assert(radius > 0 && isfinite(radius));
    pm_search search = pm_search_volume(map, point);
    pm_search_set_bound(&search, pm_search_bound(radius));
    const pm_phase_towards phase = {direction, g};
    const pm_photon_weight weight = {pm_density_phase, &phase}, *weights = &weight;
    pm_flux_sum sums;
    pm_sum_within(&search, 1, &weights, &sums);
    return pm_density_over_ball(map, &sums, radius);
}
