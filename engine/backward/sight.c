#include "backward/backward_internal.h"

/* Sight lines run so high above the surface [world units], more than the step of stored
 * positions: what stands on the surface crosses them, the surface itself does not. */
#define HEIGHT 0x1p-24

enum { LAYERS_MAX = 16 }; /* passed on one line: more than that is no clear view */

bool pm_walls_near(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 normal,
                   double radius, pm_between *walls)
{
    if (!pm_world_stands_near(pass->world, spot->point, normal, radius, spot->from))
        return false;
    pm_world_between(pass->world, spot->point, normal, radius, spot->from, walls);
    return !pm_between_nothing(walls);
}

/* Between two places of a curved surface lies the surface itself, or its next facets, which
 * lean less than walls do. */
static bool blocks(const struct pm_pass *pass, const struct pm_spot *spot, pm_vec3 up,
                   const pm_hit *hit)
{
    return hit->surface != spot->from && pm_surface_blocks(pass->world, hit) &&
           fabs(pm_vec3_dot(hit->normal, up)) < PM_STEEP_COSINE * pm_vec3_length(up);
}

bool pm_sees(const struct pm_pass *pass, const struct pm_spot *spot, const pm_between *walls,
             pm_vec3 normal, pm_vec3 place, pm_vec3 place_normal)
{
    pm_vec3 from = pm_vec3_madd(spot->point, HEIGHT, normal);
    pm_vec3 to = pm_vec3_madd(place, HEIGHT, place_normal);
    if (pm_between_clear(walls, from, to))
        return true;
    pm_vec3 way = pm_vec3_sub(to, from);
    double length = pm_vec3_length(way);
    if (!(length > 0))
        return true;
    pm_ray ray = {from, pm_vec3_scale(way, 1 / length), length, PM_NO_PRIMITIVE};
    pm_vec3 up = pm_vec3_add(normal, place_normal);
    pm_hit hit;
    for (int i = 0; i < LAYERS_MAX; i++) {
        if (!(ray.t_max > 0) || !pm_world_intersect(pass->world, &ray, &hit))
            return true;
        if (blocks(pass, spot, up, &hit))
            return false;
        ray.origin = hit.point;
        ray.from = hit.surface;
        ray.t_max -= hit.t;
    }
    return false;
}
