#include "generate_test.h"

static const double rounding = 1e-10;

#define ELL "genprism m p 6 0 0 2 0 2 1 1 1 1 2 0 2"

/* Clockwise seen from above is outward for an extrusion up, so this outline faces inward. */
static void a_prism_is_closed(void **state)
{
    (void)state;
    struct scene up = make(ELL " -l 0 0 2.5"), down = make(ELL " -l .3 .2 -2.5");
    assert_int_equal(up.count, 2 + 6);
    assert_near(enclosed_volume(&up), -3 * 2.5, rounding);
    assert_near(enclosed_volume(&down), 3 * 2.5, rounding);
    free_scene(&up);
    free_scene(&down);
}

static void ends_and_the_last_side_can_be_left_out(void **state)
{
    (void)state;
    struct scene tube = make(ELL " -e"), open = make(ELL " -c");
    assert_int_equal(tube.count, 6);
    assert_int_equal(open.count, 2 + 5);
    assert_string_equal(tube.items[0].name, "p.1");
    assert_string_equal(open.items[0].name, "p.b");
    free_scene(&tube);
    free_scene(&open);
}

/* A rounded square prism is the rounded box of these sizes: faces in the planes of the square,
 * centres a radius inside them. */
static void rounding_stays_within_the_outline(void **state)
{
    (void)state;
    struct scene p = make("genprism m p 4 0 0 0 2 2 2 2 0 -l 0 0 3 -r .1");
    assert_int_equal(count_type(&p, "polygon"), 6);
    assert_int_equal(count_type(&p, "sphere"), 8);
    assert_int_equal(count_type(&p, "cylinder"), 12);
    static const double most[] = {2, 2, 3};
    for (size_t i = 0; i < p.count; i++) {
        const struct made *s = &p.items[i];
        bool flat = strcmp(s->type, "polygon") == 0;
        if (!flat)
            assert_near(s->reals[s->real_count - 1], .1, rounding);
        for (size_t k = 0; k + !flat < s->real_count; k++) {
            double x = s->reals[k], inset = fmin(x, most[k % 3] - x);
            if (!flat || inset > .05)
                assert_near(inset, .1, rounding);
            else
                assert_near(inset, 0, rounding);
        }
    }
    free_scene(&p);
}

static pm_generate_file three_corners(void *context, const char *name)
{
    static const char text[] = "0 0\n\t2 0\n 0 3 \n";
    (void)context;
    return strcmp(name, "corners") == 0 ? (pm_generate_file){text, sizeof text - 1}
                                        : (pm_generate_file){0};
}

static void vertices_come_from_a_file(void **state)
{
    (void)state;
    struct command command;
    pm_generate_request request = request_of("genprism m p corners -l 0 0 -2", &command);
    request.find = three_corners;
    struct scene p = make_with(&request);
    assert_int_equal(p.count, 5);
    assert_near(enclosed_volume(&p), 3 * 2, rounding);
    free_scene(&p);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    assert_refused("genprism m p 3 0 0 1 0 1", PM_E_SYNTAX, 8,
                   "genprism: a vertex's y is missing; it should come after '1'");
    assert_refused("genprism m p 4 0 0 1 0 .5 0 0 1 -r .1", PM_E_RANGE, 3,
                   "genprism: the sides at vertex 2 lie upon each other, and -r cannot round "
                   "there");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_prism_is_closed),
        cmocka_unit_test(ends_and_the_last_side_can_be_left_out),
        cmocka_unit_test(rounding_stays_within_the_outline),
        cmocka_unit_test(vertices_come_from_a_file),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
