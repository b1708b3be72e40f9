#include "language_test.h"

static void check(const char *definitions, const char *text, double value)
{
    struct bench b = bench_of(definitions);
    assert_string_equal(b.message, "");
    bench_near(&b, text, value, ROUNDING);
    pm_language_free(b.language);
}

static void the_last_definition_counts(void **state)
{
    (void)state;
    check("a = 1; a = 2;", "a", 2);
    check("a : 1; a = 2;", "a", 2); /* caldefn.c hides the constant, it does not keep it */
    check("f(x) = x; f(x, y) = x*y;", "f(3, 4)", 12);
    check("f(x) = x; f = 7;", "f", 7);
}

static void uses_are_bound_when_they_are_read(void **state)
{
    (void)state;
    check("a = 1; b = a; a = 2;", "b", 2); /* variables late, */
    check("a : 1; b = a; a : 2;", "b", 1); /* constants at once, */
    check("a : 1; b = a; a : 2;", "a", 2);
    check("f(x) : x; b = f(5); f(x) : 2*x;", "b", 5); /* and constant calls too */
    check("f(x) : x; b = f(Dx); f(x) : 2*x;", "b", .72);
    check("b = sq(Px); sq(x) = 7;", "b", 1.69); /* to rayinit's, which is there already */
    check("sq(x) = 7; b = sq(Px);", "b", 7);
    check("b = c; c = 4;", "b", 4);
}

static void a_file_is_a_context(void **state)
{
    (void)state;
    struct bench b = bench_of("a = 1; PI : 3; b = PI; floor(x) = 99; c = floor(2.5);");
    bench_near(&b, "a + b", 4, 0);
    bench_near(&b, "c", 99, 0);
    bench_near(&b, "PI`", acos(-1), ROUNDING); /* a mark behind: the global one */
    bench_near(&b, "`a", 1, 0);                /* in front: the file's alone */
    bench_near(&b, "a`f", 1, 0);
    bench_read(&b, "g.cal", "a = 2; d = a`f + a; `e = 5; h`f = 6; k` = 8;");
    bench_near(&b, "a + d", 5, 0);
    bench_near(&b, "floor(2.5)", 2, 0);
    bench_near(&b, "`e", 5, 0);
    bench_near(&b, "h`f`g", 6, 0);
    bench_near(&b, "a`f", 1, 0);
    b.context = PM_CONTEXT_GLOBAL;
    bench_near(&b, "k", 8, 0);
    bench_near(&b, "a`g", 2, 0);
    pm_language_free(b.language);
}

static void explicit_names_do_not_search_outside(void **state)
{
    (void)state;
    bench_refuses("a = `PI;", "a",
                  "f.cal:1:5: PI is not defined; define it in this file or in one that is read "
                  "before");
    bench_refuses("x = 3; a = x`;", "a",
                  "f.cal:1:12: x is not defined; define it in this file or in one that is read "
                  "before");
}

static void files_of_like_names_stay_apart(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    uint32_t again;
    bench_read(&b, "dir/x.cal", "v = 1;");
    uint32_t first = b.context;
    bench_read(&b, "dir_x.cal", "v = 2;");
    assert_int_not_equal(first, b.context);
    bench_near(&b, "v", 2, 0);
    bench_read(&b, "dir/x.cal", "this is not read again");
    assert_int_equal(b.context, first);
    bench_near(&b, "v", 1, 0);
    assert_true(pm_language_find(b.language, "dir_x.cal", &again));
    assert_false(pm_language_find(b.language, "x.cal", &again));
    assert_true(pm_language_find(b.language, ".", &again));
    assert_int_equal(again, PM_CONTEXT_GLOBAL);
    pm_language_free(b.language);
}

static void a_file_that_is_refused_leaves_no_context(void **state)
{
    (void)state;
    struct bench b = bench_of("");
    uint32_t context = b.context, found;
    bench_read(&b, "g.cal", "a = ");
    assert_int_equal(b.status, PM_E_SYNTAX);
    assert_int_equal(b.context, context);
    assert_false(pm_language_find(b.language, "g.cal", &found));
    pm_language_free(b.language);
}

static void meanings_are_told(void **state)
{
    (void)state;
    struct bench b = bench_of("a = 1; f(x, y) = x; sin = 3; cos(a, b, c) = 1;");
    unsigned n = 99;
    assert_int_equal(pm_language_meaning(b.language, b.context, "a", &n), PM_MEANS_VARIABLE);
    assert_int_equal(pm_language_meaning(b.language, b.context, "sin", &n), PM_MEANS_VARIABLE);
    assert_int_equal(pm_language_meaning(b.language, b.context, "no", &n), PM_MEANS_NOTHING);
    assert_int_equal(n, 99);
    assert_int_equal(pm_language_meaning(b.language, b.context, "f", &n), PM_MEANS_FUNCTION);
    assert_int_equal(n, 2);
    assert_int_equal(pm_language_meaning(b.language, b.context, "cos", &n), PM_MEANS_FUNCTION);
    assert_int_equal(n, 3);
    assert_int_equal(pm_language_meaning(b.language, b.context, "if", &n), PM_MEANS_FUNCTION);
    assert_int_equal(n, 3);
    pm_language_free(b.language);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_last_definition_counts),
        cmocka_unit_test(uses_are_bound_when_they_are_read),
        cmocka_unit_test(a_file_is_a_context),
        cmocka_unit_test(explicit_names_do_not_search_outside),
        cmocka_unit_test(files_of_like_names_stay_apart),
        cmocka_unit_test(a_file_that_is_refused_leaves_no_context),
        cmocka_unit_test(meanings_are_told),
    };
    return cmocka_run_group_tests_name("language.names", tests, NULL, NULL);
}
