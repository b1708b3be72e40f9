#include "photons/list_simd.h"
#include "photons/node_simd.h"

/* From the root to the blocks, level by level. Nodes of a level do not wait for each other, and
 * children are listed without branches, so the processor has work while comparisons are under
 * way. */

enum { CHUNK = 16 }; /* nodes whose children are looked at together */

static void walk_level(pm_search *s, int level, const uint32_t *list, size_t count,
                       pm_take_blocks *take, void *context)
{
    const pm_node *nodes = s->map->nodes + s->map->level_start[level];
    uint32_t children[CHUNK * PM_NODE_CHILDREN + PM_NODE_CHILDREN];
    for (size_t first = 0; first < count; first += CHUNK) {
        size_t end = first + CHUNK < count ? first + CHUNK : count, found = 0;
        for (size_t i = first; i < end; i++)
            found += list_bits(children + found, list[i] * PM_NODE_CHILDREN,
                               node_mask(&nodes[list[i]], s));
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
