#include "generate_test.h"

static const double rounding = 1e-10;

static void flat_slats_stand_at_their_angle(void **state)
{
    (void)state;
    struct scene b = make("genblinds m s .1 1.5 2 4 30");
    assert_int_equal(b.count, 4);
    for (size_t i = 0; i < 4; i++) {
        const double *v = b.items[i].reals;
        double height = 2 * ((double)i + .5) / 4;
        const double want[] = {0,
                               0,
                               height,
                               0,
                               1.5,
                               height,
                               .1 * cos(PM_PI / 6),
                               1.5,
                               height + .05,
                               .1 * cos(PM_PI / 6),
                               0,
                               height + .05};
        for (int k = 0; k < 12; k++)
            assert_near(v[k], want[k], rounding);
    }
    assert_string_equal(b.items[3].name, "s.4.0");
    free_scene(&b);
}

/* Curved slats: facets that join, on an arc of that radius whose chord is the depth, at that
 * angle, each below 3 degrees. */
static void assert_arc(const char *command, double radius, double angle)
{
    struct scene b = make(command);
    double theta = 2 * asin(.1 / (2 * radius)), most = 3 * PM_PI / 180;
    size_t facets = (size_t)ceil(theta / most);
    assert_int_equal(b.count, 2 * facets);
    for (size_t k = 1; k < facets; k++)
        for (int i = 0; i < 3; i++)
            assert_near(b.items[k].reals[i], b.items[k - 1].reals[9 + i], rounding);
    const double *first = b.items[0].reals, *last = b.items[facets - 1].reals + 9;
    double dx = last[0] - first[0], dz = last[2] - first[2];
    assert_near(sqrt(dx * dx + dz * dz), .1, rounding);
    assert_near(atan2(dz, dx), angle, 1e-8);
    for (size_t k = 0; k < facets; k++) {
        double area[3];
        polygon_area(&b.items[k], area);
        assert_near(length(area), 2 * radius * sin(theta / (double)facets / 2), rounding);
    }
    free_scene(&b);
}

static void curved_slats_are_arcs(void **state)
{
    (void)state;
    assert_arc("genblinds m s .1 1 2 2 30 -r .3", .3, PM_PI / 6);
    assert_arc("genblinds m s .1 1 2 2 30 +r .3", .3, PM_PI / 6);
    assert_arc("genblinds m s .1 1 2 2 -45 +r .07", .07, -PM_PI / 4);
}

/* -r bends the middle below the chord, +r above it. */
static void the_sign_says_which_way_slats_bend(void **state)
{
    (void)state;
    struct scene down = make("genblinds m s .1 1 2 1 0 -r .3");
    struct scene up = make("genblinds m s .1 1 2 1 0 +r .3");
    assert_true(down.items[3].reals[2] < 1 && up.items[3].reals[2] > 1);
    free_scene(&down);
    free_scene(&up);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flat_slats_stand_at_their_angle),
        cmocka_unit_test(curved_slats_are_arcs),
        cmocka_unit_test(the_sign_says_which_way_slats_bend),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
