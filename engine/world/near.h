#ifndef PM_WORLD_NEAR_H
#define PM_WORLD_NEAR_H

#include "world/world.h"

/* What stands around a point of a surface. */

/* Whether a surface may rise above the tangent plane within `radius` of a point on one, more
 * steeply than PM_STEEP_COSINE says: a wall, by whose foot light and darkness meet. True also
 * for some that are a little farther, never false for one of flat parts that is within.
 *   from  the surface that the point lies on, which never counts; or PM_NO_PRIMITIVE
 * Test: walls_within_the_radius_are_found. */
#define PM_STEEP_COSINE .8
bool pm_world_stands_near(const pm_world *world, pm_vec3 point, pm_vec3 normal, double radius,
                          uint32_t from);

#endif
