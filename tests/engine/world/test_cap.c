#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/warp.h"
#include "numbers.h"
#include "world/cap.h"

/* The integral by the midpoint rule in equal solid angles; the kink at the horizon leaves an
 * error of the order of a cell's solid angle times a cell's cosine, 1e-5. */
static double by_quadrature(double versine, pm_vec3 axis)
{
    enum { STEPS = 1000 };
    pm_frame frame = pm_frame_make(axis);
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        double u = (i / STEPS + .5) / STEPS, v = (i % STEPS + .5) / STEPS;
        pm_vec3 w = pm_frame_to_world(&frame, pm_warp_cone(u, v, versine));
        sum += fmax(w.z, 0);
    }
    return sum * 2 * PM_PI * versine / (STEPS * STEPS);
}

static void cap_projection_equals_quadrature(void **state)
{
    (void)state;
    const double halves_deg[] = {1, 30, 89, 90, 120, 170, 180};
    const double tilts_deg[] = {0, 40, 89, 95, 150};
    for (size_t i = 0; i < 7; i++)
        for (size_t k = 0; k < 5; k++) {
            double versine = pm_versine(halves_deg[i] * PM_PI / 180);
            double cosine = cos(tilts_deg[k] * PM_PI / 180);
            double wanted = by_quadrature(versine, polar(cosine, .3));
            assert_near(pm_cap_projected(versine, cosine), wanted, 2e-5 * versine);
        }
}

static void cap_projection_has_no_seams(void **state)
{
    (void)state;
    for (double versine = 1e-10; versine < 2; versine *= 1.3) {
        double sine = sqrt(fmin(versine, 1) * (2 - fmin(versine, 1)));
        double step = 1e-9 * sine;
        for (int side = -1; side <= 1; side += 2) {
            double below = pm_cap_projected(versine, side * sine - step);
            double above = pm_cap_projected(versine, side * sine + step);
            assert_near(above, below, 1e-6 * versine);
        }
    }
}

static void cap_of_a_hemisphere_is_pi(void **state)
{
    (void)state;
    assert_near(pm_cap_projected(1, 1), PM_PI, 1e-15);
    assert_near(pm_cap_projected(1, 0), PM_PI / 2, 1e-15);
    assert_near(pm_cap_projected(1, -1), 0, 0);
    assert_near(pm_cap_projected(2, .3), PM_PI, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cap_projection_equals_quadrature),
        cmocka_unit_test(cap_projection_has_no_seams),
        cmocka_unit_test(cap_of_a_hemisphere_is_pi),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
