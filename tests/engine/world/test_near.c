/* What stands around a point, against distances to each triangle by themselves. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"
#include "world/near.h"
#include "world/surface.h"

enum { SAMPLES = 200, STEPS = 40 };

/* Distance from p to the nearest of many places of a triangle above p's tangent plane: never
 * less than the truth. */
static double distance_above(pm_vec3 p, pm_vec3 up, const pm_vec3 t[3])
{
    double nearest = INFINITY;
    for (int i = 0; i <= STEPS; i++)
        for (int k = 0; k <= STEPS - i; k++) {
            double u = (double)i / STEPS, v = (double)k / STEPS;
            pm_vec3 place = pm_vec3_scale(t[0], 1 - u - v);
            place = pm_vec3_madd(pm_vec3_madd(place, u, t[1]), v, t[2]);
            pm_vec3 way = pm_vec3_sub(place, p);
            if (pm_vec3_dot(way, up) > 1e-4)
                nearest = fmin(nearest, pm_vec3_length(way));
        }
    return nearest;
}

static bool is_steep(const pm_vec3 t[3], pm_vec3 up)
{
    pm_vec3 n = pm_vec3_cross(pm_vec3_sub(t[1], t[0]), pm_vec3_sub(t[2], t[0]));
    return fabs(pm_vec3_dot(pm_vec3_normalize(n), up)) < PM_STEEP_COSINE - 1e-6;
}

static pm_vec3 vector_of(const double *u, double size)
{
    return (pm_vec3){size * (2 * u[0] - 1), size * (2 * u[1] - 1), size * (2 * u[2] - 1)};
}

/* `count` small triangles in a cube of edge 2; a few need no tree. */
static void expect_found(int count)
{
    pm_vec3(*triangles)[3] = calloc((size_t)count, sizeof *triangles);
    char *text = calloc((size_t)count + 2, 300);
    assert_true(triangles && text);
    size_t used = (size_t)sprintf(text, "void plastic p 0 0 5 .5 .5 .5 0 0\n");
    pm_rng rng;
    pm_rng_init(&rng, 8, PM_RNG_PATH, (uint64_t)count);
    for (int i = 0; i < count; i++) {
        double u[12];
        draw(&rng, u, 12);
        for (int k = 0; k < 3; k++)
            triangles[i][k] = pm_vec3_add(vector_of(u, 1), vector_of(u + 3 + 3 * k, .3));
        const pm_vec3 *t = triangles[i];
        used += (size_t)sprintf(text + used,
                                "p polygon t%d 0 0 9 %.17g %.17g %.17g %.17g %.17g %.17g %.17g "
                                "%.17g %.17g\n",
                                i, t[0].x, t[0].y, t[0].z, t[1].x, t[1].y, t[1].z, t[2].x,
                                t[2].y, t[2].z);
    }
    pm_world *world = world_of(text);
    pm_world_info info;
    pm_world_info_get(world, &info);
    int near = 0, far = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double u[6], nearest = INFINITY;
        draw(&rng, u, 6);
        pm_vec3 p = vector_of(u, 1), up = pm_vec3_normalize(vector_of(u + 3, 1));
        for (int k = 0; k < count; k++)
            if (is_steep(triangles[k], up))
                nearest = fmin(nearest, distance_above(p, up, triangles[k]));
        pm_vec3 at = pm_world_from_scene(world, p);
        if (nearest < INFINITY) {
            assert_true(pm_world_stands_near(world, at, up, nearest * 1.001 / info.scale,
                                             PM_NO_PRIMITIVE));
            near++;
        }
        /* the box of a triangle of size .6 sqrt(3) is no farther than that from it */
        if (nearest > .2 &&
            !pm_world_stands_near(world, at, up, .01 / info.scale, PM_NO_PRIMITIVE))
            far++;
    }
    assert_true(near > SAMPLES / 2 && (count > 100 || far > SAMPLES / 4));
    pm_world_free(world);
    free(triangles);
    free(text);
}

static void walls_within_the_radius_are_found(void **state)
{
    (void)state;
    expect_found(3);
    expect_found(20);
    expect_found(300);
}

/* The surface itself, flat ones beside it and what lies below are no walls; a round thing is.
 */
static void floors_are_no_walls(void **state)
{
    (void)state;
    pm_world *world = world_of("void plastic p 0 0 5 .5 .5 .5 0 0\n"
                               "p polygon a 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n"
                               "p polygon b 0 0 12 1 0 0 2 0 .1 2 1 .1 1 1 0\n"
                               "p polygon c 0 0 12 0 0 0 0 1 0 0 1 -1 0 0 -1\n"
                               "p ring d 0 0 8 .5 .5 .01 0 0 1 0 .4\n"
                               "p sphere e 0 0 4 .5 .5 2 .5\n");
    pm_world_info info;
    pm_world_info_get(world, &info);
    pm_vec3 at = pm_world_from_scene(world, (pm_vec3){.5, .5, 0}), up = {0, 0, 1};
    assert_false(pm_world_stands_near(world, at, up, 1.4 / info.scale, PM_NO_PRIMITIVE));
    assert_true(pm_world_stands_near(world, at, up, 1.6 / info.scale, PM_NO_PRIMITIVE));
    pm_vec3 down = {0, 0, -1};
    assert_true(pm_world_stands_near(world, at, down, .6 / info.scale, PM_NO_PRIMITIVE));
    assert_false(pm_world_stands_near(world, at, down, .4 / info.scale, PM_NO_PRIMITIVE));
    pm_world_free(world);
}

/* ---- what stands between ---- */

/* Floors, one of them beside and one above the others, a ramp; walls, some of them above the
 * floor or below it; balls that photons may lie on and balls that they may not. */
static const char furniture[] =
    "void plastic p 0 0 5 .5 .5 .5 0 0  void metal m 0 0 5 .9 .9 .9 1 0\n"
    "p polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"
    "p polygon next 0 0 12 1 -1 0 2 -1 0 2 1 0 1 1 0\n"
    "p polygon table 0 0 12 -.9 -.9 .02 -.7 -.9 .02 -.7 -.7 .02 -.9 -.7 .02\n"
    "p polygon edge 0 0 12 -.9 -.7 0 -.7 -.7 0 -.7 -.7 .02 -.9 -.7 .02\n"
    "p polygon ramp 0 0 12 .2 .5 0 .6 .5 0 .6 .9 .1 .2 .9 .1\n"
    "p polygon wall 0 0 12 1 -1 0 1 .2 0 1 .2 1 1 -1 1\n"
    "p polygon thin 0 0 12 -.3 -.5 0 -.3 .5 0 -.3 .5 .4 -.3 -.5 .4\n"
    "p polygon high 0 0 12 .3 -.5 .01 .3 .5 .01 .3 .5 .4 .3 -.5 .4\n"
    "p polygon low 0 0 12 0 -.5 -.4 0 .5 -.4 0 .5 0 0 -.5 0\n"
    "p polygon west 0 0 12 -1 -1 0 -1 1 0 -1 1 1 -1 -1 1\n"
    "p polygon slant 0 0 12 -.1 .6 0 0 1 0 0 1 .4 .1 .6 .4\n"
    "p sphere ball 0 0 4 .6 -.4 .05 .1\n"
    "m sphere mirror 0 0 4 .6 -.8 .1 .1\n"
    "m sphere over 0 0 4 -.6 .5 .3 .2\n"
    "m sphere around 0 0 4 0 0 0 4\n";

enum { PLACES = 30000 };

/* Whether anything that leans more than the mean normal allows, but `from`, is on the way. */
static bool is_hidden(const pm_world *world, uint32_t from, pm_vec3 a, pm_vec3 b, pm_vec3 up)
{
    pm_vec3 way = pm_vec3_sub(b, a);
    pm_ray ray = {a, pm_vec3_normalize(way), pm_vec3_length(way), PM_NO_PRIMITIVE};
    pm_hit hit;
    while (ray.t_max > 0 && pm_world_intersect(world, &ray, &hit)) {
        if (hit.surface != from &&
            fabs(pm_vec3_dot(hit.normal, up)) < PM_STEEP_COSINE * pm_vec3_length(up))
            return true;
        ray.origin = hit.point;
        ray.from = hit.surface;
        ray.t_max -= hit.t;
    }
    return false;
}

/* A place of some surface, its normal up. */
static bool find_place(const pm_world *world, const double u[3], pm_hit *hit)
{
    pm_ray ray = {pm_world_from_scene(world, (pm_vec3){3.2 * u[0] - 1.1, 2.2 * u[1] - 1.1, .9}),
                  {0, 0, -1},
                  INFINITY,
                  PM_NO_PRIMITIVE};
    for (int skip = (int)(2 * u[2]); pm_world_intersect(world, &ray, hit); skip--) {
        if (hit->normal.z < 0)
            hit->normal = pm_vec3_negate(hit->normal);
        if (!skip)
            return true;
        ray.origin = hit->point;
        ray.from = hit->surface;
    }
    return false;
}

/* Whether a photon of one counts at the other (photon_map.h). */
static bool counts(const pm_hit *a, const pm_hit *b)
{
    pm_vec3 way = pm_vec3_sub(a->point, b->point);
    pm_vec3 mean = pm_vec3_scale(pm_vec3_add(a->normal, b->normal), .5);
    return pm_vec3_dot(a->normal, b->normal) >= .5 &&
           fabs(pm_vec3_dot(mean, way)) <= pm_vec3_length(way) / 4;
}

static void clear_places_see_each_other(void **state)
{
    (void)state;
    const double height = 0x1p-24;
    pm_world *world = world_of(furniture);
    pm_world_info info;
    pm_world_info_get(world, &info);
    pm_rng rng;
    pm_rng_init(&rng, 9, PM_RNG_PATH, 0);
    int clear = 0, hidden = 0, asked = 0, nothing = 0;
    for (int i = 0; i < PLACES; i++) {
        double u[7];
        pm_hit a, b;
        draw(&rng, u, 7);
        double radius = (.02 + .6 * u[6]) / info.scale;
        double near[3] = {u[0] + .2 * (u[3] - .5), u[1] + .2 * (u[4] - .5), u[5]};
        if (!find_place(world, u, &a) || !find_place(world, near, &b) || !counts(&a, &b) ||
            !pm_surface_may_store(world, &a) || !pm_surface_may_store(world, &b) ||
            pm_vec3_distance(a.point, b.point) > radius)
            continue;
        pm_between between;
        pm_world_between(world, a.point, a.normal, radius, a.surface, &between);
        pm_vec3 from = pm_vec3_madd(a.point, height, a.normal);
        pm_vec3 to = pm_vec3_madd(b.point, height, b.normal);
        bool seen = !is_hidden(world, a.surface, from, to, pm_vec3_add(a.normal, b.normal));
        bool is_clear = pm_between_clear(&between, from, to);
        assert_true(seen || !is_clear);
        assert_true(is_clear || !pm_between_nothing(&between));
        nothing += pm_between_nothing(&between);
        clear += is_clear;
        hidden += !seen;
        asked += seen && !is_clear;
    }
    assert_true(hidden > 100 && nothing > clear / 4 && clear > 4 * asked);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clear_places_see_each_other),
        cmocka_unit_test(walls_within_the_radius_are_found),
        cmocka_unit_test(floors_are_no_walls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
