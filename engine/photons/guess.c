#include <math.h>

#include "base/maths.h"
#include "photons/node_simd.h"

/* The first radius of a nearest search. */

/* The node of level 0 in whose stretch of the Morton curve the point lies. */
static size_t home_node(const pm_search *s)
{
    uint32_t p[3];
    for (int a = 0; a < 3; a++)
        p[a] = (uint32_t)fmin(fmax(s->point[a] + PM_GRID_PER_WORLD, 0), UINT32_MAX);
    uint64_t code = pm_photon_upper_code(p);
    size_t low = 0, size = s->map->level_start[1];
    while (size > 1) { /* node low does not start behind the point, node low + size does */
        size_t half = size / 2;
        low = s->map->first_code[low + half] > code ? low : low + half;
        size -= half;
    }
    return low;
}

static inline __m256 eight_floats(const uint8_t *bytes)
{
    __m128i packed = _mm_loadl_epi64((const __m128i *)(const void *)bytes);
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(packed));
}

/* Distances along one axis, in steps, from the point at q to children c .. c + 7. */
static inline __m256 axis_distance(const pm_node *node, int axis, unsigned c, float q)
{
    __m256 low = eight_floats(node->low[axis] + c), high = eight_floats(node->high[axis] + c);
    __m256 below = _mm256_sub_ps(low, _mm256_set1_ps(q));
    __m256 above = _mm256_sub_ps(_mm256_set1_ps(q - 1), high);
    return _mm256_max_ps(_mm256_max_ps(below, above), _mm256_setzero_ps());
}

/* Squared distances, in steps, from q to children c .. c + 7. */
static inline __m256 child_distances(const pm_node *node, unsigned c, const float q[3])
{
    __m256 x = axis_distance(node, 0, c, q[0]), y = axis_distance(node, 1, c, q[1]);
    __m256 z = axis_distance(node, 2, c, q[2]);
    return _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
}

/* Bits 0 .. 7 as lanes. */
static inline __m256 lanes_of(unsigned mask)
{
    const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    __m256i set = _mm256_and_si256(_mm256_set1_epi32((int)mask), bits);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bits));
}

/* Edges of the boxes of children c .. c + 7 along one axis, in steps. */
static inline __m256 box_edges(const pm_node *node, int axis, unsigned c)
{
    __m256 low = eight_floats(node->low[axis] + c), high = eight_floats(node->high[axis] + c);
    /* a box one step thick may be much thinner */
    return _mm256_max_ps(_mm256_sub_ps(high, low), _mm256_set1_ps(0.5F));
}

/* 1 / area or volume of the boxes of children c .. c + 7 [1 / steps^2 or ^3]. */
static inline __m256 box_densities(const pm_node *node, unsigned c, bool surface)
{
    __m256 x = box_edges(node, 0, c), y = box_edges(node, 1, c), z = box_edges(node, 2, c);
    __m256 xy = _mm256_mul_ps(x, y), measure = _mm256_mul_ps(xy, z);
    if (surface)
        measure = _mm256_max_ps(xy, _mm256_max_ps(_mm256_mul_ps(y, z), _mm256_mul_ps(z, x)));
    return _mm256_div_ps(_mm256_set1_ps(1), measure);
}

static float least_of_eight(__m256 v)
{
    __m128 m = _mm_min_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
    m = _mm_min_ps(m, _mm_movehl_ps(m, m));
    return _mm_cvtss_f32(_mm_min_ss(m, _mm_movehdup_ps(m)));
}

static float sum_of_eight(__m256 v)
{
    __m128 m = _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
    m = _mm_add_ps(m, _mm_movehl_ps(m, m));
    return _mm_cvtss_f32(_mm_add_ss(m, _mm_movehdup_ps(m)));
}

/* What a node says of its neighbourhood, from those children that match the search. */
struct hint {
    float distance2; /* to the nearest [steps^2] */
    float density;   /* children per step^2 or ^3; 0 if none matches */
};

static struct hint ask_node(const pm_node *node, const pm_search *s)
{
    _Alignas(16) float q[4];
    _mm_store_ps(q, _mm_mul_ps(_mm256_cvtpd_ps(point_from_node(node, s)),
                               _mm_set1_ps(node->steps_per_unit)));
    __m256 least = _mm256_set1_ps(INFINITY), sum = _mm256_setzero_ps();
    unsigned matching = children_match(node, s);
    if (!matching)
        return (struct hint){0, 0};
    for (unsigned c = 0; c < PM_NODE_CHILDREN; c += 8) {
        __m256 match = lanes_of(matching >> c);
        __m256 distance = _mm256_blendv_ps(least, child_distances(node, c, q), match);
        least = _mm256_min_ps(least, distance);
        sum = _mm256_add_ps(sum, _mm256_and_ps(box_densities(node, c, s->surface), match));
    }
    float count = (float)__builtin_popcount(matching);
    return (struct hint){least_of_eight(least), sum_of_eight(sum) / count};
}

double pm_search_guess(pm_search *s, uint32_t wanted)
{
    const pm_photon_map *map = s->map;
    size_t i = home_node(s);
    double photons = PM_BLOCK_SIZE; /* of a child */
    int level = 0;
    for (; level < map->levels - 1 && photons * PM_NODE_CHILDREN <= wanted; level++) {
        photons *= PM_NODE_CHILDREN;
        i /= PM_NODE_CHILDREN;
    }
    const pm_node *node = &map->nodes[map->level_start[level] + i];
    struct hint hint = ask_node(node, s);
    double step = 1 / (double)node->steps_per_unit;
    if (!(hint.density > 0)) /* none here: from somewhere, growing */
        return step * step;
    /* The spread of a Poisson number on top. Boxes around a few points cover less than those
     * points stand for, boxes that jump along the curve more: the factor is measured. */
    const double factor = 0.85;
    double measure = factor * (wanted + 2 * sqrt(wanted)) / (photons * (double)hint.density);
    double radius =
        s->surface ? sqrt(measure / PM_PI) : pm_pow(measure / (4.0 / 3 * PM_PI), 1.0 / 3);
    double distance = sqrt((double)hint.distance2);
    s->careful = s->surface && distance > radius;
    radius = (radius + distance) * step;
    return fmax(radius * radius, 1);
}
