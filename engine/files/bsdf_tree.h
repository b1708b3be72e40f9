#ifndef PM_FILES_BSDF_TREE_H
#define PM_FILES_BSDF_TREE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/error.h"
#include "base/rgb.h"
#include "base/vec3.h"
#include "files/bsdf_cell.h"

/* Tensor trees: a function on the unit cube of 3 (isotropic) or 4 dimensions, cut by halves as
 * deep as it needs. The last two are where light goes, the first where it comes from: in the
 * square of Shirley and Chiu that stands for projected solid angle, or only its radius.
 * Tests: test_bsdf_tree.c. */

enum { PM_TREE_LEVELS = 12 }; /* of halving; Radiance's own programs write at most 9 */

#define PM_TREE_LEAF 0x80000000U

/* One scalar tree. A link is PM_TREE_LEAF | index of a value, or the index of a node. */
struct pm_tree_nodes {
    struct pm_tree_node {
        uint32_t first; /* of its 2^rank links, or of its values */
        int32_t level;  /* >= 1: a grid of 2^level cells a dimension, the last one fastest; -1:
                           a branch, dimension d's upper half has bit d */
    } * nodes;
    uint32_t *links;
    float *values;
    uint32_t node_count, link_count, value_count, root;
    unsigned rank, depth; /* depth: levels of halving down to the smallest cell */
};

void pm_tree_nodes_clear(struct pm_tree_nodes *nodes);

float pm_tree_nodes_at(const struct pm_tree_nodes *nodes, const double *at);

/* Which directions a table of sums is for: `fixed` dimensions are given, two are free. */
struct pm_tree_table {
    unsigned row_bits;  /* of each fixed dimension */
    unsigned cell_bits; /* of each free one */
    size_t rows;
    float *sums;   /* [rows][cells + 1], running */
    double *total; /* [rows], albedo */
};

struct pm_tree {
    struct pm_tree_nodes y, u, v; /* u and v without a root link if there is no colour */
    bool has_colour;
    pm_rgb least;                  /* Lambertian part [1/sr], not subtracted in the nodes */
    double least_y;                /* its luminance */
    double cell;                   /* projected solid angle of the smallest cell [sr] */
    struct pm_tree_table table[2]; /* [1]: of reversed walks; empty if not wanted */
};

/* Takes the nodes (u, v: NULL without colour) if it succeeds. */
PM_MUST_USE pm_status pm_tree_new(struct pm_tree_nodes *y, struct pm_tree_nodes *u,
                                  struct pm_tree_nodes *v, struct pm_tree **tree,
                                  pm_rgb *diffuse);
PM_MUST_USE pm_status pm_tree_make_reversed(struct pm_tree *tree);
void pm_tree_free(struct pm_tree *tree);

/* The queries of bsdf.h, of directions on the side with z > 0 (only x and y count). */
pm_rgb pm_tree_value(const struct pm_tree *tree, bool reversed, pm_vec3 in, pm_vec3 out);
double pm_tree_albedo(const struct pm_tree *tree, bool reversed, pm_vec3 in);
bool pm_tree_cell(const struct pm_tree *tree, bool reversed, pm_vec3 in, pm_vec3 out,
                  struct pm_bsdf_place *place);
bool pm_tree_sample(const struct pm_tree *tree, bool reversed, pm_vec3 in, double u, double v,
                    pm_vec3 *out);

/* Centre of the i-th row of directions that a walk may come from; false beyond the last. */
bool pm_tree_direction(const struct pm_tree *tree, bool reversed, size_t i, pm_vec3 *in);

/* Row of the walk's direction among pm_tree_direction's. */
size_t pm_tree_row(const struct pm_tree *tree, bool reversed, pm_vec3 in);

/* Whether all directions of a row meet the same cells. */
bool pm_tree_rows_suffice(const struct pm_tree *tree);

/* ---- between bsdf_tree.c and bsdf_tree_sum.c ---- */

/* Shirley and Chiu's square of the unit disc and back; both within [0, 1)^2 and |r| < 1. */
void pm_square_of_disc(double x, double y, double *square);
pm_vec3 pm_disc_of_square(const double *square);

/* What is left of one tree below a box, whether it is a branch, within a grid, or constant. */
struct pm_tree_cursor {
    const struct pm_tree_nodes *nodes;
    uint32_t link;
    int32_t below;      /* levels of the grid still to go; 0 outside one */
    uint32_t corner[4]; /* in the grid */
};

struct pm_tree_cursor pm_tree_root(const struct pm_tree_nodes *nodes);
struct pm_tree_cursor pm_tree_child(struct pm_tree_cursor cursor, unsigned n);

static inline bool pm_tree_constant(const struct pm_tree_cursor *cursor)
{
    return cursor->link & PM_TREE_LEAF;
}

static inline double pm_tree_constant_value(const struct pm_tree_cursor *cursor)
{
    return (double)cursor->nodes->values[cursor->link & ~PM_TREE_LEAF];
}

/* A box of the two free dimensions, the others fixed. */
struct pm_tree_slice {
    const struct pm_tree *tree;
    unsigned free;    /* the first of the two free dimensions */
    const double *at; /* position; only the fixed dimensions count */
    double low[2], high[2];
};

/* A cell of the slice, clipped to its box. Masses are integrals of Y - least over the square.
 */
struct pm_tree_leaf {
    double low[2], high[2];
    double before, mass, total; /* of the cells before it, its own, of the whole box */
};

/* The cell in which the running sum passes `share` (in [0, 1)) of the whole; false if that is
 * nothing. */
bool pm_tree_slice_pick(const struct pm_tree_slice *slice, double share,
                        struct pm_tree_leaf *leaf);

/* The cell that holds `point` [2]. */
bool pm_tree_slice_find(const struct pm_tree_slice *slice, const double *point,
                        struct pm_tree_leaf *leaf);

/* Builds the table of walks along the file's direction (or, rank 4, against it). */
PM_MUST_USE pm_status pm_tree_table_sum(struct pm_tree *tree, bool reversed);

/* Rank 3 against the file's direction: by quadrature of the value. */
PM_MUST_USE pm_status pm_tree_table_probe(struct pm_tree *tree);

#endif
