#include "backward/backward_internal.h"
#include "base/maths.h"

/* 1 - exp(-x) without cancellation; x in [0, inf]. Below 2^-6 six terms of the series leave a
 * relative error under x^6 / 5040 < 2^-48. */
static double one_minus_exp(double x)
{
    if (x < 0x1p-6)
        return x * (1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6)))));
    return 1 - (x < INFINITY ? pm_exp(-x) : 0);
}

/* -log(1 - y) without cancellation; y in [0, 1). Seven terms below 2^-6 leave less than y^7 / 8
 * < 2^-45. */
static double minus_log_rest(double y)
{
    if (y < 0x1p-6)
        return y *
               (1 + y * (1. / 2 +
                         y * (1. / 3 + y * (1. / 4 + y * (1. / 5 + y * (1. / 6 + y / 7))))));
    return -pm_log(1 - y);
}

static double pick(pm_rgb values, int channel)
{
    return channel == 0 ? values.r : channel == 1 ? values.g : values.b;
}

/* Density at distance s of a collision that is known to come before `length`. */
static double collision_pdf(double extinction, double s, double length)
{
    return extinction * pm_exp(-extinction * s) / one_minus_exp(extinction * length);
}

/* A distance along the ray, drawn from one of the channels that scatter, and the density of all
 * of them together (one-sample balance heuristic, Veach 1997, eq. 9.15): bounded weights
 * whatever the ratio of the extinctions. False if none scatters. */
bool pm_inscatter_distance(const pm_medium *medium, double length, struct pm_sampler *sampler,
                           double *distance, double *pdf)
{
    int channels[3], count = 0;
    for (int c = 0; c < 3; c++)
        if (pick(medium->extinction, c) > 0 && pick(medium->albedo, c) > 0)
            channels[count++] = c;
    if (!count)
        return false;
    double u = pm_rng_uniform(&sampler->rng) * count;
    int chosen = (int)u;
    double extinction = pick(medium->extinction, channels[chosen]);
    double reach = one_minus_exp(extinction * length);
    double s = minus_log_rest((u - chosen) * reach) / extinction;
    *distance = fmin(s, length);
    *pdf = 0;
    for (int i = 0; i < count; i++)
        *pdf += collision_pdf(pick(medium->extinction, channels[i]), *distance, length) / count;
    return *pdf > 0;
}

static pm_estimate ask_part(const struct pm_lookup *lookup, pm_vec3 point, pm_vec3 direction,
                            double g)
{
    if (lookup->radius > 0)
        return pm_photon_map_volume_within(lookup->map, point, direction, g, lookup->radius);
    if (lookup->range.most)
        return pm_photon_map_volume_adapted(lookup->map, point, direction, g, &lookup->range);
    return pm_photon_map_volume(lookup->map, point, direction, g, lookup->gather_count,
                                INFINITY);
}

/* The parts of a phase function sum the same photons; so do their deviations, at most. */
static pm_estimate ask(const struct pm_lookup *lookup, const pm_medium *medium, pm_vec3 point,
                       pm_vec3 direction)
{
    pm_estimate sum = {.count = 0};
    double deviation[3] = {0};
    for (unsigned i = 0; i < medium->phases; i++) {
        pm_estimate part = ask_part(lookup, point, direction, medium->phase[i].g);
        pm_rgb share = medium->phase[i].share;
        sum.irradiance = pm_rgb_add(sum.irradiance, pm_rgb_mul(part.irradiance, share));
        sum.radius = part.radius;
        sum.count = part.count;
        deviation[0] += share.r * sqrt(part.variance.r);
        deviation[1] += share.g * sqrt(part.variance.g);
        deviation[2] += share.b * sqrt(part.variance.b);
    }
    sum.variance = (pm_rgb){deviation[0] * deviation[0], deviation[1] * deviation[1],
                            deviation[2] * deviation[2]};
    return sum;
}

/* Volume photons lie at collisions, with their flux before the albedo: their flux density is
 * extinction * fluence rate. So the light scattered towards the eye on a length ds is
 * scattering * integral(phase * L) ds = albedo * sum(flux * phase) / volume * ds
 * (Jensen and Christensen 1998, eqs. 5 and 10). */
static void add_scattered(const struct pm_pass *pass, const struct pm_walk *walk,
                          const pm_medium *medium, double length, struct pm_sampler *sampler,
                          struct pm_value *value)
{
    double distance, pdf;
    if (!pm_inscatter_distance(medium, length, sampler, &distance, &pdf))
        return;
    pm_vec3 point = pm_vec3_madd(walk->ray.origin, distance, walk->ray.direction);
    pm_estimate estimate =
        ask(&pass->volume, medium, point, pm_vec3_negate(walk->ray.direction));
    pm_rgb weight = pm_rgb_mul(walk->throughput, medium->albedo);
    weight = pm_rgb_mul(weight, pm_medium_transmittance(medium, distance));
    weight = pm_rgb_scale(weight, 1 / pdf);
    value->radiance = pm_rgb_add(value->radiance, pm_rgb_mul(weight, estimate.irradiance));
    if (pass->shared)
        value->variance = pm_rgb_add(value->variance,
                                     pm_rgb_mul(pm_rgb_mul(weight, weight), estimate.variance));
}

/* exp(-extinction * INFINITY) is 1 where nothing attenuates. */
static pm_rgb transmittance(const pm_medium *medium, double length)
{
    if (length < INFINITY)
        return pm_medium_transmittance(medium, length);
    return pm_rgb_make(medium->extinction.r > 0 ? 0 : 1, medium->extinction.g > 0 ? 0 : 1,
                       medium->extinction.b > 0 ? 0 : 1);
}

void pm_inscatter(const struct pm_pass *pass, struct pm_walk *walk, double length,
                  struct pm_sampler *sampler, struct pm_value *value)
{
    pm_medium medium;
    if (!pm_media_medium(&walk->media, pass->world, &medium))
        return;
    if (pass->volume.map)
        add_scattered(pass, walk, &medium, length, sampler, value);
    walk->throughput = pm_rgb_mul(walk->throughput, transmittance(&medium, length));
}
