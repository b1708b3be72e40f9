#include "backward/backward_internal.h"

static void add_light(const struct pm_walk *walk, pm_rgb radiance, struct pm_value *value)
{
    value->radiance = pm_rgb_add(value->radiance, pm_rgb_mul(walk->throughput, radiance));
}

/* The walk leaves the scene. */
static void add_distant(const struct pm_pass *pass, const struct pm_walk *walk,
                        struct pm_value *value)
{
    double pdf;
    pm_vec3 direction = walk->ray.direction;
    if (walk->emission == PM_EMISSION_NONE)
        return;
    pm_rgb radiance = walk->emission == PM_EMISSION_SEEN
                          ? pm_light_seen_distant(pass->world, direction)
                          : pm_light_distant(pass->world, direction, &pdf);
    if (walk->emission == PM_EMISSION_WEIGHTED)
        radiance = pm_rgb_scale(radiance, pm_power_weight(walk->bend_pdf, pdf));
    add_light(walk, radiance, value);
}

/* What the surface at `hit` emits; hit->t counts from the last event. */
static void add_emission(const struct pm_pass *pass, const struct pm_walk *walk,
                         const pm_hit *hit, struct pm_value *value)
{
    if (walk->emission == PM_EMISSION_NONE)
        return;
    pm_vec3 wo = pm_vec3_negate(walk->ray.direction);
    pm_rgb radiance = walk->emission == PM_EMISSION_SEEN
                          ? pm_light_seen_radiance(pass->world, hit, wo)
                          : pm_light_radiance(pass->world, hit, wo);
    if (pm_rgb_is_black(radiance))
        return;
    if (walk->emission == PM_EMISSION_WEIGHTED) {
        double pdf = pm_light_pdf_surface(pass->world, walk->bend, walk->ray.direction, hit);
        radiance = pm_rgb_scale(radiance, pm_power_weight(walk->bend_pdf, pdf));
    }
    add_light(walk, radiance, value);
}

/* The light that a vertex scatters towards the walk, but for what comes by its other lobes. */
static void add_vertex(const struct pm_pass *pass, const struct pm_walk *walk,
                       const struct pm_spot *spot, struct pm_sampler *sampler,
                       struct pm_value *value)
{
    const struct pm_vertex_rule *rule = &pass->rules[walk->vertex];
    bool diffuse = pm_surface_has(spot->surface, PM_EVENT_DIFFUSE) &&
                   (walk->specular || !rule->after_specular);
    unsigned lobes = diffuse ? PM_DIRECT_DIFFUSE : 0;
    if (pm_surface_has(spot->surface, PM_EVENT_GLOSSY) && rule->through_specular)
        lobes |= PM_DIRECT_GLOSSY;
    if (lobes)
        add_light(walk, pm_direct_light(pass, spot, walk->throughput, lobes, sampler), value);
    if (diffuse)
        pm_lookup_surface(pass, spot, walk->throughput, walk->vertex, sampler, value);
    if (diffuse && rule->gather)
        pm_gather(pass, spot, walk->throughput, PM_VERTEX_GATHER, sampler, value);
}

/* Russian roulette on the throughput alone, so that a hall of mirrors ends but has no fixed
 * depth (Arvo and Kirk, "Particle transport and image synthesis", SIGGRAPH 1990). */
static bool survives(struct pm_walk *walk, struct pm_sampler *sampler)
{
    enum { SAFE_BOUNCES = 6 };
    if (pm_rgb_is_black(walk->throughput))
        return false;
    if (++walk->bounces <= SAFE_BOUNCES)
        return true;
    double survival = fmin(.95, pm_rgb_max(walk->throughput));
    if (!(pm_rng_uniform(&sampler->rng) < survival))
        return false;
    walk->throughput = pm_rgb_scale(walk->throughput, 1 / survival);
    return true;
}

/* A specular or glossy event: what the walk meets next is seen through it. */
static void bend(struct pm_walk *walk, pm_vec3 origin, const pm_scatter *scatter)
{
    bool glossy = scatter->event == PM_EVENT_GLOSSY;
    walk->seen = walk->seen && !glossy;
    walk->emission = walk->seen ? PM_EMISSION_SEEN
                     : glossy   ? PM_EMISSION_WEIGHTED
                                : PM_EMISSION_FULL;
    walk->specular = true;
    walk->bend = origin;
    walk->bend_pdf = scatter->pdf;
    walk->length = 0;
}

/* Goes on by one of the non-diffuse lobes. False if the walk ends. */
static bool leave(const struct pm_pass *pass, struct pm_walk *walk, const pm_hit *hit,
                  double distance, const pm_surface *surface, struct pm_sampler *sampler)
{
    double u[3];
    pm_scatter scatter;
    pm_sampler_draw(sampler, PM_SAMPLE_LOBE, u);
    pm_surface_sample_specular(surface, walk->throughput, u, &scatter);
    if (scatter.event == PM_EVENT_NONE)
        return false;
    uint32_t from = hit->surface;
    pm_vec3 origin = hit->point;
    if (scatter.event != PM_EVENT_STRAIGHT) {
        if (!pass->rules[walk->vertex].through_specular)
            return false;
        origin = pm_surface_exit(surface, hit->point, scatter.wi, &from);
        bend(walk, origin, &scatter);
    }
    if (scatter.transmitted)
        pm_media_cross(&walk->media, pass->world, hit, scatter.wi);
    walk->throughput =
        pm_rgb_mul(walk->throughput, pm_rgb_scale(scatter.weight, scatter.radiance_scale));
    bool straight = scatter.event == PM_EVENT_STRAIGHT;
    walk->ray = (pm_ray){.origin = origin,
                         .direction = scatter.wi,
                         .t_max = straight ? walk->ray.t_max - distance : INFINITY,
                         .from = from};
    return survives(walk, sampler);
}

static bool step(const struct pm_pass *pass, struct pm_walk *walk, struct pm_sampler *sampler,
                 struct pm_value *value)
{
    pm_hit hit;
    bool met = pm_world_intersect(pass->world, &walk->ray, &hit);
    if (met)
        pm_media_meet(&walk->media, pass->world, &hit, walk->ray.direction);
    if (walk->media.count)
        pm_inscatter(pass, walk, met ? hit.t : walk->ray.t_max, sampler, value);
    if (pm_rgb_is_black(walk->throughput))
        return false;
    if (!met) {
        if (walk->ray.t_max == INFINITY) /* else a view's aft clipping plane, which is black */
            add_distant(pass, walk, value);
        return false;
    }
    double distance = hit.t;
    walk->length += distance;
    hit.t = walk->length;
    add_emission(pass, walk, &hit, value);
    pm_surface surface;
    pm_vec3 wo = pm_vec3_negate(walk->ray.direction);
    if (!walk->seen && pm_light_stands_in(pass->world, &hit, wo))
        return false; /* an illum, which next event samples, is all the light from behind it */
    (walk->seen ? pm_surface_seen_at : pm_surface_at)(pass->world, &hit, wo, &walk->media,
                                                      &surface);
    const struct pm_spot spot = {&surface, &hit, &walk->media, hit.point, hit.surface};
    add_vertex(pass, walk, &spot, sampler, value);
    return leave(pass, walk, &hit, distance, &surface, sampler);
}

void pm_walk_run(const struct pm_pass *pass, struct pm_walk *walk, struct pm_sampler *sampler,
                 struct pm_value *value)
{
    while (step(pass, walk, sampler, value))
        continue;
}
