#include "world/rays.h"

#include <stdlib.h>

#include <embree3/rtcore.h>

#include "world/pieces.h"
#include "world/probe.h"

struct pm_rays {
    RTCDevice device;
    RTCScene scene;
    struct pm_pieces pieces;
    uint32_t *round; /* shapes that are not polygons */
    size_t round_count;
    const struct pm_shape *shapes;
};

/* Embree hands the context of a query to the callbacks. */
struct query {
    struct RTCIntersectContext context; /* first */
    struct pm_probe probe;
};

/* Boxes are widened by this. A ray starts in the cube [-1, 1]^3 (and PM_CUBE_MARGIN) when it is
 * rounded to float: its origin is then off by at most 2^-25 a coordinate, its direction by
 * 2^-25, which over at most 2 sqrt(3) is 3.5 * 2^-25. Together less than 5 * 2^-25; Embree's
 * robust traversal covers its own rounding. */
#define BOX_MARGIN 0x1p-22

/* ---- what Embree calls ---- */

/* Rounds outwards. */
static void set_bounds(struct RTCBounds *b, pm_vec3 low, pm_vec3 high)
{
    b->lower_x = nextafterf((float)(low.x - BOX_MARGIN), -INFINITY);
    b->lower_y = nextafterf((float)(low.y - BOX_MARGIN), -INFINITY);
    b->lower_z = nextafterf((float)(low.z - BOX_MARGIN), -INFINITY);
    b->upper_x = nextafterf((float)(high.x + BOX_MARGIN), INFINITY);
    b->upper_y = nextafterf((float)(high.y + BOX_MARGIN), INFINITY);
    b->upper_z = nextafterf((float)(high.z + BOX_MARGIN), INFINITY);
}

static void piece_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_rays *rays = args->geometryUserPtr;
    const struct pm_piece *p = &rays->pieces.piece[args->primID];
    double low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        const double *c = p->corner[axis];
        low[axis] = fmin(fmin(c[0], c[1]), fmin(c[2], c[3]));
        high[axis] = fmax(fmax(c[0], c[1]), fmax(c[2], c[3]));
    }
    set_bounds(args->bounds_o, pm_vec3_make(low[0], low[1], low[2]),
               pm_vec3_make(high[0], high[1], high[2]));
}

static void round_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_rays *rays = args->geometryUserPtr;
    const struct pm_shape *s = &rays->shapes[rays->round[args->primID]];
    set_bounds(args->bounds_o, s->low, s->high);
}

/* Every box that holds a hit at t or before must still be visited. */
static float float_end(double t)
{
    return (float)(t * (1 + BOX_MARGIN) + BOX_MARGIN);
}

static void intersect_piece(const struct RTCIntersectFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    const struct pm_rays *rays = args->geometryUserPtr;
    if (pm_probe_piece(&q->probe, &rays->pieces, args->primID))
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = float_end(q->probe.best.t);
}

static void intersect_round(const struct RTCIntersectFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    const struct pm_rays *rays = args->geometryUserPtr;
    if (pm_probe_shape(&q->probe, rays->round[args->primID]))
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = float_end(q->probe.best.t);
}

/* The first hit will do: a negative end stops the walk. */
static void occluded_piece(const struct RTCOccludedFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    const struct pm_rays *rays = args->geometryUserPtr;
    if (pm_probe_piece(&q->probe, &rays->pieces, args->primID))
        ((struct RTCRay *)args->ray)->tfar = -INFINITY;
}

static void occluded_round(const struct RTCOccludedFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    const struct pm_rays *rays = args->geometryUserPtr;
    if (pm_probe_shape(&q->probe, rays->round[args->primID]))
        ((struct RTCRay *)args->ray)->tfar = -INFINITY;
}

/* ---- building ---- */

static void attach(struct pm_rays *rays, size_t count, RTCBoundsFunction bounds,
                   RTCIntersectFunctionN intersect, RTCOccludedFunctionN occluded)
{
    if (count == 0)
        return;
    RTCGeometry geometry = rtcNewGeometry(rays->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)count);
    rtcSetGeometryUserData(geometry, rays);
    rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occluded);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(rays->scene, geometry);
    rtcReleaseGeometry(geometry);
}

/* One thread and one instruction set: no thread is started behind the caller's back, and a
 * query takes the same way everywhere. */
static pm_status build_tree(struct pm_rays *rays, pm_error *err)
{
    rays->device = rtcNewDevice("isa=avx2,threads=1,start_threads=0,set_affinity=0");
    if (!rays->device)
        return pm_error_set(err, PM_E_UNSUPPORTED,
                            "Embree does not start; it needs a processor with AVX2");
    rays->scene = rtcNewScene(rays->device);
    rtcSetSceneFlags(rays->scene, RTC_SCENE_FLAG_ROBUST);
    attach(rays, rays->pieces.count, piece_bounds, intersect_piece, occluded_piece);
    attach(rays, rays->round_count, round_bounds, intersect_round, occluded_round);
    rtcCommitScene(rays->scene);
    enum RTCError failure = rtcGetDeviceError(rays->device);
    if (failure == RTC_ERROR_NONE)
        return PM_OK;
    return pm_error_set(err, PM_E_MEMORY, "Embree cannot build its tree (error %d)",
                        (int)failure);
}

static bool list_round(const pm_world *world, struct pm_rays *rays)
{
    rays->round = malloc((world->shape_count + 1) * sizeof *rays->round);
    for (uint32_t i = 0; rays->round && i < world->shape_count; i++)
        if (world->shapes[i].type != PM_POLYGON)
            rays->round[rays->round_count++] = i;
    return rays->round;
}

pm_status pm_rays_build(pm_world *world, pm_error *err)
{
    struct pm_rays *rays = calloc(1, sizeof *rays);
    if (!rays)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
    rays->shapes = world->shapes;
    pm_status status = pm_pieces_build(world, &rays->pieces);
    if (status || !list_round(world, rays))
        status = pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
    else
        status = build_tree(rays, err);
    if (status)
        pm_rays_free(rays);
    else
        world->rays = rays;
    return status;
}

void pm_rays_free(struct pm_rays *rays)
{
    if (!rays)
        return;
    if (rays->scene)
        rtcReleaseScene(rays->scene);
    if (rays->device)
        rtcReleaseDevice(rays->device);
    pm_pieces_clear(&rays->pieces);
    free(rays->round);
    free(rays);
}

/* ---- queries ---- */

/* No ray that is not finite may reach Embree, which aborts on one; pm_probe_init turns them
 * away.
 */
static bool query_init(struct query *q, const pm_world *world, const pm_ray *ray)
{
    rtcInitIntersectContext(&q->context);
    return pm_probe_init(&q->probe, world, ray);
}

static struct RTCRay float_ray(const struct pm_probe *p)
{
    return (struct RTCRay){.org_x = (float)p->origin.x,
                           .org_y = (float)p->origin.y,
                           .org_z = (float)p->origin.z,
                           .dir_x = (float)p->direction.x,
                           .dir_y = (float)p->direction.y,
                           .dir_z = (float)p->direction.z,
                           .tfar = float_end(p->limit),
                           .mask = UINT32_MAX};
}

static bool find_closest(const pm_world *world, struct query *q)
{
    struct RTCRayHit rayhit = {.ray = float_ray(&q->probe),
                               .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcIntersect1(world->rays->scene, &q->context, &rayhit);
    return q->probe.best.t < INFINITY;
}

static void fill_hit(const pm_world *world, const struct pm_probe *probe, pm_hit *hit)
{
    pm_vec3 point = pm_vec3_madd(probe->origin, probe->best.t, probe->direction);
    const struct pm_shape *s = &world->shapes[probe->best_shape];
    hit->t = probe->entry + probe->best.t;
    hit->surface = probe->best_shape;
    if (probe->best_piece == PM_NO_PRIMITIVE) {
        hit->point = pm_shape_project(s, point);
        hit->normal = pm_shape_normal(s, hit->point);
        hit->material = s->material;
        return;
    }
    const struct pm_piece *p = &world->rays->pieces.piece[probe->best_piece];
    const struct pm_piece_owner *owner = &world->rays->pieces.owner[probe->best_piece];
    double height = pm_vec3_dot(p->normal, point) - p->offset;
    hit->point = pm_vec3_madd(point, -height, p->normal);
    hit->normal = owner->planar ? p->normal : s->axis;
    hit->material = owner->material;
}

bool pm_world_intersect(const pm_world *world, const pm_ray *ray, pm_hit *hit)
{
    struct query q;
    if (!query_init(&q, world, ray) || !find_closest(world, &q))
        return false;
    fill_hit(world, &q.probe, hit);
    return true;
}

bool pm_rays_next(const pm_world *world, const pm_ray *ray, struct pm_ray_walk *walk,
                  pm_hit *hit)
{
    struct query q;
    if (!query_init(&q, world, ray))
        return false;
    if (walk->started)
        q.probe.after = walk->last;
    if (!find_closest(world, &q))
        return false;
    fill_hit(world, &q.probe, hit);
    walk->last = q.probe.best;
    walk->started = true;
    return true;
}

bool pm_rays_any(const pm_world *world, const pm_ray *ray)
{
    struct query q;
    if (!query_init(&q, world, ray))
        return false;
    struct RTCRay shadow = float_ray(&q.probe);
    rtcOccluded1(world->rays->scene, &q.context, &shadow);
    return q.probe.best.t < INFINITY;
}
