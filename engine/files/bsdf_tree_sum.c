/* Sums over tensor trees: of slices, and the tables that begin a search in them. */
#include <stdlib.h>

#include "base/maths.h"
#include "files/bsdf_tree.h"

/* ---- slices ---- */

/* Passes over the cells of a slice in a fixed order. */
struct pass {
    const struct pm_tree_slice *slice;
    double sum, target;  /* target: of picking */
    const double *point; /* of finding; NULL: picks */
    struct pm_tree_leaf *leaf;
    bool found, stops;
};

static double above_least(const struct pm_tree *tree, const struct pm_tree_cursor *c)
{
    double value = pm_tree_constant_value(c) - tree->least_y;
    return value > 0 ? value : 0;
}

static void pass_leaf(struct pass *p, const struct pm_tree_cursor *c, const double *low,
                      const double *high)
{
    double mass = above_least(p->slice->tree, c) * (high[0] - low[0]) * (high[1] - low[1]);
    bool here = p->point ? p->point[0] >= low[0] && p->point[0] < high[0] &&
                               p->point[1] >= low[1] && p->point[1] < high[1]
                         : mass > 0 && !p->stops; /* the last one, if rounding passes it */
    if (here) {
        p->found = true;
        *p->leaf = (struct pm_tree_leaf){.low = {low[0], low[1]},
                                         .high = {high[0], high[1]},
                                         .before = p->sum,
                                         .mass = mass};
    }
    p->sum += mass;
    if (!p->point && p->sum > p->target)
        p->stops = true;
}

/* Which half of each fixed dimension holds the position. */
static unsigned fixed_half(const struct pm_tree_slice *s, const double *local, double *below)
{
    unsigned n = 0;
    for (unsigned d = 0; d < s->tree->y.rank; d++) {
        if (d == s->free || d == s->free + 1)
            continue;
        unsigned upper = local[d] >= .5;
        n |= upper << d;
        below[d] = 2 * local[d] - upper;
    }
    return n;
}

static void pass_box(struct pass *p, struct pm_tree_cursor c, const double *local, double x,
                     double y, double edge)
{
    const struct pm_tree_slice *s = p->slice;
    double low[2] = {fmax(x, s->low[0]), fmax(y, s->low[1])};
    double high[2] = {fmin(x + edge, s->high[0]), fmin(y + edge, s->high[1])};
    if (low[0] >= high[0] || low[1] >= high[1] || p->stops)
        return;
    if (pm_tree_constant(&c)) {
        pass_leaf(p, &c, low, high);
        return;
    }
    double below[4];
    unsigned n = fixed_half(s, local, below);
    edge /= 2;
    for (unsigned k = 0; k < 4; k++)
        pass_box(p, pm_tree_child(c, n | k << s->free), below, x + (k & 1) * edge,
                 y + (k >> 1) * edge, edge);
}

static double run(struct pass *p)
{
    pass_box(p, pm_tree_root(&p->slice->tree->y), p->slice->at, 0, 0, 1);
    return p->sum;
}

bool pm_tree_slice_find(const struct pm_tree_slice *slice, const double *point,
                        struct pm_tree_leaf *leaf)
{
    struct pass pass = {.slice = slice, .point = point, .leaf = leaf};
    double total = run(&pass);
    leaf->total = total;
    return pass.found;
}

bool pm_tree_slice_pick(const struct pm_tree_slice *slice, double share,
                        struct pm_tree_leaf *leaf)
{
    struct pass all = {.slice = slice, .target = INFINITY, .leaf = leaf};
    double total = run(&all);
    struct pass pass = {.slice = slice, .target = share * total, .leaf = leaf};
    run(&pass);
    leaf->total = total;
    return pass.found;
}

/* ---- tables ---- */

static pm_status table_new(struct pm_tree_table *table, unsigned fixed, unsigned row_bits,
                           unsigned cell_bits)
{
    *table = (struct pm_tree_table){
        .row_bits = row_bits, .cell_bits = cell_bits, .rows = (size_t)1 << (fixed * row_bits)};
    table->sums = calloc(table->rows * (((size_t)1 << 2 * cell_bits) + 1), sizeof(float));
    table->total = calloc(table->rows, sizeof(double));
    return table->sums && table->total ? PM_OK : PM_E_MEMORY;
}

/* From masses, stored one place late, to running sums. */
static void accumulate(const struct pm_tree_table *table)
{
    size_t cells = (size_t)1 << 2 * table->cell_bits;
    for (size_t row = 0; row < table->rows; row++) {
        float *sums = table->sums + row * (cells + 1);
        double sum = 0;
        for (size_t i = 1; i <= cells; i++)
            sums[i] = (float)(sum += (double)sums[i]);
    }
}

/* The cells of a table, 2^bits of them, that a box at `corner` of level `level` meets. */
struct span {
    uint32_t first, count;
    double share; /* of each cell that the box covers */
};

static struct span span_of(uint32_t corner, unsigned level, unsigned bits)
{
    if (level >= bits)
        return (struct span){corner >> (level - bits), 1, 1 / (double)(1U << (level - bits))};
    return (struct span){corner << (bits - level), 1U << (bits - level), 1};
}

struct build {
    struct pm_tree *tree;
    struct pm_tree_table *table;
    unsigned free;
};

static void add_to_row(const struct build *b, size_t row, double mass, const struct span *cells)
{
    unsigned bits = b->table->cell_bits;
    size_t width = ((size_t)1 << 2 * bits) + 1;
    float *sums = b->table->sums + row * width + 1;
    for (uint32_t i = 0; i < cells[0].count; i++)
        for (uint32_t j = 0; j < cells[1].count; j++)
            sums[((cells[0].first + i) << bits) + cells[1].first + j] += (float)mass;
    b->table->total[row] += mass * cells[0].count * cells[1].count;
}

static void add_leaf(const struct build *b, double value, const uint32_t *corner,
                     unsigned level)
{
    struct pm_tree_table *t = b->table;
    unsigned rank = b->tree->y.rank, fixed = b->free == 0 ? 2 : 0;
    struct span rows[2] = {{0, 1, 1}, {0, 1, 1}};
    for (unsigned d = 0; d < rank - 2; d++)
        rows[d + (rank == 3)] = span_of(corner[fixed + d], level, t->row_bits);
    struct span cells[2] = {span_of(corner[b->free], level, t->cell_bits),
                            span_of(corner[b->free + 1], level, t->cell_bits)};
    double cell = PM_PI / (double)(1ULL << 2 * t->cell_bits);
    double mass =
        value * rows[0].share * rows[1].share * cells[0].share * cells[1].share * cell;
    for (uint32_t i = 0; i < rows[0].count; i++)
        for (uint32_t j = 0; j < rows[1].count; j++)
            add_to_row(b, ((size_t)(rows[0].first + i) << t->row_bits) + rows[1].first + j,
                       mass, cells);
}

static void add_box(const struct build *b, struct pm_tree_cursor c, const uint32_t *corner,
                    unsigned level)
{
    if (pm_tree_constant(&c)) {
        double value = above_least(b->tree, &c);
        if (value > 0)
            add_leaf(b, value, corner, level);
        return;
    }
    unsigned rank = b->tree->y.rank;
    for (unsigned n = 0; n < 1U << rank; n++) {
        uint32_t below[4] = {0};
        for (unsigned d = 0; d < rank; d++)
            below[d] = 2 * corner[d] + (n >> d & 1);
        add_box(b, pm_tree_child(c, n), below, level + 1);
    }
}

pm_status pm_tree_table_sum(struct pm_tree *tree, bool reversed)
{
    unsigned depth = tree->y.depth, rank = tree->y.rank;
    struct build b = {
        .tree = tree, .table = &tree->table[reversed], .free = reversed ? 0 : rank - 2};
    pm_status st = table_new(b.table, rank - 2, depth < 7 ? depth : 7, depth < 4 ? depth : 4);
    if (st)
        return st;
    const uint32_t corner[4] = {0};
    add_box(&b, pm_tree_root(&tree->y), corner, 0);
    accumulate(b.table);
    return PM_OK;
}

/* ---- rank 3 against the file's direction ---- */

/* Mean luminance over a cell of the square and a range of radii; cells are probed at 2 x 2
 * points, radii at 3. */
static double probe(const struct pm_tree *tree, double r, double spread, double x, double y,
                    double edge)
{
    double sum = 0;
    for (int i = 0; i < 12; i++) {
        double radius = fmin(r + (i % 3 - 1) * spread / 3, 1);
        double square[2] = {x + (.25 + .5 * (i / 3 & 1)) * edge,
                            y + (.25 + .5 * (i / 6)) * edge};
        pm_vec3 in = {radius, 0, sqrt(fmax(1 - radius * radius, 0))};
        sum += pm_rgb_luminance(pm_tree_value(tree, true, in, pm_disc_of_square(square)));
    }
    return sum / 12;
}

/* Narrow peaks may lie between the probes: every cell keeps a twentieth of the mean. */
static void floor_row(float *mass, size_t cells, double total)
{
    for (size_t i = 0; i < cells; i++)
        mass[i] += (float)(.05 * total / (double)cells);
}

pm_status pm_tree_table_probe(struct pm_tree *tree)
{
    unsigned depth = tree->y.depth + 1;
    struct pm_tree_table *t = &tree->table[1];
    pm_status st = table_new(t, 1, depth < 6 ? depth : 6, depth < 5 ? depth : 5);
    if (st)
        return st;
    size_t side = (size_t)1 << t->cell_bits, cells = side * side;
    double edge = 1 / (double)side, step = 1 / (double)t->rows;
    for (size_t row = 0; row < t->rows; row++) {
        float *mass = t->sums + row * (cells + 1) + 1;
        for (size_t i = 0; i < cells; i++) {
            double m = PM_PI * edge * edge *
                       probe(tree, ((double)row + .5) * step, step, (double)(i / side) * edge,
                             (double)(i % side) * edge, edge);
            mass[i] = (float)m;
            t->total[row] += m;
        }
        floor_row(mass, cells, t->total[row]);
    }
    accumulate(t);
    return PM_OK;
}
