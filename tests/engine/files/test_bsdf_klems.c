#include "bsdf_test.h"

static const char *const all_directions[4] = {"Reflection Front", "Reflection Back",
                                              "Transmission Front", "Transmission Back"};

/* Bounds of the quarter basis as cosines squared. */
static void quarter_bounds(double *cosine2)
{
    const double theta_deg[6] = {0, 9, 27, 46, 66, 90};
    for (int i = 0; i < 6; i++)
        cosine2[i] = pow(cos(theta_deg[i] * PM_PI / 180), 2);
    cosine2[5] = 0;
}

static const int quarter_counts[5] = {1, 8, 12, 12, 8};
enum { QUARTER = 41 };

static double quarter_projected(int patch)
{
    double cosine2[6];
    int ring = 0;
    quarter_bounds(cosine2);
    while (patch >= quarter_counts[ring])
        patch -= quarter_counts[ring++];
    return PM_PI * (cosine2[ring] - cosine2[ring + 1]) / quarter_counts[ring];
}

/* Centre of a patch of the quarter basis, azimuth from +x. */
static pm_vec3 quarter_centre(int patch)
{
    const double theta_deg[5] = {0, 18, 36.5, 56, 78};
    int ring = 0;
    while (patch >= quarter_counts[ring])
        patch -= quarter_counts[ring++];
    return polar(cos(theta_deg[ring] * PM_PI / 180), 2 * PM_PI * patch / quarter_counts[ring]);
}

/* A column's direction of incidence: light that goes towards the patch. */
static pm_vec3 quarter_from(int patch)
{
    pm_vec3 c = quarter_centre(patch);
    return (pm_vec3){-c.x, -c.y, c.z};
}

static double hash_value(void *context, int i)
{
    (void)context;
    return (i * 7919 + 13) % 101 * .0025;
}

static double constant_value(void *context, int i)
{
    (void)i;
    return *(double *)context;
}

static double random_value(void *context, int i)
{
    (void)i;
    double u = pm_rng_uniform(context);
    return u < .5 ? 0 : u * u * u;
}

/* ---- Lambertian ---- */

static void lambertian_file_is_its_albedo_over_pi(void **state)
{
    (void)state;
    const char *const bases[3] = {klems_full, klems_half, klems_quarter};
    const int patches[3] = {145, 73, 41};
    for (int i = 0; i < 3; i++) {
        pm_bytes b = {0};
        double reflected = .4 / PM_PI, transmitted = .25 / PM_PI;
        begin_file(&b, "Columns", "");
        put_matrix(&b, "Visible", "Reflection Front", bases[i], bases[i],
                   patches[i] * patches[i], constant_value, &reflected);
        put_matrix(&b, "Visible", "Transmission Front", bases[i], bases[i],
                   patches[i] * patches[i], constant_value, &transmitted);
        end_file(&b);
        pm_bsdf *bsdf = read_file(&b);
        pm_vec3 front = {.6, 0, .8}, back = {.6, 0, -.8};
        assert_grey(pm_bsdf_diffuse_reflectance(bsdf, back), .4, 1e-6);
        assert_grey(pm_bsdf_diffuse_reflectance(bsdf, front), 0, 0);
        assert_grey(pm_bsdf_diffuse_transmittance(bsdf, back), .25, 1e-6);
        assert_grey(pm_bsdf_diffuse_transmittance(bsdf, front), .25, 1e-6);
        assert_grey(pm_bsdf_value(bsdf, back, back), 0, 0);
        assert_grey(pm_bsdf_albedo(bsdf, back, true), 0, 0);
        pm_vec3 out;
        assert_false(pm_bsdf_sample(bsdf, back, false, .5, .5, &out));
        pm_bsdf_info info;
        pm_bsdf_info_get(bsdf, &info);
        assert_true(info.reflects && info.transmits && !info.is_tree && !info.has_geometry);
        assert_false(info.rest_reflects[0] || info.rest_transmits[1]);
        assert_near(info.albedo_max, .65, 1e-6);
        assert_near(info.thickness, .025, 1e-15);
        assert_near(info.width, 2, 0);
        pm_bsdf_free(bsdf);
    }
}

static void smallest_lambertian_part_is_not_split_off(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        pm_bytes b = {0};
        double value = (i ? .0101 : .0099) / PM_PI;
        begin_file(&b, "Columns", "");
        put_matrix(&b, "Visible", "Reflection Back", klems_quarter, klems_quarter,
                   QUARTER * QUARTER, constant_value, &value);
        end_file(&b);
        pm_bsdf *bsdf = read_file(&b);
        pm_vec3 in = {0, .6, .8};
        assert_int_equal(pm_bsdf_diffuse_reflectance(bsdf, in).r > 0, i);
        assert_int_equal(pm_bsdf_value(bsdf, in, in).r > 0, !i);
        pm_bsdf_free(bsdf);
    }
}

/* ---- places ---- */

struct single {
    int at;
};

static double single_value(void *context, int i)
{
    return i == ((struct single *)context)->at ? 1.5 : 0;
}

static pm_bsdf *single_entry(const char *structure, const char *direction, int in, int out)
{
    pm_bytes b = {0};
    struct single s = {strcmp(structure, "Rows") ? out * QUARTER + in : in * QUARTER + out};
    begin_file(&b, structure, "");
    put_matrix(&b, "Visible", direction, klems_quarter, klems_quarter, QUARTER * QUARTER,
               single_value, &s);
    end_file(&b);
    return read_file(&b);
}

/* Column 5 of ring 1 is at azimuth 180: light that travels towards -x, so comes from +x. Row 9
 * is the first patch of ring 2, at azimuth 0: light goes on towards +x. */
static void columns_name_where_light_goes_to(void **state)
{
    (void)state;
    const char *const structures[2] = {"Columns", "Rows"};
    for (int i = 0; i < 2; i++) {
        pm_bsdf *bsdf = single_entry(structures[i], "Reflection Back", 5, 9);
        pm_vec3 in = polar(cos(.3), 0), out = polar(cos(.6), 0);
        assert_grey(pm_bsdf_value(bsdf, in, out), 1.5, 0);
        assert_grey(pm_bsdf_value(bsdf, (pm_vec3){-in.x, in.y, in.z}, out), 0, 0);
        assert_grey(pm_bsdf_value(bsdf, in, (pm_vec3){-out.x, out.y, out.z}), 0, 0);
        pm_bsdf_free(bsdf);
    }
}

/* "Front" of the file is the exterior: z < 0. */
static void front_of_the_file_is_the_back(void **state)
{
    (void)state;
    for (int way = 0; way < 4; way++) {
        pm_bsdf *bsdf = single_entry("Columns", all_directions[way], 5, 9);
        bool front = way & 1, through = way >= 2;
        pm_vec3 in = polar(cos(.3), 0), out = polar(cos(.6), 0);
        in.z *= front ? 1 : -1;
        out.z *= front != through ? 1 : -1;
        assert_grey(pm_bsdf_value(bsdf, in, out), 1.5, 0);
        pm_bsdf_info info;
        pm_bsdf_info_get(bsdf, &info);
        assert_int_equal(info.reflects, !through);
        assert_int_equal(info.transmits, through);
        /* the way back: transmission by reciprocity, reflection of the same side not */
        assert_grey(pm_bsdf_value(bsdf, out, in), through ? 1.5 : 0, 0);
        pm_bsdf_free(bsdf);
    }
}

static void transmission_from_one_side_is_reciprocal(void **state)
{
    (void)state;
    pm_bytes b = {0};
    begin_file(&b, "Columns", "");
    put_matrix(&b, "Visible", "Transmission Front", klems_quarter, klems_full, QUARTER * 145,
               hash_value, NULL);
    end_file(&b);
    pm_bsdf *bsdf = read_file(&b);
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (int i = 0; i < 2000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 a = pm_warp_cosine(u[0], u[1]), c = pm_warp_cosine(u[2], u[3]);
        c.z = -c.z;
        assert_near(pm_bsdf_value(bsdf, a, c).r, pm_bsdf_value(bsdf, c, a).r, 0);
    }
    pm_bsdf_free(bsdf);
}

static const struct answer klems_answers[] = {
    {{-0.5, 0.1, -0.3}, {0.2, 0.3, -0.9}, 1.250000e-01},
    {{0.7, 1, -0.8}, {0.6, -0.2, -0.7}, 1.100000e-01},
    {{-0.2, 0.2, -1}, {0.2, 0.3, -0.9}, 3.250000e-02},
    {{-0.4, -0.4, -0.3}, {0.3, 0.2, -0.3}, 9.250000e-02},
    {{0.4, 0.8, -0.2}, {0.6, -0.1, 0.9}, 1.675000e-01},
    {{0.2, -0.7, -0.9}, {0.7, -0.4, 0.9}, 1.250000e-01},
    {{0.2, -0.4, -0.3}, {-0.4, -0.3, 0.2}, 3.500000e-02},
    {{-0, 0.6, -0.3}, {-0.6, 0.1, 0.6}, 7.500000e-02},
    {{0.4, -0.6, 0.7}, {0.1, -0.4, -0.9}, 1.375000e-01},
    {{-0.4, 0.5, 0.7}, {-0.9, 0.2, -0.9}, 2.150000e-01},
    {{-0.4, -0.8, 0.2}, {-0.9, -0.6, -0.2}, 1.925000e-01},
    {{-0.5, -0.4, 1}, {0, 0.1, -1}, 1.950000e-01},
    {{0.7, -0, 0.3}, {-0.7, 0.3, 0.7}, 1.925000e-01},
    {{0, 0.5, 0.3}, {-0.9, 0.5, 0.2}, 7.500000e-02},
    {{-0.4, -0.9, 0.7}, {-0.1, 0.4, 0.8}, 1.650000e-01},
    {{0.2, 0.8, 0.4}, {0.9, 0.7, 1}, 1.975000e-01},
};

static pm_bsdf *mixed_file(void)
{
    pm_bytes b = {0};
    begin_file(&b, "Columns",
               "<AngleBasis><AngleBasisName>two</AngleBasisName>"
               "<AngleBasisBlock><Theta>0</Theta><nPhis>1</nPhis><ThetaBounds>"
               "<LowerTheta>0</LowerTheta><UpperTheta>30</UpperTheta></ThetaBounds>"
               "</AngleBasisBlock><AngleBasisBlock><Theta>60</Theta><nPhis>6</nPhis>"
               "<ThetaBounds><LowerTheta>30</LowerTheta><UpperTheta>90</UpperTheta>"
               "</ThetaBounds></AngleBasisBlock></AngleBasis>");
    put_matrix(&b, "Visible", "Transmission Front", klems_half, klems_half, 73 * 73, hash_value,
               NULL);
    put_matrix(&b, "Visible", "Reflection Front", "two", "two", 49, hash_value, NULL);
    put_matrix(&b, "Visible", "Reflection Back", klems_quarter, "two", QUARTER * 7, hash_value,
               NULL);
    end_file(&b);
    return read_file(&b);
}

static void values_are_those_of_radiance(void **state)
{
    (void)state;
    pm_bsdf *bsdf = mixed_file();
    check_answers(bsdf, klems_answers, sizeof klems_answers / sizeof klems_answers[0]);
    pm_bsdf_free(bsdf);
}

/* ---- colour ---- */

static void tristimulus_values_are_colour(void **state)
{
    (void)state;
    pm_bytes b = {0};
    /* the red primary, x = .64 and y = .33, of luminance .1 / pi, beside a white part */
    double y = .1 / PM_PI, x = y * .64 / .33, z = y * .03 / .33;
    const char *const bands[3] = {"Visible", "CIE-X", "CIE-Z"};
    const double level[3] = {y, x, z};
    begin_file(&b, "Columns", "");
    for (int i = 0; i < 3; i++) {
        double front = level[i], back = .2 / PM_PI;
        put_matrix(&b, bands[i], "Reflection Front", klems_quarter, klems_quarter,
                   QUARTER * QUARTER, constant_value, &front);
        put_matrix(&b, bands[i], "Reflection Back", klems_quarter, klems_quarter,
                   QUARTER * QUARTER, constant_value, &back);
    }
    end_file(&b);
    pm_bsdf *bsdf = read_file(&b);
    pm_rgb red = pm_bsdf_diffuse_reflectance(bsdf, (pm_vec3){0, 0, -1});
    assert_near(pm_rgb_luminance(red), .1, 2e-4); /* weights of base/rgb.h: to four digits */
    assert_near(red.g, 0, 1e-5);
    assert_near(red.b, 0, 1e-5);
    assert_grey(pm_bsdf_diffuse_reflectance(bsdf, (pm_vec3){0, 0, 1}), .2, 1e-5);
    pm_bsdf_free(bsdf);
}

static void other_wavelengths_carry_no_light(void **state)
{
    (void)state;
    pm_bytes b = {0};
    double visible = .3 / PM_PI, solar = 3;
    begin_file(&b, "Columns", "");
    put_matrix(&b, "Solar", "Reflection Front", klems_quarter, klems_quarter, 5, constant_value,
               &solar);
    put_matrix(&b, "Visible", "Reflection Front", klems_quarter, klems_quarter,
               QUARTER * QUARTER, constant_value, &visible);
    put_matrix(&b, "NIR", "Reflection Front", klems_quarter, klems_quarter, 5, constant_value,
               &solar);
    end_file(&b);
    pm_bsdf *bsdf = read_file(&b);
    assert_grey(pm_bsdf_diffuse_reflectance(bsdf, (pm_vec3){0, 0, -1}), .3, 1e-6);
    pm_bsdf_free(bsdf);
}

/* ---- sums and samples ---- */

static pm_bsdf *random_file(uint64_t seed, bool both)
{
    pm_bytes b = {0};
    pm_rng rng;
    pm_rng_init(&rng, seed, PM_RNG_PATH, 0);
    begin_file(&b, "Rows", "");
    for (int way = 0; way < (both ? 4 : 3); way++)
        put_matrix(&b, "Visible", all_directions[way], klems_quarter, klems_quarter,
                   QUARTER * QUARTER, random_value, &rng);
    end_file(&b);
    return read_file(&b);
}

static void rows_sum_to_the_albedo(void **state)
{
    (void)state;
    pm_bytes b = {0};
    begin_file(&b, "Rows", "");
    put_matrix(&b, "Visible", "Transmission Back", klems_quarter, klems_quarter,
               QUARTER * QUARTER, hash_value, NULL);
    end_file(&b);
    pm_bsdf *bsdf = read_file(&b);
    for (int i = 0; i < QUARTER; i++) {
        double row = 0, column = 0;
        for (int o = 0; o < QUARTER; o++) {
            row += hash_value(NULL, i * QUARTER + o) * quarter_projected(o);
            column += hash_value(NULL, o * QUARTER + i) * quarter_projected(o);
        }
        pm_vec3 in = quarter_from(i), back = quarter_centre(i);
        back.z = -back.z;
        assert_grey(pm_bsdf_albedo(bsdf, in, true), row, 1e-6);
        assert_grey(pm_bsdf_albedo(bsdf, back, true), column, 1e-6);
    }
    pm_bsdf_free(bsdf);
}

static void energy_never_grows(void **state)
{
    (void)state;
    double cosine2[6];
    quarter_bounds(cosine2);
    for (uint64_t seed = 0; seed < 4; seed++) {
        pm_bsdf *bsdf = random_file(seed, seed & 1);
        pm_bsdf_info info;
        pm_bsdf_info_get(bsdf, &info);
        assert_true(info.albedo_max > 1); /* so that it is scaled */
        for (int i = 0; i < 2 * QUARTER; i++) {
            struct walk w = {.bsdf = bsdf, .in = quarter_from(i / 2)};
            w.in.z *= i % 2 ? 1 : -1;
            double total = 0;
            for (int through = 0; through < 2; through++) {
                w.transmitted = through;
                double part = over_rings(walk_scattered, &w, cosine2, 5);
                assert_near(pm_rgb_luminance(pm_bsdf_albedo(bsdf, w.in, through)), part, 1e-6);
                total += part;
            }
            total += pm_bsdf_diffuse_reflectance(bsdf, w.in).g +
                     pm_bsdf_diffuse_transmittance(bsdf, w.in).g;
            assert_at_most(total, 1 + 1e-6);
        }
        pm_bsdf_free(bsdf);
    }
}

static void densities_integrate_to_one(void **state)
{
    (void)state;
    double cosine2[6];
    quarter_bounds(cosine2);
    pm_bsdf *bsdf = random_file(5, false);
    for (int i = 0; i < 4 * QUARTER; i++) {
        struct walk w = {.bsdf = bsdf, .in = quarter_from(i / 4), .transmitted = i & 1};
        w.in.z *= i & 2 ? 1 : -1;
        assert_near(over_rings(walk_density, &w, cosine2, 5), 1, 1e-6);
    }
    pm_bsdf_free(bsdf);
}

static void frequencies_equal_the_density(void **state)
{
    (void)state;
    pm_bsdf *bsdf = random_file(6, false);
    for (int i = 0; i < 8; i++) {
        struct walk w = {
            .bsdf = bsdf, .in = quarter_from(9 * i % QUARTER), .transmitted = i & 1};
        w.in.z *= i & 2 ? 1 : -1;
        check_frequency(&w, 40 + (uint64_t)i);
    }
    pm_bsdf_free(bsdf);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lambertian_file_is_its_albedo_over_pi),
        cmocka_unit_test(smallest_lambertian_part_is_not_split_off),
        cmocka_unit_test(columns_name_where_light_goes_to),
        cmocka_unit_test(front_of_the_file_is_the_back),
        cmocka_unit_test(transmission_from_one_side_is_reciprocal),
        cmocka_unit_test(values_are_those_of_radiance),
        cmocka_unit_test(tristimulus_values_are_colour),
        cmocka_unit_test(other_wavelengths_carry_no_light),
        cmocka_unit_test(rows_sum_to_the_albedo),
        cmocka_unit_test(energy_never_grows),
        cmocka_unit_test(densities_integrate_to_one),
        cmocka_unit_test(frequencies_equal_the_density),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
