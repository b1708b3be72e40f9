#include "world/brdf.h"

#include <stdlib.h>
#include <string.h>

#include "base/maths.h"
#include "base/rng.h"
#include "base/warp.h"
#include "files/data.h"
#include "scene/assets.h"
#include "world/light_table.h"
#include "world/material.h"
#include "world/shading.h"
#include "world/ward.h"

/* ---- values ---- */

static void set_vector(double *out, pm_vec3 v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static pm_vec3 to_own(const pm_brdf *b, pm_vec3 w)
{
    return (pm_vec3){pm_vec3_dot(w, b->axis[0]), pm_vec3_dot(w, b->axis[1]),
                     pm_vec3_dot(w, b->axis[2])};
}

/* Radiance's setbrdfunc (m_brdf.c). */
void pm_brdf_at(const struct pm_material *material, struct pm_shading *shading, pm_vec3 normal,
                bool turned, pm_rgb color, pm_brdf *out)
{
    static const pm_vec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    out->world = shading->world;
    out->material = material;
    for (int i = 0; i < 3; i++)
        out->axis[i] = pm_shading_to_world(shading, &material->modifier, unit[i]);
    out->ray = *pm_shading_ray(shading, &material->modifier);
    double *v = out->ray.value;
    if (turned && v[PM_RAY_RDOT] < 0)
        for (int i = 0; i < 4; i++)
            v[i < 3 ? PM_RAY_NX + i : PM_RAY_RDOT] *= -1;
    set_vector(&v[PM_RAY_NXP], to_own(out, normal));
    v[PM_RAY_RDOTP] = fmin(pm_vec3_dot(normal, shading->wo), 1);
    v[PM_RAY_CRP] = color.r;
    v[PM_RAY_CGP] = color.g;
    v[PM_RAY_CBP] = color.b;
}

static bool has_data(pm_primitive_type type)
{
    return type >= PM_PLASDATA && type <= PM_TRANSDATA;
}

/* The number of the data file among the strings: func datafile funcfile x1 ... */
enum { DATA_STRING = 1 };

/* args[1..4]: the direction and the source's solid angle, which is unknown: 0. args[0]: what
 * the data give. */
static bool look_up(const pm_brdf *b, double args[5])
{
    const struct pm_modifier *m = &b->material->modifier;
    double at[PM_LANGUAGE_TEXTS];
    const pm_language *language = pm_assets_language(b->world->assets);
    if (pm_function_values(language, m->coordinates, &b->ray, args + 1, 4, at))
        return false;
    args[0] = pm_data_value(pm_assets_at(b->world->assets, m->assets[DATA_STRING])->data, at);
    return isfinite(args[0]);
}

/* [1/sr]; sums and products of what is more than this might not be finite. */
static double bounded(double f)
{
    return fmin(fmax(f, 0), 1e12);
}

pm_rgb pm_brdf_value(const pm_brdf *b, pm_vec3 wi)
{
    const struct pm_modifier *m = &b->material->modifier;
    const pm_language *language = pm_assets_language(b->world->assets);
    const pm_rgb black = {0, 0, 0};
    double args[5] = {0}, v[PM_LANGUAGE_TEXTS];
    bool data = has_data(m->type);
    set_vector(args + 1, to_own(b, wi));
    if (data && !look_up(b, args))
        return black;
    if (pm_function_values(language, m->functions, &b->ray, data ? args : args + 1,
                           data ? 5 : 4, v))
        return black;
    if (m->type != PM_BRTDFUNC)
        return pm_rgb_grey(bounded(v[0]));
    return (pm_rgb){bounded(v[0]), bounded(v[1]), bounded(v[2])};
}

/* ---- what is known of a function ---- */

enum {
    AZIMUTHS = 12,
    COSINES = 16,
    FEW_COSINES = 8, /* of functions that are not isotropic */
    DETAIL = 16,
    PLACES = 2, /* surfaces where a function is looked at */
};

/* What comes from one direction. */
struct known {
    const struct pm_light_table *table[2]; /* where it goes, on the near and on the far side */
    pm_rgb albedo[2];
};

struct pm_brdf_table {
    bool isotropic;
    int azimuths, cosines;
    const struct known *known; /* [front or back][cosines][azimuths] */
};

/* The frame that the tables are in: about the normal, x in the plane of wo for an isotropic
 * function, else along the x axis of the function's coordinates. */
static pm_frame frame_of(const pm_brdf *b, bool isotropic, pm_vec3 normal, pm_vec3 wo)
{
    pm_vec3 x = isotropic ? wo : b->axis[0];
    x = pm_vec3_madd(x, -pm_vec3_dot(x, normal), normal);
    if (!(pm_vec3_dot(x, x) > 1e-12))
        return pm_frame_make(normal);
    x = pm_vec3_normalize(x);
    return (pm_frame){x, pm_vec3_cross(normal, x), normal};
}

struct place {
    int low; /* and the next one, cyclic in azimuth */
    double share;
};

static struct place between(double at, int count, bool cyclic)
{
    double low = floor(at);
    if (cyclic)
        return (struct place){((int)low % count + count) % count, at - low};
    if (at <= 0)
        return (struct place){0, 0};
    if (at >= count - 1)
        return (struct place){count - 1, 0};
    return (struct place){(int)low, at - low};
}

/* The first node of the cosines stands for all below it, the last is 1, even steps between;
 * node k of the azimuths is 2 pi k / count. */
#define LEAST_COSINE .002

static double cosine_of(const struct pm_brdf_table *t, int node)
{
    return LEAST_COSINE + (1 - LEAST_COSINE) * node / (t->cosines - 1);
}

static void find(const struct pm_brdf_table *t, pm_vec3 local, struct place *cosine,
                 struct place *azimuth)
{
    double step = (1 - LEAST_COSINE) / (t->cosines - 1);
    *cosine = between((fabs(local.z) - LEAST_COSINE) / step, t->cosines, false);
    *azimuth = (struct place){0, 0};
    if (!t->isotropic)
        *azimuth =
            between(pm_atan2(local.y, local.x) / (2 * PM_PI) * t->azimuths, t->azimuths, true);
}

static const struct known *known_at(const struct pm_brdf_table *t, bool front, int cosine,
                                    int azimuth)
{
    if (cosine == t->cosines)
        cosine--;
    return &t->known[((front ? 0 : t->cosines) + cosine) * t->azimuths + azimuth % t->azimuths];
}

pm_rgb pm_brdf_albedo(const pm_brdf *b, pm_vec3 normal, pm_vec3 wo, bool front, bool far)
{
    const struct pm_brdf_table *t = b->material->brdf;
    pm_frame frame = frame_of(b, t->isotropic, normal, wo);
    struct place c, a;
    pm_rgb sum = {0, 0, 0};
    find(t, pm_frame_to_local(&frame, wo), &c, &a);
    for (int i = 0; i < 4; i++) {
        double share = (i & 1 ? c.share : 1 - c.share) * (i & 2 ? a.share : 1 - a.share);
        if (share > 0)
            sum = pm_rgb_madd(
                sum, share, known_at(t, front, c.low + (i & 1), a.low + (i >> 1))->albedo[far]);
    }
    return sum;
}

/* ---- sampling ---- */

/* Shares of the ways to draw: by the table, about the mirrored or the straight direction (lobes
 * between the table's nodes), by the cosine. */
#define BY_TABLE  .5
#define BY_MIRROR .25
#define BY_COSINE (1 - BY_TABLE - BY_MIRROR)
#define SHARPNESS .15 /* Ward's alpha */

static const struct pm_light_table *table_for(const pm_brdf *b, const pm_frame *frame,
                                              pm_vec3 wo, bool front, bool far)
{
    const struct pm_brdf_table *t = b->material->brdf;
    struct place c, a;
    find(t, pm_frame_to_local(frame, wo), &c, &a);
    return known_at(t, front, c.low + (c.share > .5), a.low + (a.share > .5))->table[far];
}

pm_vec3 pm_brdf_sample(const pm_brdf *b, pm_vec3 normal, pm_vec3 wo, bool front, bool far,
                       double u, double v)
{
    pm_frame frame = frame_of(b, b->material->brdf->isotropic, normal, wo);
    const struct pm_light_table *table = table_for(b, &frame, wo, front, far);
    pm_vec3 wi;
    if (u < BY_MIRROR) {
        u /= BY_MIRROR;
        if (far)
            pm_ward_transmit_sample(normal, wo, SHARPNESS, u, v, &wi);
        else
            pm_ward_reflect_sample(normal, wo, SHARPNESS, u, v, &wi);
        return wi;
    }
    bool steered = u >= BY_MIRROR + BY_COSINE;
    u = steered ? (u - BY_MIRROR - BY_COSINE) / BY_TABLE : (u - BY_MIRROR) / BY_COSINE;
    if (steered && table)
        pm_light_table_warp(table, &u, &v);
    wi = pm_warp_cosine(u, v);
    wi.z = far ? -wi.z : wi.z;
    return pm_frame_to_world(&frame, wi);
}

double pm_brdf_pdf(const pm_brdf *b, pm_vec3 normal, pm_vec3 wo, bool front, bool far,
                   pm_vec3 wi)
{
    pm_frame frame = frame_of(b, b->material->brdf->isotropic, normal, wo);
    const struct pm_light_table *table = table_for(b, &frame, wo, front, far);
    pm_vec3 local = pm_frame_to_local(&frame, wi);
    if ((local.z < 0) != far)
        return 0;
    double u, v, density = 1;
    if (table) {
        pm_warp_disc_inverse(local.x, local.y, &u, &v);
        density = pm_light_table_density(table, u, v);
    }
    double mirror = far ? pm_ward_transmit_pdf(wo, wi, SHARPNESS)
                        : pm_ward_reflect_pdf(normal, wo, wi, SHARPNESS);
    return (BY_TABLE * density + BY_COSINE) * fabs(local.z) / PM_PI + BY_MIRROR * mirror;
}

/* ---- looking at a function ---- */

struct builder {
    pm_world *world;
    struct pm_material *material;
    pm_hit place[PLACES];
    int places;
    pm_error *err;
};

static void look_from(const struct builder *b, int place, pm_vec3 wo, pm_brdf *out)
{
    const pm_hit *hit = &b->place[place];
    struct pm_shading shading;
    bool front = pm_vec3_dot(wo, hit->normal) > 0;
    pm_shading_init(&shading, b->world, hit, wo, hit->t);
    pm_brdf_at(b->material, &shading, front ? hit->normal : pm_vec3_negate(hit->normal),
               b->material->type != PM_BRTDFUNC, b->material->color, out);
}

static pm_vec3 turned(const pm_frame *frame, pm_vec3 local, double angle)
{
    double sine, cosine;
    pm_sincos(angle, &sine, &cosine);
    return pm_frame_to_world(frame, (pm_vec3){local.x * cosine - local.y * sine,
                                              local.x * sine + local.y * cosine, local.z});
}

/* Whether turning both directions about the normal changes nothing, by trial. */
static bool is_isotropic(const struct builder *b)
{
    enum { TRIALS = 24 };
    pm_rng rng;
    pm_rng_init(&rng, 0, PM_RNG_SCRAMBLE, 0);
    for (int i = 0; i < TRIALS; i++) {
        double u[5];
        for (int k = 0; k < 5; k++)
            u[k] = pm_rng_uniform(&rng);
        pm_frame frame = pm_frame_make(b->place[i % b->places].normal);
        pm_vec3 wo = pm_warp_sphere(u[0], u[1]), wi = pm_warp_sphere(u[2], u[3]);
        pm_brdf brdf[2];
        pm_rgb f[2];
        for (int k = 0; k < 2; k++) {
            double angle = 2 * PM_PI * u[4] * k;
            look_from(b, i % b->places, turned(&frame, wo, angle), &brdf[k]);
            f[k] = pm_brdf_value(&brdf[k], turned(&frame, wi, angle));
        }
        if (!(fabs(pm_rgb_mean(f[0]) - pm_rgb_mean(f[1])) <=
              1e-6 * (pm_rgb_mean(f[0]) + pm_rgb_mean(f[1]))))
            return false;
    }
    return true;
}

/* One direction seen from all places. */
struct view {
    int places;
    pm_brdf brdf[PLACES];
    pm_frame frame[PLACES];
    bool far;
};

/* pi times the largest f: its mean over the square is the albedo, or more. */
static pm_rgb seen_color(const void *context, double u, double v)
{
    const struct view *view = context;
    pm_rgb most = {0, 0, 0};
    pm_vec3 local = pm_warp_cosine(u, v);
    local.z = view->far ? -local.z : local.z;
    for (int i = 0; i < view->places; i++) {
        pm_rgb f = pm_brdf_value(&view->brdf[i], pm_frame_to_world(&view->frame[i], local));
        most = (pm_rgb){fmax(most.r, f.r), fmax(most.g, f.g), fmax(most.b, f.b)};
    }
    return pm_rgb_scale(most, PM_PI);
}

static double seen(const void *context, double u, double v)
{
    return pm_rgb_mean(seen_color(context, u, v));
}

/* Its mean over the square, from points that follow the table: right for narrow peaks. */
static pm_rgb mean_by_table(const struct view *view, const struct pm_light_table *table)
{
    enum { STEPS = 24 };
    pm_rgb sum = {0, 0, 0};
    for (int i = 0; i < STEPS * STEPS; i++) {
        double u = (i % STEPS + .5) / STEPS, v = (i / STEPS + .5) / STEPS;
        double density = pm_light_table_warp(table, &u, &v);
        sum = pm_rgb_madd(sum, 1 / (density * STEPS * STEPS), seen_color(view, u, v));
    }
    return sum;
}

/* The same by Simpson's rule in the polar angle, whose ends bring nothing, and even steps of
 * azimuth: exact enough for what is smooth. */
static pm_rgb mean_by_angles(const struct view *view)
{
    enum { RINGS = 36, SECTORS = 48 };
    pm_rgb sum = {0, 0, 0};
    for (int i = SECTORS; i < RINGS * SECTORS; i++) {
        double u, v, x, y, sine, cosine, step = PM_PI / (2 * RINGS);
        pm_sincos(step * (i / SECTORS), &sine, &cosine);
        pm_sincos(2 * PM_PI * (i % SECTORS + .5) / SECTORS, &y, &x);
        pm_warp_disc_inverse(sine * x, sine * y, &u, &v);
        double weight = (i / SECTORS % 2 ? 4 : 2) * step / 3 * sine * cosine * 2 / SECTORS;
        sum = pm_rgb_madd(sum, weight, seen_color(view, u, v));
    }
    return sum;
}

/* Where both agree the function is smooth; else the larger is nearer to the truth. */
static double albedo_from(double by_angles, double by_table)
{
    bool smooth = fabs(by_angles - by_table) < .05 * by_table;
    return smooth ? by_angles : fmax(by_angles, by_table);
}

static pm_rgb albedo_seen(const struct view *view, const struct pm_light_table *table)
{
    pm_rgb a = mean_by_angles(view), t = mean_by_table(view, table);
    return (pm_rgb){albedo_from(a.r, t.r), albedo_from(a.g, t.g), albedo_from(a.b, t.b)};
}

static void view_from(const struct builder *b, const struct pm_brdf_table *t, bool front,
                      double cosine, double azimuth, struct view *out)
{
    double sine = sqrt(1 - cosine * cosine), x, y;
    pm_sincos(azimuth, &y, &x);
    out->places = b->places;
    for (int i = 0; i < b->places; i++) {
        pm_vec3 n = b->place[i].normal;
        n = front ? n : pm_vec3_negate(n);
        look_from(b, i, n, &out->brdf[i]); /* for its axes */
        pm_frame frame = frame_of(&out->brdf[i], false, n, n);
        pm_vec3 wo = pm_frame_to_world(&frame, (pm_vec3){sine * x, sine * y, cosine});
        look_from(b, i, wo, &out->brdf[i]);
        out->frame[i] = frame_of(&out->brdf[i], t->isotropic, n, wo);
    }
}

static bool scatters_to(pm_primitive_type type, bool far)
{
    return !far || type == PM_TRANSFUNC || type == PM_TRANSDATA || type == PM_BRTDFUNC;
}

static pm_status know(const struct builder *b, const struct pm_brdf_table *t, bool front,
                      double cosine, double azimuth, struct known *out)
{
    struct view view;
    pm_status status = PM_OK;
    view_from(b, t, front, cosine, azimuth, &view);
    for (int far = 0; far < 2 && !status; far++) {
        out->table[far] = NULL;
        out->albedo[far] = (pm_rgb){0, 0, 0};
        if (!scatters_to(b->material->type, far))
            continue;
        struct pm_light_table *table;
        const struct pm_light_function function = {seen, &view, DETAIL};
        view.far = far;
        status = pm_light_table_build(&function, &b->world->arena, &table, b->err);
        if (status)
            break;
        out->table[far] = table;
        out->albedo[far] = albedo_seen(&view, table);
    }
    return status;
}

static pm_status build(const struct builder *b)
{
    struct pm_brdf_table *t = pm_arena_alloc(&b->world->arena, sizeof *t);
    int sides = b->material->type == PM_BRTDFUNC ? 2 : 1;
    if (!t)
        return pm_error_set(b->err, PM_E_MEMORY, "out of memory for materials");
    t->isotropic = is_isotropic(b);
    t->azimuths = t->isotropic ? 1 : AZIMUTHS;
    t->cosines = t->isotropic ? COSINES : FEW_COSINES;
    struct known *known =
        pm_arena_array(&b->world->arena, (size_t)(2 * t->cosines * t->azimuths), sizeof *known);
    if (!known)
        return pm_error_set(b->err, PM_E_MEMORY, "out of memory for materials");
    int count = t->cosines * t->azimuths;
    for (int i = 0; i < count * sides; i++) {
        double cosine = cosine_of(t, i / t->azimuths % t->cosines);
        double azimuth = 2 * PM_PI * (i % t->azimuths) / t->azimuths;
        pm_status status = know(b, t, i < count, cosine, azimuth, &known[i]);
        if (status)
            return status;
    }
    if (sides == 1) /* both sides are alike */
        memcpy(known + count, known, (size_t)count * sizeof *known);
    t->known = known;
    b->material->brdf = t;
    return PM_OK;
}

/* ---- all of them ---- */

/* A place on the shape is one of each function material that it may show: as such, as an
 * alternate, within mixtures. Recursion is bounded by PM_MODIFIERS_MAX. */
static void add_place(struct builder *builders, const pm_world *world, uint32_t material,
                      const pm_hit *hit)
{
    if (material == PM_NO_PRIMITIVE)
        return;
    struct builder *b = &builders[material];
    const struct pm_material *m = &world->materials[material];
    if (b->places == PLACES)
        return;
    b->place[b->places++] = *hit;
    add_place(builders, world, m->alternate, hit);
    add_place(builders, world, m->components[0], hit);
    add_place(builders, world, m->components[1], hit);
}

static void find_places(struct builder *builders, const pm_world *world)
{
    for (size_t i = 0; i < world->shape_count; i++) {
        const struct pm_shape *shape = &world->shapes[i];
        pm_hit hit = {.t = 1, .surface = (uint32_t)i, .material = shape->material};
        pm_shape_sample(shape, .5, .5, &hit.point, &hit.normal);
        add_place(builders, world, shape->material, &hit);
    }
}

pm_status pm_brdf_tables_build(pm_world *world, pm_error *err)
{
    size_t wanted = 0;
    for (size_t i = 0; i < world->material_count; i++)
        wanted += pm_brdf_is(world->materials[i].type);
    if (!wanted)
        return PM_OK;
    struct builder *builders = calloc(world->material_count, sizeof *builders);
    if (!builders)
        return pm_error_set(err, PM_E_MEMORY, "out of memory for materials");
    find_places(builders, world);
    pm_status status = PM_OK;
    for (size_t i = 0; i < world->material_count && !status; i++) {
        struct builder *b = &builders[i];
        *b = (struct builder){
            world, &world->materials[i], {b->place[0], b->place[1]}, b->places, err};
        if (!pm_brdf_is(b->material->type))
            continue;
        if (!b->places) /* on surfaces of instances alone */
            b->place[b->places++] =
                (pm_hit){.t = 1, .normal = {0, 0, 1}, .surface = PM_NO_PRIMITIVE};
        status = build(b);
    }
    free(builders);
    return status;
}
