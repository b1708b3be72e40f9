#ifndef PM_FILES_MESH_H
#define PM_FILES_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/vec3.h"
#include "files/records.h"

/* Triangle meshes, from Wavefront .obj text or from Radiance's compiled .rtm.
 *
 * In: the bytes of a file. Out: pm_mesh. Next: scene/scene.h makes prototypes of them. */

/* Slot of a triangle that no `usemtl` and no compiled material covers. */
enum { PM_MESH_NO_SLOT = 0x3fffffff };

typedef struct pm_mesh_triangle {
    uint32_t corner[3];       /* indices of vertices, all different; its front has them ccw */
    uint32_t slot : 30;       /* index of its material's slot, or PM_MESH_NO_SLOT */
    uint32_t has_normals : 1; /* the normals of its three corners may be interpolated */
    uint32_t has_uv : 1;      /* and their texture coordinates */
} pm_mesh_triangle;

/* Immutable; in the mesh's own units. Every number is finite, every index in range, and every
 * triangle has an area. */
typedef struct pm_mesh {
    const pm_vec3 *positions;
    const float (*normals)[3]; /* unit, or 0 where a vertex has none; NULL without any */
    const double (*uv)[2];     /* NULL without any */
    const pm_mesh_triangle *triangles;
    uint32_t vertex_count, triangle_count; /* at least one triangle */

    /* Names of materials: what `usemtl` (or else the group) says, or of the compiled ones, in
     * the order of the file's records (files/records.h). */
    const char *const *slots;
    uint32_t slot_count;
    bool is_compiled; /* its materials are in its file */

    pm_vec3 low, high; /* bounds of the triangles' corners */
    struct pm_mesh_memory *memory;
} pm_mesh;

/* Zero means the default. */
typedef struct pm_mesh_limits {
    size_t triangles; /* default 50 million */
} pm_mesh_limits;

/* Reads either kind, known by Radiance's header. `name` is for messages.
 *
 * .obj as Radiance's obj2mesh reads it: v, vt, vn, f (v, v/t, v//n, v/t/n, indices from 1 or
 * negative from the last), usemtl, g for faces before the first usemtl; o, s, l, p, mtllib,
 * usemap and w components are passed over; other statements are refused. Polygons are cut into
 * triangles, holes by seams. A triangle whose normals all point backwards is turned; normals
 * within 0.18 degrees of the flat one are dropped; a triangle without area is left out.
 * .rtm: whatever its octree says is only checked, triangles come from the patches.
 *
 * Errors: PM_E_SYNTAX, PM_E_RANGE (.obj, with line and column), PM_E_CORRUPT (.rtm),
 * PM_E_LIMIT, PM_E_MEMORY.
 * Source: Radiance, src/ot/wfconv.c, src/ot/cvmesh.c, src/common/readmesh.c, mesh.c, dircode.c
 * (formats). Tests: test_obj.c, test_rtm.c. */
PM_MUST_USE pm_status pm_mesh_read(const void *data, size_t size, const char *name,
                                   const pm_mesh_limits *limits, pm_mesh **out, pm_error *err);
void pm_mesh_free(pm_mesh *mesh);

/* The materials of a compiled mesh, one for each slot: what applies where the mesh primitive's
 * modifier is void. Lists are put into the arena, texts lie in `data`. None for an .obj. */
PM_MUST_USE pm_status pm_mesh_materials(const void *data, size_t size, const char *name,
                                        pm_arena *arena, pm_records *out, pm_error *err);

#endif
