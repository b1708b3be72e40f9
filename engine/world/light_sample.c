#include <math.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/light.h"
#include "world/lights.h"

/* Shadow rays end this share of their length before the light, which so never hides itself. */
#define SHORT_OF_LIGHT 0x1p-20

/* For next events half by power and half evenly, so that beside the sun a lamp is found too. */
static uint32_t pick_for_point(const struct pm_lights *l, double u)
{
    if (u < .5)
        return pm_lights_pick(l, 2 * u);
    return (uint32_t)((2 * u - 1) * (double)l->count);
}

/* The cone that a sphere fills seen from outside: its versine, 0 from inside. */
static double sphere_versine(const struct pm_shape *sphere, pm_vec3 point, pm_vec3 *to_center)
{
    *to_center = pm_vec3_sub(sphere->center, point);
    double square = sphere->r0 * sphere->r0 / pm_vec3_dot(*to_center, *to_center);
    return square < 1 ? square / (1 + sqrt(1 - square)) : 0;
}

static bool sample_sphere(const struct pm_shape *sphere, pm_vec3 point, const double u[3],
                          pm_light_sample *out, pm_hit *hit)
{
    pm_vec3 to_center;
    double versine = sphere_versine(sphere, point, &to_center);
    if (!(versine > 0))
        return false;
    double distance = pm_vec3_length(to_center);
    pm_frame frame = pm_frame_make(pm_vec3_scale(to_center, 1 / distance));
    pm_vec3 local = pm_warp_cone(u[1], u[2], versine);
    double square = local.x * local.x + local.y * local.y;
    double half_chord = sphere->r0 * sphere->r0 - distance * distance * square;
    out->wi = pm_frame_to_world(&frame, local);
    out->distance = distance * local.z - sqrt(fmax(half_chord, 0));
    out->pdf = 1 / (2 * PM_PI * versine);
    hit->point = pm_vec3_madd(point, out->distance, out->wi);
    hit->normal = pm_vec3_scale(pm_vec3_sub(hit->point, sphere->center), 1 / sphere->r0);
    return out->distance > 0;
}

static bool sample_area(const struct pm_shape *shape, pm_vec3 point, const double u[3],
                        pm_light_sample *out, pm_hit *hit)
{
    pm_shape_sample(shape, u[1], u[2], &hit->point, &hit->normal);
    pm_vec3 way = pm_vec3_sub(hit->point, point);
    out->distance = pm_vec3_length(way);
    if (!(out->distance > 0))
        return false;
    out->wi = pm_vec3_scale(way, 1 / out->distance);
    double cosine = -pm_vec3_dot(out->wi, hit->normal);
    out->pdf = out->distance * out->distance / (shape->area * cosine);
    return cosine > 0;
}

/* Another lamp lies right on this one, on the side that the point sees. */
static bool is_covered(const pm_world *world, uint32_t surface, pm_vec3 point,
                       const pm_light_sample *sample)
{
    pm_ray ray = {.origin = pm_vec3_madd(point, sample->distance, sample->wi),
                  .direction = pm_vec3_negate(sample->wi),
                  .t_max = sample->distance * SHORT_OF_LIGHT,
                  .from = surface};
    pm_hit hit;
    return pm_world_intersect(world, &ray, &hit) &&
           world->shapes[hit.surface].group == world->shapes[surface].group;
}

static bool sample_surface(const pm_world *world, const struct pm_light *light, pm_vec3 point,
                           const double u[3], pm_light_sample *out)
{
    const struct pm_shape *shape = &world->shapes[light->surface];
    pm_hit hit = {.surface = light->surface, .material = light->material};
    bool found = shape->type == PM_SPHERE ? sample_sphere(shape, point, u, out, &hit)
                                          : sample_area(shape, point, u, out, &hit);
    if (!found || (shape->contested && is_covered(world, light->surface, point, out)))
        return false;
    hit.t = out->distance;
    double share = pm_lights_focus_share(world->materials[light->material].focus, hit.t);
    out->radiance = pm_rgb_scale(pm_lights_shine(world, &hit, pm_vec3_negate(out->wi)), share);
    out->distance *= 1 - SHORT_OF_LIGHT;
    return true;
}

/* A direction that a distant source covers; but for an illum every other source there counts
 * too, with the density of all. */
static void sample_distant(const pm_world *world, uint32_t picked, const double u[3],
                           pm_light_sample *out)
{
    const struct pm_light *light = &world->lights->lights[picked];
    double solid_angle;
    out->wi = pm_light_draw_distant(world, light, u[1], u[2], &solid_angle);
    out->distance = INFINITY;
    if (out->hidden) {
        out->radiance = pm_lights_shine_far(world, light->distant, out->wi);
        out->pdf = pm_lights_distant_pdf(world, picked, out->wi);
        return;
    }
    struct pm_sky sky = pm_lights_sky(world, out->wi, false);
    out->radiance = sky.lit ? sky.lights : sky.glows;
    out->weak = !sky.lit;
    out->pdf = sky.pdf;
}

bool pm_light_sample_at(const pm_world *world, pm_vec3 point, const double u[3],
                        pm_light_sample *out)
{
    const struct pm_lights *l = world->lights;
    if (!l->count)
        return false;
    uint32_t picked = pick_for_point(l, u[0]);
    const struct pm_light *light = &l->lights[picked];
    *out = (pm_light_sample){.surface = light->surface,
                             .weak = pm_lights_is_weak(&world->materials[light->material]),
                             .hidden = world->materials[light->material].type == PM_ILLUM};
    if (light->surface == PM_NO_PRIMITIVE)
        sample_distant(world, picked, u, out);
    else if (!sample_surface(world, light, point, u, out))
        return false;
    else
        out->pdf *= pm_lights_chance(l, picked);
    return !pm_rgb_is_black(out->radiance);
}

double pm_light_pdf_surface(const pm_world *world, pm_vec3 point, pm_vec3 wi, const pm_hit *hit)
{
    uint32_t light = pm_lights_of_surface(world, hit->surface);
    double cosine = -pm_vec3_dot(wi, hit->normal);
    if (light == PM_NO_LIGHT || !(cosine > 0) ||
        world->materials[hit->material].type == PM_ILLUM)
        return 0;
    const struct pm_shape *shape = &world->shapes[hit->surface];
    double chance = pm_lights_chance(world->lights, light);
    pm_vec3 way = pm_vec3_sub(hit->point, point);
    if (shape->type != PM_SPHERE)
        return chance * pm_vec3_dot(way, way) / (shape->area * cosine);
    double versine = sphere_versine(shape, point, &way);
    return versine > 0 ? chance / (2 * PM_PI * versine) : 0;
}
