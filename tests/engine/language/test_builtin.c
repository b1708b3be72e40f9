#include "language_test.h"

struct row {
    const char *text;
    double value;
};

/* The engine's elementary functions are within 1 ULP, or 1.5, of the truth (test_maths.c). */
static void every_function_has_its_value(void **state)
{
    (void)state;
    struct bench b =
        bench_of("x = .3 + 0*Dx; y = -1.7 + Px - 1.3; big = 12345.678 + Px - 1.3;");
    const double x = .3;
    const struct row rows[] = {
        {"sqrt(x)", sqrt(x)},
        {"sin(x)", sin(x)},
        {"cos(x)", cos(x)},
        {"tan(x)", tan(x)},
        {"asin(x)", asin(x)},
        {"acos(x)", acos(x)},
        {"atan(y)", atan(-1.7)},
        {"atan2(y, x)", atan2(-1.7, x)},
        {"atan2(y, -x)", atan2(-1.7, -x)},
        {"exp(y)", exp(-1.7)},
        {"log(x)", log(x)},
        {"log10(x)", log10(x)},
        {"erf(x)", erf(x)},
        {"erfc(y)", erfc(-1.7)},
        {"floor(y)", -2},
        {"ceil(y)", -1},
        {"floor(x)", 0},
        {"ceil(x)", 1},
        {"x^y", pow(x, -1.7)},
        {"if(x, 1, 2)", 1},
        {"if(y, 1, 2)", 2},
        {"if(x - x, 1, 2)", 2}, /* truth is above zero */
        {"select(0, 5, 6, 7)", 3},
        {"select(1, 5, 6, 7)", 5},
        {"select(x + 2.4, 5, 6, 7)", 7}, /* rounded */
        {"select(x + .1, 5, 6, 7)", 3},
        {"min(x, y, 2)", -1.7},
        {"max(x, y, 2)", 2},
        {"max(y)", -1.7},
        {"min(4, 3, 2, 1, y, 7, 8, 9)", -1.7},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        bench_near(&b, rows[i].text, rows[i].value, ROUNDING);
    assert_int_equal(b.faults, 0);
    pm_language_free(b.language);
}

/* Of Radiance's own evaluator (calfunc.c built apart): numbers, not formulas. */
static void rand_has_the_values_of_radiance(void **state)
{
    (void)state;
    struct bench b = bench_of("one = Px - .3;");
    static const struct row rows[] = {{"rand(1.3*one)", 0.54355202369333711},
                                      {"rand(-2400*one)", 0.25638168367731851},
                                      {"rand(-12345*one)", 0.95622252929024398},
                                      {"rand(0*one)", 0.95447351649636403}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        bench_near(&b, rows[i].text, rows[i].value, 1e-9); /* 1e5/x loses five digits */
    pm_language_free(b.language);
}

static void functions_outside_their_domain_give_0_and_a_fault(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        unsigned fault;
    } rows[] = {
        {"1/zero", PM_FAULT_DIVISION},
        {"Dx*Dy/zero", PM_FAULT_DIVISION},
        {"sqrt(zero - 1)", PM_FAULT_DOMAIN},
        {"(zero - 1)^.5", PM_FAULT_DOMAIN},
        {"(zero - 1)^.3", PM_FAULT_DOMAIN},
        {"zero^(zero - 1)", PM_FAULT_RANGE},
        {"asin(zero + 2)", PM_FAULT_DOMAIN},
        {"acos(zero - 2)", PM_FAULT_DOMAIN},
        {"log(zero)", PM_FAULT_RANGE},
        {"log(zero - 1)", PM_FAULT_DOMAIN},
        {"log10(zero)", PM_FAULT_RANGE},
        {"exp(zero + 800)", PM_FAULT_RANGE},
        {"(zero + 1e200)^2", PM_FAULT_RANGE},
        {"(zero + 1e200)^3", PM_FAULT_RANGE},
        {"select(zero - 1, 1, 2)", PM_FAULT_DOMAIN},
        {"select(zero + 3, 1, 2)", PM_FAULT_DOMAIN},
        {"select(zero + 1e30, 1, 2)", PM_FAULT_DOMAIN},
        {"(zero + 1e200)*1e200", PM_FAULT_RANGE}, /* at the end of the evaluation */
        {"(zero + 1e200)*1e200*(zero)", PM_FAULT_RANGE},
        {"arg(zero + 3)", PM_FAULT_REAL},
        {"arg(zero + 1e300)", PM_FAULT_REAL},
    };
    struct bench b = bench_of("zero = Px - 1.3;");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double value = bench_value(&b, rows[i].text);
        if (value != 0 || b.faults != rows[i].fault)
            fail_msg("%s is %g with faults %u", rows[i].text, value, b.faults);
    }
    pm_language_free(b.language);
}

static void what_is_too_small_is_0_without_a_fault(void **state)
{
    (void)state;
    struct bench b = bench_of("zero = Px - 1.3;");
    bench_near(&b, "exp(zero - 1000)", 0, 0);
    bench_near(&b, "(zero + .1)^400", 0, 0);
    assert_int_equal(b.faults, 0);
    pm_language_free(b.language);
}

static void the_ray_is_named(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    static const char *const names[PM_RAY_VALUES] = {
        "Dx",    "Dy",  "Dz",  "Nx",  "Ny",  "Nz",  "Px", "Py",  "Pz",  "T",
        "Rdot",  "S",   "Tx",  "Ty",  "Tz",  "Ix",  "Iy", "Iz",  "Jx",  "Jy",
        "Jz",    "Kx",  "Ky",  "Kz",  "Ts",  "Lu",  "Lv", "NxP", "NyP", "NzP",
        "RdotP", "CrP", "CgP", "CbP", "DxA", "DyA", "DzA"};
    for (int i = 0; i < PM_RAY_VALUES; i++) {
        char channel[16];
        b.ray.value[i] = i + .25;
        bench_near(&b, names[i], i + .25, 0);
        snprintf(channel, sizeof channel, "$%d", i + 1);
        if (i <= PM_RAY_LV)
            bench_near(&b, channel, i + .25, 0);
    }
    pm_language_free(b.language);
}

static void real_arguments_are_counted_and_numbered(void **state)
{
    (void)state;
    struct bench b = bench_of("two = Px + .7;");
    bench_reals(&b, 11, (const double[]){10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110});
    bench_near(&b, "AC", 11, 0);
    bench_near(&b, "arg(0)", 11, 0);
    bench_near(&b, "arg(two - 3)", 11, 0);
    bench_near(&b, "A1 + A2*A10", 2010, 0);
    bench_near(&b, "arg(11)", 110, 0);
    bench_near(&b, "arg(two)", 20, 0);
    bench_near(&b, "arg(two + .4)", 20, 0);
    bench_near(&b, "arg(two + .6)", 30, 0);
    bench_near(&b, "arg(AC - 1)", 100, 0);
    pm_language_free(b.language);
}

static void generators_have_their_own_library(void **state)
{
    (void)state;
    pm_language *language = pm_language_new(PM_LANGUAGE_GENERATOR);
    static const char definitions[] = "X`SYS(s,t)=cos(2*PI*s)*r(t); r(u)=bezier(0,1,2,3,u);";
    static const struct pm_language_text text = {definitions, "-e", 0, 0};
    static const struct pm_language_text name = {"X`SYS", "-e", 0, 0};
    static const struct pm_language_text ray = {"Dx", "-e", 0, 0};
    pm_error err = PM_ERROR_INIT;
    pm_function function;
    assert_non_null(language);
    assert_int_equal(
        pm_language_define(language, PM_CONTEXT_GLOBAL, &text, sizeof definitions - 1, &err),
        PM_OK);
    struct pm_function_request request = {
        .context = PM_CONTEXT_GLOBAL, .texts = &name, .text_count = 1, .arg_count = 2};
    assert_int_equal(pm_language_compile(language, &request, &function, &err), PM_OK);
    const double at[2] = {.125, .5};
    double value = pm_function_value(language, function, NULL, at, 2);
    assert_true(fabs(value - sqrt(.5) * 1.5) < ROUNDING);
    request.texts = &ray;
    request.arg_count = 0;
    assert_int_equal(pm_language_compile(language, &request, &function, &err), PM_E_MISSING);
    pm_language_free(language);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_has_its_value),
        cmocka_unit_test(rand_has_the_values_of_radiance),
        cmocka_unit_test(functions_outside_their_domain_give_0_and_a_fault),
        cmocka_unit_test(what_is_too_small_is_0_without_a_fault),
        cmocka_unit_test(the_ray_is_named),
        cmocka_unit_test(real_arguments_are_counted_and_numbered),
        cmocka_unit_test(generators_have_their_own_library),
    };
    return cmocka_run_group_tests_name("language.builtin", tests, NULL, NULL);
}
