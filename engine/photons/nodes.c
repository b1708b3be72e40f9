#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "photons/map_internal.h"

/* The tree over the blocks: groups of photons measured exactly from the bottom up, each level
 * then stored with boxes of 8 bits a coordinate. */

/* The photons of a block or of a node. */
struct group {
    int32_t low[3], high[3];
    uint32_t content; /* bits of pm_content */
    uint32_t normal;  /* the only one, PM_NORMAL_MIXED, or NO_NORMAL while there is no photon */
};

enum { NO_NORMAL = 0x10000 };

static const struct group empty_group = {{INT32_MAX, INT32_MAX, INT32_MAX},
                                         {INT32_MIN, INT32_MIN, INT32_MIN},
                                         1U << PM_CONTENT_ANY,
                                         NO_NORMAL};

struct build {
    pm_photon_map *map;
    struct group *group[PM_NODE_LEVELS]; /* of each node of a level */
    size_t count[PM_NODE_LEVELS];        /* nodes of a level */
    uint32_t *contents;                  /* of each normal code; NULL: not worth a table */
};

/* ---- what photons there are ---- */

/* 26 directions: towards the faces, edges and corners of a cube. Every direction is within 27.5
 * degrees of one of them (the farthest is along (1, 0.41421, 0.31784)), so a normal within 60
 * degrees of it is within 88. */
#define SECTOR_COSINE 0.0348994967025010 /* cos 88 degrees */

static const double inverse_length[4] = {0, 1, 0.70710678118654752, 0.57735026918962576};

uint32_t pm_content_of_normal(pm_vec3 n)
{
    uint32_t bits = 0;
    for (int s = 0; s < 27; s++) {
        int x = s % 3 - 1, y = s / 3 % 3 - 1, z = s / 9 - 1;
        double cosine =
            (x * n.x + y * n.y + z * n.z) * inverse_length[abs(x) + abs(y) + abs(z)];
        if (cosine >= SECTOR_COSINE)
            bits |= 1U << s;
    }
    return bits;
}

static unsigned trit(double v, bool used)
{
    return used ? v < 0 ? 0 : 2 : 1;
}

unsigned pm_content_sector(pm_vec3 n)
{
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    double most = fmax(x, fmax(y, z)), least = fmin(x, fmin(y, z));
    double median = fmax(fmin(x, y), fmin(fmax(x, y), z));
    double edge = (most + median) * inverse_length[2];
    double corner = (most + median + least) * inverse_length[3];
    double limit = median; /* components from here on count */
    if (corner >= edge && corner >= most)
        limit = least;
    else if (most > edge)
        limit = most;
    return trit(n.x, x >= limit) + 3 * trit(n.y, y >= limit) + 9 * trit(n.z, z >= limit);
}

/* ---- measuring ---- */

/* Extends a group by another; also by a single photon. */
static void unite(struct group *group, const struct group *other)
{
    for (int a = 0; a < 3; a++) {
        group->low[a] = other->low[a] < group->low[a] ? other->low[a] : group->low[a];
        group->high[a] = other->high[a] > group->high[a] ? other->high[a] : group->high[a];
    }
    group->content |= other->content;
    if (group->normal == NO_NORMAL)
        group->normal = other->normal;
    else if (group->normal != other->normal)
        group->normal = PM_NORMAL_MIXED;
}

static struct group group_of_photon(const pm_photon_block *block, unsigned k)
{
    bool specular = block->flags[k] & PM_PHOTON_SPECULAR;
    struct group group = {.normal = block->normal[k]};
    for (int a = 0; a < 3; a++)
        group.low[a] = group.high[a] = block->position[a][k];
    group.content = 1U << (specular ? PM_CONTENT_SPECULAR : PM_CONTENT_PLAIN);
    return group;
}

static uint32_t content_of_code(const struct build *b, uint16_t code)
{
    pm_photon photon = {.normal = {(uint8_t)code, (uint8_t)(code >> 8)}};
    return b->contents ? b->contents[code] : pm_content_of_normal(pm_photon_normal(&photon));
}

static struct group group_of_block(const struct build *b, size_t i)
{
    const pm_photon_block *block = &b->map->blocks[i];
    size_t left = b->map->count - i * PM_BLOCK_SIZE;
    struct group group = empty_group;
    for (unsigned k = 0; k < PM_BLOCK_SIZE && k < left; k++) {
        struct group photon = group_of_photon(block, k);
        if (k == 0 || block->normal[k] != block->normal[k - 1])
            photon.content |= content_of_code(b, block->normal[k]);
        unite(&group, &photon);
    }
    return group;
}

/* ---- storing ---- */

static int node_shift(const struct group *group)
{
    uint32_t extent = 0;
    for (int a = 0; a < 3; a++)
        extent |= (uint32_t)group->high[a] - (uint32_t)group->low[a];
    int shift = 0;
    while (extent >> shift >= PM_NODE_STEPS)
        shift++;
    return shift;
}

static void store_child(pm_node *node, unsigned c, const struct group *child, int shift)
{
    for (int a = 0; a < 3; a++) {
        uint32_t low = (uint32_t)child->low[a] - (uint32_t)node->origin[a];
        uint32_t high = (uint32_t)child->high[a] - (uint32_t)node->origin[a];
        node->low[a][c] = (uint8_t)(low >> shift);
        node->high[a][c] = (uint8_t)(high >> shift);
    }
    for (unsigned k = 0; k < PM_CONTENTS; k++)
        node->holds[k] = (uint16_t)(node->holds[k] | (child->content >> k & 1) << c);
    node->normal[c] = (uint16_t)child->normal;
}

/* A node from what its children hold. */
static void store_node(const struct build *b, int level, size_t i,
                       const struct group children[PM_NODE_CHILDREN], unsigned count)
{
    pm_node *node = &b->map->nodes[b->map->level_start[level] + i];
    struct group *group = &b->group[level][i];
    *group = empty_group;
    for (unsigned c = 0; c < count; c++)
        unite(group, &children[c]);
    int shift = node_shift(group);
    *node = (pm_node){.steps_per_unit = 1 / (float)(1U << shift)};
    memcpy(node->origin, group->low, sizeof node->origin);
    for (unsigned c = 0; c < count; c++)
        store_child(node, c, &children[c], shift);
}

static unsigned children_of(size_t i, size_t all)
{
    size_t left = all - i * PM_NODE_CHILDREN;
    return left < PM_NODE_CHILDREN ? (unsigned)left : PM_NODE_CHILDREN;
}

enum { PIECE = 64 }; /* nodes over blocks */

static void store_piece(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    const struct build *b = context;
    for (size_t i = piece * PIECE; i < (piece + 1) * PIECE && i < b->count[0]; i++) {
        struct group children[PM_NODE_CHILDREN];
        unsigned count = children_of(i, b->map->block_count);
        for (unsigned c = 0; c < count; c++)
            children[c] = group_of_block(b, i * PM_NODE_CHILDREN + c);
        store_node(b, 0, i, children, count);
    }
}

static void store_level(const struct build *b, int level)
{
    for (size_t i = 0; i < b->count[level]; i++)
        store_node(b, level, i, b->group[level - 1] + i * PM_NODE_CHILDREN,
                   children_of(i, b->count[level - 1]));
}

static void store_first_codes(pm_photon_map *map)
{
    for (size_t i = 0; i < map->level_start[1]; i++) {
        pm_photon photon;
        pm_photon_map_photon(map, i * PM_NODE_CHILDREN * PM_BLOCK_SIZE, &photon);
        map->first_code[i] = pm_photon_upper_code(photon.position);
    }
}

/* ---- all together ---- */

static size_t count_levels(struct build *b)
{
    pm_photon_map *map = b->map;
    size_t count = map->block_count, nodes = 0;
    do {
        assert(map->levels < PM_NODE_LEVELS);
        count = (count + PM_NODE_CHILDREN - 1) / PM_NODE_CHILDREN;
        b->count[map->levels] = count;
        map->level_start[map->levels++] = nodes;
        nodes += count;
        map->level_start[map->levels] = nodes;
    } while (count > 1);
    return nodes;
}

enum { CODES = 1 << 16, CODE_PIECES = 64, WORTH_A_TABLE = 1 << 18 };

static void fill_contents(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    uint32_t *contents = context;
    const struct build none = {0};
    for (size_t code = piece * CODES / CODE_PIECES; code < (piece + 1) * CODES / CODE_PIECES;
         code++)
        contents[code] = content_of_code(&none, (uint16_t)code);
}

static pm_status alloc_build(struct build *b)
{
    pm_photon_map *map = b->map;
    map->node_count = count_levels(b);
    map->nodes = malloc(map->node_count * sizeof *map->nodes);
    map->first_code = malloc(map->level_start[1] * sizeof *map->first_code);
    b->group[0] = malloc(map->node_count * sizeof *b->group[0]);
    if (map->count >= WORTH_A_TABLE)
        b->contents = malloc(CODES * sizeof *b->contents);
    return map->nodes && map->first_code && b->group[0] ? PM_OK : PM_E_MEMORY;
}

pm_status pm_nodes_build(pm_photon_map *map, pm_pool *pool, pm_error *err)
{
    if (!map->count)
        return PM_OK;
    struct build b = {.map = map};
    pm_status st = alloc_build(&b);
    if (st)
        pm_error_set(err, st, "no memory for the tree over %zu photons", map->count);
    if (!st && b.contents)
        pm_photons_run(pool, CODE_PIECES, fill_contents, b.contents);
    if (!st)
        pm_photons_run(pool, (b.count[0] + PIECE - 1) / PIECE, store_piece, &b);
    for (int l = 1; l < map->levels && !st; l++) {
        b.group[l] = b.group[l - 1] + b.count[l - 1];
        store_level(&b, l);
    }
    if (!st)
        store_first_codes(map);
    free(b.group[0]);
    free(b.contents);
    return st;
}
