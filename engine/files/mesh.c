#include "files/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files/mesh_build.h"

static pm_status memory_error(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "not enough memory for the mesh");
}

/* Makes room for one more; the array stays valid if it cannot grow. */
static bool grow(void **array, size_t element, size_t capacity)
{
    void *more = realloc(*array, capacity * element);
    if (more)
        *array = more;
    return more != NULL;
}

static bool grow_vertices(struct pm_mesh_memory *m)
{
    size_t capacity = m->vertex_capacity ? 2 * m->vertex_capacity : 256;
    if (!grow((void **)&m->positions, sizeof *m->positions, capacity) ||
        !grow((void **)&m->has, sizeof *m->has, capacity) ||
        (m->normals && !grow((void **)&m->normals, sizeof *m->normals, capacity)) ||
        (m->uv && !grow((void **)&m->uv, sizeof *m->uv, capacity)))
        return false;
    m->vertex_capacity = capacity;
    return true;
}

pm_status pm_mesh_add_vertex(struct pm_mesh_memory *m, pm_vec3 position, const float *normal,
                             const double *uv, uint32_t *index, pm_error *err)
{
    uint32_t i = m->mesh.vertex_count;
    if (i == UINT32_MAX)
        return pm_error_set(err, PM_E_LIMIT, "the mesh has 2^32 vertices or more; split it");
    if (i == m->vertex_capacity && !grow_vertices(m))
        return memory_error(err);
    if (normal && !m->normals)
        m->normals = calloc(m->vertex_capacity, sizeof *m->normals);
    if (uv && !m->uv)
        m->uv = calloc(m->vertex_capacity, sizeof *m->uv);
    if ((normal && !m->normals) || (uv && !m->uv))
        return memory_error(err);
    m->positions[i] = position;
    m->has[i] = (unsigned char)((normal ? 1 : 0) | (uv ? 2 : 0));
    for (int k = 0; m->normals && k < 3; k++)
        m->normals[i][k] = normal ? normal[k] : 0;
    for (int k = 0; m->uv && k < 2; k++)
        m->uv[i][k] = uv ? uv[k] : 0;
    m->mesh.vertex_count++;
    *index = i;
    return PM_OK;
}

pm_status pm_mesh_add_triangle(struct pm_mesh_memory *m, pm_mesh_triangle triangle,
                               pm_error *err)
{
    size_t count = m->mesh.triangle_count;
    if (count >= m->triangle_limit)
        return pm_error_set(err, PM_E_LIMIT, "the mesh has more than %zu triangles; split it",
                            m->triangle_limit);
    if (count == m->triangle_capacity) {
        size_t capacity = count ? 2 * count : 256;
        if (!grow((void **)&m->triangles, sizeof *m->triangles, capacity))
            return memory_error(err);
        m->triangle_capacity = capacity;
    }
    m->triangles[m->mesh.triangle_count++] = triangle;
    return PM_OK;
}

pm_status pm_mesh_add_slot(struct pm_mesh_memory *m, const char *name, size_t length,
                           uint32_t *slot, pm_error *err)
{
    size_t count = m->mesh.slot_count;
    if (count >= PM_MESH_NO_SLOT)
        return pm_error_set(err, PM_E_LIMIT, "the mesh has too many materials; split it");
    if (count == m->slot_capacity) {
        size_t capacity = count ? 2 * count : 16;
        if (!grow((void **)&m->slots, sizeof *m->slots, capacity))
            return memory_error(err);
        m->slot_capacity = capacity;
    }
    m->slots[count] = pm_arena_text(&m->arena, name, length);
    if (!m->slots[count])
        return memory_error(err);
    *slot = m->mesh.slot_count++;
    return PM_OK;
}

void pm_mesh_set_presence(const struct pm_mesh_memory *m, pm_mesh_triangle *triangle)
{
    const uint32_t *c = triangle->corner;
    int has = m->has[c[0]] & m->has[c[1]] & m->has[c[2]];
    triangle->has_normals = (has & 1) != 0;
    triangle->has_uv = (has & 2) != 0;
}

pm_vec3 pm_mesh_normal(const struct pm_mesh_memory *m, const uint32_t corner[3])
{
    pm_vec3 a = m->positions[corner[0]];
    return pm_vec3_cross(pm_vec3_sub(m->positions[corner[1]], a),
                         pm_vec3_sub(m->positions[corner[2]], a));
}

static void set_bounds(struct pm_mesh_memory *m)
{
    pm_vec3 low = {INFINITY, INFINITY, INFINITY}, high = pm_vec3_negate(low);
    for (uint32_t i = 0; i < m->mesh.triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            pm_vec3 p = m->positions[m->triangles[i].corner[k]];
            low = pm_vec3_make(fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z));
            high = pm_vec3_make(fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z));
        }
    }
    m->mesh.low = low;
    m->mesh.high = high;
}

static bool is_compiled(const void *data, size_t size)
{
    return size >= 2 && memcmp(data, "#?", 2) == 0;
}

static pm_status finish(struct pm_mesh_memory *m, const char *name, pm_error *err)
{
    if (m->mesh.triangle_count == 0)
        return pm_error_set_at(err, PM_E_RANGE, name, 0, 0,
                               "the mesh has no triangle with an area");
    set_bounds(m);
    m->mesh.positions = m->positions;
    m->mesh.normals = (const float(*)[3])m->normals;
    m->mesh.uv = (const double(*)[2])m->uv;
    m->mesh.triangles = m->triangles;
    m->mesh.slots = m->slots;
    m->mesh.memory = m;
    return PM_OK;
}

/* What the builder says about memory and limits lacks the file. */
static pm_status with_place(pm_status st, const char *name, const pm_error *inner,
                            pm_error *err)
{
    if (inner->status && !inner->file[0])
        return pm_error_set_at(err, st, name, 0, 0, "%s", inner->text);
    if (inner->status && err && !err->status)
        *err = *inner;
    return st;
}

static void memory_free(struct pm_mesh_memory *m)
{
    free(m->positions);
    free(m->normals);
    free(m->uv);
    free(m->triangles);
    free(m->slots);
    free(m->has);
    pm_arena_clear(&m->arena);
    free(m);
}

pm_status pm_mesh_read(const void *data, size_t size, const char *name,
                       const pm_mesh_limits *limits, pm_mesh **out, pm_error *err)
{
    size_t most = limits && limits->triangles ? limits->triangles : 50000000;
    struct pm_mesh_memory *m = calloc(1, sizeof *m);
    if (!m)
        return memory_error(err);
    m->triangle_limit = most < UINT32_MAX ? most : UINT32_MAX - 1;
    pm_error inner = PM_ERROR_INIT;
    m->mesh.is_compiled = is_compiled(data, size);
    pm_status st = m->mesh.is_compiled ? pm_mesh_read_rtm(data, size, name, m, &inner)
                                       : pm_mesh_read_obj(data, size, name, m, &inner);
    if (!st)
        st = finish(m, name, &inner);
    if (!st)
        *out = &m->mesh;
    else
        memory_free(m);
    return with_place(st, name, &inner, err);
}

void pm_mesh_free(pm_mesh *mesh)
{
    if (mesh)
        memory_free(mesh->memory);
}

pm_status pm_mesh_materials(const void *data, size_t size, const char *name, pm_arena *arena,
                            pm_records *out, pm_error *err)
{
    if (is_compiled(data, size))
        return pm_mesh_rtm_materials(data, size, name, arena, out, err);
    *out = (pm_records){0};
    return PM_OK;
}
