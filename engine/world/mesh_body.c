#include "world/mesh_body.h"

#include <stdlib.h>
#include <string.h>

#include "base/radix.h"
#include "world/watertight.h"

/* ---- corners ---- */

static pm_vec3 corner_of(const struct pm_mesh_body *m, uint32_t triangle, int i)
{
    return m->positions[m->mesh->triangles[triangle].corner[i]];
}

static bool comes_before(pm_vec3 a, pm_vec3 b)
{
    if (a.x != b.x)
        return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

static bool swap_if(pm_vec3 *a, pm_vec3 *b)
{
    bool swap = comes_before(*b, *a);
    pm_vec3 first = swap ? *b : *a;
    *b = swap ? *a : *b;
    *a = first;
    return swap;
}

/* The corners in an order that triangles with the same corners share; true if they turn the
 * other way round in it. */
static bool sorted_corners(const struct pm_mesh_body *m, uint32_t triangle, pm_vec3 p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = corner_of(m, triangle, i);
    bool odd = swap_if(&p[0], &p[1]);
    odd = odd != swap_if(&p[1], &p[2]);
    return odd != swap_if(&p[0], &p[1]);
}

/* As the tests take them: in the common order if there are twins. */
static bool corners(const struct pm_mesh_body *m, uint32_t triangle, pm_vec3 p[3])
{
    if (m->group)
        return sorted_corners(m, triangle, p);
    for (int i = 0; i < 3; i++)
        p[i] = corner_of(m, triangle, i);
    return false;
}

/* ---- building ---- */

static uint64_t key_of(const struct pm_mesh_body *m, uint32_t triangle)
{
    pm_vec3 p[3];
    uint64_t bits[9], h = 0;
    sorted_corners(m, triangle, p);
    for (int i = 0; i < 3; i++)
        p[i] = pm_vec3_add(p[i], pm_vec3_make(0, 0, 0)); /* -0 + 0 = 0 */
    memcpy(bits, p, sizeof bits);
    for (int i = 0; i < 9; i++) {
        h = (h ^ bits[i]) * 0x9E3779B97F4A7C15U;
        h ^= h >> 32;
    }
    return h;
}

static int by_corners(const void *a, const void *b, void *context)
{
    const pm_keyed *x = a, *y = b;
    pm_vec3 p[3], q[3];
    sorted_corners(context, x->value, p);
    sorted_corners(context, y->value, q);
    for (int i = 0; i < 3; i++)
        if (comes_before(p[i], q[i]) || comes_before(q[i], p[i]))
            return comes_before(p[i], q[i]) ? -1 : 1;
    return (x->value > y->value) - (x->value < y->value);
}

static bool are_twins(const struct pm_mesh_body *m, uint32_t a, uint32_t b)
{
    pm_vec3 p[3], q[3];
    sorted_corners(m, a, p);
    sorted_corners(m, b, q);
    for (int i = 0; i < 3; i++)
        if (comes_before(p[i], q[i]) || comes_before(q[i], p[i]))
            return false;
    return true;
}

/* Among triangles with equal keys, which are nearly always twins. */
static bool group_run(const struct pm_mesh_body *m, pm_keyed *run, size_t count,
                      uint32_t *group)
{
    bool any = false;
    qsort_r(run, count, sizeof *run, by_corners, (void *)m);
    for (size_t i = 1; i < count; i++) {
        if (!are_twins(m, run[i - 1].value, run[i].value))
            continue;
        group[run[i].value] = group[run[i - 1].value];
        any = true;
    }
    return any;
}

/* *any: whether two triangles have the same corners. */
static bool find_twins(const struct pm_mesh_body *m, uint32_t *group, bool *any)
{
    uint32_t count = m->mesh->triangle_count;
    pm_keyed *keys = malloc(count * sizeof *keys);
    if (!keys)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        keys[i] = (pm_keyed){key_of(m, i), i};
        group[i] = i;
    }
    bool ready = !pm_radix_sort(keys, count);
    *any = false;
    for (size_t i = 0, end; ready && i < count; i = end) {
        for (end = i + 1; end < count && keys[end].key == keys[i].key;)
            end++;
        if (end - i > 1)
            *any = group_run(m, keys + i, end - i, group) || *any;
    }
    free(keys);
    return ready;
}

static bool set_groups(struct pm_mesh_body *m, pm_arena *arena)
{
    uint32_t count = m->mesh->triangle_count;
    uint32_t *group = malloc(count * sizeof *group), *kept = NULL;
    bool any = false, ready = group && find_twins(m, group, &any);
    if (ready && any) {
        kept = pm_arena_array(arena, count, sizeof *kept);
        ready = kept;
    }
    if (kept)
        memcpy(kept, group, count * sizeof *kept);
    free(group);
    m->group = kept;
    return ready;
}

pm_status pm_mesh_body_make(struct pm_body *body, const pm_mesh *mesh,
                            const uint32_t *materials, pm_arena *arena, pm_error *err)
{
    pm_vec3 *positions = pm_arena_array(arena, mesh->vertex_count, sizeof *positions);
    struct pm_mesh_body m = {.mesh = mesh, .positions = positions, .materials = materials};
    for (uint32_t i = 0; positions && i < mesh->vertex_count; i++)
        positions[i] =
            pm_vec3_scale(pm_vec3_sub(mesh->positions[i], body->center), 1 / body->scale);
    if (!positions || !set_groups(&m, arena))
        return pm_error_set(err, PM_E_MEMORY, "no memory for a mesh of %u triangles",
                            mesh->triangle_count);
    body->mesh = m;
    return PM_OK;
}

/* ---- queries ---- */

struct pm_mesh_side pm_mesh_body_side(const struct pm_mesh_body *m, uint32_t triangle)
{
    pm_vec3 p[3];
    if (!m->group)
        return (struct pm_mesh_side){triangle, triangle, false};
    bool flipped = sorted_corners(m, triangle, p);
    return (struct pm_mesh_side){m->group[triangle], triangle, flipped};
}

uint32_t pm_mesh_body_material(const struct pm_mesh_body *m, uint32_t triangle)
{
    uint32_t slot = m->mesh->triangles[triangle].slot;
    return slot < m->mesh->slot_count ? m->materials[slot] : PM_NO_PRIMITIVE;
}

uint32_t pm_mesh_body_modifier(const struct pm_mesh_body *m, uint32_t triangle)
{
    uint32_t slot = m->mesh->triangles[triangle].slot;
    return slot < m->mesh->slot_count ? m->modifiers[slot] : PM_NO_PRIMITIVE;
}

static pm_vec3 area_vector(const pm_vec3 p[3])
{
    return pm_vec3_cross(pm_vec3_sub(p[1], p[0]), pm_vec3_sub(p[2], p[0]));
}

static pm_vec3 normal_of(const pm_vec3 p[3], bool flipped)
{
    pm_vec3 n = area_vector(p);
    double length = pm_vec3_length(n);
    if (length > 0)
        n = pm_vec3_make(n.x / length, n.y / length, n.z / length);
    return flipped ? pm_vec3_negate(n) : n;
}

pm_vec3 pm_mesh_body_normal(const struct pm_mesh_body *m, uint32_t triangle)
{
    pm_vec3 p[3];
    bool flipped = corners(m, triangle, p);
    return normal_of(p, flipped);
}

void pm_mesh_body_bounds(const struct pm_mesh_body *m, uint32_t triangle, pm_vec3 *low,
                         pm_vec3 *high)
{
    pm_vec3 a = corner_of(m, triangle, 0), b = corner_of(m, triangle, 1);
    pm_vec3 c = corner_of(m, triangle, 2);
    *low = pm_vec3_min(pm_vec3_min(a, b), c);
    *high = pm_vec3_max(pm_vec3_max(a, b), c);
}

/* Where the ray meets the triangle: the corners' depths, weighted by the edges' sides, so that
 * the place is never beyond them. */
static bool passes_through(struct pm_probe *q, const pm_vec3 p[3], double *t)
{
    pm_probe_shear(q);
    const int *axis = q->axis;
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    double x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        const double c[3] = {p[i].x, p[i].y, p[i].z};
        z[i] = c[axis[2]] - q->o[axis[2]];
        x[i] = (c[axis[0]] - q->o[axis[0]]) - q->shear[0] * z[i];
        y[i] = (c[axis[1]] - q->o[axis[1]]) - q->shear[1] * z[i];
    }
    double u = pm_edge(x[1], y[1], x[2], y[2]), v = pm_edge(x[2], y[2], x[0], y[0]);
    double w = pm_edge(x[0], y[0], x[1], y[1]);
    if (!pm_edges_agree(u, v, w))
        return false;
    *t = (u * z[0] + v * z[1] + w * z[2]) / (u + v + w) / d[axis[2]];
    return true;
}

bool pm_probe_triangle(struct pm_probe *q, uint32_t triangle)
{
    const struct pm_mesh_body *m = &q->body->mesh;
    pm_vec3 p[3];
    double t, along = 0;
    bool flipped = corners(m, triangle, p);
    if (!passes_through(q, p, &t) || !pm_probe_sees(q, pm_mesh_body_material(m, triangle)))
        return false;
    uint32_t group = m->group ? m->group[triangle] : triangle;
    if (!pm_probe_starts_on(q, group))
        along = pm_probe_along(q, t);
    double cosine = pm_vec3_dot(normal_of(p, flipped), q->direction);
    if (!pm_probe_wants(q, along, cosine))
        return false;
    struct pm_ray_key key = pm_ray_key_make(along, q->base + group, triangle, flipped, cosine);
    return pm_probe_offer(q, &key, triangle, PM_NO_PRIMITIVE);
}

/* ---- what is between the corners ---- */

/* Shares of the triangle's area, as its shadow along the normal's greatest axis has them. */
static void weights(const pm_vec3 p[3], pm_vec3 point, double out[3])
{
    pm_vec3 n = area_vector(p);
    double square = pm_vec3_dot(n, n);
    for (int i = 0; i < 3; i++) {
        pm_vec3 a = pm_vec3_sub(p[(i + 1) % 3], point), b = pm_vec3_sub(p[(i + 2) % 3], point);
        out[i] = square > 0 ? pm_vec3_dot(pm_vec3_cross(a, b), n) / square : 1. / 3;
    }
}

/* Radiance's pert: what is to be added to the flat normal. */
static pm_vec3 perturbation(const pm_mesh *mesh, const uint32_t corner[3], const double w[3],
                            pm_vec3 flat)
{
    pm_vec3 sum = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const float *n = mesh->normals[corner[i]];
        sum = pm_vec3_madd(sum, w[i], pm_vec3_make((double)n[0], (double)n[1], (double)n[2]));
    }
    if (!(pm_vec3_length(sum) > 0))
        return pm_vec3_make(0, 0, 0);
    return pm_vec3_sub(pm_vec3_normalize(sum), flat);
}

void pm_mesh_body_fill_hit(const struct pm_mesh_body *m, uint32_t triangle, pm_vec3 point,
                           pm_hit *hit)
{
    const pm_mesh_triangle *t = &m->mesh->triangles[triangle];
    pm_vec3 p[3];
    double w[3];
    hit->normal = pm_mesh_body_normal(m, triangle);
    corners(m, triangle, p);
    double height = pm_vec3_dot(hit->normal, pm_vec3_sub(point, p[0]));
    hit->point = pm_vec3_madd(point, -height, hit->normal);
    hit->u = hit->v = 0;
    hit->perturbation = pm_vec3_make(0, 0, 0);
    if (!t->has_normals && !t->has_uv)
        return;
    for (int i = 0; i < 3; i++)
        p[i] = corner_of(m, triangle, i);
    weights(p, hit->point, w);
    if (t->has_normals)
        hit->perturbation = perturbation(m->mesh, t->corner, w, hit->normal);
    for (int i = 0; t->has_uv && i < 3; i++) {
        hit->u += w[i] * m->mesh->uv[t->corner[i]][0];
        hit->v += w[i] * m->mesh->uv[t->corner[i]][1];
    }
}
