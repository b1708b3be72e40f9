#include "world/placed.h"

#include <math.h>

#include "world/body.h"
#include "world/mesh_body.h"
#include "world/world_internal.h"

static void corners_of(const struct pm_mesh_body *mesh, uint32_t triangle, pm_vec3 p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = mesh->positions[mesh->mesh->triangles[triangle].corner[i]];
}

static double local_area(const struct pm_body *body, uint32_t local)
{
    if (!body->mesh.mesh)
        return body->shapes[local].area;
    pm_vec3 p[3];
    corners_of(&body->mesh, local, p);
    return pm_vec3_length(pm_vec3_cross(pm_vec3_sub(p[1], p[0]), pm_vec3_sub(p[2], p[0]))) / 2;
}

double pm_placed_area(const pm_world *world, uint32_t surface)
{
    struct pm_place place;
    pm_place_find(world->main, surface, &place);
    double area = local_area(place.body, place.local);
    for (int i = 0; i < place.depth; i++)
        area *= place.chain[i]->unit * place.chain[i]->unit;
    return area;
}

/* Turk, "Generating random points in triangles", Graphics Gems, 1990. */
static void sample_triangle(const struct pm_mesh_body *mesh, uint32_t triangle, double u,
                            double v, pm_vec3 *point, pm_vec3 *normal)
{
    pm_vec3 p[3];
    corners_of(mesh, triangle, p);
    double root = sqrt(u);
    pm_vec3 sum = pm_vec3_scale(p[0], 1 - root);
    sum = pm_vec3_madd(sum, root * (1 - v), p[1]);
    *point = pm_vec3_madd(sum, root * v, p[2]);
    *normal = pm_mesh_body_normal(mesh, triangle);
}

void pm_placed_sample(const pm_world *world, uint32_t surface, double u, double v,
                      pm_vec3 *point, pm_vec3 *normal)
{
    struct pm_place place;
    pm_place_find(world->main, surface, &place);
    if (place.body->mesh.mesh)
        sample_triangle(&place.body->mesh, place.local, u, v, point, normal);
    else
        pm_shape_sample(&place.body->shapes[place.local], u, v, point, normal);
    for (int i = place.depth; i-- > 0;) {
        *point = pm_instance_point_out(place.chain[i], *point);
        *normal = pm_instance_direction_out(place.chain[i], *normal);
    }
    *normal = pm_vec3_normalize(*normal);
}
