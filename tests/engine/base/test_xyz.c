#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/xyz.h"

static void assert_rgb(pm_rgb c, double r, double g, double b, double tolerance)
{
    if (fabs(c.r - r) > tolerance || fabs(c.g - g) > tolerance || fabs(c.b - b) > tolerance)
        fail_msg("%.12g %.12g %.12g is not %.12g %.12g %.12g", c.r, c.g, c.b, r, g, b);
}

/* A primary's XYZ is its chromaticity times its luminance: 0.2651058, 0.6701058, 0.0647884
 * solve sum L_i x_i/y_i = sum L_i = sum L_i z_i/y_i = 1. */
static void xyz_of_the_primaries_are_the_unit_colours(void **state)
{
    (void)state;
    const double xy[3][2] = {{0.64, 0.33}, {0.29, 0.60}, {0.15, 0.06}};
    const double luminance[3] = {0.2651058201058201, 0.6701058201058201, 0.06478835978835978};
    for (int i = 0; i < 3; i++) {
        double s = luminance[i] / xy[i][1];
        pm_rgb c = pm_rgb_of_xyz(s * xy[i][0], luminance[i], s * (1 - xy[i][0] - xy[i][1]));
        assert_rgb(c, i == 0, i == 1, i == 2, 1e-12);
    }
    assert_rgb(pm_rgb_of_xyz(1, 1, 1), 1, 1, 1, 1e-12);
}

static void xyz_of_a_constant_spectrum_is_grey(void **state)
{
    (void)state;
    double one = 1, many[37];
    for (int i = 0; i < 37; i++)
        many[i] = 0.25;
    assert_rgb(pm_rgb_of_spectrum(&one, 1, 380, 780), 1, 1, 1, 1e-12);
    assert_rgb(pm_rgb_of_spectrum(many, 37, 300, 900), 0.25, 0.25, 0.25, 1e-12);
    assert_rgb(pm_rgb_of_spectrum(many, 37, 900, 300), 0.25, 0.25, 0.25, 1e-12);
}

/* The two halves of a spectrum add up; order of the wavelengths is free. */
static void xyz_of_steps_is_linear_inside_the_gamut(void **state)
{
    (void)state;
    const double up[4] = {0.6, 0.7, 0.8, 0.9}, down[4] = {0.9, 0.8, 0.7, 0.6};
    pm_rgb a = pm_rgb_of_spectrum(up, 4, 380, 780);
    pm_rgb b = pm_rgb_of_spectrum(down, 4, 780, 380);
    pm_rgb c = pm_rgb_of_spectrum(down, 4, 380, 780);
    assert_rgb(a, b.r, b.g, b.b, 1e-12);
    assert_rgb(pm_rgb_add(a, c), 1.5, 1.5, 1.5, 1e-12);
    assert_true(a.r > a.b);
    assert_true(c.b > c.r);
}

/* CIE: of the luminance of equal energy 0.5000 lies below 560.2 nm or so; the sums of the 5 nm
 * table give 0.4953 below 560. Outside light there is none. */
static void xyz_of_monochromatic_light_keeps_its_luminance(void **state)
{
    (void)state;
    const double one = 1;
    pm_rgb green = pm_rgb_of_spectrum(&one, 1, 500, 560);
    double y = pm_rgb_luminance(green);
    double sum = 0; /* trapezoids over 500 .. 560 of the table's y */
    const double table[13] = {0.3230, 0.4073, 0.5030, 0.6082, 0.7100, 0.7932, 0.8620,
                              0.9149, 0.9540, 0.9803, 0.9950, 1.0000, 0.9950};
    for (int i = 0; i < 12; i++)
        sum += 2.5 * (table[i] + table[i + 1]);
    assert_true(fabs(y - sum / 106.8555) < 1e-4); /* pm_rgb_luminance has weights to 1e-4 */
    assert_true(green.r >= 0 && green.g > 0 && green.b >= 0);
    assert_rgb(pm_rgb_of_spectrum(&one, 1, 200, 380), 0, 0, 0, 0);
    assert_rgb(pm_rgb_of_spectrum(&one, 1, 780, 2000), 0, 0, 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(xyz_of_the_primaries_are_the_unit_colours),
        cmocka_unit_test(xyz_of_a_constant_spectrum_is_grey),
        cmocka_unit_test(xyz_of_steps_is_linear_inside_the_gamut),
        cmocka_unit_test(xyz_of_monochromatic_light_keeps_its_luminance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
