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

/* What may stand between a point of a surface and others within a radius: the planes of flat
 * surfaces, and spheres. Left out are those that have all surfaces on one side on which photons
 * may count (photon_map.h: they lean by up to 60 degrees and lie in the tangent plane), as the
 * walls of a convex room are for its floor, and those that stand above or below all of these.
 */
enum { PM_BETWEEN_PLANES = 16, PM_BETWEEN_BALLS = 4 };
typedef struct pm_between {
    bool unknown; /* something else, or too much: who wants to know traces rays */
    uint32_t planes, balls;
    pm_vec3 center;
    double radius;
    struct pm_between_plane {
        pm_vec3 normal;
        double offset, slack; /* the surface is within `slack` of normal . p = offset */
    } plane[PM_BETWEEN_PLANES];
    struct pm_between_ball {
        pm_vec3 center;
        double radius;
    } ball[PM_BETWEEN_BALLS];
} pm_between;

/* The arguments are those of pm_world_stands_near. */
void pm_world_between(const pm_world *world, pm_vec3 point, pm_vec3 normal, double radius,
                      uint32_t from, pm_between *out);

/* Whether nothing can stand between any two places. */
static inline bool pm_between_nothing(const pm_between *between)
{
    return !between->unknown && !between->planes && !between->balls;
}

/* True only if nothing but `from` stands between the places that would hide one from the other
 * (no plane or sphere has them on its two sides or on the way); false tells nothing. Test:
 * clear_places_see_each_other. */
bool pm_between_clear(const pm_between *between, pm_vec3 a, pm_vec3 b);

#endif
