#include "world/light.h"

#include <math.h>
#include <stdlib.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/cap.h"
#include "world/material.h"

/* Shadow rays end this share of their length before the light, which so never hides itself. */
#define SHORT_OF_LIGHT 0x1p-20

struct light {
    uint32_t surface; /* PM_NO_PRIMITIVE: a distant source */
    uint32_t distant;
    uint32_t material;
    double chance; /* of being picked by power */
};

struct pm_lights {
    size_t count;
    struct light *lights; /* surfaces in the world's order, then distant sources in theirs */
    double *cumulative;   /* [count] chances of lights 0..i; the last is 1 */
    uint32_t *of_surface; /* [shape_count]: the light of a surface, or NONE */
    uint32_t *of_distant; /* [distant_count] likewise */
    pm_rgb power;         /* of all */
    pm_vec3 center;       /* of the scene's bounding sphere */
    double radius;
};

enum { NONE = UINT32_MAX };

static const struct pm_material *material_of(const pm_world *world, const struct light *light)
{
    return &world->materials[light->material];
}

/* ---- power ---- */

/* Mean over a cone's or cylinder's azimuth of a spotlight's projected solid angle. The
 * integrand is smooth and periodic, so that equal steps converge fast. */
static double mean_around(const struct pm_shape *shape, const struct pm_material *spot)
{
    enum { STEPS = 256 };
    double slope = (shape->r0 - shape->r1) / shape->height;
    double side = shape->inward ? -1 : 1, sum = 0;
    pm_frame frame = pm_frame_make(shape->axis);
    for (int i = 0; i < STEPS; i++) {
        double sine, cosine;
        pm_sincos(2 * PM_PI * (i + .5) / STEPS, &sine, &cosine);
        pm_vec3 n = pm_vec3_normalize((pm_vec3){cosine, sine, slope});
        n = pm_frame_to_world(&frame, n);
        sum += pm_cap_projected(spot->versine, side * pm_vec3_dot(n, spot->aim));
    }
    return sum / STEPS;
}

/* Mean over the surface of the projected solid angle into which each of its points shines. */
static double projected_solid_angle(const struct pm_shape *shape, const struct pm_material *m)
{
    if (m->type != PM_SPOTLIGHT)
        return PM_PI;
    if (pm_shape_is_planar(shape))
        return pm_cap_projected(m->versine, pm_vec3_dot(shape->axis, m->aim));
    if (shape->type == PM_SPHERE || shape->type == PM_BUBBLE)
        return PM_PI * m->versine / 2; /* a direction sees pi r^2 of 4 pi r^2 */
    return mean_around(shape, m);
}

static pm_rgb power_of(const pm_world *world, const struct light *light)
{
    const struct pm_material *m = material_of(world, light);
    if (light->surface != PM_NO_PRIMITIVE) {
        const struct pm_shape *shape = &world->shapes[light->surface];
        return pm_rgb_scale(m->color, shape->area * projected_solid_angle(shape, m));
    }
    double radius = world->lights->radius;
    return pm_rgb_scale(m->color, 2 * PM_PI * world->distants[light->distant].versine * PM_PI *
                                      radius * radius);
}

static void set_chances(pm_world *world)
{
    struct pm_lights *l = world->lights;
    double total = 0, sum = 0;
    for (size_t i = 0; i < l->count; i++) {
        pm_rgb power = power_of(world, &l->lights[i]);
        l->lights[i].chance = pm_rgb_mean(power);
        l->power = pm_rgb_add(l->power, power);
        total += l->lights[i].chance;
    }
    for (size_t i = 0; i < l->count; i++) { /* evenly if nothing stands in a distant light */
        sum += total > 0 ? l->lights[i].chance / total : 1 / (double)l->count;
        l->cumulative[i] = i + 1 < l->count ? sum : 1;
        l->lights[i].chance = l->cumulative[i] - (i ? l->cumulative[i - 1] : 0);
    }
}

/* ---- the table ---- */

static bool is_light(const pm_world *world, uint32_t material)
{
    return pm_material_emits(&world->materials[material]);
}

static size_t count_lights(const pm_world *world)
{
    size_t count = 0;
    for (size_t i = 0; i < world->shape_count; i++)
        count += is_light(world, world->shapes[i].material);
    for (size_t i = 0; i < world->distant_count; i++)
        count += is_light(world, world->distants[i].material);
    return count;
}

static bool allocate(pm_world *world, struct pm_lights *l)
{
    l->count = count_lights(world);
    l->lights = pm_arena_array(&world->arena, l->count, sizeof *l->lights);
    l->cumulative = pm_arena_array(&world->arena, l->count, sizeof *l->cumulative);
    l->of_surface = pm_arena_array(&world->arena, world->shape_count, sizeof *l->of_surface);
    l->of_distant = pm_arena_array(&world->arena, world->distant_count, sizeof *l->of_distant);
    return l->lights && l->cumulative && l->of_surface && l->of_distant;
}

static void fill(const pm_world *world, struct pm_lights *l)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < world->shape_count; i++) {
        uint32_t material = world->shapes[i].material;
        l->of_surface[i] = is_light(world, material) ? n : NONE;
        if (is_light(world, material))
            l->lights[n++] = (struct light){i, NONE, material, 0};
    }
    for (uint32_t i = 0; i < world->distant_count; i++) {
        uint32_t material = world->distants[i].material;
        l->of_distant[i] = is_light(world, material) ? n : NONE;
        if (is_light(world, material))
            l->lights[n++] = (struct light){PM_NO_PRIMITIVE, i, material, 0};
    }
}

static void set_bounding_sphere(const pm_world *world, struct pm_lights *l)
{
    if (!world->shape_count)
        return;
    pm_vec3 middle = pm_vec3_scale(pm_vec3_add(world->low, world->high), .5);
    l->center = pm_vec3_scale(pm_vec3_sub(middle, world->center), 1 / world->scale);
    l->radius = pm_vec3_distance(world->low, world->high) / (2 * world->scale);
}

pm_status pm_lights_build(pm_world *world, pm_error *err)
{
    struct pm_lights *l = pm_arena_alloc(&world->arena, sizeof *l);
    if (!l || !allocate(world, l))
        return pm_error_set(err, PM_E_MEMORY, "out of memory for the lights");
    fill(world, l);
    set_bounding_sphere(world, l);
    world->lights = l;
    set_chances(world);
    return PM_OK;
}

size_t pm_lights_count(const pm_world *world)
{
    return world->lights->count;
}

pm_rgb pm_light_total_power(const pm_world *world)
{
    return world->lights->power;
}

bool pm_light_is_sampled(const pm_world *world, uint32_t surface)
{
    return surface == PM_NO_PRIMITIVE || world->lights->of_surface[surface] != NONE;
}

/* ---- picking a light ---- */

static uint32_t pick_by_power(const struct pm_lights *l, double u)
{
    size_t low = 0, high = l->count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (l->cumulative[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    return (uint32_t)low;
}

/* For next events half by power and half evenly, so that beside the sun a lamp is found too. */
static uint32_t pick_for_point(const struct pm_lights *l, double u)
{
    if (u < .5)
        return pick_by_power(l, 2 * u);
    return (uint32_t)((2 * u - 1) * (double)l->count);
}

static double chance_for_point(const struct pm_lights *l, uint32_t light)
{
    return .5 * l->lights[light].chance + .5 / (double)l->count;
}

/* ---- what a light shows ---- */

static bool in_beam(const struct pm_material *spot, pm_vec3 direction)
{
    pm_vec3 off = pm_vec3_sub(direction, spot->aim); /* |off|^2 = 2 (1 - cos) */
    return pm_vec3_dot(off, off) <= 2 * spot->versine;
}

static double focus_share(double focus, double distance)
{
    if (!(focus > 0) || distance == INFINITY)
        return 1;
    double share = distance / (distance + focus);
    return share * share;
}

double pm_emission_share(const pm_emission *emission, double distance)
{
    return focus_share(emission->focus, distance);
}

/* Of a lamp's front towards `direction`, into a point at that distance. */
static pm_rgb radiance_of(const struct pm_material *m, pm_vec3 direction, double distance)
{
    if (m->type != PM_SPOTLIGHT)
        return m->color;
    if (!in_beam(m, direction))
        return pm_rgb_grey(0);
    return pm_rgb_scale(m->color, focus_share(m->focus, distance));
}

static bool is_weak(const struct pm_material *m)
{
    return m->type == PM_GLOW || m->type == PM_ILLUM;
}

bool pm_light_stands_in(const pm_world *world, const pm_hit *hit, pm_vec3 direction)
{
    const struct pm_material *m = &world->materials[hit->material];
    return m->type == PM_ILLUM && pm_vec3_dot(direction, hit->normal) > 0;
}

pm_rgb pm_light_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo)
{
    const struct pm_material *m = &world->materials[hit->material];
    if (m->type == PM_ILLUM || !pm_material_emits(m) || pm_vec3_dot(wo, hit->normal) < 0)
        return pm_rgb_grey(0);
    return radiance_of(m, wo, hit->t);
}

pm_rgb pm_light_seen_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo)
{
    const struct pm_material *m = &world->materials[hit->material];
    bool shines = m->type == PM_LIGHT || m->type == PM_SPOTLIGHT || m->type == PM_GLOW;
    if (!shines || pm_vec3_dot(wo, hit->normal) < 0)
        return pm_rgb_grey(0);
    return radiance_of(m, wo, INFINITY);
}

/* ---- distant sources ---- */

static bool covers(const struct pm_distant *source, pm_vec3 direction)
{
    pm_vec3 off = pm_vec3_sub(direction, source->direction);
    return pm_vec3_dot(off, off) <= 2 * source->versine;
}

static double pdf_of_source(const pm_world *world, uint32_t light)
{
    const struct pm_distant *source = &world->distants[world->lights->lights[light].distant];
    return chance_for_point(world->lights, light) / (2 * PM_PI * source->versine);
}

/* What the distant sources show in a direction, illums apart. */
struct sky {
    pm_rgb lights, glows, seen_glows; /* seen: of negative radius */
    bool lit;                         /* a light is there, and hides the glows */
    double pdf;
};

static struct sky sky_at(const pm_world *world, pm_vec3 direction)
{
    struct sky sky = {.pdf = 0};
    for (uint32_t i = 0; i < world->distant_count; i++) {
        const struct pm_material *m = &world->materials[world->distants[i].material];
        uint32_t light = world->lights->of_distant[i];
        if (m->type == PM_ILLUM || !covers(&world->distants[i], direction))
            continue;
        if (light != NONE)
            sky.pdf += pdf_of_source(world, light);
        if (m->type == PM_GLOW && light == NONE)
            sky.seen_glows = pm_rgb_add(sky.seen_glows, m->color);
        else if (m->type == PM_GLOW)
            sky.glows = pm_rgb_add(sky.glows, m->color);
        else if (m->type == PM_LIGHT)
            sky.lights = pm_rgb_add(sky.lights, m->color);
        sky.lit = sky.lit || m->type == PM_LIGHT;
    }
    return sky;
}

pm_rgb pm_light_distant(const pm_world *world, pm_vec3 direction, double *pdf)
{
    struct sky sky = sky_at(world, direction);
    *pdf = sky.pdf;
    return sky.lit ? sky.lights : sky.glows;
}

pm_rgb pm_light_seen_distant(const pm_world *world, pm_vec3 direction)
{
    struct sky sky = sky_at(world, direction);
    return sky.lit ? sky.lights : pm_rgb_add(sky.glows, sky.seen_glows);
}

/* ---- emission ---- */

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

static pm_vec3 lamp_direction(const struct pm_material *m, pm_vec3 normal, double u, double v,
                              double *weight)
{
    if (m->type == PM_SPOTLIGHT)
        return beam_direction(m, normal, u, v, weight);
    pm_frame frame = pm_frame_make(normal);
    *weight = PM_PI;
    return pm_frame_to_world(&frame, pm_warp_cosine(u, v));
}

static void emit_from_surface(const pm_world *world, const struct light *light,
                              const double u[5], pm_emission *out)
{
    const struct pm_material *m = material_of(world, light);
    const struct pm_shape *shape = &world->shapes[light->surface];
    pm_vec3 normal;
    double weight;
    pm_shape_sample(shape, u[1], u[2], &out->origin, &normal);
    out->direction = lamp_direction(m, normal, u[3], u[4], &weight);
    out->from = light->surface;
    out->focus = m->type == PM_SPOTLIGHT ? m->focus : 0;
    out->flux = pm_rgb_scale(m->color, shape->area * weight / light->chance);
}

static void emit_from_distance(const pm_world *world, const struct light *light,
                               const double u[5], pm_emission *out)
{
    const struct pm_lights *l = world->lights;
    const struct pm_material *m = material_of(world, light);
    const struct pm_distant *source = &world->distants[light->distant];
    pm_frame about_source = pm_frame_make(source->direction);
    pm_vec3 up = pm_frame_to_world(&about_source, pm_warp_cone(u[3], u[4], source->versine));
    pm_frame about_ray = pm_frame_make(up);
    pm_vec3 place = pm_vec3_scale(pm_warp_disc(u[1], u[2]), l->radius);
    place.z = l->radius * (1 + 0x1p-10); /* beyond every surface */
    out->origin = pm_vec3_add(l->center, pm_frame_to_world(&about_ray, place));
    out->direction = pm_vec3_negate(up);
    out->from = PM_NO_PRIMITIVE;
    out->focus = 0;
    double solid_angle = 2 * PM_PI * source->versine, area = PM_PI * l->radius * l->radius;
    out->flux = pm_rgb_scale(m->color, solid_angle * area / light->chance);
    if (m->type == PM_GLOW && sky_at(world, up).lit)
        out->flux = pm_rgb_grey(0);
}

bool pm_light_emit(const pm_world *world, const double u[5], pm_emission *out)
{
    const struct pm_lights *l = world->lights;
    if (pm_rgb_is_black(l->power))
        return false;
    const struct light *light = &l->lights[pick_by_power(l, u[0])];
    if (light->surface == PM_NO_PRIMITIVE)
        emit_from_distance(world, light, u, out);
    else
        emit_from_surface(world, light, u, out);
    out->weak = is_weak(material_of(world, light));
    return true;
}

/* ---- next events ---- */

/* The cone that a sphere fills seen from outside: its versine, 0 from inside. */
static double sphere_versine(const struct pm_shape *sphere, pm_vec3 point, pm_vec3 *to_center)
{
    *to_center = pm_vec3_sub(sphere->center, point);
    double square = sphere->r0 * sphere->r0 / pm_vec3_dot(*to_center, *to_center);
    return square < 1 ? square / (1 + sqrt(1 - square)) : 0;
}

static bool sample_sphere(const struct pm_shape *sphere, pm_vec3 point, const double u[3],
                          pm_light_sample *out)
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
    return out->distance > 0;
}

static bool sample_area(const struct pm_shape *shape, pm_vec3 point, const double u[3],
                        pm_light_sample *out)
{
    pm_vec3 place, normal;
    pm_shape_sample(shape, u[1], u[2], &place, &normal);
    pm_vec3 way = pm_vec3_sub(place, point);
    out->distance = pm_vec3_length(way);
    if (!(out->distance > 0))
        return false;
    out->wi = pm_vec3_scale(way, 1 / out->distance);
    double cosine = -pm_vec3_dot(out->wi, normal);
    out->pdf = out->distance * out->distance / (shape->area * cosine);
    return cosine > 0;
}

static bool sample_surface(const pm_world *world, const struct light *light, pm_vec3 point,
                           const double u[3], pm_light_sample *out)
{
    const struct pm_shape *shape = &world->shapes[light->surface];
    bool found = shape->type == PM_SPHERE ? sample_sphere(shape, point, u, out)
                                          : sample_area(shape, point, u, out);
    if (!found)
        return false;
    out->radiance =
        radiance_of(material_of(world, light), pm_vec3_negate(out->wi), out->distance);
    out->distance *= 1 - SHORT_OF_LIGHT;
    return true;
}

/* A direction that a distant source covers; but for an illum every other source there counts
 * too, with the density of all. */
static void sample_distant(const pm_world *world, uint32_t picked, const double u[3],
                           pm_light_sample *out)
{
    const struct light *light = &world->lights->lights[picked];
    const struct pm_distant *source = &world->distants[light->distant];
    pm_frame frame = pm_frame_make(source->direction);
    out->wi = pm_frame_to_world(&frame, pm_warp_cone(u[1], u[2], source->versine));
    out->distance = INFINITY;
    out->radiance = material_of(world, light)->color;
    out->pdf = pdf_of_source(world, picked);
    if (out->hidden)
        return;
    struct sky sky = sky_at(world, out->wi);
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
    const struct light *light = &l->lights[picked];
    *out = (pm_light_sample){.surface = light->surface,
                             .weak = is_weak(material_of(world, light)),
                             .hidden = material_of(world, light)->type == PM_ILLUM};
    if (light->surface == PM_NO_PRIMITIVE)
        sample_distant(world, picked, u, out);
    else if (!sample_surface(world, light, point, u, out))
        return false;
    else
        out->pdf *= chance_for_point(l, picked);
    return !pm_rgb_is_black(out->radiance);
}

double pm_light_pdf_surface(const pm_world *world, pm_vec3 point, pm_vec3 wi, const pm_hit *hit)
{
    uint32_t light = world->lights->of_surface[hit->surface];
    double cosine = -pm_vec3_dot(wi, hit->normal);
    if (light == NONE || !(cosine > 0) || world->materials[hit->material].type == PM_ILLUM)
        return 0;
    const struct pm_shape *shape = &world->shapes[hit->surface];
    double chance = chance_for_point(world->lights, light);
    pm_vec3 way = pm_vec3_sub(hit->point, point);
    if (shape->type != PM_SPHERE)
        return chance * pm_vec3_dot(way, way) / (shape->area * cosine);
    double versine = sphere_versine(shape, point, &way);
    return versine > 0 ? chance / (2 * PM_PI * versine) : 0;
}
