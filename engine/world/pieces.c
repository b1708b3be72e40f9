#include "world/pieces.h"

#include <stdlib.h>

#include <immintrin.h>

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

/* The sides of the four edges and of the diagonal from corner 2 to corner 0, as pm_edge gives
 * them. */
static void exact_sides(const double x[4], const double y[4], double out[5])
{
    for (int i = 0; i < 4; i++)
        out[i] = pm_edge(x[i], y[i], x[(i + 1) & 3], y[(i + 1) & 3]);
    out[4] = pm_edge(x[2], y[2], x[0], y[0]);
}

static bool passes_exactly(const double x[4], const double y[4])
{
    double e[5];
    exact_sides(x, y, e);
    return pm_edges_agree(e[0], e[1], e[4]) || pm_edges_agree(e[2], e[3], -e[4]);
}

/* All corners at once; only where a sign is in doubt are edges taken one by one. */
static bool passes_through(const struct pm_piece *p, struct pm_probe *q)
{
    pm_probe_shear(q);
    const int *axis = q->axis;
    const __m256d sign = _mm256_set1_pd(-0.0);
    __m256d x = _mm256_load_pd(p->corner[axis[0]]), y = _mm256_load_pd(p->corner[axis[1]]);
    __m256d z = _mm256_load_pd(p->corner[axis[2]]);
    z = _mm256_sub_pd(z, _mm256_set1_pd(q->o[axis[2]]));
    x = _mm256_sub_pd(x, _mm256_set1_pd(q->o[axis[0]]));
    y = _mm256_sub_pd(y, _mm256_set1_pd(q->o[axis[1]]));
    x = _mm256_sub_pd(x, _mm256_mul_pd(_mm256_set1_pd(q->shear[0]), z));
    y = _mm256_sub_pd(y, _mm256_mul_pd(_mm256_set1_pd(q->shear[1]), z));
    __m256d next_x = _mm256_permute4x64_pd(x, 0x39), next_y = _mm256_permute4x64_pd(y, 0x39);
    __m256d a = _mm256_mul_pd(x, next_y), b = _mm256_mul_pd(y, next_x);
    __m256d size = _mm256_add_pd(_mm256_andnot_pd(sign, a), _mm256_andnot_pd(sign, b));
    __m256d edges = _mm256_sub_pd(a, b);
    __m256d doubt = _mm256_cmp_pd(_mm256_andnot_pd(sign, edges),
                                  _mm256_mul_pd(_mm256_set1_pd(0x1p-51), size), _CMP_LE_OQ);
    __m256d far_x = _mm256_permute4x64_pd(x, 0x0E), far_y = _mm256_permute4x64_pd(y, 0x0E);
    double c = _mm256_cvtsd_f64(far_x) * _mm256_cvtsd_f64(y);
    double d = _mm256_cvtsd_f64(far_y) * _mm256_cvtsd_f64(x), diagonal = c - d;
    __m256d same = _mm256_and_pd(_mm256_cmp_pd(x, next_x, _CMP_EQ_OQ),
                                 _mm256_cmp_pd(y, next_y, _CMP_EQ_OQ));
    unsigned single = (unsigned)_mm256_movemask_pd(same) & 8; /* corner 3 is corner 0 */
    if ((unsigned)_mm256_movemask_pd(doubt) & ~single ||
        fabs(diagonal) <= 0x1p-51 * (fabs(c) + fabs(d))) {
        alignas(32) double all_x[4], all_y[4];
        _mm256_store_pd(all_x, x);
        _mm256_store_pd(all_y, y);
        return passes_exactly(all_x, all_y);
    }
    /* no edge is 0 here: a triangle's three signs are equal or not */
    unsigned signs = (unsigned)_mm256_movemask_pd(edges) | (diagonal < 0 ? 0x10U : 0);
    unsigned first = signs & 0x13, second = (signs ^ 0x10) & 0x1C;
    return first == 0 || first == 0x13 || (!single && (second == 0 || second == 0x1C));
}

/* Along a plane the quotient of two roundings can be anything; the hit still lies within the
 * extent of the piece. */
static double clamp_grazing(const struct pm_piece *p, struct pm_probe *q, double t)
{
    pm_probe_shear(q);
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

bool pm_probe_piece(struct pm_probe *q, const struct pm_pieces *pieces, uint32_t index,
                    bool inside)
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
    struct pm_ray_key key =
        pm_ray_key_make(along, q->base + owner->group, owner->layer, owner->flipped, cosine);
    if (!pm_probe_wants(q, along, cosine) || !pm_probe_accepts(q, &key) ||
        !(inside || passes_through(p, q)) || !pm_probe_sees(q, owner->material))
        return false;
    pm_probe_take(q, &key, owner->shape, index);
    return true;
}
