#ifndef PM_PHOTONS_BLOCK_SIMD_H
#define PM_PHOTONS_BLOCK_SIMD_H

#include <immintrin.h>

#include "photons/search.h"

/* A block's 16 photons against a search, 4 at a time. */

static inline unsigned filter_mask(const pm_photon_block *b, const pm_search *s)
{
    if (s->filter == PM_PHOTONS_ALL)
        return 0xFFFF;
    __m128i flags = _mm_loadu_si128((const __m128i *)b->flags);
    unsigned specular =
        (unsigned)_mm_movemask_epi8(_mm_slli_epi16(flags, 3)); /* bit 4 to bit 7 */
    return s->filter == PM_PHOTONS_SPECULAR ? specular : ~specular & 0xFFFF;
}

/* The way from the point to photons k .. k + 3 of a block. */
struct way {
    __m256d x, y, z;
};

static inline __m256d axis_way(const pm_photon_block *b, const pm_search *s, int axis, int k)
{
    __m128i p = _mm_load_si128((const __m128i *)(const void *)(b->position[axis] + k));
    return _mm256_sub_pd(_mm256_cvtepi32_pd(p), _mm256_set1_pd(s->point[axis]));
}

static inline struct way way_to(const pm_photon_block *b, const pm_search *s, int k)
{
    return (struct way){axis_way(b, s, 0, k), axis_way(b, s, 1, k), axis_way(b, s, 2, k)};
}

/* One order of rounding for all, so that equal positions are equally far. */
static inline __m256d dot(struct way a, struct way b)
{
    return _mm256_fmadd_pd(a.x, b.x, _mm256_fmadd_pd(a.y, b.y, _mm256_mul_pd(a.z, b.z)));
}

/* 8 normals decoded from octahedral codes, as pm_photon_normal does. */
static inline void decode_normals(__m128i codes, __m256 n[3])
{
    const __m256 half = _mm256_set1_ps(127), sign = _mm256_set1_ps(-0.0F),
                 one = _mm256_set1_ps(1);
    __m256i wide = _mm256_cvtepu16_epi32(codes);
    __m256 x = _mm256_cvtepi32_ps(_mm256_and_si256(wide, _mm256_set1_epi32(0xFF)));
    __m256 y = _mm256_cvtepi32_ps(_mm256_srli_epi32(wide, 8));
    x = _mm256_div_ps(_mm256_sub_ps(x, half), half);
    y = _mm256_div_ps(_mm256_sub_ps(y, half), half);
    __m256 z =
        _mm256_sub_ps(_mm256_sub_ps(one, _mm256_andnot_ps(sign, x)), _mm256_andnot_ps(sign, y));
    /* the lower half is folded outwards: |x| grows smaller by -z */
    __m256 fold = _mm256_min_ps(z, _mm256_setzero_ps());
    x = _mm256_add_ps(x, _mm256_or_ps(_mm256_andnot_ps(sign, fold), _mm256_andnot_ps(x, sign)));
    y = _mm256_add_ps(y, _mm256_or_ps(_mm256_andnot_ps(sign, fold), _mm256_andnot_ps(y, sign)));
    __m256 square = _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
    __m256 inverse = _mm256_div_ps(one, _mm256_sqrt_ps(square));
    n[0] = _mm256_mul_ps(x, inverse);
    n[1] = _mm256_mul_ps(y, inverse);
    n[2] = _mm256_mul_ps(z, inverse);
}

/* Turns normals into their means with the search's; returns the lanes within 60 degrees. */
static inline unsigned mean_normals(const pm_search *s, __m256 n[3])
{
    __m256 cosine = _mm256_setzero_ps();
    for (int a = 0; a < 3; a++) {
        __m256 own = _mm256_set1_ps(s->normal[a]);
        cosine = _mm256_fmadd_ps(n[a], own, cosine);
        n[a] = _mm256_mul_ps(_mm256_set1_ps(0.5F), _mm256_add_ps(n[a], own));
    }
    return (unsigned)_mm256_movemask_ps(
        _mm256_cmp_ps(cosine, _mm256_set1_ps((float)PM_NORMAL_COSINE), _CMP_GE_OQ));
}

static inline unsigned within_bound(const pm_search *s, __m256d distance2)
{
    return (unsigned)_mm256_movemask_pd(
        _mm256_cmp_pd(distance2, _mm256_set1_pd(s->bound), _CMP_LE_OQ));
}

/* Those in the mean tangent plane, |m . D| <= slope |D| + slack. */
static inline unsigned in_plane(struct way way, struct way mean, __m256d distance2)
{
    __m256d h = _mm256_andnot_pd(_mm256_set1_pd(-0.0), dot(way, mean));
    h = _mm256_max_pd(_mm256_sub_pd(h, _mm256_set1_pd(PM_TANGENT_SLACK)), _mm256_setzero_pd());
    __m256d limit2 =
        _mm256_mul_pd(distance2, _mm256_set1_pd(PM_TANGENT_SLOPE * PM_TANGENT_SLOPE));
    return (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(_mm256_mul_pd(h, h), limit2, _CMP_LE_OQ));
}

/* The block_* functions return the lanes that are taken, and the squared distances of all. */

static inline unsigned block_in_volume(const pm_photon_block *b, const pm_search *s, double *d2)
{
    unsigned mask = 0;
    for (int k = 0; k < PM_BLOCK_SIZE; k += 4) {
        struct way way = way_to(b, s, k);
        __m256d distance2 = dot(way, way);
        _mm256_store_pd(d2 + k, distance2);
        mask |= within_bound(s, distance2) << k;
    }
    return mask;
}

/* What a block with a single normal is tested with. */
struct flat {
    struct way mean;
    __m256d height; /* greatest |m . D| so far */
};

static inline unsigned flat_four(const pm_photon_block *b, const pm_search *s, int k,
                                 struct flat *flat, double *d2)
{
    struct way way = way_to(b, s, k);
    __m256d distance2 = dot(way, way);
    __m256d height = _mm256_andnot_pd(_mm256_set1_pd(-0.0), dot(way, flat->mean));
    flat->height = _mm256_max_pd(flat->height, height);
    _mm256_store_pd(d2 + k, distance2);
    return within_bound(s, distance2) << k;
}

static inline unsigned block_in_plane(const pm_photon_block *b, const pm_search *s,
                                      const struct flat *flat)
{
    unsigned mask = 0;
    for (int k = 0; k < PM_BLOCK_SIZE; k += 4) {
        struct way way = way_to(b, s, k);
        mask |= in_plane(way, flat->mean, dot(way, way)) << k;
    }
    return mask;
}

/* With a single normal, whose mean with that of the search is known. */
static inline unsigned block_flat(const pm_photon_block *b, const pm_search *s, double *d2)
{
    struct flat flat = {{_mm256_set1_pd(s->known_mean[0]), _mm256_set1_pd(s->known_mean[1]),
                         _mm256_set1_pd(s->known_mean[2])},
                        _mm256_setzero_pd()};
    unsigned mask = flat_four(b, s, 0, &flat, d2) | flat_four(b, s, 4, &flat, d2) |
                    flat_four(b, s, 8, &flat, d2) | flat_four(b, s, 12, &flat, d2);
    __m256d off = _mm256_cmp_pd(flat.height, _mm256_set1_pd(PM_TANGENT_SLACK), _CMP_GT_OQ);
    if (_mm256_movemask_pd(off) && mask)
        mask &= block_in_plane(b, s, &flat);
    return mask;
}

static inline unsigned half_mixed(const pm_photon_block *b, const pm_search *s, int k, __m128 x,
                                  __m128 y, __m128 z, double *d2)
{
    struct way way = way_to(b, s, k);
    struct way mean = {_mm256_cvtps_pd(x), _mm256_cvtps_pd(y), _mm256_cvtps_pd(z)};
    __m256d distance2 = dot(way, way);
    _mm256_store_pd(d2 + k, distance2);
    return within_bound(s, distance2) & in_plane(way, mean, distance2);
}

static inline unsigned block_mixed(const pm_photon_block *b, const pm_search *s, double *d2)
{
    unsigned mask = 0;
    for (int k = 0; k < PM_BLOCK_SIZE; k += 8) {
        __m256 n[3];
        decode_normals(_mm_load_si128((const __m128i *)(const void *)(b->normal + k)), n);
        unsigned facing = mean_normals(s, n);
        unsigned near =
            half_mixed(b, s, k, _mm256_castps256_ps128(n[0]), _mm256_castps256_ps128(n[1]),
                       _mm256_castps256_ps128(n[2]), d2);
        near |= half_mixed(b, s, k + 4, _mm256_extractf128_ps(n[0], 1),
                           _mm256_extractf128_ps(n[1], 1), _mm256_extractf128_ps(n[2], 1), d2)
                << 4;
        mask |= (near & facing) << k;
    }
    return mask;
}

static inline void learn_normal(pm_search *s, unsigned code)
{
    __m256 n[3];
    decode_normals(_mm_set1_epi16((short)code), n);
    s->known_accepted = mean_normals(s, n) & 1;
    for (int a = 0; a < 3; a++)
        s->known_mean[a] = (double)_mm256_cvtss_f32(n[a]);
    s->known_normal = code;
}

static inline unsigned block_on_surface(const pm_photon_block *b, pm_search *s,
                                        double d2[PM_BLOCK_SIZE])
{
    __m256i codes = _mm256_load_si256((const __m256i *)b->normal);
    __m256i first = _mm256_set1_epi16((short)b->normal[0]);
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi16(codes, first)) != -1)
        return block_mixed(b, s, d2);
    if (b->normal[0] != s->known_normal)
        learn_normal(s, b->normal[0]);
    return s->known_accepted ? block_flat(b, s, d2) : 0;
}

/* Lanes of block i whose photons are taken, and the squared distances of all. */
static inline unsigned block_mask(size_t i, pm_search *s, double d2[PM_BLOCK_SIZE])
{
    const pm_photon_block *b = &s->map->blocks[i];
    size_t left = s->map->count - i * PM_BLOCK_SIZE;
    unsigned there = left < PM_BLOCK_SIZE ? (1U << left) - 1 : 0xFFFF;
    unsigned mask = s->surface ? block_on_surface(b, s, d2) : block_in_volume(b, s, d2);
    return mask & there & filter_mask(b, s);
}

/* The flux of one photon as r g b -. */
static inline __m256d photon_flux(const pm_photon_block *b, unsigned lane)
{
    __m128i packed =
        _mm_srlv_epi32(_mm_set1_epi32((int)b->flux[lane]), _mm_setr_epi32(0, 10, 20, 31));
    __m128i parts = _mm_and_si128(packed, _mm_set1_epi32(0x3FF));
    uint64_t bits = ((uint64_t)b->exponent[lane] + 1023 - 200) << 52;
    __m256d unit = _mm256_castsi256_pd(_mm256_set1_epi64x((long long)bits));
    return _mm256_mul_pd(_mm256_cvtepi32_pd(parts), unit);
}

#endif
