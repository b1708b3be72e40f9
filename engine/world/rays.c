#include "world/rays.h"

#include <stdlib.h>

#include <embree3/rtcore.h>

#include "world/mesh_body.h"
#include "world/pieces.h"
#include "world/probe.h"

/* What rays walk through in a body. */
struct pm_tree {
    RTCScene scene;
    const struct pm_body *body;
    struct pm_pieces pieces;
    uint32_t *round; /* shapes that are not polygons */
    size_t round_count;
};

struct pm_rays {
    RTCDevice device;
    struct pm_tree *trees; /* of the world's bodies, in their order */
    size_t count;
};

/* Embree hands the context of a query to the callbacks. */
struct query {
    struct RTCIntersectContext context; /* first */
    struct pm_probe probe;
};

/* Boxes are widened by this. A ray starts in the cube [-1, 1]^3 (and PM_CUBE_MARGIN) when it is
 * rounded to float: its origin is then off by at most 2^-25 a coordinate, its direction by
 * 2^-25, which over at most 2 sqrt(3) is 3.5 * 2^-25. Together less than 5 * 2^-25, and the box
 * is rounded by 2^-24 at most; Embree's robust traversal covers its own rounding. */
#define BOX_MARGIN 0x1p-22

/* ---- boxes ---- */

static void set_bounds(struct RTCBounds *b, pm_vec3 low, pm_vec3 high)
{
    b->lower_x = (float)(low.x - BOX_MARGIN);
    b->lower_y = (float)(low.y - BOX_MARGIN);
    b->lower_z = (float)(low.z - BOX_MARGIN);
    b->upper_x = (float)(high.x + BOX_MARGIN);
    b->upper_y = (float)(high.y + BOX_MARGIN);
    b->upper_z = (float)(high.z + BOX_MARGIN);
}

static pm_vec3 corner(const struct pm_piece *p, int i)
{
    return pm_vec3_make(p->corner[0][i], p->corner[1][i], p->corner[2][i]);
}

static void piece_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_tree *tree = args->geometryUserPtr;
    const struct pm_piece *p = &tree->pieces.piece[args->primID];
    pm_vec3 low = corner(p, 0), high = low;
    for (int i = 1; i < 4; i++) {
        low = pm_vec3_min(low, corner(p, i));
        high = pm_vec3_max(high, corner(p, i));
    }
    set_bounds(args->bounds_o, low, high);
}

static void round_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_tree *tree = args->geometryUserPtr;
    const struct pm_shape *s = &tree->body->shapes[tree->round[args->primID]];
    set_bounds(args->bounds_o, s->low, s->high);
}

static void triangle_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_tree *tree = args->geometryUserPtr;
    pm_vec3 low, high;
    pm_mesh_body_bounds(&tree->body->mesh, args->primID, &low, &high);
    set_bounds(args->bounds_o, low, high);
}

static void instance_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_tree *tree = args->geometryUserPtr;
    pm_vec3 low, high;
    pm_instance_bounds(&tree->body->instances[args->primID], &low, &high);
    set_bounds(args->bounds_o, low, high);
}

/* ---- rays in a tree ---- */

/* Every box that holds a hit at t or before must still be visited. */
static float float_end(double t)
{
    return (float)(t * (1 + BOX_MARGIN) + BOX_MARGIN);
}

/* Where the walk through the tree may end. */
static float tree_end(const struct pm_probe *p)
{
    return float_end(pm_probe_local(p, fmin(p->limit, p->best.t)));
}

static struct RTCRay float_ray(const struct pm_probe *p)
{
    return (struct RTCRay){.org_x = (float)p->origin.x,
                           .org_y = (float)p->origin.y,
                           .org_z = (float)p->origin.z,
                           .dir_x = (float)p->direction.x,
                           .dir_y = (float)p->direction.y,
                           .dir_z = (float)p->direction.z,
                           .tfar = tree_end(p),
                           .mask = UINT32_MAX};
}

static void find_closest(struct query *q)
{
    struct RTCRayHit rayhit = {.ray = float_ray(&q->probe),
                               .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcInitIntersectContext(&q->context);
    rtcIntersect1(q->probe.body->tree->scene, &q->context, &rayhit);
}

static void find_any(struct query *q)
{
    struct RTCRay ray = float_ray(&q->probe);
    rtcInitIntersectContext(&q->context);
    rtcOccluded1(q->probe.body->tree->scene, &q->context, &ray);
}

/* Goes on in an instance's body; what is found there comes back. Instances within instances do
 * so PM_INSTANCE_DEPTH deep at most. */
static bool probe_instance(struct pm_probe *outer, const struct pm_instance *instance,
                           void (*find)(struct query *q))
{
    struct query q;
    if (!pm_probe_enter(&q.probe, outer, instance))
        return false;
    float end = tree_end(&q.probe);
    if (end < 0)
        return false;
    find(&q);
    if (!pm_ray_key_precedes(&q.probe.best, &outer->best))
        return false;
    outer->best = q.probe.best;
    outer->best_surface = q.probe.best_surface;
    outer->best_piece = q.probe.best_piece;
    return true;
}

/* What a callback of Embree's tests: a piece, a round shape, a triangle or an instance. */
typedef bool probe_function(struct query *q, const struct pm_tree *tree, uint32_t index,
                            void (*find)(struct query *q));

static bool probe_piece(struct query *q, const struct pm_tree *tree, uint32_t index,
                        void (*find)(struct query *q))
{
    (void)find;
    return pm_probe_piece(&q->probe, &tree->pieces, index);
}

static bool probe_round(struct query *q, const struct pm_tree *tree, uint32_t index,
                        void (*find)(struct query *q))
{
    (void)find;
    return pm_probe_shape(&q->probe, tree->round[index]);
}

static bool probe_triangle(struct query *q, const struct pm_tree *tree, uint32_t index,
                           void (*find)(struct query *q))
{
    (void)tree, (void)find;
    return pm_probe_triangle(&q->probe, index);
}

static bool probe_placed(struct query *q, const struct pm_tree *tree, uint32_t index,
                         void (*find)(struct query *q))
{
    return probe_instance(&q->probe, &tree->body->instances[index], find);
}

static inline void intersect(const struct RTCIntersectFunctionNArguments *args,
                             probe_function *probe)
{
    struct query *q = (struct query *)args->context;
    if (probe(q, args->geometryUserPtr, args->primID, find_closest))
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = tree_end(&q->probe);
}

/* The first hit will do: a negative end stops the walk. */
static inline void occluded(const struct RTCOccludedFunctionNArguments *args,
                            probe_function *probe)
{
    struct query *q = (struct query *)args->context;
    if (probe(q, args->geometryUserPtr, args->primID, find_any))
        ((struct RTCRay *)args->ray)->tfar = -INFINITY;
}

static void intersect_piece(const struct RTCIntersectFunctionNArguments *args)
{
    intersect(args, probe_piece);
}

static void occluded_piece(const struct RTCOccludedFunctionNArguments *args)
{
    occluded(args, probe_piece);
}

static void intersect_round(const struct RTCIntersectFunctionNArguments *args)
{
    intersect(args, probe_round);
}

static void occluded_round(const struct RTCOccludedFunctionNArguments *args)
{
    occluded(args, probe_round);
}

static void intersect_triangle(const struct RTCIntersectFunctionNArguments *args)
{
    intersect(args, probe_triangle);
}

static void occluded_triangle(const struct RTCOccludedFunctionNArguments *args)
{
    occluded(args, probe_triangle);
}

static void intersect_instance(const struct RTCIntersectFunctionNArguments *args)
{
    intersect(args, probe_placed);
}

static void occluded_instance(const struct RTCOccludedFunctionNArguments *args)
{
    occluded(args, probe_placed);
}

/* ---- building ---- */

struct kind {
    RTCBoundsFunction bounds;
    RTCIntersectFunctionN intersect;
    RTCOccludedFunctionN occluded;
};

static void attach(RTCDevice device, struct pm_tree *tree, size_t count,
                   const struct kind *kind)
{
    if (count == 0)
        return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)count);
    rtcSetGeometryUserData(geometry, tree);
    rtcSetGeometryBoundsFunction(geometry, kind->bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, kind->intersect);
    rtcSetGeometryOccludedFunction(geometry, kind->occluded);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(tree->scene, geometry);
    rtcReleaseGeometry(geometry);
}

static void commit(RTCDevice device, struct pm_tree *tree)
{
    static const struct kind pieces = {piece_bounds, intersect_piece, occluded_piece};
    static const struct kind round = {round_bounds, intersect_round, occluded_round};
    static const struct kind triangles = {triangle_bounds, intersect_triangle,
                                          occluded_triangle};
    static const struct kind instances = {instance_bounds, intersect_instance,
                                          occluded_instance};
    const struct pm_body *body = tree->body;
    tree->scene = rtcNewScene(device);
    rtcSetSceneFlags(tree->scene, RTC_SCENE_FLAG_ROBUST);
    attach(device, tree, tree->pieces.count, &pieces);
    attach(device, tree, tree->round_count, &round);
    attach(device, tree, body->mesh.mesh ? body->own_count : 0, &triangles);
    attach(device, tree, body->instance_count, &instances);
    rtcCommitScene(tree->scene);
}

static bool list_round(struct pm_tree *tree)
{
    const struct pm_body *body = tree->body;
    tree->round = malloc(((size_t)body->shape_count + 1) * sizeof *tree->round);
    for (uint32_t i = 0; tree->round && i < body->shape_count; i++)
        if (body->shapes[i].type != PM_POLYGON)
            tree->round[tree->round_count++] = i;
    return tree->round;
}

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
}

static pm_status build_trees(struct pm_rays *rays, pm_world *world, pm_error *err)
{
    for (size_t i = 0; i < world->body_count; i++) {
        struct pm_tree *tree = &rays->trees[rays->count++];
        tree->body = &world->bodies[i];
        world->bodies[i].tree = tree;
        if (pm_pieces_build(tree->body, &tree->pieces) || !list_round(tree))
            return no_memory(err);
        commit(rays->device, tree);
    }
    enum RTCError failure = rtcGetDeviceError(rays->device);
    if (failure == RTC_ERROR_NONE)
        return PM_OK;
    return pm_error_set(err, PM_E_MEMORY, "Embree cannot build its tree (error %d)",
                        (int)failure);
}

/* One thread and one instruction set: no thread is started behind the caller's back, and a
 * query takes the same way everywhere. */
pm_status pm_rays_build(pm_world *world, pm_error *err)
{
    struct pm_rays *rays = calloc(1, sizeof *rays);
    if (!rays)
        return no_memory(err);
    world->rays = rays;
    rays->trees = calloc(world->body_count, sizeof *rays->trees);
    if (!rays->trees)
        return no_memory(err);
    rays->device = rtcNewDevice("isa=avx2,threads=1,start_threads=0,set_affinity=0");
    if (!rays->device)
        return pm_error_set(err, PM_E_UNSUPPORTED,
                            "Embree does not start; it needs a processor with AVX2");
    return build_trees(rays, world, err);
}

void pm_rays_free(struct pm_rays *rays)
{
    if (!rays)
        return;
    for (size_t i = 0; i < rays->count; i++) {
        if (rays->trees[i].scene)
            rtcReleaseScene(rays->trees[i].scene);
        pm_pieces_clear(&rays->trees[i].pieces);
        free(rays->trees[i].round);
    }
    if (rays->device)
        rtcReleaseDevice(rays->device);
    free(rays->trees);
    free(rays);
}

/* ---- hits ---- */

static void fill_piece(const struct pm_tree *tree, uint32_t index, pm_vec3 point, pm_hit *hit)
{
    const struct pm_piece *p = &tree->pieces.piece[index];
    const struct pm_piece_owner *owner = &tree->pieces.owner[index];
    double height = pm_vec3_dot(p->normal, point) - p->offset;
    hit->point = pm_vec3_madd(point, -height, p->normal);
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

/* No ray that is not finite may reach Embree, which aborts on one; pm_probe_init turns them
 * away. */
bool pm_world_intersect(const pm_world *world, const pm_ray *ray, pm_hit *hit)
{
    struct query q;
    if (!pm_probe_init(&q.probe, world, ray))
        return false;
    find_closest(&q);
    if (!(q.probe.best.t < INFINITY))
        return false;
    fill_hit(&q.probe, hit);
    return true;
}

bool pm_rays_next(const pm_world *world, const pm_ray *ray, struct pm_ray_walk *walk,
                  pm_hit *hit)
{
    struct query q;
    if (!pm_probe_init(&q.probe, world, ray))
        return false;
    if (walk->started)
        q.probe.after = walk->last;
    find_closest(&q);
    if (!(q.probe.best.t < INFINITY))
        return false;
    fill_hit(&q.probe, hit);
    walk->last = q.probe.best;
    walk->started = true;
    return true;
}

bool pm_rays_any(const pm_world *world, const pm_ray *ray)
{
    struct query q;
    if (!pm_probe_init(&q.probe, world, ray))
        return false;
    find_any(&q);
    return q.probe.best.t < INFINITY;
}
