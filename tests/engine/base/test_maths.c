#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "base/maths.h"

/* SLEEF promises 1.0 ULP; glibc's functions are within 1 ULP too, so the two differ by at most
 * 2 ULP (4 where the result is close to a power of two: ULP doubles there). */
static void near(double ours, double theirs)
{
    double ulp = nextafter(fabs(theirs), INFINITY) - fabs(theirs);
    assert_true(fabs(ours - theirs) <= 4 * ulp);
}

static void maths_agree_with_the_c_library(void **state)
{
    (void)state;
    for (int i = -4000; i <= 4000; i++) {
        double x = i * 0.00731;
        near(pm_sin(x), sin(x));
        near(pm_cos(x), cos(x));
        near(pm_tan(x), tan(x));
        near(pm_exp(x), exp(x));
        near(pm_atan2(x, 1.5), atan2(x, 1.5));
        near(pm_acos(x / 30), acos(x / 30));
        near(pm_asin(x / 30), asin(x / 30));
        near(pm_atan(x), atan(x));
        near(pm_erf(x), erf(x));
        if (x < 26) /* beyond, erfc is denormal */
            near(pm_erfc(x), erfc(x));
        if (x > 0) {
            near(pm_log(x), log(x));
            near(pm_log10(x), log10(x));
            near(pm_pow(x, 2.7), pow(x, 2.7));
        }
        double sine, cosine;
        pm_sincos(x, &sine, &cosine);
        near(sine, sin(x));
        near(cosine, cos(x));
    }
}

/* The very bits: a machine that gives others would trace other photons. */
static void maths_bits_are_pinned(void **state)
{
    (void)state;
    assert_true(pm_exp(1) == 0x1.5bf0a8b145769p+1);
    assert_true(pm_log(10) == 0x1.26bb1bbb55516p+1);
    assert_true(pm_sin(0.5) == 0x1.eaee8744b05fp-2);
    assert_true(pm_pow(2.5, 3.3) == 0x1.491876092afc1p+4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maths_agree_with_the_c_library),
        cmocka_unit_test(maths_bits_are_pinned),
    };
    return cmocka_run_group_tests_name("base.maths", tests, NULL, NULL);
}
