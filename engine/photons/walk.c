#include "photons/node_simd.h"

/* From the root to the blocks, level by level. Nodes of a level do not wait for each other, and
 * children are listed without branches, so the processor has work while comparisons are under
 * way. */

enum { CHUNK = 16 }; /* nodes whose children are looked at together */

/* Lists first + i for each bit i of the mask; writes 16 numbers, returns how many count. */
static inline size_t list_bits(uint32_t *out, uint32_t first, unsigned mask)
{
    const uint64_t nibbles = 0xFEDCBA9876543210, each = 0x1111111111111111;
    uint64_t set = _pext_u64(nibbles, _pdep_u64(mask, each) * 15);
    const __m256i base = _mm256_set1_epi32((int)first);
    for (int half = 0; half < 2; half++) {
        uint64_t bytes = _pdep_u64(set >> (32 * half), 0x0F0F0F0F0F0F0F0F);
        __m256i wide = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)bytes));
        _mm256_storeu_si256((__m256i *)(void *)(out + 8 * half), _mm256_add_epi32(wide, base));
    }
    return (size_t)__builtin_popcount(mask);
}

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
