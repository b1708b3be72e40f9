#ifndef PM_FILES_MESH_BUILD_H
#define PM_FILES_MESH_BUILD_H

#include "base/arena.h"
#include "files/mesh.h"

/* A mesh while it is read; what obj.c and rtm.c share. */
struct pm_mesh_memory {
    pm_mesh mesh; /* counts as far as it was read */
    pm_vec3 *positions;
    float (*normals)[3];
    double (*uv)[2];
    pm_mesh_triangle *triangles;
    const char **slots;
    unsigned char *has; /* by vertex: bit 0 a normal, bit 1 texture coordinates */
    size_t vertex_capacity, triangle_capacity, slot_capacity, triangle_limit;
    pm_arena arena; /* names */
};

/* Coordinates are at most this, so that squares of areas stay finite. */
#define PM_MESH_LARGEST 1e75

/* All return PM_E_MEMORY or PM_E_LIMIT with a text but without a place; `err` is given one by
 * the caller. `normal` (unit) and `uv` may be NULL. */
PM_MUST_USE pm_status pm_mesh_add_vertex(struct pm_mesh_memory *m, pm_vec3 position,
                                         const float *normal, const double *uv, uint32_t *index,
                                         pm_error *err);
PM_MUST_USE pm_status pm_mesh_add_triangle(struct pm_mesh_memory *m, pm_mesh_triangle triangle,
                                           pm_error *err);
PM_MUST_USE pm_status pm_mesh_add_slot(struct pm_mesh_memory *m, const char *name,
                                       size_t length, uint32_t *slot, pm_error *err);

/* Sets has_normals and has_uv from what the corners have. */
void pm_mesh_set_presence(const struct pm_mesh_memory *m, pm_mesh_triangle *triangle);

/* Twice the triangle's area along its normal. */
pm_vec3 pm_mesh_normal(const struct pm_mesh_memory *m, const uint32_t corner[3]);

PM_MUST_USE pm_status pm_mesh_read_obj(const char *text, size_t size, const char *name,
                                       struct pm_mesh_memory *m, pm_error *err);
PM_MUST_USE pm_status pm_mesh_read_rtm(const void *data, size_t size, const char *name,
                                       struct pm_mesh_memory *m, pm_error *err);
PM_MUST_USE pm_status pm_mesh_rtm_materials(const void *data, size_t size, const char *name,
                                            pm_arena *arena, pm_records *out, pm_error *err);

#endif
