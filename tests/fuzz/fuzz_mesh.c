/* Reads the input as a mesh, of either kind, and checks what the header promises. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "files/mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_triangle(const pm_mesh *mesh, const pm_mesh_triangle *t)
{
    for (int i = 0; i < 3; i++)
        check(t->corner[i] < mesh->vertex_count && t->corner[i] != t->corner[(i + 1) % 3]);
    check(t->slot == PM_MESH_NO_SLOT || t->slot < mesh->slot_count);
    for (int i = 0; i < 3; i++) {
        pm_vec3 p = mesh->positions[t->corner[i]];
        check(p.x >= mesh->low.x && p.y <= mesh->high.y && p.z >= mesh->low.z);
        if (t->has_normals) {
            const float *n = mesh->normals[t->corner[i]];
            check(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-5F);
        }
        if (t->has_uv)
            check(isfinite(mesh->uv[t->corner[i]][0]) && isfinite(mesh->uv[t->corner[i]][1]));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const pm_mesh_limits limits = {.triangles = 20000};
    pm_error err = PM_ERROR_INIT, other = PM_ERROR_INIT;
    pm_arena arena = {0};
    pm_records records = {0};
    pm_mesh *mesh = NULL;
    pm_status st = pm_mesh_read(data, size, "fuzz", &limits, &mesh, &err);
    check(err.status == st && !st == !err.text[0] && !st == (mesh != NULL));
    if (mesh) {
        check(mesh->triangle_count > 0 && pm_vec3_finite(mesh->low) &&
              pm_vec3_finite(mesh->high));
        for (uint32_t i = 0; i < mesh->triangle_count; i++)
            check_triangle(mesh, &mesh->triangles[i]);
        check(!pm_mesh_materials(data, size, "fuzz", &arena, &records, &other));
        check(records.count == (mesh->is_compiled ? mesh->slot_count : 0));
    }
    pm_arena_clear(&arena);
    pm_mesh_free(mesh);
    return 0;
}
