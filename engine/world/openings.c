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
#include "world/sight.h"

enum {
    PLACES = 512,       /* in space, that are looked around from */
    WAYS_OUT_MAX = 256, /* lines that are followed */
    HALVINGS = 7,
    BALLS_MAX = 16
};

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
    const pm_lamps *lamps; /* NULL: unaimed */
    unsigned count;
    struct ball balls[BALLS_MAX];
    double ends[BALLS_MAX]; /* cumulative weights */
    char note[120];
};

/* ---- places ---- */

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
    bool dark;                     /* ways to where no light is count, too */
    size_t looked, inside;         /* places */
    pm_sight_place places[PLACES]; /* that are inside */
    size_t count;
    pm_vec3 at[WAYS_OUT_MAX]; /* openings */
};

/* The place of the opening: a pane, or between an inside place and where the scene ends. */
static pm_vec3 narrow_down(const struct search *s, pm_vec3 point, pm_vec3 direction)
{
    const struct pm_lights *l = s->world->lights;
    pm_vec3 pane, off = pm_vec3_sub(l->center, point);
    bool passes;
    if (pm_sight_out(s->world, point, direction, &pane, &passes) && passes)
        return pane;
    double along = pm_vec3_dot(off, direction);
    double square = l->radius * l->radius - pm_vec3_dot(off, off) + along * along;
    double in = 0, out = along + sqrt(fmax(square, 0));
    for (int i = 0; i < HALVINGS; i++) {
        double t = (in + out) / 2;
        bool is_inside =
            pm_sight_around(s->world, pm_vec3_madd(point, t, direction)).closed > OPEN;
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
        s->places[s->inside] = pm_sight_around(s->world, point);
        s->inside += s->places[s->inside].closed >= PM_SIGHT_CLOSED;
        s->looked++;
    }
}

static void look_out(struct search *s, pm_vec3 point)
{
    for (uint32_t i = 0; i < PM_SIGHTS && s->count < WAYS_OUT_MAX; i++) {
        pm_vec3 last, direction = pm_sight_direction(i);
        bool passes;
        if (pm_sight_out(s->world, point, direction, &last, &passes) &&
            (s->dark || is_bright(s->world, direction)))
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

pm_status pm_openings_to_dark(const pm_world *world, pm_targets *out, pm_error *err)
{
    out->count = 0;
    pm_openings openings = {.world = world};
    if (!world->main->count || !(world->lights->radius > 0))
        return PM_OK;
    struct search *s = calloc(1, sizeof *s);
    if (!s)
        return pm_error_set(err, PM_E_MEMORY, "no memory to look for openings");
    s->dark = true;
    if (is_worth_aiming(&openings, s))
        for (unsigned i = 0; i < openings.count; i++)
            pm_targets_add(out, openings.balls[i].center, openings.balls[i].radius, 1);
    free(s);
    return PM_OK;
}

void pm_openings_aim_lamps(pm_openings *o, const pm_lamps *lamps)
{
    o->lamps = lamps;
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
        return pm_lamps_emit(o->lamps, o->world, u, out);
    double before = picked ? l->cumulative[picked - 1] : 0;
    double rest = (u[0] - before) / (l->cumulative[picked] - before);
    double v[5] = {fmax(0, fmin(rest, 1 - 0x1p-53)), u[1], u[2], u[3], u[4]};
    emit_from_distance(o, light, v, out);
    return true;
}
