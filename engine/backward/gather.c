#include "backward/backward_internal.h"
#include "base/maths.h"
#include "base/warp.h"

/* A cosine-distributed direction on the side that the albedos and `u` choose, and the
 * throughput f |cos| / pdf along it. u[0] is rescaled, so its stratification goes on into the
 * direction. */
static pm_vec3 choose_direction(const pm_surface *surface, double u[3], pm_rgb *weight)
{
    double reflected = pm_rgb_mean(surface->diffuse_reflectance);
    double transmitted = pm_rgb_mean(surface->diffuse_transmittance);
    double share = reflected / (reflected + transmitted);
    bool reflect = u[0] < share;
    u[0] = reflect ? u[0] / share : (u[0] - share) / (1 - share);
    pm_frame frame = pm_frame_make(reflect ? surface->normal : pm_vec3_negate(surface->normal));
    pm_vec3 local = pm_warp_cosine(u[0], u[1]);
    pm_vec3 wi = pm_frame_to_world(&frame, local);
    double pdf = (reflect ? share : 1 - share) * local.z / PM_PI;
    *weight = pm_rgb_scale(pm_surface_diffuse(surface, wi), pdf > 0 ? 1 / pdf : 0);
    return wi;
}

void pm_gather(const struct pm_pass *pass, const struct pm_spot *spot, pm_rgb throughput,
               enum pm_vertex end, struct pm_sampler *sampler, struct pm_value *value)
{
    double u[3];
    pm_rgb weight;
    pm_sampler_draw(sampler, PM_SAMPLE_GATHER, u);
    pm_vec3 wi = choose_direction(spot->surface, u, &weight);
    struct pm_walk walk = {
        .ray = {.origin = spot->point, .direction = wi, .t_max = INFINITY, .from = spot->from},
        .throughput = pm_rgb_mul(throughput, weight),
        .vertex = end,
        .emission = PM_EMISSION_NONE};
    walk.media = pm_spot_media(pass, spot, wi);
    if (!pm_rgb_is_black(walk.throughput))
        pm_walk_run(pass, &walk, sampler, value);
}
