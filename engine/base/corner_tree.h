#ifndef PM_BASE_CORNER_TREE_H
#define PM_BASE_CORNER_TREE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/triangulate.h"

/* Points of the plane, to be searched by triangles: a balanced binary tree over the points in
 * Morton order of their ranks, so that points in tight clusters, far from each other, are
 * parted as well as those that are spread evenly. Points are taken out one by one. */
typedef struct pm_corner_tree {
    const struct pm_point2 *points;
    struct pm_point2 size; /* of all points' bounds */
    uint32_t count, leaves;
    uint32_t *items;               /* [count]: numbers of points */
    uint32_t *slot;                /* [all points]: place in `items`; UINT32_MAX if not there */
    uint32_t *left;                /* [2 * leaves]: points below that are still there */
    struct pm_point2 (*bounds)[2]; /* [2 * leaves]: low and high; node i has 2i and 2i + 1 */
} pm_corner_tree;

/* Takes the `count` points whose numbers are in `items`, of `all`. PM_E_MEMORY; clear it in any
 * case. */
PM_MUST_USE pm_status pm_corner_tree_init(pm_corner_tree *tree, const struct pm_point2 *points,
                                          uint32_t all, const uint32_t *items, uint32_t count);
void pm_corner_tree_clear(pm_corner_tree *tree);

/* Nothing happens if it is not there. */
void pm_corner_tree_remove(pm_corner_tree *tree, uint32_t point);

/* Calls test for points in and near the counter-clockwise triangle, all that lie in it or
 * within rounding of it among them, until it says true; whether it did. */
bool pm_corner_tree_any(const pm_corner_tree *tree, const struct pm_point2 abc[3],
                        bool (*test)(const void *context, uint32_t point), const void *context);

#endif
