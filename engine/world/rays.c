#include "world/rays.h"

#include <stdlib.h>

#include <immintrin.h>

#include "world/mesh_body.h"
#include "world/probe.h"
#include "world/ray_tree.h"

struct pm_rays {
    void *builder;
    struct pm_ray_tree *trees; /* of the world's bodies, in their order */
    size_t count;
};

/* ---- a ray in float ----
 *
 * Every bound below errs to the side of testing too much. */

/* The ray as boxes and triangles of a tree see it. */
struct lanes {
    __m256 origin[3], near[3], far[3]; /* inverse direction, a little short and a little long */
    unsigned signs;                    /* bits of the negative directions */
    __m256 direction[3], slack;        /* see candidate_planes */
    __m256i from; /* number in the body of the surface that it starts from, or none */
};

/* Every box that holds a hit at t or before must still be visited. */
static float float_end(double t)
{
    return (float)(t * (1 + PM_TREE_MARGIN) + PM_TREE_MARGIN);
}

/* Where the walk through the tree may end. */
static float tree_end(const struct pm_probe *p)
{
    double end = p->limit < p->best.t ? p->limit : p->best.t;
    return float_end(end * p->inverse_unit - p->entry);
}

/* A direction so small makes no difference over the whole cube, and its inverse no NaN. */
static inline __m128 without_zeros(__m128 d)
{
    const __m128 sign = _mm_set1_ps(-0.0F), least = _mm_set1_ps(0x1p-60F);
    return _mm_or_ps(_mm_max_ps(_mm_andnot_ps(sign, d), least), _mm_and_ps(sign, d));
}

static inline __m256 spread(__m128 v, int i)
{
    return _mm256_permutevar8x32_ps(_mm256_castps128_ps256(v), _mm256_set1_epi32(i));
}

static inline void set_lanes(struct lanes *l, const struct pm_probe *p)
{
    __m128 origin = _mm_setr_ps((float)p->origin.x, (float)p->origin.y, (float)p->origin.z, 0);
    __m128 direction =
        _mm_setr_ps((float)p->direction.x, (float)p->direction.y, (float)p->direction.z, 1);
    __m128 inverse = _mm_div_ps(_mm_set1_ps(1), without_zeros(direction));
    __m128 near = _mm_mul_ps(inverse, _mm_set1_ps(1 - 0x1p-22F));
    __m128 far = _mm_mul_ps(inverse, _mm_set1_ps(1 + 0x1p-22F));
    l->signs = (unsigned)_mm_movemask_ps(inverse);
#pragma GCC unroll 3
    for (int i = 0; i < 3; i++) {
        l->origin[i] = spread(origin, i);
        l->near[i] = spread(near, i);
        l->far[i] = spread(far, i);
        l->direction[i] = spread(direction, i);
    }
    l->slack = _mm256_set1_ps(0x1p-18F + 4 * (float)p->tolerance);
    bool own = p->from != PM_NO_PRIMITIVE && !p->foreign;
    l->from = _mm256_set1_epi32(own ? (int)(p->from - p->base) : -2);
}

/* ---- boxes ---- */

static inline __m256 slab(const struct pm_tree_node *node, const struct lanes *l, int axis,
                          unsigned high, __m256 inverse)
{
    __m256 bound = _mm256_load_ps(node->bound[high][axis]);
    return _mm256_mul_ps(_mm256_sub_ps(bound, l->origin[axis]), inverse);
}

/* Bits of the children whose boxes the ray meets before `end`; where it enters them. The
 * inverses differ from the direction's by more than rounding does (Ize, "Robust BVH ray
 * traversal", JCGT 2(2), 2013). */
static inline unsigned enter_boxes(const struct pm_tree_node *node, const struct lanes *l,
                                   float end, float entry[PM_TREE_WIDTH])
{
    __m256 in = _mm256_setzero_ps(), out = _mm256_set1_ps(end);
#pragma GCC unroll 3
    for (int i = 0; i < 3; i++) {
        unsigned negative = l->signs >> i & 1;
        in = _mm256_max_ps(slab(node, l, i, negative, l->near[i]), in);
        out = _mm256_min_ps(slab(node, l, i, !negative, l->far[i]), out);
    }
    _mm256_store_ps(entry, in);
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(in, out, _CMP_LE_OQ));
}

/* ---- triangles and parallelograms ---- */

static inline __m256 absolute(__m256 v)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), v);
}

static inline __m256 dot(const float row[3][PM_TREE_WIDTH], const __m256 v[3], __m256 sum)
{
#pragma GCC unroll 3
    for (int i = 0; i < 3; i++)
        sum = _mm256_fmadd_ps(_mm256_load_ps(row[i]), v[i], sum);
    return sum;
}

/* Bit of the flat surface that the ray starts from: it meets that nowhere else. */
static inline unsigned itself(const struct pm_tree_leaf *leaf, const struct lanes *l)
{
    __m256i surface = _mm256_load_si256((const __m256i *)leaf->surface);
    __m256i same = _mm256_cmpeq_epi32(surface, l->from);
    return (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(same));
}

/* Where in a leaf a ray may meet something. */
struct candidates {
    unsigned bits,
        sure; /* sure: within the edges for certain, so that no exact test need ask */
};

/* What the ray may pass through before `end`, and from where on.
 *
 * Distances to a plane are off by at most 2^-20 (three products, their rounded factors, the
 * rounded offset), cosines by 2^-21, so places along the ray of at most 2 sqrt(3) by 3 * 2^-20
 * over the cosine, and coordinates by that and 2^-20, times their steepness. `slack` is more
 * than that, and more than what planes of coincident surfaces are moved by. Nearly along a
 * plane nothing is known. */
static inline struct candidates candidate_planes(const struct pm_tree_leaf *leaf,
                                                 const struct lanes *l, float end,
                                                 float start[PM_TREE_WIDTH])
{
    const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1);
    __m256 height =
        _mm256_sub_ps(dot(leaf->plane, l->origin, zero), _mm256_load_ps(leaf->plane[3]));
    __m256 inverse = _mm256_div_ps(one, dot(leaf->plane, l->direction, zero));
    __m256 t = _mm256_mul_ps(_mm256_sub_ps(zero, height), inverse), point[3];
#pragma GCC unroll 3
    for (int i = 0; i < 3; i++)
        point[i] = _mm256_fmadd_ps(t, l->direction[i], l->origin[i]);
    __m256 u = dot(leaf->along[0], point, _mm256_load_ps(leaf->along[0][3]));
    __m256 v = dot(leaf->along[1], point, _mm256_load_ps(leaf->along[1][3]));
    __m256 steep = absolute(inverse), slack = _mm256_fmadd_ps(steep, l->slack, l->slack);
    __m256 beyond = _mm256_sub_ps(_mm256_max_ps(u, v), one);
    __m256 corner = _mm256_sub_ps(_mm256_add_ps(u, v), _mm256_load_ps(leaf->most));
    __m256 outside = _mm256_max_ps(_mm256_mul_ps(corner, _mm256_set1_ps(.5F)),
                                   _mm256_sub_ps(zero, _mm256_min_ps(u, v)));
    outside = _mm256_max_ps(outside, beyond);
    __m256 margin = _mm256_mul_ps(slack, _mm256_load_ps(leaf->steep));
    __m256 first = _mm256_sub_ps(t, slack), last = _mm256_add_ps(t, slack);
    __m256 missed = _mm256_or_ps(_mm256_cmp_ps(outside, margin, _CMP_GT_OQ),
                                 _mm256_cmp_ps(last, zero, _CMP_LT_OQ));
    missed = _mm256_or_ps(missed, _mm256_cmp_ps(first, _mm256_set1_ps(end), _CMP_GT_OQ));
    __m256 known = _mm256_cmp_ps(steep, _mm256_set1_ps(0x1p16F), _CMP_LT_OQ);
    _mm256_store_ps(start, _mm256_and_ps(first, known)); /* 0 where nothing is known */
    missed = _mm256_and_ps(missed, known);
    __m256 inside = _mm256_cmp_ps(_mm256_add_ps(outside, margin), zero, _CMP_LT_OQ);
    return (struct candidates){~(unsigned)_mm256_movemask_ps(missed) & leaf->flat &
                                   ~itself(leaf, l),
                               (unsigned)_mm256_movemask_ps(_mm256_and_ps(inside, known))};
}

static inline struct candidates candidates(const struct pm_tree_leaf *leaf,
                                           const struct lanes *l, float end,
                                           float start[PM_TREE_WIDTH])
{
    alignas(32) float entry[PM_TREE_WIDTH];
    if (!leaf->boxes)
        return candidate_planes(leaf, l, end, start);
    if (!leaf->flat)
        return (struct candidates){enter_boxes(leaf->boxes, l, end, start) & ~itself(leaf, l),
                                   0};
    struct candidates c = candidate_planes(leaf, l, end, start);
    unsigned boxes = enter_boxes(leaf->boxes, l, end, entry) & ~leaf->flat & ~itself(leaf, l);
    for (unsigned rest = boxes; rest; rest &= rest - 1)
        start[__builtin_ctz(rest)] = entry[__builtin_ctz(rest)];
    c.bits |= boxes;
    return c;
}

/* ---- through a tree ---- */

static bool walk(struct pm_probe *q, bool any);

/* Goes on in an instance's body; what is found there comes back. Instances within instances do
 * so PM_INSTANCE_DEPTH deep at most. */
static bool probe_instance(struct pm_probe *outer, const struct pm_instance *instance, bool any)
{
    struct pm_probe inner;
    if (!pm_probe_enter(&inner, outer, instance) || !walk(&inner, any) ||
        !pm_ray_key_precedes(&inner.best, &outer->best))
        return false;
    outer->best = inner.best;
    outer->best_surface = inner.best_surface;
    outer->best_piece = inner.best_piece;
    return true;
}

/* The exact test of an item. True if it is the best so far. */
static bool probe_item(struct pm_probe *q, const struct pm_ray_tree *tree, uint32_t item,
                       bool inside, bool any)
{
    if (item < tree->flat_count)
        return tree->body->mesh.mesh ? pm_probe_triangle(q, item)
                                     : pm_probe_piece(q, &tree->pieces, item, inside);
    item -= tree->flat_count;
    if (item < tree->round_count)
        return pm_probe_shape(q, tree->round[item]);
    return probe_instance(q, &tree->body->instances[item - tree->round_count], any);
}

/* Takes the bit of the least number. */
static inline int take_nearest(unsigned *bits, const float *start)
{
    int best = __builtin_ctz(*bits);
    for (unsigned rest = *bits & (*bits - 1); rest; rest &= rest - 1) {
        int i = __builtin_ctz(rest);
        best = start[i] < start[best] ? i : best;
    }
    *bits &= ~(1U << best);
    return best;
}

/* Tests what may be met in leaves that lie one after the other, the nearest first; *end moves
 * with the best hit. */
static inline bool probe_leaves(struct pm_probe *q, const struct pm_tree_leaf *leaves,
                                struct candidates c, const float *start, float *end, bool any)
{
    bool found = false;
    unsigned bits = c.bits;
    while (bits) {
        int i = take_nearest(&bits, start);
        if (start[i] > *end)
            break;
        uint32_t item = leaves[i / PM_TREE_WIDTH].item[i % PM_TREE_WIDTH];
        if (!probe_item(q, q->body->tree, item, c.sure >> i & 1, any))
            continue;
        found = true;
        if (any)
            break;
        *end = tree_end(q);
    }
    return found;
}

/* A subtree put off. */
struct later {
    pm_tree_link link;
    float entry;
};

/* A node, or as much of a leaf as is looked at first. */
static inline void prefetch(pm_tree_link link)
{
    const char *at = (const char *)(link & ~(pm_tree_link)1);
    for (size_t line = 0; line < sizeof(struct pm_tree_node); line += 64)
        __builtin_prefetch(at + line);
}

/* Puts the children that are met onto the stack, the nearest on top; asks for them, since a
 * large tree lies far away in memory. */
static inline struct later *put_off(struct later *top, const struct pm_tree_node *node,
                                    unsigned bits, const float entry[PM_TREE_WIDTH])
{
    struct later *first = top;
    for (; bits; bits &= bits - 1) {
        int i = __builtin_ctz(bits);
        struct later child = {node->child[i], entry[i]}, *place = top++;
        prefetch(child.link);
        for (; place > first && place[-1].entry < child.entry; place--)
            *place = place[-1];
        *place = child;
    }
    return top;
}

/* All leaves are looked at before anything is tested: no one waits for another. */
static bool walk_few(struct pm_probe *q, const struct lanes *l, float end, bool any)
{
    const struct pm_ray_tree *tree = q->body->tree;
    alignas(32) float start[PM_TREE_FEW * PM_TREE_WIDTH];
    struct candidates all = {0, 0};
    for (uint32_t i = 0; i < tree->few_count; i++) {
        struct candidates c = candidates(&tree->few[i], l, end, start + i * PM_TREE_WIDTH);
        all.bits |= c.bits << i * PM_TREE_WIDTH;
        all.sure |= c.sure << i * PM_TREE_WIDTH;
    }
    return probe_leaves(q, tree->few, all, start, &end, any);
}

static bool walk_tree(struct pm_probe *q, const struct lanes *l, float end, bool any)
{
    struct later stack[PM_TREE_STACK], *top = stack;
    alignas(32) float entry[PM_TREE_WIDTH];
    bool found = false;
    *top++ = (struct later){q->body->tree->root, 0};
    while (top > stack && !(found && any)) {
        struct later at = *--top;
        if (at.entry > end)
            continue;
        if (at.link & 1) {
            const struct pm_tree_leaf *leaf = (const struct pm_tree_leaf *)(at.link - 1);
            struct candidates c = candidates(leaf, l, end, entry);
            found |= probe_leaves(q, leaf, c, entry, &end, any);
        } else {
            const struct pm_tree_node *node = (const struct pm_tree_node *)at.link;
            top = put_off(top, node, enter_boxes(node, l, end, entry), entry);
        }
    }
    return found;
}

/* Finds the best hit, or any. True if one was found. */
static bool walk(struct pm_probe *q, bool any)
{
    struct lanes l;
    float end = tree_end(q);
    if (end < 0)
        return false;
    set_lanes(&l, q);
    return q->body->tree->few ? walk_few(q, &l, end, any) : walk_tree(q, &l, end, any);
}

/* ---- building ---- */

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
}

static pm_status build_trees(struct pm_rays *rays, pm_world *world, pm_error *err)
{
    pm_status status = PM_OK;
    for (size_t i = 0; !status && i < world->body_count; i++) {
        struct pm_ray_tree *tree = &rays->trees[rays->count++];
        world->bodies[i].tree = tree;
        status = pm_ray_tree_build(tree, rays->builder, &world->bodies[i], err);
    }
    return status;
}

pm_status pm_rays_build(pm_world *world, pm_error *err)
{
    struct pm_rays *rays = calloc(1, sizeof *rays);
    if (!rays)
        return no_memory(err);
    world->rays = rays;
    rays->trees = calloc(world->body_count, sizeof *rays->trees);
    if (!rays->trees)
        return no_memory(err);
    rays->builder = pm_tree_builder_new();
    if (!rays->builder)
        return pm_error_set(err, PM_E_UNSUPPORTED,
                            "Embree does not start; it needs a processor with AVX2");
    return build_trees(rays, world, err);
}

void pm_rays_free(struct pm_rays *rays)
{
    if (!rays)
        return;
    for (size_t i = 0; i < rays->count; i++)
        pm_ray_tree_clear(&rays->trees[i]);
    pm_tree_builder_free(rays->builder);
    free(rays->trees);
    free(rays);
}

/* ---- hits ---- */

static void fill_piece(const struct pm_ray_tree *tree, uint32_t index, pm_vec3 point,
                       pm_hit *hit)
{
    const struct pm_piece *p = &tree->pieces.piece[index];
    const struct pm_piece_owner *owner = &tree->pieces.owner[index];
    double height = pm_vec3_dot(p->normal, point) - p->offset;
    hit->point = pm_vec3_madd(point, -height, p->normal);
    __builtin_prefetch(&tree->body->shapes[owner->shape]); /* for a ray that starts there */
    hit->normal = owner->planar ? p->normal : tree->body->shapes[owner->shape].axis;
    hit->material = owner->material;
}

/* In the body's coordinates. */
static void fill_local(const struct pm_body *body, uint32_t local, uint32_t piece,
                       pm_vec3 point, pm_hit *hit)
{
    if (body->mesh.mesh) {
        hit->material = pm_mesh_body_material(&body->mesh, local);
        pm_mesh_body_fill_hit(&body->mesh, local, point, hit);
        return;
    }
    hit->u = hit->v = 0;
    hit->perturbation = pm_vec3_make(0, 0, 0);
    if (piece != PM_NO_PRIMITIVE) {
        fill_piece(body->tree, piece, point, hit);
        return;
    }
    const struct pm_shape *s = &body->shapes[local];
    hit->point = pm_shape_project(s, point);
    hit->normal = pm_shape_normal(s, hit->point);
    hit->material = s->material;
}

/* From the body that holds the surface out to the main scene. */
static void fill_placed(const struct pm_probe *probe, pm_hit *hit)
{
    struct pm_place place;
    pm_place_find(probe->body, hit->surface, &place);
    struct pm_probe at = *probe;
    for (int i = 0; i < place.depth; i++) {
        struct pm_probe inner;
        pm_probe_enter(&inner, &at, place.chain[i]);
        at = inner;
    }
    double t = pm_probe_local(&at, probe->best.t);
    fill_local(place.body, place.local, probe->best_piece,
               pm_vec3_madd(at.origin, t, at.direction), hit);
    for (int i = place.depth; i-- > 0;) {
        hit->point = pm_instance_point_out(place.chain[i], hit->point);
        hit->normal = pm_instance_direction_out(place.chain[i], hit->normal);
        hit->perturbation = pm_instance_direction_out(place.chain[i], hit->perturbation);
    }
    hit->normal = pm_vec3_normalize(hit->normal);
    if (place.material != PM_NO_PRIMITIVE)
        hit->material = place.material;
}

static void fill_hit(const struct pm_probe *probe, pm_hit *hit)
{
    hit->t = probe->main_entry + probe->best.t;
    hit->surface = probe->best_surface;
    if (hit->surface >= probe->body->own_count) {
        fill_placed(probe, hit);
        return;
    }
    pm_vec3 point = pm_vec3_madd(probe->origin, probe->best.t, probe->direction);
    fill_local(probe->body, hit->surface, probe->best_piece, point, hit);
}

/* ---- queries ---- */

bool pm_world_intersect(const pm_world *world, const pm_ray *ray, pm_hit *hit)
{
    struct pm_probe probe;
    if (!pm_probe_init(&probe, world, ray) || !walk(&probe, false))
        return false;
    fill_hit(&probe, hit);
    return true;
}

bool pm_rays_next(const pm_world *world, const pm_ray *ray, struct pm_ray_walk *last,
                  pm_hit *hit)
{
    struct pm_probe probe;
    if (!pm_probe_init(&probe, world, ray))
        return false;
    if (last->started)
        probe.after = last->last;
    if (!walk(&probe, false))
        return false;
    fill_hit(&probe, hit);
    last->last = probe.best;
    last->started = true;
    return true;
}

bool pm_rays_any(const pm_world *world, const pm_ray *ray)
{
    struct pm_probe probe;
    return pm_probe_init(&probe, world, ray) && walk(&probe, true);
}
