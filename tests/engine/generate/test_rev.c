#include "generate_test.h"

static const double rounding = 1e-10;

static void each_kind_of_segment_is_made_of_its_surface(void **state)
{
    (void)state;
    struct scene up = make("genrev m r t .5 2"), down = make("genrev m r 1-t .5 2");
    struct scene out = make("genrev m r 2 t+1 1"), in = make("genrev m r 2 2-t 1");
    struct scene wide = make("genrev m r t t+1 1"), narrow = make("genrev m r 1-t t+1 1");
    assert_string_equal(up.items[1].type, "cylinder");
    assert_string_equal(up.items[1].name, "r.2");
    assert_string_equal(down.items[0].type, "tube");
    assert_string_equal(out.items[0].type, "ring");
    assert_near(out.items[0].reals[5], -1, 0);
    assert_near(in.items[0].reals[5], 1, 0);
    assert_string_equal(wide.items[0].type, "cone");
    assert_string_equal(narrow.items[0].type, "cup");
    struct scene *all[] = {&up, &down, &out, &in, &wide, &narrow};
    for (int i = 0; i < 6; i++)
        free_scene(all[i]);
}

static double cone_area(const struct made *cone)
{
    const double *r = cone->reals;
    double rise = r[5] - r[2], step = r[7] - r[6];
    return PM_PI * (r[6] + r[7]) * sqrt(rise * rise + step * step);
}

/* Inscribed cones: the area of a ball within (pi / segments)^2. */
static void a_half_circle_makes_a_ball(void **state)
{
    (void)state;
    struct scene ball = make("genrev m r -cos(PI*t) sin(PI*t) 40");
    double area = 0;
    for (size_t i = 0; i < ball.count; i++)
        area += cone_area(&ball.items[i]);
    assert_int_equal(ball.count, 40);
    assert_true(area < 4 * PM_PI && area > 4 * PM_PI * (1 - pow(PM_PI / 40, 2)));
    free_scene(&ball);
}

/* The lines of rev.cal: at the middle of a segment of a ball, the normal points away from the
 * centre. */
static void smooth_segments_have_the_normals_of_the_profile(void **state)
{
    (void)state;
    struct scene ball = make("genrev m r -cos(PI*t) sin(PI*t) 40 -s");
    assert_int_equal(ball.count, 80);
    for (size_t i = 2; i + 3 < ball.count; i += 2) {
        const double *a = ball.items[i].reals, *cone = ball.items[i + 1].reals;
        double z = (cone[2] + cone[5]) / 2, r = (cone[6] + cone[7]) / 2;
        assert_string_equal(ball.items[i].type, "texfunc");
        assert_string_equal(ball.items[i + 1].modifier, "Phong");
        double nz = a[0] * z + a[1], nr = a[2] * r + a[3];
        assert_near(atan2(nz, nr), atan2(z, r), 0.01);
    }
    free_scene(&ball);
}

static void definitions_come_before(void **state)
{
    (void)state;
    struct scene r = make("genrev m r z(t) R 3 -e 'z(x)=2*x*k;k:3;' -e R=1.5");
    assert_near(r.items[2].reals[5], 6, rounding);
    assert_near(r.items[2].reals[6], 1.5, rounding);
    free_scene(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_of_segment_is_made_of_its_surface),
        cmocka_unit_test(a_half_circle_makes_a_ball),
        cmocka_unit_test(smooth_segments_have_the_normals_of_the_profile),
        cmocka_unit_test(definitions_come_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
