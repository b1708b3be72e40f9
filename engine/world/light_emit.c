#include <math.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/light.h"
#include "world/lights.h"

double pm_emission_share(const pm_emission *emission, double distance)
{
    return pm_lights_focus_share(emission->focus, distance);
}

/* A direction of the beam. The mean of `weight` over u, v is the projected solid angle. */
static pm_vec3 beam_direction(const struct pm_material *spot, pm_vec3 normal, double u,
                              double v, double *weight)
{
    pm_frame frame = pm_frame_make(spot->aim);
    pm_vec3 off = pm_vec3_sub(normal, spot->aim);
    if (pm_vec3_dot(off, off) > 0x1p-80) {
        pm_vec3 w = pm_frame_to_world(&frame, pm_warp_cone(u, v, spot->versine));
        *weight = 2 * PM_PI * spot->versine * fmax(pm_vec3_dot(w, normal), 0);
        return w;
    }
    /* Straight ahead: cosine-weighted, sin^2 being uniform, so that all photons are equal. */
    double square = spot->versine < 1 ? spot->versine * (2 - spot->versine) : 1;
    double versine = u * square / (1 + sqrt(1 - u * square));
    *weight = PM_PI * square;
    return pm_frame_to_world(&frame, pm_warp_cone(1, v, versine));
}

pm_vec3 pm_lights_direction(const struct pm_material *m, pm_vec3 normal, double u, double v,
                            double *weight)
{
    if (m->type == PM_SPOTLIGHT)
        return beam_direction(m, normal, u, v, weight);
    pm_frame frame = pm_frame_make(normal);
    *weight = PM_PI;
    return pm_frame_to_world(&frame, pm_warp_cosine(u, v));
}

static void emit_evenly(const pm_world *world, const struct pm_light *light, const double u[5],
                        pm_emission *out)
{
    const struct pm_material *m = &world->materials[light->material];
    const struct pm_shape *shape = &world->shapes[light->surface];
    double weight;
    pm_shape_sample(shape, u[1], u[2], &out->origin, &out->normal);
    out->direction = pm_lights_direction(m, out->normal, u[3], u[4], &weight);
    out->flux = pm_rgb_scale(m->color, shape->area * weight / light->chance);
}

static void emit_pattern(const pm_world *world, const struct pm_light *light, const double u[5],
                         pm_emission *out)
{
    struct pm_light_draw draw;
    pm_light_draw_leaving(world, light, u + 1, &draw);
    out->origin = draw.hit.point;
    out->normal = draw.hit.normal;
    out->direction = draw.direction;
    pm_rgb radiance = {0, 0, 0};
    if (draw.weight > 0)
        radiance = pm_lights_shine(world, &draw.hit, draw.direction);
    out->flux = pm_rgb_scale(radiance, draw.weight / light->chance);
}

static void emit_from_surface(const pm_world *world, const struct pm_light *light,
                              const double u[5], pm_emission *out)
{
    const struct pm_material *m = &world->materials[light->material];
    (light->pattern ? emit_pattern : emit_evenly)(world, light, u, out);
    out->from = light->surface;
    out->focus = m->type == PM_SPOTLIGHT ? m->focus : 0;
}

static void emit_from_distance(const pm_world *world, const struct pm_light *light,
                               const double u[5], pm_emission *out)
{
    const struct pm_lights *l = world->lights;
    const struct pm_material *m = &world->materials[light->material];
    double solid_angle, area = PM_PI * l->radius * l->radius;
    pm_vec3 up = pm_light_draw_distant(world, light, u[3], u[4], &solid_angle);
    pm_frame about_ray = pm_frame_make(up);
    pm_vec3 place = pm_vec3_scale(pm_warp_disc(u[1], u[2]), l->radius);
    place.z = pm_lights_height(l);
    out->origin = pm_vec3_add(l->center, pm_frame_to_world(&about_ray, place));
    out->direction = pm_vec3_negate(up);
    out->normal = out->direction;
    out->from = PM_NO_PRIMITIVE;
    out->focus = 0;
    out->flux = pm_rgb_grey(0);
    if (m->type == PM_GLOW && pm_lights_is_lit(world, up))
        return;
    out->flux = pm_rgb_scale(pm_lights_shine_far(world, light->distant, up),
                             solid_angle * area / light->chance);
}

bool pm_light_emit(const pm_world *world, const double u[5], pm_emission *out)
{
    const struct pm_lights *l = world->lights;
    if (pm_rgb_is_black(l->power) && !l->patterned)
        return false;
    out->light = pm_lights_pick(l, u[0]);
    const struct pm_light *light = &l->lights[out->light];
    if (light->surface == PM_NO_PRIMITIVE)
        emit_from_distance(world, light, u, out);
    else
        emit_from_surface(world, light, u, out);
    out->weak = pm_lights_is_weak(&world->materials[light->material]);
    return true;
}
