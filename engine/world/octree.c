#include "world/octree.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/morton.h"
#include "base/radix.h"
#include "world/body.h"

enum { LEAF_SURFACES = 32, MAX_DEPTH = 14, MOST_ENTRIES = 1024 };

/* What a cell may hold, in an order that keeps neighbours in space together. */
struct item {
    pm_vec3 low, high;
    uint32_t
        number; /* of a shape of the main scene, or of an instance, counted on from those */
};

/* Of an item in a set: the children of the set's cell that its bounds meet, a bit each; and
 * whether the cell holds it all, so that it meets the child that alone its bounds meet. */
struct mark {
    uint8_t octants;
    bool inside;
};

/* Sets of items, one behind the other: a node's set, then those of its children, and so on
 * down. */
struct builder {
    pm_world *world;
    struct item *items;
    uint32_t *set; /* item numbers */
    struct mark *marks;
    size_t capacity;
    pm_bytes scratch;
    uint32_t *leaf; /* [leaf_capacity]: the numbers in the leaf at work */
    size_t leaf_capacity;
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
    size_t capacity = end + end / 2;
    uint32_t *set = realloc(b->set, capacity * sizeof *set);
    if (set)
        b->set = set;
    struct mark *marks = realloc(b->marks, capacity * sizeof *marks);
    if (marks)
        b->marks = marks;
    if (set && marks)
        b->capacity = capacity;
    else
        b->failed = true;
    return !b->failed;
}

static bool reserve_leaf(struct builder *b, size_t count)
{
    if (count <= b->leaf_capacity)
        return true;
    uint32_t *leaf = realloc(b->leaf, 2 * count * sizeof *leaf);
    b->failed = b->failed || !leaf;
    if (!leaf)
        return false;
    b->leaf = leaf;
    b->leaf_capacity = 2 * count;
    return true;
}

static int by_index(const void *a, const void *b)
{
    uint32_t i = *(const uint32_t *)a, j = *(const uint32_t *)b;
    return (i > j) - (i < j);
}

static void sort_indices(uint32_t *list, size_t count)
{
    enum { FEW = 16 };
    if (count > FEW) {
        qsort(list, count, sizeof *list, by_index);
        return;
    }
    for (size_t i = 1; i < count; i++) {
        uint32_t index = list[i];
        size_t at = i;
        for (; at > 0 && list[at - 1] > index; at--)
            list[at] = list[at - 1];
        list[at] = index;
    }
}

static const pm_digest *digest_of(const pm_world *world, uint32_t number)
{
    return number < world->shape_count
               ? &world->shape_digests[number]
               : &world->main->instance_digests[number - world->shape_count];
}

/* Shapes are in digest order and instances are, so that theirs is the digests'. */
static pm_digest leaf_digest(struct builder *b, const struct cell *cell)
{
    if (!reserve_leaf(b, cell->count))
        return b->empty;
    for (size_t i = 0; i < cell->count; i++)
        b->leaf[i] = b->items[b->set[cell->first + i]].number;
    sort_indices(b->leaf, cell->count);
    b->scratch.size = 0;
    pm_bytes_u8(&b->scratch, 'L');
    for (size_t i = 0; i < cell->count; i++) {
        const pm_digest *d = digest_of(b->world, b->leaf[i]);
        pm_bytes_append(&b->scratch, d->bytes, sizeof d->bytes);
    }
    if (pm_bytes_status(&b->scratch))
        b->failed = true;
    return pm_digest_of(b->scratch.data, b->scratch.size);
}

static uint8_t octants_of(const struct item *s, pm_vec3 c)
{
    unsigned x = (s->low.x <= c.x ? 0x55U : 0) | (s->high.x >= c.x ? 0xAAU : 0);
    unsigned y = (s->low.y <= c.y ? 0x33U : 0) | (s->high.y >= c.y ? 0xCCU : 0);
    unsigned z = (s->low.z <= c.z ? 0x0FU : 0) | (s->high.z >= c.z ? 0xF0U : 0);
    return (uint8_t)(x & y & z);
}

static bool is_one_bit(unsigned bits)
{
    return (bits & (bits - 1)) == 0;
}

static bool box_meets_cube(const struct item *item, pm_vec3 center, double half)
{
    return item->low.x <= center.x + half && item->low.y <= center.y + half &&
           item->low.z <= center.z + half && item->high.x >= center.x - half &&
           item->high.y >= center.y - half && item->high.z >= center.z - half;
}

/* An instance counts as its box. */
static bool meets_cube(const struct builder *b, const struct item *item, pm_vec3 center,
                       double half)
{
    if (item->number >= b->world->shape_count)
        return box_meets_cube(item, center, half);
    return pm_shape_meets_cube(&b->world->shapes[item->number], center, half);
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
    for (size_t i = parent->first; i < parent->first + parent->count; i++) {
        const struct mark mark = b->marks[i];
        if (!(mark.octants >> octant & 1))
            continue;
        uint32_t number = b->set[i];
        bool inside = mark.inside && is_one_bit(mark.octants);
        if (!inside && !meets_cube(b, &b->items[number], child.center, child.half))
            continue;
        b->marks[child.first + child.count].inside = inside;
        b->set[child.first + child.count++] = number;
    }
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
        b->marks[i].octants = octants_of(&b->items[b->set[i]], cell->center);
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
    pm_bytes_text(&b->scratch, "photon map scene 2");
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
    free(b->items);
    free(b->set);
    free(b->marks);
    free(b->leaf);
    pm_bytes_clear(&b->scratch);
}

static void set_item(const pm_world *world, uint32_t number, struct item *out)
{
    out->number = number;
    if (number < world->shape_count) {
        out->low = world->shapes[number].low;
        out->high = world->shapes[number].high;
        return;
    }
    pm_instance_bounds(&world->main->instances[number - world->shape_count], &out->low,
                       &out->high);
}

static uint64_t code_of(const struct item *item)
{
    pm_vec3 sum = pm_vec3_add(item->low, item->high);
    return pm_morton_code(sum.x / 2, sum.y / 2, sum.z / 2);
}

enum { AHEAD = 8 };

/* Shapes are scattered over memory: ask for them before they are needed. */
static void prefetch(const pm_world *world, uint32_t number)
{
    if (number < world->shape_count)
        __builtin_prefetch(&world->shapes[number].low);
}

/* The top's set: all items, neighbours in space beside each other. */
static bool list_items(struct builder *b, size_t count)
{
    pm_keyed *order = malloc((count + 1) * sizeof *order);
    b->items = malloc((count + 1) * sizeof *b->items);
    bool ready = order && b->items && reserve(b, 4 * count) && reserve_leaf(b, LEAF_SURFACES);
    for (uint32_t i = 0; ready && i < count; i++) {
        struct item item;
        set_item(b->world, i, &item);
        order[i] = (pm_keyed){code_of(&item), i};
    }
    ready = ready && !pm_radix_sort(order, count);
    for (uint32_t i = 0; ready && i < count; i++) {
        prefetch(b->world, i + AHEAD < count ? order[i + AHEAD].value : UINT32_MAX);
        set_item(b->world, order[i].value, &b->items[i]);
        b->set[i] = i;
        b->marks[i].inside = true;
    }
    free(order);
    return ready;
}

pm_status pm_octree_build(pm_world *world, pm_error *err)
{
    struct builder b = {.world = world};
    size_t count = world->shape_count + world->main->instance_count;
    struct cell top = {.half = 1, .count = count, .free = count};
    top.entries = MOST_ENTRIES * (double)top.count;
    pm_digest digest = {0};
    b.failed = !list_items(&b, count);
    if (!b.failed) {
        b.empty = leaf_digest(&b, &(struct cell){.count = 0});
        digest = node_digest(&b, &top);
        digest = root_digest(&b, &digest);
    }
    builder_clear(&b);
    if (b.failed)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the octree");
    world->hash = digest;
    world->octree_nodes = b.nodes;
    return PM_OK;
}
