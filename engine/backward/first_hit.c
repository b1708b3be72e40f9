#include "backward/first_hit.h"

#include "backward/backward_internal.h"

static pm_vec3 facing(pm_vec3 normal, pm_vec3 direction)
{
    return pm_vec3_dot(normal, direction) > 0 ? pm_vec3_negate(normal) : normal;
}

static pm_vec3 shading_normal(const pm_world *world, const pm_ray *ray, const pm_hit *hit)
{
    pm_media media;
    pm_surface surface;
    pm_media_at(world, ray->origin, &media);
    pm_surface_seen_at(world, hit, pm_vec3_negate(ray->direction), &media, &surface);
    return surface.count ? surface.lobes[0].normal : surface.normal;
}

pm_first_hit pm_sensor_first_hit(const pm_world *world, const pm_sensor *sensor,
                                 pm_quantity quantity)
{
    pm_vec3 direction = pm_view_unit(sensor->normal);
    if (quantity == PM_IRRADIANCE)
        return (pm_first_hit){.met = true,
                              .point = sensor->point,
                              .normal = direction,
                              .geometric_normal = direction,
                              .surface = PM_NO_PRIMITIVE};
    pm_hit hit;
    pm_world_info info;
    pm_ray ray = {.origin = pm_world_from_scene(world, sensor->point),
                  .direction = direction,
                  .t_max = INFINITY,
                  .from = PM_NO_PRIMITIVE};
    if (!pm_world_intersect(world, &ray, &hit))
        return (pm_first_hit){
            .distance = INFINITY, .point = sensor->point, .surface = PM_NO_PRIMITIVE};
    pm_world_info_get(world, &info);
    return (pm_first_hit){.met = true,
                          .distance = hit.t * info.scale,
                          .point = pm_world_to_scene(world, hit.point),
                          .normal = facing(shading_normal(world, &ray, &hit), direction),
                          .geometric_normal = facing(hit.normal, direction),
                          .u = hit.u,
                          .v = hit.v,
                          .surface = hit.surface};
}
