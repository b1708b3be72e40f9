#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/maths.h"
#include "base/sobol.h"
#include "base/warp.h"

enum { N = 1 << 16 };

/* Means over a Sobol net of 2^16 points: the quadrature error of these smooth integrands is far
 * below 1e-3. Analytic moments: cosine <z> = 2/3, <z^2> = 1/2; sphere <z> = 0, <z^2> = 1/3;
 * disc <r^2> = 1/2; cone of versine v: <z> = 1 - v/2. */
static void warp_moments_are_analytic(void **state)
{
    (void)state;
    double cz = 0, cz2 = 0, sz = 0, sz2 = 0, dr2 = 0, kz = 0;
    const double versine = 0.3;
    for (uint32_t i = 0; i < N; i++) {
        double u = pm_sobol(i, 0, 1), v = pm_sobol(i, 1, 1);
        pm_vec3 c = pm_warp_cosine(u, v), s = pm_warp_sphere(u, v);
        pm_vec3 d = pm_warp_disc(u, v), k = pm_warp_cone(u, v, versine);
        assert_true(fabs(pm_vec3_length(c) - 1) < 1e-14 && c.z > 0);
        assert_true(fabs(pm_vec3_length(s) - 1) < 1e-14);
        assert_true(fabs(pm_vec3_length(k) - 1) < 1e-14 && k.z >= 1 - versine);
        cz += c.z / N;
        cz2 += c.z * c.z / N;
        sz += s.z / N;
        sz2 += s.z * s.z / N;
        dr2 += (d.x * d.x + d.y * d.y) / N;
        kz += k.z / N;
    }
    assert_true(fabs(cz - 2.0 / 3) < 1e-3);
    assert_true(fabs(cz2 - 0.5) < 1e-3);
    assert_true(fabs(sz) < 1e-3);
    assert_true(fabs(sz2 - 1.0 / 3) < 1e-3);
    assert_true(fabs(dr2 - 0.5) < 1e-3);
    assert_true(fabs(kz - (1 - versine / 2)) < 1e-3);
}

/* The inverse of sin and atan leaves a few roundings, of the cone's width. */
static void disc_and_cap_are_inverted(void **state)
{
    (void)state;
    static const double versines[] = {2, 1.5, 1, 1e-3, 1e-12};
    for (uint32_t i = 0; i < N; i++) {
        double u = pm_sobol(i, 0, 1), v = pm_sobol(i, 1, 1), x, y;
        pm_vec3 d = pm_warp_disc(u, v);
        pm_warp_disc_inverse(d.x, d.y, &x, &y);
        assert_true(fabs(x - u) < 1e-14 && fabs(y - v) < 1e-14 && x < 1 && y < 1);
        double versine = versines[i % 5];
        pm_vec3 w = pm_warp_cap(u, v, versine);
        assert_true(fabs(pm_vec3_length(w) - 1) < 1e-14 && w.z >= 1 - versine - 1e-15);
        pm_warp_cap_inverse(w, versine, &x, &y);
        pm_vec3 again = pm_warp_cap(x, y, versine);
        assert_true(pm_vec3_distance(w, again) < 1e-13 * sqrt(versine) + 1e-16);
    }
}

static void versine_keeps_its_precision_for_the_smallest_angles(void **state)
{
    (void)state;
    const double angle = 1e-9; /* 1 - cos = angle^2 / 2 to 1e-18 relative */
    assert_true(fabs(pm_versine(angle) / (angle * angle / 2) - 1) < 1e-15);
    assert_true(fabs(pm_versine(PM_PI) - 2) < 1e-15);
}

static void frame_is_orthonormal_and_right_handed(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        pm_vec3 n = pm_warp_sphere(pm_sobol(i, 0, 3), pm_sobol(i, 1, 3));
        if (i == 0)
            n = pm_vec3_make(0, 0, -1);
        pm_frame f = pm_frame_make(n);
        assert_true(fabs(pm_vec3_dot(f.x, f.y)) < 1e-14 && fabs(pm_vec3_dot(f.x, n)) < 1e-14);
        assert_true(fabs(pm_vec3_length(f.x) - 1) < 1e-14);
        assert_true(pm_vec3_distance(pm_vec3_cross(f.x, f.y), n) < 1e-14);
        pm_vec3 v = {0.1, -0.7, 0.4};
        assert_true(pm_vec3_distance(pm_frame_to_world(&f, pm_frame_to_local(&f, v)), v) <
                    1e-14);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(warp_moments_are_analytic),
        cmocka_unit_test(disc_and_cap_are_inverted),
        cmocka_unit_test(versine_keeps_its_precision_for_the_smallest_angles),
        cmocka_unit_test(frame_is_orthonormal_and_right_handed),
    };
    return cmocka_run_group_tests_name("base.warp", tests, NULL, NULL);
}
