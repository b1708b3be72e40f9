#include "world/probe.h"

static bool is_in_cube(pm_vec3 p)
{
    const double bound = 1 + PM_CUBE_MARGIN;
    return fabs(p.x) <= bound && fabs(p.y) <= bound && fabs(p.z) <= bound;
}

/* Moves a far origin to where the ray enters the cube, so that rounding to float costs no more
 * than the boxes allow for. False if the ray misses the cube. */
static bool enter_cube(struct pm_probe *q)
{
    const double bound = 1 + PM_CUBE_MARGIN;
    double o[3] = {q->origin.x, q->origin.y, q->origin.z};
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    double in = 0, out = INFINITY;
    for (int i = 0; i < 3; i++) {
        if (d[i] == 0) {
            if (fabs(o[i]) > bound)
                return false;
            continue;
        }
        double a = (-bound - o[i]) / d[i], b = (bound - o[i]) / d[i];
        in = fmax(in, fmin(a, b));
        out = fmin(out, fmax(a, b));
    }
    if (!(in <= out && in < q->limit))
        return false;
    q->entry = in;
    q->limit -= in;
    for (int i = 0; i < 3; i++)
        o[i] = fmin(fmax(o[i] + in * d[i], -bound), bound);
    q->origin = pm_vec3_make(o[0], o[1], o[2]);
    return true;
}

static void set_shear(struct pm_probe *q)
{
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    int z = fabs(d[1]) > fabs(d[0]) ? 1 : 0;
    z = fabs(d[2]) > fabs(d[z]) ? 2 : z;
    int x = (z + 1) % 3, y = (z + 2) % 3;
    q->axis[0] = x;
    q->axis[1] = y;
    q->axis[2] = z;
    q->shear[0] = d[x] / d[z];
    q->shear[1] = d[y] / d[z];
    q->o[0] = q->origin.x;
    q->o[1] = q->origin.y;
    q->o[2] = q->origin.z;
}

/* What lies behind the ray's start: everything up to t = 0, and of what coincides with `from`
 * that which comes before it. */
static void set_start(struct pm_probe *q, uint32_t from)
{
    q->after = (struct pm_ray_key){0, UINT32_MAX, INT64_MAX};
    q->from_group = PM_NO_PRIMITIVE;
    if (from == PM_NO_PRIMITIVE)
        return;
    const struct pm_shape *s = &q->shapes[from];
    double cosine = pm_vec3_dot(pm_shape_normal(s, q->origin), q->direction);
    q->from_group = s->group;
    q->after = pm_ray_key_make(0, s->group, s->layer, s->flipped, cosine);
}

bool pm_probe_init(struct pm_probe *q, const pm_world *world, const pm_ray *ray)
{
    if (!pm_vec3_finite(ray->origin) || !pm_vec3_finite(ray->direction) || !(ray->t_max > 0) ||
        (ray->direction.x == 0 && ray->direction.y == 0 && ray->direction.z == 0) ||
        world->shape_count == 0)
        return false;
    q->shapes = world->shapes;
    q->origin = ray->origin;
    q->direction = ray->direction;
    q->entry = 0;
    q->limit = ray->t_max;
    q->tolerance = world->tolerance;
    if (!is_in_cube(q->origin) && !enter_cube(q))
        return false;
    set_shear(q);
    set_start(q, ray->from);
    q->best = (struct pm_ray_key){INFINITY, 0, 0};
    return true;
}

static bool probe_ring(struct pm_probe *q, const struct pm_shape *s, uint32_t index)
{
    double cosine = pm_vec3_dot(s->axis, q->direction), t = 0;
    if (s->group != q->from_group)
        t = (s->offset - pm_vec3_dot(s->axis, q->origin)) / cosine;
    if (!pm_probe_wants(q, t, cosine))
        return false;
    double r = pm_vec3_distance(pm_vec3_madd(q->origin, t, q->direction), s->center);
    if (!(r >= s->r0 && r <= s->r1))
        return false;
    struct pm_ray_key key = pm_ray_key_make(t, s->group, s->layer, s->flipped, cosine);
    return pm_probe_offer(q, &key, index, PM_NO_PRIMITIVE);
}

static bool probe_curved(struct pm_probe *q, const struct pm_shape *s, uint32_t index)
{
    double t[2];
    int count = pm_shape_roots(s, q->origin, q->direction, s->group == q->from_group, t);
    for (int i = 0; i < count; i++) {
        if (!pm_probe_wants(q, t[i], 1))
            continue;
        pm_vec3 point = pm_vec3_madd(q->origin, t[i], q->direction);
        double cosine = pm_vec3_dot(pm_shape_normal(s, point), q->direction);
        struct pm_ray_key key = pm_ray_key_make(t[i], s->group, s->layer, s->flipped, cosine);
        if (!pm_probe_is_at_end(q, t[i], cosine) &&
            pm_probe_offer(q, &key, index, PM_NO_PRIMITIVE))
            return true;
    }
    return false;
}

bool pm_probe_shape(struct pm_probe *q, uint32_t index)
{
    const struct pm_shape *s = &q->shapes[index];
    return s->type == PM_RING ? probe_ring(q, s, index) : probe_curved(q, s, index);
}
