#include "world/lamps.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/sobol.h"
#include "world/light_aim.h"
#include "world/lights.h"
#include "world/openings.h"
#include "world/placed.h"
#include "world/sight.h"

enum {
    LIGHTS_MAX = 1 << 14,
    SURFACES_MAX = 1 << 22,
    GLANCES = 64,        /* at lamps by their power, to see whether any stands outside */
    RAYS = 8,            /* of a lamp, to see whether it does */
    ALL_RAYS = 1 << 12,  /* of all together, about */
    LINES = 64,          /* from a lamp to ports */
    ALL_LINES = 1 << 18, /* of all together, about */
};

#define UNAIMED .5

struct pm_lamps {
    pm_targets openings;
    pm_light_aim *aim;
    char note[120];
};

/* Surfaces that are ports: those that let light go along their normal come first. */
struct ports {
    uint32_t *surfaces;
    size_t count, fronts;
};

struct finder {
    const pm_world *world;
    struct ports ports;
    bool *lamps; /* [lights] that are to be aimed */
    pm_lamps *out;
};

/* ---- where lamps stand ---- */

static bool is_lamp(const struct pm_light *light)
{
    return light->surface != PM_NO_PRIMITIVE && light->chance > 0;
}

/* An emission of the lights whose cumulative chance lies there. */
static bool draw(const pm_world *world, uint32_t i, double at, pm_emission *out)
{
    double u[5] = {at};
    for (unsigned d = 1; d < 5; d++)
        u[d] = pm_sobol(i, d, pm_hash_u32(1, d));
    return pm_light_emit(world, u, out) && out->from != PM_NO_PRIMITIVE;
}

static bool is_outside(const pm_world *world, const pm_emission *e)
{
    pm_ray ray = {e->origin, e->direction, INFINITY, e->from};
    pm_hit hit;
    if (!pm_world_intersect(world, &ray, &hit))
        return true;
    pm_vec3 middle = pm_vec3_madd(e->origin, hit.t / 2, e->direction);
    return pm_sight_around(world, middle).closed < PM_SIGHT_CLOSED;
}

static double before(const struct pm_lights *l, size_t light)
{
    return light ? l->cumulative[light - 1] : 0;
}

/* Lamps come before the distant sources. */
static double chance_of_lamps(const struct pm_lights *l)
{
    size_t count = l->count;
    while (count && l->lights[count - 1].surface == PM_NO_PRIMITIVE)
        count--;
    return before(l, count);
}

static bool may_stand_outside(const pm_world *world)
{
    double lamps = chance_of_lamps(world->lights);
    pm_emission e;
    for (uint32_t i = 0; i < GLANCES && lamps > 0; i++)
        if (draw(world, i, lamps * (i + .5) / GLANCES, &e) && is_outside(world, &e))
            return true;
    return false;
}

static uint32_t at_most(uint32_t each, size_t all, size_t lights)
{
    size_t share = all / lights;
    return share < 1 ? 1 : share < each ? (uint32_t)share : each;
}

static bool stands_outside(const pm_world *world, size_t light)
{
    const struct pm_lights *l = world->lights;
    double at = (before(l, light) + l->cumulative[light]) / 2;
    uint32_t rays = at_most(RAYS, ALL_RAYS, l->count), outside = 0;
    pm_emission e;
    for (uint32_t i = 0; i < rays; i++)
        outside += draw(world, i, at, &e) && is_outside(world, &e);
    return 2 * outside > rays;
}

/* ---- ports ---- */

static pm_status list_ports(const pm_world *world, const pm_selection ports[2],
                            struct ports *out, pm_error *err)
{
    uint32_t *sides[2] = {NULL, NULL};
    size_t counts[2] = {0, 0};
    pm_status st = PM_OK;
    for (int i = 0; i < 2 && !st; i++)
        st = pm_selection_list(&ports[i], world, SURFACES_MAX, &sides[i], &counts[i], err);
    size_t count = counts[0] + counts[1];
    if (!st && count) {
        out->surfaces = malloc(count * sizeof *out->surfaces);
        if (!out->surfaces)
            st = pm_error_set(err, PM_E_MEMORY, "no memory for a choice of surfaces");
    }
    if (!st && count) {
        if (counts[0])
            memcpy(out->surfaces, sides[0], counts[0] * sizeof *out->surfaces);
        if (counts[1])
            memcpy(out->surfaces + counts[0], sides[1], counts[1] * sizeof *out->surfaces);
        out->count = count;
        out->fronts = counts[0];
    }
    free(sides[0]);
    free(sides[1]);
    return st;
}

/* Whether a line from the lamp gets to a place of the port, on the side that lets it through.
 */
static bool passes_port(const struct finder *f, const struct pm_light *light, uint32_t i)
{
    const struct ports *p = &f->ports;
    double area, u[5];
    for (unsigned d = 0; d < 5; d++)
        u[d] = pm_sobol(i, d, pm_hash_u32(2, d));
    size_t port = (size_t)(u[4] * (double)p->count);
    pm_vec3 end, normal;
    pm_hit hit = pm_light_draw_place(f->world, light, u[0], u[1], &area);
    pm_placed_sample(f->world, p->surfaces[port], u[2], u[3], &end, &normal);
    pm_vec3 way = pm_vec3_sub(end, hit.point);
    double along = pm_vec3_dot(way, normal);
    return (port < p->fronts ? along > 0 : along < 0) && pm_vec3_dot(way, hit.normal) > 0 &&
           pm_sight_reaches(f->world, hit.point, light->surface, end);
}

static bool shines_through_port(const struct finder *f, size_t light)
{
    const struct pm_lights *l = f->world->lights;
    uint32_t lines = at_most(LINES, ALL_LINES, l->count);
    for (uint32_t i = 0; i < lines; i++)
        if (passes_port(f, &l->lights[light], i))
            return true;
    return false;
}

/* ---- finding ---- */

static pm_status find_openings(struct finder *f, pm_error *err)
{
    const struct ports *p = &f->ports;
    if (p->count)
        return pm_targets_about(f->world, p->surfaces, p->count, &f->out->openings, err);
    return pm_openings_to_dark(f->world, &f->out->openings, err);
}

/* Light that may pass a port either way says nothing about where its lamp stands. */
static bool is_chosen(const struct finder *f, size_t light)
{
    const struct ports *p = &f->ports;
    bool one_way = p->count && (!p->fronts || p->fronts == p->count);
    if (!is_lamp(&f->world->lights->lights[light]))
        return false;
    if (!one_way && !stands_outside(f->world, light))
        return false;
    return !p->count || shines_through_port(f, light);
}

static pm_status aim(struct finder *f, size_t *aimed, pm_error *err)
{
    const struct pm_lights *l = f->world->lights;
    size_t chosen = 0;
    *aimed = 0;
    for (size_t i = 0; i < l->count; i++)
        chosen += f->lamps[i] = is_chosen(f, i);
    pm_status st = chosen ? find_openings(f, err) : PM_OK;
    if (st || !chosen || !f->out->openings.count)
        return st;
    st = pm_light_aim_lamps(f->world, &f->out->openings, UNAIMED, f->lamps, &f->out->aim, err);
    for (size_t i = 0; i < l->count && !st; i++)
        *aimed += f->lamps[i];
    return st;
}

static pm_status find(struct finder *f, bool *found, pm_error *err)
{
    size_t aimed = 0;
    f->lamps = calloc(f->world->lights->count, sizeof *f->lamps);
    f->out = calloc(1, sizeof *f->out);
    pm_status st = f->lamps && f->out
                       ? aim(f, &aimed, err)
                       : pm_error_set(err, PM_E_MEMORY, "no memory to aim lamps");
    if (!st && aimed)
        snprintf(f->out->note, sizeof f->out->note,
                 "%zu lamp%s outside: half the light is aimed at the %s", aimed,
                 aimed > 1 ? "s" : "", f->ports.count ? "ports" : "openings");
    *found = aimed > 0;
    return st;
}

pm_status pm_lamps_find(const pm_world *world, const pm_selection ports[2], pm_lamps **out,
                        pm_error *err)
{
    const struct pm_lights *l = world->lights;
    struct finder f = {.world = world};
    bool found = false, named = ports[0].any || ports[1].any;
    *out = NULL;
    if (l->count > LIGHTS_MAX || !(chance_of_lamps(l) > 0) ||
        (!named && !may_stand_outside(world)))
        return PM_OK;
    pm_status st = list_ports(world, ports, &f.ports, err);
    if (!st && (f.ports.count || !named))
        st = find(&f, &found, err);
    if (!st && found)
        *out = f.out;
    else
        pm_lamps_free(f.out);
    free(f.lamps);
    free(f.ports.surfaces);
    return st;
}

void pm_lamps_free(pm_lamps *lamps)
{
    if (!lamps)
        return;
    pm_light_aim_free(lamps->aim);
    free(lamps);
}

bool pm_lamps_emit(const pm_lamps *lamps, const pm_world *world, const double u[5],
                   pm_emission *out)
{
    return lamps ? pm_light_emit_lamps(lamps->aim, u, out) : pm_light_emit(world, u, out);
}

const pm_targets *pm_lamps_openings(const pm_lamps *lamps)
{
    return &lamps->openings;
}

const char *pm_lamps_note(const pm_lamps *lamps)
{
    return lamps->note;
}
