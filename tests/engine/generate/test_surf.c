#include "generate_test.h"

static const double rounding = 1e-10;

static void a_plane_is_one_quadrilateral_a_patch(void **state)
{
    (void)state;
    struct scene plane = make("gensurf m p 2*s 3*t 1+s 4 5");
    double area[3], sum[3] = {0};
    assert_int_equal(plane.count, 20);
    for (size_t i = 0; i < plane.count; i++) {
        polygon_area(&plane.items[i], area);
        for (int k = 0; k < 3; k++)
            sum[k] += area[k];
    }
    assert_near(sum[0], -3, rounding); /* ds x dt = (2,0,1) x (0,3,0) */
    assert_near(sum[1], 0, rounding);
    assert_near(sum[2], 6, rounding);
    assert_string_equal(plane.items[19].name, "p.20");
    free_scene(&plane);
}

static void a_curved_patch_is_two_triangles(void **state)
{
    (void)state;
    struct scene saddle = make("gensurf m p s t s*t 4 5");
    assert_int_equal(saddle.count, 40);
    assert_int_equal(saddle.items[0].real_count, 9);
    free_scene(&saddle);
}

#define BALL "gensurf m p cos(2*PI*s)*sin(PI*t) sin(2*PI*s)*sin(PI*t) -cos(PI*t) "

static void a_ball_is_closed(void **state)
{
    (void)state;
    struct scene ball = make(BALL "60 30");
    double volume = 4 * PM_PI / 3;
    assert_true(enclosed_volume(&ball) < volume);
    assert_true(enclosed_volume(&ball) > volume * (1 - pow(PM_PI / 30, 2)));
    free_scene(&ball);
}

/* surf.cal's coefficients and the face's normal give the ball's normal at the corners: central
 * differences are exact in direction but for the poles. */
static void smooth_patches_have_the_normals_of_the_surface(void **state)
{
    (void)state;
    struct scene ball = make(BALL "60 30 -s");
    size_t checked = 0;
    for (size_t i = 0; i < ball.count; i++) {
        const struct made *texture = &ball.items[i], *face = texture + 1;
        if (strcmp(texture->type, "texfunc") != 0 || fabs(face->reals[2]) > .9)
            continue;
        int axis = (int)texture->reals[0];
        double plain[3], size;
        polygon_area(face, plain);
        size = length(plain);
        for (size_t k = 0; k < face->real_count; k += 3) {
            const double *p = face->reals + k, *a = texture->reals + 1;
            double u = p[(axis + 1) % 3], v = p[(axis + 2) % 3];
            for (int j = 0; j < 3; j++)
                assert_near(a[j] * u * v + a[3 + j] * u + a[6 + j] * v + a[9 + j] +
                                plain[j] / size,
                            p[j], 1e-4);
            checked++;
        }
    }
    assert_in_range(checked, 4000, 6000);
    free_scene(&ball);
}

static void points_that_are_not_valid_are_left_out(void **state)
{
    (void)state;
    struct scene ring = make("gensurf m p s t 0 40 40 -e 'valid(s,t)=(s-.5)^2+(t-.5)^2-.09;'");
    double area = total_area(&ring), cells = 2 * PM_PI * .3 / 40;
    assert_near(area, 1 - PM_PI * .09, 2 * cells);
    free_scene(&ring);
}

/* s varies fastest. */
static pm_generate_file heights(void *context, const char *name)
{
    static const char text[] = "0 1 4\n2 3 9\n";
    (void)context;
    return strcmp(name, "heights") == 0 ? (pm_generate_file){text, sizeof text - 1}
                                        : (pm_generate_file){0};
}

static void recorded_heights_are_met(void **state)
{
    (void)state;
    struct command command;
    pm_generate_request request = request_of("gensurf m p s t heights 2 1", &command);
    request.find = heights;
    struct scene surface = make_with(&request);
    for (size_t i = 0; i < surface.count; i++)
        for (size_t k = 0; k < surface.items[i].real_count; k += 3) {
            static const double z[2][3] = {{0, 1, 4}, {2, 3, 9}};
            const double *p = surface.items[i].reals + k;
            assert_near(p[2], z[(int)p[1]][(int)(2 * p[0])], rounding);
        }
    free_scene(&surface);
}

/* Hermite, Bezier and uniform B-spline curves end and bend where they should. */
static void the_generators_have_their_curves(void **state)
{
    (void)state;
    struct scene curves = make("gensurf m p hermite(1,5,2,3,s) bezier(1,7,8,5,s) "
                               "bspline(0,6,12,6,s)+t 1 1");
    const double *first = curves.items[0].reals;
    double ends[2][3];
    for (int k = 0; k < 12; k += 3)
        if (fabs(first[k + 2] - fmod(first[k + 2], 1)) < 100 && first[k] < 1 + rounding)
            memcpy(ends[0], first + k, sizeof ends[0]);
        else
            memcpy(ends[1], first + k, sizeof ends[1]);
    assert_near(ends[0][0], 1, rounding);
    assert_near(ends[0][1], 1, rounding);
    assert_near(ends[1][0], 5, rounding);
    assert_near(ends[1][1], 5, rounding);
    free_scene(&curves);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    assert_refused(
        "gensurf m p s t height(s,t) 3 3", PM_E_MISSING, 5,
        "gensurf: there is no function height; define it in this file or in one that "
        "is read before");
    assert_refused("gensurf m p s t 0 3 -1", PM_E_RANGE, 7,
                   "gensurf: '-1' is no number of patches; write a whole number above 0");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plane_is_one_quadrilateral_a_patch),
        cmocka_unit_test(a_curved_patch_is_two_triangles),
        cmocka_unit_test(a_ball_is_closed),
        cmocka_unit_test(smooth_patches_have_the_normals_of_the_surface),
        cmocka_unit_test(points_that_are_not_valid_are_left_out),
        cmocka_unit_test(recorded_heights_are_met),
        cmocka_unit_test(the_generators_have_their_curves),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
