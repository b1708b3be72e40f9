#include "language_test.h"

static void branches_that_are_not_taken_fault_nothing(void **state)
{
    (void)state;
    struct bench b = bench_of("zero = Px - 1.3; bad = 1/zero;");
    bench_near(&b, "if(Px, 3, bad)", 3, 0);
    assert_int_equal(b.faults, 0);
    bench_near(&b, "select(Px, 3, bad, log(zero))", 3, 0);
    assert_int_equal(b.faults, 0);
    bench_near(&b, "and(zero, bad) + or(Px, bad)", 1.3, 0);
    assert_int_equal(b.faults, 0);
    bench_near(&b, "if(zero, 3, bad)", 0, 0);
    assert_int_equal(b.faults, PM_FAULT_DIVISION);
    pm_language_free(b.language);
}

static void variables_keep_their_value_through_branches(void **state)
{
    (void)state;
    struct bench b =
        bench_of("v = Px*2 + noise3(Px, Py, Pz)*0; w = if(Dx, v, 0) + if(Dy, v, v);"
                 "x = if(-Dx, v, 1) + v;");
    bench_near(&b, "w + x", 2.6 * 3 + 1, ROUNDING);
    pm_language_free(b.language);
}

static void arguments_belong_to_their_call(void **state)
{
    (void)state;
    struct bench b =
        bench_of("f(a, b) = g(b, a) + a*a + b*b; g(a, b) = h(a - b, b + a*a) - a + b*b;"
                 "h(a, b) = if(a, a*b, b/(1 + a*a)) + a;");
    const double x = 1.3, y = -2.4;
    double a = y - x, c = x + y * y;
    double h = (a > 0 ? a * c : c / (1 + a * a)) + a;
    bench_near(&b, "f(Px, Py)", h - y + x * x + x * x + y * y, ROUNDING);
    a = x - y, c = y + x * x;
    h = (a > 0 ? a * c : c / (1 + a * a)) + a;
    bench_near(&b, "f(f(Px, Py)*0 + Py, Px)", h - x + y * y + x * x + y * y, ROUNDING);
    pm_language_free(b.language);
}

static void functions_of_many_arguments_are_called(void **state)
{
    (void)state;
    struct bench b = bench_of(
        "f(a, b, c, d, e, j, g, h, i) = if(a, a*a + b*b + c*c + d*d + e*e + j*j + g*g + h*h + "
        "i*i + r(a - 1, b, c, d, e, j, g, h, i), 0);"
        "r(a, b, c, d, e, j, g, h, i) = if(a, f(a, b, c, d, e, j, g, h, i + 1), 0);");
    bench_near(&b, "f(3 + 0*Px, 1, 2, 3, 4, 5, 6, 7, 8)",
               9 + 4 + 1 + 3 * (1 + 4 + 9 + 16 + 25 + 36 + 49) + 64 + 81 + 100, ROUNDING);
    pm_language_free(b.language);
}

static void sums_and_products_run_from_left_to_right(void **state)
{
    (void)state;
    struct bench b = bench_of("one = Px - .3;");
    bench_near(&b, "1e20*one + one - 1e20*one", 0, 0);
    bench_near(&b, "1e20*one - 1e20*one + one", 1, 1e-15);
    bench_near(&b, "2*one/4*3/one/one", 1.5, ROUNDING);
    bench_near(&b, "2 - one - one - one", -1, ROUNDING);
    bench_near(&b, "one/3/(2 - one)*6", 2, ROUNDING);
    bench_near(&b, "min(one, 2, 3)*max(4, one)", 4, ROUNDING);
    pm_language_free(b.language);
}

/* Whatever the ray: huge, infinite, not a number. */
static void values_are_always_finite(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    static const char *const texts[] = {"Px",
                                        "Px*Py",
                                        "Px - Px",
                                        "Px/Py",
                                        "sin(Px)",
                                        "noise3(Px, Py, Pz)",
                                        "fnoise3(Px, 1, 2)",
                                        "rand(Px)",
                                        "Px^Py",
                                        "select(Px, 1, 2)",
                                        "floor(Px)",
                                        "arg(Px)",
                                        "min(Px, Py)",
                                        "erf(Px)",
                                        "turbulence(Px, 1, 2, .1)",
                                        "mod(Px, Py)",
                                        "U + V",
                                        "if(Px, Py, Pz)",
                                        "atan2(Px, Py)",
                                        "-exp(Px)"};
    static const double values[] = {INFINITY, -INFINITY, NAN, 1e308, -1e308, 1e-320};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        pm_function f;
        assert_int_equal(bench_compile(&b, texts[i], 0, false, &f), PM_OK);
        for (int v = 0; v < 36; v++) {
            for (int k = 0; k < PM_RAY_VALUES; k++)
                b.ray.value[k] = values[k % 2 ? v % 6 : v / 6];
            assert_true(isfinite(pm_function_value(b.language, f, &b.ray, NULL, 0)));
        }
    }
    pm_language_free(b.language);
}

/* Programs of up to 64 variables and of more keep them in different places. */
static void few_and_many_variables_evaluate_alike(void **state)
{
    (void)state;
    static char text[100000], sum[20000];
    char *at = text, *term = sum;
    for (int i = 0; i < 3000; i++) {
        at += sprintf(at, "v%d = Px*%d;", i, i);
        term += sprintf(term, "%sv%d", i ? "+" : "", i);
        struct bench b = {0};
        if (i != 10 && i != 63 && i != 64 && i != 65 && i != 2999)
            continue;
        b = bench_of(text);
        bench_near(&b, sum, 1.3 * i * (i + 1) / 2, 1e-12);
        pm_language_free(b.language);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(branches_that_are_not_taken_fault_nothing),
        cmocka_unit_test(variables_keep_their_value_through_branches),
        cmocka_unit_test(arguments_belong_to_their_call),
        cmocka_unit_test(functions_of_many_arguments_are_called),
        cmocka_unit_test(sums_and_products_run_from_left_to_right),
        cmocka_unit_test(values_are_always_finite),
        cmocka_unit_test(few_and_many_variables_evaluate_alike),
    };
    return cmocka_run_group_tests_name("language.evaluate", tests, NULL, NULL);
}
