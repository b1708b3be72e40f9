#ifndef PM_WORLD_SKY_H
#define PM_WORLD_SKY_H

#include "world/world_internal.h"

/* Which distant sources cover a direction: a table over the sphere, so that a sky of many
 * patches costs no more than a sky of few. */
struct pm_sky_index;

PM_MUST_USE pm_status pm_sky_index_build(pm_world *world, struct pm_sky_index **out,
                                         pm_error *err);

/* Calls visit(context, source) for each source that covers the direction, always in one order.
 */
void pm_sky_index_visit(const struct pm_sky_index *index, const pm_world *world,
                        pm_vec3 direction, void (*visit)(void *context, uint32_t source),
                        void *context);

#endif
