#include "world/light_pattern.h"

#include <math.h>

#include "base/maths.h"
#include "base/sobol.h"
#include "world/lights.h"

enum {
    FEW = 64, /* evaluations that are worth no table */
    SKY_DETAIL = 128,
    LAMP_DETAIL = 64,
    PLACE_DETAIL_MAX = 256,
    PROBES = 4,     /* of directions for each place, or the other way around; 2 x 2 */
    LAMP_SHARE = 4, /* a lamp gets so much less work than a sky */
    POWER_SAMPLES_MIN = 16,
    POWER_SAMPLES_MAX = 4096
};

/* ---- draws ---- */

static const struct pm_shape *shape_of(const pm_world *world, const struct pm_light *light)
{
    return &world->shapes[light->surface];
}

/* From farther than the whole scene, since emission does not know where its light will fall. */
static pm_hit hit_of(const pm_world *world, const struct pm_light *light, pm_vec3 point,
                     pm_vec3 normal)
{
    return (pm_hit){.t = 2 * world->lights->radius,
                    .point = point,
                    .normal = normal,
                    .surface = light->surface,
                    .material = light->material};
}

/* Evenly over the disc that a ball shows to a direction (a bubble: its far inner side). */
static pm_hit place_on_ball(const pm_world *world, const struct pm_light *light,
                            pm_vec3 direction, double u, double v)
{
    const struct pm_shape *ball = shape_of(world, light);
    pm_frame frame = pm_frame_make(direction);
    pm_vec3 normal = pm_frame_to_world(&frame, pm_warp_cosine(u, v));
    double radius = ball->inward ? -ball->r0 : ball->r0;
    return hit_of(world, light, pm_vec3_madd(ball->center, radius, normal), normal);
}

static void draw_from_ball(const pm_world *world, const struct pm_light *light,
                           const double u[4], struct pm_light_draw *out)
{
    double radius = shape_of(world, light)->r0, pdf;
    out->direction = pm_light_beam_sample(&light->pattern->beam, u[2], u[3], &pdf);
    out->hit = place_on_ball(world, light, out->direction, u[0], u[1]);
    out->weight = PM_PI * radius * radius / pdf;
}

pm_hit pm_light_draw_place(const pm_world *world, const struct pm_light *light, double u,
                           double v, double *area)
{
    const struct pm_shape *shape = shape_of(world, light);
    const struct pm_light_table *places = light->pattern ? light->pattern->places : NULL;
    pm_vec3 point, normal;
    *area = shape->area / (places ? pm_light_table_warp(places, &u, &v) : 1);
    pm_shape_sample(shape, u, v, &point, &normal);
    return hit_of(world, light, point, normal);
}

void pm_light_draw_leaving(const pm_world *world, const struct pm_light *light,
                           const double u[4], struct pm_light_draw *out)
{
    const struct pm_light_beam *beam = &light->pattern->beam;
    if (beam->table && pm_shape_is_ball(shape_of(world, light))) {
        draw_from_ball(world, light, u, out);
        return;
    }
    double area, pdf;
    out->hit = pm_light_draw_place(world, light, u[0], u[1], &area);
    if (beam->table) {
        out->direction = pm_light_beam_sample(beam, u[2], u[3], &pdf);
        out->weight = fmax(pm_vec3_dot(out->direction, out->hit.normal), 0) / pdf;
    } else {
        out->direction = pm_lights_direction(&world->materials[light->material],
                                             out->hit.normal, u[2], u[3], &out->weight);
    }
    out->weight *= area;
}

pm_vec3 pm_light_draw_distant(const pm_world *world, const struct pm_light *light, double u,
                              double v, double *solid_angle)
{
    const struct pm_distant *source = &world->distants[light->distant];
    if (light->pattern && light->pattern->beam.table) {
        double pdf;
        pm_vec3 direction = pm_light_beam_sample(&light->pattern->beam, u, v, &pdf);
        *solid_angle = 1 / pdf;
        return direction;
    }
    pm_frame frame = pm_frame_make(source->direction);
    *solid_angle = 2 * PM_PI * source->versine;
    return pm_frame_to_world(&frame, pm_warp_cone(u, v, source->versine));
}

/* ---- what patterns look at ---- */

struct traits {
    uint64_t uses;   /* bits (1 << PM_RAY_..) */
    uint32_t detail; /* the most columns or rows of a picture; 0: there is none */
};

#define BIT(value)    (1ull << (value))
#define BITS(x, y, z) (BIT(x) | BIT(y) | BIT(z))
#define USES_POINT    BITS(PM_RAY_PX, PM_RAY_PY, PM_RAY_PZ)
#define USES_NORMAL   (BITS(PM_RAY_NX, PM_RAY_NY, PM_RAY_NZ) | BIT(PM_RAY_RDOT))
#define USES_RAY      (BITS(PM_RAY_DX, PM_RAY_DY, PM_RAY_DZ) | BIT(PM_RAY_RDOT))

static uint32_t greater(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint64_t uses_of(const pm_world *world, pm_function function)
{
    return function == PM_NO_FUNCTION
               ? 0
               : pm_function_uses(pm_assets_language(world->assets), function);
}

static uint32_t detail_of(const pm_world *world, const struct pm_modifier *m)
{
    uint32_t most = 0;
    for (uint32_t k = 0; m->assets && k < m->string_count; k++) {
        if (m->assets[k] == PM_NO_ASSET)
            continue;
        const pm_asset *asset = pm_assets_at(world->assets, m->assets[k]);
        if (asset->kind != PM_ASSET_PICTURE)
            continue;
        most = greater(most, pm_picture_width(asset->picture));
        most = greater(most, pm_picture_height(asset->picture));
    }
    return most;
}

/* The depth is bounded by PM_MODIFIERS_MAX, the work by PM_MODIFIERS_ASKED_MAX. */
static void add_traits(const pm_world *world, const struct pm_texture *list,
                       struct traits *traits)
{
    for (; list; list = list->next) {
        const struct pm_modifier *m = &list->modifier;
        traits->uses |= uses_of(world, m->expressions) | uses_of(world, m->functions);
        traits->uses |= m->ink ? USES_POINT : 0;
        traits->detail = greater(traits->detail, detail_of(world, m));
        for (int i = 0; i < 2; i++)
            add_traits(world, list->components[i], traits);
    }
}

/* Whether radiance differs between places of a lamp, in one direction. */
static bool differs_by_place(const struct traits *traits, const struct pm_shape *shape)
{
    uint64_t place = USES_POINT | (pm_shape_is_planar(shape) ? 0 : USES_NORMAL);
    return traits->uses & place;
}

/* ---- tables ---- */

struct look {
    const pm_world *world;
    const struct pm_light *light;
    struct traits traits;
    int probes;            /* a lamp's places that are looked at for each direction */
    pm_hit places[PROBES]; /* typical ones of a flat lamp */
    double areas[PROBES];
};

static double probe_u(int i)
{
    return .25 + .5 * (i & 1);
}

static double probe_v(int i)
{
    return .25 + .5 * (i >> 1);
}

static double shine(const struct look *l, const pm_hit *hit, pm_vec3 direction)
{
    return pm_rgb_mean(pm_lights_shine(l->world, hit, direction));
}

static double shine_of_sky(const void *context, pm_vec3 direction)
{
    const struct look *l = context;
    return pm_rgb_mean(pm_lights_shine_far(l->world, l->light->distant, direction));
}

static double shine_of_ball(const void *context, pm_vec3 direction)
{
    const struct look *l = context;
    double sum = 0;
    for (int i = 0; i < l->probes; i++) {
        pm_hit hit = place_on_ball(l->world, l->light, direction, probe_u(i), probe_v(i));
        sum += shine(l, &hit, direction);
    }
    return sum;
}

static double shine_of_flat(const void *context, pm_vec3 direction)
{
    const struct look *l = context;
    double cosine = pm_vec3_dot(direction, l->places[0].normal), sum = 0;
    for (int i = 0; i < l->probes && cosine > 0; i++)
        sum += l->areas[i] * shine(l, &l->places[i], direction);
    return cosine * sum;
}

static double shine_of_place(const void *context, double u, double v)
{
    const struct look *l = context;
    const struct pm_material *m = &l->world->materials[l->light->material];
    double area, weight, sum = 0;
    pm_hit hit = pm_light_draw_place(l->world, l->light, u, v, &area);
    for (int i = 0; i < PROBES; i++) {
        pm_vec3 w = pm_lights_direction(m, hit.normal, probe_u(i), probe_v(i), &weight);
        sum += weight * shine(l, &hit, w);
    }
    return sum;
}

/* The greatest power of two up to `wanted` whose square of looks is within `evaluations`. */
static uint32_t detail_for(uint32_t wanted, size_t evaluations)
{
    uint32_t detail = 2;
    while (2 * detail <= wanted && 4 * (size_t)detail * detail <= evaluations)
        detail *= 2;
    return detail;
}

static pm_status tabulate_sky(pm_world *world, const struct look *look, size_t evaluations,
                              struct pm_light_pattern *pattern, pm_error *err)
{
    const struct pm_distant *source = &world->distants[look->light->distant];
    uint32_t wanted = greater(SKY_DETAIL, look->traits.detail);
    const struct pm_light_directions directions = {shine_of_sky, look,
                                                   detail_for(wanted, evaluations)};
    return pm_light_beam_build(&directions, source->direction, source->versine, &world->arena,
                               &pattern->beam, err);
}

static pm_status tabulate_ball(pm_world *world, const struct look *look, size_t evaluations,
                               struct pm_light_pattern *pattern, pm_error *err)
{
    const struct pm_material *m = &world->materials[look->light->material];
    bool spot = m->type == PM_SPOTLIGHT;
    const struct pm_light_directions directions = {
        shine_of_ball, look, detail_for(SKY_DETAIL, evaluations / (size_t)look->probes)};
    return pm_light_beam_build(&directions, spot ? m->aim : (pm_vec3){0, 0, 1},
                               spot ? m->versine : 2, &world->arena, &pattern->beam, err);
}

/* A flat lamp's directions, seen from places that its table of places picks. */
static pm_status tabulate_flat(pm_world *world, struct look *look, size_t evaluations,
                               struct pm_light_pattern *pattern, pm_error *err)
{
    const struct pm_material *m = &world->materials[look->light->material];
    bool spot = m->type == PM_SPOTLIGHT;
    for (int i = 0; i < PROBES; i++)
        look->places[i] =
            pm_light_draw_place(world, look->light, probe_u(i), probe_v(i), &look->areas[i]);
    const struct pm_light_directions directions = {
        shine_of_flat, look, detail_for(LAMP_DETAIL, evaluations / (size_t)look->probes)};
    return pm_light_beam_build(&directions, spot ? m->aim : look->places[0].normal,
                               spot ? m->versine : 1, &world->arena, &pattern->beam, err);
}

static pm_status tabulate_places(pm_world *world, const struct look *look, size_t evaluations,
                                 struct pm_light_pattern *pattern, pm_error *err)
{
    uint32_t wanted = greater(LAMP_DETAIL, look->traits.detail);
    wanted = wanted < PLACE_DETAIL_MAX ? wanted : (uint32_t)PLACE_DETAIL_MAX;
    const struct pm_light_function places = {shine_of_place, look,
                                             detail_for(wanted, evaluations / PROBES)};
    struct pm_light_table *table;
    pm_status status = pm_light_table_build(&places, &world->arena, &table, err);
    if (!status)
        pattern->places = table;
    return status;
}

/* A ball that differs by place alone is drawn by its places, and by the cosine. */
static pm_status tabulate_lamp(pm_world *world, struct look *look, size_t evaluations,
                               struct pm_light_pattern *pattern, pm_error *err)
{
    const struct pm_shape *shape = shape_of(world, look->light);
    bool by_place = differs_by_place(&look->traits, shape);
    bool by_direction = look->traits.uses & USES_RAY;
    look->probes = by_place ? PROBES : 1;
    if (by_direction && pm_shape_is_ball(shape))
        return tabulate_ball(world, look, evaluations, pattern, err);
    bool flat = pm_shape_is_planar(shape);
    pm_status status = PM_OK;
    if (by_place || (by_direction && !flat))
        status = tabulate_places(world, look, evaluations, pattern, err);
    if (!status && by_direction && flat)
        status = tabulate_flat(world, look, evaluations, pattern, err);
    return status;
}

static pm_status tabulate(pm_world *world, const struct pm_light *light, size_t evaluations,
                          struct pm_light_pattern *pattern, pm_error *err)
{
    struct look look = {.world = world, .light = light};
    add_traits(world, world->materials[light->material].textures, &look.traits);
    if (light->surface == PM_NO_PRIMITIVE)
        return tabulate_sky(world, &look, evaluations, pattern, err);
    return tabulate_lamp(world, &look, evaluations, pattern, err);
}

/* ---- power ---- */

static pm_rgb finite_part(pm_rgb c)
{
    return (pm_rgb){isfinite(c.r) ? c.r : 0, isfinite(c.g) ? c.g : 0, isfinite(c.b) ? c.b : 0};
}

static pm_rgb sample_power(const pm_world *world, const struct pm_light *light,
                           const double u[4])
{
    if (light->surface != PM_NO_PRIMITIVE) {
        struct pm_light_draw draw;
        pm_light_draw_leaving(world, light, u, &draw);
        return pm_rgb_scale(pm_lights_shine(world, &draw.hit, draw.direction), draw.weight);
    }
    double solid_angle, radius = world->lights->radius;
    pm_vec3 direction = pm_light_draw_distant(world, light, u[2], u[3], &solid_angle);
    return pm_rgb_scale(pm_lights_shine_far(world, light->distant, direction),
                        solid_angle * PM_PI * radius * radius);
}

/* By the emission's own draws, whose weights vary little. */
static pm_rgb integrate_power(const pm_world *world, const struct pm_light *light,
                              size_t evaluations)
{
    size_t samples = evaluations / PROBES;
    samples = samples > POWER_SAMPLES_MAX ? POWER_SAMPLES_MAX : samples;
    samples = samples < POWER_SAMPLES_MIN ? POWER_SAMPLES_MIN : samples;
    pm_rgb sum = {0, 0, 0};
    for (uint32_t i = 0; i < samples; i++) {
        double u[4];
        for (unsigned d = 0; d < 4; d++)
            u[d] = pm_sobol(i, d, 0);
        sum = pm_rgb_add(sum, finite_part(sample_power(world, light, u)));
    }
    return pm_rgb_scale(sum, 1 / (double)samples);
}

pm_status pm_light_pattern_build(pm_world *world, struct pm_light *light, size_t evaluations,
                                 pm_rgb *power, pm_error *err)
{
    struct pm_light_pattern *pattern = pm_arena_alloc(&world->arena, sizeof *pattern);
    if (!pattern)
        return pm_error_set(err, PM_E_MEMORY, "out of memory for the lights");
    light->pattern = pattern;
    if (light->surface != PM_NO_PRIMITIVE)
        evaluations /= LAMP_SHARE;
    pm_status status =
        evaluations > FEW ? tabulate(world, light, evaluations, pattern, err) : PM_OK;
    if (!status)
        *power = integrate_power(world, light, evaluations);
    return status;
}
