#ifndef PM_PHOTONS_LANES_H
#define PM_PHOTONS_LANES_H

#include <immintrin.h>
#include <stdint.h>

/* 16 floats in two registers; kernel.h says what each function means. */

typedef struct lanes {
    __m256 a, b;
} lanes;
typedef lanes lane_set; /* all bits of a lane, or none */

static inline lanes lanes_all(float v)
{
    return (lanes){_mm256_set1_ps(v), _mm256_set1_ps(v)};
}

static inline lanes lanes_load(const float *p)
{
    return (lanes){_mm256_load_ps(p), _mm256_load_ps(p + 8)};
}

static inline void lanes_store(float *p, lanes v)
{
    _mm256_store_ps(p, v.a);
    _mm256_store_ps(p + 8, v.b);
}

static inline __m256i eight_ints(const void *p)
{
    return _mm256_load_si256(p);
}

static inline lanes lanes_of_ints(__m256i a, __m256i b)
{
    return (lanes){_mm256_cvtepi32_ps(a), _mm256_cvtepi32_ps(b)};
}

static inline lanes lanes_way(const int32_t *p, int32_t q)
{
    const __m256i from = _mm256_set1_epi32(q);
    return lanes_of_ints(_mm256_sub_epi32(eight_ints(p), from),
                         _mm256_sub_epi32(eight_ints(p + 8), from));
}

static inline __m256i field_of(__m256i v, unsigned shift, uint32_t mask)
{
    return _mm256_and_si256(_mm256_srli_epi32(v, (int)shift), _mm256_set1_epi32((int)mask));
}

static inline lanes lanes_field(const uint32_t *p, unsigned shift, uint32_t mask)
{
    return lanes_of_ints(field_of(eight_ints(p), shift, mask),
                         field_of(eight_ints(p + 8), shift, mask));
}

static inline __m256i eight_bytes(const uint8_t *p)
{
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)p));
}

static inline lanes lanes_bytes(const uint8_t *p)
{
    return lanes_of_ints(eight_bytes(p), eight_bytes(p + 8));
}

static inline __m256 power_of(__m256i e, int bias)
{
    e = _mm256_add_epi32(e, _mm256_set1_epi32(bias));
    e = _mm256_max_epi32(e, _mm256_setzero_si256());
    return _mm256_castsi256_ps(_mm256_slli_epi32(e, 23));
}

static inline lanes lanes_power(const uint8_t *p, int bias)
{
    return (lanes){power_of(eight_bytes(p), bias), power_of(eight_bytes(p + 8), bias)};
}

static inline __m256i eight_halves(const uint16_t *p)
{
    return _mm256_cvtepu16_epi32(_mm_loadu_si128((const __m128i *)(const void *)p));
}

static inline lanes lanes_halves(const uint16_t *p, unsigned shift)
{
    return lanes_of_ints(field_of(eight_halves(p), shift, 0xFF),
                         field_of(eight_halves(p + 8), shift, 0xFF));
}

static inline lanes lanes_add(lanes a, lanes b)
{
    return (lanes){_mm256_add_ps(a.a, b.a), _mm256_add_ps(a.b, b.b)};
}

static inline lanes lanes_sub(lanes a, lanes b)
{
    return (lanes){_mm256_sub_ps(a.a, b.a), _mm256_sub_ps(a.b, b.b)};
}

static inline lanes lanes_mul(lanes a, lanes b)
{
    return (lanes){_mm256_mul_ps(a.a, b.a), _mm256_mul_ps(a.b, b.b)};
}

static inline lanes lanes_div(lanes a, lanes b)
{
    return (lanes){_mm256_div_ps(a.a, b.a), _mm256_div_ps(a.b, b.b)};
}

static inline lanes lanes_sqrt(lanes v)
{
    return (lanes){_mm256_sqrt_ps(v.a), _mm256_sqrt_ps(v.b)};
}

static inline lanes lanes_min(lanes a, lanes b)
{
    return (lanes){_mm256_min_ps(a.a, b.a), _mm256_min_ps(a.b, b.b)};
}

static inline lanes lanes_max(lanes a, lanes b)
{
    return (lanes){_mm256_max_ps(a.a, b.a), _mm256_max_ps(a.b, b.b)};
}

static inline lanes lanes_abs(lanes v)
{
    const __m256 sign = _mm256_set1_ps(-0.0F);
    return (lanes){_mm256_andnot_ps(sign, v.a), _mm256_andnot_ps(sign, v.b)};
}

static inline lanes lanes_copysign(lanes v, lanes sign)
{
    const __m256 bit = _mm256_set1_ps(-0.0F);
    v = lanes_abs(v);
    return (lanes){_mm256_or_ps(v.a, _mm256_and_ps(bit, sign.a)),
                   _mm256_or_ps(v.b, _mm256_and_ps(bit, sign.b))};
}

static inline lane_set lanes_le(lanes a, lanes b)
{
    return (lanes){_mm256_cmp_ps(a.a, b.a, _CMP_LE_OQ), _mm256_cmp_ps(a.b, b.b, _CMP_LE_OQ)};
}

static inline lane_set lanes_lt(lanes a, lanes b)
{
    return (lanes){_mm256_cmp_ps(a.a, b.a, _CMP_LT_OQ), _mm256_cmp_ps(a.b, b.b, _CMP_LT_OQ)};
}

static inline lane_set lanes_both(lane_set a, lane_set b)
{
    return (lanes){_mm256_and_ps(a.a, b.a), _mm256_and_ps(a.b, b.b)};
}

static inline lane_set lanes_le_in(lane_set set, lanes a, lanes b)
{
    return lanes_both(set, lanes_le(a, b));
}

static inline unsigned lanes_bits(lane_set set)
{
    return (unsigned)_mm256_movemask_ps(set.a) | (unsigned)_mm256_movemask_ps(set.b) << 8;
}

static inline __m256 eight_of(unsigned bits)
{
    const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    __m256i set = _mm256_and_si256(_mm256_set1_epi32((int)bits), each);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, each));
}

static inline lane_set lanes_set_of(unsigned bits)
{
    return (lanes){eight_of(bits), eight_of(bits >> 8)};
}

static inline lanes lanes_add_if(lane_set set, lanes sum, lanes v)
{
    return lanes_add(sum, lanes_both(set, v));
}

static inline lanes lanes_add_square_if(lane_set set, lanes sum, lanes v)
{
    return lanes_add_if(set, sum, lanes_mul(v, v));
}

static inline lanes lanes_choose(lane_set set, lanes yes, lanes no)
{
    return (lanes){_mm256_blendv_ps(no.a, yes.a, set.a), _mm256_blendv_ps(no.b, yes.b, set.b)};
}

/* Numbers of the set bits as bytes, lowest first. */
static inline unsigned pack_eight(float *out, __m256 v, unsigned bits)
{
    uint64_t set = _pdep_u64(bits, 0x0101010101010101) * 0xFF;
    uint64_t order = _pext_u64(0x0706050403020100, set);
    __m256i wide = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)order));
    _mm256_storeu_ps(out, _mm256_permutevar8x32_ps(v, wide));
    return (unsigned)__builtin_popcount(bits);
}

static inline unsigned lanes_pack(float *out, lanes v, lane_set set)
{
    unsigned n = pack_eight(out, v.a, (unsigned)_mm256_movemask_ps(set.a));
    return n + pack_eight(out + n, v.b, (unsigned)_mm256_movemask_ps(set.b));
}

/* Lanes (i + (i + 8)) + ((i + 4) + (i + 12)). */
static inline __m128 lanes_quarter(lanes v)
{
    __m256 half = _mm256_add_ps(v.a, v.b);
    return _mm_add_ps(_mm256_castps256_ps128(half), _mm256_extractf128_ps(half, 1));
}

#endif
