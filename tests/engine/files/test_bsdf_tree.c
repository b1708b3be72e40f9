#include "bsdf_test.h"

#include <malloc.h>

/* ---- shapes of trees ---- */

static double stripes(void *context, const double *centre)
{
    (void)context;
    double sum = 0;
    for (int d = 0; d < 3; d++)
        sum += (d + 1) * floor(centre[d] * 8);
    return fmod(sum, 7) * .02 + .005;
}

/* Coarse but near the corner where all coordinates are small. */
static bool corner_splits(void *context, const double *centre, double edge)
{
    (void)context;
    return centre[0] < .5 + edge / 4 || edge > .6;
}

static double constant(void *context, const double *centre)
{
    (void)centre;
    return *(double *)context;
}

/* A ridge along the diagonal: light goes mostly straight on. */
static double ridge(void *context, const double *centre)
{
    (void)context;
    double dx = centre[0] - centre[2], dy = centre[1] - centre[3];
    return fabs(dx) + fabs(dy) < 1e-9 ? 30 : centre[2] > .5 ? .02 : 0;
}

static bool ridge_splits(void *context, const double *centre, double edge)
{
    (void)context;
    return fabs(centre[0] - centre[2]) < edge / 2 && fabs(centre[1] - centre[3]) < edge / 2;
}

/* Isotropic: bright about one angle, no Lambertian part. */
static double spot(void *context, const double *centre)
{
    (void)context;
    double dx = centre[1] - .75, dy = centre[2] - .35;
    return dx * dx + dy * dy < .0625 ? .6 + .4 * centre[0] : 0;
}

static bool spot_splits(void *context, const double *centre, double edge)
{
    (void)context;
    double dx = centre[1] - .75, dy = centre[2] - .35;
    return sqrt(dx * dx + dy * dy) < sqrt(.0625) + edge;
}

static const struct tree_shape rank3 = {3, 3, stripes, corner_splits, NULL};
static const struct tree_shape rank4 = {4, 3, stripes, corner_splits, NULL};
static const struct tree_shape ridge4 = {4, 4, ridge, ridge_splits, NULL};
static const struct tree_shape spot3 = {3, 4, spot, spot_splits, NULL};

static pm_bsdf *tree_file(const char *direction, const char *second,
                          const struct tree_shape *shape)
{
    pm_bytes b = {0};
    begin_file(&b, shape->rank == 3 ? "TensorTree3" : "TensorTree4", "");
    put_tree(&b, "Visible", direction, shape);
    if (second)
        put_tree(&b, "Visible", second, shape);
    end_file(&b);
    return read_file(&b);
}

/* ---- values ---- */

static void constant_tree_is_lambertian(void **state)
{
    (void)state;
    for (int rank = 3; rank <= 4; rank++) {
        double value = .5 / PM_PI;
        const struct tree_shape shape = {rank, rank - 3, constant, NULL, &value};
        pm_bsdf *bsdf = tree_file("Transmission Front", NULL, &shape);
        pm_vec3 in = {.6, 0, .8};
        assert_grey(pm_bsdf_diffuse_transmittance(bsdf, in), .5, 1e-6);
        assert_grey(pm_bsdf_diffuse_transmittance(bsdf, pm_vec3_negate(in)), .5, 1e-6);
        assert_grey(pm_bsdf_diffuse_reflectance(bsdf, in), 0, 0);
        pm_bsdf_info info;
        pm_bsdf_info_get(bsdf, &info);
        assert_true(info.is_tree && info.transmits && !info.reflects);
        assert_false(info.rest_transmits[0] || info.rest_transmits[1]);
        pm_bsdf_free(bsdf);
    }
}

/* One grid of 2^4: dimension 0 counts eight, dimension 3 one. The first two are the direction
 * that light goes to before the surface, (x, y) of its square. */
static void places_of_a_grid(void **state)
{
    (void)state;
    pm_bytes b = {0};
    begin_file(&b, "TensorTree4", "");
    begin_block(&b, "Visible", "Reflection Back");
    pm_bytes_text(&b, "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis><ScatteringData>{");
    for (int i = 0; i < 16; i++)
        pm_bytes_format(&b, "%g ", .01 * i);
    pm_bytes_text(&b, "}");
    end_block(&b);
    end_file(&b);
    pm_bsdf *bsdf = read_file(&b);
    for (int i = 0; i < 16; i++) {
        double sign[4];
        for (int d = 0; d < 4; d++)
            sign[d] = i >> (3 - d) & 1 ? .5 : -.5;
        pm_vec3 in = {-sign[0], -sign[1], sqrt(.5)}, out = {sign[2], sign[3], sqrt(.5)};
        assert_grey(pm_bsdf_value(bsdf, in, out), .01 * i, 1e-8);
    }
    pm_bsdf_free(bsdf);
}

static void isotropic_values_turn_along(void **state)
{
    (void)state;
    pm_bsdf *bsdf = tree_file("Transmission Back", "Reflection Back", &spot3);
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    int some = 0;
    for (int i = 0; i < 20000; i++) {
        double u[5];
        draw(&rng, u, 5);
        pm_vec3 in = pm_warp_cosine(u[0], u[1]), out = pm_warp_cosine(u[2], u[3]);
        out.z *= i & 1 ? 1 : -1;
        double c = cos(6 * u[4]), s = sin(6 * u[4]);
        double value = pm_bsdf_value(bsdf, in, out).r;
        some += value > 0;
        in = (pm_vec3){c * in.x - s * in.y, s * in.x + c * in.y, in.z};
        out = (pm_vec3){c * out.x - s * out.y, s * out.x + c * out.y, out.z};
        assert_near(pm_bsdf_value(bsdf, in, out).r, value, 1e-12);
    }
    assert_true(some > 500);
    pm_bsdf_free(bsdf);
}

static void transmission_from_one_side_is_reciprocal(void **state)
{
    (void)state;
    const struct tree_shape *shapes[3] = {&rank3, &spot3, &rank4};
    for (int i = 0; i < 3; i++) {
        pm_bsdf *bsdf = tree_file("Transmission Front", NULL, shapes[i]);
        pm_rng rng;
        pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
        for (int k = 0; k < 2000; k++) {
            double u[4];
            draw(&rng, u, 4);
            pm_vec3 a = pm_warp_cosine(u[0], u[1]), c = pm_warp_cosine(u[2], u[3]);
            c.z = -c.z;
            assert_near(pm_bsdf_value(bsdf, a, c).r, pm_bsdf_value(bsdf, c, a).r, 0);
        }
        pm_bsdf_free(bsdf);
    }
}

static const struct answer tree3_answers[] = {
    {{-0.8, -0.9, -0.3}, {-0.7, 0.8, -0.4}, 0.000000e+00},
    {{-0, 0.7, -0.2}, {0.3, -0.1, 0.7}, 4.500000e-02},
    {{0.7, -0.5, -0.3}, {0.8, -0.7, 0.6}, 1.050000e-01},
    {{-0.4, 0.1, -0.9}, {0.5, 0.7, 0.7}, 1.050000e-01},
    {{0.9, 0.8, -0.5}, {-0.4, -0.5, 0.4}, 1.050000e-01},
    {{1, -0.2, 0.2}, {0, -0.9, -0.4}, 1.250000e-01},
    {{-1, 0.4, 0.5}, {-0.2, 0.4, -0.4}, 2.500000e-02},
    {{0.4, 0.1, 1}, {-0.3, -1, -0.2}, 4.500000e-02},
    {{-0.6, -0.4, 0.6}, {-0.6, -1, -0.8}, 2.500000e-02},
    {{-0, 0.6, 0.2}, {-0, 0.9, 0.5}, 1.050000e-01},
    {{-0.2, -1, 0.6}, {0.1, 1, 0.5}, 4.500000e-02},
    {{0.7, -0.6, 0.4}, {-0.8, 0.4, 0.3}, 1.250000e-01},
    {{-0.8, -0.6, 0.3}, {-0, -0.6, 0.2}, 5.000000e-03},
};

static const struct answer tree4_answers[] = {
    {{0.4, 0.3, -1}, {-0.8, -0.9, -0.3}, 2.500000e-02},
    {{0.6, 0.6, -0.4}, {0.6, 0.5, -0.6}, 4.500000e-02},
    {{-0, 0.7, -0.8}, {0.6, 0.7, -0.7}, 1.250000e-01},
    {{-0.4, -0.3, -0.4}, {-0.4, 0.1, -0.2}, 4.500000e-02},
    {{-0.5, -0.2, -0.3}, {0.4, 0, 0.5}, 4.500000e-02},
    {{0.8, -0.1, -0.5}, {-0.1, 0.7, 0.3}, 5.000000e-03},
    {{-0.9, 0.3, -0.9}, {0.9, -0.8, 0.9}, 2.500000e-02},
    {{-0.4, 0.1, -0.7}, {0.3, 0.8, 0.7}, 1.050000e-01},
    {{1, 0.1, 0.4}, {-0.6, 0.2, -0.5}, 1.250000e-01},
    {{0.8, -0.7, 0.8}, {-0.7, 0.6, -0.4}, 1.050000e-01},
    {{-1, 1, 0.3}, {-0.3, -0.9, -0.6}, 4.500000e-02},
    {{-0, -0.2, 0.6}, {-0.4, -0.5, -0.6}, 6.500000e-02},
    {{-0.1, -0.3, 0.8}, {-0.1, -0.2, 0.4}, 0.000000e+00},
};

static void values_are_those_of_radiance(void **state)
{
    (void)state;
    pm_bsdf *bsdf = tree_file("Transmission Front", "Reflection Back", &rank3);
    check_answers(bsdf, tree3_answers, sizeof tree3_answers / sizeof tree3_answers[0]);
    pm_bsdf_free(bsdf);
    bsdf = tree_file("Transmission Back", "Reflection Front", &rank4);
    check_answers(bsdf, tree4_answers, sizeof tree4_answers / sizeof tree4_answers[0]);
    pm_bsdf_free(bsdf);
}

/* u' = v' = of white, with luminance .3 / pi; the same for the red primary. */
static void chromaticities_are_colour(void **state)
{
    (void)state;
    const double xy[2][2] = {{1. / 3, 1. / 3}, {.64, .33}};
    for (int i = 0; i < 2; i++) {
        pm_bytes b = {0};
        double x = xy[i][0], y = xy[i][1], down = -2 * x + 12 * y + 3;
        double u = 4 * x / down, v = 9 * y / down, level = .1 / PM_PI;
        struct tree_shape shape = {4, 1, constant, NULL, &level};
        begin_file(&b, "TensorTree4", "");
        put_tree(&b, "Visible", "Reflection Back", &shape);
        shape.context = &u;
        shape.depth = 0;
        put_tree(&b, "CIE-u", "Reflection Back", &shape);
        shape.context = &v;
        put_tree(&b, "CIE-v", "Reflection Back", &shape);
        end_file(&b);
        pm_bsdf *bsdf = read_file(&b);
        pm_rgb c = pm_bsdf_diffuse_reflectance(bsdf, (pm_vec3){0, 0, 1});
        if (i == 0)
            assert_grey(c, .1, 1e-5);
        else
            assert_near(c.g + c.b, 0, 1e-5);
        assert_near(pm_rgb_luminance(c), .1, 2e-4); /* weights of base/rgb.h */
        pm_bsdf_free(bsdf);
    }
}

/* ---- sums and samples ---- */

static const struct {
    const char *direction;
    const struct tree_shape *shape;
    bool front;  /* the side that the walk comes from */
    bool probed; /* the density is not the value's */
} walks[] = {
    {"Transmission Front", &rank4, false, false}, {"Transmission Front", &rank4, true, false},
    {"Transmission Back", &ridge4, true, false},  {"Transmission Back", &ridge4, false, false},
    {"Transmission Front", &rank3, false, false}, {"Transmission Front", &rank3, true, true},
    {"Transmission Back", &spot3, true, false},   {"Transmission Back", &spot3, false, true},
};
enum { WALKS = sizeof walks / sizeof walks[0] };

static const double cosines[4] = {.98, .8, .5, .15};

/* Where the coordinates stand in the file cells are squares of the sum: 1e-6. Turned or
 * reversed they are not: 256^2 midpoints of a value below 2 that jumps along a few lines. */
static void albedo_is_the_integral_and_at_most_one(void **state)
{
    (void)state;
    for (int i = 0; i < WALKS; i++) {
        pm_bsdf *bsdf = tree_file(walks[i].direction, NULL, walks[i].shape);
        for (int k = 0; k < 4; k++) {
            struct walk w = {.bsdf = bsdf, .in = polar(cosines[k], .4), .transmitted = true};
            w.in.z *= walks[i].front ? 1 : -1;
            double sum = over_hemisphere(walk_scattered, &w);
            double albedo = pm_rgb_luminance(pm_bsdf_albedo(bsdf, w.in, true));
            double tolerance = walks[i].shape->rank == 4 ? 1e-6 : .006;
            assert_near(albedo, sum, walks[i].probed ? .05 * sum + .005 : tolerance);
            assert_at_most(albedo + pm_bsdf_diffuse_transmittance(bsdf, w.in).g, 1 + 1e-6);
            if (albedo > 0)
                assert_near(over_hemisphere(walk_density, &w), 1, tolerance);
        }
        pm_bsdf_free(bsdf);
    }
}

static void frequencies_equal_the_density(void **state)
{
    (void)state;
    for (int i = 0; i < WALKS; i++) {
        pm_bsdf *bsdf = tree_file(walks[i].direction, NULL, walks[i].shape);
        for (int k = 0; k < 2; k++) {
            struct walk w = {
                .bsdf = bsdf, .in = polar(cosines[1 + k], .4), .transmitted = true};
            w.in.z *= walks[i].front ? 1 : -1;
            check_frequency(&w, 70 + (uint64_t)(2 * i + k));
        }
        pm_bsdf_free(bsdf);
    }
}

/* Where the density is the value's, each sample weighs the albedo; elsewhere on average. */
static void mean_weight_is_the_albedo(void **state)
{
    (void)state;
    for (int i = 0; i < WALKS; i++) {
        pm_bsdf *bsdf = tree_file(walks[i].direction, NULL, walks[i].shape);
        pm_rng rng;
        pm_rng_init(&rng, 9, PM_RNG_PATH, (uint64_t)i);
        struct walk w = {.bsdf = bsdf, .in = polar(.8, .4), .transmitted = true};
        w.in.z *= walks[i].front ? 1 : -1;
        double albedo = pm_bsdf_albedo(bsdf, w.in, true).g, sum = 0, squares = 0;
        enum { SAMPLES = 20000 };
        for (int k = 0; k < SAMPLES; k++) {
            double u[2];
            pm_vec3 out;
            draw(&rng, u, 2);
            assert_true(pm_bsdf_sample(bsdf, w.in, true, u[0], u[1], &out));
            double weight = walk_scattered(&w, out) / walk_density(&w, out);
            if (!walks[i].probed)
                assert_near(weight, albedo, 2e-4 * albedo); /* sums are floats */
            sum += weight;
            squares += weight * weight;
        }
        double mean = sum / SAMPLES, variance = squares / SAMPLES - mean * mean;
        double integral = over_hemisphere(walk_scattered, &w);
        assert_near(mean, integral, 4 * sqrt(fmax(variance, 0) / SAMPLES) + .006);
        pm_bsdf_free(bsdf);
    }
}

/* ---- size ---- */

static void seven_levels_read_within_bounded_memory(void **state)
{
    (void)state;
    struct tree_shape deep = ridge4;
    deep.depth = 7;
    pm_bytes b = {0};
    begin_file(&b, "TensorTree4", "");
    put_tree(&b, "Visible", "Transmission Front", &deep);
    end_file(&b);
    assert_true(b.size > 300000);
    size_t text = b.size, before = mallinfo2().uordblks + mallinfo2().hblkhd;
    pm_bsdf *bsdf = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_ok(pm_bsdf_read(b.data, b.size, "deep.xml", &bsdf, &err), &err);
    size_t after = mallinfo2().uordblks + mallinfo2().hblkhd;
    assert_true(after - before < 4 * text + (64u << 20));
    pm_vec3 in = polar(.7, 1), out = pm_vec3_negate(in);
    in.z = -in.z;
    out.z = -out.z;
    assert_true(pm_bsdf_value(bsdf, in, out).r > 10);
    pm_bsdf_free(bsdf);
    pm_bytes_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_tree_is_lambertian),
        cmocka_unit_test(places_of_a_grid),
        cmocka_unit_test(isotropic_values_turn_along),
        cmocka_unit_test(transmission_from_one_side_is_reciprocal),
        cmocka_unit_test(values_are_those_of_radiance),
        cmocka_unit_test(chromaticities_are_colour),
        cmocka_unit_test(albedo_is_the_integral_and_at_most_one),
        cmocka_unit_test(frequencies_equal_the_density),
        cmocka_unit_test(mean_weight_is_the_albedo),
        cmocka_unit_test(seven_levels_read_within_bounded_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
