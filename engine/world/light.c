#include "world/light.h"

#include <math.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/cap.h"
#include "world/lights.h"

static const struct pm_material *material_of(const pm_world *world,
                                             const struct pm_light *light)
{
    return &world->materials[light->material];
}

/* ---- power ---- */

/* Mean over a cone's or cylinder's azimuth of a spotlight's projected solid angle. Equal
 * steps suit a periodic integrand; for the narrowest beams it has kinks, which leave 2e-6. */
static double mean_around(const struct pm_shape *shape, const struct pm_material *spot)
{
    enum { STEPS = 1024 };
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

static pm_rgb power_of(const pm_world *world, const struct pm_light *light)
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
        l->cumulative[i] = i + 1 < l->count ? fmin(sum, 1) : 1;
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
        l->of_surface[i] = is_light(world, material) ? n : PM_NO_LIGHT;
        if (is_light(world, material))
            l->lights[n++] = (struct pm_light){i, PM_NO_LIGHT, material, 0};
    }
    for (uint32_t i = 0; i < world->distant_count; i++) {
        uint32_t material = world->distants[i].material;
        l->of_distant[i] = is_light(world, material) ? n : PM_NO_LIGHT;
        if (is_light(world, material))
            l->lights[n++] = (struct pm_light){PM_NO_PRIMITIVE, i, material, 0};
    }
}

static void set_bounding_sphere(const pm_world *world, struct pm_lights *l)
{
    if (!world->shape_count)
        return;
    pm_vec3 low = pm_world_from_scene(world, world->low);
    pm_vec3 high = pm_world_from_scene(world, world->high);
    l->center = pm_vec3_scale(pm_vec3_add(low, high), .5);
    l->radius = pm_vec3_distance(low, high) / 2;
}

pm_status pm_lights_build(pm_world *world, pm_error *err)
{
    struct pm_lights *l = pm_arena_alloc(&world->arena, sizeof *l);
    if (!l || !allocate(world, l))
        return pm_error_set(err, PM_E_MEMORY, "out of memory for the lights");
    pm_status status = pm_sky_index_build(world, &l->sky, err);
    if (status)
        return status;
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

/* ---- picking a light ---- */

uint32_t pm_lights_pick(const struct pm_lights *l, double u)
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

double pm_lights_chance(const struct pm_lights *l, uint32_t light)
{
    return .5 * l->lights[light].chance + .5 / (double)l->count;
}

/* ---- what a light shows ---- */

static bool in_beam(const struct pm_material *spot, pm_vec3 direction)
{
    pm_vec3 off = pm_vec3_sub(direction, spot->aim); /* |off|^2 = 2 (1 - cos) */
    return pm_vec3_dot(off, off) <= 2 * spot->versine;
}

double pm_lights_focus_share(double focus, double distance)
{
    if (!(focus > 0) || distance == INFINITY)
        return 1;
    double share = distance / (distance + focus);
    return share * share;
}

pm_rgb pm_lights_radiance(const struct pm_material *m, pm_vec3 direction, double distance)
{
    if (m->type != PM_SPOTLIGHT)
        return m->color;
    if (!in_beam(m, direction))
        return pm_rgb_grey(0);
    return pm_rgb_scale(m->color, pm_lights_focus_share(m->focus, distance));
}

bool pm_lights_is_weak(const struct pm_material *m)
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
    return pm_lights_radiance(m, wo, hit->t);
}

pm_rgb pm_light_seen_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo)
{
    const struct pm_material *m = &world->materials[hit->material];
    bool shines = m->type == PM_LIGHT || m->type == PM_SPOTLIGHT || m->type == PM_GLOW;
    if (!shines || pm_vec3_dot(wo, hit->normal) < 0)
        return pm_rgb_grey(0);
    return pm_lights_radiance(m, wo, INFINITY);
}

/* ---- distant sources ---- */

double pm_lights_distant_pdf(const pm_world *world, uint32_t light)
{
    const struct pm_distant *source = &world->distants[world->lights->lights[light].distant];
    return pm_lights_chance(world->lights, light) / (2 * PM_PI * source->versine);
}

struct gathering {
    const pm_world *world;
    struct pm_sky sky;
};

static void gather_source(void *context, uint32_t source)
{
    struct gathering *g = context;
    const struct pm_material *m = &g->world->materials[g->world->distants[source].material];
    uint32_t light = g->world->lights->of_distant[source];
    if (m->type == PM_ILLUM)
        return;
    if (light != PM_NO_LIGHT)
        g->sky.pdf += pm_lights_distant_pdf(g->world, light);
    if (m->type == PM_LIGHT) {
        g->sky.lights = pm_rgb_add(g->sky.lights, m->color);
        g->sky.lit = true;
    } else if (m->type == PM_GLOW && light != PM_NO_LIGHT) {
        g->sky.glows = pm_rgb_add(g->sky.glows, m->color);
    } else if (m->type == PM_GLOW) {
        g->sky.seen_glows = pm_rgb_add(g->sky.seen_glows, m->color);
    }
}

struct pm_sky pm_lights_sky(const pm_world *world, pm_vec3 direction)
{
    struct gathering g = {.world = world};
    pm_sky_index_visit(world->lights->sky, world, direction, gather_source, &g);
    return g.sky;
}

pm_rgb pm_light_distant(const pm_world *world, pm_vec3 direction, double *pdf)
{
    struct pm_sky sky = pm_lights_sky(world, direction);
    *pdf = sky.pdf;
    return sky.lit ? sky.lights : sky.glows;
}

pm_rgb pm_light_seen_distant(const pm_world *world, pm_vec3 direction)
{
    struct pm_sky sky = pm_lights_sky(world, direction);
    return sky.lit ? sky.lights : pm_rgb_add(sky.glows, sky.seen_glows);
}
