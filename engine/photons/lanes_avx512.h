#ifndef PM_PHOTONS_LANES_H
#define PM_PHOTONS_LANES_H

#include <immintrin.h>
#include <stdint.h>

/* 16 floats in one register; kernel.h says what each function means. */

typedef __m512 lanes;
typedef __mmask16 lane_set;

static inline lanes lanes_all(float v)
{
    return _mm512_set1_ps(v);
}

static inline lanes lanes_load(const float *p)
{
    return _mm512_load_ps(p);
}

static inline void lanes_store(float *p, lanes v)
{
    _mm512_store_ps(p, v);
}

static inline lanes lanes_way(const int32_t *p, int32_t q)
{
    return _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_load_si512(p), _mm512_set1_epi32(q)));
}

static inline lanes lanes_field(const uint32_t *p, unsigned shift, uint32_t mask)
{
    __m512i v = _mm512_srli_epi32(_mm512_load_si512(p), shift);
    return _mm512_cvtepi32_ps(_mm512_and_si512(v, _mm512_set1_epi32((int)mask)));
}

static inline lanes lanes_bytes(const uint8_t *p)
{
    __m128i v = _mm_loadu_si128((const __m128i *)(const void *)p);
    return _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(v));
}

static inline lanes lanes_power(const uint8_t *p, int bias)
{
    __m128i v = _mm_loadu_si128((const __m128i *)(const void *)p);
    __m512i e = _mm512_add_epi32(_mm512_cvtepu8_epi32(v), _mm512_set1_epi32(bias));
    e = _mm512_max_epi32(e, _mm512_setzero_si512());
    return _mm512_castsi512_ps(_mm512_slli_epi32(e, 23));
}

static inline lanes lanes_halves(const uint16_t *p, unsigned shift)
{
    __m256i v = _mm256_loadu_si256((const __m256i *)(const void *)p);
    __m512i wide = _mm512_srli_epi32(_mm512_cvtepu16_epi32(v), shift);
    return _mm512_cvtepi32_ps(_mm512_and_si512(wide, _mm512_set1_epi32(0xFF)));
}

static inline lanes lanes_add(lanes a, lanes b)
{
    return _mm512_add_ps(a, b);
}

static inline lanes lanes_sub(lanes a, lanes b)
{
    return _mm512_sub_ps(a, b);
}

static inline lanes lanes_mul(lanes a, lanes b)
{
    return _mm512_mul_ps(a, b);
}

static inline lanes lanes_div(lanes a, lanes b)
{
    return _mm512_div_ps(a, b);
}

static inline lanes lanes_sqrt(lanes a)
{
    return _mm512_sqrt_ps(a);
}

static inline lanes lanes_min(lanes a, lanes b)
{
    return _mm512_min_ps(a, b);
}

static inline lanes lanes_max(lanes a, lanes b)
{
    return _mm512_max_ps(a, b);
}

static inline lanes lanes_abs(lanes a)
{
    return _mm512_abs_ps(a);
}

static inline lanes lanes_copysign(lanes a, lanes sign)
{
    const __m512i bit = _mm512_set1_epi32(INT32_MIN);
    return _mm512_castsi512_ps(_mm512_ternarylogic_epi32(
        bit, _mm512_castps_si512(sign), _mm512_castps_si512(a), 0xCA)); /* bit ? sign : a */
}

static inline lane_set lanes_le(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}

static inline lane_set lanes_lt(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}

static inline lane_set lanes_both(lane_set a, lane_set b)
{
    return (lane_set)(a & b);
}

static inline lane_set lanes_le_in(lane_set set, lanes a, lanes b)
{
    return _mm512_mask_cmp_ps_mask(set, a, b, _CMP_LE_OQ);
}

static inline unsigned lanes_bits(lane_set set)
{
    return set;
}

static inline lane_set lanes_set_of(unsigned bits)
{
    return (lane_set)bits;
}

static inline lanes lanes_add_if(lane_set set, lanes sum, lanes v)
{
    return _mm512_mask_add_ps(sum, set, sum, v);
}

static inline lanes lanes_add_square_if(lane_set set, lanes sum, lanes v)
{
    return _mm512_mask3_fmadd_ps(v, v, sum, set);
}

static inline lanes lanes_choose(lane_set set, lanes yes, lanes no)
{
    return _mm512_mask_blend_ps(set, no, yes);
}

static inline unsigned lanes_pack(float *out, lanes v, lane_set set)
{
    _mm512_storeu_ps(out, _mm512_maskz_compress_ps(set, v));
    return (unsigned)__builtin_popcount(set);
}

/* Lanes (i + (i + 8)) + ((i + 4) + (i + 12)). */
static inline __m128 lanes_quarter(lanes v)
{
    __m256 high = _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(v), 1));
    __m256 half = _mm256_add_ps(_mm512_castps512_ps256(v), high);
    return _mm_add_ps(_mm256_castps256_ps128(half), _mm256_extractf128_ps(half, 1));
}

#endif
