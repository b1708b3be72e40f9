#include "world/octree.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"

enum { LEAF_SURFACES = 6, MAX_DEPTH = 14, MOST_ENTRIES = 1024 };

/* Sets of surfaces, one behind the other: a node's set, then those of its children, and so on
 * down. */
struct builder {
    pm_world *world;
    uint32_t *set;
    uint8_t *octants; /* of each in the set: the children that its bounds meet, a bit each */
    size_t capacity;
    pm_bytes scratch;
    pm_digest empty; /* of a leaf that meets nothing: most are */
    size_t nodes;
    bool failed;
};

struct cell {
    pm_vec3 center;
    double half;
    size_t first, count; /* its set in builder.set */
    size_t free;         /* from here on there is room for its children's sets */
    int depth;
    double entries; /* that the sets below it may have in all */
};

static bool reserve(struct builder *b, size_t end)
{
    if (end <= b->capacity)
        return true;
    size_t capacity = 2 * end;
    uint32_t *set = realloc(b->set, capacity * sizeof *set);
    if (set)
        b->set = set;
    uint8_t *octants = realloc(b->octants, capacity * sizeof *octants);
    if (octants)
        b->octants = octants;
    if (set && octants)
        b->capacity = capacity;
    else
        b->failed = true;
    return !b->failed;
}

static pm_digest leaf_digest(struct builder *b, const struct cell *cell)
{
    b->scratch.size = 0;
    pm_bytes_u8(&b->scratch, 'L');
    for (size_t i = 0; i < cell->count; i++) {
        const pm_digest *d = &b->world->shape_digests[b->set[cell->first + i]];
        pm_bytes_append(&b->scratch, d->bytes, sizeof d->bytes);
    }
    if (pm_bytes_status(&b->scratch))
        b->failed = true;
    return pm_digest_of(b->scratch.data, b->scratch.size);
}

static uint8_t octants_of(const struct pm_shape *s, pm_vec3 c)
{
    unsigned x = (s->low.x <= c.x ? 0x55U : 0) | (s->high.x >= c.x ? 0xAAU : 0);
    unsigned y = (s->low.y <= c.y ? 0x33U : 0) | (s->high.y >= c.y ? 0xCCU : 0);
    unsigned z = (s->low.z <= c.z ? 0x0FU : 0) | (s->high.z >= c.z ? 0xF0U : 0);
    return (uint8_t)(x & y & z);
}

/* Child number `octant`, its set from `first` on. */
static struct cell make_child(struct builder *b, const struct cell *parent, int octant,
                              size_t first)
{
    double half = parent->half / 2;
    pm_vec3 offset = {octant & 1 ? half : -half, octant & 2 ? half : -half,
                      octant & 4 ? half : -half};
    struct cell child = {.center = pm_vec3_add(parent->center, offset),
                         .half = half,
                         .first = first,
                         .depth = parent->depth + 1};
    for (size_t i = parent->first; i < parent->first + parent->count; i++)
        if (b->octants[i] >> octant & 1 &&
            pm_shape_meets_cube(&b->world->shapes[b->set[i]], child.center, child.half))
            b->set[child.first + child.count++] = b->set[i];
    return child;
}

/* Cuts a cell into eight. False if it is to stay a leaf. */
static bool cut(struct builder *b, const struct cell *cell, struct cell children[8])
{
    size_t end = cell->first + cell->count, entries = 0;
    if (cell->count <= LEAF_SURFACES || cell->depth >= MAX_DEPTH ||
        !reserve(b, cell->free + 8 * cell->count))
        return false;
    for (size_t i = cell->first; i < end; i++)
        b->octants[i] = octants_of(&b->world->shapes[b->set[i]], cell->center);
    for (int octant = 0; octant < 8; octant++) {
        children[octant] = make_child(b, cell, octant, cell->free + entries);
        entries += children[octant].count;
    }
    if ((double)entries > cell->entries)
        return false;
    for (int octant = 0; octant < 8; octant++) {
        children[octant].free = cell->free + entries;
        children[octant].entries = (cell->entries - (double)entries) *
                                   ((double)children[octant].count / (double)entries);
    }
    return true;
}

static pm_digest node_digest(struct builder *b, const struct cell *cell)
{
    struct cell children[8];
    b->nodes++;
    if (cell->count == 0)
        return b->empty;
    if (!cut(b, cell, children))
        return leaf_digest(b, cell);
    uint8_t bytes[1 + 8 * sizeof(pm_digest)] = {'N'};
    for (size_t octant = 0; octant < 8; octant++) {
        pm_digest digest = node_digest(b, &children[octant]);
        memcpy(bytes + 1 + octant * sizeof digest, digest.bytes, sizeof digest);
    }
    return pm_digest_of(bytes, sizeof bytes);
}

static pm_digest root_digest(struct builder *b, const pm_digest *top)
{
    const pm_world *world = b->world;
    b->scratch.size = 0;
    pm_bytes_text(&b->scratch, "photon map scene 1");
    pm_bytes_f64(&b->scratch, world->center.x);
    pm_bytes_f64(&b->scratch, world->center.y);
    pm_bytes_f64(&b->scratch, world->center.z);
    pm_bytes_f64(&b->scratch, world->scale);
    pm_bytes_append(&b->scratch, top->bytes, sizeof top->bytes);
    for (size_t i = 0; i < world->distant_count; i++)
        pm_bytes_append(&b->scratch, world->distant_digests[i].bytes, sizeof(pm_digest));
    if (pm_bytes_status(&b->scratch))
        b->failed = true;
    return pm_digest_of(b->scratch.data, b->scratch.size);
}

static void builder_clear(struct builder *b)
{
    free(b->set);
    free(b->octants);
    pm_bytes_clear(&b->scratch);
}

static pm_status no_memory(struct builder *b, pm_error *err)
{
    builder_clear(b);
    return pm_error_set(err, PM_E_MEMORY, "no memory for the octree");
}

pm_status pm_octree_build(pm_world *world, pm_error *err)
{
    struct builder b = {.world = world};
    struct cell top = {.half = 1, .count = world->shape_count, .free = world->shape_count};
    top.entries = MOST_ENTRIES * (double)top.count;
    if (!reserve(&b, top.count))
        return no_memory(&b, err);
    for (uint32_t i = 0; i < world->shape_count; i++)
        b.set[i] = i;
    b.empty = leaf_digest(&b, &(struct cell){.count = 0});
    pm_digest digest = node_digest(&b, &top);
    digest = root_digest(&b, &digest);
    if (b.failed)
        return no_memory(&b, err);
    builder_clear(&b);
    world->hash = digest;
    world->octree_nodes = b.nodes;
    return PM_OK;
}
