#include "world/sight.h"

#include <math.h>

#include "base/warp.h"
#include "world/body.h"
#include "world/material.h"

enum { PASSAGES_MAX = 64 }; /* surfaces in a row that let light through */

static bool lets_through(const struct pm_material *m)
{
    switch (m->type) {
    case PM_GLASS:
    case PM_DIELECTRIC:
    case PM_INTERFACE:
    case PM_TRANS:
    case PM_TRANS2:
    case PM_TRANSFUNC:
    case PM_TRANSDATA:
    case PM_BRTDFUNC:
    case PM_BSDF:
    case PM_ABSDF:
    case PM_PRISM1:
    case PM_PRISM2:
    case PM_MIST:
    case PM_ANTIMATTER:
        return true;
    default:
        return m->straight;
    }
}

bool pm_sight_out(const pm_world *world, pm_vec3 point, pm_vec3 direction, pm_vec3 *last,
                  bool *passes)
{
    *passes = false;
    *last = point;
    pm_ray ray = {point, direction, INFINITY, PM_NO_PRIMITIVE};
    for (int i = 0; i < PASSAGES_MAX; i++) {
        pm_hit hit;
        if (!pm_world_intersect(world, &ray, &hit))
            return true;
        *last = hit.point;
        if (!lets_through(&world->materials[hit.material]))
            return false;
        *passes = true;
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    return false;
}

bool pm_sight_reaches(const pm_world *world, pm_vec3 point, uint32_t from, pm_vec3 end)
{
    pm_vec3 way = pm_vec3_sub(end, point);
    double length = pm_vec3_length(way) * (1 - 0x1p-20);
    pm_ray ray = {point, pm_vec3_normalize(way), length, from};
    for (int i = 0; i < PASSAGES_MAX; i++) {
        pm_hit hit;
        if (!(ray.t_max > 0) || !pm_world_intersect(world, &ray, &hit))
            return true;
        if (!lets_through(&world->materials[hit.material]))
            return false;
        ray.t_max -= hit.t;
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    return false;
}

pm_vec3 pm_sight_direction(uint32_t i)
{
    return pm_warp_sphere((i + .5) / PM_SIGHTS, fmod(i * .6180339887498949, 1));
}

pm_sight_place pm_sight_around(const pm_world *world, pm_vec3 point)
{
    pm_sight_place place = {.point = point};
    double inverse = 0;
    int ended = 0;
    for (uint32_t i = 0; i < PM_SIGHTS; i++) {
        pm_vec3 end;
        bool passes;
        if (pm_sight_out(world, point, pm_sight_direction(i), &end, &passes))
            continue;
        inverse += 1 / (pm_vec3_distance(point, end) + 0x1p-40);
        ended++;
    }
    place.closed = (double)ended / PM_SIGHTS;
    place.room = ended ? ended / inverse : 0;
    return place;
}
