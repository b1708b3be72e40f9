#include "world/survey.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "world/body.h"
#include "world/light.h"
#include "world/lights.h"
#include "world/media.h"
#include "world/shading.h"
#include "world/surface.h"

enum {
    PATHS = 20000,
    EVENTS = 16,        /* a path is followed so far */
    STRAIGHT = 64,      /* passages in a row */
    LAMPS = 2000,       /* that are looked at one by one */
    RAYS_OF_A_LAMP = 32 /* through a grid of places and directions */
};

struct survey {
    const pm_scene *scene;
    const pm_world *world;
    pm_survey *out;
    size_t told[PM_WARNING_KINDS];
    size_t last[PM_WARNING_KINDS]; /* index of the last warning of the kind */
    bool *patterned;               /* [material_count]: already warned of */
    size_t escaped, paths;
    pm_ray first_escape;
};

const char *pm_warning_kind_name(pm_warning_kind kind)
{
    static const char *const names[PM_WARNING_KINDS] = {
        [PM_WARNING_NO_LIGHT] = "no light",
        [PM_WARNING_OPEN] = "open",
        [PM_WARNING_LEAK] = "leak",
        [PM_WARNING_LIGHT_AWAY] = "light away",
        [PM_WARNING_COVERED] = "light covered",
        [PM_WARNING_NOT_FLAT] = "not flat",
        [PM_WARNING_NO_AREA] = "no area",
        [PM_WARNING_PATTERN] = "pattern",
        [PM_WARNING_BRIGHT] = "bright",
        [PM_WARNING_UNIT] = "unit",
    };
    return names[kind];
}

static void warn(struct survey *s, pm_warning_kind kind, const pm_primitive *about,
                 const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Beyond PM_SURVEY_OF_A_KIND they are counted. */
static void warn(struct survey *s, pm_warning_kind kind, const pm_primitive *about,
                 const char *format, ...)
{
    pm_survey *out = s->out;
    if (s->told[kind]++ >= PM_SURVEY_OF_A_KIND || out->warning_count == PM_SURVEY_WARNINGS)
        return;
    s->last[kind] = out->warning_count;
    pm_warning *w = &out->warnings[out->warning_count++];
    va_list args;
    va_start(args, format);
    vsnprintf(w->text, sizeof w->text, format, args);
    va_end(args);
    w->kind = kind;
    if (about) {
        snprintf(w->file, sizeof w->file, "%s", s->scene->files[about->file]);
        w->line = about->line;
        w->column = about->column;
    }
}

static void count_the_rest(struct survey *s)
{
    for (int kind = 0; kind < PM_WARNING_KINDS; kind++) {
        if (s->told[kind] <= PM_SURVEY_OF_A_KIND)
            continue;
        pm_warning *w = &s->out->warnings[s->last[kind]];
        size_t used = strlen(w->text);
        snprintf(w->text + used, sizeof w->text - used, "; and %zu more like this",
                 s->told[kind] - PM_SURVEY_OF_A_KIND);
    }
}

/* The primitive of a surface; NULL for one of an instance. */
static const pm_primitive *primitive_of(const struct survey *s, uint32_t surface)
{
    if (surface >= s->world->shape_count)
        return NULL;
    return &s->scene->primitives[s->world->shapes[surface].primitive];
}

static const char *name_of(const struct survey *s, uint32_t surface)
{
    const pm_primitive *p = primitive_of(s, surface);
    return p ? p->name : "an instance";
}

/* ---- what there is ---- */

static void count_primitives(struct survey *s)
{
    const pm_scene *scene = s->scene;
    for (size_t i = 0; i < scene->main_count; i++)
        s->out->counts[scene->primitives[i].type]++;
    s->out->in_prototypes = scene->count - scene->main_count;
    for (size_t i = 0; i < s->world->material_count; i++) {
        const struct pm_material *m = &s->world->materials[i];
        s->out->media += m->bounds_volume && pm_rgb_max(m->extinction) > 0;
    }
}

static void describe_light(const struct survey *s, const struct pm_light *light,
                           pm_survey_light *out)
{
    const pm_world *world = s->world;
    uint32_t index = light->surface != PM_NO_PRIMITIVE
                         ? world->shapes[light->surface].primitive
                         : world->distants[light->distant].primitive;
    const pm_primitive *p = &s->scene->primitives[index];
    pm_rgb power = pm_light_total_power(world);
    const char *material = p->modifier >= 0 ? s->scene->primitives[p->modifier].name : "";
    snprintf(out->name, sizeof out->name, "%s", p->name);
    snprintf(out->material, sizeof out->material, "%s", material);
    out->type = p->type;
    out->power = light->chance * pm_rgb_mean(power) * world->scale * world->scale;
}

/* The strongest, the first of equal ones. */
static void list_lights(struct survey *s)
{
    const struct pm_lights *lights = s->world->lights;
    pm_survey *out = s->out;
    for (size_t i = 0; i < lights->count; i++) {
        pm_survey_light light;
        size_t at = out->light_count;
        double power = lights->lights[i].chance * pm_rgb_mean(pm_light_total_power(s->world)) *
                       s->world->scale * s->world->scale;
        while (at > 0 && out->lights[at - 1].power < power)
            at--;
        if (at == PM_SURVEY_LIGHTS)
            continue;
        describe_light(s, &lights->lights[i], &light);
        out->light_count += out->light_count < PM_SURVEY_LIGHTS;
        memmove(&out->lights[at + 1], &out->lights[at],
                (out->light_count - 1 - at) * sizeof *out->lights);
        out->lights[at] = light;
    }
    if (!lights->count)
        warn(s, PM_WARNING_NO_LIGHT, NULL,
             "nothing gives light, so every picture is black; add a surface or a source of "
             "light or glow");
}

/* ---- what is probably not meant ---- */

/* Vertices farther from the plane than a thousandth of the polygon's size. */
static void check_flatness(struct survey *s)
{
    static const double tolerance = 1e-3;
    const pm_world *world = s->world;
    for (size_t i = 0; i < world->shape_count; i++) {
        const struct pm_shape *shape = &world->shapes[i];
        if (shape->type != PM_POLYGON || !(shape->deviation > tolerance * sqrt(shape->area)))
            continue;
        const pm_primitive *p = primitive_of(s, (uint32_t)i);
        warn(
            s, PM_WARNING_NOT_FLAT, p,
            "the polygon '%.60s' is not flat: a vertex lies %.3g from the plane in which it is "
            "rendered; cut it into triangles",
            p->name, shape->deviation * world->scale);
    }
}

static void check_areas(struct survey *s)
{
    for (size_t i = 0; i < s->scene->count; i++) {
        const pm_primitive *p = &s->scene->primitives[i];
        if (p->empty)
            warn(s, PM_WARNING_NO_AREA, p,
                 "the polygon '%.60s' has no area and is left out; its vertices lie in a line",
                 p->name);
    }
}

/* White paint reflects 0.85 to 0.9. Metals and mirrors may have more. */
static void check_reflectances(struct survey *s)
{
    static const double most = 0.92;
    for (size_t i = 0; i < s->scene->main_count; i++) {
        const pm_primitive *p = &s->scene->primitives[i];
        if (p->type != PM_PLASTIC || p->real_count < 3)
            continue;
        double y = pm_rgb_mean((pm_rgb){p->reals[0], p->reals[1], p->reals[2]});
        if (y > most)
            warn(s, PM_WARNING_BRIGHT, p,
                 "'%.60s' reflects %.0f %% of all light; white paint reflects at most 90 %%, "
                 "and "
                 "light stays long in a room that is brighter",
                 p->name, 100 * y);
    }
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Rooms and furniture are made of pieces of some metres. */
static pm_status check_unit(struct survey *s, pm_error *err)
{
    const pm_world *world = s->world;
    pm_world_info info;
    pm_world_info_get(world, &info);
    pm_vec3 size = pm_vec3_sub(info.high, info.low);
    double extent = fmax(size.x, fmax(size.y, size.z));
    if (!world->shape_count)
        return PM_OK;
    double *sizes = calloc(world->shape_count, sizeof *sizes);
    if (!sizes)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory to survey the scene");
    for (size_t i = 0; i < world->shape_count; i++)
        sizes[i] = sqrt(world->shapes[i].area) * world->scale;
    qsort(sizes, world->shape_count, sizeof *sizes, by_value);
    double median = sizes[world->shape_count / 2];
    free(sizes);
    if (extent > 500 && median > 25)
        warn(s, PM_WARNING_UNIT, NULL,
             "the scene is %.4g units wide and half its surfaces are larger than %.3g: that "
             "looks "
             "like millimetres; power is radiance times area, mist is by unit of length: scale "
             "by xform -s .001 if metres are meant",
             extent, median);
    return PM_OK;
}

/* ---- lamps, one by one ---- */

/* The place and the direction of ray i of a lamp: points of Halton's sequence. */
static double radical_inverse(unsigned i, unsigned base)
{
    double value = 0, digit = 1;
    for (; i; i /= base) {
        digit /= base;
        value += digit * (i % base);
    }
    return value;
}

static bool emit_from(const struct survey *s, size_t light, unsigned i, pm_emission *out)
{
    const double *cumulative = s->world->lights->cumulative;
    double before = light ? cumulative[light - 1] : 0;
    const double u[5] = {(before + cumulative[light]) / 2, radical_inverse(i, 2),
                         radical_inverse(i, 3), radical_inverse(i, 5), radical_inverse(i, 7)};
    return pm_light_emit(s->world, u, out);
}

static void check_lamp(struct survey *s, size_t index)
{
    const pm_world *world = s->world;
    const struct pm_light *light = &world->lights->lights[index];
    const pm_primitive *p = primitive_of(s, light->surface);
    double near = 1e-3 * sqrt(world->shapes[light->surface].area);
    unsigned rays = 0, escaped = 0, covered = 0;
    uint32_t cover = PM_NO_PRIMITIVE;
    for (unsigned i = 1; i <= RAYS_OF_A_LAMP; i++) {
        pm_emission e;
        pm_hit hit;
        if (!emit_from(s, index, i, &e) || e.from != light->surface)
            continue;
        rays++;
        if (!pm_world_intersect(world, &(pm_ray){e.origin, e.direction, INFINITY, e.from},
                                &hit)) {
            escaped++;
        } else if (hit.t * fabs(pm_vec3_dot(hit.normal, e.direction)) < near &&
                   !world->materials[hit.material].straight) {
            covered++;
            cover = hit.surface;
        }
    }
    if (rays && escaped == rays)
        warn(s, PM_WARNING_LIGHT_AWAY, p,
             "all light of '%.60s' leaves the scene without meeting anything; its front is "
             "where "
             "its vertices run counter-clockwise: does it face away?",
             p->name);
    if (rays && covered == rays)
        warn(s, PM_WARNING_COVERED, p,
             "all light of '%.60s' ends at '%.60s' right in front of it; move one of them, or "
             "turn the lamp",
             p->name, name_of(s, cover));
}

static void check_lamps(struct survey *s)
{
    const struct pm_lights *lights = s->world->lights;
    size_t looked_at = 0;
    if (s->world->main->count < 2)
        return;
    for (size_t i = 0; i < lights->count && looked_at < LAMPS; i++) {
        if (lights->lights[i].surface == PM_NO_PRIMITIVE || !(lights->lights[i].chance > 0))
            continue;
        looked_at++;
        check_lamp(s, i);
    }
}

/* ---- paths ---- */

/* Whether a pattern makes more than all light of what the material reflects. */
static void check_pattern(struct survey *s, const pm_hit *hit, pm_vec3 wo)
{
    const struct pm_material *m = &s->world->materials[hit->material];
    if (!m->textures || s->patterned[hit->material] || pm_material_emits(m))
        return;
    struct pm_shading shading;
    pm_shading_init(&shading, s->world, hit, wo, hit->t);
    pm_textures_apply(m, &shading);
    double most = pm_rgb_max(pm_rgb_mul(shading.color, m->color));
    const pm_primitive *p = primitive_of(s, hit->surface);
    if (!p || !(most > 1 + 1e-6))
        return;
    s->patterned[hit->material] = true;
    const pm_primitive *modifier = p->modifier >= 0 ? &s->scene->primitives[p->modifier] : p;
    warn(
        s, PM_WARNING_PATTERN, modifier,
        "the pattern '%.60s' makes its material reflect %.3g times the light that comes; it is "
        "cut at 1 so that no energy is made: darken it",
        modifier->name, most);
}

/* Follows a path whatever is absorbed. True if it leaves the scene. */
static bool follow(struct survey *s, pm_rng *rng, pm_ray *ray)
{
    static const pm_rgb white = {1, 1, 1};
    pm_media media;
    pm_media_at(s->world, ray->origin, &media);
    unsigned events = 0, straight = 0;
    for (uint32_t segment = 1; events < EVENTS && straight < STRAIGHT; segment++) {
        pm_hit hit;
        pm_surface surface;
        pm_scatter scatter;
        pm_rng_bounce(rng, segment);
        if (!pm_world_intersect(s->world, ray, &hit))
            return true;
        pm_vec3 wo = pm_vec3_negate(ray->direction);
        const double u[3] = {pm_rng_uniform(rng), pm_rng_uniform(rng), pm_rng_uniform(rng)};
        check_pattern(s, &hit, wo);
        pm_media_meet(&media, s->world, &hit, ray->direction);
        pm_surface_at(s->world, &hit, wo, &media, &surface);
        pm_surface_sample(&surface, white, u, &scatter);
        if (scatter.event == PM_EVENT_NONE)
            return false;
        if (scatter.event == PM_EVENT_STRAIGHT) {
            straight++;
        } else {
            events++;
            straight = 0;
        }
        if (scatter.transmitted)
            pm_media_cross(&media, s->world, &hit, scatter.wi);
        *ray = (pm_ray){hit.point, scatter.wi, INFINITY, hit.surface};
    }
    return false;
}

static void trace_paths(struct survey *s)
{
    for (uint64_t i = 0; i < PATHS; i++) {
        pm_rng rng;
        pm_emission e;
        double u[5];
        pm_rng_init(&rng, 0, PM_RNG_SURVEY, i);
        for (int k = 0; k < 5; k++)
            u[k] = pm_rng_uniform(&rng);
        if (!pm_light_emit(s->world, u, &e))
            continue;
        bool local = e.from != PM_NO_PRIMITIVE;
        pm_ray ray = {e.origin, e.direction, INFINITY, e.from};
        bool out = follow(s, &rng, &ray);
        s->paths += local;
        if (out && local && !s->escaped++)
            s->first_escape = ray;
    }
}

/* With a sky, light is meant to go in and out. */
static void check_enclosure(struct survey *s)
{
    static const double gap = 0.02;
    pm_survey *out = s->out;
    out->has_paths = s->paths > 0;
    if (!s->paths)
        return;
    out->escaping = (double)s->escaped / (double)s->paths;
    if (!s->escaped || s->world->distant_count)
        return;
    const pm_ray *ray = &s->first_escape;
    pm_vec3 p = pm_world_to_scene(s->world, ray->origin), d = ray->direction;
    const pm_primitive *last = primitive_of(s, ray->from);
    bool leak = out->escaping < gap;
    warn(
        s, leak ? PM_WARNING_LEAK : PM_WARNING_OPEN, last,
        leak
            ? "%.3g %% of the lamps' paths leave the scene through a gap: one from '%.60s' at "
              "%.4g %.4g %.4g towards %.2f %.2f %.2f; do the walls meet there?"
            : "%.3g %% of the lamps' paths leave the scene: one from '%.60s' at %.4g %.4g %.4g "
              "towards %.2f %.2f %.2f; a room needs its walls, floor and ceiling, and there is "
              "no sky",
        100 * out->escaping, name_of(s, ray->from), p.x, p.y, p.z, d.x, d.y, d.z);
}

pm_status pm_survey_make(const pm_scene *scene, const pm_world *world, pm_survey **out,
                         pm_error *err)
{
    struct survey s = {.scene = scene, .world = world};
    s.out = calloc(1, sizeof *s.out);
    s.patterned = calloc(world->material_count + 1, sizeof *s.patterned);
    pm_status st = s.out && s.patterned ? PM_OK
                                        : pm_error_set(err, PM_E_MEMORY,
                                                       "not enough memory to survey the scene");
    if (!st)
        st = check_unit(&s, err);
    if (!st) {
        count_primitives(&s);
        list_lights(&s);
        check_flatness(&s);
        check_areas(&s);
        check_reflectances(&s);
        check_lamps(&s);
        trace_paths(&s);
        check_enclosure(&s);
        count_the_rest(&s);
        *out = s.out;
    } else {
        free(s.out);
    }
    free(s.patterned);
    return st;
}
