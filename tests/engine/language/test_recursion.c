#include "language_test.h"

static void recursion_that_always_needs_itself_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *expression, *message;
    } rows[] = {
        {"\nx = x + 1;", "x",
         "f.cal:2:1: x always needs itself, so its recursion has no end; put the recursion "
         "into "
         "a branch of an if"},
        {"x = y + 1;\n y = 2*x;", "x",
         "f.cal:1:1: x always needs itself, so its recursion has no end; put the recursion "
         "into "
         "a branch of an if"},
        {"f(a) = f(a + 1);", "f(Px)",
         "f.cal:1:1: f always needs itself, so its recursion has no end; put the recursion "
         "into "
         "a branch of an if"},
        {"f(a) = if(g(a), 1, 2); g(a) = f(a - 1);", "f(Px)",
         "f.cal:1:1: f always needs itself, so its recursion has no end; put the recursion "
         "into "
         "a branch of an if"},
        {"twice(h, a) = h(h(a)); f(a) = twice(f, a);", "f(Px)",
         "f.cal:1:1: twice always needs itself, so its recursion has no end; put the recursion "
         "into a branch of an if"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        bench_refuses(rows[i].text, rows[i].expression, rows[i].message);
}

static void recursion_whose_branches_never_end_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *expression, *message;
    } rows[] = {
        {"f(a) = if(a, f(a + 1), f(a - 1));", "f(Px)",
         "f.cal:1:1: the recursion of f has no end: it was followed 32000 levels deep"},
        {"\n f(a) = if(a, f(a + 1), 0);", "f(7)",
         "f.cal:2:2: the recursion of f has no end: it was followed 32000 levels deep"},
        {"", "turbulence(Px, Py, Pz, 0)",
         "main.rad:3:5: the recursion of turbulence has no end: it was followed 32000 levels "
         "deep"},
        {"f(n) = if(n, f(n - 1) + f(n - 1), 1);", "f(50)",
         "f.cal:1:1: f takes too long: it was followed through 1048576 steps"},
        {"f(n) : if(n, f(n - 1) + f(n - 1), 1); a = f(50);", "a",
         "f.cal:1:43: this constant takes too long, or f does not end"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        bench_refuses(rows[i].text, rows[i].expression, rows[i].message);
}

static void recursion_that_ends_has_its_value(void **state)
{
    (void)state;
    struct bench b = bench_of("factorial(n) = if(n - .5, n*factorial(n - 1), 1);"
                              "fib(n) = if(n - 1.5, fib(n - 1) + fib(n - 2), n);"
                              "even(n) = if(n - .5, odd(n - 1), 1);"
                              "odd(n) = if(n - .5, even(n - 1), 0);"
                              "sum(f, n) = if(n - .5, f(n) + sum(f, n - 1), 0);"
                              "square(i) = i*i;"
                              "three = 3 + 0*Px; x = if(Dx, y, 1); y = if(-Dx, x, 2);");
    bench_near(&b, "factorial(7*three/3)", 5040, 0);
    bench_near(&b, "factorial(5)", 120, 0);
    bench_near(&b, "fib(5*three)", 610, 0);
    bench_near(&b, "even(three) + 2*odd(three)", 2, 0);
    bench_near(&b, "sum(square, 10)", 385, 0);
    bench_near(&b, "sum(square, 10*three)", 9455, 0);
    bench_near(&b, "sum(sqrt, three)", 1 + sqrt(2) + sqrt(3), ROUNDING);
    bench_near(&b, "x", 2, 0);
    pm_language_free(b.language);
}

static void arguments_that_are_not_needed_may_be_endless(void **state)
{
    (void)state;
    struct bench b = bench_of("f(a, b) = if(a, 1, f(1, f(0, b)));"
                              "endless(n) = if(n, endless(n + 1), endless(n - 1));");
    bench_near(&b, "f(0*Px, 1)", 1, 0);
    bench_near(&b, "and(Py, endless(Px))", -2.4, ROUNDING);
    bench_near(&b, "if(Px, 3, endless(Px))", 3, 0);
    assert_int_equal(b.faults, 0);
    pm_language_free(b.language);
}

/* What only some rays meet is left to the evaluation, which ends and says so. */
static void recursion_too_deep_for_some_rays_gives_0_and_a_fault(void **state)
{
    (void)state;
    struct bench b = bench_of("down(n) = if(n, 1 + down(n - 1), 0);"
                              "wide(n) = if(n, wide(n - 1) + wide(n - 1), 1);"
                              "up(n) = if(n - 100, up(n + 1), n);");
    b.ray.value[PM_RAY_PX] = 1000;
    bench_near(&b, "down(Px)", 1000, 0);
    b.ray.value[PM_RAY_PX] = 1e9;
    bench_near(&b, "down(Px)", 0, 0);
    assert_int_equal(b.faults, PM_FAULT_DEPTH);
    bench_near(&b, "up(Px) + 7", 0, 0);
    assert_int_equal(b.faults, PM_FAULT_DEPTH);
    b.ray.value[PM_RAY_PX] = 60;
    bench_near(&b, "wide(Px)", 0, 0);
    assert_int_equal(b.faults, PM_FAULT_WORK);
    b.ray.value[PM_RAY_PX] = 5;
    bench_near(&b, "wide(Px)", 32, 0);
    assert_int_equal(b.faults, 0);
    pm_language_free(b.language);
}

static void definitions(char *out, int count, const char *format)
{
    for (int i = 1; i < count; i++)
        out += sprintf(out, format, i, i - 1, i - 1);
}

static void chains_of_variables_do_not_multiply(void **state)
{
    (void)state;
    static char text[10000] = "v0 = Px;";
    definitions(text + strlen(text), 60, "v%d = v%d + v%d;");
    struct bench b = bench_of(text);
    bench_near(&b, "v59", 1.3 * 0x1p59, ROUNDING);
    assert_int_equal(b.faults, 0);
    pm_language_free(b.language);
}

static void chains_of_functions_are_not_copied_out(void **state)
{
    (void)state;
    static char text[10000] = "f0(x) = x;";
    definitions(text + strlen(text), 12, "f%d(x) = f%d(x) + f%d(x + 1);");
    struct bench b = bench_of(text);
    bench_near(&b, "f11(Px)", 2048 * 1.3 + 11 * 1024, 1e-12);
    pm_language_free(b.language);
    strcpy(text, "f0(x) = x;");
    definitions(text + strlen(text), 40, "f%d(x) = f%d(x) + f%d(x + 1);");
    bench_refuses(text, "f39(Px)",
                  "f.cal:1:11: f1 takes too long: it was followed through 1048576 steps");
}

static void definitions_that_go_too_deep_are_refused(void **state)
{
    (void)state;
    static char text[4000000] = "v0 = Px;\n";
    definitions(text + strlen(text), 100000, "v%d = v%d + 1; {%d}\n");
    bench_refuses(text, "v99999",
                  "f.cal:97953:10: definitions use each other more than 4096 levels deep");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recursion_that_always_needs_itself_is_refused),
        cmocka_unit_test(recursion_whose_branches_never_end_is_refused),
        cmocka_unit_test(recursion_that_ends_has_its_value),
        cmocka_unit_test(arguments_that_are_not_needed_may_be_endless),
        cmocka_unit_test(recursion_too_deep_for_some_rays_gives_0_and_a_fault),
        cmocka_unit_test(chains_of_variables_do_not_multiply),
        cmocka_unit_test(chains_of_functions_are_not_copied_out),
        cmocka_unit_test(definitions_that_go_too_deep_are_refused),
    };
    return cmocka_run_group_tests_name("language.recursion", tests, NULL, NULL);
}
