#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "photons/visit.h"

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

static inline void take_candidates(void *context, pm_search *s, size_t i, unsigned lanes,
                                   const double *d2)
{
    pm_candidates *c = context;
    uint32_t n = c->count;
    n = append_four(c, n, i, 0, lanes, d2);
    n = append_four(c, n, i, 4, lanes, d2);
    n = append_four(c, n, i, 8, lanes, d2);
    n = append_four(c, n, i, 12, lanes, d2);
    c->count = n;
    if (n < c->wanted + c->wanted / 2 + 64)
        return;
    /* later photons at the same distance come later in stored order, so they lose */
    pm_search_set_bound(s, nextafter(keep_nearest(c, s->bound), -1));
}

static void gather(pm_search *s, pm_candidates *c)
{
    c->count = 0;
    visit(s, take_candidates, c);
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

/* ---- a first radius ---- */

/* True if the first photon of the block lies behind p on the Morton curve. */
static bool starts_behind(const pm_photon_block *block, const uint32_t p[3])
{
    uint32_t most = 0;
    bool behind = false;
    for (int a = 0; a < 3;
         a++) { /* of equally high differing bits that of the first axis counts */
        uint32_t q = (uint32_t)block->position[a][0] ^ 0x80000000U, differ = p[a] ^ q;
        bool higher = most < differ && most < (most ^ differ);
        most = higher ? differ : most;
        behind = higher ? q > p[a] : behind;
    }
    return behind;
}

/* The block where the point would be stored. */
static size_t home_block(const pm_search *s)
{
    uint32_t p[3];
    for (int a = 0; a < 3; a++)
        p[a] = (uint32_t)fmin(fmax(s->point[a] + PM_GRID_PER_WORLD, 0), UINT32_MAX);
    size_t low = 0, size = s->map->block_count;
    while (size > 1) { /* blocks before low do not start behind, low + size and later do */
        size_t half = size / 2;
        low = starts_behind(&s->map->blocks[low + half], p) ? low : low + half;
        size -= half;
    }
    return low;
}

/* 1 / area of a child's box, or 1 / volume [1 / steps^2 or 3]; 0 for a child that does not
 * match. */
static float child_density(const pm_node *node, unsigned c, const pm_search *s)
{
    float edge[3];
    if ((node->content[c] & s->content) != s->content)
        return 0;
    for (int a = 0; a < 3; a++) /* a box one step thick may be much thinner */
        edge[a] = fmaxf((float)(node->high[a][c] - node->low[a][c]), 0.5F);
    float xy = edge[0] * edge[1], yz = edge[1] * edge[2], zx = edge[2] * edge[0];
    return 1 / (s->surface ? fmaxf(xy, fmaxf(yz, zx)) : xy * edge[2]);
}

/* A squared radius that probably holds somewhat more than the wanted photons, from the boxes of
 * the neighbourhood. Only speed depends on it. */
static double guess_bound(const pm_search *s, uint32_t wanted)
{
    const pm_photon_map *map = s->map;
    size_t child = home_block(s);
    double photons = PM_BLOCK_SIZE; /* of a child */
    int level = 0;
    for (; level < map->levels - 1 && photons * PM_NODE_CHILDREN <= wanted; level++) {
        photons *= PM_NODE_CHILDREN;
        child /= PM_NODE_CHILDREN;
    }
    const pm_node *node = &map->nodes[map->level_start[level] + child / PM_NODE_CHILDREN];
    child %= PM_NODE_CHILDREN;
    _Alignas(32) float distance2[8];
    _mm256_store_ps(distance2, child_distances(node, child & 8, point_in_node(node, s)));
    float density = 0;
    unsigned matching = 0;
    for (unsigned c = 0; c < PM_NODE_CHILDREN; c++) {
        float d = child_density(node, c, s);
        density += d;
        matching += d > 0;
    }
    double margin = wanted + 2 * sqrt(wanted),
           measure = margin / (photons * density / matching);
    double radius =
        s->surface ? sqrt(measure / PM_PI) : pm_pow(measure / (4.0 / 3 * PM_PI), 1.0 / 3);
    radius = (radius + sqrt((double)distance2[child & 7])) / (double)node->steps_per_unit;
    return fmax(radius * radius, 1);
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
    double bound = guess_bound(s, wanted);
    for (;;) {
        s->bound = bound < most ? bound : most;
        double searched = s->bound;
        gather(s, out);
        if (out->count >= wanted)
            return out->count > wanted ? keep_nearest(out, s->bound) : farthest(out);
        if (searched >= most)
            return farthest(out);
        double missing = 1.5 * wanted / (out->count + 1.0);
        bound = searched * fmin(missing, 16);
    }
}
