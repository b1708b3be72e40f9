#include "world/ports.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/maths.h"
#include "base/sobol.h"
#include "world/lights.h"
#include "world/placed.h"

enum {
    SURFACES_MAX = 1 << 22,
    PATCHES_MAX = 1 << 16, /* about, beyond one a surface */
    ROWS = 5,              /* normals are grouped by their place on the sphere */
    COLUMNS = 8,
    GROUPS = ROWS * COLUMNS,
    BROAD = 2,         /* components of broad sources: lights, weak ones */
    NARROW_MAX = 4096, /* more are drawn as broad ones are */
    LOOKS = 1 << 16,   /* through patches, to see how much light comes; about */
    LOOKS_OF_A_PATCH = 16,
    LOOKS_AT_NARROW = 32,
    TABLE_LOOKS = 1 << 20, /* values of all tables, about */
    PROBES = 4,            /* places of a port from which a table looks in a direction */
    NORMALS = 16,          /* of a curved port that a table averages over */
    STRAIGHT_MAX = 1024    /* surfaces in a row before a port */
};

/* 1 - cos of half the angle of sources that are drawn by themselves. */
#define NARROW_VERSINE .1

/* What was seen dark may not be. */
#define LEAST_VISIBLE .125
#define LEAST_CHANCE  0x1p-6

/* Part of a surface, in the square of pm_placed_sample. */
struct patch {
    uint32_t surface;
    uint16_t group;
    uint8_t side; /* 0: light goes along the normal; 1: against it */
    float u, v, size_u, size_v;
    double area;
};

/* Patches whose normals point to about the same side. */
struct group {
    size_t first, count; /* of the patches */
    bool flat;           /* all normals are the same */
    pm_vec3 outward;     /* to where light comes from, on average */
    double area;
    struct pm_light_beam beam[BROAD];
};

struct pm_ports {
    const pm_world *world;
    const pm_lamps *aimed; /* NULL: none */
    pm_ports_options options;
    pm_arena arena;

    struct patch *patches;
    double *patch_ends; /* cumulative chances within each group */
    size_t patch_count;
    struct group *groups;
    size_t group_count;

    bool *is_broad; /* [distant_count] */
    bool has_broad[BROAD];
    uint32_t *narrow; /* lights */
    size_t narrow_count;
    double *pair_ends; /* [group_count][BROAD + narrow_count] cumulative chances */
    double local;      /* share of the photons that lamps emit */
    double lamps;      /* chance of lamps in pm_light_emit */
};

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "no memory for the photon ports");
}

/* ---- sources ---- */

static const struct pm_light *light_of(const pm_ports *p, uint32_t light)
{
    return &p->world->lights->lights[light];
}

static const struct pm_material *material_of(const pm_ports *p, const struct pm_light *light)
{
    return &p->world->materials[light->material];
}

static size_t first_distant(const struct pm_lights *l)
{
    size_t i = 0;
    while (i < l->count && l->lights[i].surface != PM_NO_PRIMITIVE)
        i++;
    return i;
}

static bool is_small(const pm_ports *p, const struct pm_light *light)
{
    return p->world->distants[light->distant].versine < NARROW_VERSINE;
}

static bool sort_sources(pm_ports *p)
{
    const struct pm_lights *l = p->world->lights;
    size_t small = 0, first = first_distant(l);
    for (size_t i = first; i < l->count; i++)
        small += is_small(p, &l->lights[i]);
    p->is_broad = pm_arena_array(&p->arena, p->world->distant_count, sizeof *p->is_broad);
    p->narrow = pm_arena_array(&p->arena, small + 1, sizeof *p->narrow);
    if (!p->is_broad || !p->narrow)
        return false;
    for (size_t i = first; i < l->count; i++) {
        const struct pm_light *light = &l->lights[i];
        if (small <= NARROW_MAX && is_small(p, light)) {
            p->narrow[p->narrow_count++] = (uint32_t)i;
        } else {
            p->is_broad[light->distant] = true;
            p->has_broad[pm_lights_is_weak(material_of(p, light))] = true;
        }
    }
    return true;
}

/* What broad sources show, those of one component. */
struct shining {
    const pm_ports *ports;
    pm_vec3 direction;
    bool weak;
    bool lit; /* a light hides the glows */
    pm_rgb sum;
};

static void add_source(void *context, uint32_t source)
{
    struct shining *s = context;
    const pm_world *world = s->ports->world;
    const struct pm_material *m = &world->materials[world->distants[source].material];
    if (!s->ports->is_broad[source] || pm_lights_is_weak(m) != s->weak ||
        (s->lit && m->type == PM_GLOW))
        return;
    s->sum = pm_rgb_add(s->sum, pm_lights_shine_far(world, source, s->direction));
}

static pm_rgb broad_radiance(const pm_ports *p, int component, pm_vec3 direction)
{
    struct shining s = {.ports = p, .direction = direction, .weak = component};
    s.lit = component && pm_lights_is_lit(p->world, direction);
    pm_sky_index_visit(p->world->lights->sky, p->world, direction, add_source, &s);
    return s.sum;
}

static pm_rgb narrow_radiance(const pm_ports *p, const struct pm_light *light,
                              pm_vec3 direction)
{
    if (material_of(p, light)->type == PM_GLOW && pm_lights_is_lit(p->world, direction))
        return pm_rgb_grey(0);
    return pm_lights_shine_far(p->world, light->distant, direction);
}

/* ---- patches ---- */

/* A place of a patch: where light comes from there is the side of `outward`. */
struct place {
    pm_vec3 point, outward;
    uint32_t surface;
};

static struct place place_in(const pm_ports *p, const struct patch *patch, double u, double v)
{
    struct place place = {.surface = patch->surface};
    pm_vec3 normal;
    u = fmin((double)patch->u + (double)patch->size_u * u, 1 - 0x1p-53);
    v = fmin((double)patch->v + (double)patch->size_v * v, 1 - 0x1p-53);
    pm_placed_sample(p->world, patch->surface, u, v, &place.point, &normal);
    place.outward = patch->side ? normal : pm_vec3_negate(normal);
    return place;
}

/* Normals along axes are in the middle of a cell. */
static uint16_t group_of(pm_vec3 n)
{
    int row = (int)floor((n.z + 1) / 2 * (ROWS - 1) + .5);
    double turn = pm_atan2(n.y, n.x) / (2 * PM_PI) + 1;
    int column = (int)floor(turn * COLUMNS + .5) % COLUMNS;
    return (uint16_t)(row * COLUMNS + column);
}

/* Pieces along one edge of the square, given the surfaces' area in patches. */
static uint32_t pieces_of(double area, double patch_area)
{
    double pieces = ceil(sqrt(area / patch_area));
    return pieces > 1 ? pieces < 256 ? (uint32_t)pieces : 256 : 1;
}

struct chosen {
    uint32_t *surfaces[2];
    size_t count[2];
};

static void chosen_clear(struct chosen *chosen)
{
    free(chosen->surfaces[0]);
    free(chosen->surfaces[1]);
}

static double area_chosen(const pm_ports *p, const struct chosen *chosen)
{
    double area = 0;
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < chosen->count[side]; i++)
            area += pm_placed_area(p->world, chosen->surfaces[side][i]);
    return area;
}

static void cut_surface(pm_ports *p, uint32_t surface, int side, double patch_area)
{
    double area = pm_placed_area(p->world, surface);
    uint32_t n = pieces_of(area, patch_area);
    for (uint32_t i = 0; i < n * n; i++) {
        struct patch patch = {.surface = surface,
                              .side = (uint8_t)side,
                              .u = (float)(i % n) / (float)n,
                              .v = (float)(i / n) / (float)n};
        patch.size_u = (float)(i % n + 1) / (float)n - patch.u;
        patch.size_v = (float)(i / n + 1) / (float)n - patch.v;
        patch.area = area * (double)patch.size_u * (double)patch.size_v;
        patch.group = group_of(place_in(p, &patch, .5, .5).outward);
        p->patches[p->patch_count++] = patch;
    }
}

/* At most about PATCHES_MAX, but one a surface at least. */
static bool cut_patches(pm_ports *p, const struct chosen *chosen)
{
    double size = 2 * p->options.partition;
    double least = area_chosen(p, chosen) / PATCHES_MAX;
    double patch_area = fmax(size * size, 4 * least);
    size_t count = 0;
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < chosen->count[side]; i++) {
            size_t n =
                pieces_of(pm_placed_area(p->world, chosen->surfaces[side][i]), patch_area);
            count += n * n;
        }
    p->patches = pm_arena_array(&p->arena, count, sizeof *p->patches);
    p->patch_ends = pm_arena_array(&p->arena, count, sizeof *p->patch_ends);
    if (!p->patches || !p->patch_ends)
        return false;
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < chosen->count[side]; i++)
            cut_surface(p, chosen->surfaces[side][i], side, patch_area);
    return true;
}

/* ---- groups ---- */

/* Stable, so that equal worlds have equal patches. */
static bool sort_patches(pm_ports *p, size_t starts[GROUPS + 1])
{
    struct patch *sorted = malloc(p->patch_count * sizeof *sorted);
    size_t next[GROUPS];
    if (!sorted)
        return false;
    memset(starts, 0, (GROUPS + 1) * sizeof *starts);
    for (size_t i = 0; i < p->patch_count; i++)
        starts[p->patches[i].group + 1]++;
    for (int g = 0; g < GROUPS; g++)
        starts[g + 1] += starts[g];
    memcpy(next, starts, sizeof next);
    for (size_t i = 0; i < p->patch_count; i++)
        sorted[next[p->patches[i].group]++] = p->patches[i];
    memcpy(p->patches, sorted, p->patch_count * sizeof *sorted);
    free(sorted);
    return true;
}

/* Whether a patch's corners have all the group's normal. */
static bool is_flat(const pm_ports *p, const struct patch *patch, pm_vec3 outward)
{
    for (int i = 0; i < 5; i++) {
        static const double at[5][2] = {{.5, .5}, {0, 0}, {0, .999}, {.999, 0}, {.999, .999}};
        pm_vec3 off = pm_vec3_sub(place_in(p, patch, at[i][0], at[i][1]).outward, outward);
        if (!(pm_vec3_dot(off, off) < 0x1p-60))
            return false;
    }
    return true;
}

static void measure_group(pm_ports *p, struct group *g)
{
    pm_vec3 first = place_in(p, &p->patches[g->first], .5, .5).outward, sum = {0, 0, 0};
    g->flat = true;
    for (size_t i = g->first; i < g->first + g->count; i++) {
        g->area += p->patches[i].area;
        g->flat = g->flat && is_flat(p, &p->patches[i], first);
        sum =
            pm_vec3_madd(sum, p->patches[i].area, place_in(p, &p->patches[i], .5, .5).outward);
    }
    g->outward = first;
    if (!g->flat && pm_vec3_length(sum) > 0)
        g->outward = pm_vec3_normalize(sum);
}

static bool make_groups(pm_ports *p)
{
    size_t starts[GROUPS + 1];
    p->groups = pm_arena_array(&p->arena, GROUPS, sizeof *p->groups);
    if (!p->groups || !sort_patches(p, starts))
        return false;
    for (int i = 0; i < GROUPS; i++) {
        if (starts[i + 1] == starts[i])
            continue;
        struct group *g = &p->groups[p->group_count++];
        g->first = starts[i];
        g->count = starts[i + 1] - starts[i];
        measure_group(p, g);
        if (!(g->area > 0))
            p->group_count--;
    }
    return true;
}

/* ---- looking out ---- */

/* Whether anything comes from there: media are left out, as they only attenuate. */
static bool is_open(const pm_ports *p, const struct place *place, pm_vec3 up)
{
    const pm_ray ray = {place->point, up, INFINITY, place->surface};
    const pm_media none = {.count = 0};
    return !pm_rgb_is_black(pm_world_transmittance(p->world, &ray, &none, false));
}

static const struct patch *some_patch(const pm_ports *p, const struct group *g, uint32_t hash)
{
    return &p->patches[g->first + (size_t)((double)hash * 0x1p-32 * (double)g->count)];
}

/* A table's view of the broad sources of one component from a group. */
struct outlook {
    const pm_ports *ports;
    const struct group *group;
    int component;
};

static uint32_t hash_of(pm_vec3 direction)
{
    uint32_t x = (uint32_t)(int32_t)(direction.x * 0x1p30);
    uint32_t y = (uint32_t)(int32_t)(direction.y * 0x1p30);
    return pm_hash_u32(pm_hash_u32(x, y), direction.z < 0);
}

static double mean_cosine(const struct outlook *o, pm_vec3 direction)
{
    const struct group *g = o->group;
    if (g->flat)
        return fmax(pm_vec3_dot(direction, g->outward), 0);
    double sum = 0;
    for (uint32_t i = 0; i < NORMALS; i++) {
        const struct patch *patch = some_patch(o->ports, g, pm_hash_u32(i, 1));
        double u = pm_sobol(i, 0, 0), v = pm_sobol(i, 1, 0);
        sum += fmax(pm_vec3_dot(direction, place_in(o->ports, patch, u, v).outward), 0);
    }
    return sum / NORMALS;
}

/* A direction counts unless nothing comes from there to any of several places: where it comes
 * to some, photons that do not arrive are left out later. */
static double seen_from_group(const void *context, pm_vec3 direction)
{
    const struct outlook *o = context;
    double radiance = pm_rgb_mean(broad_radiance(o->ports, o->component, direction));
    double cosine = radiance > 0 ? mean_cosine(o, direction) : 0;
    uint32_t hash = hash_of(direction);
    for (uint32_t i = 0; cosine > 0 && i < PROBES; i++) {
        uint32_t draw = pm_hash_u32(hash, i);
        const struct patch *patch = some_patch(o->ports, o->group, draw);
        struct place place = place_in(o->ports, patch, pm_hash_u32(draw, 1) * 0x1p-32,
                                      pm_hash_u32(draw, 2) * 0x1p-32);
        if (pm_vec3_dot(place.outward, direction) > 0 && is_open(o->ports, &place, direction))
            return radiance * cosine;
    }
    return 0;
}

static uint32_t detail_of(const pm_ports *p, double versine)
{
    double most = sqrt((double)TABLE_LOOKS / (double)(p->group_count * BROAD * 5));
    return (uint32_t)fmin(sqrt(p->options.direction_resolution * 2 * PM_PI * versine), most);
}

static pm_status make_tables(pm_ports *p, pm_error *err)
{
    pm_status st = PM_OK;
    for (size_t i = 0; i < p->group_count; i++)
        for (int c = 0; c < BROAD && !st; c++) {
            struct group *g = &p->groups[i];
            double versine = g->flat ? 1 : 2;
            const struct outlook outlook = {p, g, c};
            const struct pm_light_directions directions = {seen_from_group, &outlook,
                                                           detail_of(p, versine)};
            if (p->has_broad[c])
                st = pm_light_beam_build(&directions, g->outward, versine, &p->arena,
                                         &g->beam[c], err);
        }
    return st;
}

/* ---- draws ---- */

/* A direction in which a component shines, and one over its density [sr]. */
static pm_vec3 draw_direction(const pm_ports *p, const struct group *g, size_t component,
                              double u, double v, double *solid_angle)
{
    if (component >= BROAD) {
        const struct pm_light *light = light_of(p, p->narrow[component - BROAD]);
        return pm_light_draw_distant(p->world, light, u, v, solid_angle);
    }
    double pdf;
    pm_vec3 up = pm_light_beam_sample(&g->beam[component], u, v, &pdf);
    *solid_angle = 1 / pdf;
    return up;
}

static pm_rgb radiance_of(const pm_ports *p, size_t component, pm_vec3 up)
{
    if (component < BROAD)
        return broad_radiance(p, (int)component, up);
    return narrow_radiance(p, light_of(p, p->narrow[component - BROAD]), up);
}

/* ---- chances ---- */

static size_t components(const pm_ports *p)
{
    return BROAD + p->narrow_count;
}

static bool has_component(const pm_ports *p, size_t component)
{
    return component >= BROAD || p->has_broad[component];
}

/* One draw of the irradiance that a component brings to a patch. */
static double look(const pm_ports *p, const struct group *g, const struct patch *patch,
                   size_t component, const double u[4], double *unobstructed)
{
    double solid_angle;
    struct place place = place_in(p, patch, u[0], u[1]);
    pm_vec3 up = draw_direction(p, g, component, u[2], u[3], &solid_angle);
    double cosine = pm_vec3_dot(up, place.outward), value = 0;
    if (cosine > 0)
        value = cosine * solid_angle * pm_rgb_mean(radiance_of(p, component, up));
    value = isfinite(value) ? value : 0;
    *unobstructed = value;
    return value > 0 && is_open(p, &place, up) ? value : 0;
}

static void draw_four(uint32_t i, uint32_t scramble, double u[4])
{
    for (unsigned d = 0; d < 4; d++)
        u[d] = pm_sobol(i, d, scramble);
}

/* Irradiance [W/scale^2] at right angles, as pm_lights knows it: what a component may have that
 * looking misses. */
static double normal_irradiance(const pm_ports *p, size_t component)
{
    const struct pm_lights *l = p->world->lights;
    double total = pm_rgb_mean(l->power), chance = 0;
    for (size_t i = first_distant(l); component < BROAD && i < l->count; i++) {
        bool weak = pm_lights_is_weak(material_of(p, &l->lights[i]));
        if (p->is_broad[l->lights[i].distant] && weak == (component == 1))
            chance += l->lights[i].chance;
    }
    if (component >= BROAD)
        chance = light_of(p, p->narrow[component - BROAD])->chance;
    return chance * (total > 0 ? total : 1) / (PM_PI * l->radius * l->radius);
}

/* Behind every place of a group, certainly. */
static bool is_behind(const pm_ports *p, const struct group *g, size_t component)
{
    if (!g->flat || component < BROAD)
        return false;
    const struct pm_light *light = light_of(p, p->narrow[component - BROAD]);
    const struct pm_distant *source = &p->world->distants[light->distant];
    double cosine = pm_vec3_dot(source->direction, g->outward);
    return cosine < 0 && cosine * cosine > source->versine * (2 - source->versine) + 0x1p-40;
}

/* Power that a component brings to a group [W/scale^2]. */
static double power_of(const pm_ports *p, const struct group *g, size_t component)
{
    if (!has_component(p, component) || is_behind(p, g, component))
        return 0;
    size_t looks = LOOKS / (p->group_count * components(p));
    uint32_t n = looks < 4 ? 4 : looks > LOOKS_AT_NARROW ? LOOKS_AT_NARROW : (uint32_t)looks;
    double sum = 0, least = LEAST_CHANCE * normal_irradiance(p, component);
    for (uint32_t i = 0; i < n; i++) {
        double u[4], all = 0;
        draw_four(i, (uint32_t)component + 1, u);
        const struct patch *patch = some_patch(p, g, pm_hash_u32(i, (uint32_t)component));
        sum += fmax(look(p, g, patch, component, u, &all), LEAST_VISIBLE * all);
    }
    return g->area * fmax(sum / n, least);
}

/* Sums up to chances: the last is exactly 1. */
static void accumulate(double *values, size_t count)
{
    double total = 0, sum = 0;
    for (size_t i = 0; i < count; i++)
        total += values[i];
    for (size_t i = 0; i < count; i++) {
        sum += total > 0 ? values[i] / total : 1. / (double)count;
        values[i] = i + 1 < count ? fmin(sum, 1) : 1;
    }
}

static double chance_of(const double *ends, size_t first, size_t i)
{
    return ends[i] - (i > first ? ends[i - 1] : 0);
}

/* The first end that exceeds *u; *u becomes its place within. */
static size_t pick(const double *ends, size_t first, size_t count, double *u)
{
    size_t low = first, high = first + count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (ends[middle] > *u)
            high = middle;
        else
            low = middle + 1;
    }
    double before = low > first ? ends[low - 1] : 0;
    *u = fmax(0, fmin((*u - before) / (ends[low] - before), 1 - 0x1p-53));
    return low;
}

/* Of a stratified choice in proportion to power. */
static size_t component_at(const double *powers, size_t count, double at)
{
    size_t last = 0;
    for (size_t c = 0; c < count; c++) {
        if (!(powers[c] > 0))
            continue;
        if (at < powers[c])
            return c;
        at -= powers[c];
        last = c;
    }
    return last;
}

/* Chances of the patches of a group: their area, and the share of light that comes to them,
 * looked at from each a few times. */
static void weigh_patches(pm_ports *p, const struct group *g, const double *powers)
{
    double total = 0;
    for (size_t c = 0; c < components(p); c++)
        total += powers[c];
    size_t looks = LOOKS / p->patch_count;
    uint32_t n = looks < 1 ? 1 : looks > LOOKS_OF_A_PATCH ? LOOKS_OF_A_PATCH : (uint32_t)looks;
    for (size_t i = g->first; i < g->first + g->count; i++) {
        double came = 0, could = 0;
        for (uint32_t k = 0; k < n && total > 0; k++) {
            double u[4], all = 0;
            size_t c = component_at(powers, components(p), (k + .5) / n * total);
            draw_four(k, (uint32_t)i, u);
            came += look(p, g, &p->patches[i], c, u, &all) / powers[c];
            could += all / powers[c];
        }
        double share = could > 0 ? came / could : 1;
        p->patch_ends[i] = p->patches[i].area * fmax(share, LEAST_VISIBLE);
    }
    accumulate(p->patch_ends + g->first, g->count);
}

static bool set_chances(pm_ports *p)
{
    const struct pm_lights *l = p->world->lights;
    size_t pairs = components(p), count = p->group_count * pairs, first = first_distant(l);
    p->pair_ends = pm_arena_array(&p->arena, count, sizeof *p->pair_ends);
    if (!p->pair_ends)
        return false;
    double entering = 0;
    for (size_t i = 0; i < count; i++) {
        p->pair_ends[i] = power_of(p, &p->groups[i / pairs], i % pairs);
        entering += p->pair_ends[i];
    }
    for (size_t g = 0; g < p->group_count; g++)
        weigh_patches(p, &p->groups[g], p->pair_ends + g * pairs);
    if (!(entering > 0))
        p->group_count = 0;
    p->lamps = first ? l->cumulative[first - 1] : 0;
    double lamps = p->lamps * pm_rgb_mean(l->power);
    if (p->lamps > 0)
        p->local = lamps + entering > 0 ? lamps / (lamps + entering) : .5;
    p->local = p->lamps > 0 ? fmax(0x1p-10, fmin(p->local, 1 - 0x1p-10)) : 0;
    accumulate(p->pair_ends, count);
    return true;
}

/* ---- making ---- */

static pm_status choose(pm_ports *p, struct chosen *chosen, pm_error *err)
{
    pm_status st = PM_OK;
    for (int side = 0; side < 2 && !st; side++)
        st = pm_selection_list(p->options.sides[side], p->world, SURFACES_MAX,
                               &chosen->surfaces[side], &chosen->count[side], err);
    return st;
}

static pm_status build(pm_ports *p, const struct chosen *chosen, pm_error *err)
{
    if (!cut_patches(p, chosen) || !make_groups(p) || !sort_sources(p))
        return no_memory(err);
    pm_status st = p->group_count ? make_tables(p, err) : PM_OK;
    if (!st && p->group_count && !set_chances(p))
        st = no_memory(err);
    return st;
}

pm_status pm_ports_new(const pm_world *world, const pm_ports_options *options, pm_ports **out,
                       pm_error *err)
{
    const struct pm_lights *l = world->lights;
    *out = NULL;
    if ((!options->sides[0]->any && !options->sides[1]->any) || first_distant(l) == l->count)
        return PM_OK;
    pm_ports *p = calloc(1, sizeof *p);
    if (!p)
        return no_memory(err);
    p->world = world;
    p->options = *options;
    struct chosen chosen = {0};
    pm_status st = choose(p, &chosen, err);
    if (!st)
        st = build(p, &chosen, err);
    chosen_clear(&chosen);
    if (st)
        pm_ports_free(p);
    else
        *out = p;
    return st;
}

void pm_ports_aim_lamps(pm_ports *p, const pm_lamps *lamps)
{
    p->aimed = lamps;
}

void pm_ports_free(pm_ports *p)
{
    if (!p)
        return;
    pm_arena_clear(&p->arena);
    free(p);
}

/* ---- emission ---- */

/* 0: light goes along the normal; 1: against it. */
static int side_of(const pm_hit *hit, pm_vec3 direction)
{
    return pm_vec3_dot(hit->normal, direction) > 0 ? 0 : 1;
}

/* Beyond every surface, on the line through a place. */
static pm_vec3 far_out(const pm_world *world, pm_vec3 point, pm_vec3 up)
{
    const struct pm_lights *l = world->lights;
    double height = l->radius * (1 + 0x1p-10) - pm_vec3_dot(pm_vec3_sub(point, l->center), up);
    return pm_vec3_madd(point, height, up);
}

/* Follows a line to the first port that lets it in. False if that is not the one that was
 * drawn, or if there is anything opaque before. */
static bool reach_port(const pm_ports *p, const struct patch *port, const pm_ray *start,
                       pm_port_entry *out, unsigned *crossed)
{
    const pm_world *world = p->world;
    pm_ray ray = *start;
    out->media.count = 0;
    for (*crossed = 0; *crossed < STRAIGHT_MAX; ++*crossed) {
        if (!pm_world_intersect(world, &ray, &out->hit))
            return false;
        pm_media_meet(&out->media, world, &out->hit, ray.direction);
        int side = side_of(&out->hit, ray.direction);
        if (pm_selection_has(p->options.sides[side], world, out->hit.surface))
            return out->hit.surface == port->surface && side == port->side;
        if (!out->media.count && !world->materials[out->hit.material].straight)
            return false;
        pm_media_cross(&out->media, world, &out->hit, ray.direction);
        ray.origin = out->hit.point;
        ray.from = out->hit.surface;
    }
    return false;
}

/* The share of light that comes from far out to the port. */
static pm_rgb share_of(const pm_ports *p, const pm_port_entry *entry, unsigned crossed)
{
    if (!crossed && !entry->media.count)
        return pm_rgb_grey(1);
    const pm_ray back = {.origin = entry->hit.point,
                         .direction = pm_vec3_negate(entry->emission.direction),
                         .t_max = INFINITY,
                         .from = entry->hit.surface};
    return pm_world_transmittance(p->world, &back, &entry->media, entry->emission.weak);
}

static void enter(const pm_ports *p, const struct patch *port, pm_rgb flux, pm_port_entry *out)
{
    const pm_emission *e = &out->emission;
    const pm_ray start = {e->origin, e->direction, INFINITY, PM_NO_PRIMITIVE};
    unsigned crossed;
    if (!reach_port(p, port, &start, out, &crossed))
        return;
    out->enters = true;
    out->emission.origin = out->hit.point;
    out->emission.from = port->surface;
    out->emission.flux = pm_rgb_mul(flux, share_of(p, out, crossed));
}

static bool is_weak(const pm_ports *p, size_t component)
{
    if (component < BROAD)
        return component == 1;
    return pm_lights_is_weak(material_of(p, light_of(p, p->narrow[component - BROAD])));
}

static void emit_through(const pm_ports *p, const double u[5], pm_port_entry *out)
{
    size_t pairs = components(p);
    double x = u[0], solid_angle;
    size_t pair = pick(p->pair_ends, 0, p->group_count * pairs, &x);
    const struct group *g = &p->groups[pair / pairs];
    size_t component = pair % pairs, i = pick(p->patch_ends, g->first, g->count, &x);
    const struct patch *patch = &p->patches[i];
    out->emission = (pm_emission){.from = PM_NO_PRIMITIVE, .direction = {0, 0, 1}};
    if (!has_component(p, component)) /* a rounding error's chance */
        return;
    struct place place = place_in(p, patch, u[1], u[2]);
    pm_vec3 up = draw_direction(p, g, component, u[3], u[4], &solid_angle);
    double cosine = pm_vec3_dot(up, place.outward);
    out->emission = (pm_emission){.origin = far_out(p->world, place.point, up),
                                  .direction = pm_vec3_negate(up),
                                  .from = PM_NO_PRIMITIVE,
                                  .weak = is_weak(p, component)};
    double chance = (1 - p->local) * chance_of(p->pair_ends, 0, pair) *
                    chance_of(p->patch_ends, g->first, i);
    double weight = cosine * solid_angle * patch->area / chance;
    if (weight > 0 && weight < INFINITY)
        enter(p, patch, pm_rgb_scale(radiance_of(p, component, up), weight), out);
}

bool pm_ports_emit(const pm_ports *p, const double u[5], pm_port_entry *out)
{
    double v[5];
    memcpy(v, u, sizeof v);
    out->enters = false;
    if (u[0] < p->local) {
        v[0] = fmin(u[0] / p->local, 1 - 0x1p-53) * p->lamps;
        if (!pm_lamps_emit(p->aimed, p->world, v, &out->emission))
            return false;
        out->emission.flux = pm_rgb_scale(out->emission.flux, p->lamps / p->local);
        return true;
    }
    if (!p->group_count)
        return false;
    v[0] = fmin((u[0] - p->local) / (1 - p->local), 1 - 0x1p-53);
    emit_through(p, v, out);
    return true;
}
