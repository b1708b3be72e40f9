#ifndef PM_WORLD_TWINS_H
#define PM_WORLD_TWINS_H

#include "world/world_internal.h"

/* Finds coincident surfaces, gives each set of them one group number and, if planar, one plane,
 * so that a ray meets them at the same distance to the last bit and rays.h can order them:
 *   planar shapes  all of whose corners lie within world->tolerance of the plane of a larger
 * one curved shapes  with equal parameters
 * Shapes that coincide with none are a group of their own.
 *
 * Layers order a group from the side that its first normal points to: lamps on the side that
 * they light, so that a lamp in the plane of a ceiling shines; illums next to them; what is
 * left by index. Of lamps on the same side the first hides the others. */
PM_MUST_USE pm_status pm_twins_find(pm_world *world, pm_error *err);

#endif
