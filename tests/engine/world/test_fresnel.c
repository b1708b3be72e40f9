#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "numbers.h"
#include "world/fresnel.h"

static const double angles_deg[] = {0.001, 45, 80};

/* The equations in angles (Born and Wolf 1.5.2, eq. 21a): another form than the engine's. */
static double by_angles(double from, double to)
{
    double s = sin(from - to) / sin(from + to), p = tan(from - to) / tan(from + to);
    return (s * s + p * p) / 2;
}

static void dielectric_fresnel_equals_the_equations_in_angles(void **state)
{
    (void)state;
    const double index = 1.5;
    for (size_t i = 0; i < 3; i++) {
        double outside = angles_deg[i] * PM_PI / 180, inside = asin(sin(outside) / index),
               other;
        double wanted = by_angles(outside, inside);
        assert_near(pm_fresnel_dielectric(cos(outside), 1 / index, &other), wanted, 1e-8);
        assert_near(other, cos(inside), 1e-14);
        assert_near(pm_fresnel_dielectric(cos(inside), index, &other), wanted, 1e-8);
        assert_near(other, cos(outside), 1e-14);
    }
    double other; /* normal incidence: ((n - 1) / (n + 1))^2 */
    assert_near(pm_fresnel_dielectric(1, 1 / index, &other), .04, 1e-16);
}

static void brewsters_angle_reflects_one_polarisation(void **state)
{
    (void)state;
    double n = 1.7, angle = atan(n), other;
    double s = (n * n - 1) / (n * n + 1); /* amplitude of the perpendicular one there */
    assert_near(pm_fresnel_dielectric(cos(angle), 1 / n, &other), s * s / 2, 1e-15);
}

static void total_internal_reflection_is_exactly_one(void **state)
{
    (void)state;
    double critical = sqrt(1 - 1 / (1.5 * 1.5)), other;
    for (int i = 0; i < 1000; i++) {
        double cosine = critical * (1 - 1e-12) * i / 999;
        assert_true(pm_fresnel_dielectric(cosine, 1.5, &other) == 1);
        assert_true(other == 0);
    }
    assert_true(pm_fresnel_dielectric(critical * (1 + 1e-9), 1.5, &other) < 1);
    assert_true(other > 0);
}

static void equal_indices_do_not_reflect(void **state)
{
    (void)state;
    for (double cosine = 1; cosine > 1e-8; cosine *= .5) {
        double other;
        assert_near(pm_fresnel_dielectric(cosine, 1, &other), 0, 1e-15);
        assert_near(other, cosine, 1e-8 * cosine);
    }
}

/* Ray by ray: each order of reflection within the pane added up, each polarisation apart. */
static void pane_by_orders(double angle, double index, double a, double *reflected,
                           double *transmitted)
{
    double inner = asin(sin(angle) / index);
    double amplitude[2] = {sin(angle - inner) / sin(angle + inner),
                           tan(angle - inner) / tan(angle + inner)};
    double way = pow(a, 1 / cos(inner));
    *reflected = *transmitted = 0;
    for (int p = 0; p < 2; p++) {
        double r = amplitude[p] * amplitude[p], flux = 1 - r;
        *reflected += r / 2;
        for (int k = 0; k < 4000; k++) {
            flux *= way;
            *(k % 2 ? reflected : transmitted) += flux * (1 - r) / 2;
            flux *= r;
        }
    }
}

static void pane_equals_the_sum_over_orders(void **state)
{
    (void)state;
    const double transmissivities[] = {1, .96, .5, .01};
    for (size_t i = 0; i < 3; i++)
        for (size_t k = 0; k < 4; k++) {
            double angle = angles_deg[i] * PM_PI / 180, r, t;
            pane_by_orders(angle, 1.52, transmissivities[k], &r, &t);
            pm_pane pane = pm_pane_at(cos(angle), 1.52);
            assert_near(pm_pane_reflectance(&pane, transmissivities[k]), r, 1e-8);
            assert_near(pm_pane_transmittance(&pane, transmissivities[k]), t, 1e-8);
        }
}

/* Radiance's manual: transmissivity .96 is standard glass of 88 % transmittance. */
static void standard_glass_transmits_88_percent(void **state)
{
    (void)state;
    pm_pane pane = pm_pane_at(1, 1.52);
    assert_near(pm_pane_transmittance(&pane, .96), .88, .0015);
}

static void clear_pane_loses_nothing_at_any_angle(void **state)
{
    (void)state;
    for (double cosine = 1; cosine > 1e-300; cosine *= .7) {
        pm_pane pane = pm_pane_at(cosine, 1.52);
        double r = pm_pane_reflectance(&pane, 1), t = pm_pane_transmittance(&pane, 1);
        assert_near(r + t, 1, 1e-12);
        assert_true(r >= 0 && t >= 0);
    }
    pm_pane grazing = pm_pane_at(0, 1.52);
    assert_near(pm_pane_reflectance(&grazing, 1), 1, 0);
}

static void opaque_pane_reflects_at_its_face_alone(void **state)
{
    (void)state;
    pm_pane pane = pm_pane_at(1, 1.5);
    assert_near(pm_pane_reflectance(&pane, 0), .04, 1e-15);
    assert_near(pm_pane_transmittance(&pane, 0), 0, 0);
}

static void estimate_rises_from_nothing_to_all(void **state)
{
    (void)state;
    assert_near(pm_fresnel_estimate(1), 0, 1e-11);
    assert_near(pm_fresnel_estimate(0), 1, .003);
    for (int i = 0; i < 100; i++)
        assert_true(pm_fresnel_estimate(i / 100.) > pm_fresnel_estimate((i + 1) / 100.));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dielectric_fresnel_equals_the_equations_in_angles),
        cmocka_unit_test(brewsters_angle_reflects_one_polarisation),
        cmocka_unit_test(total_internal_reflection_is_exactly_one),
        cmocka_unit_test(equal_indices_do_not_reflect),
        cmocka_unit_test(pane_equals_the_sum_over_orders),
        cmocka_unit_test(standard_glass_transmits_88_percent),
        cmocka_unit_test(clear_pane_loses_nothing_at_any_angle),
        cmocka_unit_test(opaque_pane_reflects_at_its_face_alone),
        cmocka_unit_test(estimate_rises_from_nothing_to_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
