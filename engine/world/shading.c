#include "world/shading.h"

#include "world/material.h"

/* ---- beginning ---- */

void pm_shading_init(struct pm_shading *s, const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                     double distance)
{
    s->world = world;
    s->hit = hit;
    s->wo = wo;
    s->distance = distance;
    s->segment = hit->t;
    s->far = false;
    s->color = (pm_rgb){1, 1, 1};
    s->perturbation = hit->perturbation;
    s->in_instance = hit->surface != PM_NO_PRIMITIVE &&
                     pm_world_instance_transform(world, hit->surface, &s->from_instance,
                                                 &s->to_instance);
    s->frame = NULL;
}

void pm_shading_init_far(struct pm_shading *s, const pm_world *world, pm_hit *hit, pm_vec3 wo)
{
    *hit = (pm_hit){.normal = wo, .surface = PM_NO_PRIMITIVE, .material = PM_NO_PRIMITIVE};
    pm_shading_init(s, world, hit, wo, 0);
    s->far = true;
}

/* ---- the ray as functions see it ---- */

/* Radiance's FHUGE: the distance of what is infinitely far (src/rt/ray.h). */
#define FAR_DISTANCE 1e10

static void set_vector(double *out, pm_vec3 v, double scale)
{
    out[0] = v.x * scale;
    out[1] = v.y * scale;
    out[2] = v.z * scale;
}

/* From the scene's coordinates to those of the modifier. */
static pm_transform own_frame(const struct pm_shading *s, const struct pm_modifier *m)
{
    return s->in_instance ? pm_transform_then(&s->to_instance, &m->inverse) : m->inverse;
}

/* Radiance's chanvalue (src/rt/func.c). */
static void fill(struct pm_ray_values *ray, const struct pm_shading *s, const pm_transform *own)
{
    double *v = ray->value, unit = 1 / own->scale;
    pm_vec3 point = {0, 0, 0};
    if (!s->far)
        point = pm_transform_point(own, pm_world_to_scene(s->world, s->hit->point));
    double length = s->far ? own->scale : own->scale * s->world->scale;
    double cosine = pm_vec3_dot(s->wo, s->hit->normal);
    set_vector(&v[PM_RAY_DX], pm_transform_vector(own, s->wo), -unit);
    set_vector(&v[PM_RAY_NX], pm_transform_vector(own, s->hit->normal), unit);
    set_vector(&v[PM_RAY_PX], point, 1);
    v[PM_RAY_T] = (s->far ? FAR_DISTANCE : s->distance) * length;
    v[PM_RAY_TS] = (s->far ? FAR_DISTANCE : s->segment) * length;
    v[PM_RAY_RDOT] = cosine < -1 ? -1 : cosine > 1 ? 1 : cosine;
    v[PM_RAY_S] = own->scale;
    for (int j = 0; j < 3; j++) {
        v[PM_RAY_TX + j] = own->shift[j];
        v[PM_RAY_IX + j] = own->turn[0][j] * unit;
        v[PM_RAY_JX + j] = own->turn[1][j] * unit;
        v[PM_RAY_KX + j] = own->turn[2][j] * unit;
    }
    v[PM_RAY_LU] = s->hit->u;
    v[PM_RAY_LV] = s->hit->v;
    for (int i = PM_RAY_NXP; i < PM_RAY_VALUES; i++)
        v[i] = 0;
}

struct pm_ray_values *pm_shading_ray(struct pm_shading *s, const struct pm_modifier *m)
{
    if (s->frame != m) {
        const pm_transform own = own_frame(s, m);
        fill(&s->ray, s, &own);
        s->ray.reals = m->reals;
        s->ray.real_count = m->real_count;
        s->frame = m;
    }
    return &s->ray;
}

bool pm_shading_evaluate(struct pm_shading *s, const struct pm_modifier *m,
                         pm_function function, const double *args, unsigned arg_count,
                         double *values)
{
    const pm_language *language = pm_assets_language(s->world->assets);
    const struct pm_ray_values *ray = pm_shading_ray(s, m);
    return !pm_function_values(language, function, ray, args, arg_count, values);
}

pm_vec3 pm_shading_to_world(const struct pm_shading *s, const struct pm_modifier *m, pm_vec3 v)
{
    double scale = m->transform.scale;
    v = pm_transform_vector(&m->transform, v);
    if (s->in_instance) {
        scale *= s->from_instance.scale;
        v = pm_transform_vector(&s->from_instance, v);
    }
    return pm_vec3_scale(v, 1 / scale);
}

pm_vec3 pm_shading_to_own(const struct pm_shading *s, const struct pm_modifier *m, pm_vec3 v)
{
    const pm_transform own = own_frame(s, m);
    return pm_vec3_scale(pm_transform_vector(&own, v), 1 / own.scale);
}

/* ---- results ---- */

pm_vec3 pm_shading_normal(const struct pm_shading *s)
{
    pm_vec3 p = s->perturbation, flat = s->hit->normal;
    if (p.x == 0 && p.y == 0 && p.z == 0)
        return flat;
    pm_vec3 normal = pm_vec3_normalize(pm_vec3_add(flat, p));
    if (normal.x == 0 && normal.y == 0 && normal.z == 0)
        return flat;
    double cosine = pm_vec3_dot(normal, s->wo);
    if ((cosine > 0) != (pm_vec3_dot(flat, s->wo) > 0)) /* mirrored about the plane of sight */
        normal = pm_vec3_normalize(pm_vec3_madd(normal, -2 * cosine, s->wo));
    return normal;
}

static double limited(double x, double most)
{
    return x > 0 ? (x < most ? x : most) : 0;
}

pm_rgb pm_shading_reflectance(const struct pm_shading *s, pm_rgb base)
{
    pm_rgb c = pm_rgb_mul(base, s->color);
    return (pm_rgb){limited(c.r, 1), limited(c.g, 1), limited(c.b, 1)};
}

pm_rgb pm_shading_radiance(const struct pm_shading *s, pm_rgb base)
{
    pm_rgb c = pm_rgb_mul(base, s->color);
    return (pm_rgb){limited(c.r, INFINITY), limited(c.g, INFINITY), limited(c.b, INFINITY)};
}
