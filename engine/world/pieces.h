#ifndef PM_WORLD_PIECES_H
#define PM_WORLD_PIECES_H

#include <stdalign.h>

#include "world/probe.h"

/* Polygons as rays meet them. */

/* A triangle, or two that share the edge from corner 0 to corner 2; a single triangle repeats
 * its corner 0 as corner 3. Two cache lines: in a large mesh fetching them is what a test
 * costs. */
struct pm_piece {
    alignas(64) double corner[3][4]; /* [axis][corner] */
    pm_vec3 normal;                  /* normal . p = offset */
    double offset;
};

/* Whose piece it is. */
struct pm_piece_owner {
    uint32_t shape, group, material; /* numbers in the body */
    int64_t layer;
    bool flipped;
    bool planar; /* the shape is: its normal is the piece's */
};

struct pm_pieces {
    size_t count;
    struct pm_piece *piece;
    struct pm_piece_owner *owner;
};

/* The pieces of all polygons of a body, neighbours in space beside each other: digests scatter
 * them. */
PM_MUST_USE pm_status pm_pieces_build(const struct pm_body *body, struct pm_pieces *out);
void pm_pieces_clear(struct pm_pieces *pieces);

/* The exact test, watertight (watertight.h). True if the piece is the best so far.
 *   inside  it is known already that the ray passes within the piece's edges
 * Test: closed_surfaces_leak_no_ray. */
bool pm_probe_piece(struct pm_probe *probe, const struct pm_pieces *pieces, uint32_t index,
                    bool inside);

#endif
