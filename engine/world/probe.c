#include "world/probe.h"

#include "world/mesh_body.h"

static bool is_in_cube(pm_vec3 p)
{
    const double bound = 1 + PM_CUBE_MARGIN;
    return fabs(p.x) <= bound && fabs(p.y) <= bound && fabs(p.z) <= bound;
}

/* Moves a far origin to where the ray enters the cube, so that rounding to float costs no more
 * than the boxes allow for. False if the ray misses the cube. */
static bool enter_cube(struct pm_probe *q, double *entry)
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
    if (!(in <= out))
        return false;
    *entry = in;
    for (int i = 0; i < 3; i++)
        o[i] = fmin(fmax(o[i] + in * d[i], -bound), bound);
    q->origin = pm_vec3_make(o[0], o[1], o[2]);
    return true;
}

void pm_probe_set_shear(struct pm_probe *q)
{
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    static const int after[4] = {1, 2, 0, 1};
    double size[3] = {fabs(d[0]), fabs(d[1]), fabs(d[2])};
    int z = size[1] > size[0];
    double most = size[1] > size[0] ? size[1] : size[0];
    z = size[2] > most ? 2 : z;
    int x = after[z], y = after[z + 1];
    q->axis[0] = x;
    q->axis[1] = y;
    q->axis[2] = z;
    q->shear[0] = d[x] / d[z];
    q->shear[1] = d[y] / d[z];
    q->o[0] = q->origin.x;
    q->o[1] = q->origin.y;
    q->o[2] = q->origin.z;
    q->sheared = true;
}

/* What lies behind the ray's start: everything up to t = 0, and of what coincides with `from`
 * that which comes before it. */
static void start_on_shape(struct pm_probe *q, const struct pm_probe *at, uint32_t local)
{
    const struct pm_shape *s = &at->body->shapes[local];
    pm_vec3 normal = pm_shape_is_planar(s) ? s->axis : pm_shape_normal(s, at->origin);
    double cosine = pm_vec3_dot(normal, at->direction);
    q->from_group = at->base + s->group;
    q->after = pm_ray_key_make(0, q->from_group, s->layer, s->flipped, cosine);
}

static void start_on_triangle(struct pm_probe *q, const struct pm_probe *at, uint32_t local)
{
    struct pm_mesh_side side = pm_mesh_body_side(&at->body->mesh, local);
    double cosine = pm_vec3_dot(pm_mesh_body_normal(&at->body->mesh, local), at->direction);
    q->from_group = at->base + side.group;
    q->after = pm_ray_key_make(0, q->from_group, side.layer, side.flipped, cosine);
}

static void set_start(struct pm_probe *q, uint32_t from)
{
    q->after = (struct pm_ray_key){0, UINT32_MAX, INT64_MAX};
    q->from = from < q->body->count ? from : PM_NO_PRIMITIVE;
    q->from_group = PM_NO_PRIMITIVE;
    pm_probe_set_foreign(q);
    if (q->from == PM_NO_PRIMITIVE)
        return;
    if (from < q->body->shape_count) {
        start_on_shape(q, q, from);
        return;
    }
    struct pm_place place;
    struct pm_probe at = *q;
    pm_place_find(q->body, from, &place);
    for (int i = 0; i < place.depth; i++) {
        struct pm_probe inner;
        pm_probe_enter(&inner, &at, place.chain[i]);
        at = inner;
    }
    if (at.body->mesh.mesh)
        start_on_triangle(q, &at, place.local);
    else
        start_on_shape(q, &at, place.local);
}

static bool is_ray(const pm_ray *ray)
{
    pm_vec3 o = ray->origin, d = ray->direction;
    double size =
        fabs(d.x) + fabs(d.y) + fabs(d.z); /* one part that is no number makes it so */
    return ray->t_max > 0 && size > 0 && isfinite(size + (fabs(o.x) + fabs(o.y) + fabs(o.z)));
}

bool pm_probe_init(struct pm_probe *q, const pm_world *world, const pm_ray *ray)
{
    if (!is_ray(ray) || world->main->count == 0)
        return false;
    q->body = world->main;
    q->origin = ray->origin;
    q->direction = ray->direction;
    q->entry = q->main_entry = 0;
    q->unit = q->inverse_unit = 1;
    q->base = 0;
    q->material = PM_NO_PRIMITIVE;
    q->limit = ray->t_max;
    q->tolerance = world->tolerance;
    if (!is_in_cube(q->origin)) {
        if (!enter_cube(q, &q->main_entry) || !(q->main_entry < q->limit))
            return false;
        q->limit -= q->main_entry;
    }
    q->sheared = false;
    set_start(q, ray->from);
    q->best = (struct pm_ray_key){INFINITY, 0, 0};
    return true;
}

/* From a surface of the instance itself: off its cube by rounding at most. */
static void clamp_to_cube(struct pm_probe *q)
{
    const double bound = 1 + PM_CUBE_MARGIN;
    q->origin.x = fmin(fmax(q->origin.x, -bound), bound);
    q->origin.y = fmin(fmax(q->origin.y, -bound), bound);
    q->origin.z = fmin(fmax(q->origin.z, -bound), bound);
}

bool pm_probe_enter(struct pm_probe *inner, const struct pm_probe *outer,
                    const struct pm_instance *instance)
{
    *inner = *outer;
    inner->body = instance->body;
    inner->origin = pm_instance_point_in(instance, outer->origin);
    inner->direction = pm_vec3_normalize(pm_instance_direction_in(instance, outer->direction));
    inner->entry = outer->entry / instance->unit;
    inner->unit = outer->unit * instance->unit;
    inner->inverse_unit = 1 / inner->unit;
    inner->base = outer->base + instance->first;
    inner->tolerance = outer->tolerance + inner->unit * instance->body->tolerance;
    if (inner->material == PM_NO_PRIMITIVE)
        inner->material = instance->material;
    pm_probe_set_foreign(inner);
    if (!is_in_cube(inner->origin)) {
        double entry = 0;
        if (outer->from - inner->base < instance->body->count)
            clamp_to_cube(inner);
        else if (!enter_cube(inner, &entry))
            return false;
        inner->entry += entry;
    }
    inner->sheared = false;
    return true;
}

static bool probe_ring(struct pm_probe *q, const struct pm_shape *s, uint32_t index)
{
    double cosine = pm_vec3_dot(s->axis, q->direction), t = 0, along = 0;
    if (!pm_probe_starts_on(q, s->group)) {
        t = (s->offset - pm_vec3_dot(s->axis, q->origin)) / cosine;
        along = pm_probe_along(q, t);
    }
    if (!pm_probe_wants(q, along, cosine))
        return false;
    double r = pm_vec3_distance(pm_vec3_madd(q->origin, t, q->direction), s->center);
    if (!(r >= s->r0 && r <= s->r1))
        return false;
    struct pm_ray_key key =
        pm_ray_key_make(along, q->base + s->group, s->layer, s->flipped, cosine);
    return pm_probe_offer(q, &key, index, PM_NO_PRIMITIVE);
}

static bool probe_curved(struct pm_probe *q, const struct pm_shape *s, uint32_t index)
{
    double t[2];
    bool on = pm_probe_starts_on(q, s->group);
    int count = pm_shape_roots(s, q->origin, q->direction, on, t);
    for (int i = 0; i < count; i++) {
        double along = on && t[i] == 0 ? 0 : pm_probe_along(q, t[i]);
        if (!pm_probe_wants(q, along, 1))
            continue;
        pm_vec3 point = pm_vec3_madd(q->origin, t[i], q->direction);
        double cosine = pm_vec3_dot(pm_shape_normal(s, point), q->direction);
        struct pm_ray_key key =
            pm_ray_key_make(along, q->base + s->group, s->layer, s->flipped, cosine);
        if (!pm_probe_is_at_end(q, along, cosine) && !pm_probe_is_at_start(q, along, cosine) &&
            pm_probe_offer(q, &key, index, PM_NO_PRIMITIVE))
            return true;
    }
    return false;
}

bool pm_probe_shape(struct pm_probe *q, uint32_t index)
{
    const struct pm_shape *s = &q->body->shapes[index];
    if (!pm_probe_sees(q, s->material))
        return false;
    return s->type == PM_RING ? probe_ring(q, s, index) : probe_curved(q, s, index);
}
