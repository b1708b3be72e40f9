#ifndef PM_WORLD_RAY_TREE_H
#define PM_WORLD_RAY_TREE_H

#include <stdalign.h>

#include "world/pieces.h"

/* What rays walk through in a body: a tree of boxes, eight to a node, over its triangles, round
 * shapes and instances. Boxes and triangles are in float and only propose: whatever a ray may
 * meet for all roundings is tested in double (probe.h, pieces.h, mesh_body.h).
 *
 * Embree builds the tree; it is walked here (rays.c), since Embree asks for every surface that
 * is not its own through a callback, which costs more than the test. */

enum {
    PM_TREE_WIDTH = 8,
    PM_TREE_DEPTH = 40,                            /* more than it is built */
    PM_TREE_STACK = PM_TREE_DEPTH * PM_TREE_WIDTH, /* places of the nodes put off */
};

/* Where a subtree lies: a node, or a leaf if the lowest bit is set; 0: nothing. */
typedef uintptr_t pm_tree_link;

struct pm_tree_node {
    alignas(32) float bound[2][3][PM_TREE_WIDTH]; /* [low, high][axis]; nothing: inverted */
    pm_tree_link child[PM_TREE_WIDTH];
};

/* Up to eight items. A triangle or parallelogram as a plane and two coordinates in it, 0 at the
 * first corner and 1 at the next ones. What is neither has NaN there; its box is in `boxes`. */
struct pm_tree_leaf {
    alignas(32) float plane[4][PM_TREE_WIDTH]; /* x y z of the unit normal; offset */
    float along[2][4][PM_TREE_WIDTH];          /* u, v = x y z of it . point + the last */
    float steep[PM_TREE_WIDTH];                /* greatest change of u or v with the point */
    float most[PM_TREE_WIDTH];                 /* of u + v: 1 in a triangle, else 2 */
    uint32_t item[PM_TREE_WIDTH];
    uint32_t surface[PM_TREE_WIDTH]; /* of the body, if it is flat and so never meets a ray that
                                        starts from it; else PM_NO_PRIMITIVE */
    struct pm_tree_node *boxes;      /* NULL: none is needed */
    unsigned lanes;                  /* bits of those that are taken */
    unsigned flat;                   /* of those that have a plane */
};

/* A body with so few leaves needs no tree: all of it is tested. */
enum { PM_TREE_FEW = 4 };

/* Items are numbered: pieces of polygons or a mesh's triangles, then round shapes (those that
 * are no polygons), then instances. */
struct pm_ray_tree {
    const struct pm_body *body;
    struct pm_pieces pieces;
    uint32_t flat_count; /* pieces or triangles */
    uint32_t round_count;
    uint32_t *round;
    pm_tree_link root;
    struct pm_tree_leaf *few; /* [few_count], instead of a tree; or NULL */
    struct pm_tree_node *few_boxes;
    uint32_t few_count;
    void *memory; /* that Embree gave for nodes and leaves */
};

/* Boxes are widened by this. A ray starts in the cube [-1, 1]^3 (and PM_CUBE_MARGIN) when it is
 * rounded to float: its origin is then off by at most 2^-25 a coordinate, its direction by
 * 2^-25, which over at most 2 sqrt(3) is 3.5 * 2^-25. Together less than 5 * 2^-25, and the box
 * is rounded by 2^-24 at most. */
#define PM_TREE_MARGIN 0x1p-22

/* Embree, with one thread: none is started behind the caller's back. NULL if it does not start.
 */
void *pm_tree_builder_new(void);
void pm_tree_builder_free(void *builder);

/* Zeroed storage on; it is to be cleared whether this fails or not. */
PM_MUST_USE pm_status pm_ray_tree_build(struct pm_ray_tree *tree, void *builder,
                                        const struct pm_body *body, pm_error *err);
void pm_ray_tree_clear(struct pm_ray_tree *tree);

/* The corners of a flat item; a triangle's first is its last as well. */
void pm_ray_tree_corners(const struct pm_ray_tree *tree, uint32_t item, pm_vec3 out[4]);

#endif
