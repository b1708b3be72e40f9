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

/* The photons found, what is asked of them, and what the first k of them bring, which is found
 * out when it is asked for. */
struct found {
    const pm_search *search;
    const pm_photon_map *map;
    const pm_photon_weight *weight; /* NULL: 1 */
    pm_ranked ranked;
    uint32_t known;
    pm_rgb sum[PM_GATHER_MAX + 1], square[PM_GATHER_MAX + 1];
};

static pm_rgb flux_of(const struct found *f, uint32_t rank)
{
    const pm_photon_block *block = &f->map->blocks[f->ranked.index[rank] / PM_BLOCK_SIZE];
    unsigned lane = f->ranked.index[rank] % PM_BLOCK_SIZE;
    pm_photon photon = {.flux = block->flux[lane], .exponent = block->exponent[lane]};
    if (!f->weight)
        return pm_photon_flux(&photon);
    pm_photon_map_photon(f->map, f->ranked.index[rank], &photon);
    return pm_rgb_mul(pm_photon_flux(&photon), f->weight->of(f->weight->context, &photon));
}

static pm_flux_sum sum_of_first(struct found *f, uint32_t k)
{
    for (; f->known < k; f->known++) {
        pm_rgb flux = flux_of(f, f->known);
        f->sum[f->known + 1] = pm_rgb_add(f->sum[f->known], flux);
        f->square[f->known + 1] = pm_rgb_add(f->square[f->known], pm_rgb_mul(flux, flux));
    }
    return (pm_flux_sum){f->sum[k], f->square[k], k};
}

/* Inverse area of the disc, or volume of the ball, that reaches to the next photon, but for a
 * factor that all share. */
static double inverse_measure(const struct found *f, uint32_t k)
{
    double d2 = fmax(f->ranked.distance2[k], 1);
    return 1 / (f->search->surface ? d2 : d2 * sqrt(d2));
}

static double pow_2(double v)
{
    return v * v;
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

/* How many photons are taken. */
static uint32_t compensate(struct found *f, uint32_t least)
{
    struct history history = {0};
    uint32_t low = least, high = f->ranked.count + 1;
    /* a single photon's estimate has no finite variance */
    for (uint32_t k = least > 1 ? 2 : 1; k <= least; k++)
        remember(&history, k, pm_rgb_scale(sum_of_first(f, k).sum, inverse_measure(f, k)));
    while (high - low > 1) {
        uint32_t k = low + (high - low) / 2;
        double own = sum_of(f->square[low]) * pow_2(inverse_measure(f, low));
        pm_rgb estimate = pm_rgb_scale(sum_of_first(f, k).sum, inverse_measure(f, k));
        if (is_biased(&history, estimate, own)) {
            high = k;
            continue;
        }
        remember(&history, k, estimate);
        low = k;
    }
    return low;
}

/* ---- chi-squared hold ---- */

enum { SECTORS = 8 };

static unsigned sector_of(const struct found *f, const pm_frame *frame, uint32_t rank)
{
    const pm_photon_block *block = &f->map->blocks[f->ranked.index[rank] / PM_BLOCK_SIZE];
    unsigned lane = f->ranked.index[rank] % PM_BLOCK_SIZE;
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

static uint32_t hold(struct found *f, uint32_t least)
{
    pm_frame frame =
        pm_frame_make((pm_vec3){(double)f->search->normal[0], (double)f->search->normal[1],
                                (double)f->search->normal[2]});
    uint32_t counts[SECTORS] = {0}, counted = 0, kept = least;
    for (uint32_t k = least;; k += k / 5 + 1) {
        k = k < f->ranked.count ? k : f->ranked.count;
        for (; counted < k; counted++)
            counts[sector_of(f, &frame, counted)]++;
        if (!is_even(counts, k))
            break;
        kept = k;
        if (k == f->ranked.count)
            break;
    }
    return kept;
}

/* ---- together ---- */

static pm_estimate adapt(pm_search *search, const pm_gather_range *range,
                         const pm_photon_weight *weight)
{
    assert(range->least && range->least <= range->most && range->most <= PM_GATHER_MAX);
    pm_candidates candidates;
    struct found found;
    double radius = pm_density_find(search, range->most, INFINITY, &candidates);
    double next = radius * PM_GRID_PER_WORLD;
    pm_ranked_sort(&candidates, next * next, &found.ranked);
    found.search = search;
    found.map = search->map;
    found.weight = weight;
    found.known = 0;
    found.sum[0] = found.square[0] = pm_rgb_grey(0);
    uint32_t count = found.ranked.count;
    if (count > range->least)
        count =
            (range->bandwidth == PM_BANDWIDTH_CHI2 ? hold : compensate)(&found, range->least);
    pm_flux_sum sums = sum_of_first(&found, count);
    radius = sqrt(found.ranked.distance2[count]) / PM_GRID_PER_WORLD;
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
