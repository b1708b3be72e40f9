#ifndef PM_WORLD_BODIES_H
#define PM_WORLD_BODIES_H

#include "world/identity.h"

/* Makes the world's bodies: prototypes in the order of the identity, the main scene last, each
 * with its bounds, cube, shapes or triangles, and instances. In two steps, since materials need
 * the main scene's cube, and shapes the materials. The second also sets world->shapes and
 * shape_count.
 *
 * Errors at the primitive's place: those of shape.h and cube.h; PM_E_RANGE for an instance that
 * is too small beside the scene; PM_E_UNSUPPORTED for one whose modifier is a light, which
 * Radiance refuses too (markallsources in src/rt/source.c: only what has an area is a source);
 * PM_E_LIMIT for 2^32 surfaces in all. */
PM_MUST_USE pm_status pm_bodies_place(pm_world *world, const pm_scene *scene,
                                      const struct pm_identity *identity, pm_error *err);
PM_MUST_USE pm_status pm_bodies_fill(pm_world *world, const pm_scene *scene,
                                     const struct pm_identity *identity, pm_error *err);

#endif
