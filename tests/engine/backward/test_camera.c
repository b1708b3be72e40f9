/* Pixel rays: rpict's geometry. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "backward/backward_internal.h"
#include "base/maths.h"

#define SPHERE "void plastic grey 0 0 5 .5 .5 .5 0 0\ngrey sphere s 0 0 4 0 0 0 1\n"

static pm_ray seen(const struct pm_camera *camera, uint32_t pixel, const double u[2])
{
    pm_ray ray;
    assert_true(pm_camera_ray(camera, pixel, u, &ray));
    return ray;
}

static void assert_direction(pm_vec3 a, double x, double y, double z)
{
    double length = sqrt(x * x + y * y + z * z);
    assert_true(fabs(a.x - x / length) < 1e-12);
    assert_true(fabs(a.y - y / length) < 1e-12);
    assert_true(fabs(a.z - z / length) < 1e-12);
}

/* Looking along +y with z up, x is to the right; the image plane at distance 1 reaches to
 * tan(angle / 2). */
static void corners_of_the_picture_lie_at_the_view_angles(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    pm_view view = {.point = {0, -4, 0},
                    .direction = {0, 3, 0},
                    .up = {0, .5, 2},
                    .horizontal = 90,
                    .vertical = 60};
    struct pm_camera camera;
    pm_camera_init(&camera, world, &view, 7, 5);
    double up = pm_tan(PM_PI / 6);
    const double low[2] = {0, 0}, high[2] = {1, 1}, middle[2] = {.5, .5};
    assert_direction(seen(&camera, 0, low).direction, -1, 1, up);
    assert_direction(seen(&camera, 34, high).direction, 1, 1, -up);
    assert_direction(seen(&camera, 17, middle).direction, 0, 1, 0);
    /* pixel (1, 0): between 2/7 and 4/7 of the half from the left edge, linear on the plane */
    assert_direction(seen(&camera, 1, low).direction, -1 + 2.0 / 7, 1, up);
    pm_ray ray = seen(&camera, 3, middle);
    pm_vec3 origin = pm_world_to_scene(world, ray.origin);
    assert_true(origin.x == 0 && origin.y == -4 && origin.z == 0);
    assert_true(ray.from == PM_NO_PRIMITIVE && ray.t_max == INFINITY);
    pm_world_free(world);
}

/* A view of one unit from a million away: world coordinates keep 2^-33 of it. */
static void distant_scenes_are_seen_alike(void **state)
{
    (void)state;
    pm_world *near = world_of(SPHERE);
    pm_world *far = world_of("void plastic grey 0 0 5 .5 .5 .5 0 0\n"
                             "grey sphere s 0 0 4 1048576 1048576 1048576 1\n");
    pm_view view = pm_view_default();
    view.point = (pm_vec3){0, -4, .25};
    struct pm_camera a, b;
    pm_camera_init(&a, near, &view, 4, 4);
    view.point = (pm_vec3){1048576, 1048572, 1048576.25};
    pm_camera_init(&b, far, &view, 4, 4);
    const double u[2] = {.3, .6};
    pm_world_info near_info, far_info;
    pm_world_info_get(near, &near_info);
    pm_world_info_get(far, &far_info);
    for (uint32_t p = 0; p < 16; p++) {
        pm_ray x = seen(&a, p, u), y = seen(&b, p, u);
        pm_hit hit, other;
        assert_true(pm_vec3_distance(x.direction, y.direction) == 0);
        bool met = pm_world_intersect(near, &x, &hit);
        assert_true(met == pm_world_intersect(far, &y, &other));
        if (met)
            assert_true(fabs(hit.t * near_info.scale - other.t * far_info.scale) < 1e-8);
    }
    pm_world_free(near);
    pm_world_free(far);
}

/* ---- the other types: closed forms at the edges and half way to them ---- */

/* The ray at (x, y) of the picture, -1 .. 1, of a view along +y with z up. */
static bool ray_at(const pm_world *world, pm_view view, double x, double y, pm_ray *ray)
{
    struct pm_camera camera;
    view.direction = (pm_vec3){0, 2, 0};
    view.up = (pm_vec3){0, 0, 1};
    pm_camera_init(&camera, world, &view, 1, 1);
    const double u[2] = {(x + 1) / 2, (1 - y) / 2};
    return pm_camera_ray(&camera, 0, u, ray);
}

static void assert_angle(const pm_world *world, pm_view_type type, double size, double x,
                         double angle)
{
    pm_view view = {.type = type, .horizontal = size, .vertical = fmin(size, 170)};
    pm_ray ray;
    assert_true(ray_at(world, view, x, 0, &ray));
    assert_direction(ray.direction, pm_sin(angle), pm_cos(angle), 0);
}

static void fisheyes_and_panoramas_keep_their_projection(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    /* sine of the angle: half of sin 90 is sin 30 */
    assert_angle(world, PM_VIEW_HEMISPHERICAL, 180, .5, PM_PI / 6);
    assert_angle(world, PM_VIEW_HEMISPHERICAL, 60, 1, PM_PI / 6);
    /* the angle itself, all around included */
    assert_angle(world, PM_VIEW_ANGULAR, 180, .5, PM_PI / 4);
    assert_angle(world, PM_VIEW_ANGULAR, 360, .75, .75 * PM_PI);
    assert_angle(world, PM_VIEW_ANGULAR, 360, 1e-12, 1e-12 * PM_PI);
    assert_angle(world, PM_VIEW_CYLINDRICAL, 360, -.5, -PM_PI / 2);
    /* tangent of half the angle: tan(45 degrees) / 2 */
    assert_angle(world, PM_VIEW_STEREOGRAPHIC, 180, .5, 2 * pm_atan(.5));
    pm_world_free(world);
}

/* A cylinder's height is the tangent of the elevation at any azimuth. */
static void panoramas_are_tall_by_the_tangent(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    const pm_view view = {.type = PM_VIEW_CYLINDRICAL, .horizontal = 360, .vertical = 90};
    pm_ray ray;
    assert_true(ray_at(world, view, .5, 1, &ray));
    assert_direction(ray.direction, 1, 0, 1);
    pm_world_free(world);
}

static void parallel_rays_start_side_by_side(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    const pm_view view = {.type = PM_VIEW_PARALLEL,
                          .point = {0, -4, 0},
                          .horizontal = 3,
                          .vertical = 2,
                          .fore = 1,
                          .aft = 3};
    pm_ray ray;
    assert_true(ray_at(world, view, 1, -1, &ray));
    assert_direction(ray.direction, 0, 1, 0);
    pm_vec3 from = pm_world_to_scene(world, ray.origin);
    pm_vec3 end = pm_world_to_scene(world, pm_vec3_madd(ray.origin, ray.t_max, ray.direction));
    assert_true(pm_vec3_distance(from, (pm_vec3){1.5, -3, -1}) < 1e-12);
    assert_true(pm_vec3_distance(end, (pm_vec3){1.5, -1, -1}) < 1e-12);
    pm_world_free(world);
}

/* A perspective view's clipping planes stand upright on its direction, a fisheye's are spheres
 * about the eye. */
static void views_are_clipped_by_planes_and_spheres(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    pm_view view = {.horizontal = 90, .vertical = 90, .fore = 1, .aft = 3};
    pm_ray ray;
    assert_true(ray_at(world, view, 1, 0, &ray));
    pm_vec3 from = pm_world_to_scene(world, ray.origin);
    pm_vec3 end = pm_world_to_scene(world, pm_vec3_madd(ray.origin, ray.t_max, ray.direction));
    assert_true(pm_vec3_distance(from, (pm_vec3){1, 1, 0}) < 1e-12);
    assert_true(pm_vec3_distance(end, (pm_vec3){3, 3, 0}) < 1e-12);
    view.type = PM_VIEW_ANGULAR;
    view.horizontal = 180;
    assert_true(ray_at(world, view, 1, 0, &ray));
    from = pm_world_to_scene(world, ray.origin);
    end = pm_world_to_scene(world, pm_vec3_madd(ray.origin, ray.t_max, ray.direction));
    assert_true(pm_vec3_distance(from, (pm_vec3){1, 0, 0}) < 1e-12);
    assert_true(pm_vec3_distance(end, (pm_vec3){3, 0, 0}) < 1e-12);
    pm_world_free(world);
}

/* One width to the right: its left edge is where the right edge was. */
static void shift_and_lift_move_the_picture(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    const pm_view view = {.horizontal = 90, .vertical = 90, .shift = 1, .lift = -.5};
    pm_ray ray;
    assert_true(ray_at(world, view, -1, 1, &ray));
    assert_direction(ray.direction, 1, 1, 0);
    pm_world_free(world);
}

static void nothing_is_seen_outside_of_a_fisheye(void **state)
{
    (void)state;
    pm_world *world = world_of(SPHERE);
    pm_ray ray;
    const pm_view hemisphere = {
        .type = PM_VIEW_HEMISPHERICAL, .horizontal = 180, .vertical = 180};
    const pm_view all = {.type = PM_VIEW_ANGULAR, .horizontal = 360, .vertical = 360};
    assert_true(ray_at(world, hemisphere, .7, .7, &ray));
    assert_false(ray_at(world, hemisphere, .72, .72, &ray));
    assert_true(ray_at(world, all, .7, -.7, &ray));
    assert_false(ray_at(world, all, .72, -.72, &ray));
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_of_the_picture_lie_at_the_view_angles),
        cmocka_unit_test(distant_scenes_are_seen_alike),
        cmocka_unit_test(fisheyes_and_panoramas_keep_their_projection),
        cmocka_unit_test(panoramas_are_tall_by_the_tangent),
        cmocka_unit_test(parallel_rays_start_side_by_side),
        cmocka_unit_test(views_are_clipped_by_planes_and_spheres),
        cmocka_unit_test(shift_and_lift_move_the_picture),
        cmocka_unit_test(nothing_is_seen_outside_of_a_fisheye),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
