#include "backward/backward_internal.h"

pm_media pm_spot_media(const struct pm_pass *pass, const struct pm_spot *spot,
                       pm_vec3 direction)
{
    pm_media media = *spot->media;
    if (spot->hit && pm_vec3_dot(direction, spot->surface->normal) < 0)
        pm_media_cross(&media, pass->world, spot->hit, direction);
    return media;
}

/* f |cos| of the lobes asked for, the glossy one weighted. A glossy bounce cannot hit a hidden
 * light, so there next event has all of it. */
static pm_rgb scattered(const struct pm_spot *spot, pm_rgb throughput, unsigned lobes,
                        const pm_light_sample *light)
{
    pm_rgb f = {0, 0, 0};
    if (lobes & PM_DIRECT_DIFFUSE)
        f = pm_surface_value(spot->surface, PM_EVENT_DIFFUSE, light->wi);
    if (!(lobes & PM_DIRECT_GLOSSY))
        return f;
    double weight = 1;
    if (!light->hidden)
        weight = pm_power_weight(light->pdf,
                                 pm_surface_glossy_pdf(spot->surface, throughput, light->wi));
    return pm_rgb_madd(f, weight, pm_surface_value(spot->surface, PM_EVENT_GLOSSY, light->wi));
}

/* Next event from `point`, where the rays of one side of a proxy start, or of both. */
static pm_rgb light_from(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 point,
                         uint32_t from, unsigned sides, const double *u, pm_rgb throughput,
                         unsigned lobes)
{
    const pm_rgb black = {0, 0, 0};
    pm_light_sample light;
    if (!pm_light_sample_at(pass->world, point, u, &light))
        return black;
    bool near = pm_vec3_dot(spot->surface->normal, light.wi) > 0;
    if (!(sides & (near ? PM_SIDE_NEAR : PM_SIDE_FAR)))
        return black;
    pm_rgb f = scattered(spot, throughput, lobes, &light);
    f = pm_rgb_scale(pm_rgb_mul(f, light.radiance), 1 / light.pdf);
    if (pm_rgb_is_black(f))
        return black;
    pm_ray ray = {
        .origin = point, .direction = light.wi, .t_max = light.distance, .from = from};
    pm_media media = pm_spot_media(pass, spot, light.wi);
    return pm_rgb_mul(f, pm_world_transmittance(pass->world, &ray, &media, light.weak));
}

pm_rgb pm_direct_light(const struct pm_pass *pass, const struct pm_spot *spot,
                       pm_rgb throughput, unsigned lobes, struct pm_sampler *sampler)
{
    double u[3];
    const pm_surface *surface = spot->surface;
    pm_sampler_draw(sampler, PM_SAMPLE_LIGHT, u);
    if (!(surface->skip > 0))
        return light_from(pass, spot, spot->point, spot->from, PM_SIDE_NEAR | PM_SIDE_FAR, u,
                          throughput, lobes);
    pm_rgb near =
        light_from(pass, spot, spot->point, spot->from, PM_SIDE_NEAR, u, throughput, lobes);
    uint32_t from = spot->from;
    pm_vec3 behind =
        pm_surface_exit(surface, spot->point, pm_vec3_negate(surface->normal), &from);
    return pm_rgb_add(near,
                      light_from(pass, spot, behind, from, PM_SIDE_FAR, u, throughput, lobes));
}
