#include "world/rays.h"

#include <assert.h>
#include <math.h>
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "world/media.h"

/* A triangle, or two that share the edge from corner 0 to corner 2; a single triangle repeats
 * its corner 0 as corner 3. */
struct piece {
    double corner[3][4]; /* [axis][corner] */
    pm_vec3 normal;
    double offset;
    uint32_t shape, group;
};

struct pm_rays {
    RTCDevice device;
    RTCScene scene;
    struct piece *pieces;
    size_t piece_count;
    uint32_t *round; /* shapes that are not polygons */
    size_t round_count;
    const struct pm_shape *shapes;
};

/* Boxes are widened by this. A ray is moved into the cube [-1, 1]^3 (and 2^-20) before it is
 * rounded to float: its origin is then off by at most 2^-25 a coordinate, its direction by
 * 2^-25, over at most 2 sqrt(3) that is 3.5 * 2^-25. Together less than 5 * 2^-25; Embree's
 * robust traversal covers its own rounding. */
#define BOX_MARGIN  0x1p-22
#define CUBE_MARGIN 0x1p-20

struct query {
    struct RTCIntersectContext context; /* first: Embree hands it to the callbacks */
    const struct pm_shape *shapes;
    pm_vec3 origin, direction; /* the origin moved into the cube */
    double entry;              /* how far it was moved */
    double o[3];
    double shear[2];
    int axis[3]; /* x, y of the sheared plane, and the direction's greatest axis */

    double limit, tolerance;
    uint32_t from, from_group;
    struct pm_ray_key after, best;
    uint32_t best_shape;
    const struct piece *best_piece; /* NULL if best_shape is no polygon */
};

/* ---- order along a ray ---- */

static bool precedes(const struct pm_ray_key *a, const struct pm_ray_key *b)
{
    if (a->t != b->t)
        return a->t < b->t;
    return a->group != b->group ? a->group < b->group : a->order < b->order;
}

/* `cosine`: of the direction with the shape's axis (planar) or with its outward normal. */
static struct pm_ray_key make_key(const struct pm_shape *shape, uint32_t index, double t,
                                  double cosine)
{
    int64_t order = (cosine < 0) != shape->flipped ? (int64_t)index : -(int64_t)index;
    return (struct pm_ray_key){t, shape->group, order};
}

/* A surface passes within rounding of the ray's end: it is what the ray was aimed at, or
 * coincides with it. */
static bool is_at_end(const struct query *q, double t, double cosine)
{
    double gap = q->limit - t;
    return !(gap > 0 && gap * fabs(cosine) > q->tolerance);
}

/* At t = 0 only what coincides with the surface that the ray starts from, and lies ahead of it.
 */
static bool offer(struct query *q, const struct pm_ray_key *key, uint32_t index,
                  const struct piece *piece)
{
    if (!(key->t > 0 || (key->t == 0 && key->group == q->from_group)))
        return false;
    if (!precedes(&q->after, key) || !precedes(key, &q->best))
        return false;
    q->best = *key;
    q->best_shape = index;
    q->best_piece = piece;
    return true;
}

/* ---- polygons ---- */

/* x_a y_b - y_a x_b with the right sign: where the difference of the rounded products could
 * lie, their errors are added (Kahan; Jeannerod, Louvet, Muller, Math. Comp. 82, 2013). Exactly
 * antisymmetric in a and b. */
static inline double edge(double xa, double ya, double xb, double yb)
{
    double p = xa * yb, q = ya * xb, e = p - q;
    if (fabs(e) <= 0x1p-51 * (fabs(p) + fabs(q)))
        e += fma(xa, yb, -p) - fma(ya, xb, -q);
    return e;
}

static inline bool same_side(double a, double b, double c)
{
    double low = fmin(a, fmin(b, c)), high = fmax(a, fmax(b, c));
    return (low >= 0 || high <= 0) && low != high;
}

/* Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013: the corners are
 * sheared so that the ray is the z axis. Equal corners are sheared to equal numbers and edges
 * decided by exact signs, so no ray slips between polygons that share an edge. */
static inline bool passes_through(const struct piece *p, const struct query *q)
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
    double diagonal = edge(x[2], y[2], x[0], y[0]);
    if (same_side(edge(x[0], y[0], x[1], y[1]), edge(x[1], y[1], x[2], y[2]), diagonal))
        return true;
    return same_side(edge(x[2], y[2], x[3], y[3]), edge(x[3], y[3], x[0], y[0]), -diagonal);
}

/* Along a plane the quotient of two roundings can be anything; the hit still lies within the
 * extent of the piece. */
static double clamp_grazing(const struct piece *p, const struct query *q, double t)
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

static bool test_piece(const struct piece *p, struct query *q)
{
    double cosine = pm_vec3_dot(p->normal, q->direction);
    double t = 0;
    if (p->group != q->from_group) {
        t = (p->offset - pm_vec3_dot(p->normal, q->origin)) / cosine;
        if (fabs(cosine) < 0x1p-26 && cosine != 0)
            t = clamp_grazing(p, q, t);
    }
    if (!(t >= q->after.t && t <= q->best.t) || is_at_end(q, t, cosine))
        return false;
    if (!passes_through(p, q))
        return false;
    struct pm_ray_key key = make_key(&q->shapes[p->shape], p->shape, t, cosine);
    return offer(q, &key, p->shape, p);
}

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
    const struct piece *p = (const struct piece *)args->geometryUserPtr + args->primID;
    double low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        const double *c = p->corner[axis];
        low[axis] = fmin(fmin(c[0], c[1]), fmin(c[2], c[3]));
        high[axis] = fmax(fmax(c[0], c[1]), fmax(c[2], c[3]));
    }
    set_bounds(args->bounds_o, pm_vec3_make(low[0], low[1], low[2]),
               pm_vec3_make(high[0], high[1], high[2]));
}

/* ---- rings and curved shapes ---- */

static bool test_ring(const struct pm_shape *s, uint32_t index, struct query *q)
{
    double cosine = pm_vec3_dot(s->axis, q->direction), t = 0;
    if (s->group != q->from_group)
        t = (s->offset - pm_vec3_dot(s->axis, q->origin)) / cosine;
    if (!(t >= q->after.t && t <= q->best.t) || is_at_end(q, t, cosine))
        return false;
    pm_vec3 p = pm_vec3_madd(q->origin, t, q->direction);
    double r = pm_vec3_distance(p, s->center);
    if (!(r >= s->r0 && r <= s->r1))
        return false;
    struct pm_ray_key key = make_key(s, index, t, cosine);
    return offer(q, &key, index, NULL);
}

static bool test_curved(const struct pm_shape *s, uint32_t index, struct query *q)
{
    double t[2];
    int count = pm_shape_roots(s, q->origin, q->direction, s->group == q->from_group, t);
    for (int i = 0; i < count; i++) {
        if (!(t[i] >= q->after.t && t[i] <= q->best.t && t[i] < q->limit))
            continue;
        pm_vec3 point = pm_vec3_madd(q->origin, t[i], q->direction);
        double cosine = pm_vec3_dot(pm_shape_normal(s, point), q->direction);
        struct pm_ray_key key = make_key(s, index, t[i], cosine);
        if (!is_at_end(q, t[i], cosine) && offer(q, &key, index, NULL))
            return true;
    }
    return false;
}

static bool test_round(const struct pm_rays *rays, uint32_t item, struct query *q)
{
    uint32_t index = rays->round[item];
    const struct pm_shape *s = &rays->shapes[index];
    return s->type == PM_RING ? test_ring(s, index, q) : test_curved(s, index, q);
}

static void round_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct pm_rays *rays = args->geometryUserPtr;
    const struct pm_shape *s = &rays->shapes[rays->round[args->primID]];
    set_bounds(args->bounds_o, s->low, s->high);
}

/* ---- what Embree calls ---- */

/* Every box that holds a hit at t or before must still be visited. */
static float float_end(double t)
{
    return (float)(t * (1 + BOX_MARGIN) + BOX_MARGIN);
}

static void intersect_piece(const struct RTCIntersectFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    if (test_piece((const struct piece *)args->geometryUserPtr + args->primID, q))
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = float_end(q->best.t);
}

static void occluded_piece(const struct RTCOccludedFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    if (test_piece((const struct piece *)args->geometryUserPtr + args->primID, q))
        ((struct RTCRay *)args->ray)->tfar = -INFINITY;
}

static void intersect_round(const struct RTCIntersectFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    if (test_round(args->geometryUserPtr, args->primID, q))
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = float_end(q->best.t);
}

static void occluded_round(const struct RTCOccludedFunctionNArguments *args)
{
    struct query *q = (struct query *)args->context;
    if (test_round(args->geometryUserPtr, args->primID, q))
        ((struct RTCRay *)args->ray)->tfar = -INFINITY;
}

/* ---- building ---- */

static bool share_diagonal(const struct pm_triangle *a, const struct pm_triangle *b, int *first,
                           int *other)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (a->corner[i] == b->corner[(j + 1) % 3] &&
                a->corner[(i + 1) % 3] == b->corner[j]) {
                *first = i;
                *other = (j + 2) % 3;
                return true;
            }
    return false;
}

static void set_corner(struct piece *p, int i, pm_vec3 v)
{
    p->corner[0][i] = v.x;
    p->corner[1][i] = v.y;
    p->corner[2][i] = v.z;
}

/* The triangle's own plane, for polygons that are not planar. */
static void set_own_plane(struct piece *p, pm_vec3 a, pm_vec3 b, pm_vec3 c)
{
    pm_vec3 n = pm_vec3_cross(pm_vec3_sub(b, a), pm_vec3_sub(c, a));
    double length = pm_vec3_length(n);
    if (length > 0)
        p->normal = pm_vec3_make(n.x / length, n.y / length, n.z / length);
    p->offset = pm_vec3_dot(p->normal, a);
}

/* One piece from triangle i of a shape, with triangle i + 1 if that shares an edge; says how
 * many it took. */
static uint32_t make_piece(const pm_world *world, uint32_t index, uint32_t i, struct piece *p)
{
    const struct pm_shape *s = &world->shapes[index];
    const struct pm_triangle *t = &s->triangles[i];
    const bool planar = s->deviation <= world->tolerance;
    int first = 0, other = 0;
    bool two = planar && i + 1 < s->triangle_count && share_diagonal(t, t + 1, &first, &other);
    /* the shared edge goes from corner 2 to corner 0 */
    const uint32_t corner[3] = {t->corner[(first + 1) % 3], t->corner[(first + 2) % 3],
                                t->corner[first]};
    for (int k = 0; k < 3; k++)
        set_corner(p, k, s->vertices[corner[k]]);
    set_corner(p, 3, s->vertices[two ? t[1].corner[other] : corner[0]]);
    p->normal = s->axis;
    p->offset = s->offset;
    if (!planar)
        set_own_plane(p, s->vertices[corner[0]], s->vertices[corner[1]],
                      s->vertices[corner[2]]);
    p->shape = index;
    p->group = s->group;
    return two ? 2 : 1;
}

static bool make_pieces(const pm_world *world, struct pm_rays *rays)
{
    size_t triangles = 0, round = 0;
    for (size_t i = 0; i < world->shape_count; i++) {
        triangles += world->shapes[i].triangle_count;
        round += world->shapes[i].type != PM_POLYGON;
    }
    rays->pieces = malloc((triangles + 1) * sizeof *rays->pieces);
    rays->round = malloc((round + 1) * sizeof *rays->round);
    if (!rays->pieces || !rays->round || triangles >= UINT32_MAX)
        return false;
    for (uint32_t i = 0; i < world->shape_count; i++) {
        const struct pm_shape *s = &world->shapes[i];
        if (s->type != PM_POLYGON)
            rays->round[rays->round_count++] = i;
        for (uint32_t k = 0; k < s->triangle_count;)
            k += make_piece(world, i, k, &rays->pieces[rays->piece_count++]);
    }
    struct piece *fitting =
        realloc(rays->pieces, (rays->piece_count + 1) * sizeof *rays->pieces);
    if (fitting)
        rays->pieces = fitting;
    return true;
}

static void attach(struct pm_rays *rays, size_t count, void *user, RTCBoundsFunction bounds,
                   RTCIntersectFunctionN intersect, RTCOccludedFunctionN occluded)
{
    if (count == 0)
        return;
    RTCGeometry geometry = rtcNewGeometry(rays->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)count);
    rtcSetGeometryUserData(geometry, user);
    rtcSetGeometryBoundsFunction(geometry, bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occluded);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(rays->scene, geometry);
    rtcReleaseGeometry(geometry);
}

/* One thread and one instruction set, so that the same tree is built everywhere and that no
 * thread is started behind the caller's back. */
static pm_status build_tree(struct pm_rays *rays, pm_error *err)
{
    rays->device = rtcNewDevice("isa=avx2,threads=1,start_threads=0,set_affinity=0");
    if (!rays->device)
        return pm_error_set(err, PM_E_UNSUPPORTED,
                            "Embree does not start; it needs a processor with AVX2");
    rays->scene = rtcNewScene(rays->device);
    rtcSetSceneFlags(rays->scene, RTC_SCENE_FLAG_ROBUST);
    attach(rays, rays->piece_count, rays->pieces, piece_bounds, intersect_piece,
           occluded_piece);
    attach(rays, rays->round_count, rays, round_bounds, intersect_round, occluded_round);
    rtcCommitScene(rays->scene);
    enum RTCError failure = rtcGetDeviceError(rays->device);
    if (failure == RTC_ERROR_NONE)
        return PM_OK;
    return pm_error_set(err, PM_E_MEMORY, "Embree cannot build its tree (error %d)",
                        (int)failure);
}

pm_status pm_rays_build(pm_world *world, pm_error *err)
{
    struct pm_rays *rays = calloc(1, sizeof *rays);
    if (!rays)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
    rays->shapes = world->shapes;
    pm_status status = PM_OK;
    if (!make_pieces(world, rays))
        status = pm_error_set(err, PM_E_MEMORY, "no memory for the ray structure");
    if (!status)
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
    free(rays->pieces);
    free(rays->round);
    free(rays);
}

/* ---- queries ---- */

/* Moves a far origin to where the ray enters the cube, so that rounding to float costs no more
 * than BOX_MARGIN allows. False if the ray misses the cube. */
static bool enter_cube(struct query *q)
{
    const double bound = 1 + CUBE_MARGIN;
    double o[3] = {q->origin.x, q->origin.y, q->origin.z};
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    double in = 0, out = INFINITY;
    for (int i = 0; i < 3; i++) {
        if (d[i] == 0) {
            if (fabs(o[i]) > bound)
                return false;
            continue;
        }
        double a = (-bound - o[i]) / d[i], b = (bound - o[i]) / d[i];
        in = fmax(in, fmin(a, b));
        out = fmin(out, fmax(a, b));
    }
    if (!(in <= out && in < q->limit))
        return false;
    q->entry = in;
    q->limit -= in;
    for (int i = 0; i < 3; i++)
        o[i] = fmin(fmax(o[i] + in * d[i], -bound), bound);
    q->origin = pm_vec3_make(o[0], o[1], o[2]);
    return true;
}

static bool is_in_cube(pm_vec3 p)
{
    return fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))) <= 1 + CUBE_MARGIN;
}

static void set_shear(struct query *q)
{
    const double d[3] = {q->direction.x, q->direction.y, q->direction.z};
    int z = fabs(d[1]) > fabs(d[0]) ? 1 : 0;
    z = fabs(d[2]) > fabs(d[z]) ? 2 : z;
    int x = (z + 1) % 3, y = (z + 2) % 3;
    q->axis[0] = x;
    q->axis[1] = y;
    q->axis[2] = z;
    q->shear[0] = d[x] / d[z];
    q->shear[1] = d[y] / d[z];
    q->o[0] = q->origin.x;
    q->o[1] = q->origin.y;
    q->o[2] = q->origin.z;
}

/* What lies behind the ray's start: everything up to t = 0, and of what coincides with `from`
 * that which comes before it. */
static void set_start(struct query *q)
{
    q->after = (struct pm_ray_key){0, UINT32_MAX, INT64_MAX};
    q->from_group = PM_NO_PRIMITIVE;
    if (q->from == PM_NO_PRIMITIVE)
        return;
    const struct pm_shape *s = &q->shapes[q->from];
    pm_vec3 normal = pm_shape_is_planar(s) ? s->axis : pm_shape_normal(s, q->origin);
    q->from_group = s->group;
    q->after = make_key(s, q->from, 0, pm_vec3_dot(normal, q->direction));
}

/* False for rays that meet nothing: not finite, without direction, past the cube, or empty. No
 * other ray may reach Embree, which aborts on numbers that are not finite. */
static bool query_init(struct query *q, const pm_world *world, const pm_ray *ray)
{
    if (!pm_vec3_finite(ray->origin) || !pm_vec3_finite(ray->direction) || !(ray->t_max > 0) ||
        (ray->direction.x == 0 && ray->direction.y == 0 && ray->direction.z == 0) ||
        world->shape_count == 0)
        return false;
    rtcInitIntersectContext(&q->context);
    q->shapes = world->shapes;
    q->origin = ray->origin;
    q->direction = ray->direction;
    q->entry = 0;
    q->limit = ray->t_max;
    q->tolerance = world->tolerance;
    q->from = ray->from;
    if (!is_in_cube(q->origin) && !enter_cube(q))
        return false;
    set_shear(q);
    set_start(q);
    q->best = (struct pm_ray_key){INFINITY, 0, 0};
    return true;
}

static struct RTCRay float_ray(const struct query *q)
{
    return (struct RTCRay){.org_x = (float)q->origin.x,
                           .org_y = (float)q->origin.y,
                           .org_z = (float)q->origin.z,
                           .dir_x = (float)q->direction.x,
                           .dir_y = (float)q->direction.y,
                           .dir_z = (float)q->direction.z,
                           .tfar = float_end(q->limit),
                           .mask = UINT32_MAX};
}

static bool find_closest(const pm_world *world, struct query *q)
{
    struct RTCRayHit rayhit = {.ray = float_ray(q), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcIntersect1(world->rays->scene, &q->context, &rayhit);
    return q->best.t < INFINITY;
}

static void fill_hit(const pm_world *world, const struct query *q, pm_hit *hit)
{
    const struct pm_shape *s = &world->shapes[q->best_shape];
    pm_vec3 point = pm_vec3_madd(q->origin, q->best.t, q->direction);
    if (q->best_piece) {
        const struct piece *p = q->best_piece;
        double height = pm_vec3_dot(p->normal, point) - p->offset;
        hit->point = pm_vec3_madd(point, -height, p->normal);
    } else {
        hit->point = pm_shape_project(s, point);
    }
    hit->t = q->entry + q->best.t;
    hit->normal = pm_shape_normal(s, hit->point);
    hit->surface = q->best_shape;
    hit->material = s->material;
}

bool pm_world_intersect(const pm_world *world, const pm_ray *ray, pm_hit *hit)
{
    struct query q;
    if (!query_init(&q, world, ray) || !find_closest(world, &q))
        return false;
    fill_hit(world, &q, hit);
    return true;
}

bool pm_rays_next(const pm_world *world, const pm_ray *ray, struct pm_ray_walk *walk,
                  pm_hit *hit)
{
    struct query q;
    if (!query_init(&q, world, ray))
        return false;
    if (walk->started)
        q.after = walk->last;
    if (!find_closest(world, &q))
        return false;
    fill_hit(world, &q, hit);
    walk->last = q.best;
    walk->started = true;
    return true;
}

bool pm_rays_any(const pm_world *world, const pm_ray *ray)
{
    struct query q;
    if (!query_init(&q, world, ray))
        return false;
    struct RTCRay shadow = float_ray(&q);
    rtcOccluded1(world->rays->scene, &q.context, &shadow);
    return q.best.t < INFINITY;
}
