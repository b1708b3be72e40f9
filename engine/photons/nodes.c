#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "photons/map_internal.h"

/* The tree of boxes over the blocks: exact ones from the bottom up, each
 * level then stored in 8 bits a coordinate. */

struct box {
    int32_t low[3], high[3];
};

/* Boxes of all children of one level. */
struct child_boxes {
    struct box *box;
    uint32_t *content;
    size_t count;
};

struct build {
    pm_photon_map *map;
    struct child_boxes level[PM_NODE_LEVELS + 1]; /* [0]: blocks; [l + 1]: nodes of level l */
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

/* ---- exact boxes ---- */

static void add_point(struct box *box, const int32_t (*position)[PM_BLOCK_SIZE], unsigned i)
{
    for (int a = 0; a < 3; a++) {
        if (position[a][i] < box->low[a])
            box->low[a] = position[a][i];
        if (position[a][i] > box->high[a])
            box->high[a] = position[a][i];
    }
}

static const struct box empty_box = {{INT32_MAX, INT32_MAX, INT32_MAX},
                                     {INT32_MIN, INT32_MIN, INT32_MIN}};

static void measure_block(const struct build *b, size_t i)
{
    const pm_photon_block *block = &b->map->blocks[i];
    size_t left = b->map->count - i * PM_BLOCK_SIZE;
    struct box box = empty_box;
    uint32_t content = 1U << PM_CONTENT_ANY, seen = UINT32_MAX;
    for (unsigned k = 0; k < PM_BLOCK_SIZE && k < left; k++) {
        add_point(&box, block->position, k);
        bool specular = block->flags[k] & PM_PHOTON_SPECULAR;
        content |= 1U << (specular ? PM_CONTENT_SPECULAR : PM_CONTENT_PLAIN);
        if (block->normal[k] == seen)
            continue;
        seen = block->normal[k];
        pm_photon photon = {.normal = {(uint8_t)seen, (uint8_t)(seen >> 8)}};
        content |= pm_content_of_normal(pm_photon_normal(&photon));
    }
    b->level[0].box[i] = box;
    b->level[0].content[i] = content;
}

enum { PIECE = 1024 };

static void measure_piece(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    const struct build *b = context;
    for (size_t i = piece * PIECE; i < (piece + 1) * PIECE && i < b->level[0].count; i++)
        measure_block(b, i);
}

static void unite(const struct child_boxes *below, const struct child_boxes *out)
{
    for (size_t i = 0; i < out->count; i++) {
        struct box box = empty_box;
        uint32_t content = 0;
        for (size_t c = i * PM_NODE_CHILDREN;
             c < (i + 1) * PM_NODE_CHILDREN && c < below->count; c++) {
            for (int a = 0; a < 3; a++) {
                box.low[a] =
                    below->box[c].low[a] < box.low[a] ? below->box[c].low[a] : box.low[a];
                box.high[a] =
                    below->box[c].high[a] > box.high[a] ? below->box[c].high[a] : box.high[a];
            }
            content |= below->content[c];
        }
        out->box[i] = box;
        out->content[i] = content;
    }
}

/* ---- stored boxes ---- */

static int node_shift(const struct box *box)
{
    uint32_t extent = 0;
    for (int a = 0; a < 3; a++)
        extent |= (uint32_t)box->high[a] - (uint32_t)box->low[a];
    int shift = 0;
    while (extent >> shift >= PM_NODE_STEPS)
        shift++;
    return shift;
}

static void store_child(pm_node *node, unsigned c, const struct box *box, int shift,
                        uint32_t content)
{
    for (int a = 0; a < 3; a++) {
        uint32_t low = (uint32_t)box->low[a] - (uint32_t)node->origin[a];
        uint32_t high = (uint32_t)box->high[a] - (uint32_t)node->origin[a];
        node->low[a][c] = (uint8_t)(low >> shift);
        node->high[a][c] = (uint8_t)(high >> shift);
    }
    for (unsigned k = 0; k < PM_CONTENTS; k++)
        node->holds[k] = (uint16_t)(node->holds[k] | (content >> k & 1) << c);
}

static void store_level(const struct build *b, int level)
{
    const struct child_boxes *children = &b->level[level];
    for (size_t i = 0; i < b->level[level + 1].count; i++) {
        pm_node *node = &b->map->nodes[b->map->level_start[level] + i];
        const struct box *box = &b->level[level + 1].box[i];
        int shift = node_shift(box);
        *node = (pm_node){.steps_per_unit = 1 / (float)(1U << shift)};
        memcpy(node->origin, box->low, sizeof node->origin);
        size_t first = i * PM_NODE_CHILDREN;
        for (unsigned c = 0; c < PM_NODE_CHILDREN && first + c < children->count; c++)
            store_child(node, c, &children->box[first + c], shift,
                        children->content[first + c]);
    }
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
    b->level[0].count = count;
    do {
        assert(map->levels < PM_NODE_LEVELS);
        count = (count + PM_NODE_CHILDREN - 1) / PM_NODE_CHILDREN;
        map->level_start[map->levels++] = nodes;
        b->level[map->levels].count = count;
        nodes += count;
        map->level_start[map->levels] = nodes;
    } while (count > 1);
    return nodes;
}

pm_status pm_nodes_build(pm_photon_map *map, pm_pool *pool, pm_error *err)
{
    if (!map->count)
        return PM_OK;
    struct build b = {.map = map};
    size_t nodes = count_levels(&b), boxes = map->block_count + nodes;
    map->node_count = nodes;
    map->nodes = malloc(nodes * sizeof *map->nodes);
    map->first_code = malloc(map->level_start[1] * sizeof *map->first_code);
    b.level[0].box = malloc(boxes * sizeof *b.level[0].box);
    b.level[0].content = malloc(boxes * sizeof *b.level[0].content);
    pm_status st = PM_E_MEMORY;
    if (map->nodes && map->first_code && b.level[0].box && b.level[0].content) {
        pm_photons_run(pool, (map->block_count + PIECE - 1) / PIECE, measure_piece, &b);
        for (int l = 0; l < map->levels; l++) {
            b.level[l + 1].box = b.level[l].box + b.level[l].count;
            b.level[l + 1].content = b.level[l].content + b.level[l].count;
            unite(&b.level[l], &b.level[l + 1]);
            store_level(&b, l);
        }
        store_first_codes(map);
        st = PM_OK;
    }
    free(b.level[0].box);
    free(b.level[0].content);
    return st ? pm_error_set(err, st, "no memory for the tree over %zu photons", map->count)
              : st;
}
