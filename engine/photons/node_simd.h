#ifndef PM_PHOTONS_NODE_SIMD_H
#define PM_PHOTONS_NODE_SIMD_H

#include <immintrin.h>

#include "photons/search.h"

/* A node's 16 children against a search, 8 at a time. */

static inline __m256 eight_floats(const uint8_t *bytes)
{
    __m128i packed = _mm_loadl_epi64((const __m128i *)(const void *)bytes);
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(packed));
}

/* The point from a node's origin, in steps. */
static inline __m128 point_in_node(const pm_node *node, const pm_search *s)
{
    __m128i origin = _mm_loadu_si128((const __m128i *)(const void *)node->origin);
    __m256d relative = _mm256_sub_pd(_mm256_load_pd(s->point), _mm256_cvtepi32_pd(origin));
    return _mm_mul_ps(_mm256_cvtpd_ps(relative), _mm_set1_ps(node->steps_per_unit));
}

/* Distances along one axis, in steps, from the point at q to children c .. c + 7. */
static inline __m256 axis_distance(const pm_node *node, int axis, unsigned c, __m256 q)
{
    /* Only the conversion to float rounds: by less than 2^-15 steps where the point is within
     * 2^8 steps, and relatively by 2^-24 beyond. */
    const float slack = 0x1p-15F;
    __m256 low = eight_floats(node->low[axis] + c), high = eight_floats(node->high[axis] + c);
    __m256 below = _mm256_sub_ps(low, _mm256_add_ps(q, _mm256_set1_ps(slack)));
    __m256 above = _mm256_sub_ps(_mm256_sub_ps(q, _mm256_set1_ps(1 + slack)), high);
    return _mm256_max_ps(_mm256_max_ps(below, above), _mm256_setzero_ps());
}

/* Squared distances, in steps, from q to children c .. c + 7. */
static inline __m256 child_distances(const pm_node *node, unsigned c, __m128 q)
{
    __m256 x = axis_distance(node, 0, c, _mm256_broadcastss_ps(q));
    __m256 y = axis_distance(node, 1, c, _mm256_broadcastss_ps(_mm_permute_ps(q, 0x55)));
    __m256 z = axis_distance(node, 2, c, _mm256_broadcastss_ps(_mm_permute_ps(q, 0xAA)));
    return _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
}

/* Those of children c .. c + 7 that hold what is sought. */
static inline __m256 children_match(const pm_node *node, unsigned c, const pm_search *s)
{
    __m256i need = _mm256_set1_epi32((int)s->content);
    __m256i content = _mm256_loadu_si256((const __m256i *)(const void *)(node->content + c));
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(content, need), need));
}

/* Children of the node that may hold photons within the bound. */
static inline unsigned node_mask(const pm_node *node, const pm_search *s)
{
    __m128 q = point_in_node(node, s);
    __m256 bound =
        _mm256_set1_ps(s->rough_bound * (node->steps_per_unit * node->steps_per_unit));
    unsigned mask = 0;
    for (unsigned c = 0; c < PM_NODE_CHILDREN; c += 8) {
        __m256 near = _mm256_cmp_ps(child_distances(node, c, q), bound, _CMP_LE_OQ);
        near = _mm256_and_ps(near, children_match(node, c, s));
        mask |= (unsigned)_mm256_movemask_ps(near) << c;
    }
    return mask;
}

#endif
