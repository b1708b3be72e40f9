#include "world/openings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/maths.h"
#include "base/sobol.h"
#include "base/warp.h"
#include "world/body.h"
#include "world/lights.h"
#include "world/placed.h"

enum {
    PLACES = 512,       /* in space, that are looked around from */
    SIGHTS = 64,        /* lines of sight from each */
    WAYS_OUT_MAX = 256, /* lines that are followed */
    HALVINGS = 7,
    PASSAGES_MAX = 64, /* surfaces in a row that let light through */
    BALLS_MAX = 16
};

#define CLOSED     .86 /* share of the lines of sight that end, inside */
#define OPEN       .8  /* in an opening, where half of them lead out to ground and sky */
#define INSIDE     .04 /* share of the places that are inside, at least */
#define AIMED      .5  /* share of the distant photons that are aimed */
#define NARROW     .3  /* less room than this share of the mean is a gap */
#define LARGE      .125
#define STRAY      .02 /* a ball with fewer of the places found holds none */
#define LEAST_BALL .005
#define WIDER      1.15 /* than what holds the places found: they are inexact */

struct ball {
    pm_vec3 center;
    double radius, weight;
    size_t first, count; /* of the places that it holds */
};

struct pm_openings {
    const pm_world *world;
    unsigned count;
    struct ball balls[BALLS_MAX];
    double ends[BALLS_MAX]; /* cumulative weights */
    char note[120];
};

/* ---- looking around ---- */

static bool lets_through(const struct pm_material *m)
{
    switch (m->type) {
    case PM_GLASS:
    case PM_DIELECTRIC:
    case PM_INTERFACE:
    case PM_TRANS:
    case PM_TRANS2:
    case PM_TRANSFUNC:
    case PM_TRANSDATA:
    case PM_BRTDFUNC:
    case PM_BSDF:
    case PM_ABSDF:
    case PM_PRISM1:
    case PM_PRISM2:
    case PM_MIST:
    case PM_ANTIMATTER:
        return true;
    default:
        return m->straight;
    }
}

/* `last`: where it ends, or where it passes the last surface on its way, if it does. */
static bool gets_out_by(const pm_world *world, pm_vec3 point, pm_vec3 direction, pm_vec3 *last,
                        bool *passes)
{
    *passes = false;
    *last = point;
    pm_ray ray = {point, direction, INFINITY, PM_NO_PRIMITIVE};
    for (int i = 0; i < PASSAGES_MAX; i++) {
        pm_hit hit;
        if (!pm_world_intersect(world, &ray, &hit))
            return true;
        *last = hit.point;
        if (!lets_through(&world->materials[hit.material]))
            return false;
        *passes = true;
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    return false;
}

static bool gets_out(const pm_world *world, pm_vec3 point, pm_vec3 direction)
{
    pm_vec3 last;
    bool passes;
    return gets_out_by(world, point, direction, &last, &passes);
}

/* Evenly over the sphere. */
static pm_vec3 sight(uint32_t i, uint32_t count)
{
    return pm_warp_sphere((i + .5) / count, fmod(i * .6180339887498949, 1));
}

struct place {
    pm_vec3 point;
    double closed; /* share of the lines of sight that end */
    double room;   /* harmonic mean of their lengths: short in a gap, however long that is */
};

static struct place look_around(const pm_world *world, pm_vec3 point)
{
    struct place place = {.point = point};
    double inverse = 0;
    int ended = 0;
    for (uint32_t i = 0; i < SIGHTS; i++) {
        pm_vec3 end;
        bool passes;
        if (gets_out_by(world, point, sight(i, SIGHTS), &end, &passes))
            continue;
        inverse += 1 / (pm_vec3_distance(point, end) + 0x1p-40);
        ended++;
    }
    place.closed = (double)ended / SIGHTS;
    place.room = ended ? ended / inverse : 0;
    return place;
}

/* In the middle of a free way between two surfaces. */
static bool draw_place(const pm_world *world, uint32_t i, pm_vec3 *out)
{
    uint32_t hash = pm_hash_u32(i, 3), side = pm_hash_u32(i, 4);
    uint32_t surface = (uint32_t)((double)hash * 0x1p-32 * (double)world->main->count);
    pm_vec3 point, normal;
    pm_hit hit;
    pm_placed_sample(world, surface, pm_sobol(i, 0, 1), pm_sobol(i, 1, 1), &point, &normal);
    pm_frame frame = pm_frame_make(side & 1 ? normal : pm_vec3_negate(normal));
    pm_vec3 direction =
        pm_frame_to_world(&frame, pm_warp_cosine(pm_sobol(i, 2, 1), pm_sobol(i, 3, 1)));
    pm_ray ray = {point, direction, INFINITY, surface};
    if (!pm_world_intersect(world, &ray, &hit))
        return false;
    *out = pm_vec3_madd(point, hit.t / 2, direction);
    return true;
}

static bool is_bright(const pm_world *world, pm_vec3 direction)
{
    struct pm_sky sky = pm_lights_sky(world, direction, false);
    return !pm_rgb_is_black(sky.lit ? sky.lights : sky.glows);
}

/* ---- ways out ---- */

struct search {
    const pm_world *world;
    size_t looked, inside;       /* places */
    struct place places[PLACES]; /* that are inside */
    size_t count;
    pm_vec3 at[WAYS_OUT_MAX]; /* openings */
};

/* The place of the opening: a pane, or between an inside place and where the scene ends. */
static pm_vec3 narrow_down(const struct search *s, pm_vec3 point, pm_vec3 direction)
{
    const struct pm_lights *l = s->world->lights;
    pm_vec3 pane, off = pm_vec3_sub(l->center, point);
    bool passes;
    if (gets_out_by(s->world, point, direction, &pane, &passes) && passes)
        return pane;
    double along = pm_vec3_dot(off, direction);
    double square = l->radius * l->radius - pm_vec3_dot(off, off) + along * along;
    double in = 0, out = along + sqrt(fmax(square, 0));
    for (int i = 0; i < HALVINGS; i++) {
        double t = (in + out) / 2;
        bool is_inside = look_around(s->world, pm_vec3_madd(point, t, direction)).closed > OPEN;
        *(is_inside ? &in : &out) = t;
    }
    return pm_vec3_madd(point, (in + out) / 2, direction);
}

static void find_inside(struct search *s)
{
    for (uint32_t i = 0; i < PLACES; i++) {
        pm_vec3 point;
        if (!draw_place(s->world, i, &point))
            continue;
        s->places[s->inside] = look_around(s->world, point);
        s->inside += s->places[s->inside].closed >= CLOSED;
        s->looked++;
    }
}

static void look_out(struct search *s, pm_vec3 point)
{
    for (uint32_t i = 0; i < SIGHTS && s->count < WAYS_OUT_MAX; i++) {
        pm_vec3 direction = sight(i, SIGHTS);
        if (gets_out(s->world, point, direction) && is_bright(s->world, direction))
            s->at[s->count++] = narrow_down(s, point, direction);
    }
}

static void find_ways_out(struct search *s)
{
    double mean = 0;
    for (size_t i = 0; i < s->inside; i++)
        mean += s->places[i].room / (double)s->inside;
    for (size_t i = 0; i < s->inside; i++)
        if (s->places[i].room > NARROW * mean)
            look_out(s, s->places[i].point);
}

/* ---- balls ---- */

static double part(pm_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static void bounds_of(const pm_vec3 *at, size_t count, pm_vec3 *low, pm_vec3 *high)
{
    *low = *high = at[0];
    for (size_t i = 1; i < count; i++) {
        *low = pm_vec3_min(*low, at[i]);
        *high = pm_vec3_max(*high, at[i]);
    }
}

static struct ball ball_about(const pm_vec3 *at, size_t first, size_t count)
{
    pm_vec3 low, high;
    bounds_of(at + first, count, &low, &high);
    struct ball ball = {pm_vec3_scale(pm_vec3_add(low, high), .5), 0, 0, first, count};
    for (size_t i = first; i < first + count; i++)
        ball.radius = fmax(ball.radius, pm_vec3_distance(at[i], ball.center));
    ball.radius = fmax(ball.radius * WIDER, LEAST_BALL);
    return ball;
}

/* Places below the middle of the longest side of their box come first. */
static size_t divide(pm_vec3 *at, size_t count)
{
    pm_vec3 low, high;
    bounds_of(at, count, &low, &high);
    pm_vec3 size = pm_vec3_sub(high, low);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    double middle = (part(low, axis) + part(high, axis)) / 2;
    size_t below = 0;
    for (size_t i = 0; i < count; i++)
        if (part(at[i], axis) < middle) {
            pm_vec3 other = at[below];
            at[below++] = at[i];
            at[i] = other;
        }
    return below;
}

/* Divides a ball where that makes the discs that the sky sees smaller. */
static bool divide_ball(pm_openings *o, pm_vec3 *at, unsigned index)
{
    struct ball *ball = &o->balls[index];
    size_t below = divide(at + ball->first, ball->count);
    if (!below || below == ball->count)
        return false;
    struct ball a = ball_about(at, ball->first, below);
    struct ball b = ball_about(at, ball->first + below, ball->count - below);
    if (a.radius * a.radius + b.radius * b.radius > .9 * ball->radius * ball->radius)
        return false;
    *ball = a;
    o->balls[o->count++] = b;
    return true;
}

/* The largest one that was not found to be whole. */
static int largest_ball(const pm_openings *o, const bool *is_whole)
{
    int largest = -1;
    for (unsigned i = 0; i < o->count; i++)
        if (!is_whole[i] && (largest < 0 || o->balls[i].radius > o->balls[largest].radius))
            largest = (int)i;
    return largest;
}

static void make_balls(pm_openings *o, struct search *s)
{
    bool is_whole[BALLS_MAX] = {false};
    o->balls[0] = ball_about(s->at, 0, s->count);
    o->count = 1;
    for (int i = 0; o->count < BALLS_MAX && i >= 0; i = largest_ball(o, is_whole))
        is_whole[i] = !divide_ball(o, s->at, (unsigned)i);
    unsigned kept = 0;
    for (unsigned i = 0; i < o->count; i++)
        if ((double)o->balls[i].count >= STRAY * (double)s->count)
            o->balls[kept++] = o->balls[i];
    o->count = kept;
}

/* Discs are equally bright. Returns their share of the disc that the scene shows. */
static double weigh_balls(pm_openings *o)
{
    double sum = 0, so_far = 0, whole = o->world->lights->radius;
    for (unsigned i = 0; i < o->count; i++)
        sum += o->balls[i].radius * o->balls[i].radius;
    for (unsigned i = 0; i < o->count; i++) {
        o->balls[i].weight = o->balls[i].radius * o->balls[i].radius / sum;
        so_far += o->balls[i].weight;
        o->ends[i] = i + 1 < o->count ? so_far : 1;
    }
    return sum / (whole * whole);
}

/* ---- finding ---- */

static bool has_distant_light(const struct pm_lights *l)
{
    return l->count && l->lights[l->count - 1].surface == PM_NO_PRIMITIVE && l->radius > 0;
}

static bool is_worth_aiming(pm_openings *o, struct search *s)
{
    s->world = o->world;
    find_inside(s);
    find_ways_out(s);
    if (!s->count || (double)s->inside < INSIDE * (double)s->looked)
        return false;
    make_balls(o, s);
    double share = weigh_balls(o);
    snprintf(o->note, sizeof o->note,
             "closed but for openings (%.2g %% of its outline): half the light of sky and sun "
             "is aimed at them",
             100 * share);
    return share < LARGE;
}

pm_status pm_openings_find(const pm_world *world, pm_openings **out, pm_error *err)
{
    *out = NULL;
    if (!has_distant_light(world->lights) || !world->main->count)
        return PM_OK;
    pm_openings *o = calloc(1, sizeof *o);
    struct search *s = calloc(1, sizeof *s);
    bool made = o && s;
    if (made)
        o->world = world;
    if (made && is_worth_aiming(o, s))
        *out = o;
    else
        free(o);
    free(s);
    return made ? PM_OK : pm_error_set(err, PM_E_MEMORY, "no memory to look for openings");
}

void pm_openings_free(pm_openings *o)
{
    free(o);
}

const char *pm_openings_note(const pm_openings *o)
{
    return o->note;
}

/* ---- emission ---- */

/* A place on the plane through the scene's centre that faces `up`, relative to that centre. */
static pm_vec3 aim(const pm_openings *o, const pm_frame *frame, double u, double x, double y,
                   unsigned *ball)
{
    unsigned i = 0;
    while (i + 1 < o->count && !(u < o->ends[i]))
        i++;
    *ball = i;
    pm_vec3 place = pm_vec3_scale(pm_warp_disc(x, y), o->balls[i].radius);
    pm_vec3 p = pm_vec3_sub(o->balls[i].center, o->world->lights->center);
    p = pm_vec3_madd(p, -pm_vec3_dot(p, frame->z), frame->z);
    return pm_vec3_add(p, pm_frame_to_world(frame, place));
}

/* Of both ways to draw a place. */
static double density_at(const pm_openings *o, pm_vec3 place, pm_vec3 up, unsigned drawn)
{
    const struct pm_lights *l = o->world->lights;
    double sum = 0;
    for (unsigned i = 0; i < o->count; i++) {
        const struct ball *ball = &o->balls[i];
        pm_vec3 off = pm_vec3_sub(pm_vec3_sub(ball->center, l->center), place);
        off = pm_vec3_madd(off, -pm_vec3_dot(off, up), up);
        double square = ball->radius * ball->radius;
        if (i == drawn || pm_vec3_dot(off, off) <= square)
            sum += ball->weight / square;
    }
    return (AIMED * sum + (1 - AIMED) / (l->radius * l->radius)) / PM_PI;
}

static void emit_from_distance(const pm_openings *o, const struct pm_light *light,
                               const double u[5], pm_emission *out)
{
    const pm_world *world = o->world;
    const struct pm_lights *l = world->lights;
    const struct pm_material *m = &world->materials[light->material];
    double solid_angle;
    pm_vec3 up = pm_light_draw_distant(world, light, u[3], u[4], &solid_angle), place;
    pm_frame frame = pm_frame_make(up);
    unsigned ball = BALLS_MAX;
    if (u[0] < AIMED)
        place = aim(o, &frame, u[0] / AIMED, u[1], u[2], &ball);
    else
        place = pm_frame_to_world(&frame, pm_vec3_scale(pm_warp_disc(u[1], u[2]), l->radius));
    pm_vec3 origin = pm_vec3_madd(place, l->radius * (1 + 0x1p-10), up);
    *out = (pm_emission){.origin = pm_vec3_add(l->center, origin),
                         .direction = pm_vec3_negate(up),
                         .from = PM_NO_PRIMITIVE,
                         .weak = pm_lights_is_weak(m)};
    bool beside = pm_vec3_dot(place, place) > l->radius * l->radius * (1 + 0x1p-40);
    if (beside || (m->type == PM_GLOW && pm_lights_is_lit(world, up)))
        return;
    out->flux = pm_rgb_scale(pm_lights_shine_far(world, light->distant, up),
                             solid_angle / (light->chance * density_at(o, place, up, ball)));
}

bool pm_openings_emit(const pm_openings *o, const double u[5], pm_emission *out)
{
    const struct pm_lights *l = o->world->lights;
    if (pm_rgb_is_black(l->power) && !l->patterned)
        return false;
    uint32_t picked = pm_lights_pick(l, u[0]);
    const struct pm_light *light = &l->lights[picked];
    if (light->surface != PM_NO_PRIMITIVE)
        return pm_light_emit(o->world, u, out);
    double before = picked ? l->cumulative[picked - 1] : 0;
    double rest = (u[0] - before) / (l->cumulative[picked] - before);
    double v[5] = {fmax(0, fmin(rest, 1 - 0x1p-53)), u[1], u[2], u[3], u[4]};
    emit_from_distance(o, light, v, out);
    return true;
}
