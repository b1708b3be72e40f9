#ifndef PM_WORLD_TWINS_H
#define PM_WORLD_TWINS_H

#include "world/world_internal.h"

/* Finds coincident surfaces, gives each set of them one group number and, if planar, one plane,
 * so that a ray meets them at the same distance to the last bit and rays.h can order them:
 *   planar shapes  all of whose corners lie within world->tolerance of the plane of a larger
 * one curved shapes  with equal parameters Shapes that coincide with none are a group of their
 * own. */
PM_MUST_USE pm_status pm_twins_find(pm_world *world, pm_error *err);

#endif
