#include "bsdf_test.h"

/* A clear pane: `through` of the light goes straight on, `spread` evenly everywhere, and
 * `around` into the next ring of patches or so. */
struct pane {
    double through, spread;
};

static const int counts[5] = {1, 8, 12, 12, 8};

static double projected(int patch)
{
    const double theta_deg[6] = {0, 9, 27, 46, 66, 90};
    int ring = 0;
    while (patch >= counts[ring])
        patch -= counts[ring++];
    double inner = cos(theta_deg[ring] * PM_PI / 180);
    double outer = ring < 4 ? cos(theta_deg[ring + 1] * PM_PI / 180) : 0;
    return PM_PI * (inner * inner - outer * outer) / counts[ring];
}

static double pane_value(void *context, int i)
{
    const struct pane *p = context;
    int in = i % 41, out = i / 41;
    return p->spread / PM_PI + (in == out ? p->through / projected(in) : 0) +
           ((in + out) % 5 == 0 ? .01 : 0);
}

static pm_bsdf *pane_file(struct pane pane, const char *direction, const char *second)
{
    pm_bytes b = {0};
    begin_file(&b, "Columns", "");
    put_matrix(&b, "Visible", direction, klems_quarter, klems_quarter, 41 * 41, pane_value,
               &pane);
    if (second)
        put_matrix(&b, "Visible", second, klems_quarter, klems_quarter, 41 * 41, pane_value,
                   &pane);
    end_file(&b);
    return read_file(&b);
}

static double tree_pane(void *context, const double *centre)
{
    const struct pane *p = context;
    double dx = centre[0] - centre[2], dy = centre[1] - centre[3];
    bool straight = fabs(dx) + fabs(dy) < 1e-9;
    return p->spread / PM_PI + (straight ? p->through * 256 / PM_PI : 0) +
           (centre[2] > .5 ? .005 : 0);
}

static bool tree_splits(void *context, const double *centre, double edge)
{
    (void)context;
    return fabs(centre[0] - centre[2]) < edge / 2 && fabs(centre[1] - centre[3]) < edge / 2;
}

static pm_bsdf *tree_pane_file(struct pane pane)
{
    pm_bytes b = {0};
    const struct tree_shape shape = {4, 4, tree_pane, tree_splits, &pane};
    begin_file(&b, "TensorTree4", "");
    put_tree(&b, "Visible", "Transmission Back", &shape);
    end_file(&b);
    return read_file(&b);
}

enum { FILES = 4 };

static pm_bsdf *any_file(int which)
{
    const struct pane pane = {.6, .1};
    switch (which) {
    case 0:
        return pane_file(pane, "Transmission Front", NULL);
    case 1:
        return pane_file(pane, "Transmission Back", NULL);
    case 2:
        return pane_file(pane, "Transmission Front", "Transmission Back");
    default:
        return tree_pane_file(pane);
    }
}

/* Directions well inside patches of the quarter basis. */
static const double cosines[4] = {1, .95, .8, .55};

static pm_vec3 direction(int i)
{
    pm_vec3 in = polar(cosines[i / 2 % 4], .1);
    in.z *= i % 2 ? 1 : -1;
    return in;
}

static void straight_light_is_the_peak(void **state)
{
    (void)state;
    for (int file = 0; file < FILES; file++) {
        pm_bsdf *bsdf = any_file(file);
        for (int i = 0; i < 8; i++) {
            pm_bsdf_peak peak;
            pm_bsdf_peak_at(bsdf, direction(i), &peak);
            assert_true(peak.count >= 1);
            assert_near(peak.transmittance.g, .6, .01);
        }
        pm_bsdf_free(bsdf);
    }
}

static void peak_is_the_same_both_ways(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 4, PM_RNG_PATH, 0);
    for (int file = 0; file < FILES; file++) {
        pm_bsdf *bsdf = any_file(file);
        int found = 0;
        for (int i = 0; i < 500; i++) {
            double u[2];
            draw(&rng, u, 2);
            pm_vec3 in = pm_warp_cosine(u[0], u[1]);
            pm_bsdf_peak there, back;
            pm_bsdf_peak_at(bsdf, in, &there);
            pm_bsdf_peak_at(bsdf, pm_vec3_negate(in), &back);
            assert_near(there.transmittance.g, back.transmittance.g, 0);
            assert_int_equal(there.count > 0, back.count > 0);
            found += there.count > 0;
        }
        assert_true(found > 300);
        pm_bsdf_free(bsdf);
    }
}

static void scattered_light_is_no_peak(void **state)
{
    (void)state;
    pm_bsdf *bsdf = pane_file((struct pane){0, .5}, "Transmission Front", NULL);
    for (int i = 0; i < 8; i++) {
        pm_bsdf_peak peak;
        pm_bsdf_peak_at(bsdf, direction(i), &peak);
        assert_int_equal(peak.count, 0);
        assert_grey(peak.transmittance, 0, 0);
        struct walk w = {.bsdf = bsdf, .peak = &peak, .in = direction(i), .transmitted = true};
        pm_vec3 out = {.3, .2, -w.in.z};
        out = pm_vec3_normalize(out);
        assert_near(walk_density(&w, out), pm_bsdf_pdf(bsdf, w.in, out), 0);
        assert_near(pm_bsdf_value_without(bsdf, &peak, w.in, out).g,
                    pm_bsdf_value(bsdf, w.in, out).g, 0);
    }
    pm_bsdf_free(bsdf);
}

/* The peak and what is left make up the whole. */
static void nothing_counts_twice(void **state)
{
    (void)state;
    for (int file = 0; file < FILES; file++) {
        pm_bsdf *bsdf = any_file(file);
        for (int i = 0; i < 8; i++) {
            pm_bsdf_peak peak;
            pm_bsdf_peak_at(bsdf, direction(i), &peak);
            struct walk w = {
                .bsdf = bsdf, .peak = &peak, .in = direction(i), .transmitted = true};
            double whole = pm_bsdf_albedo(bsdf, w.in, true).g;
            double rest = over_hemisphere(walk_scattered, &w);
            double left = whole * (1 - peak.share);
            /* the midpoint rule resolves patches to a few in a thousand */
            assert_near(rest, left, .003);
            /* the third file differs a little from itself turned round */
            assert_near(peak.transmittance.g, whole * peak.share, file == 2 ? .001 : 1e-5);
            assert_near(pm_rgb_luminance(
                            pm_bsdf_value_without(bsdf, &peak, w.in, pm_vec3_negate(w.in))),
                        0, 0);
        }
        pm_bsdf_free(bsdf);
    }
}

static void frequencies_equal_the_density(void **state)
{
    (void)state;
    for (int file = 0; file < FILES; file++) {
        pm_bsdf *bsdf = any_file(file);
        for (int i = 2; i < 6; i++) {
            pm_bsdf_peak peak;
            pm_bsdf_peak_at(bsdf, direction(i), &peak);
            assert_true(peak.count > 0);
            struct walk w = {
                .bsdf = bsdf, .peak = &peak, .in = direction(i), .transmitted = true};
            check_frequency(&w, 10 * (uint64_t)file + (uint64_t)i);
        }
        pm_bsdf_free(bsdf);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(straight_light_is_the_peak),
        cmocka_unit_test(peak_is_the_same_both_ways),
        cmocka_unit_test(scattered_light_is_no_peak),
        cmocka_unit_test(nothing_counts_twice),
        cmocka_unit_test(frequencies_equal_the_density),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
