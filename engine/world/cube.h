#ifndef PM_WORLD_CUBE_H
#define PM_WORLD_CUBE_H

#include "world/identity.h"

/* Sets world->low, high, center, scale and tolerance from the bounds of the local surfaces: the
 * smallest cube whose edge is a power of two and whose corner is a multiple of a quarter of it,
 * so that a small edit seldom moves it. Without local surfaces: [-1, 1]^3.
 * Errors: PM_E_RANGE if the sizes or the distance from the origin leave no digits to work with.
 */
PM_MUST_USE pm_status pm_cube_choose(pm_world *world, const pm_scene *scene,
                                     const struct pm_identity *identity, pm_error *err);

#endif
