#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "photons/block_simd.h"

/* Appends d2[k .. k + 3] of the lanes whose bit is set, and their indices. */
static inline uint32_t append_four(pm_candidates *c, uint32_t n, size_t i, int k,
                                   unsigned lanes, const double *d2)
{
    /* for each set of lanes, the 32-bit halves of its doubles moved to the front */
    static const _Alignas(32) int8_t halves[16][8] = {{0},
                                                      {0, 1},
                                                      {2, 3},
                                                      {0, 1, 2, 3},
                                                      {4, 5},
                                                      {0, 1, 4, 5},
                                                      {2, 3, 4, 5},
                                                      {0, 1, 2, 3, 4, 5},
                                                      {6, 7},
                                                      {0, 1, 6, 7},
                                                      {2, 3, 6, 7},
                                                      {0, 1, 2, 3, 6, 7},
                                                      {4, 5, 6, 7},
                                                      {0, 1, 4, 5, 6, 7},
                                                      {2, 3, 4, 5, 6, 7},
                                                      {0, 1, 2, 3, 4, 5, 6, 7}};
    unsigned set = lanes >> k & 0xF;
    __m256i order =
        _mm256_cvtepi8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)halves[set]));
    __m256 moved = _mm256_permutevar8x32_ps(_mm256_castpd_ps(_mm256_load_pd(d2 + k)), order);
    _mm256_storeu_pd(c->distance2 + n, _mm256_castps_pd(moved));
    __m128i lane = _mm_setr_epi32(0, 1, 2, 3);
    lane =
        _mm_add_epi32(lane, _mm_set1_epi32((int)((uint32_t)i * PM_BLOCK_SIZE + (unsigned)k)));
    moved = _mm256_permutevar8x32_ps(
        _mm256_castpd_ps(_mm256_castsi256_pd(_mm256_cvtepu32_epi64(lane))), order);
    __m256i even = _mm256_permutevar8x32_epi32(_mm256_castps_si256(moved),
                                               _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
    _mm_storeu_si128((__m128i *)(void *)(c->index + n), _mm256_castsi256_si128(even));
    return n + (uint32_t)__builtin_popcount(set);
}

static uint32_t count_up_to(const pm_candidates *c, double limit)
{
    __m256d t = _mm256_set1_pd(limit);
    __m256i count = _mm256_setzero_si256();
    for (uint32_t i = 0; i < c->count; i += 4) {
        __m256d le = _mm256_cmp_pd(_mm256_load_pd(c->distance2 + i), t, _CMP_LE_OQ);
        count = _mm256_sub_epi64(count, _mm256_castpd_si256(le));
    }
    _Alignas(32) uint64_t lane[4];
    _mm256_store_si256((__m256i *)(void *)lane, count);
    return (uint32_t)(lane[0] + lane[1] + lane[2] + lane[3]);
}

/* The least distance^2 above `limit`. */
static double next_above(const pm_candidates *c, double limit)
{
    __m256d t = _mm256_set1_pd(limit), least = _mm256_set1_pd(INFINITY);
    for (uint32_t i = 0; i < c->count; i += 4) {
        __m256d v = _mm256_load_pd(c->distance2 + i);
        v = _mm256_blendv_pd(_mm256_set1_pd(INFINITY), v, _mm256_cmp_pd(v, t, _CMP_GT_OQ));
        least = _mm256_min_pd(least, v);
    }
    _Alignas(32) double lane[4];
    _mm256_store_pd(lane, least);
    return fmin(fmin(lane[0], lane[1]), fmin(lane[2], lane[3]));
}

/* Halfway between two doubles >= 0 in the order of their bits, which any run of halvings ends.
 */
static double middle_double(double a, double b)
{
    uint64_t p, q;
    memcpy(&p, &a, sizeof p);
    memcpy(&q, &b, sizeof q);
    p += (q - p) / 2;
    memcpy(&a, &p, sizeof a);
    return a;
}

/* The wanted-th least distance^2 among the candidates, at least `wanted` of which there are:
 * brackets it by interpolation and halving in turn, then walks over the last few. */
static double select_distance(pm_candidates *c, double high)
{
    for (uint32_t i = c->count; i % 4; i++)
        c->distance2[i] = INFINITY;
    double low = 0;
    uint32_t below = count_up_to(c, 0), above = c->count;
    if (below >= c->wanted)
        return 0;
    for (int turn = 0; above - below > 4 && turn < 128; turn++) {
        double part = (c->wanted - below - 0.5) / (above - below);
        double t = turn & 1 ? middle_double(low, high) : low + (high - low) * part;
        uint32_t count = count_up_to(c, t);
        if (count >= c->wanted) {
            high = t;
            above = count;
        } else {
            low = t;
            below = count;
        }
    }
    while (below < c->wanted) {
        low = next_above(c, low);
        below = count_up_to(c, low);
    }
    return low;
}

/* Leaves the wanted ones; returns the greatest distance^2. */
static double keep_nearest(pm_candidates *c, double bound)
{
    double limit = select_distance(c, bound);
    uint32_t n = 0, closer = 0;
    for (uint32_t i = 0; i < c->count; i++)
        closer += c->distance2[i] < limit;
    uint32_t ties = c->wanted - closer;
    for (uint32_t i = 0; i < c->count; i++) {
        bool tie = ties && c->distance2[i] == limit;
        ties -= tie;
        c->distance2[n] = c->distance2[i];
        c->index[n] = c->index[i];
        n += tie || c->distance2[i] < limit;
    }
    c->count = n;
    return limit;
}

static void take_candidates(void *context, pm_search *s, const uint32_t *blocks, size_t count)
{
    pm_candidates *c = context;
    for (size_t i = 0; i < count; i++) {
        _Alignas(32) double d2[PM_BLOCK_SIZE];
        unsigned lanes = block_mask(blocks[i], s, d2);
        uint32_t n = c->count;
        for (int k = 0; k < PM_BLOCK_SIZE; k += 4)
            n = append_four(c, n, blocks[i], k, lanes, d2);
        c->count = n;
        if (n < c->wanted + c->wanted / 2 + 64)
            continue;
        /* later photons at the same distance come later in stored order, so they lose */
        pm_search_set_bound(s, nextafter(keep_nearest(c, s->bound), -1));
    }
}

static void gather(pm_search *s, pm_candidates *c)
{
    c->count = 0;
    pm_search_walk(s, take_candidates, c);
}

static double farthest(const pm_candidates *c)
{
    double most = 0;
    for (uint32_t i = 0; i < c->count; i++)
        most = c->distance2[i] > most ? c->distance2[i] : most;
    return most;
}

void pm_candidates_drop_farthest(pm_candidates *c)
{
    if (!c->count)
        return;
    uint32_t last = 0;
    for (uint32_t i = 1; i < c->count; i++)
        if (c->distance2[i] >= c->distance2[last])
            last = i;
    c->count--;
    for (uint32_t i = last; i < c->count; i++) {
        c->distance2[i] = c->distance2[i + 1];
        c->index[i] = c->index[i + 1];
    }
}

/* A squared radius beyond which there is no photon. */
static double whole_map(const pm_search *s)
{
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        double d = fabs(s->point[a]) + PM_GRID_PER_WORLD;
        sum += d * d;
    }
    return sum;
}

double pm_search_nearest(pm_search *s, uint32_t wanted, pm_candidates *out)
{
    assert(wanted <= PM_GATHER_MAX + 1);
    double most = s->bound;
    out->wanted = wanted;
    out->count = 0;
    if (!wanted || !s->map->levels)
        return 0;
    if (most > whole_map(s))
        most = whole_map(s);
    double bound = pm_search_guess(s, wanted);
    for (;;) {
        double searched = bound < most ? bound : most;
        pm_search_set_bound(s, searched);
        gather(s, out);
        if (out->count >= wanted)
            return out->count > wanted ? keep_nearest(out, s->bound) : farthest(out);
        if (searched >= most)
            return farthest(out);
        double missing = 1.5 * wanted / (out->count + 1.0);
        bound = searched * fmin(missing, 16);
    }
}
