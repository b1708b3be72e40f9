#include "photons/bias.h"

#include <assert.h>
#include <math.h>

#include "base/warp.h"
#include "photons/density.h"
#include "photons/ranked.h"

const char *pm_bandwidth_name(pm_bandwidth bandwidth)
{
    static const char *const names[PM_BANDWIDTHS] = {"bias", "chi2"};
    assert(bandwidth < PM_BANDWIDTHS);
    return names[bandwidth];
}

/* ---- estimates from the k nearest ---- */

/* The photons found, and what is asked of them. */
struct found {
    const pm_search *search;
    const pm_photon_map *map;
    const pm_photon_weight *weight; /* NULL: 1 */
    const pm_ranked *ranked;
};

/* Adds photons until there are k. */
static void take_up_to(const struct found *f, uint32_t k, pm_flux_sum *sums)
{
    for (; sums->count < k; sums->count++) {
        pm_photon photon;
        pm_photon_map_photon(f->map, f->ranked->index[sums->count], &photon);
        pm_rgb flux = pm_photon_flux(&photon);
        if (f->weight)
            flux = pm_rgb_mul(flux, f->weight->of(f->weight->context, &photon));
        sums->sum = pm_rgb_add(sums->sum, flux);
        sums->square = pm_rgb_add(sums->square, pm_rgb_mul(flux, flux));
    }
}

/* Inverse area of the disc, or volume of the ball, that reaches to the next photon, but for a
 * factor that all share. */
static double inverse_measure(const struct found *f, uint32_t k)
{
    double d2 = fmax(f->ranked->distance2[k], 1);
    return 1 / (f->search->surface ? d2 : d2 * sqrt(d2));
}

static double sum_of(pm_rgb c)
{
    return c.r + c.g + c.b;
}

/* ---- bias compensation ---- */

/* Estimates so far: their weighted sums. */
struct history {
    double weight, square;
    pm_rgb mean;
};

static void remember(struct history *h, uint32_t k, pm_rgb estimate)
{
    double weight = (double)k * k;
    h->weight += weight;
    h->mean = pm_rgb_madd(h->mean, weight, estimate);
    h->square += weight * sum_of(pm_rgb_mul(estimate, estimate));
}

/* Whether an estimate differs from the earlier ones by more than their noise. */
static bool is_biased(const struct history *h, pm_rgb estimate, double own_variance)
{
    const double deviations = 2.25;
    pm_rgb mean = pm_rgb_scale(h->mean, 1 / h->weight);
    pm_rgb off = pm_rgb_sub(estimate, mean);
    double running = h->square / h->weight - sum_of(pm_rgb_mul(mean, mean));
    return sum_of(pm_rgb_mul(off, off)) > deviations * deviations * fmax(running, own_variance);
}

static pm_flux_sum compensate(const struct found *f, uint32_t least)
{
    struct history history = {0};
    pm_flux_sum low = {.count = 0};
    /* a single photon's estimate has no finite variance */
    for (uint32_t k = least > 1 ? 2 : 1; k <= least; k++) {
        take_up_to(f, k, &low);
        remember(&history, k, pm_rgb_scale(low.sum, inverse_measure(f, k)));
    }
    uint32_t high = f->ranked->count + 1;
    double inverse = inverse_measure(f, least);
    while (high - low.count > 1) {
        uint32_t k = low.count + (high - low.count) / 2;
        pm_flux_sum middle = low;
        take_up_to(f, k, &middle);
        double inverse_middle = inverse_measure(f, k);
        pm_rgb estimate = pm_rgb_scale(middle.sum, inverse_middle);
        if (is_biased(&history, estimate, sum_of(low.square) * inverse * inverse)) {
            high = k;
            continue;
        }
        remember(&history, k, estimate);
        low = middle;
        inverse = inverse_middle;
    }
    return low;
}

/* ---- chi-squared hold ---- */

enum { SECTORS = 8 };

static unsigned sector_of(const struct found *f, const pm_frame *frame, uint32_t rank)
{
    const pm_photon_block *block = &f->map->blocks[f->ranked->index[rank] / PM_BLOCK_SIZE];
    unsigned lane = f->ranked->index[rank] % PM_BLOCK_SIZE;
    pm_vec3 way = {(double)(block->position[0][lane] - f->search->point[0]),
                   (double)(block->position[1][lane] - f->search->point[1]),
                   (double)(block->position[2][lane] - f->search->point[2])};
    if (!f->search->surface)
        return (way.x < 0) | (way.y < 0) << 1 | (way.z < 0) << 2;
    double x = pm_vec3_dot(way, frame->x), y = pm_vec3_dot(way, frame->y);
    return (x < 0) | (y < 0) << 1 | (fabs(x) < fabs(y)) << 2;
}

static bool is_even(const uint32_t counts[SECTORS], uint32_t total)
{
    const double quantile = 29.88; /* 1 - 1e-4, of SECTORS - 1 degrees of freedom */
    double expected = (double)total / SECTORS, chi2 = 0;
    for (int s = 0; s < SECTORS; s++)
        chi2 += (counts[s] - expected) * (counts[s] - expected);
    return chi2 <= quantile * expected;
}

static pm_flux_sum hold(const struct found *f, uint32_t least)
{
    pm_frame frame =
        pm_frame_make((pm_vec3){(double)f->search->normal[0], (double)f->search->normal[1],
                                (double)f->search->normal[2]});
    uint32_t counts[SECTORS] = {0}, counted = 0, kept = least;
    for (uint32_t k = least;; k += k / 5 + 1) {
        k = k < f->ranked->count ? k : f->ranked->count;
        for (; counted < k; counted++)
            counts[sector_of(f, &frame, counted)]++;
        if (!is_even(counts, k))
            break;
        kept = k;
        if (k == f->ranked->count)
            break;
    }
    pm_flux_sum sums = {.count = 0};
    take_up_to(f, kept, &sums);
    return sums;
}

/* ---- together ---- */

static pm_estimate adapt(pm_search *search, const pm_gather_range *range,
                         const pm_photon_weight *weight)
{
    assert(range->least && range->least <= range->most && range->most <= PM_GATHER_MAX);
    pm_candidates candidates;
    pm_ranked ranked;
    double radius = pm_density_find(search, range->most, INFINITY, &candidates);
    double next = radius * PM_GRID_PER_WORLD;
    pm_ranked_sort(&candidates, next * next, &ranked);
    const struct found found = {search, search->map, weight, &ranked};
    pm_flux_sum sums = {.count = 0};
    if (ranked.count <= range->least)
        take_up_to(&found, ranked.count, &sums);
    else
        sums =
            (range->bandwidth == PM_BANDWIDTH_CHI2 ? hold : compensate)(&found, range->least);
    radius = sqrt(ranked.distance2[sums.count]) / PM_GRID_PER_WORLD;
    return (search->surface ? pm_density_over_disc : pm_density_over_ball)(search->map, &sums,
                                                                           radius);
}

pm_estimate pm_photon_map_adapted(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                                  const pm_gather_range *range, pm_photon_filter filter,
                                  const pm_photon_weight *weight)
{
    pm_search search = pm_search_surface(map, point, normal, filter);
    return adapt(&search, range, weight);
}

pm_estimate pm_photon_map_volume_adapted(const pm_photon_map *map, pm_vec3 point,
                                         pm_vec3 direction, double g,
                                         const pm_gather_range *range)
{
    pm_search search = pm_search_volume(map, point);
    const pm_phase_towards phase = {direction, g};
    return adapt(&search, range, &(pm_photon_weight){pm_density_phase, &phase});
}
