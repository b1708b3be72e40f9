#include "reference_internal.h"

/* Is a point of the polygon's plane inside? Crossing number in the plane's own axes. */
static bool polygon_covers(const struct shape *p, struct vec point)
{
    bool inside = false;
    struct vec previous = vec_sub(p->vertices[p->vertex_count - 1], point);
    for (size_t i = 0; i < p->vertex_count; i++) {
        struct vec next = vec_sub(p->vertices[i], point);
        double x0 = vec_dot(previous, p->u), y0 = vec_dot(previous, p->v);
        double x1 = vec_dot(next, p->u), y1 = vec_dot(next, p->v);
        if ((y0 > 0) != (y1 > 0) && x0 + (x1 - x0) * (y0 / (y0 - y1)) > 0)
            inside = !inside;
        previous = next;
    }
    return inside;
}

static size_t plane_root(struct vec on_plane, struct vec normal, struct vec origin,
                         struct vec direction, double *t)
{
    double slope = vec_dot(direction, normal);
    if (slope == 0)
        return 0;
    *t = vec_dot(vec_sub(on_plane, origin), normal) / slope;
    return isfinite(*t) ? 1 : 0;
}

static size_t polygon_roots(const struct shape *p, struct vec o, struct vec d, double t[2])
{
    if (!plane_root(p->vertices[0], p->axis, o, d, t))
        return 0;
    return polygon_covers(p, vec_along(o, t[0], d)) ? 1 : 0;
}

static size_t ring_roots(const struct shape *ring, struct vec o, struct vec d, double t[2])
{
    if (!plane_root(ring->center, ring->axis, o, d, t))
        return 0;
    struct vec radial = vec_sub(vec_along(o, t[0], d), ring->center);
    double r2 = vec_dot(radial, radial);
    return r2 >= ring->r0 * ring->r0 && r2 <= ring->r1 * ring->r1 ? 1 : 0;
}

/* Real, finite roots of a t^2 + 2 b t + c, ascending, without cancellation. `starts_here` drops
 * the root nearest 0 before anything else can. */
static size_t quadratic_roots(double a, double b, double c, bool starts_here, double t[2])
{
    double discriminant = b * b - a * c;
    if (!(discriminant > 0))
        return 0;
    double q = -(b + copysign(sqrt(discriminant), b));
    double r0 = c / q, r1 = q / a;
    if (!isfinite(r1)) { /* a is 0: a single root */
        t[0] = r0;
        return starts_here ? 0 : 1;
    }
    if (starts_here) {
        t[0] = fabs(r0) < fabs(r1) ? r1 : r0;
        return 1;
    }
    t[0] = fmin(r0, r1);
    t[1] = fmax(r0, r1);
    return 2;
}

static size_t sphere_roots(const struct shape *s, struct vec o, struct vec d, bool starts_here,
                           double t[2])
{
    struct vec w = vec_sub(o, s->center);
    double distance = vec_length(w);
    double c = (distance - s->r0) * (distance + s->r0);
    return quadratic_roots(1, vec_dot(w, d), c, starts_here, t);
}

/* The side is |radial| = r0 + k h for heights h in [0, length]. */
static size_t cone_roots(const struct shape *s, struct vec o, struct vec d, bool starts_here,
                         double t[2])
{
    double k = (s->r1 - s->r0) / s->length;
    struct vec w = vec_sub(o, s->center);
    double w_high = vec_dot(w, s->axis), d_high = vec_dot(d, s->axis);
    struct vec w_side = vec_along(w, -w_high, s->axis), d_side = vec_along(d, -d_high, s->axis);
    double radius = s->r0 + k * w_high, side = vec_length(w_side);
    double raw[2];
    size_t n = quadratic_roots(vec_dot(d_side, d_side) - k * k * d_high * d_high,
                               vec_dot(w_side, d_side) - k * d_high * radius,
                               (side - radius) * (side + radius), starts_here, raw);
    size_t kept = 0;
    for (size_t i = 0; i < n; i++) {
        double high = w_high + raw[i] * d_high;
        if (high >= 0 && high <= s->length)
            t[kept++] = raw[i];
    }
    return kept;
}

size_t ref_shape_roots(const struct shape *shape, struct vec origin, struct vec direction,
                       bool starts_here, double t[2])
{
    switch (shape->kind) {
    case SHAPE_POLYGON:
        return starts_here ? 0 : polygon_roots(shape, origin, direction, t);
    case SHAPE_RING:
        return starts_here ? 0 : ring_roots(shape, origin, direction, t);
    case SHAPE_SPHERE:
        return sphere_roots(shape, origin, direction, starts_here, t);
    case SHAPE_CONE:
        return cone_roots(shape, origin, direction, starts_here, t);
    case SHAPE_SOURCE:
        break;
    }
    return 0;
}

static struct vec cone_normal(const struct shape *s, struct vec point)
{
    struct vec w = vec_sub(point, s->center);
    struct vec radial = vec_along(w, -vec_dot(w, s->axis), s->axis);
    double k = (s->r1 - s->r0) / s->length;
    return vec_unit(vec_along(vec_unit(radial), -k, s->axis));
}

struct vec ref_shape_normal(const struct shape *shape, struct vec point)
{
    struct vec normal = shape->axis;
    if (shape->kind == SHAPE_SPHERE)
        normal = vec_unit(vec_sub(point, shape->center));
    else if (shape->kind == SHAPE_CONE)
        normal = cone_normal(shape, point);
    return shape->inward ? vec_scale(normal, -1) : normal;
}

static struct vec polygon_point(const struct shape *p, struct ref_rng *rng)
{
    struct vec point;
    do {
        double u = p->u_min + (p->u_max - p->u_min) * ref_rng_uniform(rng);
        double v = p->v_min + (p->v_max - p->v_min) * ref_rng_uniform(rng);
        point = vec_along(vec_along(p->vertices[0], u, p->u), v, p->v);
    } while (!polygon_covers(p, point));
    return point;
}

/* On a ring and on a cone's side alike, the area between two radii goes with their squares. */
static double radius_by_area(const struct shape *s, struct ref_rng *rng)
{
    double a = s->r0 * s->r0, b = s->r1 * s->r1;
    return sqrt(a + (b - a) * ref_rng_uniform(rng));
}

static struct vec round_point(const struct shape *s, struct ref_rng *rng)
{
    double radius = radius_by_area(s, rng);
    double phi = 2 * REF_PI * ref_rng_uniform(rng);
    double high = 0;
    if (s->kind == SHAPE_CONE)
        high = s->r0 == s->r1 ? s->length * ref_rng_uniform(rng)
                              : s->length * (radius - s->r0) / (s->r1 - s->r0);
    struct vec base = vec_along(s->center, high, s->axis);
    return vec_along(base, radius, vec_polar(s->axis, 0, phi));
}

static struct vec area_point(const struct shape *shape, struct ref_rng *rng)
{
    if (shape->kind == SHAPE_POLYGON)
        return polygon_point(shape, rng);
    if (shape->kind != SHAPE_SPHERE)
        return round_point(shape, rng);
    double cosine = 1 - 2 * ref_rng_uniform(rng);
    double phi = 2 * REF_PI * ref_rng_uniform(rng);
    return vec_along(shape->center, shape->r0, vec_polar((struct vec){0, 0, 1}, cosine, phi));
}

static bool sample_area(const struct shape *shape, struct vec from, struct ref_rng *rng,
                        struct light_sample *sample)
{
    struct vec point = area_point(shape, rng);
    struct vec w = vec_sub(point, from);
    double distance = vec_length(w);
    if (distance == 0)
        return false;
    sample->direction = vec_scale(w, 1 / distance);
    sample->distance = distance;
    double cosine = -vec_dot(sample->direction, ref_shape_normal(shape, point));
    if (cosine <= 0)
        return false;
    sample->pdf_solid_angle = distance * distance / (cosine * shape->area);
    return true;
}

/* Uniform in the cone that a sphere fills as seen from outside. */
static bool sample_sphere(const struct shape *s, struct vec from, struct ref_rng *rng,
                          struct light_sample *sample)
{
    struct vec w = vec_sub(s->center, from);
    double distance = vec_length(w);
    if (distance <= s->r0)
        return false;
    double sine2_max = (s->r0 / distance) * (s->r0 / distance);
    double height = sine2_max / (1 + sqrt(1 - sine2_max)); /* 1 - cosine_max, exactly */
    double cosine = 1 - height * ref_rng_uniform(rng);
    double phi = 2 * REF_PI * ref_rng_uniform(rng);
    sample->direction = vec_polar(vec_scale(w, 1 / distance), cosine, phi);
    double reach2 = s->r0 * s->r0 - distance * distance * (1 - cosine * cosine);
    sample->distance = distance * cosine - sqrt(fmax(0, reach2));
    sample->pdf_solid_angle = 1 / (2 * REF_PI * height);
    return true;
}

static bool sample_source(const struct shape *s, struct ref_rng *rng,
                          struct light_sample *sample)
{
    double height = s->area / (2 * REF_PI);
    double cosine = 1 - height * ref_rng_uniform(rng);
    double phi = 2 * REF_PI * ref_rng_uniform(rng);
    sample->direction = vec_polar(s->axis, cosine, phi);
    sample->distance = INFINITY;
    sample->pdf_solid_angle = 1 / s->area;
    return true;
}

bool ref_shape_sample(const struct shape *shape, struct vec from, struct ref_rng *rng,
                      struct light_sample *sample)
{
    if (shape->kind == SHAPE_SOURCE)
        return sample_source(shape, rng, sample);
    if (shape->kind == SHAPE_SPHERE && !shape->inward)
        return sample_sphere(shape, from, rng, sample);
    return sample_area(shape, from, rng, sample);
}
