#include "world/light_table.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/maths.h"

enum {
    MAX_LEVELS = 11,    /* of the grid, whose cells take 2 x 2 values */
    DEEPER = 6,         /* levels below the grid */
    MAX_NODES = 1 << 20 /* a node's four children are neighbours */
};

/* A cell is divided while its range of values, times its area, is more than this share of the
 * whole: by the grid's own values, and where only new ones tell. The number of cells is so
 * bounded by the inverse on each level. */
#define SHARE_IN_GRID 0x1p-16
#define SHARE_BELOW   0x1p-13 /* more below coarse grids */
#define SMOOTH        .25     /* nor where it varies less */

/* Values between those that were looked at may be like those of a neighbour: an edge crosses
 * the cell. It and all its parts get this share of the neighbour's weight, and it is divided
 * as if it had seen its values. */
#define BESIDE 0x1p-6

struct node {
    uint32_t first; /* of four children: v low u low, v low u high, ...; 0: a leaf */
    float low;      /* share of the lower half in v, as by share_of */
    float left[2];  /* of that half, and of the upper one: share of the left half in u */
};

struct pm_light_table {
    uint32_t count;
    struct node *nodes;
};

/* ---- what is known of a cell ---- */

struct cell {
    double weight, low, high;
    double least; /* weight for the sake of its neighbours, and of all that is in it */
};

struct builder {
    const struct pm_light_function *function;
    int levels;                    /* of the grid */
    struct cell *grid[MAX_LEVELS]; /* of level l: 2^l rows of 2^l cells; one block */
    double total;                  /* the grid's mean weight */
    double share_below;
    size_t divisions;   /* below the grid, that are left */
    struct node *nodes; /* [capacity] */
    double *weights;    /* [capacity] of the leaves */
    uint32_t count, capacity;
    bool out_of_memory;
};

static double value_at(const struct builder *b, double u, double v)
{
    double value = b->function->value(b->function->context, u, v);
    return value > 0 && value < INFINITY ? fmin(value, 1e150) : 0;
}

/* Four values, of which the root mean square weighs the cell: that leaves the least variance.
 */
static struct cell sample_cell(const struct builder *b, int level, uint32_t x, uint32_t y)
{
    double size = 1. / (double)(1U << level), squares = 0;
    struct cell cell = {0, INFINITY, 0, 0};
    for (int i = 0; i < 4; i++) {
        double value =
            value_at(b, (x + .25 + .5 * (i & 1)) * size, (y + .25 + .5 * (i >> 1)) * size);
        cell.low = fmin(cell.low, value);
        cell.high = fmax(cell.high, value);
        squares += .25 * value * value;
    }
    cell.weight = fmax(sqrt(squares), cell.high / 2); /* a square may underflow */
    return cell;
}

static struct cell *grid_cell(const struct builder *b, int level, uint32_t x, uint32_t y)
{
    return &b->grid[level][((size_t)y << level) + x];
}

static void join_four(const struct builder *b, int level, uint32_t x, uint32_t y)
{
    struct cell all = {0, INFINITY, 0, 0};
    for (uint32_t i = 0; i < 4; i++) {
        const struct cell *c = grid_cell(b, level + 1, 2 * x + (i & 1), 2 * y + (i >> 1));
        all.weight += c->weight / 4;
        all.low = fmin(all.low, c->low);
        all.high = fmax(all.high, c->high);
    }
    *grid_cell(b, level, x, y) = all;
}

/* `cell` beside a neighbour. */
static void heed(struct cell *cell, const struct cell *neighbour)
{
    cell->least = fmax(cell->least, BESIDE * neighbour->weight);
    cell->low = fmin(cell->low, neighbour->low);
    cell->high = fmax(cell->high, neighbour->high);
}

static struct cell heed_all(const struct cell *cells, uint32_t n, uint32_t x, uint32_t y)
{
    struct cell cell = cells[(size_t)y * n + x];
    for (uint32_t j = y ? y - 1 : 0; j <= y + 1 && j < n; j++)
        for (uint32_t i = x ? x - 1 : 0; i <= x + 1 && i < n; i++)
            heed(&cell, &cells[(size_t)j * n + i]);
    cell.weight = fmax(cell.weight, cell.least);
    return cell;
}

static bool fill_finest(struct builder *b)
{
    uint32_t n = 1U << b->levels;
    struct cell *cells = malloc((size_t)n * n * sizeof *cells);
    if (!cells)
        return false;
    for (uint32_t i = 0; i < n * n; i++)
        cells[i] = sample_cell(b, b->levels, i % n, i / n);
    for (uint32_t i = 0; i < n * n; i++)
        *grid_cell(b, b->levels, i % n, i / n) = heed_all(cells, n, i % n, i / n);
    free(cells);
    return true;
}

static bool fill_grid(struct builder *b)
{
    size_t count = 0;
    for (int level = 0; level <= b->levels; level++)
        count += (size_t)1 << 2 * level;
    struct cell *cells = malloc(count * sizeof *cells);
    if (!cells)
        return false;
    for (int level = 0; level <= b->levels; level++) {
        b->grid[level] = cells;
        cells += (size_t)1 << 2 * level;
    }
    if (!fill_finest(b))
        return false;
    for (int level = b->levels - 1; level >= 0; level--)
        for (uint32_t i = 0; i < 1U << 2 * level; i++)
            join_four(b, level, i & ((1U << level) - 1), i >> level);
    size_t finest = (size_t)1 << 2 * b->levels;
    b->total = b->grid[0]->weight;
    b->share_below = fmax(SHARE_BELOW, .125 / (double)finest);
    b->divisions = finest;
    return true;
}

/* ---- the tree ---- */

static bool reserve_nodes(struct builder *b, uint32_t count)
{
    if (b->count + count <= b->capacity)
        return true;
    uint32_t capacity = b->capacity ? 2 * b->capacity : 64;
    struct node *nodes = realloc(b->nodes, capacity * sizeof *nodes);
    if (nodes)
        b->nodes = nodes;
    double *weights = nodes ? realloc(b->weights, capacity * sizeof *weights) : NULL;
    if (weights)
        b->weights = weights;
    b->out_of_memory = !weights;
    b->capacity = weights ? capacity : b->capacity;
    return weights;
}

static bool is_worth_dividing(const struct builder *b, int level, const struct cell *cell)
{
    double range = cell->high - cell->low, area = 1 / (double)((uint64_t)1 << 2 * level);
    double share = level < b->levels ? SHARE_IN_GRID : b->share_below;
    return level < b->levels + DEEPER && (level < b->levels || b->divisions > 0) &&
           range * area > share * b->total &&
           range > SMOOTH * (cell->low + PM_LIGHT_TABLE_FLOOR * b->total) &&
           b->count + 4 <= MAX_NODES && !b->out_of_memory;
}

/* The four children of a cell. */
static void find_children(const struct builder *b, int level, uint32_t x, uint32_t y,
                          double least, struct cell children[4])
{
    struct cell sampled[4];
    for (uint32_t i = 0; i < 4; i++) {
        uint32_t right = 2 * x + (i & 1), up = 2 * y + (i >> 1);
        sampled[i] = level < b->levels ? *grid_cell(b, level + 1, right, up)
                                       : sample_cell(b, level + 1, right, up);
    }
    for (int i = 0; i < 4; i++) {
        children[i] = sampled[i];
        for (int k = 0; level >= b->levels && k < 4; k++)
            heed(&children[i], &sampled[k]);
        children[i].least = fmax(children[i].least, least);
        children[i].weight = fmax(children[i].weight, children[i].least);
    }
}

static void grow(struct builder *b, uint32_t node, int level, uint32_t x, uint32_t y,
                 const struct cell *cell)
{
    b->nodes[node].first = 0;
    b->weights[node] = cell->weight;
    if (!is_worth_dividing(b, level, cell) || !reserve_nodes(b, 4))
        return;
    uint32_t first = b->count;
    b->nodes[node].first = first;
    b->count += 4;
    b->divisions -= level >= b->levels;
    struct cell children[4];
    find_children(b, level, x, y, cell->least, children);
    for (uint32_t i = 0; i < 4; i++)
        grow(b, first + i, level + 1, 2 * x + (i & 1), 2 * y + (i >> 1), &children[i]);
}

/* What is known after growing: mean weight of the node. */
static double mean_weight(const struct builder *b, uint32_t node)
{
    uint32_t first = b->nodes[node].first;
    if (!first)
        return b->weights[node];
    double sum = 0;
    for (uint32_t i = 0; i < 4; i++)
        sum += mean_weight(b, first + i);
    return sum / 4;
}

/* The greater of two shares would lose what the other one is: minus the lesser stands for it.
 */
static float share_of(double part, double rest)
{
    double whole = part + rest;
    return (float)(part <= rest ? part / whole : -rest / whole);
}

/* Sets the node's shares; returns its mean density, `total` being the whole's weight. */
static double settle(struct builder *b, uint32_t index, double total)
{
    struct node *node = &b->nodes[index];
    if (!node->first) {
        double weight = total > 0 ? b->weights[index] / total : 1;
        return (1 - PM_LIGHT_TABLE_FLOOR) * weight + PM_LIGHT_TABLE_FLOOR;
    }
    double m[4];
    for (uint32_t i = 0; i < 4; i++)
        m[i] = settle(b, node->first + i, total);
    node->low = share_of(m[0] + m[1], m[2] + m[3]);
    node->left[0] = share_of(m[0], m[1]);
    node->left[1] = share_of(m[2], m[3]);
    return (m[0] + m[1] + m[2] + m[3]) / 4;
}

static bool copy_tree(const struct builder *b, pm_arena *arena, struct pm_light_table **out)
{
    struct pm_light_table *table = pm_arena_alloc(arena, sizeof *table);
    struct node *nodes = pm_arena_array(arena, b->count, sizeof *nodes);
    if (!table || !nodes)
        return false;
    memcpy(nodes, b->nodes, b->count * sizeof *nodes);
    *table = (struct pm_light_table){b->count, nodes};
    *out = table;
    return true;
}

static bool build(struct builder *b, pm_arena *arena, struct pm_light_table **out)
{
    if (!fill_grid(b) || !reserve_nodes(b, 1))
        return false;
    b->count = 1;
    grow(b, 0, 0, 0, 0, b->grid[0]);
    settle(b, 0, mean_weight(b, 0));
    return !b->out_of_memory && copy_tree(b, arena, out);
}

pm_status pm_light_table_build(const struct pm_light_function *function, pm_arena *arena,
                               struct pm_light_table **out, pm_error *err)
{
    struct builder b = {.function = function};
    while (b.levels + 1 < MAX_LEVELS && (4U << b.levels) <= function->detail)
        b.levels++;
    bool built = build(&b, arena, out);
    free(b.grid[0]);
    free(b.nodes);
    free(b.weights);
    if (!built)
        return pm_error_set(err, PM_E_MEMORY, "out of memory for the pattern of a light");
    return PM_OK;
}

/* ---- drawing ---- */

/* Share of the first half or of the second. */
static double half_share(float share, unsigned second)
{
    double lesser = (double)fabsf(share);
    return (share < 0) != (second != 0) ? 1 - lesser : lesser;
}

/* Which half `*u` falls into, and its place there. */
static unsigned choose_half(float share, double *u, double *density)
{
    double first = half_share(share, 0), rest = half_share(share, 1);
    unsigned second = *u >= first;
    double place = second ? (*u - first) / rest : *u / first;
    *u = fmin(place, 1 - 0x1p-53);
    *density *= 2 * (second ? rest : first);
    return second;
}

double pm_light_table_warp(const struct pm_light_table *table, double *u, double *v)
{
    double x = 0, y = 0, size = 1, density = 1;
    const struct node *node = table->nodes;
    while (node->first) {
        unsigned up = choose_half(node->low, v, &density);
        unsigned right = choose_half(node->left[up], u, &density);
        size /= 2;
        x += right * size;
        y += up * size;
        node = &table->nodes[node->first + 2 * up + right];
    }
    *u = fmin(x + size * *u, 1 - 0x1p-53);
    *v = fmin(y + size * *v, 1 - 0x1p-53);
    return density;
}

double pm_light_table_density(const struct pm_light_table *table, double u, double v)
{
    double density = 1;
    const struct node *node = table->nodes;
    while (node->first) {
        unsigned right = u >= .5, up = v >= .5;
        u = 2 * u - right;
        v = 2 * v - up;
        density *= 4 * half_share(node->low, up) * half_share(node->left[up], right);
        node = &table->nodes[node->first + 2 * up + right];
    }
    return density;
}

/* ---- directions ---- */

struct over_cone {
    const struct pm_light_directions *directions;
    const struct pm_light_beam *beam;
};

static double value_over_cone(const void *context, double u, double v)
{
    const struct over_cone *c = context;
    pm_vec3 local = pm_warp_cap(u, v, c->beam->versine);
    return c->directions->radiance(c->directions->context,
                                   pm_frame_to_world(&c->beam->frame, local));
}

pm_status pm_light_beam_build(const struct pm_light_directions *directions, pm_vec3 axis,
                              double versine, pm_arena *arena, struct pm_light_beam *out,
                              pm_error *err)
{
    struct pm_light_beam beam = {.frame = pm_frame_make(axis), .versine = versine};
    const struct over_cone cone = {directions, &beam};
    const struct pm_light_function function = {value_over_cone, &cone, directions->detail};
    struct pm_light_table *table;
    pm_status status = pm_light_table_build(&function, arena, &table, err);
    if (status)
        return status;
    beam.table = table;
    *out = beam;
    return PM_OK;
}

pm_vec3 pm_light_beam_sample(const struct pm_light_beam *beam, double u, double v, double *pdf)
{
    *pdf = pm_light_table_warp(beam->table, &u, &v) / (2 * PM_PI * beam->versine);
    return pm_frame_to_world(&beam->frame, pm_warp_cap(u, v, beam->versine));
}

double pm_light_beam_pdf(const struct pm_light_beam *beam, pm_vec3 direction)
{
    double u, v;
    pm_vec3 local = pm_frame_to_local(&beam->frame, direction);
    pm_warp_cap_inverse(local, beam->versine, &u, &v);
    return pm_light_table_density(beam->table, u, v) / (2 * PM_PI * beam->versine);
}
