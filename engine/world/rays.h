#ifndef PM_WORLD_RAYS_H
#define PM_WORLD_RAYS_H

#include "world/world_internal.h"

/* Ray queries. Each body has a tree (ray_tree.h); in it, instances are boxes, behind which the
 * ray goes on in the tree of the instance's body. Trees are walked in float, over boxes and
 * triangles that are wide enough for every rounding; what the ray may meet is tested in double
 * against the exact shape. So the answer is the exact nearest surface whatever the tree looks
 * like. */

/* Where a surface comes along a ray: by distance, and coincident ones (one group, see twins.h)
 * as if they lay an infinitesimal apart, the lesser layer on the side that the group's first
 * normal points to. A total order: walking along a ray meets every surface once and ends. */
struct pm_ray_key {
    double t;
    uint32_t group;
    int64_t order;
};

/* The trees of all bodies; world->rays owns them. */
PM_MUST_USE pm_status pm_rays_build(pm_world *world, pm_error *err);
void pm_rays_free(struct pm_rays *rays);

/* The surfaces along one ray, one after the other, all seen from the same origin. Zeroed
 * storage starts at the origin. False when there is none left before t_max. */
struct pm_ray_walk {
    struct pm_ray_key last;
    bool started;
};

bool pm_rays_next(const pm_world *world, const pm_ray *ray, struct pm_ray_walk *walk,
                  pm_hit *hit);

/* Whether any surface lies before t_max. */
bool pm_rays_any(const pm_world *world, const pm_ray *ray);

#endif
