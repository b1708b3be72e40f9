#include "forward/path.h"

#include "base/maths.h"
#include "base/sobol.h"
#include "forward/choice.h"
#include "forward/record.h"
#include "world/light.h"
#include "world/media.h"
#include "world/surface.h"

enum {
    /* Passages in a row: panes that coincide must not hang a path. */
    STRAIGHT_MAX = 1024,
    /* Random numbers are drawn per segment; those of storing come from a stream beside it. */
    STORING = 1 << 30,
    /* Of paths that leave paths. */
    DEPTH_MAX = 8,
};

/* A path on its way. */
struct walk {
    const struct pm_tracer *tracer;
    struct pm_recorder *recorder;
    pm_rng rng;
    pm_ray ray;
    pm_rgb flux;
    double reference; /* largest channel of the emitted flux: roulette keeps `flux` there */
    double common;    /* the same of an unaimed path, from the next diffuse event on */
    pm_media media;   /* that hold the ray's origin */
    pm_emission emission;
    double travelled;    /* from the light, or from where distant light enters the scene */
    uint32_t *segment;   /* of all walks of the path together */
    unsigned depth;      /* of paths that this one left */
    uint32_t events;     /* diffuse, glossy and specular ones, */
    uint32_t collisions; /* and those in media */
    uint32_t straight;   /* passages since the last event */
    bool specular;       /* the last event was specular or glossy */
};

/* True with probability p, also for a p far below the 2^-32 steps of one number. */
static bool chance(pm_rng *rng, double p)
{
    double u = pm_rng_uniform(rng);
    if (p < 0x1p-16)
        u += pm_rng_uniform(rng) * 0x1p-32;
    return u < p;
}

/* Uniform in [0, 1) in steps of 2^-53: free paths need the small values. */
static double fine_uniform(pm_rng *rng)
{
    double high = pm_rng_u32(rng) >> 5, low = pm_rng_u32(rng) >> 6;
    return (high * 0x1p26 + low) * 0x1p-53;
}

static void add_to(pm_rgb *sum, pm_rgb flux)
{
    *sum = pm_rgb_add(*sum, flux);
}

/* Russian roulette: a path weaker than it started ends, or goes on as strong as it started
 * (Arvo and Kirk, "Particle transport and image synthesis", SIGGRAPH 1990). */
static bool survives(struct walk *walk, pm_rgb flux)
{
    double largest = pm_rgb_max(flux);
    walk->flux = flux;
    if (!(largest < walk->reference))
        return true;
    double survival = largest / walk->reference;
    if (!(survival > 0) || !chance(&walk->rng, survival))
        return false;
    walk->flux = pm_rgb_scale(flux, 1 / survival);
    return true;
}

/* Whether the light has been scattered on its way. */
static bool is_indirect(const struct walk *walk)
{
    return walk->events || walk->collisions;
}

/* Counts a scattering. False if the path is at its bound: the rest of its flux counts as
 * absorbed. */
static bool count_event(struct walk *walk, pm_event event, bool in_medium)
{
    bool within;
    if (event == PM_EVENT_STRAIGHT) {
        within = walk->straight++ < STRAIGHT_MAX;
    } else {
        uint32_t *spent = in_medium ? &walk->collisions : &walk->events;
        within = *spent < (in_medium ? walk->tracer->max_collisions : walk->tracer->max_events);
        within = within && walk->events + walk->collisions < walk->tracer->max_scatterings;
        ++*spent;
        walk->straight = 0;
        walk->specular = event == PM_EVENT_SPECULAR || event == PM_EVENT_GLOSSY;
    }
    if (!within)
        add_to(&walk->recorder->absorbed, walk->flux);
    return within;
}

static void deposit(struct walk *walk, unsigned kinds, pm_rgb flux, pm_vec3 point,
                    pm_vec3 normal)
{
    pm_photon_record photon = {.position = point,
                               .normal = normal,
                               .direction = pm_vec3_negate(walk->ray.direction),
                               .flux = flux,
                               .specular = walk->specular};
    pm_rng draws = walk->rng;
    pm_rng_bounce(&draws, *walk->segment | STORING);
    pm_record_deposit(walk->recorder, kinds, &photon, &draws);
}

/* ---- surfaces ---- */

/* What the surface takes, in expectation: from its albedo, so that the flux balance also checks
 * the sampling. Where that has no closed form, what the sample lost is taken. */
static pm_rgb absorbed_by(const pm_surface *surface, pm_rgb before, pm_rgb after)
{
    pm_rgb albedo;
    if (!pm_surface_albedo(surface, &albedo))
        return pm_rgb_sub(before, after);
    return pm_rgb_sub(before, pm_rgb_mul(before, albedo));
}

/* A focused spotlight keeps back part of its flux (see light.h); known where the first event
 * is. */
static double focus_share(const struct walk *walk)
{
    if (is_indirect(walk) || !(walk->emission.focus > 0))
        return 1;
    return pm_emission_share(&walk->emission, walk->travelled);
}

static pm_rgb flux_here(const struct walk *walk)
{
    double share = focus_share(walk);
    return share == 1 ? walk->flux : pm_rgb_scale(walk->flux, share);
}

static void apply_focus(struct walk *walk)
{
    double share = focus_share(walk);
    if (share == 1)
        return;
    add_to(&walk->recorder->absorbed, pm_rgb_scale(walk->flux, 1 - share));
    walk->flux = pm_rgb_scale(walk->flux, share);
}

/* Weak light that leaves through the front of an illum is in that illum's own light. */
static bool is_stood_for(const struct walk *walk, const pm_hit *hit, pm_vec3 wi)
{
    bool weak = walk->emission.weak || is_indirect(walk);
    return weak && pm_light_stands_in(walk->tracer->world, hit, wi);
}

/* A sensor stores what comes to its front, whatever it is made of. */
static bool is_sensed(const struct walk *walk, const pm_hit *hit)
{
    const struct pm_choice *choice = walk->tracer->choice;
    return choice && choice->sensors.any && pm_vec3_dot(walk->ray.direction, hit->normal) < 0 &&
           pm_selection_has(&choice->sensors, walk->tracer->world, hit->surface) &&
           !pm_surface_is_hidden(walk->tracer->world, hit, &walk->media);
}

static bool is_stored(const struct walk *walk, uint32_t surface, pm_vec3 point)
{
    const struct pm_choice *choice = walk->tracer->choice;
    return !choice || pm_choice_stores(choice, walk->tracer->world, surface, point);
}

/* Of a photon that lands on a diffuse surface or a sensor. */
static unsigned kinds_here(const struct walk *walk)
{
    if (!is_indirect(walk))
        return 1U << PM_MAP_DIRECT;
    return walk->specular ? 1U << PM_MAP_GLOBAL | 1U << PM_MAP_CAUSTIC : 1U << PM_MAP_GLOBAL;
}

static void deposit_on(struct walk *walk, const pm_hit *hit, const pm_surface *surface)
{
    unsigned kinds = kinds_here(walk) & ~walk->recorder->ignored;
    if (!kinds || !(pm_surface_has(surface, PM_EVENT_DIFFUSE) || is_sensed(walk, hit)) ||
        !is_stored(walk, hit->surface, hit->point))
        return;
    deposit(walk, kinds, flux_here(walk), hit->point, surface->normal);
}

/* The path goes on from the surface. */
static void leave(struct walk *walk, const pm_hit *hit, const pm_surface *surface,
                  const pm_scatter *scatter)
{
    if (scatter->transmitted)
        pm_media_cross(&walk->media, walk->tracer->world, hit, scatter->wi);
    walk->ray = (pm_ray){hit->point, scatter->wi, INFINITY, hit->surface};
    if (scatter->event != PM_EVENT_STRAIGHT)
        walk->ray.origin = pm_surface_exit(surface, hit->point, scatter->wi, &walk->ray.from);
}

static void follow(struct walk *walk);

/* Another path leaves a diffuse event for a target, and is followed to its end. It is held to
 * its own strength up to the next diffuse event. */
static void follow_second(const struct walk *walk, const pm_hit *hit, const pm_surface *surface,
                          const pm_scatter *scatter, pm_rgb flux)
{
    if (is_stood_for(walk, hit, scatter->wi)) {
        add_to(&walk->recorder->absorbed, flux);
        return;
    }
    struct walk second = *walk;
    second.depth++;
    second.flux = flux;
    second.reference = pm_rgb_max(flux);
    leave(&second, hit, surface, scatter);
    follow(&second);
}

/* A diffuse event of an aimed path: more paths may leave, and what they carry is taken from
 * this one. False if it ends. */
static bool divide(struct walk *walk, const pm_hit *hit, const pm_surface *surface,
                   const pm_scatter *scatter, pm_rgb flux)
{
    const pm_aim *aim = walk->tracer->aim;
    pm_aim_event event = {.strength = 1};
    if (walk->depth < DEPTH_MAX)
        pm_aim_look(aim, hit->point, surface, scatter, &event);
    walk->reference = walk->common * event.strength;
    if (!survives(walk, flux))
        return false;
    double kept, weight;
    pm_scatter other = *scatter;
    flux = walk->flux;
    unsigned seconds =
        pm_aim_divide(aim, pm_rgb_max(flux) / walk->common, &walk->rng, &event, &kept);
    walk->flux = pm_rgb_scale(flux, kept);
    walk->reference = pm_rgb_max(walk->flux);
    for (unsigned i = 0; i < seconds; i++)
        if (pm_aim_second(&event, &walk->rng, &other.wi, &weight))
            follow_second(walk, hit, surface, &other, pm_rgb_scale(flux, weight));
    return true;
}

/* The path meets a surface. False if it ends there. */
static bool meet_surface(struct walk *walk, const pm_hit *hit)
{
    pm_surface surface;
    pm_surface_lit_at(walk->tracer->world, hit, pm_vec3_negate(walk->ray.direction),
                      &walk->media, &surface);
    deposit_on(walk, hit, &surface);
    double u[3];
    for (int i = 0; i < 3; i++)
        u[i] = pm_rng_uniform(&walk->rng);
    pm_scatter scatter;
    pm_surface_sample(&surface, walk->flux, u, &scatter);
    if (scatter.event == PM_EVENT_NONE) {
        add_to(&walk->recorder->absorbed, walk->flux);
        return false;
    }
    if (scatter.event != PM_EVENT_STRAIGHT)
        apply_focus(walk);
    if (!count_event(walk, scatter.event, false))
        return false;
    if (is_stood_for(walk, hit, scatter.wi)) {
        add_to(&walk->recorder->absorbed, walk->flux);
        return false;
    }
    pm_rgb flux = pm_rgb_mul(walk->flux, scatter.weight);
    add_to(&walk->recorder->absorbed, absorbed_by(&surface, walk->flux, flux));
    bool divides = walk->tracer->aim && scatter.event == PM_EVENT_DIFFUSE;
    if (divides ? !divide(walk, hit, &surface, &scatter, flux) : !survives(walk, flux))
        return false;
    leave(walk, hit, &surface, &scatter);
    return true;
}

/* ---- media ---- */

static double pick_channel(pm_rgb flux, pm_rgb values, double u)
{
    double x = u * (flux.r + flux.g + flux.b);
    if (x < flux.r)
        return values.r;
    return x < flux.r + flux.g ? values.g : values.b;
}

/* Distance to the next collision, drawn from the extinction of a channel that is picked in
 * proportion to its flux; infinity if that channel meets none. */
static double draw_free_path(struct walk *walk, const pm_medium *medium)
{
    double u = pm_rng_uniform(&walk->rng);
    double extinction = pick_channel(walk->flux, medium->extinction, u);
    double depth = -pm_log(1 - fine_uniform(&walk->rng));
    return extinction > 0 ? depth / extinction : INFINITY;
}

/* Weighs the flux after a free path of `length` that ended in a collision or not: one-sample
 * multiple importance sampling by the balance heuristic over the channels (Veach 1997,
 * 9.2.4). With channels picked in proportion to their flux the sum of the three stays what
 * it was, so weights are bounded for any ratio of extinctions. */
static void weigh_free_path(struct walk *walk, const pm_medium *medium, double length,
                            bool collided)
{
    pm_rgb flux = walk->flux, extinction = medium->extinction;
    if (extinction.r == extinction.g && extinction.g == extinction.b)
        return; /* all weights are 1 */
    pm_rgb value = pm_medium_transmittance(medium, length);
    if (collided)
        value = pm_rgb_mul(value, extinction);
    pm_rgb arriving = pm_rgb_mul(flux, value);
    double density = (arriving.r + arriving.g + arriving.b) / (flux.r + flux.g + flux.b);
    walk->flux = pm_rgb_scale(arriving, 1 / density);
}

/* A medium that only absorbs. False if the path ends in it. */
static bool attenuate(struct walk *walk, const pm_medium *medium, double length)
{
    pm_rgb flux = pm_rgb_mul(walk->flux, pm_medium_transmittance(medium, length));
    add_to(&walk->recorder->absorbed, pm_rgb_sub(walk->flux, flux));
    return survives(walk, flux);
}

/* The path collides in a scattering medium. False if it ends there. */
static bool collide(struct walk *walk, const pm_medium *medium, pm_vec3 point)
{
    apply_focus(walk);
    if (is_stored(walk, PM_NO_PRIMITIVE, point))
        deposit(walk, 1U << PM_MAP_VOLUME, walk->flux, point, (pm_vec3){0, 0, 0});
    if (!count_event(walk, PM_EVENT_DIFFUSE, true))
        return false;
    pm_rgb weight, flux = pm_rgb_mul(walk->flux, medium->albedo);
    add_to(&walk->recorder->absorbed, pm_rgb_sub(walk->flux, flux));
    double u[3];
    for (int i = 0; i < 3; i++)
        u[i] = pm_rng_uniform(&walk->rng);
    pm_vec3 direction = pm_medium_scatter(medium, flux, walk->ray.direction, u, &weight);
    walk->reference = walk->common;
    if (!survives(walk, pm_rgb_mul(flux, weight)))
        return false;
    walk->ray = (pm_ray){point, direction, INFINITY, PM_NO_PRIMITIVE};
    return true;
}

/* ---- the walk ---- */

/* A medium whose boundary has gaps ends where the scene does. */
static bool is_outside(pm_vec3 p)
{
    return !(fabs(p.x) <= 1 && fabs(p.y) <= 1 && fabs(p.z) <= 1);
}

static bool escape(struct walk *walk)
{
    add_to(&walk->recorder->escaped, walk->flux);
    return false;
}

/* Adds a stretch to the path. False if its bound lies within: the path ends there, and counts
 * as absorbed. */
static bool travel(struct walk *walk, double length)
{
    const struct pm_choice *choice = walk->tracer->choice;
    walk->travelled += length;
    if (!choice || walk->travelled <= choice->max_length)
        return true;
    add_to(&walk->recorder->absorbed, walk->flux);
    return false;
}

static bool step_through_medium(struct walk *walk, const pm_medium *medium)
{
    pm_hit hit;
    bool scatters = pm_rgb_max(medium->albedo) > 0;
    walk->ray.t_max = scatters ? draw_free_path(walk, medium) : INFINITY;
    bool met = pm_world_intersect(walk->tracer->world, &walk->ray, &hit);
    double length = met ? hit.t : walk->ray.t_max;
    if (!travel(walk, length))
        return false;
    if (scatters)
        weigh_free_path(walk, medium, length, !met && length < INFINITY);
    else if (met && !attenuate(walk, medium, length))
        return false;
    if (met)
        return meet_surface(walk, &hit);
    pm_vec3 point = pm_vec3_madd(walk->ray.origin, length, walk->ray.direction);
    return is_outside(point) ? escape(walk) : collide(walk, medium, point);
}

static bool step(struct walk *walk)
{
    pm_hit hit;
    pm_medium medium;
    pm_rng_bounce(&walk->rng, ++*walk->segment);
    if (walk->media.count && pm_media_medium(&walk->media, walk->tracer->world, &medium))
        return step_through_medium(walk, &medium);
    if (!pm_world_intersect(walk->tracer->world, &walk->ray, &hit))
        return escape(walk);
    pm_media_meet(&walk->media, walk->tracer->world, &hit, walk->ray.direction);
    if (walk->media.count && pm_media_medium(&walk->media, walk->tracer->world, &medium))
        return step_through_medium(walk,
                                   &medium); /* what was met says that the path was in it */
    return travel(walk, hit.t) && meet_surface(walk, &hit);
}

/* A path that fails this is dropped and counted; a healthy engine has none. One non-finite part
 * makes the sum so. */
static bool is_finite(const struct walk *walk)
{
    const pm_ray *r = &walk->ray;
    double sum = walk->flux.r + walk->flux.g + walk->flux.b;
    sum += r->direction.x + r->direction.y + r->direction.z;
    return isfinite(sum + r->origin.x + r->origin.y + r->origin.z);
}

void pm_tracer_set_replicate(struct pm_tracer *tracer, unsigned replicate)
{
    pm_rng rng;
    pm_rng_init(&rng, tracer->seed, PM_RNG_SCRAMBLE, replicate);
    pm_rng_bounce(&rng, (uint32_t)tracer->purpose); /* the pre-run has scrambles of its own */
    uint32_t scramble = pm_rng_u32(&rng);
    for (unsigned d = 0; d < PM_SOBOL_DIMENSIONS; d++)
        tracer->scramble[d] = pm_hash_u32(scramble, d);
}

/* The way to the scene's cube; 0 from within, and past it. */
static double way_to_scene(const pm_ray *ray)
{
    const double origin[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
    const double direction[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
    double way = 0;
    for (int i = 0; i < 3; i++)
        if (fabs(origin[i]) > 1 && origin[i] * direction[i] < 0)
            way = fmax(way, (fabs(origin[i]) - 1) / fabs(direction[i]));
    return way;
}

static bool draw_emission(const struct pm_tracer *tracer, uint32_t sobol_index,
                          pm_emission *emission, double *common, pm_port_entry *out)
{
    double u[PM_SOBOL_DIMENSIONS];
    pm_sobol_point(sobol_index, tracer->scramble, u);
    out->enters = false;
    if (tracer->openings)
        return pm_openings_emit(tracer->openings, u, emission);
    if (tracer->ports) {
        bool emits = pm_ports_emit(tracer->ports, u, out);
        *emission = out->emission;
        return emits;
    }
    if (tracer->aim)
        return pm_aim_emit(tracer->aim, u, emission, common);
    return pm_lamps_emit(tracer->lamps, tracer->world, u, emission);
}

/* False if no light emits. */
static bool emit(struct walk *walk, uint32_t sobol_index, pm_port_entry *entry)
{
    const pm_emission *e = &walk->emission;
    double common = 1;
    if (!draw_emission(walk->tracer, sobol_index, &walk->emission, &common, entry))
        return false;
    walk->ray = (pm_ray){e->origin, e->direction, INFINITY, e->from};
    walk->flux = e->flux;
    walk->reference = pm_rgb_max(e->flux);
    walk->common = walk->reference * common;
    walk->travelled = 0;
    walk->media.count = 0;
    if (entry->enters)
        walk->media = entry->media;
    else if (e->from != PM_NO_PRIMITIVE)
        pm_media_at(walk->tracer->world, e->origin, &walk->media);
    else
        walk->travelled = -way_to_scene(&walk->ray);
    add_to(&walk->recorder->emitted, e->flux);
    return walk->reference > 0;
}

/* The path starts where it meets the port. */
static bool enter(struct walk *walk, const pm_port_entry *entry)
{
    if (!entry->enters)
        return true;
    pm_rng_bounce(&walk->rng, ++*walk->segment);
    return meet_surface(walk, &entry->hit);
}

static void follow(struct walk *walk)
{
    bool finite;
    while ((finite = is_finite(walk)) && step(walk))
        continue;
    walk->recorder->nonfinite += !finite;
}

void pm_path_trace(const struct pm_tracer *tracer, uint64_t number, uint32_t sobol_index,
                   struct pm_recorder *recorder)
{
    struct walk walk;
    uint32_t segment = 0;
    walk.tracer = tracer;
    walk.recorder = recorder;
    walk.segment = &segment;
    walk.depth = walk.events = walk.collisions = walk.straight = 0;
    walk.specular = false;
    pm_port_entry entry;
    if (!emit(&walk, sobol_index, &entry))
        return;
    pm_rng_init(&walk.rng, tracer->seed, tracer->purpose, number);
    if (enter(&walk, &entry))
        follow(&walk);
    recorder->rays += segment;
}
