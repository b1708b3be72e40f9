#include "world/light_aim.h"

#include <math.h>
#include <stdlib.h>

#include "base/maths.h"
#include "base/sobol.h"
#include "world/lights.h"

/* Places of a lamp that are looked at to know how much of its light goes to the targets; and of
 * all lamps together, about. */
enum { PLACES = 16, ALL_PLACES = 1 << 14 };

/* A lamp that sends more of its light to the targets need not be aimed. */
#define MOST .25

struct pm_light_aim {
    const pm_world *world;
    const pm_targets *targets;
    double unaimed;               /* share of the photons */
    double share;                 /* of the light that leaves for the targets */
    double *cumulative;           /* [lights] chances of lights 0..i, aimed; the last is 1 */
    double discs[PM_TARGETS_MAX]; /* cumulative chances of targets of distant light */
    double disc_density;          /* of a weight of 1 [1/area] */
    double disc_share;
};

/* ---- lamps ---- */

static bool has_ball_beam(const pm_world *world, const struct pm_light *light)
{
    return light->pattern && light->pattern->beam.table &&
           pm_shape_is_ball(&world->shapes[light->surface]);
}

/* What leaves a place of the lamp, but for patterns. */
static pm_target_lobe lobe_of(const struct pm_material *m, pm_vec3 normal)
{
    if (m->type == PM_SPOTLIGHT)
        return (pm_target_lobe){m->aim, true, m->versine};
    return (pm_target_lobe){normal, false, 1};
}

/* Density [1/sr] of pm_lights_direction; see beam_direction in light_emit.c. */
static double plain_density(const struct pm_material *m, pm_vec3 normal, pm_vec3 direction)
{
    double cosine = fmax(pm_vec3_dot(normal, direction), 0);
    if (m->type != PM_SPOTLIGHT)
        return cosine / PM_PI;
    pm_vec3 from_aim = pm_vec3_sub(direction, m->aim), off = pm_vec3_sub(normal, m->aim);
    if (pm_vec3_dot(from_aim, from_aim) > 2 * m->versine)
        return 0;
    if (pm_vec3_dot(off, off) > 0x1p-80)
        return 1 / (2 * PM_PI * m->versine);
    double square = m->versine < 1 ? m->versine * (2 - m->versine) : 1;
    return cosine / (PM_PI * square);
}

/* Density with which unaimed light takes that direction from a place which was drawn with
 * density 1 / area. */
static double unaimed_density(const pm_world *world, const struct pm_light *light,
                              const pm_hit *hit, pm_vec3 direction, double area)
{
    const struct pm_material *m = &world->materials[light->material];
    if (!light->pattern || !light->pattern->beam.table)
        return plain_density(m, hit->normal, direction);
    const struct pm_light_beam *beam = &light->pattern->beam;
    pm_vec3 off = pm_vec3_sub(direction, beam->frame.z);
    if (pm_vec3_dot(off, off) > 2 * beam->versine)
        return 0;
    double density = pm_light_beam_pdf(beam, direction);
    if (!has_ball_beam(world, light))
        return density;
    double radius = world->shapes[light->surface].r0;
    double cosine = fmax(pm_vec3_dot(hit->normal, direction), 0);
    return density * cosine / (PM_PI * radius * radius) * area;
}

/* Where the targets hold the lamp, light is sent as ever. */
static double aimed_density(const pm_target_view *view, const struct pm_material *m,
                            pm_vec3 normal, pm_vec3 direction)
{
    double sum = view->total + view->around;
    if (!(sum > 0))
        return 0;
    double density = view->total * pm_targets_pdf(view, direction);
    if (view->around > 0)
        density += view->around * plain_density(m, normal, direction);
    return density / sum;
}

static pm_vec3 aim_direction(const pm_target_view *view, const struct pm_material *m,
                             pm_vec3 normal, double u, double v, double *density)
{
    double at = u * (view->total + view->around), weight;
    if (at < view->total) {
        double pdf;
        pm_vec3 direction = pm_targets_sample(view, at / view->total, v, &pdf);
        *density = view->total * pdf;
        if (view->around > 0)
            *density += view->around * plain_density(m, normal, direction);
        *density /= view->total + view->around;
        return direction;
    }
    u = fmin((at - view->total) / view->around, 1 - 0x1p-53);
    pm_vec3 direction = pm_lights_direction(m, normal, u, v, &weight);
    *density = aimed_density(view, m, normal, direction);
    return direction;
}

static double aimed_chance(const pm_light_aim *aim, uint32_t light)
{
    return aim->cumulative[light] - (light ? aim->cumulative[light - 1] : 0);
}

/* Flux from radiance over both densities. */
static void weigh(const pm_light_aim *aim, uint32_t light, double unaimed, double aimed,
                  pm_rgb radiance, pm_emission *out, double *common)
{
    double base = aim->unaimed * aim->world->lights->lights[light].chance * unaimed;
    double both = base + (1 - aim->unaimed) * aimed_chance(aim, light) * aimed;
    bool possible = base > 0; /* else the emission's radiance there is none */
    out->flux = possible ? pm_rgb_scale(radiance, 1 / both) : pm_rgb_grey(0);
    *common = possible ? both / base : 1;
}

static void aim_from_lamp(const pm_light_aim *aim, const double u[5], pm_emission *out,
                          double *common)
{
    const pm_world *world = aim->world;
    const struct pm_light *light = &world->lights->lights[out->light];
    const struct pm_material *m = &world->materials[light->material];
    double area, aimed;
    pm_hit hit = pm_light_draw_place(world, light, u[1], u[2], &area);
    pm_target_view view;
    pm_target_lobe lobe = lobe_of(m, hit.normal);
    pm_targets_look(aim->targets, hit.point, &lobe, &view);
    *out = (pm_emission){.origin = hit.point,
                         .normal = hit.normal,
                         .light = out->light,
                         .from = light->surface,
                         .focus = m->type == PM_SPOTLIGHT ? m->focus : 0};
    *common = 1;
    if (!(view.total + view.around > 0)) {
        out->direction = hit.normal;
        return;
    }
    out->direction = aim_direction(&view, m, hit.normal, u[3], u[4], &aimed);
    double cosine = pm_vec3_dot(hit.normal, out->direction);
    if (!(cosine > 0))
        return;
    double unaimed = unaimed_density(world, light, &hit, out->direction, area);
    pm_rgb radiance = pm_lights_shine(world, &hit, out->direction);
    weigh(aim, out->light, unaimed, aimed, pm_rgb_scale(radiance, cosine * area), out, common);
}

/* An unaimed photon that flies to a target all the same. */
static double weigh_lamp(const pm_light_aim *aim, const pm_emission *e)
{
    const pm_world *world = aim->world;
    const struct pm_light *light = &world->lights->lights[e->light];
    const struct pm_material *m = &world->materials[light->material];
    double chance = aimed_chance(aim, e->light);
    if (!(chance > 0))
        return 0;
    pm_hit hit = {.normal = e->normal};
    pm_target_view view;
    pm_target_lobe lobe = lobe_of(m, e->normal);
    pm_targets_look(aim->targets, e->origin, &lobe, &view);
    double aimed = aimed_density(&view, m, e->normal, e->direction);
    if (!(aimed > 0))
        return 0;
    double area = has_ball_beam(world, light) ? world->shapes[light->surface].area : 1;
    double unaimed = unaimed_density(world, light, &hit, e->direction, area);
    return unaimed > 0 ? chance * aimed / (light->chance * unaimed) : 0;
}

/* ---- distant sources ---- */

/* Density with which distant light that is aimed passes a place, along a direction. */
static double disc_density(const pm_light_aim *aim, pm_vec3 origin, pm_vec3 direction,
                           unsigned chosen)
{
    const pm_targets *targets = aim->targets;
    double sum = 0;
    for (unsigned t = 0; t < targets->count; t++) {
        pm_vec3 way = {targets->x[t] - origin.x, targets->y[t] - origin.y,
                       targets->z[t] - origin.z};
        way = pm_vec3_madd(way, -pm_vec3_dot(way, direction), direction);
        bool in = pm_vec3_dot(way, way) <= targets->radius[t] * targets->radius[t];
        sum += in || t == chosen ? targets->weight[t] : 0;
    }
    return sum * aim->disc_density;
}

/* The place, from outside the scene; false if unaimed light never starts there. */
static bool aim_at_disc(const pm_light_aim *aim, pm_vec3 up, double u, double v,
                        pm_vec3 *origin, unsigned *chosen)
{
    const struct pm_lights *l = aim->world->lights;
    const pm_targets *targets = aim->targets;
    unsigned t = 0;
    while (t + 1 < targets->count && !(u < aim->discs[t]))
        t++;
    double before = t ? aim->discs[t - 1] : 0;
    double place = fmax(0, fmin((u - before) / (aim->discs[t] - before), 1 - 0x1p-53));
    pm_frame frame = pm_frame_make(up);
    pm_vec3 on_disc = pm_vec3_scale(pm_warp_disc(place, v), targets->radius[t]);
    pm_vec3 p = {targets->x[t], targets->y[t], targets->z[t]};
    p = pm_vec3_sub(pm_vec3_add(p, pm_frame_to_world(&frame, on_disc)), l->center);
    p = pm_vec3_madd(p, -pm_vec3_dot(p, up), up);
    *chosen = t;
    *origin = pm_vec3_madd(pm_vec3_add(l->center, p), pm_lights_height(l), up);
    return pm_vec3_dot(p, p) <= l->radius * l->radius;
}

static void aim_from_distance(const pm_light_aim *aim, const double u[5], pm_emission *out,
                              double *common)
{
    const pm_world *world = aim->world;
    const struct pm_lights *l = world->lights;
    const struct pm_light *light = &l->lights[out->light];
    double solid_angle;
    unsigned chosen;
    pm_vec3 origin, up = pm_light_draw_distant(world, light, u[3], u[4], &solid_angle);
    bool possible = aim_at_disc(aim, up, u[1], u[2], &origin, &chosen);
    pm_vec3 down = pm_vec3_negate(up);
    *out = (pm_emission){.origin = origin,
                         .direction = down,
                         .normal = down,
                         .light = out->light,
                         .from = PM_NO_PRIMITIVE};
    *common = 1;
    bool hidden =
        world->materials[light->material].type == PM_GLOW && pm_lights_is_lit(world, up);
    if (!possible || hidden)
        return;
    pm_rgb radiance = pm_lights_shine_far(world, light->distant, up);
    weigh(aim, out->light, 1 / (PM_PI * l->radius * l->radius),
          disc_density(aim, origin, down, chosen), pm_rgb_scale(radiance, solid_angle), out,
          common);
}

static double weigh_distant(const pm_light_aim *aim, const pm_emission *e)
{
    const struct pm_lights *l = aim->world->lights;
    double chance = aimed_chance(aim, e->light);
    if (!(chance > 0))
        return 0;
    double aimed = disc_density(aim, e->origin, e->direction, PM_TARGETS_MAX);
    return chance * aimed * PM_PI * l->radius * l->radius / l->lights[e->light].chance;
}

/* ---- both ---- */

static bool emit_unaimed(const pm_light_aim *aim, const double u[5], pm_emission *out,
                         double *common)
{
    *common = 1;
    if (!pm_light_emit(aim->world, u, out))
        return false;
    double aimed =
        out->from == PM_NO_PRIMITIVE ? weigh_distant(aim, out) : weigh_lamp(aim, out);
    double both = aim->unaimed + (1 - aim->unaimed) * aimed;
    out->flux = pm_rgb_scale(out->flux, 1 / both);
    *common = both / aim->unaimed;
    return true;
}

bool pm_light_emit_aimed(const pm_light_aim *aim, const double u[5], pm_emission *out,
                         double *common)
{
    const pm_world *world = aim->world;
    const struct pm_lights *l = world->lights;
    double rescaled[5] = {u[0] / aim->unaimed, u[1], u[2], u[3], u[4]};
    rescaled[0] = fmin(rescaled[0], 1 - 0x1p-53);
    if (u[0] < aim->unaimed)
        return emit_unaimed(aim, rescaled, out, common);
    double at = fmin((u[0] - aim->unaimed) / (1 - aim->unaimed), 1 - 0x1p-53);
    out->light = pm_lights_search(aim->cumulative, l->count, at);
    const struct pm_light *light = &l->lights[out->light];
    if (light->surface == PM_NO_PRIMITIVE)
        aim_from_distance(aim, u, out, common);
    else
        aim_from_lamp(aim, u, out, common);
    out->weak = pm_lights_is_weak(&world->materials[light->material]);
    return true;
}

bool pm_light_emit_lamps(const pm_light_aim *aim, const double u[5], pm_emission *out)
{
    const struct pm_lights *l = aim->world->lights;
    if (pm_rgb_is_black(l->power) && !l->patterned)
        return false;
    uint32_t picked = pm_lights_pick(l, u[0]);
    double before = picked ? l->cumulative[picked - 1] : 0, common;
    double rest = (u[0] - before) / (l->cumulative[picked] - before);
    if (!(aimed_chance(aim, picked) > 0))
        return pm_light_emit(aim->world, u, out);
    if (rest < aim->unaimed)
        return emit_unaimed(aim, u, out, &common);
    out->light = picked;
    aim_from_lamp(aim, u, out, &common);
    out->weak = pm_lights_is_weak(&aim->world->materials[l->lights[picked].material]);
    return true;
}

/* ---- set up ---- */

static void set_discs(pm_light_aim *aim)
{
    const pm_targets *t = aim->targets;
    double radius = aim->world->lights->radius, sum = 0, share = 0;
    for (unsigned i = 0; i < t->count; i++) {
        double square = t->radius[i] * t->radius[i];
        share += square / (radius * radius);
        sum += t->weight[i] * square;
        aim->discs[i] = sum;
    }
    for (unsigned i = 0; i < t->count; i++)
        aim->discs[i] /= sum;
    aim->disc_density = 1 / (PM_PI * sum);
    aim->disc_share = fmin(share, 1);
}

static double share_of_lamp(const pm_light_aim *aim, const struct pm_light *light,
                            unsigned places)
{
    const struct pm_material *m = &aim->world->materials[light->material];
    double sum = 0, area;
    for (unsigned i = 0; i < places; i++) {
        pm_target_view view;
        pm_hit hit =
            pm_light_draw_place(aim->world, light, pm_sobol(i, 0, 1), pm_sobol(i, 1, 1), &area);
        pm_target_lobe lobe = lobe_of(m, hit.normal);
        pm_targets_look(aim->targets, hit.point, &lobe, &view);
        sum += view.around > 0 ? 1 : view.share;
    }
    return sum / places;
}

/* Each light's chance is what it sends to the targets. */
static void set_chances(pm_light_aim *aim)
{
    const struct pm_lights *l = aim->world->lights;
    size_t places = ALL_PLACES / l->count;
    places = places < 1 ? 1 : places > PLACES ? PLACES : places;
    double sum = 0;
    for (size_t i = 0; i < l->count; i++) {
        const struct pm_light *light = &l->lights[i];
        double share = light->surface == PM_NO_PRIMITIVE
                           ? aim->disc_share
                           : share_of_lamp(aim, light, (unsigned)places);
        sum += light->chance * share;
        aim->cumulative[i] = sum;
    }
    aim->share = fmin(sum, 1);
    for (size_t i = 0; i < l->count; i++)
        aim->cumulative[i] = sum > 0 ? fmin(aim->cumulative[i] / sum, 1) : 0;
    if (sum > 0)
        aim->cumulative[l->count - 1] = 1;
    else
        aim->unaimed = 1; /* no light leaves for them */
}

static pm_light_aim *make(const pm_world *world, const pm_targets *targets, double unaimed,
                          pm_error *err)
{
    pm_light_aim *aim = calloc(1, sizeof *aim);
    double *cumulative = calloc(world->lights->count + 1, sizeof *cumulative);
    if (!aim || !cumulative) {
        free(aim);
        free(cumulative);
        pm_error_set(err, PM_E_MEMORY, "no memory to aim the lights");
        return NULL;
    }
    *aim = (pm_light_aim){
        .world = world, .targets = targets, .unaimed = unaimed, .cumulative = cumulative};
    return aim;
}

pm_status pm_light_aim_new(const pm_world *world, const pm_targets *targets, double unaimed,
                           pm_light_aim **out, pm_error *err)
{
    bool any = targets->count && world->lights->count;
    pm_light_aim *aim = make(world, targets, any ? unaimed : 1, err);
    if (!aim)
        return PM_E_MEMORY;
    if (aim->unaimed < 1) {
        set_discs(aim);
        set_chances(aim);
    }
    *out = aim;
    return PM_OK;
}

pm_status pm_light_aim_lamps(const pm_world *world, const pm_targets *targets, double unaimed,
                             bool *lamps, pm_light_aim **out, pm_error *err)
{
    const struct pm_lights *l = world->lights;
    pm_light_aim *aim = make(world, targets, unaimed, err);
    if (!aim)
        return PM_E_MEMORY;
    double sum = 0;
    for (size_t i = 0; i < l->count; i++) {
        double share = lamps[i] ? share_of_lamp(aim, &l->lights[i], PLACES) : 0;
        lamps[i] = share > 0 && share < MOST;
        sum += lamps[i] ? l->lights[i].chance : 0;
        aim->share += lamps[i] ? l->lights[i].chance * share : 0;
        aim->cumulative[i] = sum;
    }
    *out = aim;
    return PM_OK;
}

void pm_light_aim_free(pm_light_aim *aim)
{
    if (!aim)
        return;
    free(aim->cumulative);
    free(aim);
}

double pm_light_aim_share(const pm_light_aim *aim)
{
    return aim->share;
}
