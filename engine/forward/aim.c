#include "forward/aim.h"

#include <math.h>
#include <stdlib.h>

#include "base/sobol.h"
#include "world/lobe.h"

/* Of the paths, how many are not aimed as they leave the light: those carry what first meets a
 * diffuse surface. Measured (bench_forward): .15 to .25 take the least time for an error. */
#define UNAIMED .2

/* Targets that fill more of the light are met often enough. */
#define LARGE .5

/* Weight of an opening among the targets. */
#define OPENING .1

/* Paths that leave a diffuse event for targets, on average at most. */
#define SECONDS_MAX 16.

/* Rays that show how much of the light of diffuse surfaces goes to targets. */
enum { PROBES = 256 };

/* Those photons may be so much more than those that come from the lights. */
#define MORE 2.

struct pm_aim {
    pm_targets targets;
    pm_targets light_targets; /* those, and openings */
    pm_light_aim *lights;
    /* Flux of photons that leave the light for targets, over that of unaimed ones. Those that
     * leave diffuse surfaces are to be as strong: a map's few strong photons are its noise. */
    double goal;
};

/* Of the light that first falls on surfaces, the share that would leave for targets if it were
 * all scattered by the cosine. */
static double share_of_surfaces(const pm_aim *aim, const pm_world *world)
{
    double sum = 0, flux = 0;
    for (uint32_t i = 0; i < PROBES; i++) {
        double u[5];
        pm_emission e;
        pm_hit hit;
        pm_target_view view;
        for (unsigned d = 0; d < 5; d++)
            u[d] = pm_sobol(i, d, pm_hash_u32(1, d));
        if (!pm_light_emit(world, u, &e))
            return 0;
        double strength = pm_rgb_max(e.flux);
        pm_ray ray = {e.origin, e.direction, INFINITY, e.from};
        flux += strength;
        if (!(strength > 0) || !pm_world_intersect(world, &ray, &hit))
            continue;
        bool behind = pm_vec3_dot(hit.normal, e.direction) > 0;
        pm_target_lobe lobe = {behind ? pm_vec3_negate(hit.normal) : hit.normal, false, 1};
        pm_targets_look(&aim->targets, hit.point, &lobe, &view);
        sum += strength * view.share;
    }
    return flux > 0 && isfinite(flux) ? sum / flux : 0;
}

/* Openings count as panes do. */
static void add_openings(const pm_targets *openings, pm_targets *out)
{
    for (unsigned i = 0; openings && out->count && i < openings->count; i++)
        pm_targets_add(out, (pm_vec3){openings->x[i], openings->y[i], openings->z[i]},
                       openings->radius[i], OPENING);
}

pm_status pm_aim_new(const pm_world *world, bool ports, const pm_targets *openings,
                     pm_aim **out, pm_error *err)
{
    pm_aim *aim = calloc(1, sizeof *aim);
    if (!aim)
        return pm_error_set(err, PM_E_MEMORY, "no memory to aim photons");
    pm_status st = pm_targets_find(world, &aim->targets, err);
    aim->light_targets = aim->targets;
    add_openings(openings, &aim->light_targets);
    if (!st)
        st = pm_light_aim_new(world, &aim->light_targets, UNAIMED, &aim->lights, err);
    if (!st && aim->targets.count) {
        double share = pm_light_aim_share(aim->lights);
        double most = fmax(share, share_of_surfaces(aim, world) / MORE);
        if (ports)
            most = fmax(most, .25 * (1 - UNAIMED) / UNAIMED);
        aim->goal = share > LARGE ? 0 : UNAIMED / (1 - UNAIMED) * most;
    }
    if (!(aim->goal > 0)) {
        pm_aim_free(aim);
        aim = NULL;
    }
    if (!st)
        *out = aim;
    return st;
}

void pm_aim_free(pm_aim *aim)
{
    if (!aim)
        return;
    pm_light_aim_free(aim->lights);
    free(aim);
}

bool pm_aim_emit(const pm_aim *aim, const double u[5], pm_emission *out, double *common)
{
    return pm_light_emit_aimed(aim->lights, u, out, common);
}

/* The Lambertian lobe that scatters to that side, if no other diffuse one does. */
static const pm_lobe *lambertian(const pm_surface *surface, bool transmitted)
{
    const pm_lobe *found = NULL;
    unsigned side = transmitted ? PM_SIDE_FAR : PM_SIDE_NEAR;
    for (unsigned i = 0; i < surface->count; i++) {
        const pm_lobe *lobe = &surface->lobes[i];
        if (lobe->event != PM_EVENT_DIFFUSE || !(lobe->sides & side))
            continue;
        if (found || lobe->kind != PM_LOBE_DIFFUSE || lobe->sides != side)
            return NULL;
        found = lobe;
    }
    return found;
}

void pm_aim_look(const pm_aim *aim, pm_vec3 point, const pm_surface *surface,
                 const pm_scatter *scatter, pm_aim_event *out)
{
    const pm_lobe *lobe = lambertian(surface, scatter->transmitted);
    out->lobe = NULL;
    out->strength = 1;
    if (!lobe)
        return;
    out->surface = surface;
    out->first = pm_lobe_pdf(surface, lobe, scatter->wi);
    out->value = pm_rgb_max(pm_lobe_value(surface, lobe, scatter->wi));
    if (!(out->first > 0) || !(out->value > 0))
        return;
    pm_target_lobe shape = {lobe->normal, false, 1};
    if (scatter->transmitted)
        shape.normal = pm_vec3_negate(shape.normal);
    pm_targets_look(&aim->targets, point, &shape, &out->view);
    if (!(out->view.total > 0))
        return;
    out->lobe = lobe;
    out->second = pm_targets_pdf(&out->view, scatter->wi);
    out->strength = fmax(aim->goal, fmin(1, aim->goal / out->view.share));
}

unsigned pm_aim_divide(const pm_aim *aim, double strength, pm_rng *rng, pm_aim_event *event,
                       double *kept)
{
    *kept = 1;
    if (!event->lobe)
        return 0;
    event->seconds = fmin(event->view.share * strength / aim->goal, SECONDS_MAX);
    *kept = event->first / (event->first + event->seconds * event->second);
    return (unsigned)(event->seconds + pm_rng_uniform(rng));
}

bool pm_aim_second(const pm_aim_event *event, pm_rng *rng, pm_vec3 *wi, double *weight)
{
    double u = pm_rng_uniform(rng), pdf;
    *wi = pm_targets_sample(&event->view, u, pm_rng_uniform(rng), &pdf);
    double value = pm_rgb_max(pm_lobe_value(event->surface, event->lobe, *wi));
    double density = pm_lobe_pdf(event->surface, event->lobe, *wi) + event->seconds * pdf;
    *weight = value / event->value * event->first / density;
    return value > 0;
}
