#include <math.h>

#include "base/maths.h"
#include "photons/search.h"

/* The first radius of a nearest search. */

/* The node of level 0 in whose stretch of the Morton curve the point lies. */
static size_t home_node(const pm_search *s)
{
    uint32_t p[3];
    for (int a = 0; a < 3; a++) {
        int64_t q = s->point[a] - INT32_MIN;
        p[a] = (uint32_t)(q < 0 ? 0 : q > UINT32_MAX ? UINT32_MAX : q);
    }
    uint64_t code = pm_photon_upper_code(p);
    size_t low = 0, size = s->map->level_start[1];
    while (size > 1) { /* node low does not start behind the point, node low + size does */
        size_t half = size / 2;
        low = s->map->first_code[low + half] > code ? low : low + half;
        size -= half;
    }
    return low;
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
    unsigned matching = node->holds[s->content[0]] & node->holds[s->content[1]];
    pm_hint hint = map->kernel->ask(node, s, matching);
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
