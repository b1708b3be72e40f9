#include "files/mesh_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "files/records.h"

/* Radiance's compiled meshes: header, cube, limits of texture coordinates, octree, materials,
 * patches of at most 256 vertices. A triangle lies inside a patch or joins two or three.
 * Source: src/common/mesh.h, readmesh.c, mesh.c. */

#define FORMAT "Radiance_tmesh"
enum { PATCH_VERTICES = 256, LOCAL_TRIANGLES = 512, JOINERS = 256 };
enum { HAS_POSITION = 1, HAS_NORMAL = 2, HAS_UV = 4 };

struct rtm {
    pm_reader bytes;
    unsigned index_size;
    const char *name;
    struct pm_mesh_memory *mesh;
    pm_arena *arena; /* of the materials */
    pm_error *err;
    double origin[3], size;
    double uv_low[2], uv_high[2];
    pm_records materials;
    uint32_t *first; /* vertex of each patch */
    uint32_t patch_count;
};

static pm_status fail(const struct rtm *r, const char *what)
{
    return pm_portable_error(&r->bytes, r->name, what, r->err);
}

static pm_status read_head(struct rtm *r)
{
    if (!pm_portable_header(&r->bytes, FORMAT, PM_MESH_MAGIC, &r->index_size))
        return pm_error_set_at(r->err, PM_E_CORRUPT, r->name, 0, 0,
                               "this is no compiled mesh; obj2mesh makes them of .obj files");
    if (!pm_portable_cube(&r->bytes, r->origin, &r->size))
        return fail(r, "the bounding cube");
    for (int i = 0; i < 3; i++)
        if (!(r->size > 0 && fabs(r->origin[i]) + r->size <= PM_MESH_LARGEST))
            return fail(r, "the bounding cube");
    for (int i = 0; i < 2; i++) {
        r->uv_low[i] = pm_portable_real(&r->bytes);
        r->uv_high[i] = pm_portable_real(&r->bytes);
    }
    pm_status st =
        pm_portable_tree(&r->bytes, r->index_size, (uint64_t)1 << 32, NULL, r->name, r->err);
    if (st)
        return st;
    return pm_records_read(&r->bytes, r->index_size, PM_MESH_NO_SLOT, r->name, r->arena,
                           &r->materials, r->err);
}

static pm_status add_slots(struct rtm *r)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < r->materials.count; i++) {
        uint32_t slot;
        const char *name = r->materials.items[i].name;
        st = pm_mesh_add_slot(r->mesh, name, strlen(name), &slot, r->err);
    }
    return st;
}

/* ---- vertices ---- */

/* Two of the three components in 13 bits each; the largest follows from them (dircode.c). */
static void decode_normal(uint32_t code, float normal[3])
{
    enum { FIRST_IS_X = 8, SECOND_IS_Z = 16, MASK = 0x1fff };
    const double scale = 1 / 11584.5; /* (2^13 - 1/2) sqrt 2 */
    double first = (code >> 5 & MASK) * scale, second = (code >> 18 & MASK) * scale;
    double largest = sqrt(1 - first * first - second * second);
    double n[3];
    n[code & FIRST_IS_X ? 0 : 1] = first;
    if (code & SECOND_IS_Z) {
        n[2] = second;
        n[code & FIRST_IS_X ? 1 : 0] = largest;
    } else {
        n[code & FIRST_IS_X ? 1 : 0] = second;
        n[2] = largest;
    }
    for (int i = 0; i < 3; i++)
        normal[i] = (float)(code >> i & 1 ? -n[i] : n[i]);
}

static uint32_t unsigned_at(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* A coordinate in 32 bits between two limits. */
static double between(uint32_t code, double low, double size)
{
    return low + (code + .5) * (size / 4294967296.);
}

struct patch_vertices {
    const uint8_t *positions, *normals, *uv;
};

static pm_status add_vertex(struct rtm *r, const struct patch_vertices *v, uint32_t i)
{
    double p[3], uv[2] = {0, 0};
    float normal[3];
    uint32_t index, code = v->normals ? unsigned_at(v->normals + 4 * i) : 0;
    bool has_uv = v->uv && unsigned_at(v->uv + 8 * i) != 0;
    for (uint32_t k = 0; k < 3; k++)
        p[k] = between(unsigned_at(v->positions + 12 * i + 4 * k), r->origin[k], r->size);
    for (uint32_t k = 0; has_uv && k < 2; k++)
        uv[k] = between(unsigned_at(v->uv + 8 * i + 4 * k), r->uv_low[k],
                        r->uv_high[k] - r->uv_low[k]);
    if (code)
        decode_normal(code, normal);
    return pm_mesh_add_vertex(r->mesh, pm_vec3_make(p[0], p[1], p[2]), code ? normal : NULL,
                              has_uv ? uv : NULL, &index, r->err);
}

/* A vertex has texture coordinates if the first of their codes is not 0. */
static pm_status read_vertices(struct rtm *r, uint32_t *count)
{
    int64_t flags = pm_portable_integer(&r->bytes, 1);
    int64_t n = pm_portable_integer(&r->bytes, 2);
    if (!(flags & HAS_POSITION) || flags & ~(HAS_POSITION | HAS_NORMAL | HAS_UV))
        return fail(r, "a patch");
    if (n < 1 || n > PATCH_VERTICES)
        return fail(r, "the number of a patch's vertices");
    size_t size = (size_t)n * 4;
    struct patch_vertices v = {.positions = pm_reader_take(&r->bytes, 3 * size)};
    v.normals = flags & HAS_NORMAL ? pm_reader_take(&r->bytes, size) : NULL;
    v.uv = flags & HAS_UV ? pm_reader_take(&r->bytes, 2 * size) : NULL;
    if (r->bytes.failed)
        return fail(r, "a patch's vertices");
    if (v.uv && !(r->uv_high[0] > r->uv_low[0] && r->uv_high[1] > r->uv_low[1]))
        return fail(r, "the range of texture coordinates");
    pm_status st = PM_OK;
    for (uint32_t i = 0; !st && i < (uint32_t)n; i++)
        st = add_vertex(r, &v, i);
    *count = (uint32_t)n;
    return st;
}

/* ---- triangles ---- */

/* Corners are patch << 8 | vertex until all patches are read. */
static pm_status add_triangle(struct rtm *r, const int64_t corner[3], int64_t material)
{
    pm_mesh_triangle t = {.slot = PM_MESH_NO_SLOT};
    for (int i = 0; i < 3; i++) {
        if (corner[i] < 0 || corner[i] > INT32_MAX)
            return fail(r, "a corner of a triangle");
        t.corner[i] = (uint32_t)corner[i];
    }
    if (r->materials.count > 0) {
        if (material < 0 || (uint64_t)material >= r->materials.count)
            return fail(r, "the material of a triangle");
        t.slot = (uint32_t)material & PM_MESH_NO_SLOT;
    }
    return pm_mesh_add_triangle(r->mesh, t, r->err);
}

static int64_t local_corner(struct rtm *r, uint32_t patch)
{
    return (int64_t)patch << 8 | (pm_portable_integer(&r->bytes, 1) & 0xff);
}

static pm_status read_local(struct rtm *r, uint32_t patch)
{
    pm_status st = PM_OK;
    int64_t count = pm_portable_integer(&r->bytes, 2);
    if (count < 0 || count > LOCAL_TRIANGLES)
        return fail(r, "the number of a patch's triangles");
    const uint8_t *corners = pm_reader_take(&r->bytes, 3 * (size_t)count);
    int64_t materials = pm_portable_integer(&r->bytes, 2);
    if (r->bytes.failed || (materials > 1 && materials != count))
        return fail(r, "the materials of a patch");
    int64_t material = materials > 1 ? 0 : pm_portable_integer(&r->bytes, 2);
    for (int64_t i = 0; !st && i < count; i++) {
        int64_t corner[3];
        for (int64_t k = 0; k < 3; k++)
            corner[k] = (int64_t)patch << 8 | corners[3 * i + k];
        if (materials > 1)
            material = pm_portable_integer(&r->bytes, 2);
        st = add_triangle(r, corner, material);
    }
    return st;
}

/* Triangles with one or two corners in other patches. */
static pm_status read_joiners(struct rtm *r, uint32_t patch, int far)
{
    pm_status st = PM_OK;
    int64_t count = pm_portable_integer(&r->bytes, 2);
    if (r->bytes.failed || count < 0 || count > JOINERS)
        return fail(r, "the number of a patch's joining triangles");
    for (int64_t i = 0; !st && i < count; i++) {
        int64_t corner[3];
        for (int k = 0; k < 3; k++)
            corner[k] = k < far ? pm_portable_integer(&r->bytes, 4) : local_corner(r, patch);
        int64_t material = pm_portable_integer(&r->bytes, 2);
        st = r->bytes.failed ? fail(r, "a patch's joining triangles")
                             : add_triangle(r, corner, material);
    }
    return st;
}

static pm_status read_patches(struct rtm *r)
{
    enum { LEAST = 1 + 2 + 12 + 2 + 2 + 2 + 2 + 2 }; /* bytes of a patch */
    int64_t count = pm_portable_integer(&r->bytes, 4);
    if (r->bytes.failed || count < 0 || (size_t)count > (r->bytes.size - r->bytes.at) / LEAST ||
        count >= 1 << 22)
        return fail(r, "the number of patches");
    r->first = calloc((size_t)count + 1, sizeof *r->first);
    if (!r->first)
        return pm_error_set(r->err, PM_E_MEMORY, "not enough memory for the mesh");
    pm_status st = PM_OK;
    for (uint32_t i = 0; !st && i < (uint32_t)count; i++) {
        uint32_t vertices = 0;
        st = read_vertices(r, &vertices);
        r->first[i + 1] = r->first[i] + vertices;
        if (!st)
            st = read_local(r, i);
        for (int far = 1; !st && far <= 2; far++)
            st = read_joiners(r, i, far);
    }
    r->patch_count = (uint32_t)count;
    return st;
}

static bool place_corner(const struct rtm *r, uint32_t *corner)
{
    uint32_t patch = *corner >> 8, vertex = *corner & 0xff;
    if (patch >= r->patch_count || vertex >= r->first[patch + 1] - r->first[patch])
        return false;
    *corner = r->first[patch] + vertex;
    return true;
}

/* Puts the numbers of vertices into the triangles and leaves out those without area. */
static pm_status place_triangles(struct rtm *r)
{
    struct pm_mesh_memory *m = r->mesh;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < m->mesh.triangle_count; i++) {
        pm_mesh_triangle t = m->triangles[i];
        for (int k = 0; k < 3; k++)
            if (!place_corner(r, &t.corner[k]))
                return fail(r, "a corner of a triangle");
        pm_mesh_set_presence(m, &t);
        if (pm_vec3_length(pm_mesh_normal(m, t.corner)) > 0)
            m->triangles[kept++] = t;
    }
    m->mesh.triangle_count = kept;
    return PM_OK;
}

static pm_status read_all(struct rtm *r)
{
    pm_status st = read_head(r);
    if (!st)
        st = add_slots(r);
    if (!st)
        st = read_patches(r);
    if (!st)
        st = place_triangles(r);
    if (!st && r->bytes.at < r->bytes.size)
        return fail(r, "what follows the last patch");
    return st;
}

pm_status pm_mesh_read_rtm(const void *data, size_t size, const char *name,
                           struct pm_mesh_memory *m, pm_error *err)
{
    pm_arena scratch = {0};
    struct rtm r = {.bytes = {.data = data, .size = size}, .name = name, .mesh = m, .err = err};
    r.arena = &scratch;
    pm_status st = read_all(&r);
    free(r.first);
    pm_arena_clear(&scratch);
    return st;
}

pm_status pm_mesh_rtm_materials(const void *data, size_t size, const char *name,
                                pm_arena *arena, pm_records *out, pm_error *err)
{
    struct rtm r = {
        .bytes = {.data = data, .size = size}, .name = name, .arena = arena, .err = err};
    pm_status st = read_head(&r);
    if (!st)
        *out = r.materials;
    return st;
}
