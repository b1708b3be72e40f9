#include "photons/search.h"

#include <assert.h>

#include "photons/block_simd.h"
#include "photons/list_simd.h"
#include "photons/node_simd.h"

pm_search pm_search_volume(const pm_photon_map *map, pm_vec3 p)
{
    assert(pm_vec3_finite(p));
    return (pm_search){
        .map = map,
        .point = {p.x * PM_GRID_PER_WORLD, p.y * PM_GRID_PER_WORLD, p.z * PM_GRID_PER_WORLD},
        .content = {PM_CONTENT_ANY, PM_CONTENT_ANY},
    };
}

pm_search pm_search_surface(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                            pm_photon_filter filter)
{
    pm_search s = pm_search_volume(map, point);
    s.normal[0] = (float)normal.x, s.normal[1] = (float)normal.y, s.normal[2] = (float)normal.z;
    s.surface = true;
    s.filter = filter;
    s.content[0] = pm_content_sector(normal);
    if (filter != PM_PHOTONS_ALL)
        s.content[1] = filter == PM_PHOTONS_SPECULAR ? PM_CONTENT_SPECULAR : PM_CONTENT_PLAIN;
    s.known_normal = PM_NORMAL_MIXED;
    return s;
}

/* ---- from the root to the blocks, level by level ----
 *
 * Nodes of a level do not wait for each other, and
 * children are listed without branches, so the processor has work while comparisons are under
 * way. */

enum {
    CHUNK = PM_TAKE_MAX / PM_NODE_CHILDREN
}; /* nodes whose children are looked at together */

/* False if no photon of child c can lie in the tangent plane: known where all have one normal.
 */
static bool child_in_plane(const pm_node *node, unsigned c, pm_search *s)
{
    if (node->normal[c] == PM_NORMAL_MIXED)
        return true;
    if (node->normal[c] != s->known_normal)
        learn_normal(s, node->normal[c]);
    if (!s->known_accepted)
        return false;
    double step = 1 / (double)node->steps_per_unit;
    double height = 0, thickness = 0, center2 = 0, half2 = 0;
    for (int a = 0; a < 3; a++) {
        double half = (node->high[a][c] + 1 - node->low[a][c]) * step / 2;
        double center = node->origin[a] + node->low[a][c] * step + half - s->point[a];
        height += center * s->known_mean[a];
        thickness += half * fabs(s->known_mean[a]);
        center2 += center * center;
        half2 += half * half;
    }
    double farthest = sqrt(center2) + sqrt(half2);
    return fabs(height) - thickness <= PM_TANGENT_SLOPE * farthest + 2 * PM_TANGENT_SLACK;
}

static unsigned children_in_plane(const pm_node *node, unsigned mask, pm_search *s)
{
    for (unsigned rest = mask; rest; rest &= rest - 1)
        if (!child_in_plane(node, (unsigned)__builtin_ctz(rest), s))
            mask ^= rest & -rest;
    return mask;
}

static void walk_level(pm_search *s, int level, const uint32_t *list, size_t count,
                       pm_take_blocks *take, void *context)
{
    const pm_node *nodes = s->map->nodes + s->map->level_start[level];
    uint32_t children[CHUNK * PM_NODE_CHILDREN + PM_NODE_CHILDREN];
    for (size_t first = 0; first < count; first += CHUNK) {
        size_t end = first + CHUNK < count ? first + CHUNK : count, found = 0;
        for (size_t i = first; i < end; i++) {
            unsigned mask = node_mask(&nodes[list[i]], s);
            if (s->careful)
                mask = children_in_plane(&nodes[list[i]], mask, s);
            found += list_bits(children + found, list[i] * PM_NODE_CHILDREN, mask);
        }
        if (level)
            walk_level(s, level - 1, children, found, take, context);
        else
            take(context, s, children, found);
    }
}

void pm_search_walk(pm_search *s, pm_take_blocks *take, void *context)
{
    const uint32_t root = 0;
    if (s->map->levels)
        walk_level(s, s->map->levels - 1, &root, 1, take, context);
}
