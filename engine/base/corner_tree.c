#include "base/corner_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/radix.h"

enum { LEAF = 8 };

/* ---- building ---- */

/* Ascending as the numbers are. */
static uint64_t key_of(double x)
{
    uint64_t bits;
    x += 0.0; /* -0 + 0 = 0 */
    memcpy(&bits, &x, sizeof bits);
    return bits >> 63 ? ~bits : bits | UINT64_C(1) << 63;
}

/* One zero after each bit. */
static uint64_t spread(uint32_t v)
{
    uint64_t x = v;
    x = (x | x << 16) & 0x0000FFFF0000FFFF;
    x = (x | x << 8) & 0x00FF00FF00FF00FF;
    x = (x | x << 4) & 0x0F0F0F0F0F0F0F0F;
    x = (x | x << 2) & 0x3333333333333333;
    return (x | x << 1) & 0x5555555555555555;
}

/* Adds the rank of each item by one coordinate to its code. */
static pm_status add_ranks(const pm_corner_tree *t, bool by_y, pm_keyed *keys, uint64_t *codes)
{
    for (uint32_t i = 0; i < t->count; i++) {
        struct pm_point2 p = t->points[t->items[i]];
        keys[i] = (pm_keyed){key_of(by_y ? p.y : p.x), i};
    }
    pm_status status = pm_radix_sort(keys, t->count);
    for (uint32_t i = 0; !status && i < t->count; i++)
        codes[keys[i].value] |= spread(i) << by_y;
    return status;
}

static pm_status sort_items(pm_corner_tree *t)
{
    pm_keyed *keys = malloc(t->count * sizeof *keys);
    uint64_t *codes = calloc(t->count, sizeof *codes);
    pm_status status = keys && codes ? PM_OK : PM_E_MEMORY;
    if (!status)
        status = add_ranks(t, false, keys, codes);
    if (!status)
        status = add_ranks(t, true, keys, codes);
    for (uint32_t i = 0; !status && i < t->count; i++)
        keys[i] = (pm_keyed){codes[i], t->items[i]};
    if (!status)
        status = pm_radix_sort(keys, t->count);
    for (uint32_t i = 0; !status && i < t->count; i++)
        t->items[i] = keys[i].value;
    free(keys);
    free(codes);
    return status;
}

static void include(struct pm_point2 box[2], struct pm_point2 low, struct pm_point2 high)
{
    box[0] = (struct pm_point2){fmin(box[0].x, low.x), fmin(box[0].y, low.y)};
    box[1] = (struct pm_point2){fmax(box[1].x, high.x), fmax(box[1].y, high.y)};
}

static void fill_nodes(pm_corner_tree *t)
{
    for (uint32_t i = 0; i < 2 * t->leaves; i++) {
        t->bounds[i][0] = (struct pm_point2){INFINITY, INFINITY};
        t->bounds[i][1] = (struct pm_point2){-INFINITY, -INFINITY};
    }
    for (uint32_t i = 0; i < t->count; i++) {
        uint32_t leaf = t->leaves + i / LEAF;
        include(t->bounds[leaf], t->points[t->items[i]], t->points[t->items[i]]);
        t->left[leaf]++;
        t->slot[t->items[i]] = i;
    }
    for (uint32_t i = t->leaves; i-- > 1;) {
        for (uint32_t child = 2 * i; child < 2 * i + 2; child++) {
            include(t->bounds[i], t->bounds[child][0], t->bounds[child][1]);
            t->left[i] += t->left[child];
        }
    }
}

pm_status pm_corner_tree_init(pm_corner_tree *tree, const struct pm_point2 *points,
                              uint32_t all, const uint32_t *items, uint32_t count)
{
    pm_corner_tree *t = tree;
    *t = (pm_corner_tree){.points = points, .count = count, .leaves = 1};
    while ((uint64_t)t->leaves * LEAF < count)
        t->leaves *= 2;
    size_t nodes = 2 * (size_t)t->leaves;
    t->items = malloc(((size_t)count + 1) * sizeof *t->items);
    t->slot = malloc(((size_t)all + 1) * sizeof *t->slot);
    t->left = calloc(nodes, sizeof *t->left);
    t->bounds = malloc(nodes * sizeof *t->bounds);
    if (!t->items || !t->slot || !t->left || !t->bounds)
        return PM_E_MEMORY;
    memset(t->slot, 0xFF, all * sizeof *t->slot);
    if (count)
        memcpy(t->items, items, count * sizeof *items);
    if (count > LEAF && sort_items(t))
        return PM_E_MEMORY;
    fill_nodes(t);
    if (count)
        t->size = (struct pm_point2){t->bounds[1][1].x - t->bounds[1][0].x,
                                     t->bounds[1][1].y - t->bounds[1][0].y};
    return PM_OK;
}

void pm_corner_tree_clear(pm_corner_tree *tree)
{
    free(tree->items);
    free(tree->slot);
    free(tree->left);
    free(tree->bounds);
    *tree = (pm_corner_tree){0};
}

void pm_corner_tree_remove(pm_corner_tree *tree, uint32_t point)
{
    uint32_t slot = tree->slot[point];
    if (slot == UINT32_MAX)
        return;
    tree->slot[point] = UINT32_MAX;
    for (uint32_t node = tree->leaves + slot / LEAF; node > 0; node /= 2)
        tree->left[node]--;
}

/* ---- searching ---- */

struct search {
    const pm_corner_tree *tree;
    const struct pm_point2 *abc;
    struct pm_point2 low, high; /* of the triangle */
    double margin[3];           /* for each edge: what rounding may make of a point's side */
    bool (*test)(const void *context, uint32_t point);
    const void *context;
};

/* All of the box is to the right of an edge. */
static bool is_beyond(const struct search *s, int edge, const struct pm_point2 box[2])
{
    struct pm_point2 a = s->abc[edge], b = s->abc[(edge + 1) % 3];
    double dx = b.x - a.x, dy = b.y - a.y;
    double y = dx > 0 ? box[1].y : box[0].y, x = dy > 0 ? box[0].x : box[1].x;
    return dx * (y - a.y) - dy * (x - a.x) < -s->margin[edge];
}

static bool misses(const struct search *s, const struct pm_point2 box[2])
{
    return box[0].x > s->high.x || box[0].y > s->high.y || box[1].x < s->low.x ||
           box[1].y < s->low.y || is_beyond(s, 0, box) || is_beyond(s, 1, box) ||
           is_beyond(s, 2, box);
}

static bool search_leaf(const struct search *s, uint32_t leaf)
{
    const pm_corner_tree *t = s->tree;
    uint32_t first = leaf * LEAF, end = t->count - first < LEAF ? t->count : first + LEAF;
    for (uint32_t i = first; i < end; i++)
        if (t->slot[t->items[i]] == i && s->test(s->context, t->items[i]))
            return true;
    return false;
}

/* As deep as the tree: 32 at most. */
static bool search_node(const struct search *s, uint32_t node)
{
    const pm_corner_tree *t = s->tree;
    if (!t->left[node] || misses(s, t->bounds[node]))
        return false;
    if (node >= t->leaves)
        return search_leaf(s, node - t->leaves);
    return search_node(s, 2 * node) || search_node(s, 2 * node + 1);
}

bool pm_corner_tree_any(const pm_corner_tree *tree, const struct pm_point2 abc[3],
                        bool (*test)(const void *context, uint32_t point), const void *context)
{
    const double tiny = 1e-12;
    struct search s = {.tree = tree, .abc = abc, .test = test, .context = context};
    s.low = s.high = abc[0];
    for (int i = 0; i < 3; i++) {
        struct pm_point2 a = abc[i], b = abc[(i + 1) % 3];
        s.low = (struct pm_point2){fmin(s.low.x, a.x), fmin(s.low.y, a.y)};
        s.high = (struct pm_point2){fmax(s.high.x, a.x), fmax(s.high.y, a.y)};
        s.margin[i] = tiny * (fabs(b.x - a.x) * tree->size.y + fabs(b.y - a.y) * tree->size.x);
    }
    return search_node(&s, 1);
}
