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
    assert_direction(pm_camera_ray(&camera, 0, low).direction, -1, 1, up);
    assert_direction(pm_camera_ray(&camera, 34, high).direction, 1, 1, -up);
    assert_direction(pm_camera_ray(&camera, 17, middle).direction, 0, 1, 0);
    /* pixel (1, 0): between 2/7 and 4/7 of the half from the left edge, linear on the plane */
    assert_direction(pm_camera_ray(&camera, 1, low).direction, -1 + 2.0 / 7, 1, up);
    pm_ray ray = pm_camera_ray(&camera, 3, middle);
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
        pm_ray x = pm_camera_ray(&a, p, u), y = pm_camera_ray(&b, p, u);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_of_the_picture_lie_at_the_view_angles),
        cmocka_unit_test(distant_scenes_are_seen_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
