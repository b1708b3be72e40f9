#include "world/pieces.h"

#include <stdlib.h>

#include "base/morton.h"
#include "base/radix.h"
#include "world/watertight.h"

/* ---- building ---- */

/* A piece to be: which triangles it is made of. */
struct place {
    uint32_t shape, triangle;
};

static bool is_planar(const struct pm_body *body, const struct pm_shape *s)
{
    return s->deviation <= body->tolerance;
}

/* Whether triangle i can go with the next one; the shared edge is that from corner *first of i,
 * and corner *other of the next is not on it. */
static bool pairs_up(const struct pm_body *body, const struct pm_shape *s, uint32_t i,
                     int *first, int *other)
{
    if (i + 1 >= s->triangle_count || !is_planar(body, s))
        return false;
    const uint32_t *a = s->triangles[i].corner, *b = s->triangles[i + 1].corner;
    for (int k = 0; k < 9; k++) {
        int m = k / 3, n = k % 3;
        if (a[m] == b[(n + 1) % 3] && a[(m + 1) % 3] == b[n]) {
            *first = m;
            *other = (n + 2) % 3;
            return true;
        }
    }
    return false;
}

/* Morton code of the triangle's middle. */
static uint64_t code_of(const struct pm_shape *s, uint32_t triangle)
{
    const uint32_t *c = s->triangles[triangle].corner;
    pm_vec3 sum =
        pm_vec3_add(s->vertices[c[0]], pm_vec3_add(s->vertices[c[1]], s->vertices[c[2]]));
    return pm_morton_code(sum.x / 3, sum.y / 3, sum.z / 3);
}

static size_t list_places(const struct pm_body *body, struct place *places, pm_keyed *order)
{
    size_t count = 0;
    int first, other;
    for (uint32_t i = 0; i < body->shape_count; i++) {
        const struct pm_shape *s = &body->shapes[i];
        for (uint32_t k = 0; k < s->triangle_count; count++) {
            places[count] = (struct place){i, k};
            order[count] = (pm_keyed){code_of(s, k), (uint32_t)count};
            k += pairs_up(body, s, k, &first, &other) ? 2 : 1;
        }
    }
    return count;
}

static void set_corner(struct pm_piece *p, int i, pm_vec3 v)
{
    p->corner[0][i] = v.x;
    p->corner[1][i] = v.y;
    p->corner[2][i] = v.z;
}

/* The triangle's own plane, for polygons that are not planar. */
static void set_own_plane(struct pm_piece *p, pm_vec3 a, pm_vec3 b, pm_vec3 c)
{
    pm_vec3 n = pm_vec3_cross(pm_vec3_sub(b, a), pm_vec3_sub(c, a));
    double length = pm_vec3_length(n);
    if (length > 0)
        p->normal = pm_vec3_make(n.x / length, n.y / length, n.z / length);
    p->offset = pm_vec3_dot(p->normal, a);
}

static void make_piece(const struct pm_body *body, const struct place *place,
                       struct pm_piece *p)
{
    const struct pm_shape *s = &body->shapes[place->shape];
    const uint32_t *a = s->triangles[place->triangle].corner;
    int first = 0, other = 0;
    bool two = pairs_up(body, s, place->triangle, &first, &other);
    const pm_vec3 corner[3] = {s->vertices[a[(first + 1) % 3]], s->vertices[a[(first + 2) % 3]],
                               s->vertices[a[first]]};
    for (int k = 0; k < 3; k++)
        set_corner(p, k, corner[k]);
    const struct pm_triangle *next = &s->triangles[place->triangle + two];
    set_corner(p, 3, two ? s->vertices[next->corner[other]] : corner[0]);
    p->normal = s->axis;
    p->offset = s->offset;
    if (!is_planar(body, s))
        set_own_plane(p, corner[0], corner[1], corner[2]);
}

static struct pm_piece_owner make_owner(const struct pm_body *body, uint32_t index)
{
    const struct pm_shape *s = &body->shapes[index];
    return (struct pm_piece_owner){index,    s->group,   s->material,
                                   s->layer, s->flipped, is_planar(body, s)};
}

/* Shapes are scattered over memory, and their vertices elsewhere: ask for them before they are
 * needed. */
static void prefetch(const struct pm_body *body, const struct place *places,
                     const pm_keyed *order, size_t count, size_t i)
{
    enum { AHEAD = 8 };
    if (i + 2 * AHEAD >= count)
        return;
    const struct pm_shape *far = &body->shapes[places[order[i + 2 * AHEAD].value].shape];
    __builtin_prefetch(far);
    __builtin_prefetch(&far->axis);
    __builtin_prefetch(&far->vertices);
    __builtin_prefetch(body->shapes[places[order[i + AHEAD].value].shape].vertices);
}

pm_status pm_pieces_build(const struct pm_body *body, struct pm_pieces *out)
{
    size_t triangles = 0, count = 0;
    for (size_t i = 0; i < body->shape_count; i++)
        triangles += body->shapes[i].triangle_count;
    struct place *places = malloc((triangles + 1) * sizeof *places);
    pm_keyed *order = malloc((triangles + 1) * sizeof *order);
    if (places && order && triangles < UINT32_MAX)
        count = list_places(body, places, order);
    *out = (struct pm_pieces){
        .count = count,
        .piece = aligned_alloc(alignof(struct pm_piece), (count + 1) * sizeof *out->piece),
        .owner = malloc((count + 1) * sizeof *out->owner)};
    bool ready = places && order && triangles < UINT32_MAX && out->piece && out->owner &&
                 !pm_radix_sort(order, count);
    for (size_t i = 0; ready && i < count; i++) {
        const struct place *place = &places[order[i].value];
        prefetch(body, places, order, count, i);
        make_piece(body, place, &out->piece[i]);
        out->owner[i] = make_owner(body, place->shape);
    }
    free(places);
    free(order);
    if (!ready)
        pm_pieces_clear(out);
    return ready ? PM_OK : PM_E_MEMORY;
}

void pm_pieces_clear(struct pm_pieces *pieces)
{
    free(pieces->piece);
    free(pieces->owner);
    *pieces = (struct pm_pieces){0};
}

/* ---- the exact test ---- */

static bool passes_through(const struct pm_piece *p, const struct pm_probe *q)
{
    double x[4], y[4];
    const double *px = p->corner[q->axis[0]], *py = p->corner[q->axis[1]];
    const double *pz = p->corner[q->axis[2]];
    const double ox = q->o[q->axis[0]], oy = q->o[q->axis[1]], oz = q->o[q->axis[2]];
    for (int i = 0; i < 4; i++) {
        double z = pz[i] - oz;
        x[i] = (px[i] - ox) - q->shear[0] * z;
        y[i] = (py[i] - oy) - q->shear[1] * z;
    }
    double diagonal = pm_edge(x[2], y[2], x[0], y[0]);
    if (pm_edges_agree(pm_edge(x[0], y[0], x[1], y[1]), pm_edge(x[1], y[1], x[2], y[2]),
                       diagonal))
        return true;
    return pm_edges_agree(pm_edge(x[2], y[2], x[3], y[3]), pm_edge(x[3], y[3], x[0], y[0]),
                          -diagonal);
}

/* Along a plane the quotient of two roundings can be anything; the hit still lies within the
 * extent of the piece. */
static double clamp_grazing(const struct pm_piece *p, const struct pm_probe *q, double t)
{
    const double *z = p->corner[q->axis[2]];
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    double scale = 1 / d[q->axis[2]], low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 4; i++) {
        double at = (z[i] - q->o[q->axis[2]]) * scale;
        low = fmin(low, at);
        high = fmax(high, at);
    }
    return fmin(fmax(t, low), high);
}

bool pm_probe_piece(struct pm_probe *q, const struct pm_pieces *pieces, uint32_t index)
{
    const struct pm_piece *p = &pieces->piece[index];
    const struct pm_piece_owner *owner = &pieces->owner[index];
    double cosine = pm_vec3_dot(p->normal, q->direction);
    double along = 0;
    if (!pm_probe_starts_on(q, owner->group)) {
        double t = (p->offset - pm_vec3_dot(p->normal, q->origin)) / cosine;
        if (fabs(cosine) < 0x1p-26 && cosine != 0)
            t = clamp_grazing(p, q, t);
        along = pm_probe_along(q, t);
    }
    if (!pm_probe_wants(q, along, cosine) || !passes_through(p, q) ||
        !pm_probe_sees(q, owner->material))
        return false;
    struct pm_ray_key key =
        pm_ray_key_make(along, q->base + owner->group, owner->layer, owner->flipped, cosine);
    return pm_probe_offer(q, &key, owner->shape, index);
}
