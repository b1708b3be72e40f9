#ifndef PM_PHOTONS_LANES_H
#define PM_PHOTONS_LANES_H

#include <emmintrin.h>
#include <stdint.h>

/* 16 floats in four registers; kernel.h says what each function means. */

typedef struct lanes {
    __m128 v[4];
} lanes;
typedef lanes lane_set; /* all bits of a lane, or none */

#define EACH(expression)                                                                       \
    lanes out;                                                                                 \
    for (int i = 0; i < 4; i++)                                                                \
        out.v[i] = (expression);                                                               \
    return out

static inline lanes lanes_all(float v)
{
    EACH(_mm_set1_ps(v));
}

static inline lanes lanes_load(const float *p)
{
    EACH(_mm_load_ps(p + 4 * i));
}

static inline void lanes_store(float *p, lanes v)
{
    for (int i = 0; i < 4; i++)
        _mm_store_ps(p + 4 * i, v.v[i]);
}

static inline __m128i four_ints(const void *p, int i)
{
    return _mm_load_si128((const __m128i *)p + i);
}

static inline lanes lanes_way(const int32_t *p, int32_t q)
{
    EACH(_mm_cvtepi32_ps(_mm_sub_epi32(four_ints(p, i), _mm_set1_epi32(q))));
}

static inline __m128i field_of(__m128i v, unsigned shift, uint32_t mask)
{
    return _mm_and_si128(_mm_srl_epi32(v, _mm_cvtsi32_si128((int)shift)),
                         _mm_set1_epi32((int)mask));
}

static inline lanes lanes_field(const uint32_t *p, unsigned shift, uint32_t mask)
{
    EACH(_mm_cvtepi32_ps(field_of(four_ints(p, i), shift, mask)));
}

static inline __m128i four_bytes(const uint8_t *p)
{
    const __m128i zero = _mm_setzero_si128();
    return _mm_unpacklo_epi16(_mm_unpacklo_epi8(_mm_loadu_si32(p), zero), zero);
}

static inline lanes lanes_bytes(const uint8_t *p)
{
    EACH(_mm_cvtepi32_ps(four_bytes(p + 4 * i)));
}

static inline __m128 power_of(__m128i e, int bias)
{
    e = _mm_add_epi32(e, _mm_set1_epi32(bias));
    e = _mm_and_si128(e, _mm_cmpgt_epi32(e, _mm_setzero_si128()));
    return _mm_castsi128_ps(_mm_slli_epi32(e, 23));
}

static inline lanes lanes_power(const uint8_t *p, int bias)
{
    EACH(power_of(four_bytes(p + 4 * i), bias));
}

static inline __m128i four_halves(const uint16_t *p)
{
    __m128i v = _mm_loadl_epi64((const __m128i *)(const void *)p);
    return _mm_unpacklo_epi16(v, _mm_setzero_si128());
}

static inline lanes lanes_halves(const uint16_t *p, unsigned shift)
{
    EACH(_mm_cvtepi32_ps(field_of(four_halves(p + 4 * i), shift, 0xFF)));
}

static inline lanes lanes_add(lanes a, lanes b)
{
    EACH(_mm_add_ps(a.v[i], b.v[i]));
}

static inline lanes lanes_sub(lanes a, lanes b)
{
    EACH(_mm_sub_ps(a.v[i], b.v[i]));
}

static inline lanes lanes_mul(lanes a, lanes b)
{
    EACH(_mm_mul_ps(a.v[i], b.v[i]));
}

static inline lanes lanes_div(lanes a, lanes b)
{
    EACH(_mm_div_ps(a.v[i], b.v[i]));
}

static inline lanes lanes_sqrt(lanes a)
{
    EACH(_mm_sqrt_ps(a.v[i]));
}

static inline lanes lanes_min(lanes a, lanes b)
{
    EACH(_mm_min_ps(a.v[i], b.v[i]));
}

static inline lanes lanes_max(lanes a, lanes b)
{
    EACH(_mm_max_ps(a.v[i], b.v[i]));
}

static inline lanes lanes_abs(lanes a)
{
    EACH(_mm_andnot_ps(_mm_set1_ps(-0.0F), a.v[i]));
}

static inline lanes lanes_copysign(lanes a, lanes sign)
{
    a = lanes_abs(a);
    EACH(_mm_or_ps(a.v[i], _mm_and_ps(_mm_set1_ps(-0.0F), sign.v[i])));
}

static inline lane_set lanes_le(lanes a, lanes b)
{
    EACH(_mm_cmple_ps(a.v[i], b.v[i]));
}

static inline lane_set lanes_lt(lanes a, lanes b)
{
    EACH(_mm_cmplt_ps(a.v[i], b.v[i]));
}

static inline lane_set lanes_both(lane_set a, lane_set b)
{
    EACH(_mm_and_ps(a.v[i], b.v[i]));
}

static inline lane_set lanes_le_in(lane_set set, lanes a, lanes b)
{
    return lanes_both(set, lanes_le(a, b));
}

static inline unsigned lanes_bits(lane_set set)
{
    unsigned bits = 0;
    for (int i = 0; i < 4; i++)
        bits |= (unsigned)_mm_movemask_ps(set.v[i]) << 4 * i;
    return bits;
}

static inline __m128 four_of(unsigned bits)
{
    const __m128i each = _mm_setr_epi32(1, 2, 4, 8);
    __m128i set = _mm_and_si128(_mm_set1_epi32((int)bits), each);
    return _mm_castsi128_ps(_mm_cmpeq_epi32(set, each));
}

static inline lane_set lanes_set_of(unsigned bits)
{
    EACH(four_of(bits >> 4 * i));
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
    EACH(_mm_or_ps(_mm_and_ps(set.v[i], yes.v[i]), _mm_andnot_ps(set.v[i], no.v[i])));
}

static inline unsigned lanes_pack(float *out, lanes v, lane_set set)
{
    _Alignas(16) float each[16];
    unsigned n = 0;
    lanes_store(each, v);
    for (unsigned bits = lanes_bits(set); bits; bits &= bits - 1)
        out[n++] = each[__builtin_ctz(bits)];
    return n;
}

/* Lanes (i + (i + 8)) + ((i + 4) + (i + 12)). */
static inline __m128 lanes_quarter(lanes v)
{
    return _mm_add_ps(_mm_add_ps(v.v[0], v.v[2]), _mm_add_ps(v.v[1], v.v[3]));
}

#undef EACH

#endif
