#ifndef PM_PHOTONS_NODE_SIMD_H
#define PM_PHOTONS_NODE_SIMD_H

#include <immintrin.h>

#include "photons/search.h"

/* A node's 16 children against a search, all at a time. */

/* The point from a node's origin, x y z - [grid units]. */
static inline __m256d point_from_node(const pm_node *node, const pm_search *s)
{
    __m128i origin = _mm_loadu_si128((const __m128i *)(const void *)node->origin);
    return _mm256_sub_pd(_mm256_load_pd(s->point), _mm256_cvtepi32_pd(origin));
}

/* Children that hold what is sought. */
static inline unsigned children_match(const pm_node *node, const pm_search *s)
{
    return node->holds[s->content[0]] & node->holds[s->content[1]];
}

/* Those whose box meets [from, to] along one axis; from and to in the axis' lane, 0 .. 255. */
static inline __m128i children_meet(const pm_node *node, int axis, __m128i from, __m128i to)
{
    __m128i lane = _mm_set1_epi8((char)(4 * axis));
    __m128i low = _mm_loadu_si128((const __m128i *)(const void *)node->low[axis]);
    __m128i high = _mm_loadu_si128((const __m128i *)(const void *)node->high[axis]);
    from = _mm_shuffle_epi8(from, lane);
    to = _mm_shuffle_epi8(to, lane);
    return _mm_and_si128(_mm_cmpeq_epi8(_mm_min_epu8(low, to), low),
                         _mm_cmpeq_epi8(_mm_max_epu8(high, from), high));
}

/* Children of the node that may hold photons within the bound: those whose box meets the cube
 * around the search's ball. */
static inline unsigned node_mask(const pm_node *node, const pm_search *s)
{
    /* Of all this only the conversion to float rounds, by less than 2^-15 steps below 2^8. */
    const __m128 slack = _mm_set1_ps(0x1p-15F), step = _mm_set1_ps(node->steps_per_unit);
    __m256d point = point_from_node(node, s), radius = _mm256_set1_pd(s->radius);
    __m128 from = _mm_mul_ps(_mm256_cvtpd_ps(_mm256_sub_pd(point, radius)), step);
    __m128 to = _mm_mul_ps(_mm256_cvtpd_ps(_mm256_add_pd(point, radius)), step);
    from = _mm_sub_ps(from, slack);
    to = _mm_add_ps(to, slack);
    const __m128 zero = _mm_setzero_ps(), end = _mm_set1_ps(PM_NODE_STEPS);
    __m128 outside = _mm_or_ps(_mm_cmplt_ps(to, zero), _mm_cmpge_ps(from, end));
    if (_mm_movemask_ps(outside) & 7)
        return 0;
    __m128i first = _mm_cvttps_epi32(_mm_max_ps(from, zero));
    __m128i last = _mm_cvttps_epi32(_mm_min_ps(to, _mm_set1_ps(PM_NODE_STEPS - 1)));
    __m128i meet = _mm_and_si128(children_meet(node, 0, first, last),
                                 _mm_and_si128(children_meet(node, 1, first, last),
                                               children_meet(node, 2, first, last)));
    return (unsigned)_mm_movemask_epi8(meet) & children_match(node, s);
}

#endif
