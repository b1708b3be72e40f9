#include "world/octree.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"

enum { LEAF_SURFACES = 6, MAX_DEPTH = 14, MAX_STALLED = 3 };

/* Sets of surfaces, one behind the other: a node's set, then its child's, and so on down. */
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
    size_t first, count; /* in builder.set */
    int depth, stalled;
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

/* Child number `octant`, its set behind that of its parent. */
static struct cell make_child(struct builder *b, const struct cell *parent, int octant)
{
    double half = parent->half / 2;
    pm_vec3 offset = {octant & 1 ? half : -half, octant & 2 ? half : -half,
                      octant & 4 ? half : -half};
    struct cell child = {.center = pm_vec3_add(parent->center, offset),
                         .half = half,
                         .first = parent->first + parent->count,
                         .depth = parent->depth + 1};
    if (!reserve(b, child.first + parent->count))
        return child;
    for (size_t i = 0; i < parent->count; i++) {
        uint32_t shape = b->set[parent->first + i];
        if (b->octants[parent->first + i] >> octant & 1 &&
            pm_shape_meets_cube(&b->world->shapes[shape], child.center, child.half))
            b->set[child.first + child.count++] = shape;
    }
    child.stalled = child.count == parent->count ? parent->stalled + 1 : 0;
    return child;
}

static pm_digest node_digest(struct builder *b, const struct cell *cell)
{
    b->nodes++;
    if (cell->count == 0)
        return b->empty;
    if (b->failed || cell->count <= LEAF_SURFACES || cell->depth >= MAX_DEPTH ||
        cell->stalled >= MAX_STALLED)
        return leaf_digest(b, cell);
    for (size_t i = cell->first; i < cell->first + cell->count; i++)
        b->octants[i] = octants_of(&b->world->shapes[b->set[i]], cell->center);
    uint8_t bytes[1 + 8 * sizeof(pm_digest)] = {'N'};
    for (int octant = 0; octant < 8; octant++) {
        struct cell child = make_child(b, cell, octant);
        pm_digest digest = node_digest(b, &child);
        memcpy(bytes + 1 + (size_t)octant * sizeof digest, digest.bytes, sizeof digest);
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

pm_status pm_octree_build(pm_world *world, pm_error *err)
{
    struct builder b = {.world = world};
    struct cell top = {.half = 1, .count = world->shape_count};
    if (reserve(&b, top.count)) {
        for (uint32_t i = 0; i < world->shape_count; i++)
            b.set[i] = i;
    }
    b.empty = leaf_digest(&b, &(struct cell){.count = 0});
    pm_digest digest = node_digest(&b, &top);
    digest = root_digest(&b, &digest);
    free(b.set);
    free(b.octants);
    pm_bytes_clear(&b.scratch);
    if (b.failed)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the octree");
    world->hash = digest;
    world->octree_nodes = b.nodes;
    return PM_OK;
}
