#include "files/bsdf_tree.h"

#include <stdlib.h>
#include <string.h>

#include "base/maths.h"
#include "base/warp.h"
#include "files/bsdf_internal.h"

/* ---- nodes ---- */

void pm_tree_nodes_clear(struct pm_tree_nodes *nodes)
{
    free(nodes->nodes);
    free(nodes->links);
    free(nodes->values);
    *nodes = (struct pm_tree_nodes){.rank = 0};
}

static uint32_t grid_index(uint32_t first, const uint32_t *corner, unsigned rank, int32_t level)
{
    uint32_t index = 0;
    for (unsigned d = 0; d < rank; d++)
        index = (index << level) + corner[d];
    return first + index;
}

float pm_tree_nodes_at(const struct pm_tree_nodes *t, const double *at)
{
    double local[4];
    uint32_t link = t->root, corner[4];
    memcpy(local, at, t->rank * sizeof *local);
    while (!(link & PM_TREE_LEAF)) {
        const struct pm_tree_node *node = &t->nodes[link];
        if (node->level > 0) {
            for (unsigned d = 0; d < t->rank; d++)
                corner[d] = (uint32_t)(local[d] * (double)(1U << node->level));
            return t->values[grid_index(node->first, corner, t->rank, node->level)];
        }
        uint32_t n = 0;
        for (unsigned d = 0; d < t->rank; d++) {
            uint32_t upper = local[d] >= .5;
            n |= upper << d;
            local[d] = 2 * local[d] - upper;
        }
        link = t->links[node->first + n];
    }
    return t->values[link & ~PM_TREE_LEAF];
}

struct pm_tree_cursor pm_tree_root(const struct pm_tree_nodes *nodes)
{
    return (struct pm_tree_cursor){.nodes = nodes, .link = nodes->root};
}

struct pm_tree_cursor pm_tree_child(struct pm_tree_cursor c, unsigned n)
{
    if (c.link & PM_TREE_LEAF)
        return c;
    const struct pm_tree_node *node = &c.nodes->nodes[c.link];
    if (node->level < 0) {
        c.link = c.nodes->links[node->first + n];
        return c;
    }
    unsigned rank = c.nodes->rank;
    c.below = (c.below ? c.below : node->level) - 1;
    for (unsigned d = 0; d < rank; d++)
        c.corner[d] += (n >> d & 1) << c.below;
    if (c.below == 0)
        c.link = PM_TREE_LEAF | grid_index(node->first, c.corner, rank, node->level);
    return c;
}

/* ---- Shirley and Chiu's square ---- */

static double clamp(double x)
{
    return x < 0 ? 0 : x < 1 ? x : 1 - 0x1p-40;
}

void pm_square_of_disc(double x, double y, double *square)
{
    double r = sqrt(x * x + y * y), a, b;
    bool flat = fabs(x) > fabs(y);
    double major = flat ? x : y, minor = flat ? y : x;
    double sign = copysign(1, major);
    double angle = pm_atan2(sign * minor, sign * major) * (4 / PM_PI);
    a = sign * r;
    b = sign * r * angle;
    square[0] = clamp(.5 + .5 * (flat ? a : b));
    square[1] = clamp(.5 + .5 * (flat ? b : a));
}

pm_vec3 pm_disc_of_square(const double *square)
{
    pm_vec3 d = pm_warp_disc(square[0], square[1]);
    double z2 = 1 - d.x * d.x - d.y * d.y;
    d.z = sqrt(fmax(z2, 0x1p-64)); /* never in the plane: the density stays positive */
    return d;
}

/* ---- positions ---- */

/* A walk's position: the fixed dimensions, and the turn that an isotropic one takes out. */
struct place {
    double at[4];
    double cosine, sine;
    unsigned free; /* first of the free dimensions */
    bool probed;   /* the table stands for itself: cells are not looked into */
};

static bool isotropic(const struct pm_tree *tree)
{
    return tree->y.rank == 3;
}

/* The radius of light's origin, whose direction is (x, y): Radiance's coordinate. */
static double radius_coordinate(double r)
{
    return clamp(.5 - 1e-6 - .5 * r);
}

static void turn_to(struct place *p, double x, double y, double r, double sign)
{
    p->cosine = r > 0 ? sign * x / r : sign;
    p->sine = r > 0 ? sign * y / r : 0;
}

static struct place place_of(const struct pm_tree *tree, bool reversed, pm_vec3 in)
{
    struct place p = {.cosine = 1, .free = tree->y.rank - 2};
    if (isotropic(tree)) {
        double r = sqrt(in.x * in.x + in.y * in.y);
        turn_to(&p, in.x, in.y, r, reversed ? 1 : -1);
        p.probed = reversed;
        p.at[0] = reversed ? clamp(r) : radius_coordinate(r);
    } else if (reversed) {
        p.free = 0;
        pm_square_of_disc(in.x, in.y, p.at + 2);
    } else {
        pm_square_of_disc(-in.x, -in.y, p.at);
    }
    return p;
}

/* Square of the direction where a walk goes on, and back. */
static void free_square(const struct place *p, bool reversed, pm_vec3 out, double *square)
{
    double sign = reversed && !p->probed ? -1 : 1;
    double x = sign * out.x, y = sign * out.y;
    pm_square_of_disc(p->cosine * x + p->sine * y, p->cosine * y - p->sine * x, square);
}

static pm_vec3 free_direction(const struct place *p, bool reversed, const double *square)
{
    double sign = reversed && !p->probed ? -1 : 1;
    pm_vec3 d = pm_disc_of_square(square);
    return (pm_vec3){sign * (p->cosine * d.x - p->sine * d.y),
                     sign * (p->cosine * d.y + p->sine * d.x), d.z};
}

/* ---- value ---- */

static pm_rgb value_at(const struct pm_tree *tree, const double *at)
{
    double y = (double)pm_tree_nodes_at(&tree->y, at);
    if (!tree->has_colour)
        return pm_rgb_grey(fmax(y - tree->least_y, 0));
    pm_rgb f = pm_bsdf_rgb_from_yuv(y, (double)pm_tree_nodes_at(&tree->u, at),
                                    (double)pm_tree_nodes_at(&tree->v, at));
    f = pm_rgb_sub(f, tree->least);
    return (pm_rgb){fmax(f.r, 0), fmax(f.g, 0), fmax(f.b, 0)};
}

pm_rgb pm_tree_value(const struct pm_tree *tree, bool reversed, pm_vec3 in, pm_vec3 out)
{
    struct place p = place_of(tree, false, reversed ? out : in);
    free_square(&p, false, reversed ? in : out, p.at + p.free);
    return value_at(tree, p.at);
}

/* ---- Lambertian part ---- */

struct least {
    pm_rgb rgb;
    double y;
};

static pm_rgb least_of(pm_rgb a, pm_rgb b)
{
    return (pm_rgb){fmin(a.r, b.r), fmin(a.g, b.g), fmin(a.b, b.b)};
}

/* Follows the three trees down to where all are constant. */
static void find_least(struct pm_tree_cursor y, struct pm_tree_cursor u,
                       struct pm_tree_cursor v, bool colour, unsigned children, pm_rgb *least)
{
    if (pm_tree_constant(&y) && (!colour || (pm_tree_constant(&u) && pm_tree_constant(&v)))) {
        double level = pm_tree_constant_value(&y);
        pm_rgb f = colour ? pm_bsdf_rgb_from_yuv(level, pm_tree_constant_value(&u),
                                                 pm_tree_constant_value(&v))
                          : pm_rgb_grey(level);
        *least = least_of(*least, f);
        return;
    }
    unsigned all = 1U << y.nodes->rank;
    for (unsigned n = 0; n < all; n += all / children)
        find_least(pm_tree_child(y, n), colour ? pm_tree_child(u, n) : u,
                   colour ? pm_tree_child(v, n) : v, colour, all, least);
}

static pm_rgb take_diffuse(struct pm_tree *tree)
{
    pm_rgb least = pm_rgb_grey(INFINITY);
    /* the upper half of an isotropic tree's radius is not used: its children have bit 0 */
    unsigned children = isotropic(tree) ? 4 : 16;
    find_least(pm_tree_root(&tree->y), pm_tree_root(&tree->u), pm_tree_root(&tree->v),
               tree->has_colour, children, &least);
    if (!(pm_rgb_luminance(least) > PM_BSDF_LEAST_DIFFUSE))
        return pm_rgb_grey(0);
    tree->least = least;
    tree->least_y = tree->has_colour ? pm_rgb_luminance(least) : least.r;
    return pm_rgb_scale(least, PM_PI);
}

/* ---- making ---- */

pm_status pm_tree_new(struct pm_tree_nodes *y, struct pm_tree_nodes *u, struct pm_tree_nodes *v,
                      struct pm_tree **out, pm_rgb *diffuse)
{
    struct pm_tree *tree = calloc(1, sizeof *tree);
    if (!tree)
        return PM_E_MEMORY;
    tree->y = *y;
    tree->has_colour = u && v;
    if (tree->has_colour) {
        tree->u = *u;
        tree->v = *v;
    }
    unsigned depth = y->depth;
    tree->cell = PM_PI / (double)(1ULL << (2 * depth));
    pm_rgb part = take_diffuse(tree);
    pm_status st = pm_tree_table_sum(tree, false);
    if (st) { /* the nodes stay the caller's */
        tree->y = tree->u = tree->v = (struct pm_tree_nodes){.rank = 0};
        pm_tree_free(tree);
        return st;
    }
    *y = (struct pm_tree_nodes){.rank = 0};
    if (tree->has_colour)
        *u = *v = *y;
    *out = tree;
    *diffuse = part;
    return PM_OK;
}

pm_status pm_tree_make_reversed(struct pm_tree *tree)
{
    return isotropic(tree) ? pm_tree_table_probe(tree) : pm_tree_table_sum(tree, true);
}

void pm_tree_free(struct pm_tree *tree)
{
    if (!tree)
        return;
    pm_tree_nodes_clear(&tree->y);
    pm_tree_nodes_clear(&tree->u);
    pm_tree_nodes_clear(&tree->v);
    for (int i = 0; i < 2; i++) {
        free(tree->table[i].sums);
        free(tree->table[i].total);
    }
    free(tree);
}

/* ---- albedo, sampling ---- */

static size_t row_of(const struct pm_tree *tree, bool reversed, const struct place *p)
{
    const struct pm_tree_table *table = &tree->table[reversed];
    double cells = (double)(1U << table->row_bits);
    if (isotropic(tree))
        return (size_t)(p->at[0] * cells);
    const double *at = p->at + (reversed ? 2 : 0);
    return ((size_t)(at[0] * cells) << table->row_bits) + (size_t)(at[1] * cells);
}

size_t pm_tree_row(const struct pm_tree *tree, bool reversed, pm_vec3 in)
{
    struct place p = place_of(tree, reversed, in);
    return row_of(tree, reversed, &p);
}

bool pm_tree_rows_suffice(const struct pm_tree *tree)
{
    return tree->table[0].row_bits == tree->y.depth;
}

double pm_tree_albedo(const struct pm_tree *tree, bool reversed, pm_vec3 in)
{
    struct place p = place_of(tree, reversed, in);
    return tree->table[reversed].total[row_of(tree, reversed, &p)];
}

static const float *sums_of(const struct pm_tree *tree, bool reversed, const struct place *p,
                            size_t *count)
{
    const struct pm_tree_table *table = &tree->table[reversed];
    *count = (size_t)1 << (2 * table->cell_bits);
    const float *sums = table->sums + row_of(tree, reversed, p) * (*count + 1);
    return sums[*count] > 0 ? sums : NULL;
}

static struct pm_tree_slice slice_of(const struct pm_tree *tree, bool reversed,
                                     const struct place *p, size_t column)
{
    unsigned bits = tree->table[reversed].cell_bits;
    double edge = 1 / (double)(1U << bits);
    double x = (double)(column >> bits) * edge;
    double y = (double)(column & ((1U << bits) - 1)) * edge;
    return (struct pm_tree_slice){.tree = tree,
                                  .free = p->free,
                                  .at = p->at,
                                  .low = {x, y},
                                  .high = {x + edge, y + edge}};
}

static struct pm_tree_leaf whole(const struct pm_tree_slice *s)
{
    return (struct pm_tree_leaf){
        .low = {s->low[0], s->low[1]}, .high = {s->high[0], s->high[1]}, .mass = 1, .total = 1};
}

bool pm_tree_cell(const struct pm_tree *tree, bool reversed, pm_vec3 in, pm_vec3 out,
                  struct pm_bsdf_place *place)
{
    struct place p = place_of(tree, reversed, in);
    size_t count;
    const float *sums = sums_of(tree, reversed, &p, &count);
    if (!sums)
        return false;
    double square[2];
    unsigned bits = tree->table[reversed].cell_bits;
    free_square(&p, reversed, out, square);
    size_t column = ((size_t)(square[0] * (double)(1U << bits)) << bits) +
                    (size_t)(square[1] * (double)(1U << bits));
    struct pm_tree_slice slice = slice_of(tree, reversed, &p, column);
    struct pm_tree_leaf leaf = whole(&slice);
    if (!p.probed && !pm_tree_slice_find(&slice, square, &leaf))
        return false;
    double total = (double)sums[count], start = (double)sums[column];
    double share = (double)sums[column + 1] - start;
    bool some = leaf.total > 0;
    place->start = (start + (some ? share * leaf.before / leaf.total : 0)) / total;
    place->share = some ? share * leaf.mass / leaf.total / total : 0;
    place->projected = PM_PI * (leaf.high[0] - leaf.low[0]) * (leaf.high[1] - leaf.low[1]);
    return true;
}

bool pm_tree_sample(const struct pm_tree *tree, bool reversed, pm_vec3 in, double u, double v,
                    pm_vec3 *out)
{
    struct place p = place_of(tree, reversed, in);
    size_t count;
    const float *sums = sums_of(tree, reversed, &p, &count);
    if (!sums)
        return false;
    double rest, square[2];
    size_t column = pm_bsdf_step(sums, count, u * (double)sums[count], &rest);
    struct pm_tree_slice slice = slice_of(tree, reversed, &p, column);
    struct pm_tree_leaf leaf = whole(&slice);
    if (!p.probed) {
        if (!pm_tree_slice_pick(&slice, rest, &leaf))
            return false;
        rest = clamp((rest * leaf.total - leaf.before) / leaf.mass);
    }
    square[0] = leaf.low[0] + rest * (leaf.high[0] - leaf.low[0]);
    square[1] = leaf.low[1] + v * (leaf.high[1] - leaf.low[1]);
    *out = free_direction(&p, reversed, square);
    return true;
}

bool pm_tree_direction(const struct pm_tree *tree, bool reversed, size_t i, pm_vec3 *in)
{
    const struct pm_tree_table *table = &tree->table[reversed];
    if (i >= table->rows)
        return false;
    double edge = 1 / (double)(1U << table->row_bits);
    if (isotropic(tree)) {
        double at = ((double)i + .5) * edge;
        double r = reversed ? at : fmax(1 - 2 * at, 0);
        *in = (pm_vec3){r, 0, sqrt(fmax(1 - r * r, 0x1p-64))};
        return true;
    }
    size_t column = i & ((1U << table->row_bits) - 1), row = i >> table->row_bits;
    double square[2] = {((double)row + .5) * edge, ((double)column + .5) * edge};
    *in = pm_disc_of_square(square);
    if (!reversed)
        *in = (pm_vec3){-in->x, -in->y, in->z};
    return true;
}
