#include "world/light.h"

#include <math.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/body.h"
#include "world/cap.h"
#include "world/lights.h"

/* Of all patterns together, about. */
#define EVALUATIONS ((size_t)1 << 22)

/* Of the chances, for patterned lights together. */
#define LEAST_SHARE 0x1p-10

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

static pm_rgb plain_power(const pm_world *world, const struct pm_light *light)
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

/* Sets each light's chance to its mean power, and sums power. */
static pm_status measure(pm_world *world, pm_error *err)
{
    struct pm_lights *l = world->lights;
    for (size_t i = 0; i < l->count; i++)
        l->patterned += pm_lights_is_patterned(material_of(world, &l->lights[i]));
    for (size_t i = 0; i < l->count; i++) {
        struct pm_light *light = &l->lights[i];
        pm_rgb power = plain_power(world, light);
        pm_status status = PM_OK;
        if (pm_lights_is_patterned(material_of(world, light)))
            status =
                pm_light_pattern_build(world, light, EVALUATIONS / l->patterned, &power, err);
        if (status)
            return status;
        light->chance = pm_rgb_mean(power);
        l->power = pm_rgb_add(l->power, power);
    }
    return PM_OK;
}

/* Quadrature may miss what a pattern shows: none is left without a chance. */
static void add_least_chance(struct pm_lights *l, double total)
{
    double least = total * LEAST_SHARE / (double)l->patterned;
    for (size_t i = 0; i < l->count; i++)
        if (l->lights[i].pattern && l->lights[i].chance < least)
            l->lights[i].chance = least;
}

static double total_chance(const struct pm_lights *l)
{
    double total = 0;
    for (size_t i = 0; i < l->count; i++)
        total += l->lights[i].chance;
    return total;
}

static void set_chances(struct pm_lights *l)
{
    double total = total_chance(l), sum = 0;
    if (l->patterned) {
        add_least_chance(l, total);
        total = total_chance(l);
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
    l->shows = pm_arena_array(&world->arena, world->material_count, sizeof *l->shows);
    return l->lights && l->cumulative && l->of_surface && l->of_distant && l->shows;
}

static bool shows_light(const struct pm_lights *l, const struct pm_material *m)
{
    if (m->type == PM_LIGHT || m->type == PM_SPOTLIGHT || m->type == PM_GLOW)
        return true;
    const uint32_t through[] = {m->type == PM_ILLUM ? m->alternate : PM_NO_PRIMITIVE,
                                m->components[0], m->components[1]};
    for (int i = 0; i < 3; i++)
        if (through[i] != PM_NO_PRIMITIVE && l->shows[through[i]])
            return true;
    return false;
}

/* One round for each link of the longest chain. */
static void find_shows(const pm_world *world, struct pm_lights *l)
{
    for (bool changed = true; changed;) {
        changed = false;
        for (size_t i = 0; i < world->material_count; i++)
            if (!l->shows[i] && shows_light(l, &world->materials[i]))
                changed = l->shows[i] = true;
    }
}

static void fill(const pm_world *world, struct pm_lights *l)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < world->shape_count; i++) {
        uint32_t material = world->shapes[i].material;
        l->of_surface[i] = is_light(world, material) ? n : PM_NO_LIGHT;
        if (is_light(world, material))
            l->lights[n++] = (struct pm_light){i, PM_NO_LIGHT, material, 0, NULL};
    }
    for (uint32_t i = 0; i < world->distant_count; i++) {
        uint32_t material = world->distants[i].material;
        l->of_distant[i] = is_light(world, material) ? n : PM_NO_LIGHT;
        if (is_light(world, material))
            l->lights[n++] = (struct pm_light){PM_NO_PRIMITIVE, i, material, 0, NULL};
    }
}

static void set_bounding_sphere(const pm_world *world, struct pm_lights *l)
{
    if (!world->main->count)
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
    find_shows(world, l);
    set_bounding_sphere(world, l);
    world->lights = l;
    status = measure(world, err);
    if (!status)
        set_chances(l);
    return status;
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

uint32_t pm_lights_search(const double *cumulative, size_t count, double u)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (cumulative[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    return (uint32_t)low;
}

uint32_t pm_lights_pick(const struct pm_lights *l, double u)
{
    return pm_lights_search(l->cumulative, l->count, u);
}

double pm_lights_chance(const struct pm_lights *l, uint32_t light)
{
    return .5 * l->lights[light].chance + .5 / (double)l->count;
}
