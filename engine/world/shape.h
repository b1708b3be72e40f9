#ifndef PM_WORLD_SHAPE_H
#define PM_WORLD_SHAPE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/vec3.h"
#include "scene/scene.h"

/* Exact shapes, in double and in world coordinates. Embree only proposes candidates; what is
 * hit and where is decided here. */

/* Planar pieces of a polygon: three indices into its vertices each, wound as the polygon is. */
struct pm_triangle {
    uint32_t corner[3];
};

struct pm_shape {
    pm_primitive_type type;
    uint32_t material; /* index into the world's materials */
    bool inward;       /* bubble, cup, tube: the front looks at the centre or the axis */

    /* polygon: a point of the plane, unit front normal. sphere, bubble: the centre.
     * ring: centre, unit front normal. cone, cup, cylinder, tube: centre of the first end, unit
     * axis towards the second. */
    pm_vec3 center, axis;
    double r0, r1; /* sphere: r0. ring: inner, outer. cones: at the first end, at the second */
    double height; /* cones: length of the axis */
    double area;   /* of one side */

    /* polygon only; the memory belongs to the world */
    const pm_vec3 *vertices;
    const struct pm_triangle *triangles;
    const double *cumulative; /* area of triangles 0..i over the whole area; the last is 1 */
    uint32_t vertex_count, triangle_count;
};

/* Area of one side [scale^2]. */
double pm_shape_area(const struct pm_shape *shape);

/* A point spread uniformly by area over the shape for u, v uniform in [0, 1), and the unit
 * front normal there. Test: shape_samples_are_uniform_by_area. */
void pm_shape_sample(const struct pm_shape *shape, double u, double v, pm_vec3 *point,
                     pm_vec3 *normal);

/* Unit front normal at a point of the shape. */
pm_vec3 pm_shape_normal(const struct pm_shape *shape, pm_vec3 point);

/* True for a shape that lies in a plane and so meets a ray once at most. */
static inline bool pm_shape_is_planar(const struct pm_shape *shape)
{
    return shape->type == PM_POLYGON || shape->type == PM_RING;
}

#endif
