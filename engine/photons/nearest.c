#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "photons/block_simd.h"
#include "photons/list_simd.h"

/* For each set of 4 lanes, the 32-bit halves of its doubles moved to the front. */
static const _Alignas(32) int8_t front_halves[16][8] = {
    {0},
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
    {0, 1, 2, 3, 4, 5, 6, 7},
};

/* Writes the doubles whose bit is set, then others up to 4; returns how many count. */
static inline uint32_t pack_four(double *out, __m256d v, unsigned set)
{
    __m128i halves = _mm_loadl_epi64((const __m128i *)(const void *)front_halves[set]);
    __m256 packed = _mm256_permutevar8x32_ps(_mm256_castpd_ps(v), _mm256_cvtepi8_epi32(halves));
    _mm256_storeu_pd(out, _mm256_castps_pd(packed));
    return (uint32_t)__builtin_popcount(set);
}

/* Appends the photons of block i whose bit is set. */
static inline void append(pm_candidates *c, uint32_t i, unsigned lanes, const double *distance2)
{
    uint32_t n = c->count;
    list_bits(c->index + n, i * PM_BLOCK_SIZE, lanes);
    for (int k = 0; k < PM_BLOCK_SIZE; k += 4)
        n += pack_four(c->distance2 + n, _mm256_load_pd(distance2 + k), lanes >> k & 0xF);
    c->count = n;
}

/* Fills the last vector up, for the functions below. */
static void fill_up(pm_candidates *c)
{
    for (uint32_t i = c->count; i % 4; i++)
        c->distance2[i] = INFINITY;
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

/* Halfway between two doubles >= 0 in the order of their bits: 64 halvings end anywhere. */
static double middle_double(double a, double b)
{
    uint64_t p, q;
    memcpy(&p, &a, sizeof p);
    memcpy(&q, &b, sizeof q);
    p += (q - p) / 2;
    memcpy(&a, &p, sizeof a);
    return a;
}

/* The rank-th least distance^2 among at least so many candidates: brackets it by interpolation
 * and halving in turn, then walks over the last few. */
static double select_distance(const pm_candidates *c, uint32_t rank)
{
    double low = 0, high = c->limit;
    uint32_t below = count_up_to(c, 0), above = c->count;
    if (below >= rank)
        return 0;
    for (int turn = 0; above - below > 4 && turn < 128; turn++) {
        double part = (rank - below - 0.5) / (above - below);
        double t = turn & 1 ? middle_double(low, high) : low + (high - low) * part;
        uint32_t count = count_up_to(c, t);
        if (count >= rank) {
            high = t;
            above = count;
        } else {
            low = t;
            below = count;
        }
    }
    while (below < rank) {
        low = next_above(c, low);
        below = count_up_to(c, low);
    }
    return low;
}

/* The greatest double below x >= 0, or a negative one. */
static double just_below(double x)
{
    return x > 0 ? nextafter(x, -1) : -1;
}

/* Keeps the first `count` candidates in the order of distance, of which the farthest are at
 * `limit`. Equal ones count in stored order, in which the candidates are and stay. */
static void keep(pm_candidates *c, uint32_t count, double limit)
{
    uint32_t n = 0, ties = count - count_up_to(c, just_below(limit));
    for (uint32_t i = 0; i < c->count; i++) {
        bool tie = ties && c->distance2[i] == limit;
        ties -= tie;
        c->distance2[n] = c->distance2[i];
        c->index[n] = c->index[i];
        n += tie || c->distance2[i] < limit;
    }
    c->count = n;
}

static void take_candidates(void *context, pm_search *s, const uint32_t *blocks, size_t count)
{
    pm_candidates *c = context;
    for (size_t i = 0; i < count; i++) {
        _Alignas(32) double distance2[PM_BLOCK_SIZE];
        append(c, blocks[i], block_mask(blocks[i], s, distance2), distance2);
        if (c->count <= c->wanted + c->wanted / 2 + 64)
            continue;
        fill_up(c);
        c->limit = select_distance(c, c->wanted + 1);
        keep(c, c->wanted + 1, c->limit);
        /* later photons at the same distance come later in stored order, so they lose */
        pm_search_set_bound(s, just_below(c->limit));
    }
}

static void gather(pm_search *s, pm_candidates *c)
{
    c->count = 0;
    c->limit = s->bound;
    pm_search_walk(s, take_candidates, c);
    fill_up(c);
}

double pm_candidates_drop_farthest(pm_candidates *c)
{
    double limit = 0;
    for (uint32_t i = 0; i < c->count; i++)
        limit = fmax(limit, c->distance2[i]);
    if (c->count)
        keep(c, c->count - 1, limit);
    return limit;
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
    assert(wanted && wanted <= PM_GATHER_MAX);
    double most = fmin(s->bound, whole_map(s));
    double bound = s->map->levels ? pm_search_guess(s, wanted + 1) : most;
    out->wanted = wanted;
    for (;;) {
        double searched = fmin(bound, most);
        pm_search_set_bound(s, searched);
        gather(s, out);
        if (out->count > wanted) {
            double next = select_distance(out, wanted + 1);
            keep(out, wanted, next);
            return next;
        }
        if (searched >= most)
            return INFINITY;
        double missing = 1.5 * (wanted + 1) / (out->count + 1.0);
        bound = searched * fmin(missing, 16);
        s->careful = s->surface;
    }
}
