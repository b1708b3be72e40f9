#ifndef PM_WORLD_SHAPE_H
#define PM_WORLD_SHAPE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/arena.h"
#include "base/triangulate.h"
#include "base/vec3.h"
#include "scene/scene.h"

/* Exact shapes, in double and in world coordinates. Trees (ray_tree.h) only propose
 * candidates; what is hit and where is decided here and in probe.c. */

struct pm_shape {
    pm_primitive_type type;
    uint32_t material;  /* index into the world's materials */
    uint32_t modifier;  /* index into the world's modifiers (selection.h) */
    uint32_t primitive; /* of the scene that it was made from: for messages alone */
    bool inward;        /* bubble, cup, tube: the front looks at the centre or the axis */

    /* Coincident shapes share a group (twins.h): its number is the index of one of them, and
     * planar ones share one plane to the last bit, up to its sign. */
    uint32_t group;
    bool flipped;   /* axis is opposite to that of the group's first shape */
    int64_t layer;  /* place among coincident shapes (twins.h) */
    bool contested; /* a lamp in whose group other lamps are, one of which may cover it */

    /* polygon, ring: `axis` is the unit front normal, axis . p = offset the plane.
     * sphere, bubble, ring: `center`. cone, cup, cylinder, tube: `center` of the first end,
     * unit `axis` towards the second. */
    pm_vec3 axis,
        center; /* axis: beside the group and the layer, which are asked for with it */
    double offset;
    double deviation; /* polygon: greatest distance of a vertex from the plane */
    double r0, r1; /* sphere: r0. ring: inner, outer. cones: at the first end, at the second */
    double height; /* cones: length of the axis */
    double area;   /* of one side */
    pm_vec3 low, high;

    /* polygon only; the memory belongs to the world */
    const pm_vec3 *vertices;
    const struct pm_triangle *triangles;
    const double *cumulative; /* area of triangles 0..i over the whole area; the last is 1 */
    uint32_t vertex_count, triangle_count;
};

/* Where shapes are made: scene point p is at (p - center) / scale. Points closer than
 * `tolerance` are one point in the precision of the scene's numbers. */
struct pm_shape_frame {
    pm_vec3 center;
    double scale, tolerance;
};

/* Makes the shape of a surface primitive (not `source`), as the parser leaves it: radii
 * positive and in order, ends apart. Vertices and triangles are put into the arena. Errors at
 * the primitive's place: PM_E_RANGE for what has no extent (a polygon without area, anything
 * too small beside the scene) and for polygons with crossing edges; PM_E_MEMORY. Source:
 * Radiance reference manual; src/common/face.c for the plane. */
PM_MUST_USE pm_status pm_shape_make(const pm_scene *scene, const pm_primitive *primitive,
                                    const struct pm_shape_frame *frame, pm_arena *arena,
                                    struct pm_shape *out, pm_error *err);

/* Exact bounds of a surface primitive in scene units; for the world's cube. */
PM_MUST_USE pm_status pm_shape_scene_bounds(const pm_scene *scene,
                                            const pm_primitive *primitive, pm_vec3 *low,
                                            pm_vec3 *high, pm_error *err);

/* Sets low and high. */
void pm_shape_set_bounds(struct pm_shape *shape);

/* False only if the shape misses the closed cube. Used for the octree: conservative, and the
 * same everywhere. */
bool pm_shape_meets_cube(const struct pm_shape *shape, pm_vec3 center, double half);

/* Area of one side [scale^2]. */
double pm_shape_area(const struct pm_shape *shape);

/* A point spread uniformly by area over the shape for u, v uniform in [0, 1), and the unit
 * front normal there. Test: shape_samples_are_uniform_by_area. */
void pm_shape_sample(const struct pm_shape *shape, double u, double v, pm_vec3 *point,
                     pm_vec3 *normal);

/* Ascending distances at which a line meets a curved shape, 0 to 2 of them. With `on` the
 * origin lies on the shape: one root is then exactly 0, and the other free of cancellation (the
 * quadratic is deflated). Test: quadrics_are_met_where_analysis_says. */
int pm_shape_roots(const struct pm_shape *shape, pm_vec3 origin, pm_vec3 direction, bool on,
                   double t[2]);

/* True for a shape that lies in a plane and so meets a ray once at most. */
static inline bool pm_shape_is_planar(const struct pm_shape *shape)
{
    return shape->type == PM_POLYGON || shape->type == PM_RING;
}

static inline bool pm_shape_is_ball(const struct pm_shape *shape)
{
    return shape->type == PM_SPHERE || shape->type == PM_BUBBLE;
}

/* pm_shape_normal and pm_shape_project of cones and their like. */
pm_vec3 pm_shape_cone_normal(const struct pm_shape *shape, pm_vec3 point);
pm_vec3 pm_shape_cone_project(const struct pm_shape *shape, pm_vec3 point);

/* Unit front normal at a point of the shape. */
static inline pm_vec3 pm_shape_normal(const struct pm_shape *s, pm_vec3 point)
{
    if (pm_shape_is_planar(s))
        return s->axis;
    if (!pm_shape_is_ball(s))
        return pm_shape_cone_normal(s, point);
    pm_vec3 out = pm_vec3_normalize(pm_vec3_sub(point, s->center));
    return s->inward ? pm_vec3_negate(out) : out;
}

/* The nearest point of the (unbounded) plane or quadric, for points within rounding of it. */
static inline pm_vec3 pm_shape_project(const struct pm_shape *s, pm_vec3 point)
{
    if (pm_shape_is_planar(s)) {
        double height = pm_vec3_dot(s->axis, point) - s->offset;
        return pm_vec3_madd(point, -height, s->axis);
    }
    if (!pm_shape_is_ball(s))
        return pm_shape_cone_project(s, point);
    pm_vec3 v = pm_vec3_normalize(pm_vec3_sub(point, s->center));
    return pm_vec3_madd(s->center, s->r0, v);
}

#endif
