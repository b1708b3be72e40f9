#include "backward/backward_internal.h"
#include "base/maths.h"

/* A sensor this near to a diffuse surface lies on it [world units, half the octree cube's
 * edge]: a tenth of a millimetre in a room of metres, and more than coordinates of five digits
 * miss. */
#define ON_SURFACE 0x1p-13

/* The photons on the surface have normals within 60 degrees of it (photon_map.h). */
#define LEAST_COSINE 0.5

/* True and the hit if the sensor lies on a diffuse surface that faces its way. */
static bool find_surface(const struct pm_pass *pass, const struct pm_probe *probe, pm_hit *hit)
{
    pm_ray ray = {.origin = pm_vec3_madd(probe->point, ON_SURFACE, probe->normal),
                  .direction = pm_vec3_negate(probe->normal),
                  .t_max = 2 * ON_SURFACE,
                  .from = PM_NO_PRIMITIVE};
    if (!pm_world_intersect(pass->world, &ray, hit))
        return false;
    pm_media media;
    pm_media_at(pass->world, ray.origin, &media);
    pm_surface surface;
    pm_surface_at(pass->world, hit, probe->normal, &media, &surface);
    return pm_surface_has(&surface, PM_EVENT_DIFFUSE) &&
           pm_vec3_dot(surface.normal, probe->normal) > LEAST_COSINE;
}

/* Irradiance is pi times the radiance of a white Lambertian receiver. On a surface the maps
 * hold photons, and the receiver is a vertex of the eye's; in free space there are none, and
 * one ray a pass looks for all indirect light. */
void pm_probe_irradiance(const struct pm_pass *pass, const struct pm_probe *probe,
                         struct pm_sampler *sampler, struct pm_value *value)
{
    pm_hit hit;
    bool attached = find_surface(pass, probe, &hit);
    pm_vec3 above = pm_vec3_madd(probe->point, attached ? ON_SURFACE : 0, probe->normal);
    pm_media media;
    pm_media_at(pass->world, above, &media);
    pm_surface receiver;
    pm_surface_receiver(probe->normal, &receiver);
    const struct pm_spot spot = {.surface = &receiver,
                                 .media = &media,
                                 .point = attached ? hit.point : probe->point,
                                 .from = attached ? hit.surface : PM_NO_PRIMITIVE};
    const pm_rgb pi = {PM_PI, PM_PI, PM_PI};
    pm_rgb direct = pm_direct_light(pass, &spot, pi, PM_DIRECT_DIFFUSE, sampler);
    value->radiance = pm_rgb_madd(value->radiance, PM_PI, direct);
    if (!attached) {
        pm_gather(pass, &spot, pi, PM_VERTEX_SENSOR, sampler, value);
        return;
    }
    pm_lookup_surface(pass, &spot, pi, PM_VERTEX_EYE, sampler, value);
    if (pass->rules[PM_VERTEX_EYE].gather)
        pm_gather(pass, &spot, pi, PM_VERTEX_GATHER, sampler, value);
}

/* A ray may start on the boundary of a medium, to rounding on either side of it. So far ahead
 * [world units] it is plain on which; 1e-11 of a scene is less than its coordinates say. */
#define CLEAR 0x1p-36

void pm_probe_radiance(const struct pm_pass *pass, const struct pm_probe *probe,
                       struct pm_sampler *sampler, struct pm_value *value)
{
    pm_vec3 origin = pm_vec3_madd(probe->point, CLEAR, probe->normal);
    struct pm_walk walk = {.ray = {.origin = origin,
                                   .direction = probe->normal,
                                   .t_max = INFINITY,
                                   .from = PM_NO_PRIMITIVE},
                           .throughput = {1, 1, 1},
                           .vertex = PM_VERTEX_EYE,
                           .emission = PM_EMISSION_SEEN,
                           .seen = true};
    pm_media_at(pass->world, origin, &walk.media);
    pm_walk_run(pass, &walk, sampler, value);
}
