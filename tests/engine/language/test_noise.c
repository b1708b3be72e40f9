#include "language_test.h"

#include "language/noise.h"

/* Of Radiance's own functions (src/rt/noise3.c built apart): numbers, not formulas. */
static void noise_has_the_values_of_radiance(void **state)
{
    (void)state;
    static const struct {
        double x, y, z, noise, fractal;
    } rows[] = {
        {0.3, 0.4, 0, -0.053544000000000064, -0.053888648646963036},
        {1.3, -2.4, 0.7, 0.18913429131832332, -0.18734935006888717},
        {-13.37, 7.25, 99.5, 0.39716862091245519, 0.79023167802077099},
        {1000.1, -777.7, 3.33, 0.5618910375337498, 0.34606662841351349},
        {-0.001, 0.002, -0.003, -0.0040000879325281071, -0.28112731146580794},
        {255.9, 256.1, -256.5, -0.3049674707199807, 0.50610680267461372},
        {12.5, 12.5, 12.5, 0.125, 0.55112871100633809},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double noise = pm_noise(rows[i].x, rows[i].y, rows[i].z);
        double fractal = pm_noise_fractal(rows[i].x, rows[i].y, rows[i].z);
        if (!(fabs(noise - rows[i].noise) < 1e-14) ||
            !(fabs(fractal - rows[i].fractal) < 1e-14))
            fail_msg("row %zu: %.17g %.17g", i, noise, fractal);
    }
}

/* A gradient at a corner says nothing of the corner itself. */
static void noise_is_0_on_the_lattice(void **state)
{
    (void)state;
    for (int i = -300; i < 300; i += 7)
        assert_true(pm_noise(i, 3 * i + 1, -i) == 0);
}

/* The slope is at most 4: |fade'| <= 15/8 times differences up to 2, and gradients up to 2. */
static void noise_is_continuous_and_repeats_after_256(void **state)
{
    (void)state;
    const double h = 1e-6;
    for (int i = 0; i < 2000; i++) {
        double x = i * .137 - 140, y = i * .091 - 95, z = i * -.053;
        double here = pm_noise(x, y, z);
        assert_true(fabs(here) <= 1.5);
        assert_true(fabs(pm_noise(x + h, y, z) - here) < 12 * h);
        assert_true(fabs(pm_noise(x, y - h, z) - here) < 12 * h);
        assert_true(fabs(pm_noise(x + 256, y, z - 512) - here) < 1e-10);
    }
}

static void fractal_noise_stays_between_its_bounds(void **state)
{
    (void)state;
    double least = 1, most = -1;
    for (int i = 0; i < 20000; i++) {
        double v = pm_noise_fractal(i * .0137 - 100, i * .0091, i * -.053);
        least = fmin(least, v);
        most = fmax(most, v);
    }
    assert_true(least > -2 && least < -.5 && most < 2 && most > .5);
}

static void noise_far_away_is_0(void **state)
{
    (void)state;
    const double far[] = {1e10, -1e300, INFINITY, NAN};
    for (int i = 0; i < 4; i++) {
        assert_true(pm_noise(far[i], 0, .5) == 0 && pm_noise(.5, .5, far[i]) == 0);
        assert_true(pm_noise_fractal(.5, far[i], .5) == 0);
    }
}

/* Backward differences of step 5e-4: the derivative within half the step times the second
 * derivative, which is some tens at most. */
static void derivatives_follow_the_noise(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    const double h = 1e-6;
    for (int i = 0; i < 50; i++) {
        double *p = b.ray.value + PM_RAY_PX;
        p[0] = i * .37, p[1] = -i * .11 + .3, p[2] = .77;
        double dx = (pm_noise(p[0] + h, p[1], p[2]) - pm_noise(p[0] - h, p[1], p[2])) / (2 * h);
        double dy = (pm_noise(p[0], p[1] + h, p[2]) - pm_noise(p[0], p[1] - h, p[2])) / (2 * h);
        double dz = (pm_noise(p[0], p[1], p[2] + h) - pm_noise(p[0], p[1], p[2] - h)) / (2 * h);
        bench_near(&b, "noise3x(Px, Py, Pz)", dx, .02);
        bench_near(&b, "noise3(Px, Py, Pz)*0 + noise3y(Px, Py, Pz)", dy, .02);
        bench_near(&b, "noise3z(Px, Py, Pz) + 0*noise3z(Py, Py, Pz)", dz, .02);
    }
    pm_language_free(b.language);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_has_the_values_of_radiance),
        cmocka_unit_test(noise_is_0_on_the_lattice),
        cmocka_unit_test(noise_is_continuous_and_repeats_after_256),
        cmocka_unit_test(fractal_noise_stays_between_its_bounds),
        cmocka_unit_test(noise_far_away_is_0),
        cmocka_unit_test(derivatives_follow_the_noise),
    };
    return cmocka_run_group_tests_name("language.noise", tests, NULL, NULL);
}
