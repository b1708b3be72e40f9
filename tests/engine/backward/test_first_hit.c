/* What sensors' rays meet first, against geometry on paper; the same numbers came from rtrace
 * -oLpnN. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "backward/first_hit.h"

/* The texture adds (.1, 0, 0) to the floor's normal, so that it is (.1, 0, 1) / sqrt(1.01). */
static const char scene[] = "void texfunc lean 4 .1 0 0 . 0 0\n"
                            "lean plastic wood 0 0 5 .5 .4 .3 0 0\n"
                            "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
                            "wood polygon floor 0 0 12 -5 -5 0 5 -5 0 5 5 0 -5 5 0\n"
                            "grey sphere ball 0 0 4 1 1 2 1\n";

static void assert_near(pm_vec3 a, double x, double y, double z)
{
    assert_true(pm_vec3_distance(a, pm_vec3_make(x, y, z)) < 1e-12);
}

static pm_first_hit hit_of(const pm_world *world, pm_vec3 point, pm_vec3 direction)
{
    const pm_sensor sensor = {point, direction};
    return pm_sensor_first_hit(world, &sensor, PM_RADIANCE);
}

static void rays_meet_what_is_in_front(void **state)
{
    (void)state;
    pm_world *world = world_of(scene);
    pm_first_hit hit = hit_of(world, (pm_vec3){1, 1, 5}, (pm_vec3){0, 0, -4});
    assert_true(hit.met && fabs(hit.distance - 2) < 1e-12);
    assert_near(hit.point, 1, 1, 3);
    assert_near(hit.normal, 0, 0, 1);
    hit = hit_of(world, (pm_vec3){-2, 0, 3}, (pm_vec3){0, 0, -1});
    assert_true(fabs(hit.distance - 3) < 1e-12);
    assert_near(hit.geometric_normal, 0, 0, 1);
    assert_near(hit.normal, .1 / sqrt(1.01), 0, 1 / sqrt(1.01));
    pm_world_free(world);
}

/* From below the floor both normals look down. */
static void normals_face_the_ray(void **state)
{
    (void)state;
    pm_world *world = world_of(scene);
    pm_first_hit hit = hit_of(world, (pm_vec3){-2, 0, -3}, (pm_vec3){0, 0, 1});
    assert_near(hit.geometric_normal, 0, 0, -1);
    assert_true(hit.normal.z < -.9);
    pm_world_free(world);
}

static void rays_that_leave_meet_nothing(void **state)
{
    (void)state;
    pm_world *world = world_of(scene);
    pm_first_hit hit = hit_of(world, (pm_vec3){0, -3, 1}, (pm_vec3){0, 0, 1});
    assert_true(!hit.met && isinf(hit.distance) && hit.surface == PM_NO_PRIMITIVE);
    assert_near(hit.point, 0, -3, 1);
    pm_world_free(world);
}

static void irradiance_sensors_are_met_themselves(void **state)
{
    (void)state;
    pm_world *world = world_of(scene);
    const pm_sensor sensor = {{1, 2, 3}, {0, 0, 2}};
    pm_first_hit hit = pm_sensor_first_hit(world, &sensor, PM_IRRADIANCE);
    assert_true(hit.met && hit.distance == 0);
    assert_near(hit.point, 1, 2, 3);
    assert_near(hit.normal, 0, 0, 1);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_meet_what_is_in_front),
        cmocka_unit_test(normals_face_the_ray),
        cmocka_unit_test(rays_that_leave_meet_nothing),
        cmocka_unit_test(irradiance_sensors_are_met_themselves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
