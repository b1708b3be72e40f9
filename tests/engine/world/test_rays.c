#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "compile.h"
#include "numbers.h"
#include "world/body.h"
#include "world/pieces.h"
#include "world/rays.h"

#define GREY "void plastic grey 0 0 5 .5 .5 .5 0 0\n"

static pm_ray ray_from(pm_vec3 origin, pm_vec3 direction)
{
    return (pm_ray){.origin = origin,
                    .direction = pm_vec3_normalize(direction),
                    .t_max = INFINITY,
                    .from = PM_NO_PRIMITIVE};
}

/* In scene units. */
static pm_ray scene_ray(const pm_world *world, pm_vec3 origin, pm_vec3 direction)
{
    return ray_from(pm_world_from_scene(world, origin), direction);
}

static double scale_of(const pm_world *world)
{
    pm_world_info info;
    pm_world_info_get(world, &info);
    return info.scale;
}

/* ---- where surfaces are met ---- */

struct meeting {
    const char *surface;
    pm_vec3 origin, direction;
    double t; /* < 0: not met */
    pm_vec3 normal;
};

/* Lengths and normals by hand. */
static const struct meeting meetings[] = {
    {"sphere s 0 0 4 1 2 3 2", {1, 2, 9}, {0, 0, -1}, 4, {0, 0, 1}},
    {"sphere s 0 0 4 1 2 3 2", {1, 2, 3}, {0, 1, 0}, 2, {0, 1, 0}},
    {"bubble s 0 0 4 1 2 3 2", {1, 2, 3}, {0, 1, 0}, 2, {0, -1, 0}},
    {"sphere s 0 0 4 1 2 3 -2", {1, 2, 3}, {0, 1, 0}, 2, {0, -1, 0}},
    {"sphere s 0 0 4 1 2 3 2", {4, 2, 9}, {0, 0, -1}, -1, {0, 0, 0}},
    {"cylinder s 0 0 7 0 0 0 0 0 4 1", {5, 0, 1}, {-1, 0, 0}, 4, {1, 0, 0}},
    {"tube s 0 0 7 0 0 0 0 0 4 1", {5, 0, 1}, {-1, 0, 0}, 4, {-1, 0, 0}},
    {"cylinder s 0 0 7 0 0 0 0 0 4 1", {0, 0, 2}, {0, 1, 0}, 1, {0, 1, 0}},
    {"cylinder s 0 0 7 0 0 0 0 0 4 1", {0, 0, -3}, {0, 0, 1}, -1, {0, 0, 0}},
    {"cylinder s 0 0 7 0 0 0 0 0 4 1", {5, 0, 4.5}, {-1, 0, 0}, -1, {0, 0, 0}},
    /* in through the open end: x = 2 - t / sqrt 2, z = 5.5 - t / sqrt 2 */
    {"cylinder s 0 0 7 0 0 0 0 0 4 1", {2, 0, 5.5}, {-1, 0, -1}, 3 * M_SQRT2, {-1, 0, 0}},
    /* radius 2 - z / 2: at z = 2 from the side */
    {"cone s 0 0 8 0 0 0 0 0 4 2 0", {5, 0, 2}, {-1, 0, 0}, 4, {2, 0, 1}},
    {"cup s 0 0 8 0 0 0 0 0 4 2 0", {5, 0, 2}, {-1, 0, 0}, 4, {-2, 0, -1}},
    {"cone s 0 0 8 0 0 4 0 0 0 0 2", {0, 0, 2}, {1, 0, 0}, 1, {2, 0, 1}},
    /* beyond the apex lies the other half of the double cone, which is no part of it */
    {"cone s 0 0 8 0 0 0 0 0 4 2 0", {5, 0, 6}, {-1, 0, 0}, -1, {0, 0, 0}},
    /* parallel to a line of the cone: one root, and none */
    {"cone s 0 0 8 0 0 0 0 0 4 2 0", {-2, 0, 2}, {1, 0, -2}, 1.118033988749895, {-2, 0, 1}},
    {"cone s 0 0 8 0 0 0 0 0 4 2 0", {-2, 0, 2}, {1, 0, 2}, -1, {0, 0, 0}},
    {"ring s 0 0 8 0 0 1 0 0 2 1 3", {2, 0, 5}, {0, 0, -1}, 4, {0, 0, 1}},
    {"ring s 0 0 8 0 0 1 0 0 2 3 1", {2, 0, -5}, {0, 0, 1}, 6, {0, 0, 1}},
    {"ring s 0 0 8 0 0 1 0 0 2 1 3", {.5, 0, 5}, {0, 0, -1}, -1, {0, 0, 0}},
    {"ring s 0 0 8 0 0 1 0 0 2 1 3", {3.5, 0, 5}, {0, 0, -1}, -1, {0, 0, 0}},
    {"polygon s 0 0 12 0 0 0 4 0 0 4 4 0 0 4 0", {1, 3, 2}, {0, 0, -1}, 2, {0, 0, 1}},
    {"polygon s 0 0 12 0 0 0 4 0 0 4 4 0 0 4 0", {1, 3, -2}, {0, 0, 1}, 2, {0, 0, 1}},
    {"polygon s 0 0 12 0 0 0 0 4 0 4 4 0 4 0 0", {1, 3, 2}, {0, 0, -1}, 2, {0, 0, -1}},
    {"polygon s 0 0 12 0 0 0 4 0 0 4 4 0 0 4 0", {5, 3, 2}, {0, 0, -1}, -1, {0, 0, 0}},
    /* concave: in the notch, and beside it */
    {"polygon s 0 0 12 0 0 0 4 0 0 1 1 0 0 4 0", {1.5, 1.5, 2}, {0, 0, -1}, -1, {0, 0, 0}},
    {"polygon s 0 0 12 0 0 0 4 0 0 1 1 0 0 4 0", {.4, 2, 2}, {0, 0, -1}, 2, {0, 0, 1}},
    /* a hole by seam */
    {"polygon s 0 0 30 0 0 0 4 0 0 4 4 0 0 4 0 0 0 0 1 1 0 1 3 0 3 3 0 3 1 0 1 1 0",
     {2, 2, 2},
     {0, 0, -1},
     -1,
     {0, 0, 0}},
    {"polygon s 0 0 30 0 0 0 4 0 0 4 4 0 0 4 0 0 0 0 1 1 0 1 3 0 3 3 0 3 1 0 1 1 0",
     {.5, .5, 2},
     {0, 0, -1},
     2,
     {0, 0, 1}},
};

static void assert_meeting(const struct meeting *m)
{
    char text[512];
    snprintf(text, sizeof text, GREY "grey %s\n", m->surface);
    pm_world *world = world_of(text);
    pm_ray ray = scene_ray(world, m->origin, m->direction);
    pm_hit hit;
    assert_int_equal(pm_world_intersect(world, &ray, &hit), m->t >= 0);
    if (m->t >= 0) {
        pm_vec3 wanted = pm_vec3_normalize(m->normal), met;
        assert_near(hit.t * scale_of(world), m->t, 1e-14 * m->t);
        met = pm_vec3_madd(m->origin, m->t, pm_vec3_normalize(m->direction));
        assert_at_most(pm_vec3_distance(pm_world_to_scene(world, hit.point), met), 4e-15 * 10);
        assert_at_most(pm_vec3_distance(hit.normal, wanted), 4e-15);
        assert_at_most(
            pm_vec3_distance(hit.normal, pm_shape_normal(&world->shapes[0], hit.point)), 4e-15);
    }
    pm_world_free(world);
}

static void surfaces_are_met_where_analysis_says_on_both_sides(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof meetings / sizeof *meetings; i++)
        assert_meeting(&meetings[i]);
}

/* From a point of a sphere inwards: a chord of length 2 r cos. Outwards: nothing. */
static void a_sphere_is_met_from_itself_at_the_far_root_only(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "grey sphere s 0 0 4 .3 .2 .1 .7\n");
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (int i = 0; i < 20000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 point, normal, direction = pm_warp_sphere(u[2], u[3]);
        pm_shape_sample(&world->shapes[0], u[0], u[1], &point, &normal);
        pm_ray ray = {point, direction, INFINITY, 0};
        pm_hit hit;
        double cosine = pm_vec3_dot(normal, direction);
        assert_int_equal(pm_world_intersect(world, &ray, &hit), cosine < 0);
        if (cosine < 0)
            assert_near(hit.t, -2 * world->shapes[0].r0 * cosine, 2e-15);
    }
    pm_world_free(world);
}

/* From inside a closed cylinder (with its two discs) every ray meets one of the others, and it
 * never meets the surface that it leaves at the place that it leaves. */
static void walks_inside_curved_shapes_never_stick_nor_leave(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "grey tube t 0 0 7 .1 .2 0 .7 .9 2 .8\n"
                                    "grey ring a 0 0 8 .1 .2 0 .6 .7 2 0 .8000001\n"
                                    "grey ring b 0 0 8 .7 .9 2 .6 .7 2 0 .8000001\n"
                                    "grey cone c 0 0 8 .3 .4 .7 .5 .6 1.3 .3 .1\n");
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    pm_ray ray = scene_ray(world, pm_vec3_make(.4, .5, .3), pm_vec3_make(1, 2, 3));
    for (int i = 0; i < 300000; i++) {
        pm_hit hit;
        double u[2];
        draw(&rng, u, 2);
        assert_true(pm_world_intersect(world, &ray, &hit));
        assert_true(hit.t > 0);
        bool behind = pm_vec3_dot(hit.normal, ray.direction) > 0;
        pm_frame frame = pm_frame_make(behind ? pm_vec3_negate(hit.normal) : hit.normal);
        ray.direction = pm_frame_to_world(&frame, pm_warp_cosine(u[0], u[1]));
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    pm_world_free(world);
}

/* ---- the nearest one ---- */

static double number(pm_rng *rng, double low, double high)
{
    return low + (high - low) * pm_rng_uniform(rng);
}

static void add_random_shape(struct text *t, pm_rng *rng)
{
    double size = pow(2, number(rng, -12, -1)), p[3], q[9];
    for (int i = 0; i < 3; i++)
        p[i] = number(rng, -1, 1);
    for (int i = 0; i < 9; i++)
        q[i] = p[i % 3] + size * number(rng, -1, 1);
    switch (pm_rng_u32(rng) % 5) {
    case 0:
        add(t, "grey sphere s 0 0 4 %.17g %.17g %.17g %.17g\n", p[0], p[1], p[2], size);
        break;
    case 1:
        add(t, "grey cone s 0 0 8 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", p[0],
            p[1], p[2], q[0], q[1], q[2], size, size * number(rng, 0, 2));
        break;
    case 2:
        add(t, "grey ring s 0 0 8 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", p[0],
            p[1], p[2], q[0], q[1], q[2], size, size * number(rng, 0, .9));
        break;
    default:
        add(t, "grey polygon s 0 0 9 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n",
            q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[7], q[8]);
        break;
    }
}

/* The exact tests over every surface, without a tree. */
static bool met_by_brute_force(const pm_world *world, const struct pm_pieces *pieces,
                               const pm_ray *ray, struct pm_probe *probe)
{
    if (!pm_probe_init(probe, world, ray))
        return false;
    for (uint32_t i = 0; i < pieces->count; i++)
        pm_probe_piece(probe, pieces, i, false);
    for (uint32_t i = 0; i < world->shape_count; i++)
        if (world->shapes[i].type != PM_POLYGON)
            pm_probe_shape(probe, i);
    return probe->best.t < INFINITY;
}

/* Rays between surfaces, from far away, and of finite length. */
static pm_ray random_ray(const pm_world *world, pm_rng *rng)
{
    double u[8];
    draw(rng, u, 8);
    uint32_t a = pm_rng_u32(rng) % (uint32_t)world->shape_count;
    uint32_t b = pm_rng_u32(rng) % (uint32_t)world->shape_count;
    pm_vec3 p, q, normal;
    pm_shape_sample(&world->shapes[a], u[0], u[1], &p, &normal);
    pm_shape_sample(&world->shapes[b], u[2], u[3], &q, &normal);
    uint32_t from = a;
    if (u[4] < .3) {
        p = pm_vec3_scale(pm_warp_sphere(u[0], u[1]), pow(10, 6 * u[5]));
        from = PM_NO_PRIMITIVE;
    }
    pm_ray ray = ray_from(p, pm_vec3_sub(q, p));
    ray.from = from;
    if (u[4] > .8)
        ray.t_max = 2 * u[6];
    return ray;
}

static void the_tree_hides_no_surface(void **state)
{
    (void)state;
    struct text t = {0};
    pm_rng rng;
    pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
    add(&t, GREY);
    for (int i = 0; i < 1500; i++)
        add_random_shape(&t, &rng);
    pm_world *world = world_of(t.data);
    struct pm_pieces pieces;
    assert_int_equal(pm_pieces_build(world->main, &pieces), PM_OK);
    int met = 0;
    for (int i = 0; i < 30000; i++) {
        pm_ray ray = random_ray(world, &rng);
        struct pm_probe probe;
        pm_hit hit = {0};
        bool wanted = met_by_brute_force(world, &pieces, &ray, &probe);
        assert_int_equal(pm_world_intersect(world, &ray, &hit), wanted);
        assert_int_equal(pm_rays_any(world, &ray), wanted);
        if (wanted) {
            assert_int_equal(hit.surface, probe.best_surface);
            assert_true(hit.t == probe.main_entry + probe.best.t);
        }
        met += wanted;
    }
    assert_in_range(met, 15000, 30000);
    pm_pieces_clear(&pieces);
    pm_world_free(world);
    free(t.data);
}

/* Two squares 1e-9 apart: float sees them in one plane. */
static void polygons_a_billionth_apart_are_seen_in_order(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "void plastic red 0 0 5 .5 0 0 0 0\n"
                                    "grey polygon a 0 0 12 -1 -.9 -1 1 -.8 -1 1 .9 1 -1 .8 1\n"
                                    "red polygon b 0 0 12 -1 -.900000001 -1 1 -.800000001 -1 "
                                    "1 .899999999 1 -1 .799999999 1\n");
    double top = fmax(world->shapes[0].vertices[0].y, world->shapes[1].vertices[0].y);
    uint32_t upper = world->shapes[0].vertices[0].y == top ? 0 : 1;
    pm_rng rng;
    pm_rng_init(&rng, 4, PM_RNG_PATH, 0);
    for (int i = 0; i < 100000; i++) {
        double u[5];
        draw(&rng, u, 5);
        pm_vec3 target, normal, up = world->shapes[upper].axis;
        pm_shape_sample(&world->shapes[0], .05 + .9 * u[0], .05 + .9 * u[1], &target, &normal);
        if (up.y < 0)
            up = pm_vec3_negate(up);
        pm_frame frame = pm_frame_make(i & 1 ? up : pm_vec3_negate(up));
        /* down to a degree of grazing */
        pm_vec3 back = pm_frame_to_world(&frame, polar(.02 + .98 * u[2], 2 * PM_PI * u[3]));
        pm_ray ray = ray_from(pm_vec3_madd(target, .01 + u[4], back), pm_vec3_negate(back));
        pm_hit hit, next;
        if (!pm_world_intersect(world, &ray, &hit))
            continue; /* past the edge of the lower one */
        assert_int_equal(hit.surface, i & 1 ? upper : 1 - upper);
        ray.origin = hit.point;
        ray.from = hit.surface;
        assert_true(pm_world_intersect(world, &ray, &next));
        assert_int_equal(next.surface, 1 - hit.surface);
        assert_near(next.t * fabs(pm_vec3_dot(ray.direction, up)), 1e-9 * fabs(up.y), 2e-15);
        ray.direction = back;
        assert_false(pm_world_intersect(world, &ray, &next));
    }
    pm_world_free(world);
}

/* ---- coincident surfaces ---- */

/* Coincident in exact numbers, written differently; each in a colour of its own. */
static const char *const coincident[] = {
    "polygon s 0 0 12 -1 -.3 -1 1 -.1 -1 1 .3 1 -1 .1 1",
    "polygon s 0 0 12 1 .3 1 1 -.1 -1 -1 -.3 -1 -1 .1 1",
    "polygon s 0 0 12 .5 .15 .5 .5 -.05 -.5 -.5 -.15 -.5 -.5 .05 .5",
    "polygon s 0 0 9 -1 -.3 -1 0 -.2 -1 1 .3 1",
};

static pm_world *coincident_world(const int order[4])
{
    struct text t = {0};
    for (int i = 0; i < 4; i++)
        add(&t, "void plastic c%d 0 0 5 .%d .5 .5 0 0\nc%d %s\n", i, order[i] + 1, i,
            coincident[order[i]]);
    pm_world *world = world_of(t.data);
    free(t.data);
    return world;
}

/* A point of their plane y = .1 x + .2 z. */
static pm_vec3 coincident_point(const pm_world *world, double x, double z)
{
    return pm_world_from_scene(world, pm_vec3_make(x, .1 * x + .2 * z, z));
}

static void coincident_surfaces_give_one_answer_for_any_order_in_the_file(void **state)
{
    (void)state;
    const int forwards[] = {0, 1, 2, 3}, backwards[] = {3, 2, 1, 0};
    pm_world *a = coincident_world(forwards), *b = coincident_world(backwards);
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(a->shapes[i].group, a->shapes[0].group);
    pm_rng rng;
    pm_rng_init(&rng, 5, PM_RNG_PATH, 0);
    for (int i = 0; i < 20000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 target = coincident_point(a, -.45 + .9 * u[0], -.45 + .9 * u[1]);
        pm_vec3 origin = pm_vec3_add(target, pm_warp_sphere(u[2], u[3]));
        pm_ray ray = ray_from(origin, pm_vec3_sub(target, origin));
        pm_hit x, y;
        assert_true(pm_world_intersect(a, &ray, &x) && pm_world_intersect(b, &ray, &y));
        assert_int_equal(x.surface, y.surface);
        assert_true(x.t == y.t);
        assert_true(pm_digest_equal(pm_world_surface_digest(a, x.surface),
                                    pm_world_surface_digest(b, y.surface)));
    }
    pm_world_free(a);
    pm_world_free(b);
}

/* The order in which a ray meets the surfaces, stepping from each to the next as a path does.
 */
static int step_through(const pm_world *world, pm_ray ray, uint32_t met[8])
{
    int count = 0;
    pm_hit hit;
    while (count < 8 && pm_world_intersect(world, &ray, &hit)) {
        met[count++] = hit.surface;
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    return count;
}

static int walk_through(const pm_world *world, pm_ray ray, uint32_t met[8])
{
    int count = 0;
    struct pm_ray_walk walk = {.started = false};
    pm_hit hit;
    while (count < 8 && pm_rays_next(world, &ray, &walk, &hit))
        met[count++] = hit.surface;
    return count;
}

static void assert_met_in_opposite_orders(const pm_world *world, pm_vec3 origin, pm_vec3 target,
                                          int wanted)
{
    pm_vec3 other = pm_vec3_madd(target, 1, pm_vec3_sub(target, origin));
    uint32_t there[8], back[8], again[8];
    pm_ray ray = ray_from(origin, pm_vec3_sub(target, origin));
    assert_int_equal(step_through(world, ray, there), wanted);
    assert_int_equal(walk_through(world, ray, again), wanted);
    ray = ray_from(other, pm_vec3_sub(target, other));
    assert_int_equal(step_through(world, ray, back), wanted);
    for (int i = 0; i < wanted; i++) {
        assert_int_equal(there[i], again[i]);
        assert_int_equal(there[i], back[wanted - 1 - i]);
    }
}

static void
coincident_surfaces_are_each_met_once_in_opposite_orders_from_both_sides(void **state)
{
    (void)state;
    const int order[] = {0, 1, 2, 3};
    pm_world *flat = coincident_world(order);
    pm_world *round = world_of(GREY "void plastic red 0 0 5 .5 0 0 0 0\n"
                                    "grey sphere a 0 0 4 .1 .2 .3 .9\n"
                                    "red bubble b 0 0 4 .1 .2 .3 .9\n"
                                    "red sphere c 0 0 4 .1 .2 .3 .9\n");
    pm_world *straight = world_of(GREY "void plastic red 0 0 5 .5 0 0 0 0\n"
                                       "grey cylinder a 0 0 7 .1 .2 .3 .5 .7 .9 .2\n"
                                       "red tube b 0 0 7 .5 .7 .9 .1 .2 .3 .2\n");
    pm_rng rng;
    pm_rng_init(&rng, 6, PM_RNG_PATH, 0);
    for (int i = 0; i < 5000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 target = coincident_point(flat, .2 * u[0], -.1 - .2 * u[1]);
        pm_vec3 out = pm_warp_sphere(u[2], u[3]);
        assert_met_in_opposite_orders(flat, pm_vec3_add(target, out), target, 4);
        pm_vec3 center = round->shapes[0].center;
        assert_met_in_opposite_orders(round, pm_vec3_madd(center, 3, out), center, 6);
        const struct pm_shape *s = &straight->shapes[0];
        pm_vec3 middle = pm_vec3_madd(s->center, s->height / 2, s->axis);
        pm_vec3 across = pm_vec3_normalize(pm_vec3_cross(s->axis, out));
        assert_met_in_opposite_orders(straight, pm_vec3_madd(middle, 1.5, across), middle, 4);
    }
    pm_world_free(flat);
    pm_world_free(round);
    pm_world_free(straight);
}

/* Reflected at one of several coincident surfaces, a ray is free. */
static void a_ray_that_turns_back_meets_no_coincident_surface(void **state)
{
    (void)state;
    const int order[] = {0, 1, 2, 3};
    pm_world *world = coincident_world(order);
    pm_rng rng;
    pm_rng_init(&rng, 7, PM_RNG_PATH, 0);
    for (int i = 0; i < 20000; i++) {
        double u[6];
        draw(&rng, u, 6);
        pm_vec3 target = coincident_point(world, -.45 + .9 * u[0], -.45 + .9 * u[1]);
        pm_vec3 origin = pm_vec3_add(target, pm_warp_sphere(u[2], u[3]));
        pm_ray ray = ray_from(origin, pm_vec3_sub(target, origin));
        pm_hit hit, next;
        assert_true(pm_world_intersect(world, &ray, &hit));
        bool behind = pm_vec3_dot(hit.normal, ray.direction) > 0;
        pm_frame frame = pm_frame_make(behind ? pm_vec3_negate(hit.normal) : hit.normal);
        pm_ray back = {hit.point, pm_frame_to_world(&frame, pm_warp_cosine(u[4], u[5])),
                       INFINITY, hit.surface};
        assert_false(pm_world_intersect(world, &back, &next));
    }
    pm_world_free(world);
}

/* ---- nothing slips through ---- */

/* Each face of an octahedron, cut finer and put on a sphere, is split into a triangle and a
 * concave dart about an inner point; all corners are shared to the last bit. */
static pm_vec3 on_ball(pm_vec3 p)
{
    return pm_vec3_scale(pm_vec3_normalize(p), .8);
}

static void add_face(struct text *t, pm_vec3 a, pm_vec3 b, pm_vec3 c, int depth)
{
    if (depth > 0) {
        pm_vec3 ab = on_ball(pm_vec3_add(a, b)), bc = on_ball(pm_vec3_add(b, c));
        pm_vec3 ca = on_ball(pm_vec3_add(c, a));
        add_face(t, a, ab, ca, depth - 1);
        add_face(t, ab, b, bc, depth - 1);
        add_face(t, ca, bc, c, depth - 1);
        add_face(t, ab, bc, ca, depth - 1);
        return;
    }
    pm_vec3 p = pm_vec3_scale(pm_vec3_add(pm_vec3_add(a, a), pm_vec3_add(b, c)), .25);
    add(t, "grey polygon s 0 0 9 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", a.x,
        a.y, a.z, b.x, b.y, b.z, p.x, p.y, p.z);
    add(t,
        "grey polygon s 0 0 12 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g "
        "%.17g "
        "%.17g\n",
        p.x, p.y, p.z, b.x, b.y, b.z, c.x, c.y, c.z, a.x, a.y, a.z);
}

static pm_world *ball_of_darts(void)
{
    struct text t = {0};
    add(&t, GREY);
    for (int i = 0; i < 8; i++) {
        pm_vec3 x = {i & 1 ? .8 : -.8, 0, 0}, y = {0, i & 2 ? .8 : -.8, 0};
        add_face(&t, x, y, pm_vec3_make(0, 0, i & 4 ? .8 : -.8), 3);
    }
    pm_world *world = world_of(t.data);
    free(t.data);
    return world;
}

/* Diffuse walks inside: every ray must meet something. */
static int count_leaks(const pm_world *world, int rays)
{
    pm_rng rng;
    pm_rng_init(&rng, 8, PM_RNG_PATH, 0);
    int leaks = 0;
    pm_ray ray = ray_from(pm_vec3_make(.01, .02, .03), pm_vec3_make(1, 2, 3));
    for (int i = 0; i < rays; i++) {
        double u[2];
        pm_hit hit;
        draw(&rng, u, 2);
        if (!pm_world_intersect(world, &ray, &hit)) {
            leaks++;
            ray = ray_from(pm_vec3_make(.01, .02, .03), pm_warp_sphere(u[0], u[1]));
            continue;
        }
        bool behind = pm_vec3_dot(hit.normal, ray.direction) > 0;
        pm_frame frame = pm_frame_make(behind ? pm_vec3_negate(hit.normal) : hit.normal);
        ray = (pm_ray){hit.point, pm_frame_to_world(&frame, pm_warp_cosine(u[0], u[1])),
                       INFINITY, hit.surface};
    }
    return leaks;
}

/* Rays from within at corners and at points of edges. */
static int count_edge_leaks(const pm_world *world, int origins)
{
    pm_rng rng;
    pm_rng_init(&rng, 9, PM_RNG_PATH, 0);
    int leaks = 0;
    for (int k = 0; k < origins; k++) {
        double u[3];
        draw(&rng, u, 3);
        pm_vec3 origin = pm_vec3_scale(pm_warp_sphere(u[0], u[1]), .5 * u[2]);
        for (size_t i = 0; i < world->shape_count; i++) {
            const struct pm_shape *s = &world->shapes[i];
            for (uint32_t c = 0; c < s->vertex_count; c++) {
                pm_vec3 a = s->vertices[c], b = s->vertices[(c + 1) % s->vertex_count];
                pm_vec3 p = pm_vec3_madd(a, pm_rng_uniform(&rng), pm_vec3_sub(b, a));
                pm_ray corner = ray_from(origin, pm_vec3_sub(a, origin));
                pm_ray edge = ray_from(origin, pm_vec3_sub(p, origin));
                pm_hit hit;
                leaks += !pm_world_intersect(world, &corner, &hit);
                leaks += !pm_world_intersect(world, &edge, &hit);
            }
        }
    }
    return leaks;
}

static void closed_surfaces_leak_no_ray(void **state)
{
    (void)state;
    pm_world *box = world_of(GREY TEST_BOX("grey"));
    pm_world *ball = ball_of_darts();
    assert_int_equal(count_leaks(box, 1000000), 0);
    assert_int_equal(count_leaks(ball, 1000000), 0);
    assert_int_equal(count_edge_leaks(box, 10000), 0);
    assert_int_equal(count_edge_leaks(ball, 100), 0);
    pm_world_free(box);
    pm_world_free(ball);
}

/* ---- scale and place ---- */

/* A ball over a floor, a tilted pane and a cone, in units of `size` and at `offset`. */
static pm_world *moved_world(double size, double offset)
{
    struct text t = {0};
    double s = size, o = offset;
    add(&t,
        GREY "grey polygon f 0 0 12 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g "
             "%.17g %.17g %.17g\n",
        o, o, o, o + s, o, o, o + s, o + s, o, o, o + s, o);
    add(&t, "grey sphere b 0 0 4 %.17g %.17g %.17g %.17g\n", o + .3 * s, o + .4 * s, o + .4 * s,
        .25 * s);
    add(&t, "grey polygon p 0 0 9 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", o,
        o, o + .9 * s, o + .8 * s, o + .1 * s, o + .5 * s, o + .3 * s, o + .9 * s, o + .7 * s);
    add(&t, "grey cone c 0 0 8 %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", o + .7 * s,
        o + .7 * s, o, o + .8 * s, o + .6 * s, o + .6 * s, .2 * s, .05 * s);
    pm_world *world = world_of(t.data);
    free(t.data);
    return world;
}

/* The same rays in both, seen from the scene's own units. Hits move by the rounding of the
 * scene's numbers, magnified where the ray grazes or meets an edge: those few may differ. */
static void assert_same_hits(double size, double offset, double tolerance)
{
    pm_world *plain = moved_world(1, 0), *moved = moved_world(size, offset);
    double scale = scale_of(plain), moved_scale = scale_of(moved);
    pm_rng rng;
    pm_rng_init(&rng, 10, PM_RNG_PATH, 0);
    int differ = 0, met = 0;
    for (int i = 0; i < 20000; i++) {
        double u[5];
        draw(&rng, u, 5);
        pm_vec3 p = {u[0], u[1], u[2]}, direction = pm_warp_sphere(u[3], u[4]);
        pm_vec3 q = {offset + size * p.x, offset + size * p.y, offset + size * p.z};
        pm_ray a = scene_ray(plain, p, direction), b = scene_ray(moved, q, direction);
        pm_hit x = {0}, y = {0};
        bool hit_x = pm_world_intersect(plain, &a, &x),
             hit_y = pm_world_intersect(moved, &b, &y);
        differ += hit_x != hit_y ||
                  (hit_x && fabs(x.t * scale - y.t * moved_scale / size) > tolerance);
        met += hit_x;
    }
    assert_in_range(met, 5000, 20000);
    assert_in_range(differ, 0, tolerance < 1e-12 ? 0 : 2);
    pm_world_free(plain);
    pm_world_free(moved);
}

static void hits_do_not_depend_on_scale_or_place(void **state)
{
    (void)state;
    assert_same_hits(0x1p-20, 0, 1e-15);
    assert_same_hits(1e-6, 0, 1e-13);
    assert_same_hits(1e6, 0, 1e-13);
    assert_same_hits(1e-150, 0, 1e-13);
    assert_same_hits(1e150, 0, 1e-13);
    /* numbers of a million sizes are rounded to 2^-34 of a size */
    assert_same_hits(1, 1e6, 1e-8);
    assert_same_hits(1e-3, -1e3, 1e-8);
}

/* ---- needles, ends, and rays that are none ---- */

static void needles_are_met_within_and_missed_beside(void **state)
{
    (void)state;
    /* a metre long, a nanometre wide at one end */
    pm_world *world = world_of(GREY "grey polygon s 0 0 9 0 0 0 1 0 0 1 1e-9 0\n");
    int met = 0;
    for (int i = 1; i < 1000; i++) {
        double x = i / 1000.;
        pm_ray in = scene_ray(world, pm_vec3_make(x, .5e-9 * x, .3), pm_vec3_make(0, 0, -1));
        pm_ray out = scene_ray(world, pm_vec3_make(x, 1.01e-9 * x, .3), pm_vec3_make(0, 0, -1));
        pm_ray below =
            scene_ray(world, pm_vec3_make(x, -.01e-9 * x, .3), pm_vec3_make(0, 0, -1));
        pm_hit hit;
        met += pm_world_intersect(world, &in, &hit);
        assert_false(pm_world_intersect(world, &out, &hit));
        assert_false(pm_world_intersect(world, &below, &hit));
    }
    assert_int_equal(met, 999);
    pm_world_free(world);
}

static void rays_that_are_none_meet_nothing(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "grey sphere s 0 0 4 0 0 0 1\n");
    const double bad[] = {NAN, INFINITY, -INFINITY};
    const pm_ray good = ray_from(pm_vec3_make(0, 0, 0), pm_vec3_make(0, 0, 1));
    pm_hit hit;
    assert_true(pm_world_intersect(world, &good, &hit));
    for (int i = 0; i < 18; i++) {
        pm_ray ray = good;
        double *number[] = {&ray.origin.x,    &ray.origin.y,    &ray.origin.z,
                            &ray.direction.x, &ray.direction.y, &ray.direction.z};
        *number[i % 6] = bad[i / 6];
        assert_false(pm_world_intersect(world, &ray, &hit));
        assert_false(pm_rays_any(world, &ray));
    }
    const double ends[] = {NAN, 0, -1, -INFINITY};
    for (int i = 0; i < 4; i++) {
        pm_ray ray = good;
        ray.t_max = ends[i];
        assert_false(pm_world_intersect(world, &ray, &hit));
    }
    pm_ray still = good;
    still.direction = pm_vec3_make(0, 0, 0);
    assert_false(pm_world_intersect(world, &still, &hit));
    pm_world_free(world);
}

/* A ray aimed at a point of a surface does not meet that surface, whatever the rounding; one a
 * little longer does. */
static void surfaces_at_the_end_of_a_ray_are_not_met(void **state)
{
    (void)state;
    pm_world *world = world_of(GREY "grey sphere s 0 0 4 .3 .2 .1 .5\n"
                                    "grey polygon p 0 0 9 1 2 3 3 1 2 2 3 1\n"
                                    "grey cone c 0 0 8 -1 -1 -1 -2 -1.5 -.7 .2 .4\n"
                                    "grey ring r 0 0 8 -1 1 1 .3 .4 .5 .1 .9\n");
    pm_rng rng;
    pm_rng_init(&rng, 11, PM_RNG_PATH, 0);
    int met = 0;
    for (int i = 0; i < 100000; i++) {
        double u[5];
        draw(&rng, u, 5);
        uint32_t target = (uint32_t)i % 4;
        pm_vec3 point, normal, out = pm_warp_sphere(u[2], u[3]);
        pm_shape_sample(&world->shapes[target], u[0], u[1], &point, &normal);
        if (pm_vec3_dot(out, normal) < 0)
            out = pm_vec3_negate(out);
        pm_vec3 origin = pm_vec3_madd(point, .01 + u[4], out);
        pm_ray ray = ray_from(origin, pm_vec3_sub(point, origin));
        pm_hit hit;
        ray.t_max = pm_vec3_distance(point, origin);
        bool something = pm_world_intersect(world, &ray, &hit);
        if (something)
            assert_true(hit.surface != target || hit.t < ray.t_max - 1e-6);
        ray.t_max *= 1 + 1e-6;
        bool more = pm_world_intersect(world, &ray, &hit);
        assert_true(more || !something);
        met += more && !something && hit.surface == target;
    }
    assert_in_range(met, 50000, 100000);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_are_met_where_analysis_says_on_both_sides),
        cmocka_unit_test(a_sphere_is_met_from_itself_at_the_far_root_only),
        cmocka_unit_test(walks_inside_curved_shapes_never_stick_nor_leave),
        cmocka_unit_test(the_tree_hides_no_surface),
        cmocka_unit_test(polygons_a_billionth_apart_are_seen_in_order),
        cmocka_unit_test(coincident_surfaces_give_one_answer_for_any_order_in_the_file),
        cmocka_unit_test(
            coincident_surfaces_are_each_met_once_in_opposite_orders_from_both_sides),
        cmocka_unit_test(a_ray_that_turns_back_meets_no_coincident_surface),
        cmocka_unit_test(closed_surfaces_leak_no_ray),
        cmocka_unit_test(hits_do_not_depend_on_scale_or_place),
        cmocka_unit_test(needles_are_met_within_and_missed_beside),
        cmocka_unit_test(rays_that_are_none_meet_nothing),
        cmocka_unit_test(surfaces_at_the_end_of_a_ray_are_not_met),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
