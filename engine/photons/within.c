#include "photons/block_simd.h"

/* Sums over photons. */

/* ---- within a fixed radius ---- */

/* Four virtual lanes, so that sums do not depend on the width of the machine's registers. */
struct sums {
    __m256d sum[3], square[3];
    uint32_t count;
};

static inline void add_channel(__m256d *sum, __m256d *square, __m128i mantissa, __m256d unit)
{
    __m256d v = _mm256_mul_pd(_mm256_cvtepi32_pd(mantissa), unit);
    *sum = _mm256_add_pd(*sum, v);
    *square = _mm256_fmadd_pd(v, v, *square);
}

static inline __m128i load_bytes(const uint8_t *bytes) /* 4 of them */
{
    return _mm_loadu_si32(bytes);
}

/* Adds those of photons k .. k + 3 of the block whose bit is set in lanes. */
static inline void add_four(struct sums *t, const pm_photon_block *b, int k, unsigned lanes)
{
    const __m256i bits = _mm256_setr_epi64x(1, 2, 4, 8);
    __m256i taken = _mm256_and_si256(_mm256_set1_epi64x((long long)(lanes >> k)), bits);
    __m256i exponent = _mm256_cvtepu8_epi64(load_bytes(b->exponent + k));
    exponent = _mm256_add_epi64(exponent, _mm256_set1_epi64x(1023 - 200));
    __m256i unit =
        _mm256_and_si256(_mm256_slli_epi64(exponent, 52), _mm256_cmpeq_epi64(taken, bits));
    __m128i flux = _mm_load_si128((const __m128i *)(const void *)(b->flux + k));
    const __m128i low = _mm_set1_epi32(0x3FF);
    add_channel(&t->sum[0], &t->square[0], _mm_and_si128(flux, low), _mm256_castsi256_pd(unit));
    add_channel(&t->sum[1], &t->square[1], _mm_and_si128(_mm_srli_epi32(flux, 10), low),
                _mm256_castsi256_pd(unit));
    add_channel(&t->sum[2], &t->square[2], _mm_and_si128(_mm_srli_epi32(flux, 20), low),
                _mm256_castsi256_pd(unit));
}

/* Lists the blocks with photons within the bound, then sums: neither loop has a branch to
 * guess. */
static void take_sum(void *context, pm_search *s, const uint32_t *blocks, size_t count)
{
    struct sums *t = context;
    struct sums here = *t;
    struct hit {
        uint32_t block, lanes;
    } hits[PM_TAKE_MAX];
    size_t hit_count = 0;
    for (size_t i = 0; i < count; i++) {
        _Alignas(32) double distance2[PM_BLOCK_SIZE];
        unsigned lanes = block_mask(blocks[i], s, distance2);
        hits[hit_count] = (struct hit){blocks[i], lanes};
        hit_count += lanes != 0;
    }
    for (size_t i = 0; i < hit_count; i++) {
        const pm_photon_block *b = &s->map->blocks[hits[i].block];
        here.count += (uint32_t)__builtin_popcount(hits[i].lanes);
        for (int k = 0; k < PM_BLOCK_SIZE; k += 4)
            add_four(&here, b, k, hits[i].lanes);
    }
    *t = here;
}

static pm_rgb rgb_of_lanes(const __m256d v[3])
{
    double sum[3];
    for (int a = 0; a < 3; a++) {
        _Alignas(32) double lane[4];
        _mm256_store_pd(lane, v[a]);
        sum[a] = (lane[0] + lane[1]) + (lane[2] + lane[3]);
    }
    return (pm_rgb){sum[0], sum[1], sum[2]};
}

pm_flux_sum pm_search_sum(pm_search *search)
{
    const __m256d zero = _mm256_setzero_pd();
    struct sums t = {{zero, zero, zero}, {zero, zero, zero}, 0};
    pm_search_set_bound(search, search->bound);
    pm_search_walk(search, take_sum, &t);
    return (pm_flux_sum){rgb_of_lanes(t.sum), rgb_of_lanes(t.square), t.count};
}

/* ---- the same with a weight by direction ---- */

struct weighted_sums {
    pm_flux_sum *out;
    const pm_photon_weight *weight;
};

static void add_weighted(const pm_photon_map *map, size_t i, const pm_photon_weight *weight,
                         pm_flux_sum *out)
{
    pm_photon photon;
    pm_photon_map_photon(map, i, &photon);
    pm_rgb factor = weight->of(weight->context, pm_photon_direction(&photon));
    pm_rgb v = pm_rgb_mul(pm_photon_flux(&photon), factor);
    out->sum = pm_rgb_add(out->sum, v);
    out->square = pm_rgb_add(out->square, pm_rgb_mul(v, v));
    out->count++;
}

static void take_weighted(void *context, pm_search *s, const uint32_t *blocks, size_t count)
{
    const struct weighted_sums *t = context;
    for (size_t i = 0; i < count; i++) {
        _Alignas(32) double distance2[PM_BLOCK_SIZE];
        for (unsigned lanes = block_mask(blocks[i], s, distance2); lanes; lanes &= lanes - 1)
            add_weighted(s->map, blocks[i] * PM_BLOCK_SIZE + (unsigned)__builtin_ctz(lanes),
                         t->weight, t->out);
    }
}

pm_flux_sum pm_search_sum_weighted(pm_search *search, const pm_photon_weight *weight)
{
    pm_flux_sum out = {{0, 0, 0}, {0, 0, 0}, 0};
    struct weighted_sums t = {&out, weight};
    pm_search_set_bound(search, search->bound);
    pm_search_walk(search, take_weighted, &t);
    return out;
}

/* ---- candidates of a nearest search ---- */

static pm_rgb rgb_of_pixel(__m256d v)
{
    _Alignas(32) double lane[4];
    _mm256_store_pd(lane, v);
    return (pm_rgb){lane[0], lane[1], lane[2]};
}

pm_flux_sum pm_candidates_sum(const pm_photon_map *map, const pm_candidates *c)
{
    __m256d sum[2], square[2];
    sum[0] = sum[1] = square[0] = square[1] = _mm256_setzero_pd();
    for (uint32_t i = 0; i < c->count; i++) {
        const pm_photon_block *b = &map->blocks[c->index[i] / PM_BLOCK_SIZE];
        __m256d v = photon_flux(b, c->index[i] % PM_BLOCK_SIZE);
        sum[i & 1] = _mm256_add_pd(sum[i & 1], v);
        square[i & 1] = _mm256_fmadd_pd(v, v, square[i & 1]);
    }
    return (pm_flux_sum){rgb_of_pixel(_mm256_add_pd(sum[0], sum[1])),
                         rgb_of_pixel(_mm256_add_pd(square[0], square[1])), c->count};
}

pm_flux_sum pm_candidates_sum_weighted(const pm_photon_map *map, const pm_candidates *c,
                                       const pm_photon_weight *weight)
{
    pm_flux_sum out = {{0, 0, 0}, {0, 0, 0}, 0};
    for (uint32_t i = 0; i < c->count; i++)
        add_weighted(map, c->index[i], weight, &out);
    return out;
}
