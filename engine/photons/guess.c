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
    while (size >
           1) { /* nodes before low do not start behind the point, those from low + size do */
        size_t half = size / 2;
        low = s->map->first_code[low + half] > code ? low : low + half;
        size -= half;
    }
    return low;
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
    __m128 q = point_in_node(node, s);
    __m256 least = _mm256_set1_ps(INFINITY), sum = _mm256_setzero_ps();
    int count = 0;
    for (unsigned c = 0; c < PM_NODE_CHILDREN; c += 8) {
        __m256 match = children_match(node, c, s);
        __m256 distance = _mm256_blendv_ps(least, child_distances(node, c, q), match);
        least = _mm256_min_ps(least, distance);
        sum = _mm256_add_ps(sum, _mm256_and_ps(box_densities(node, c, s->surface), match));
        count += __builtin_popcount((unsigned)_mm256_movemask_ps(match));
    }
    if (!count)
        return (struct hint){0, 0};
    return (struct hint){least_of_eight(least), sum_of_eight(sum) / (float)count};
}

double pm_search_guess(const pm_search *s, uint32_t wanted)
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
    /* The spread of a Poisson number on top; a box around n points in a square covers less than
     * the square, but boxes that jump along the curve cover more: GUESS is measured. */
    const double guess = 0.85;
    double measure = guess * (wanted + 2 * sqrt(wanted)) / (photons * (double)hint.density);
    double radius =
        s->surface ? sqrt(measure / PM_PI) : pm_pow(measure / (4.0 / 3 * PM_PI), 1.0 / 3);
    radius = (radius + sqrt((double)hint.distance2)) * step;
    return fmax(radius * radius, 1);
}
