#include "generate_test.h"

static const double rounding = 1e-10;

static void an_even_worm_is_spheres_and_cylinders(void **state)
{
    (void)state;
    struct scene worm = make("genworm m w t 2*t 0 .1 4");
    assert_int_equal(worm.count, 9);
    assert_int_equal(count_type(&worm, "sphere"), 5);
    assert_int_equal(count_type(&worm, "cylinder"), 4);
    const double *v = named(&worm, "w.c2")->reals;
    const double want[] = {.25, .5, 0, .5, 1, 0, .1};
    for (int i = 0; i < 7; i++)
        assert_near(v[i], want[i], rounding);
    free_scene(&worm);
}

/* Where a cone ends it lies on the sphere, and its side is at right angles to the radius. */
static void cones_touch_their_spheres(void **state)
{
    (void)state;
    struct scene worm = make("genworm m w 2*t 0 0 .3-.2*t 2");
    const double *cone = named(&worm, "w.c1")->reals;
    for (int end = 0; end < 2; end++) {
        const double *ball = named(&worm, end ? "w.s1" : "w.s0")->reals;
        double x = cone[end ? 3 : 0] - ball[0], r = cone[end ? 7 : 6];
        assert_near(x * x + r * r, ball[3] * ball[3], rounding);
        assert_near(x * (cone[3] - cone[0]) + r * (cone[7] - cone[6]), 0, rounding);
    }
    free_scene(&worm);
}

static void a_worm_can_end_in_a_point(void **state)
{
    (void)state;
    struct scene worm = make("genworm m w 0 0 t .1*(1-t) 3");
    assert_near(named(&worm, "w.s3")->reals[3], 0, 1e-15);
    free_scene(&worm);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_worm_is_spheres_and_cylinders),
        cmocka_unit_test(cones_touch_their_spheres),
        cmocka_unit_test(a_worm_can_end_in_a_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
