#include "world/media.h"
#include "world/rays.h"

/* What is left of the light over one stretch of the ray. */
static void attenuate(const pm_world *world, const pm_media *media, double length,
                      pm_rgb *share)
{
    pm_medium medium;
    if (media->count && pm_media_medium(media, world, &medium))
        *share = pm_rgb_mul(*share, pm_medium_transmittance(&medium, length));
}

pm_rgb pm_world_transmittance(const pm_world *world, const pm_ray *ray,
                              const struct pm_media *start, bool weak)
{
    if (!world->passes_straight && !world->has_media)
        return pm_rgb_grey(pm_rays_any(world, ray) ? 0 : 1);
    struct pm_ray_walk walk = {.started = false};
    pm_media media = *start;
    pm_rgb share = pm_rgb_grey(1);
    double reached = 0;
    pm_hit hit;
    while (pm_rays_next(world, ray, &walk, &hit)) {
        pm_media_meet(&media, world, &hit, ray->direction);
        attenuate(world, &media, hit.t - reached, &share);
        pm_rgb through = pm_material_straight(world, &hit, ray->direction, &media, weak);
        share = pm_rgb_mul(share, through);
        if (pm_rgb_is_black(share))
            return share;
        pm_media_cross(&media, world, &hit, ray->direction);
        reached = hit.t;
    }
    attenuate(world, &media, ray->t_max - reached, &share);
    return share;
}
