#include "world/shape.h"

#include <math.h>
#include <stdlib.h>

#include "base/maths.h"
#include "base/triangulate.h"

/* What the steps of making one shape share. */
struct maker {
    const pm_scene *scene;
    const pm_primitive *primitive;
    const struct pm_shape_frame *frame;
    pm_arena *arena;
    struct pm_shape *shape;
    pm_error *err;
};

static pm_status refuse(const struct maker *m, const char *what)
{
    const pm_primitive *p = m->primitive;
    return pm_error_set_at(m->err, PM_E_RANGE, m->scene->files[p->file], p->line, p->column,
                           "%s %s %s", pm_primitive_type_name(p->type), p->name, what);
}

static pm_status no_memory(const struct maker *m)
{
    return pm_error_set(m->err, PM_E_MEMORY, "no memory for the scene's surfaces");
}

static pm_vec3 point_at(const struct maker *m, uint32_t real)
{
    const double *r = m->primitive->reals + real;
    pm_vec3 p = pm_vec3_sub(pm_vec3_make(r[0], r[1], r[2]), m->frame->center);
    return pm_vec3_scale(p, 1 / m->frame->scale);
}

static double length_at(const struct maker *m, uint32_t real)
{
    return m->primitive->reals[real] / m->frame->scale;
}

/* Divides by the greatest component first, so that nothing over- or underflows; 0 for 0. By
 * division, which keeps the axes exact. */
static pm_vec3 unit(pm_vec3 v, double *length)
{
    double most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    *length = 0;
    if (!(most > 0))
        return v;
    v = pm_vec3_make(v.x / most, v.y / most, v.z / most);
    double l = pm_vec3_length(v);
    *length = l * most;
    return pm_vec3_make(v.x / l, v.y / l, v.z / l);
}

/* ---- round shapes: the parser has made radii positive and told their types and order ---- */

static pm_status make_ball(const struct maker *m)
{
    struct pm_shape *s = m->shape;
    s->center = point_at(m, 0);
    s->r0 = s->r1 = length_at(m, 3);
    s->inward = s->type == PM_BUBBLE;
    s->area = 4 * PM_PI * s->r0 * s->r0;
    return PM_OK;
}

static pm_status make_ring(const struct maker *m)
{
    struct pm_shape *s = m->shape;
    const double *r = m->primitive->reals;
    double length;
    s->center = point_at(m, 0);
    s->axis = unit(pm_vec3_make(r[3], r[4], r[5]), &length);
    s->offset = pm_vec3_dot(s->axis, s->center);
    s->r0 = length_at(m, 6);
    s->r1 = length_at(m, 7);
    s->area = PM_PI * (s->r1 - s->r0) * (s->r1 + s->r0);
    return PM_OK;
}

static bool comes_before(pm_vec3 a, pm_vec3 b)
{
    if (a.x != b.x)
        return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

/* The lesser end comes first, so that a cone written from its other end is the same to the last
 * bit. */
static pm_status make_cone(const struct maker *m)
{
    struct pm_shape *s = m->shape;
    bool straight = s->type == PM_CYLINDER || s->type == PM_TUBE;
    double r0 = length_at(m, 6), r1 = straight ? r0 : length_at(m, 7);
    pm_vec3 p0 = point_at(m, 0), p1 = point_at(m, 3);
    bool swap = comes_before(p1, p0);
    s->center = swap ? p1 : p0;
    s->axis = unit(pm_vec3_sub(swap ? p0 : p1, s->center), &s->height);
    if (s->height == 0)
        return refuse(m, "is too short beside the size of the scene");
    s->r0 = swap ? r1 : r0;
    s->r1 = swap ? r0 : r1;
    s->inward = s->type == PM_CUP || s->type == PM_TUBE;
    double rise = s->r1 - s->r0;
    s->area = PM_PI * (s->r0 + s->r1) * sqrt(s->height * s->height + rise * rise);
    return PM_OK;
}

/* ---- polygons ---- */

static double perimeter(const struct pm_shape *s)
{
    double sum = 0;
    for (uint32_t i = 0; i < s->vertex_count; i++)
        sum += pm_vec3_distance(s->vertices[i], s->vertices[(i + 1) % s->vertex_count]);
    return sum;
}

/* The vertices; a last one that repeats the first is dropped, as in Radiance. */
static pm_status place_vertices(const struct maker *m)
{
    uint32_t count = m->primitive->real_count / 3;
    pm_vec3 *vertices = pm_arena_array(m->arena, count, sizeof *vertices);
    if (!vertices)
        return no_memory(m);
    for (uint32_t i = 0; i < count; i++)
        vertices[i] = point_at(m, 3 * i);
    if (count > 3 && pm_vec3_distance(vertices[0], vertices[count - 1]) == 0)
        count--;
    m->shape->vertices = vertices;
    m->shape->vertex_count = count;
    return PM_OK;
}

/* Newell's area vector about the first vertex; its direction is the mean normal that Radiance
 * gives polygons that are not quite planar, and the mean of the vertices lies on the plane. */
static void find_plane(struct pm_shape *s)
{
    pm_vec3 sum = {0, 0, 0}, first = s->vertices[0];
    for (uint32_t i = 2; i < s->vertex_count; i++) {
        pm_vec3 a = pm_vec3_sub(s->vertices[i - 1], first);
        pm_vec3 b = pm_vec3_sub(s->vertices[i], first);
        sum = pm_vec3_add(sum, pm_vec3_cross(a, b));
    }
    double length, height = 0;
    s->axis = unit(sum, &length);
    s->area = length / 2;
    for (uint32_t i = 1; i < s->vertex_count; i++)
        height += pm_vec3_dot(s->axis, pm_vec3_sub(s->vertices[i], first));
    s->center = first;
    s->offset = pm_vec3_dot(s->axis, first) + height / s->vertex_count;
    for (uint32_t i = 0; i < s->vertex_count; i++)
        s->deviation =
            fmax(s->deviation, fabs(pm_vec3_dot(s->axis, s->vertices[i]) - s->offset));
}

/* Along the axis nearest to the normal, so that the polygon turns counter-clockwise. Dropping a
 * coordinate rounds nothing. */
static struct pm_point2 flatten(pm_vec3 p, pm_vec3 normal)
{
    double x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    struct pm_point2 q;
    double sign;
    if (z >= x && z >= y) {
        q = (struct pm_point2){p.x, p.y};
        sign = normal.z;
    } else if (y >= x) {
        q = (struct pm_point2){p.z, p.x};
        sign = normal.y;
    } else {
        q = (struct pm_point2){p.y, p.z};
        sign = normal.x;
    }
    return sign > 0 ? q : (struct pm_point2){q.y, q.x};
}

static pm_status triangulate(const struct maker *m, struct pm_triangle *triangles,
                             double *inverted)
{
    struct pm_shape *s = m->shape;
    enum { FEW = 16 };
    struct pm_point2 few[FEW], *flat = few;
    if (s->vertex_count > FEW)
        flat = malloc(s->vertex_count * sizeof *flat);
    if (!flat)
        return no_memory(m);
    for (uint32_t i = 0; i < s->vertex_count; i++)
        flat[i] = flatten(s->vertices[i], s->axis);
    pm_status status =
        pm_triangulate(flat, s->vertex_count, triangles, &s->triangle_count, inverted);
    if (flat != few)
        free(flat);
    return status ? no_memory(m) : PM_OK;
}

/* Running share of the area; for sampling. */
static void accumulate_areas(struct pm_shape *s, double *cumulative)
{
    double sum = 0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        const uint32_t *corner = s->triangles[i].corner;
        pm_vec3 a = pm_vec3_sub(s->vertices[corner[1]], s->vertices[corner[0]]);
        pm_vec3 b = pm_vec3_sub(s->vertices[corner[2]], s->vertices[corner[0]]);
        sum += pm_vec3_length(pm_vec3_cross(a, b)) / 2;
        cumulative[i] = sum;
    }
    for (uint32_t i = 0; i < s->triangle_count; i++)
        cumulative[i] /= sum;
    s->cumulative = cumulative;
}

/* Most polygons are triangles, and share these. */
static const struct pm_triangle fan[] = {{{0, 1, 2}}};
static const double whole[] = {1};

static pm_status cut_polygon(const struct maker *m, double *inverted)
{
    struct pm_shape *s = m->shape;
    uint32_t most = s->vertex_count - 2;
    struct pm_triangle *triangles = pm_arena_array(m->arena, most, sizeof *triangles);
    double *cumulative = pm_arena_array(m->arena, most, sizeof *cumulative);
    if (!triangles || !cumulative)
        return no_memory(m);
    s->triangles = triangles;
    pm_status status = triangulate(m, triangles, inverted);
    if (!status)
        accumulate_areas(s, cumulative);
    return status;
}

static pm_status make_polygon(const struct maker *m)
{
    struct pm_shape *s = m->shape;
    pm_status status = place_vertices(m);
    if (status)
        return status;
    find_plane(s);
    double rim = m->frame->tolerance * perimeter(s), inverted = 0;
    if (!(s->area > rim))
        return refuse(m, "has no area");
    if (s->vertex_count == 3) {
        s->triangles = fan;
        s->triangle_count = 1;
        s->cumulative = whole;
        return PM_OK;
    }
    status = cut_polygon(m, &inverted);
    if (!status && inverted > rim)
        return refuse(m, "has edges that cross each other");
    return status;
}

pm_status pm_shape_make(const pm_scene *scene, const pm_primitive *primitive,
                        const struct pm_shape_frame *frame, pm_arena *arena,
                        struct pm_shape *out, pm_error *err)
{
    struct pm_shape shape = {.type = primitive->type};
    struct maker m = {scene, primitive, frame, arena, &shape, err};
    pm_status status;
    switch (primitive->type) {
    case PM_POLYGON:
        status = make_polygon(&m);
        break;
    case PM_SPHERE:
    case PM_BUBBLE:
        status = make_ball(&m);
        break;
    case PM_RING:
        status = make_ring(&m);
        break;
    default:
        status = make_cone(&m);
        break;
    }
    if (!status && !(shape.area > 0))
        status = refuse(&m, "is too small beside the size of the scene");
    if (status)
        return status;
    pm_shape_set_bounds(&shape);
    *out = shape;
    return PM_OK;
}

/* ---- bounds in scene units ---- */

/* A power of two at least as great as every number: in its units nothing over- or underflows.
 */
static double unit_of(const double *reals, uint32_t count)
{
    double most = 0;
    int exponent;
    for (uint32_t i = 0; i < count; i++)
        most = fmax(most, fabs(reals[i]));
    frexp(most, &exponent);
    return ldexp(1, exponent);
}

static void polygon_bounds(const pm_primitive *primitive, pm_vec3 *low, pm_vec3 *high)
{
    *low = pm_vec3_make(INFINITY, INFINITY, INFINITY);
    *high = pm_vec3_negate(*low);
    for (uint32_t i = 0; i + 2 < primitive->real_count; i += 3) {
        const double *r = primitive->reals + i;
        pm_vec3 p = {r[0], r[1], r[2]};
        *low = pm_vec3_min(*low, p);
        *high = pm_vec3_max(*high, p);
    }
}

pm_status pm_shape_scene_bounds(const pm_scene *scene, const pm_primitive *primitive,
                                pm_vec3 *low, pm_vec3 *high, pm_error *err)
{
    if (primitive->type == PM_POLYGON) {
        polygon_bounds(primitive, low, high);
        return PM_OK;
    }
    struct pm_shape_frame frame = {.scale = unit_of(primitive->reals, primitive->real_count)};
    struct pm_shape shape;
    pm_status status = pm_shape_make(scene, primitive, &frame, NULL, &shape, err);
    if (status)
        return status;
    *low = pm_vec3_scale(shape.low, frame.scale);
    *high = pm_vec3_scale(shape.high, frame.scale);
    return PM_OK;
}
