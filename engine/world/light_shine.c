#include <math.h>

#include "base/maths.h"
#include "world/light.h"
#include "world/lights.h"
#include "world/shading.h"

/* ---- lamps ---- */

static bool in_beam(const struct pm_material *spot, pm_vec3 direction)
{
    pm_vec3 off = pm_vec3_sub(direction, spot->aim); /* |off|^2 = 2 (1 - cos) */
    return pm_vec3_dot(off, off) <= 2 * spot->versine;
}

bool pm_lights_is_patterned(const struct pm_material *lamp)
{
    return lamp->textures;
}

pm_rgb pm_lights_shine(const pm_world *world, const pm_hit *hit, pm_vec3 wo)
{
    const struct pm_material *m = &world->materials[hit->material];
    if (m->type == PM_SPOTLIGHT && !in_beam(m, wo))
        return pm_rgb_grey(0);
    if (!m->textures)
        return m->color;
    struct pm_shading shading;
    pm_shading_init(&shading, world, hit, wo, hit->t);
    pm_textures_apply(m, &shading);
    return pm_shading_radiance(&shading, m->color);
}

double pm_lights_focus_share(double focus, double distance)
{
    if (!(focus > 0) || distance == INFINITY)
        return 1;
    double share = distance / (distance + focus);
    return share * share;
}

bool pm_lights_is_weak(const struct pm_material *m)
{
    return m->type == PM_GLOW || m->type == PM_ILLUM;
}

uint32_t pm_lights_of_surface(const pm_world *world, uint32_t surface)
{
    return surface < world->shape_count ? world->lights->of_surface[surface] : PM_NO_LIGHT;
}

bool pm_light_stands_in(const pm_world *world, const pm_hit *hit, pm_vec3 direction)
{
    const struct pm_material *m = &world->materials[hit->material];
    return m->type == PM_ILLUM && pm_vec3_dot(direction, hit->normal) > 0;
}

pm_rgb pm_light_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo)
{
    const struct pm_material *m = &world->materials[hit->material];
    if (m->type == PM_ILLUM || pm_vec3_dot(wo, hit->normal) < 0 ||
        pm_lights_of_surface(world, hit->surface) == PM_NO_LIGHT)
        return pm_rgb_grey(0);
    pm_rgb radiance = pm_lights_shine(world, hit, wo);
    return pm_rgb_scale(radiance, pm_lights_focus_share(m->focus, hit->t));
}

static pm_rgb shown_by(const pm_world *world, const pm_hit *hit, pm_vec3 wo, uint32_t material,
                       const struct pm_shading *above);

static pm_rgb shown_by_mixture(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                               const struct pm_material *mixture, struct pm_shading *shading)
{
    double share;
    if (!pm_mixture_share(mixture, shading, &share))
        return pm_rgb_grey(0);
    pm_rgb sum = {0, 0, 0};
    if (share > 0)
        sum = pm_rgb_scale(shown_by(world, hit, wo, mixture->components[0], shading), share);
    if (share < 1)
        sum = pm_rgb_madd(sum, 1 - share,
                          shown_by(world, hit, wo, mixture->components[1], shading));
    return sum;
}

/* Through illums and into mixtures, as Radiance's rayshade goes. `above`: what the modifiers of
 * a mixture left, or NULL. Recursion is bounded by PM_MODIFIERS_MAX. */
static pm_rgb shown_by(const pm_world *world, const pm_hit *hit, pm_vec3 wo, uint32_t material,
                       const struct pm_shading *above)
{
    if (material == PM_NO_PRIMITIVE || !world->lights->shows[material])
        return pm_rgb_grey(0);
    const struct pm_material *m = &world->materials[material];
    if (m->type == PM_ILLUM)
        return shown_by(world, hit, wo, m->alternate, above);
    if (m->type == PM_SPOTLIGHT && !in_beam(m, wo))
        return pm_rgb_grey(0);
    struct pm_shading shading;
    if (above)
        shading = *above;
    else
        pm_shading_init(&shading, world, hit, wo, hit->t);
    pm_textures_apply(m, &shading);
    if (pm_primitive_is_mixture(m->type))
        return shown_by_mixture(world, hit, wo, m, &shading);
    return pm_shading_radiance(&shading, m->color);
}

pm_rgb pm_light_seen_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo)
{
    if (!world->lights->shows[hit->material] || pm_vec3_dot(wo, hit->normal) < 0)
        return pm_rgb_grey(0);
    const struct pm_material *m = &world->materials[hit->material];
    if (m->type == PM_ILLUM || pm_primitive_is_mixture(m->type))
        return shown_by(world, hit, wo, hit->material, NULL);
    return pm_lights_shine(world, hit, wo);
}

/* ---- distant sources ---- */

pm_rgb pm_lights_shine_far(const pm_world *world, uint32_t distant, pm_vec3 direction)
{
    const struct pm_material *m = &world->materials[world->distants[distant].material];
    if (!m->textures)
        return m->color;
    pm_hit hit;
    struct pm_shading shading;
    pm_shading_init_far(&shading, world, &hit, pm_vec3_negate(direction));
    pm_textures_apply(m, &shading);
    return pm_shading_radiance(&shading, m->color);
}

double pm_lights_distant_pdf(const pm_world *world, uint32_t light, pm_vec3 direction)
{
    const struct pm_light *l = &world->lights->lights[light];
    double chance = pm_lights_chance(world->lights, light);
    if (l->pattern && l->pattern->beam.table)
        return chance * pm_light_beam_pdf(&l->pattern->beam, direction);
    return chance / (2 * PM_PI * world->distants[l->distant].versine);
}

struct gathering {
    const pm_world *world;
    pm_vec3 direction;
    bool seen;
    struct pm_sky sky;
};

static void add_shine(const struct gathering *g, uint32_t source, pm_rgb *sum)
{
    *sum = pm_rgb_add(*sum, pm_lights_shine_far(g->world, source, g->direction));
}

static void gather_source(void *context, uint32_t source)
{
    struct gathering *g = context;
    const struct pm_material *m = &g->world->materials[g->world->distants[source].material];
    uint32_t light = g->world->lights->of_distant[source];
    if (m->type == PM_ILLUM)
        return;
    if (light != PM_NO_LIGHT)
        g->sky.pdf += pm_lights_distant_pdf(g->world, light, g->direction);
    if (m->type == PM_LIGHT) {
        add_shine(g, source, &g->sky.lights);
        g->sky.lit = true;
    } else if (m->type == PM_GLOW && light != PM_NO_LIGHT) {
        add_shine(g, source, &g->sky.glows);
    } else if (m->type == PM_GLOW && g->seen) {
        add_shine(g, source, &g->sky.seen_glows);
    }
}

struct pm_sky pm_lights_sky(const pm_world *world, pm_vec3 direction, bool seen)
{
    struct gathering g = {.world = world, .direction = direction, .seen = seen};
    pm_sky_index_visit(world->lights->sky, world, direction, gather_source, &g);
    return g.sky;
}

static void gather_lit(void *context, uint32_t source)
{
    struct gathering *g = context;
    if (g->world->materials[g->world->distants[source].material].type == PM_LIGHT)
        g->sky.lit = true;
}

bool pm_lights_is_lit(const pm_world *world, pm_vec3 direction)
{
    struct gathering g = {.world = world};
    pm_sky_index_visit(world->lights->sky, world, direction, gather_lit, &g);
    return g.sky.lit;
}

pm_rgb pm_light_distant(const pm_world *world, pm_vec3 direction, double *pdf)
{
    struct pm_sky sky = pm_lights_sky(world, direction, false);
    *pdf = sky.pdf;
    return sky.lit ? sky.lights : sky.glows;
}

pm_rgb pm_light_seen_distant(const pm_world *world, pm_vec3 direction)
{
    struct pm_sky sky = pm_lights_sky(world, direction, true);
    return sky.lit ? sky.lights : pm_rgb_add(sky.glows, sky.seen_glows);
}
