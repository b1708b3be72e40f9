#include "scene_test.h"

#include <math.h>

#include "base/vec3.h"

#define STEEL "void metal steel 0 0 5 .9 .9 .9 1 0\n"

/* Rounding of a handful of products and sums of numbers below 8. */
static const double tiny = 64 * 0x1p-53;

/* The scene that `!xform options part.rad` makes. */
static pm_scene *moved(const char *options, const char *part)
{
    char text[400];
    snprintf(text, sizeof text, STEEL "!xform %s part.rad\n", options);
    return scene_of(text, part);
}

static void assert_center(const char *options, double x, double y, double z)
{
    pm_scene *scene = moved(options, "steel sphere s 0 0 4 1 2 3 1\n");
    const double *reals = scene->primitives[1].reals;
    if (fabs(reals[0] - x) > tiny || fabs(reals[1] - y) > tiny || fabs(reals[2] - z) > tiny)
        fail_msg("xform %s moves 1 2 3 to %g %g %g, not %g %g %g", options, reals[0], reals[1],
                 reals[2], x, y, z);
    pm_scene_free(scene);
}

static void each_transform_moves_a_point_as_its_page_says(void **state)
{
    (void)state;
    double s = sqrt(0.75), c = 0.5;
    assert_center("", 1, 2, 3);
    assert_center("-t 1 -2 .5", 2, 0, 3.5);
    assert_center("-s 2", 2, 4, 6);
    assert_center("-s -2", -2, -4, -6);
    assert_center("-mx", -1, 2, 3);
    assert_center("-my", 1, -2, 3);
    assert_center("-mz", 1, 2, -3);
    /* Counter-clockwise looking down the axis: rz takes x to y, rx y to z, ry z to x. */
    assert_center("-rz 60", c - 2 * s, s + 2 * c, 3);
    assert_center("-rx 60", 1, 2 * c - 3 * s, 2 * s + 3 * c);
    assert_center("-ry 60", c + 3 * s, 2, -s + 3 * c);
}

static void transforms_act_in_the_order_written(void **state)
{
    (void)state;
    assert_center("-t 1 0 0 -rz 90", -2, 2, 3);
    assert_center("-rz 90 -t 1 0 0", -1, 1, 3);
    assert_center("-t 1 0 0 -s 3 -t 0 0 1", 6, 6, 10);
}

static void quarter_turns_are_exact(void **state)
{
    (void)state;
    static const char *const options[] = {
        "-rz 90",        "-rz -270", "-rz 450", "-i 3 -rz -90", "-i 1000000001 -rz 90",
        "-rz 3600000090"};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        pm_scene *scene = moved(options[i], "steel sphere s 0 0 4 1 2 3 1\n");
        ASSERT_REALS(&scene->primitives[1], -2, 1, 3, 1);
        pm_scene_free(scene);
    }
}

static void iterations_repeat_up_to_the_next(void **state)
{
    (void)state;
    assert_center("-t 0 0 1 -i 3 -t 1 0 0 -i 0 -t 50 0 0 -i 2 -t 0 1 0", 4, 4, 4);
}

/* -a 2 by -a 3 with a transform before and one after: names and places as xform(1) makes them.
 */
static void arrays_count_from_zero_the_last_fastest(void **state)
{
    (void)state;
    pm_scene *scene = moved("-n p -t 0 0 1 -a 2 -t 10 0 0 -a 3 -t 0 1 0 -i 1 -t 0 0 5",
                            "steel sphere s 0 0 4 0 0 0 1\n");
    assert_int_equal(scene->count, 7);
    for (int i = 0; i < 6; i++) {
        char name[32];
        snprintf(name, sizeof name, "p.%d.%d.s", i / 3, i % 3);
        assert_string_equal(scene->primitives[i + 1].name, name);
        ASSERT_REALS(&scene->primitives[i + 1], 10 * (i / 3), i % 3, 6, 1);
    }
    pm_scene_free(scene);
    scene = moved("-a 2 -t 1 0 0", "steel sphere s 0 0 4 0 0 0 1\n");
    assert_string_equal(scene->primitives[2].name, "a1.s");
    pm_scene_free(scene);
}

static void radii_scale_and_stay_positive(void **state)
{
    (void)state;
    pm_scene *scene = moved("-s -3", "steel sphere s 0 0 4 0 0 0 2\n"
                                     "steel cone c 0 0 8 0 0 0 0 0 1 2 1\n"
                                     "steel tube t 0 0 7 0 0 0 0 0 1 2\n"
                                     "steel ring r 0 0 8 0 0 1 0 0 4 1 2\n");
    ASSERT_REALS(named(scene, "s"), 0, 0, 0, 6);
    ASSERT_REALS(named(scene, "c"), 0, 0, 0, 0, 0, -3, 6, 3);
    ASSERT_REALS(named(scene, "t"), 0, 0, 0, 0, 0, -3, 6);
    ASSERT_REALS(named(scene, "r"), 0, 0, -3, 0, 0, -4, 3, 6); /* its normal keeps its length */
    assert_int_equal(named(scene, "s")->type, PM_SPHERE);
    assert_int_equal(named(scene, "c")->type, PM_CONE);
    pm_scene_free(scene);
}

/* Twice the vector area of a triangle: its front side. */
static pm_vec3 front(const pm_primitive *p)
{
    const double *v = p->reals;
    pm_vec3 a = {v[0], v[1], v[2]}, b = {v[3], v[4], v[5]}, c = {v[6], v[7], v[8]};
    return pm_vec3_cross(pm_vec3_sub(b, a), pm_vec3_sub(c, a));
}

static void assert_front(const char *options, double x, double y, double z)
{
    /* Faces +z. */
    pm_scene *scene = moved(options, "steel polygon p 0 0 9 0 0 7 1 0 7 0 1 7\n");
    pm_vec3 n = front(&scene->primitives[1]);
    assert_true(n.x == x && n.y == y && n.z == z);
    pm_scene_free(scene);
}

/* What was outside stays outside: a mirrored polygon faces where the mirror shows its front. */
static void mirrors_keep_fronts_in_front(void **state)
{
    (void)state;
    assert_front("", 0, 0, 1);
    assert_front("-mx", 0, 0, 1);
    assert_front("-mz", 0, 0, -1);
    assert_front("-mx -my", 0, 0, 1);
    assert_front("-s -1", 0, 0, -1);
    assert_front("-ry 90", 1, 0, 0);
    assert_front("-mx -ry 90", 1, 0, 0);
}

static void inversion_turns_every_surface(void **state)
{
    (void)state;
    pm_scene *scene = moved("-I", "steel polygon p 0 0 9 0 0 7 1 0 7 0 1 7\n"
                                  "steel sphere a 0 0 4 0 0 0 2\nsteel bubble b 0 0 4 0 0 0 2\n"
                                  "steel cone c 0 0 8 0 0 0 0 0 1 2 1\n"
                                  "steel cup d 0 0 8 0 0 0 0 0 1 2 1\n"
                                  "steel cylinder e 0 0 7 0 0 0 0 0 1 2\n"
                                  "steel tube f 0 0 7 0 0 0 0 0 1 2\n"
                                  "steel ring g 0 0 8 0 0 1 0 0 4 1 2\n");
    static const pm_primitive_type types[] = {PM_POLYGON, PM_BUBBLE, PM_SPHERE,   PM_CUP,
                                              PM_CONE,    PM_TUBE,   PM_CYLINDER, PM_RING};
    for (size_t i = 0; i < 8; i++)
        assert_int_equal(scene->primitives[i + 1].type, types[i]);
    assert_true(front(named(scene, "p")).z == -1);
    ASSERT_REALS(named(scene, "g"), 0, 0, 1, 0, 0, -4, 1, 2);
    pm_scene_free(scene);
    assert_front("-I -mz", 0, 0, 1);
    assert_front("-I -I", 0, 0, 1);
}

static void lights_move_with_the_scene(void **state)
{
    (void)state;
    pm_scene *scene = moved("-rz 90 -s 2 -t 5 5 5",
                            "void light sun 0 0 3 1 2 3\nsun source s 0 0 4 3 0 0 .5\n"
                            "void glow g 0 0 4 1 2 3 7\nvoid glow h 0 0 4 1 2 3 -1\n"
                            "void spotlight b 0 0 7 1 2 3 30 0 3 0\n");
    ASSERT_REALS(named(scene, "s"), 0, 3, 0,
                 .5); /* a direction: turned, neither moved nor scaled */
    ASSERT_REALS(named(scene, "sun"), 1, 2, 3); /* radiance stays */
    ASSERT_REALS(named(scene, "g"), 1, 2, 3, 14);
    ASSERT_REALS(named(scene, "h"), 1, 2, 3, -2);
    ASSERT_REALS(named(scene, "b"), 1, 2, 3, 30, -6, 0, 0); /* the focal length is a length */
    pm_scene_free(scene);
}

/* The optical depth through a body must not depend on its size: with the body k times as long,
 * extinction * length and tau^length stay. pm_pow is good to 1 ulp. */
static void scaling_keeps_the_optical_depth(void **state)
{
    (void)state;
    static const double scales[] = {1e-2, 0.5, 3, 1e3, 1e6};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        char options[40];
        double k = scales[i];
        snprintf(options, sizeof options, "-mx -s %g", k);
        pm_scene *scene = moved(options, "void mist m 0 0 7 .1 .2 4 .5 .6 .7 .8\n"
                                         "void dielectric d 0 0 5 .5 0 1 1.5 8\n");
        const double *m = named(scene, "m")->reals, *d = named(scene, "d")->reals;
        assert_true(fabs(m[0] * k - .1) < 1e-16 && fabs(m[1] * k - .2) < 1e-16);
        assert_true(m[3] == .5 && m[4] == .6 && m[5] == .7 && m[6] == .8);
        /* log(tau') = log(tau) / k, and tau' is off by 2^-52 of itself. */
        assert_true(fabs(log(d[0]) * k - log(.5)) <= 2 * 0x1p-52 * (k + 2));
        assert_true(d[1] == 0 && d[2] == 1 && d[3] == 1.5 && d[4] == 8);
        pm_scene_free(scene);
    }
}

static void reflectances_stay_as_they_are(void **state)
{
    (void)state;
    pm_scene *scene = moved("-rx 30 -s 7 -mx", "void plastic p 0 0 5 .1 .2 .3 .4 .5\n"
                                               "void trans t 0 0 7 .1 .2 .3 .4 .5 .6 .7\n"
                                               "void glass g 0 0 4 .1 .2 .3 1.6\n"
                                               "void mirror m 0 0 3 .1 .2 .3\n");
    ASSERT_REALS(named(scene, "p"), .1, .2, .3, .4, .5);
    ASSERT_REALS(named(scene, "t"), .1, .2, .3, .4, .5, .6, .7);
    ASSERT_REALS(named(scene, "g"), .1, .2, .3, 1.6);
    ASSERT_REALS(named(scene, "m"), .1, .2, .3);
    pm_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_transform_moves_a_point_as_its_page_says),
        cmocka_unit_test(transforms_act_in_the_order_written),
        cmocka_unit_test(quarter_turns_are_exact),
        cmocka_unit_test(iterations_repeat_up_to_the_next),
        cmocka_unit_test(arrays_count_from_zero_the_last_fastest),
        cmocka_unit_test(radii_scale_and_stay_positive),
        cmocka_unit_test(mirrors_keep_fronts_in_front),
        cmocka_unit_test(inversion_turns_every_surface),
        cmocka_unit_test(lights_move_with_the_scene),
        cmocka_unit_test(scaling_keeps_the_optical_depth),
        cmocka_unit_test(reflectances_stay_as_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
