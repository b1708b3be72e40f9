#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "compile.h"
#include "numbers.h"
#include "world/body.h"
#include "world/material.h"
#include "world/rays.h"

/* Meshes against the same triangles as polygons. */

#define GREY "void plastic grey 0 0 5 .5 .5 .5 0 0\n"

static pm_world *world_of_mesh(const char *main, const char *obj)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_bundle *bundle = pm_bundle_new();
    assert_int_equal(pm_bundle_add(bundle, "main.rad", main, strlen(main), NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "m.obj", obj, strlen(obj), NULL), PM_OK);
    pm_status status = pm_scene_parse(bundle, "main.rad", NULL, &scene, &err);
    if (!status)
        status = pm_world_compile(scene, &world, &err);
    if (status)
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    pm_bundle_free(bundle);
    pm_scene_free(scene);
    return world;
}

/* A bumpy ball of 2 * across^2 - 2 * across triangles, as obj or as polygons. */
static pm_vec3 bump(int i, int j, int across)
{
    double polar = PM_PI * i / across, azimuth = 2 * PM_PI * (j % across) / across;
    double r = 1 + .1 * sin(7 * polar) * cos(5 * azimuth);
    if (i == 0 || i == across)
        return pm_vec3_make(0, 0, i ? -1 : 1);
    return pm_vec3_make(r * sin(polar) * cos(azimuth), r * sin(polar) * sin(azimuth),
                        r * cos(polar));
}

static void add_bumps(struct text *obj, struct text *polygons, int across)
{
    add(polygons, GREY);
    for (int i = 0; i <= across; i++)
        for (int j = 0; j < across; j++) {
            pm_vec3 p = bump(i, j, across);
            add(obj, "v %.17g %.17g %.17g\n", p.x, p.y, p.z);
        }
    add(obj, "usemtl grey\n");
    for (int i = 0; i < across; i++)
        for (int k = 0; k < 2 * across; k++) {
            int j = k / 2, upper = k % 2;
            if (upper ? i == 0 : i == across - 1)
                continue;
            const int row[3] = {i, i + 1, upper ? i : i + 1};
            const int column[3] = {upper ? j : j, upper ? j + 1 : j, j + 1};
            add(obj, "f");
            add(polygons, "grey polygon p 0 0 9");
            for (int c = 0; c < 3; c++) {
                pm_vec3 p = bump(row[c], column[c], across);
                add(obj, " %d", row[c] * across + column[c] % across + 1);
                add(polygons, " %.17g %.17g %.17g", p.x, p.y, p.z);
            }
            add(obj, "\n");
            add(polygons, "\n");
        }
}

static void hits_are_those_of_polygons(void **state)
{
    (void)state;
    enum { ACROSS = 40, RAYS = 30000 };
    struct text obj = {0}, polygons = {0};
    add_bumps(&obj, &polygons, ACROSS);
    pm_world *a = world_of_mesh(GREY "void mesh m 1 m.obj 0 0\n", obj.data);
    pm_world *b = world_of(polygons.data);
    assert_int_equal(a->main->count, b->main->count);
    assert_int_equal(a->main->count, 2 * ACROSS * (ACROSS - 1));
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    int met = 0, apart = 0;
    for (int i = 0; i < RAYS; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 from = pm_vec3_scale(pm_warp_sphere(u[0], u[1]), i % 2 ? .3 : 1.5);
        pm_ray ray = {from, pm_warp_sphere(u[2], u[3]), INFINITY, PM_NO_PRIMITIVE};
        pm_hit p, q;
        bool hit = pm_world_intersect(a, &ray, &p), same = pm_world_intersect(b, &ray, &q);
        apart += hit != same;
        if (!hit || !same)
            continue;
        met++;
        double cosine = fabs(pm_vec3_dot(p.normal, ray.direction));
        apart += pm_vec3_distance(p.normal, q.normal) > 1e-12; /* at an edge */
        assert_at_most(pm_vec3_distance(p.point, q.point), 64 * 0x1p-53 / cosine);
        assert_int_equal(a->materials[p.material].type, PM_PLASTIC);
    }
    assert_in_range(met, RAYS / 2, RAYS);
    assert_in_range(apart, 0, 2);
    pm_world_free(a);
    pm_world_free(b);
    free(obj.data);
    free(polygons.data);
}

static void closed_meshes_leak_no_ray(void **state)
{
    (void)state;
    struct text obj = {0}, polygons = {0};
    add_bumps(&obj, &polygons, 60);
    pm_world *world = world_of_mesh(GREY "void mesh m 8 m.obj -rx 12 -ry 7 -s .01 -mx 0 0\n"
                                         "grey sphere far 0 0 4 9 9 9 1\n",
                                    obj.data);
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    for (int i = 0; i < 20000; i++) {
        pm_hit hit = {.point = pm_world_from_scene(world, pm_vec3_make(0, 0, 0)),
                      .surface = PM_NO_PRIMITIVE};
        for (int bounce = 0; bounce < 6; bounce++) {
            double u[2];
            draw(&rng, u, 2);
            pm_vec3 d = pm_warp_sphere(u[0], u[1]);
            if (bounce && pm_vec3_dot(d, hit.normal) > 0)
                d = pm_vec3_negate(d);
            pm_ray ray = {hit.point, d, INFINITY, hit.surface};
            assert_true(pm_world_intersect(world, &ray, &hit));
            assert_true(hit.surface != 0); /* the sphere outside */
        }
    }
    pm_world_free(world);
    free(obj.data);
    free(polygons.data);
}

/* Aimed at the corners and the middles of edges of a closed mesh from inside. */
static void edges_and_corners_hold(void **state)
{
    (void)state;
    enum { ACROSS = 24 };
    struct text obj = {0}, polygons = {0};
    add_bumps(&obj, &polygons, ACROSS);
    pm_world *world = world_of_mesh(GREY "void mesh m 1 m.obj 0 0\n", obj.data);
    const pm_vec3 inside = {.05, .02, -.03};
    for (int i = 0; i <= ACROSS; i++)
        for (int j = 0; j < ACROSS; j++)
            for (int k = 0; k < 3; k++) {
                pm_vec3 p = bump(i, j, ACROSS);
                pm_vec3 q = i < ACROSS ? bump(i + 1, j + (k == 2), ACROSS) : p;
                pm_vec3 to = k ? pm_vec3_scale(pm_vec3_add(p, q), .5) : p;
                to = pm_world_from_scene(world, to);
                pm_vec3 from = pm_world_from_scene(world, inside);
                pm_ray ray = {from, pm_vec3_normalize(pm_vec3_sub(to, from)), INFINITY,
                              PM_NO_PRIMITIVE};
                pm_hit hit;
                assert_true(pm_world_intersect(world, &ray, &hit));
            }
    pm_world_free(world);
    free(obj.data);
    free(polygons.data);
}

/* Two-sided: each side is a triangle of its own with the same corners. */
static void sides_of_one_triangle_are_met_in_order(void **state)
{
    (void)state;
    pm_world *world = world_of_mesh("void plastic up 0 0 5 .1 0 0 0 0\n"
                                    "void plastic down 0 0 5 .2 0 0 0 0\n"
                                    "void mesh m 5 m.obj -rx 10 -ry 20 0 0\n",
                                    "v 0 0 0\nv 1 .1 .2\nv .3 1 .4\n"
                                    "v .3 1 .4\nv 1 .1 .2\nv 0 0 0\n"
                                    "usemtl up\nf 1 2 3\nusemtl down\nf 4 5 6\n");
    pm_rng rng;
    pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
    int met = 0;
    for (int i = 0; i < 20000; i++) {
        double u[5];
        draw(&rng, u, 5);
        pm_vec3 from = pm_warp_sphere(u[0], u[1]);
        pm_vec3 to = {u[2] - .5, u[3] - .5, u[4] - .5};
        pm_ray ray = {from, pm_vec3_normalize(pm_vec3_sub(to, from)), INFINITY,
                      PM_NO_PRIMITIVE};
        struct pm_ray_walk walk = {.started = false};
        pm_hit first, second, third;
        if (!pm_rays_next(world, &ray, &walk, &first))
            continue;
        met++;
        assert_true(pm_rays_next(world, &ray, &walk, &second));
        assert_false(pm_rays_next(world, &ray, &walk, &third));
        assert_true(first.t == second.t);
        assert_int_equal(first.surface + second.surface, 1);
        /* one that turns back meets nothing, one that goes on meets the other */
        pm_ray back = {first.point, pm_vec3_negate(ray.direction), INFINITY, first.surface};
        assert_false(pm_world_intersect(world, &back, &third));
        pm_ray on = {first.point, ray.direction, INFINITY, first.surface};
        assert_true(pm_world_intersect(world, &on, &third));
        assert_int_equal(third.surface, second.surface);
    }
    assert_in_range(met, 1000, 20000);
    pm_world_free(world);
}

/* At the point with weights w of the corners (o_mesh.c): uv and normal are their means. */
static void coordinates_and_normals_are_interpolated(void **state)
{
    (void)state;
    pm_world *world = world_of_mesh(GREY "void mesh m 6 m.obj -rz 90 -s 3 -mx 0 0\n",
                                    "v 0 0 0\nv 4 0 0\nv 0 4 0\n"
                                    "vt 0 0\nvt 1 0\nvt .5 2\n"
                                    "vn 0 0 1\nvn .6 0 .8\nvn 0 -.6 .8\n"
                                    "usemtl grey\nf 1/1/1 2/2/2 3/3/3\n");
    static const double weights[][3] = {{.2, .3, .5}, {.5, .25, .25}, {.1, .8, .1}};
    for (int i = 0; i < 3; i++) {
        const double *w = weights[i];
        /* (x, y) -> (-y, x), thrice, mirrored */
        pm_vec3 at = {3 * 4 * w[2], 3 * 4 * w[1], 0};
        pm_ray ray = {pm_world_from_scene(world, pm_vec3_make(at.x, at.y, 1)),
                      {0, 0, -1},
                      INFINITY,
                      PM_NO_PRIMITIVE};
        pm_hit hit;
        assert_true(pm_world_intersect(world, &ray, &hit));
        assert_near(hit.normal.z, 1, 1e-15);
        assert_near(hit.u, w[1] + .5 * w[2], 1e-14);
        assert_near(hit.v, 2 * w[2], 1e-14);
        /* (.6 w1, -.6 w2), turned: (.6 w2, .6 w1), mirrored */
        pm_vec3 n = {-.6 * w[2], .6 * w[1], w[0] + .8 * (w[1] + w[2])};
        n = pm_vec3_normalize(n);
        pm_vec3 sum = pm_vec3_add(hit.normal, hit.perturbation);
        assert_near(sum.x, n.x, 1e-7); /* normals are floats */
        assert_near(sum.y, n.y, 1e-7);
        assert_near(sum.z, n.z, 1e-7);
    }
    pm_world_free(world);
}

/* Faces before any usemtl cannot be seen, but for a modifier of the mesh. */
static void slots_and_modifiers_say_what_is_seen(void **state)
{
    (void)state;
    const char *obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\n"
                      "f 1 2 3\nusemtl red\nf 4 5 6\n";
    pm_hit hit;
    for (int k = 0; k < 2; k++) {
        pm_world *world = world_of_mesh(
            k ? GREY "void plastic red 0 0 5 .9 0 0 0 0\ngrey mesh m 1 m.obj 0 0\n"
              : GREY "void plastic red 0 0 5 .9 0 0 0 0\nvoid mesh m 1 m.obj 0 0\n",
            obj);
        pm_vec3 from = pm_world_from_scene(world, pm_vec3_make(.2, .2, -3));
        pm_ray ray = {from, {0, 0, 1}, INFINITY, PM_NO_PRIMITIVE};
        assert_true(pm_world_intersect(world, &ray, &hit));
        assert_near(pm_world_to_scene(world, hit.point).z, k ? 0 : 1, 1e-14);
        assert_near(world->materials[hit.material].color.r, k ? .5 : .9, 0);
        pm_world_info info;
        pm_world_info_get(world, &info);
        assert_int_equal(info.surfaces, 2);
        assert_int_equal(info.diffuse_surfaces, k ? 2 : 1);
        pm_world_free(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_polygons),
        cmocka_unit_test(closed_meshes_leak_no_ray),
        cmocka_unit_test(edges_and_corners_hold),
        cmocka_unit_test(sides_of_one_triangle_are_met_in_order),
        cmocka_unit_test(coordinates_and_normals_are_interpolated),
        cmocka_unit_test(slots_and_modifiers_say_what_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
