#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "compile.h"
#include "numbers.h"
#include "world/material.h"
#include "world/twins.h"

#define GREY "void plastic grey 0 0 5 .5 .5 .5 0 0\n"

static size_t group_count(const char *text)
{
    pm_world *world = world_of(text);
    size_t count = 0;
    for (uint32_t i = 0; i < world->shape_count; i++) {
        const struct pm_shape *s = &world->shapes[i], *first = &world->shapes[s->group];
        count += s->group == i;
        assert_int_equal(first->group, s->group);
        if (pm_shape_is_planar(s)) {
            double sign = s->flipped ? -1 : 1;
            assert_true(s->offset == sign * first->offset &&
                        s->axis.x == sign * first->axis.x &&
                        s->axis.y == sign * first->axis.y && s->axis.z == sign * first->axis.z);
        }
    }
    pm_world_free(world);
    return count;
}

/* Points of the plane 3 x + 4 y + 5 z = 6. */
static void add_in_plane(struct text *t, pm_rng *rng, double size)
{
    double x = 10 * pm_rng_uniform(rng), y = 10 * pm_rng_uniform(rng);
    add(t, "grey polygon p 0 0 9");
    for (int i = 0; i < 3; i++) {
        double u = x + size * cos(2. * i), v = y + size * sin(2. * i);
        add(t, " %.17g %.17g %.17g", u, v, (6 - 3 * u - 4 * v) / 5);
    }
    add(t, "\n");
}

static void what_lies_in_one_plane_is_one_group(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    struct text t = {0};
    add(&t,
        GREY "grey ring r 0 0 8 2 0 0 3 4 5 1 2\ngrey ring s 0 0 8 0 0 1.2 -6 -8 -10 1 2\n");
    for (int i = 0; i < 300; i++)
        add_in_plane(&t, &rng, pow(10, -3 * pm_rng_uniform(&rng)));
    assert_int_equal(group_count(t.data), 1);
    free(t.data);
}

static void what_lies_a_billionth_apart_is_not(void **state)
{
    (void)state;
    assert_int_equal(group_count(GREY "grey polygon a 0 0 9 0 0 0 1 0 0 0 1 0\n"
                                      "grey polygon b 0 0 9 0 0 1e-9 1 0 1e-9 0 1 1e-9\n"
                                      "grey polygon c 0 0 9 0 0 0 1 0 0 0 1 1e-9\n"
                                      "grey ring d 0 0 8 0 0 0 0 1e-9 1 0 1\n"),
                     4);
}

/* Room walls meet at edges and are no twins; a polygon that is not planar has none. */
static void other_surfaces_stay_alone(void **state)
{
    (void)state;
    assert_int_equal(group_count(GREY TEST_BOX("grey")), 6);
    assert_int_equal(group_count(GREY "grey polygon a 0 0 12 0 0 0 1 0 0 1 1 .1 0 1 0\n"
                                      "grey polygon b 0 0 12 0 0 0 1 0 0 1 1 .1 0 1 0\n"),
                     2);
}

static void curved_surfaces_with_equal_numbers_are_one_group(void **state)
{
    (void)state;
    assert_int_equal(group_count(GREY "grey sphere a 0 0 4 .1 .2 .3 .4\n"
                                      "grey bubble b 0 0 4 .1 .2 .3 .4\n"
                                      "grey sphere c 0 0 4 .1 .2 .3 .41\n"
                                      "grey cylinder d 0 0 7 .1 .2 .3 .4 .5 .6 .7\n"
                                      "grey tube e 0 0 7 .4 .5 .6 .1 .2 .3 .7\n"
                                      "grey cone f 0 0 8 .1 .2 .3 .4 .5 .6 .7 .7\n"
                                      "grey cone g 0 0 8 .1 .2 .3 .4 .5 .6 .7 .8\n"
                                      "grey cup h 0 0 8 .4 .5 .6 .1 .2 .3 .8 .7\n"
                                      "grey cup i 0 0 8 .4 .5 .6 .1 .2 .3 .7 .8\n"),
                     5);
}

/* Names of shapes and numbers of lamps differ, so does the order of digests. */
static void a_lamp_in_the_plane_of_a_ceiling_shines(void **state)
{
    (void)state;
    for (int power = 1; power <= 16; power++) {
        struct text t = {0};
        add(&t,
            GREY TEST_BOX("grey") "void light m 0 0 3 %d 1 1\n"
                                  "m polygon lamp 0 0 12 -.3 -.3 1 -.3 .3 1 .3 .3 1 .3 -.3 1\n"
                                  "void illum i 0 0 3 1 1 1\n"
                                  "i polygon a 0 0 12 -.3 -.3 1 -.3 .3 1 .3 .3 1 .3 -.3 1\n"
                                  "i polygon b 0 0 12 .5 .5 1 .5 .8 1 .8 .8 1 .8 .5 1\n",
            power);
        pm_world *world = world_of(t.data);
        pm_ray up = {.direction = {0, 0, 1}, .t_max = INFINITY, .from = PM_NO_PRIMITIVE};
        pm_hit hit;
        assert_true(pm_world_intersect(world, &up, &hit));
        assert_int_equal(world->materials[hit.material].type, PM_LIGHT);
        up.origin = pm_world_from_scene(world, (pm_vec3){.65, .65, 0});
        assert_true(pm_world_intersect(world, &up, &hit));
        assert_int_equal(world->materials[hit.material].type, PM_ILLUM);
        pm_world_free(world);
        free(t.data);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_lies_in_one_plane_is_one_group),
        cmocka_unit_test(what_lies_a_billionth_apart_is_not),
        cmocka_unit_test(other_surfaces_stay_alone),
        cmocka_unit_test(curved_surfaces_with_equal_numbers_are_one_group),
        cmocka_unit_test(a_lamp_in_the_plane_of_a_ceiling_shines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
