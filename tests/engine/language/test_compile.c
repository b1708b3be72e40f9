#include "language_test.h"

static void functions_are_handed_on_by_name(void **state)
{
    (void)state;
    struct bench b = bench_of("twice(f, x) = f(f(x)); outer(g, x) = twice(g, x) + g(x);"
                              "add(x) = x + 1; apply(f, a, b) = f(a, b); three(f) = f(3);"
                              "pick(i) = select(i, Px, Py, Pz); sum(v) = v(1) + v(2) + v(3);");
    bench_near(&b, "twice(add, Px)", 3.3, ROUNDING);
    bench_near(&b, "outer(add, Px)", 5.6, ROUNDING);
    bench_near(&b, "outer(sq, Px)", pow(1.3, 4) + 1.69, ROUNDING);
    bench_near(&b, "outer(sqrt, Px)", pow(1.3, .25) + sqrt(1.3), ROUNDING);
    bench_near(&b, "apply(atan2, Px, Py)", atan2(1.3, -2.4), ROUNDING);
    bench_near(&b, "three(add) + three(sq)", 13, ROUNDING);
    bench_near(&b, "sum(pick)", -.4, ROUNDING);
    bench_near(&b, "dot(P, N)", 1.3 * .1 + 2.4 * .3 + .7 * .948, ROUNDING);
    pm_language_free(b.language);
}

static void what_is_not_there_is_refused_where_it_is_used(void **state)
{
    (void)state;
    static const struct {
        const char *text, *expression, *message;
    } rows[] = {
        {"a = 1 +\n  nothing;", "a",
         "f.cal:2:3: nothing is not defined; define it in this file or in one that is read "
         "before"},
        {"f(x) = x*g(x);", "f(2)",
         "f.cal:1:10: there is no function g; define it in this file or in one that is read "
         "before"},
        {"", "if(Px, 1, no)",
         "main.rad:3:15: no is not defined; define it in this file or in one that is read "
         "before"},
        {"", "sin", "main.rad:3:5: sin is a function: it needs its arguments, as in sin(x)"},
        {"f(x) = x;", "2*f",
         "main.rad:3:7: f is a function: it needs its arguments, as in f(x)"},
        {"", "2 + noop(sin)",
         "main.rad:3:14: sin is a function: it needs its arguments, as in sin(x)"},
        {"x = 1;", "x(2)",
         "main.rad:3:5: there is no function x; define it in this file or in one that is read "
         "before"},
        {"f(g) = g(1);", "f(3)",
         "f.cal:1:8: g is called here, but what is handed over for it is not the name of a "
         "function"},
        {"", "1 + dot(D, 3)",
         "main.rad:3:9: b is called here, but what is handed over for it is not the name of a "
         "function"},
        {"f(x, y) = x + y;", "f(1)", "main.rad:3:5: f needs 2 arguments and has 1"},
        {"", "atan2(Px)", "main.rad:3:5: atan2 needs 2 arguments and has 1"},
        {"", "if(Px, 2)", "main.rad:3:5: if needs 3 arguments and has 2"},
        {"", "bound(0, Px)", "main.rad:3:5: bound needs 3 arguments and has 2"},
        {"a = 1/arg(4);", "a", "f.cal:1:7: this needs real argument 4, and there are 0"},
        {"", "noise3(A1, 2, Px)",
         "main.rad:3:12: A1 needs a real argument that is not there; there are 0"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        bench_refuses(rows[i].text, rows[i].expression, rows[i].message);
}

static void what_is_not_reached_is_not_missed(void **state)
{
    (void)state;
    struct bench b = bench_of("unused = nothing + sin; f(x, y) = x; mode = if(AC - 1, A2, A1);"
                              "g(x) = nowhere(x);");
    bench_reals(&b, 1, (const double[]){4});
    bench_near(&b, "f(Px)", 1.3, 0);          /* the second argument is not asked for */
    bench_near(&b, "f(Px, 1, 2, 3)", 1.3, 0); /* nor are more */
    bench_near(&b, "mode", 4, 0);
    bench_near(&b, "if(1, 2, 3)", 2, 0);
    pm_language_free(b.language);
}

static void real_arguments_that_some_rays_need_are_a_fault(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    bench_reals(&b, 1, (const double[]){4});
    bench_near(&b, "if(Px, A1, A2)", 4, 0);
    assert_int_equal(b.faults, 0);
    bench_near(&b, "if(-Px, A1, A2) + 0", 0, 0);
    assert_int_equal(b.faults, PM_FAULT_REAL);
    pm_language_free(b.language);
}

static void functions_are_called_with_arguments(void **state)
{
    (void)state;
    struct bench b = bench_of("f(x, y) = x*Px - y; one(x) = 2*x; constant(x) = 7; v = 3;");
    pm_function f;
    const double args[2] = {10, 4};
    assert_int_equal(bench_compile(&b, "f", 2, false, &f), PM_OK);
    assert_true(pm_function_value(b.language, f, &b.ray, args, 2) == 10 * 1.3 - 4);
    assert_int_equal(bench_compile(&b, "one", 2, false, &f), PM_OK); /* one too many */
    assert_true(pm_function_value(b.language, f, &b.ray, args, 2) == 20);
    assert_int_equal(bench_compile(&b, "constant", 1, false, &f), PM_OK);
    assert_true(pm_function_value(b.language, f, NULL, args, 1) == 7);
    assert_int_equal(bench_compile(&b, "noop", 1, false, &f), PM_OK);
    assert_true(pm_function_value(b.language, f, NULL, args, 1) == 10);
    assert_int_equal(bench_compile(&b, "sqrt", 1, false, &f), PM_OK);
    assert_true(pm_function_value(b.language, f, NULL, args + 1, 1) == 2);
    assert_int_equal(bench_compile(&b, "max", 2, false, &f), PM_OK);
    assert_true(pm_function_value(b.language, f, NULL, args, 2) == 10);
    assert_int_equal(bench_compile(&b, "f", 1, false, &f), PM_E_SYNTAX);
    assert_string_equal(b.message, "main.rad:3:5: f needs 2 arguments and has 1");
    assert_int_equal(bench_compile(&b, "v", 1, false, &f), PM_E_MISSING);
    assert_int_equal(bench_compile(&b, "2*v", 1, false, &f), PM_E_SYNTAX);
    assert_string_equal(b.message,
                        "main.rad:3:6: a function is wanted here by its name, not an "
                        "expression");
    pm_language_free(b.language);
}

static void several_texts_make_one_function(void **state)
{
    (void)state;
    struct bench b = bench_of("common = noise3(Px, Py, Pz);");
    static const struct pm_language_text texts[3] = {
        {"common", "m", 1, 1}, {"2*common", "m", 1, 2}, {"Dx", "m", 1, 3}};
    const struct pm_function_request request = {
        .context = b.context, .texts = texts, .text_count = 3};
    pm_function f;
    double values[3];
    assert_int_equal(pm_language_compile(b.language, &request, &f, NULL), PM_OK);
    assert_int_equal(pm_function_values(b.language, f, &b.ray, NULL, 0, values), 0);
    assert_true(values[1] == 2 * values[0] && values[0] != 0 && values[2] == .36);
    assert_true(pm_function_value(b.language, f, &b.ray, NULL, 0) == values[0]);
    pm_language_free(b.language);
}

static void equal_requests_give_one_function(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    pm_function first, second, third, fourth;
    bench_reals(&b, 1, (const double[]){4});
    assert_int_equal(bench_compile(&b, "Px + 1", 0, true, &first), PM_OK);
    b.reals[0] = 5; /* does not matter to it */
    assert_int_equal(bench_compile(&b, "Px + 1", 0, true, &second), PM_OK);
    assert_int_equal(first, second);
    assert_int_equal(bench_compile(&b, "Px + A1", 0, true, &first), PM_OK);
    assert_int_equal(bench_compile(&b, "Px + A1", 0, true, &second), PM_OK);
    assert_int_equal(first, second);
    b.reals[0] = 6;
    assert_int_equal(bench_compile(&b, "Px + A1", 0, true, &third), PM_OK);
    assert_int_not_equal(first, third);
    assert_int_equal(bench_compile(&b, "Px + A1", 0, false, &fourth), PM_OK);
    assert_int_not_equal(third, fourth);
    assert_true(pm_function_value(b.language, first, &b.ray, NULL, 0) == 1.3 + 5);
    assert_true(pm_function_value(b.language, third, &b.ray, NULL, 0) == 1.3 + 6);
    pm_language_free(b.language);
}

static uint64_t uses(struct bench *b, const char *text)
{
    pm_function f;
    assert_int_equal(bench_compile(b, text, 0, true, &f), PM_OK);
    return pm_function_uses(b->language, f);
}

static void what_of_the_ray_is_used_is_told(void **state)
{
    (void)state;
    struct bench b = bench_of("a = Px + NxP; b = if(Dx, a, 0); f(x) = x*Rdot;"
                              "g(n) = if(n, g(n - 1), Tx);");
    assert_true(uses(&b, "3 + sin(2)") == 0);
    assert_true(uses(&b, "Px") == 1ull << PM_RAY_PX);
    assert_true(uses(&b, "b") == (1ull << PM_RAY_PX | 1ull << PM_RAY_NXP | 1ull << PM_RAY_DX));
    assert_true(uses(&b, "f(2)") == 1ull << PM_RAY_RDOT);
    assert_true(uses(&b, "g(Py)") == (1ull << PM_RAY_PY | 1ull << PM_RAY_TX));
    assert_true(uses(&b, "if(-1, NxP, 2)") == 0);
    assert_true(uses(&b, "b") & PM_RAY_OF_MATERIALS);
    assert_true(uses(&b, "CbP") & PM_RAY_OF_MATERIALS &&
                !(uses(&b, "Lv") & PM_RAY_OF_MATERIALS));
    assert_true(uses(&b, "DxA") & PM_RAY_OF_PRISMS && !(uses(&b, "DxA") & PM_RAY_OF_MATERIALS));
    pm_language_free(b.language);
}

static void too_many_functions_for_one_are_refused(void **state)
{
    (void)state;
    static char text[60000] = "r(h, n) = if(n, h(n) + r(h, n - 1), 0);\n", sum[60000];
    char *at = text + strlen(text), *term = sum;
    for (int i = 0; i < 1500; i++) {
        at += sprintf(at, "g%d(x) = x + %d;\n", i, i);
        term += sprintf(term, "%sr(g%d, Px)", i ? "+" : "", i);
    }
    bench_refuses(text, sum, "f.cal:1:1: r is called with more than 1000 different functions");
}

static void too_many_variables_are_refused(void **state)
{
    (void)state;
    static char text[600000], sum[200000];
    char *at = text, *term = sum;
    for (int i = 0; i < 9000; i++) {
        at += sprintf(at, "v%d = Px*%d;\n", i, i + 2);
        term += sprintf(term, "%sv%d", i ? "+" : "", i);
    }
    struct bench b = bench_of(text);
    pm_function f;
    assert_string_equal(b.message, "");
    assert_int_equal(bench_compile(&b, sum, 0, true, &f), PM_E_LIMIT);
    assert_non_null(strstr(b.message, "a function asks for more than 8192 variables"));
    pm_language_free(b.language);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_are_handed_on_by_name),
        cmocka_unit_test(what_is_not_there_is_refused_where_it_is_used),
        cmocka_unit_test(what_is_not_reached_is_not_missed),
        cmocka_unit_test(real_arguments_that_some_rays_need_are_a_fault),
        cmocka_unit_test(functions_are_called_with_arguments),
        cmocka_unit_test(several_texts_make_one_function),
        cmocka_unit_test(equal_requests_give_one_function),
        cmocka_unit_test(what_of_the_ray_is_used_is_told),
        cmocka_unit_test(too_many_functions_for_one_are_refused),
        cmocka_unit_test(too_many_variables_are_refused),
    };
    return cmocka_run_group_tests_name("language.compile", tests, NULL, NULL);
}
