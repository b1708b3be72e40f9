#ifndef PM_WORLD_MESH_BODY_H
#define PM_WORLD_MESH_BODY_H

#include "base/arena.h"
#include "world/probe.h"

/* A mesh's triangles as rays meet them, from its vertices and indices alone: in a mesh of a
 * million triangles they take about 120 bytes each, most of it in the tree. */

/* Fills body->mesh from the mesh, in the body's coordinates. */
PM_MUST_USE pm_status pm_mesh_body_make(struct pm_body *body, const pm_mesh *mesh,
                                        const uint32_t *materials, pm_arena *arena,
                                        pm_error *err);

/* Where a triangle comes among those with the same corners (two-sided leaves, say), as
 * pm_shape's group, layer and flipped do. */
struct pm_mesh_side {
    uint32_t group;
    int64_t layer;
    bool flipped;
};

struct pm_mesh_side pm_mesh_body_side(const struct pm_mesh_body *mesh, uint32_t triangle);

uint32_t pm_mesh_body_material(const struct pm_mesh_body *mesh, uint32_t triangle);
uint32_t pm_mesh_body_modifier(const struct pm_mesh_body *mesh, uint32_t triangle);

/* Unit normal of the front: from there the corners go counter-clockwise. */
pm_vec3 pm_mesh_body_normal(const struct pm_mesh_body *mesh, uint32_t triangle);

void pm_mesh_body_bounds(const struct pm_mesh_body *mesh, uint32_t triangle, pm_vec3 *low,
                         pm_vec3 *high);

/* The exact test, watertight as that of pieces.h is. True if the triangle is the best so far.
 */
bool pm_probe_triangle(struct pm_probe *probe, uint32_t triangle);

/* Point, normal, coordinates and perturbation at the point of the triangle's plane that is
 * nearest to `point`, in the body's coordinates, as Radiance's o_mesh.c has them: weights of
 * the corners by area; normals and coordinates that the three corners do not all have are 0. */
void pm_mesh_body_fill_hit(const struct pm_mesh_body *mesh, uint32_t triangle, pm_vec3 point,
                           pm_hit *hit);

#endif
