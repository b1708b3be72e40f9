#ifndef PM_BASE_TRIANGULATE_H
#define PM_BASE_TRIANGULATE_H

#include <stdint.h>

#include "base/status.h"

struct pm_point2 {
    double x, y;
};

/* A piece of a polygon: three indices into its vertices, wound as the polygon is. */
struct pm_triangle {
    uint32_t corner[3];
};

/* Cuts a counter-clockwise polygon into triangles over its own vertices.
 *   points    the corners in order; concave, with collinear or repeated corners, with holes
 * joined by seams (Radiance's convention: the seam is walked twice) out       room for count -
 * 2 triangles, counter-clockwise; those of zero area are kept, because they close the gaps that
 * rounding would open beside collinear corners, unless two corners are equal inverted  out:
 * area of clockwise triangles. 0 (or rounding) if no edges cross; the triangles then cover the
 * inside exactly once, since they add up to the polygon's boundary and the winding number is 1
 * inside and 0 outside Ear clipping (Meisters 1975), shortest diagonal first, with a tree over
 * the reflex corners (Held, "FIST", Algorithmica 30, 2001). Returns PM_OK or PM_E_MEMORY.
 * Tests: test_triangulate.c. */
PM_MUST_USE pm_status pm_triangulate(const struct pm_point2 *points, uint32_t count,
                                     struct pm_triangle *out, uint32_t *made, double *inverted);

#endif
