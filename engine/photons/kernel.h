/* A list's blocks against a search, 16 photons at a time.
 *
 * Included by the files that compile it for one instruction set each, after lanes_*.h, which
 * give 16 floats and what can be done with them. All is done in floats without contraction, in
 * one order, so each instruction set gives the same bytes:
 *   lanes_way      p[i] - q as floats; the difference fits 32 bits
 *   lanes_field    (p[i] >> shift) & mask
 *   lanes_bytes    p[i]
 *   lanes_halves   (p[i] >> shift) & 0xFF
 *   lanes_power    2^(p[i] + bias - 127), or 0 if that is 2^-127 or less
 *   lanes_pack     writes the lanes of a set one behind the other, then others up to 16;
 *                  returns how many
 *   lanes_add_square_if  adds v^2, which is exact
 *   lanes_quarter  (v[i] + v[i + 8]) + (v[i + 4] + v[i + 12])
 */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "photons/search.h"

#ifndef PM_PHOTONS_LANES_H
#error "kernel.h needs one of the lanes_*.h"
#endif

typedef struct way {
    lanes x, y, z;
} way;

static inline lanes dot(way a, way b)
{
    return lanes_add(lanes_add(lanes_mul(a.x, b.x), lanes_mul(a.y, b.y)), lanes_mul(a.z, b.z));
}

static inline way same_way(const float v[3])
{
    return (way){lanes_all(v[0]), lanes_all(v[1]), lanes_all(v[2])};
}

/* ---- blocks made ready ---- */

/* Normals decoded from octahedral codes, as pm_photon_normal does. */
static inline way decode_normals(const uint16_t *codes)
{
    const lanes half = lanes_all(127), one = lanes_all(1), zero = lanes_all(0);
    lanes x = lanes_div(lanes_sub(lanes_halves(codes, 0), half), half);
    lanes y = lanes_div(lanes_sub(lanes_halves(codes, 8), half), half);
    lanes z = lanes_sub(lanes_sub(one, lanes_abs(x)), lanes_abs(y));
    /* the lower half is folded outwards: |x| grows smaller by -z */
    lanes fold = lanes_min(z, zero);
    lane_set lower = lanes_lt(z, zero);
    lanes folded_x = lanes_copysign(lanes_add(lanes_abs(x), fold), x);
    lanes folded_y = lanes_copysign(lanes_add(lanes_abs(y), fold), y);
    way n = {lanes_choose(lower, folded_x, x), lanes_choose(lower, folded_y, y), z};
    lanes inverse = lanes_div(one, lanes_sqrt(dot(n, n)));
    return (way){lanes_mul(n.x, inverse), lanes_mul(n.y, inverse), lanes_mul(n.z, inverse)};
}

/* The axis of a single normal, if all photons lie in one plane across it. */
static inline void find_plane(pm_ready *r, const pm_normals *n)
{
    for (int a = 0; a < 3; a++) {
        if (fabsf(n->axis[a][0]) != 1)
            continue;
        const int32_t *p = r->block->position[a];
        r->plane = p[0];
        lanes off = lanes_abs(lanes_way(p, p[0]));
        if (lanes_bits(lanes_le(off, lanes_all(0))) == 0xFFFF)
            r->axis = n->axis[a][0] > 0 ? a + 1 : -a - 1;
    }
}

/* Axes of the plane across axis a - 1. */
static const int plane_axes[4][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 1}};

/* What is known of the normals of the list's last block with a single one. */
typedef struct single {
    unsigned code; /* PM_NORMAL_MIXED: there was none */
    way normal;
} single;

static inline way block_normals(const pm_ready *r, single *last)
{
    if (r->code != PM_NORMAL_MIXED && r->code == last->code)
        return last->normal;
    way n = decode_normals(r->block->normal);
    if (r->code != PM_NORMAL_MIXED)
        *last = (single){r->code, n};
    return n;
}

/* True if all lanes in use either lie exactly in the plane of all points and have their normal,
 * and are found whenever they are near enough, or face elsewhere and never are: `there` is left
 * with the first. */
static inline bool lies_flat(pm_ready *r, const pm_group *g, const pm_list *list, way n)
{
    if (!list->plane || r->wide)
        return false;
    const lanes normals[3] = {n.x, n.y, n.z}, zero = lanes_all(0);
    int a = abs(list->plane) - 1;
    lanes along = lanes_mul(normals[a], lanes_all(list->plane > 0 ? 1 : -1));
    lanes height = lanes_way(r->block->position[a], (int32_t)g->searches[0].point[a]);
    unsigned facing = lanes_bits(lanes_le(lanes_all(PM_NORMAL_COSINE), along));
    unsigned found = lanes_bits(
        lanes_both(lanes_le(lanes_all(1), along), lanes_le(lanes_abs(height), zero)));
    if (r->there & facing & ~found)
        return false;
    r->there &= (uint16_t)found;
    const int *axes = plane_axes[a + 1];
    memcpy(r->along[0], r->block->position[axes[0]], sizeof r->along[0]);
    memcpy(r->along[1], r->block->position[axes[1]], sizeof r->along[1]);
    return true;
}

static inline void prepare_normals(pm_ready *r, pm_normals *normals, way n)
{
    lanes_store(normals->axis[0], n.x);
    lanes_store(normals->axis[1], n.y);
    lanes_store(normals->axis[2], n.z);
    if (r->code != PM_NORMAL_MIXED && !r->wide)
        find_plane(r, normals);
}

/* Smaller fluxes count as none: so squares, of 10 bits, are exact and need no rounding of their
 * own before they are added. */
#define LEAST_UNIT 0x1p-74F

static inline void prepare_fluxes(pm_ready *r, int bias)
{
    const pm_photon_block *b = r->block;
    lanes unit = lanes_power(b->exponent, bias);
    unit = lanes_choose(lanes_lt(unit, lanes_all(LEAST_UNIT)), lanes_all(0), unit);
    for (unsigned c = 0; c < 3; c++)
        lanes_store(r->flux[c], lanes_mul(lanes_field(b->flux, 10 * c, 0x3FF), unit));
}

static inline unsigned lanes_there(const pm_ready *r, const pm_search *s)
{
    size_t left = s->map->count - (size_t)r->index * PM_BLOCK_SIZE;
    unsigned there = left < PM_BLOCK_SIZE ? (1U << left) - 1 : 0xFFFF;
    if (s->filter == PM_PHOTONS_ALL)
        return there;
    unsigned specular = 0;
    for (unsigned i = 0; i < PM_BLOCK_SIZE; i++)
        specular |= (r->block->flags[i] & PM_PHOTON_SPECULAR ? 1U : 0U) << i;
    return there & (s->filter == PM_PHOTONS_SPECULAR ? specular : ~specular);
}

/* True if normals and plane of the whole block are exactly those of all points, so that no test
 * of them can fail. */
static inline bool in_plane_of_all(const pm_ready *r, const pm_group *g)
{
    int a = (g->axis < 0 ? -g->axis : g->axis) - 1;
    return g->axis && r->axis == g->axis &&
           g->point_high[a] - r->plane <= (double)PM_TANGENT_SLACK &&
           r->plane - g->point_low[a] <= (double)PM_TANGENT_SLACK;
}

/* The axis across which all points lie in exactly one plane, as of a search. */
static inline int plane_of_all(const pm_group *g)
{
    int a = abs(g->axis) - 1;
    const pm_search *s = &g->searches[0];
    bool one = g->axis && s->surface && g->point_low[a] == g->point_high[a] &&
               s->point[a] >= INT32_MIN && s->point[a] <= INT32_MAX;
    return one ? g->axis : 0;
}

static inline enum pm_test prepare_surface(const pm_group *group, pm_list *list, size_t i,
                                           single *last)
{
    pm_ready *r = &list->ready[i];
    way n = block_normals(r, last);
    r->axis = 0;
    if (lies_flat(r, group, list, n))
        return PM_TEST_FLAT;
    prepare_normals(r, &list->normals[i], n);
    return in_plane_of_all(r, group) ? PM_TEST_DISTANCE : PM_TEST_ALL;
}

static void prepare(const pm_group *group, pm_list *list)
{
    const pm_search *s = &group->searches[0];
    single last = {.code = PM_NORMAL_MIXED};
    list->plane = plane_of_all(group);
    for (size_t i = 0; i < list->count; i++) {
        pm_ready *r = &list->ready[i];
        r->there = (uint16_t)lanes_there(r, s);
        if (group->fluxes)
            prepare_fluxes(r, 127 - s->map->exponent);
        r->test = s->surface ? prepare_surface(group, list, i, &last) : PM_TEST_DISTANCE;
        if (r->test == PM_TEST_DISTANCE && (r->wide || r->there != 0xFFFF))
            r->test = PM_TEST_ALL;
        if (!r->there) /* near to no point */
            list->low[0][i] = INFINITY;
    }
}

/* ---- a node's children listed ---- */

/* The children's boxes are rounded outwards: `slack` is more than the sums round. */
static void list_children(const pm_node *node, unsigned mask, const int64_t origin[3],
                          pm_list *list)
{
    const float step = pm_node_step(node);
    lane_set set = lanes_set_of(mask);
    for (int a = 0; a < 3; a++) {
        float base = (float)(node->origin[a] - origin[a]);
        float slack = (fabsf(base) + PM_NODE_STEPS * step) * 0x1p-21F;
        lanes low = lanes_mul(lanes_bytes(node->low[a]), lanes_all(step));
        lanes high = lanes_mul(lanes_bytes(node->high[a]), lanes_all(step));
        low = lanes_add(low, lanes_all(base - slack));
        high = lanes_add(high, lanes_all(base + step + slack));
        lanes_pack(list->low[a] + list->count, low, set);
        lanes_pack(list->high[a] + list->count, high, set);
    }
}

/* ---- a block's photons against a search ---- */

/* Blocks first .. first + 15 of the list that may hold photons within the bound: those whose
 * box is near enough. reach2 is more than the bound. */
static inline unsigned boxes_near(const pm_list *list, size_t first, const pm_search *s,
                                  lanes reach2)
{
    lanes distance2 = lanes_all(0);
    for (int a = 0; a < 3; a++) {
        lanes q = lanes_all(s->offset[a]);
        lanes below = lanes_sub(lanes_load(list->low[a] + first), q);
        lanes above = lanes_sub(q, lanes_load(list->high[a] + first));
        lanes d = lanes_max(lanes_max(below, above), lanes_all(0));
        distance2 = lanes_add(distance2, lanes_mul(d, d));
    }
    return lanes_bits(lanes_le(distance2, reach2));
}

enum { STRETCH = 64 };

/* The same for blocks first .. first + 63. */
static inline uint64_t stretch_near(const pm_list *list, size_t first, const pm_search *s,
                                    lanes reach2)
{
    size_t left = list->count - first;
    uint64_t near = 0;
    for (size_t i = 0; i < left && i < STRETCH; i += PM_BLOCK_SIZE)
        near |= (uint64_t)boxes_near(list, first + i, s, reach2) << i;
    return left < STRETCH ? near & ((UINT64_C(1) << left) - 1) : near;
}

/* A search in all lanes. */
struct target {
    lanes bound, reach2;
    int32_t point[3];
    int32_t along[2]; /* in the plane of all points */
};

/* reach2 is a squared distance within which the boxes of all photons within the bound lie:
 * offsets are rounded. */
static inline struct target aim(const pm_list *list, const pm_search *s)
{
    const int *axes = plane_axes[abs(list->plane)];
    float far = fabsf(s->offset[0]) + fabsf(s->offset[1]) + fabsf(s->offset[2]);
    float reach = s->reach + far * 0x1p-21F;
    return (struct target){
        lanes_all((float)s->bound),
        lanes_all(reach * reach * (1 + 0x1p-20F)),
        {(int32_t)(uint32_t)s->point[0], (int32_t)(uint32_t)s->point[1],
         (int32_t)(uint32_t)s->point[2]},
        {(int32_t)(uint32_t)s->point[axes[0]], (int32_t)(uint32_t)s->point[axes[1]]},
    };
}

static inline lanes far_way(const int32_t *p, int64_t q)
{
    _Alignas(64) float d[PM_BLOCK_SIZE];
    for (int i = 0; i < PM_BLOCK_SIZE; i++)
        d[i] = (float)(p[i] - q);
    return lanes_load(d);
}

/* From the point to the photons; each difference is rounded once. */
static inline way way_to(const pm_photon_block *b, const int32_t point[3])
{
    return (way){lanes_way(b->position[0], point[0]), lanes_way(b->position[1], point[1]),
                 lanes_way(b->position[2], point[2])};
}

static inline way far_way_to(const pm_photon_block *b, const int64_t point[3])
{
    return (way){far_way(b->position[0], point[0]), far_way(b->position[1], point[1]),
                 far_way(b->position[2], point[2])};
}

/* True if normals and plane of the whole block are exactly the search's, whose tests then pass.
 */
static inline bool in_one_plane(const pm_ready *r, const pm_search *s)
{
    if (!r->axis || r->axis != s->axis)
        return false;
    int64_t height = r->plane - s->point[(s->axis < 0 ? -s->axis : s->axis) - 1];
    return height <= (int64_t)PM_TANGENT_SLACK && height >= -(int64_t)PM_TANGENT_SLACK;
}

static inline void learn_normal(pm_search *s, const pm_ready *r, const pm_normals *normals)
{
    const float *n = s->normal;
    const float there[3] = {normals->axis[0][0], normals->axis[1][0], normals->axis[2][0]};
    float cosine = (there[0] * n[0] + there[1] * n[1]) + there[2] * n[2];
    s->known_accepted = cosine >= PM_NORMAL_COSINE;
    for (int a = 0; a < 3; a++)
        s->known_mean[a] = (there[a] + n[a]) * 0.5F;
    s->known_normal = r->code;
}

static inline lane_set in_plane(way d, way mean, lanes distance2)
{
    lanes height = lanes_sub(lanes_abs(dot(d, mean)), lanes_all(PM_TANGENT_SLACK));
    height = lanes_max(height, lanes_all(0));
    lanes limit = lanes_mul(distance2, lanes_all(PM_TANGENT_SLOPE * PM_TANGENT_SLOPE));
    return lanes_le(lanes_mul(height, height), limit);
}

static inline lane_set on_mixed_surface(const pm_normals *normals, const pm_search *s, way d,
                                        lanes distance2)
{
    const way own = same_way(s->normal);
    way n = {lanes_load(normals->axis[0]), lanes_load(normals->axis[1]),
             lanes_load(normals->axis[2])};
    lane_set facing = lanes_le(lanes_all(PM_NORMAL_COSINE), dot(n, own));
    const lanes half = lanes_all(0.5F);
    way mean = {lanes_mul(lanes_add(n.x, own.x), half), lanes_mul(lanes_add(n.y, own.y), half),
                lanes_mul(lanes_add(n.z, own.z), half)};
    return lanes_both(facing, in_plane(d, mean, distance2));
}

static inline lane_set on_surface(const pm_ready *r, const pm_normals *normals, pm_search *s,
                                  way d, lanes distance2)
{
    if (r->code == PM_NORMAL_MIXED)
        return on_mixed_surface(normals, s, d, distance2);
    if (r->code != s->known_normal)
        learn_normal(s, r, normals);
    if (!s->known_accepted)
        return lanes_set_of(0);
    return in_plane(d, same_way(s->known_mean), distance2);
}

/* What dot gives where the third difference is 0. */
static inline lanes flat_distance2(const pm_ready *r, const struct target *t)
{
    lanes u = lanes_way(r->along[0], t->along[0]);
    lanes v = lanes_way(r->along[1], t->along[1]);
    return lanes_add(lanes_mul(u, u), lanes_mul(v, v));
}

static lane_set test_carefully(const pm_list *list, size_t i, pm_search *s,
                               const struct target *t, lanes *distance2)
{
    const pm_ready *r = &list->ready[i];
    way d = r->wide ? far_way_to(r->block, s->point) : way_to(r->block, t->point);
    *distance2 = dot(d, d);
    lane_set found = lanes_le(*distance2, t->bound);
    if (s->surface && !in_one_plane(r, s))
        found = lanes_both(found, on_surface(r, &list->normals[i], s, d, *distance2));
    return lanes_both(found, lanes_set_of(r->there));
}

/* Lanes whose photons are found, and the squared distances of all. */
static inline __attribute__((always_inline)) lane_set test_block(const pm_list *list, size_t i,
                                                                 pm_search *s,
                                                                 const struct target *t,
                                                                 lanes *distance2)
{
    const pm_ready *r = &list->ready[i];
    if (r->test == PM_TEST_FLAT) {
        *distance2 = flat_distance2(r, t);
        return lanes_le_in(lanes_set_of(r->there), *distance2, t->bound);
    }
    if (r->test == PM_TEST_ALL)
        return test_carefully(list, i, s, t, distance2);
    way d = way_to(r->block, t->point);
    *distance2 = dot(d, d);
    return lanes_le(*distance2, t->bound);
}

/* ---- sums ---- */

enum { BLOCKS_IN_PART = 64 };

/* Sums of fluxes and their squares: r g b rr gg bb. */
typedef struct parts {
    lanes r, g, b, rr, gg, bb;
} parts;

static inline parts no_parts(void)
{
    const lanes zero = lanes_all(0);
    return (parts){zero, zero, zero, zero, zero, zero};
}

static inline void add_block(parts *v, lane_set found, const pm_ready *r)
{
    lanes red = lanes_load(r->flux[0]);
    lanes green = lanes_load(r->flux[1]);
    lanes blue = lanes_load(r->flux[2]);
    v->r = lanes_add_if(found, v->r, red);
    v->g = lanes_add_if(found, v->g, green);
    v->b = lanes_add_if(found, v->b, blue);
    v->rr = lanes_add_square_if(found, v->rr, red);
    v->gg = lanes_add_square_if(found, v->gg, green);
    v->bb = lanes_add_square_if(found, v->bb, blue);
}

/* Sums over i of what lanes_quarter gives, of three. */
static inline void hand_over_three(lanes x, lanes y, lanes z, double *total)
{
    __m128 a = lanes_quarter(x), b = lanes_quarter(y), c = lanes_quarter(z);
    __m128 d = _mm_setzero_ps();
    _MM_TRANSPOSE4_PS(a, b, c, d);
    _Alignas(16) float sum[4];
    _mm_store_ps(sum, _mm_add_ps(_mm_add_ps(a, c), _mm_add_ps(b, d)));
    for (int i = 0; i < 3; i++)
        total[i] += (double)sum[i];
}

static inline void hand_over(parts *v, pm_sums *sums)
{
    hand_over_three(v->r, v->g, v->b, sums->total);
    hand_over_three(v->rr, v->gg, v->bb, sums->total + 3);
    *v = no_parts();
}

static inline parts load_parts(const pm_sums *sums)
{
    return (parts){lanes_load(sums->part[0]), lanes_load(sums->part[1]),
                   lanes_load(sums->part[2]), lanes_load(sums->part[3]),
                   lanes_load(sums->part[4]), lanes_load(sums->part[5])};
}

static inline void store_parts(const parts *v, pm_sums *sums)
{
    lanes_store(sums->part[0], v->r);
    lanes_store(sums->part[1], v->g);
    lanes_store(sums->part[2], v->b);
    lanes_store(sums->part[3], v->rr);
    lanes_store(sums->part[4], v->gg);
    lanes_store(sums->part[5], v->bb);
}

static void sum_list(const pm_list *list, pm_search *s, pm_sums *sums)
{
    const struct target t = aim(list, s);
    uint32_t count = sums->count, blocks = sums->blocks;
    parts v = sums->begun ? load_parts(sums) : no_parts();
    for (size_t first = 0; first < list->count; first += STRETCH) {
        uint64_t near = stretch_near(list, first, s, t.reach2);
        for (; near; near &= near - 1) {
            size_t i = first + (unsigned)__builtin_ctzll(near);
            lanes distance2;
            lane_set found = test_block(list, i, s, &t, &distance2);
            unsigned bits = lanes_bits(found);
            count += (uint32_t)__builtin_popcount(bits);
            blocks += bits != 0;
            add_block(&v, found, &list->ready[i]);
            if (blocks == BLOCKS_IN_PART) {
                hand_over(&v, sums);
                blocks = 0;
            }
        }
    }
    if (list->last)
        hand_over(&v, sums);
    else
        store_parts(&v, sums);
    sums->begun = true;
    sums->count = count;
    sums->blocks = blocks;
}

/* ---- photons found ---- */

static size_t collect_list(const pm_list *list, pm_search *s, float *out)
{
    const struct target t = aim(list, s);
    size_t count = 0;
    for (size_t first = 0; first < list->count; first += STRETCH) {
        uint64_t near = stretch_near(list, first, s, t.reach2);
        for (; near; near &= near - 1) {
            lanes distance2;
            size_t i = first + (unsigned)__builtin_ctzll(near);
            lane_set found = test_block(list, i, s, &t, &distance2);
            count += lanes_pack(out + count, distance2, found);
        }
    }
    return count;
}

static size_t find_in_list(const pm_list *list, pm_search *s, pm_found *out)
{
    const struct target t = aim(list, s);
    size_t count = 0;
    for (size_t first = 0; first < list->count; first += STRETCH) {
        uint64_t near = stretch_near(list, first, s, t.reach2);
        for (; near; near &= near - 1) {
            lanes distance2;
            size_t i = first + (unsigned)__builtin_ctzll(near);
            out[count].lanes = lanes_bits(test_block(list, i, s, &t, &distance2));
            out[count].block = list->ready[i].index;
            lanes_store(out[count].distance2, distance2);
            count += out[count].lanes != 0;
        }
    }
    return count;
}

static inline float least_lane(lanes v)
{
    _Alignas(64) float each[PM_BLOCK_SIZE];
    lanes_store(each, v);
    __m128 a = _mm_min_ps(_mm_load_ps(each), _mm_load_ps(each + 4));
    __m128 b = _mm_min_ps(_mm_load_ps(each + 8), _mm_load_ps(each + 12));
    a = _mm_min_ps(a, b);
    a = _mm_min_ps(a, _mm_movehl_ps(a, a));
    return _mm_cvtss_f32(_mm_min_ss(a, _mm_shuffle_ps(a, a, 1)));
}

static void closest_in_list(const pm_list *list, pm_search *s, pm_closest *out)
{
    lanes least = lanes_load(out->distance2), index = lanes_load(out->index);
    for (size_t first = 0; first < list->count; first += PM_BLOCK_SIZE) {
        const struct target t = aim(list, s);
        size_t left = list->count - first;
        unsigned near = boxes_near(list, first, s, t.reach2);
        near = left < PM_BLOCK_SIZE ? near & ((1U << left) - 1) : near;
        if (!near)
            continue;
        for (; near; near &= near - 1) {
            lanes distance2;
            size_t i = first + (unsigned)__builtin_ctz(near);
            lane_set found = test_block(list, i, s, &t, &distance2);
            float number;
            memcpy(&number, &list->ready[i].index, sizeof number);
            found = lanes_both(found, lanes_lt(distance2, least));
            least = lanes_choose(found, distance2, least);
            index = lanes_choose(found, lanes_all(number), index);
        }
        double nearest = (double)least_lane(least);
        if (nearest < s->bound)
            pm_search_set_bound(s, nearest);
    }
    lanes_store(out->distance2, least);
    lanes_store(out->index, index);
}

/* ---- selection ---- */

static inline size_t count_up_to(const float *values, size_t count, float limit)
{
    const lanes t = lanes_all(limit);
    size_t n = 0;
    for (size_t i = 0; i < count; i += PM_BLOCK_SIZE)
        n += (size_t)__builtin_popcount(lanes_bits(lanes_le(lanes_load(values + i), t)));
    return n;
}

/* The least value above `limit`. */
static inline float next_above(const float *values, size_t count, float limit)
{
    const lanes none = lanes_all(INFINITY), t = lanes_all(limit);
    lanes least = none;
    for (size_t i = 0; i < count; i += PM_BLOCK_SIZE) {
        lanes v = lanes_load(values + i);
        least = lanes_min(least, lanes_choose(lanes_lt(t, v), v, none));
    }
    return least_lane(least);
}

/* Halfway between two floats >= 0 in the order of their bits: 32 halvings end anywhere. */
static float middle_float(float a, float b)
{
    uint32_t p, q;
    memcpy(&p, &a, sizeof p);
    memcpy(&q, &b, sizeof q);
    p += (q - p) / 2;
    memcpy(&a, &p, sizeof a);
    return a;
}

/* Brackets the value by interpolation and halving in turn, then walks over the last few. */
static float select_value(float *values, size_t count, size_t rank, float high)
{
    for (size_t i = count; i % PM_BLOCK_SIZE; i++)
        values[i] = INFINITY;
    float low = 0;
    size_t below = count_up_to(values, count, 0), above = count;
    if (below >= rank)
        return 0;
    for (int turn = 0; above - below > 4 && turn < 128; turn++) {
        float part = ((float)(rank - below) - 0.5F) / (float)(above - below);
        float t = turn & 1 ? middle_float(low, high) : low + (high - low) * part;
        size_t n = count_up_to(values, count, t);
        if (n >= rank) {
            high = t;
            above = n;
        } else {
            low = t;
            below = n;
        }
    }
    while (below < rank) {
        low = next_above(values, count, low);
        below = count_up_to(values, count, low);
    }
    return low;
}

/* ---- what a node says of its neighbourhood ---- */

/* Squared distances, in steps, from q to the children. */
static inline lanes child_distances(const pm_node *node, const float q[3])
{
    lanes sum = lanes_all(0);
    for (int a = 0; a < 3; a++) {
        lanes below = lanes_sub(lanes_bytes(node->low[a]), lanes_all(q[a]));
        lanes above = lanes_sub(lanes_all(q[a] - 1), lanes_bytes(node->high[a]));
        lanes d = lanes_max(lanes_max(below, above), lanes_all(0));
        sum = lanes_add(sum, lanes_mul(d, d));
    }
    return sum;
}

/* 1 / area or volume of the children's boxes [1 / steps^2 or ^3]. */
static inline lanes box_densities(const pm_node *node, bool surface)
{
    lanes edge[3];
    for (int a = 0; a < 3; a++) {
        lanes d = lanes_sub(lanes_bytes(node->high[a]), lanes_bytes(node->low[a]));
        edge[a] = lanes_max(d, lanes_all(0.5F)); /* one step thick may be much thinner */
    }
    lanes xy = lanes_mul(edge[0], edge[1]), measure = lanes_mul(xy, edge[2]);
    if (surface)
        measure =
            lanes_max(xy, lanes_max(lanes_mul(edge[1], edge[2]), lanes_mul(edge[2], edge[0])));
    return lanes_div(lanes_all(1), measure);
}

static pm_hint ask_node(const pm_node *node, const pm_search *s, unsigned matching)
{
    float q[3];
    if (!matching)
        return (pm_hint){0, 0};
    for (int a = 0; a < 3; a++)
        q[a] = (float)(s->point[a] - node->origin[a]) * node->steps_per_unit;
    const lanes none = lanes_all(INFINITY), zero = lanes_all(0);
    lane_set match = lanes_set_of(matching);
    lanes distance2 = lanes_choose(match, child_distances(node, q), none);
    lanes density = lanes_choose(match, box_densities(node, s->surface), zero);
    double sum[3] = {0, 0, 0};
    hand_over_three(density, zero, zero, sum);
    return (pm_hint){least_lane(distance2),
                     (float)sum[0] / (float)__builtin_popcount(matching)};
}

#define PM_KERNEL(isa)                                                                         \
    const pm_kernel pm_kernel_##isa = {                                                        \
        #isa,         list_children,   prepare,      sum_list, collect_list,                   \
        find_in_list, closest_in_list, select_value, ask_node}
