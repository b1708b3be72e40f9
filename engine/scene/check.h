#ifndef PM_SCENE_CHECK_H
#define PM_SCENE_CHECK_H

#include <stdbool.h>

#include "scene/scene.h"

/* Checks the values of a primitive's reals (their count is right). NULL if they are right; else
 * what would be right, and *index the argument at fault. Accepted is what Radiance accepts and
 * physics allows; refused is what would create light (reflectance above 1), take it away
 * (negative radiance), or has no extent. */
const char *pm_check_reals(pm_primitive_type type, const double *reals, size_t count,
                           size_t *index);

/* False for a polygon whose area is nothing but the rounding of its numbers. */
bool pm_check_has_area(const double *reals, size_t count);

/* Writes one thing in one way, as Radiance reads it (src/common/cone.c, src/ot/sphere.c): a
 * negative radius turns a surface inside out (sphere and bubble, cone and cup, cylinder and
 * tube change places), a cone with equal radii is a cylinder, a ring's inner radius comes
 * first. The reals are right. */
void pm_check_canonical(pm_primitive_type *type, double *reals, uint32_t *count);

#endif
