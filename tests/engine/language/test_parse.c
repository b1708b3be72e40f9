#include "language_test.h"

struct row {
    const char *text;
    double value;
};

static void check(const char *definitions, const struct row *rows, size_t count)
{
    struct bench b = bench_of(definitions);
    assert_string_equal(b.message, "");
    for (size_t i = 0; i < count; i++)
        bench_near(&b, rows[i].text, rows[i].value, ROUNDING);
    pm_language_free(b.language);
}
#define CHECK(definitions, rows) check(definitions, rows, sizeof rows / sizeof *rows)

static void operators_bind_as_in_radiance(void **state)
{
    (void)state;
    static const struct row rows[] = {
        {"1+2*3", 7},       {"(1+2)*3", 9},   {"10-2-3", 5},
        {"100/10/5", 2},    {"2^3^2", 512}, /* to the right */
        {"-2^2", 4},                        /* the sign first */
        {"2^-1", .5},       {"-2^-2", .25},   {"2*3^2", 18},
        {"-x^2", 9},        {"x-+2", 1},      {"+x", 3},
        {"-(-x)", 3},       {"6/x*2", 4},     {"6/(x*2)", 1},
        {"1-x+4-x*2/6", 1}, {"x/4*x/3", .75}, {"x^2^x/x^7", 3}, /* x^(2^3) / x^7 */
    };
    CHECK("x = 3;", rows);
}

static void numbers_are_read_as_written(void **state)
{
    (void)state;
    static const struct row rows[] = {
        {"1", 1},      {"1.", 1},  {".5", .5},    {"1.5e3", 1500}, {"1.5E-3", .0015},
        {"2e+2", 200}, {"007", 7}, {"1.e2", 100}, {"5e0*x", 15},   {"0", 0},
    };
    CHECK("x=3;", rows);
}

static void white_space_and_comments_part_words(void **state)
{
    (void)state;
    static const struct row rows[] = {
        {" x\t+\n y ", 8}, {"x{ {nested} ; }+{}y", 8}, {"{a}{b} x", 3}, {"f ( x , y )", -2}};
    CHECK("{ first } x {x}={y} 3 ; ; y = 5\n;; f\n(a,\tb)\r\n=a-b", rows);
}

static void names_hold_letters_digits_dots_and_lines(void **state)
{
    (void)state;
    static const struct row rows[] = {{"a_1.b + A_1.B", 3}, {"x.", 4}};
    CHECK("a_1.b = 1; A_1.B = 2; x. = 4;", rows);
}

static void what_calexpr_simplifies_is_not_evaluated(void **state)
{
    (void)state;
    static const struct row rows[] = {
        {"0*undefined", 0}, {"undefined*0", 0}, {"0/undefined", 0}, {"0^undefined", 0},
        {"undefined^0", 1}, {"1^undefined", 1}, {"x^1", 3},
    };
    CHECK("x = 3;", rows);
}

static void mistakes_are_named_with_their_place(void **state)
{
    (void)state;
    static const struct {
        const char *text, *expression, *message;
    } rows[] = {
        {"a = 1 2;", "", "f.cal:1:7: '2' where an operator or ; should be"},
        {"a = ;", "", "f.cal:1:5: ';' where a number, a name or ( should be"},
        {"a = 1;\n b = (1 + 2;", "",
         "f.cal:2:12: ';' where an operator, or the ) of this parenthesis, should be"},
        {"a = - -1;", "", "f.cal:1:7: '-' where a number, a name or ( should be"},
        {"a = f();", "", "f.cal:1:7: ')' where a number, a name or ( should be"},
        {"f() = 1;", "", "f.cal:1:3: ')' where the name of an argument should be"},
        {"f(1) = 1;", "", "f.cal:1:3: '1' where the name of an argument should be"},
        {"f(a`b) = 1;", "", "f.cal:1:3: the name of an argument has no context"},
        {"f(a = 1;", "", "f.cal:1:5: '=' where a comma or the ) of the arguments should be"},
        {"f(a) 1;", "", "f.cal:1:6: '1' where = or : should be"},
        {"1 = a;", "", "f.cal:1:1: '1' where the name of a variable or function should be"},
        {"a + 1;", "", "f.cal:1:3: '+' where =, : or ( should be"},
        {"a = 1; { {} ", "", "f.cal:1:8: this comment has no end; } is missing"},
        {"a = 1 }", "", "f.cal:1:7: '}' where an operator or ; should be"},
        {"a = .;", "", "f.cal:1:5: a lone point; a number has a digit beside it"},
        {"a = 2e;", "", "f.cal:1:7: ';' where the digits of an exponent should be"},
        {"a = 1e999;", "", "f.cal:1:5: this number is too large"},
        {"a = $0;", "a", "f.cal:1:5: there is no channel of this number; a ray has $1 to $27"},
        {"b = $99999999999; a = $28;", "a",
         "f.cal:1:23: there is no channel of this number; a ray has $1 to $27"},
        {"$1 = 3;", "", "f.cal:1:1: there are no output channels here"},
        {"a = 1 / 0;", "", "f.cal:1:7: division by zero"},
        {"a = x\001;", "", "f.cal:1:6: character 1 where an operator or ; should be"},
        {"a =", "", "f.cal:1:4: the text ends where a number, a name or ( should be"},
        {"a : sqrt(-1);", "",
         "f.cal:1:5: this constant has no value: a function is asked outside its domain"},
        {"a : exp(1000);", "", "f.cal:1:5: this constant has no value: it is too large"},
        {"a : Dx; b = a;", "", "f.cal:1:13: a constant (:) cannot depend on the ray; write ="},
        {"f(x) : x*arg(1); b = f(2);", "",
         "f.cal:1:10: a constant (:) cannot depend on real arguments; write ="},
        {"g(n) : n + 1; a : g(T(0)); b = a;", "",
         "f.cal:1:21: a constant needs this, which is not defined yet"},
        {"f(x) : g(x); b = f(2); g(x) : x;", "",
         "f.cal:1:8: a constant needs this, which is not defined yet"},
        {"", "1 + ", "main.rad:3:9: the text ends where a number, a name or ( should be"},
        {"", "1;",
         "main.rad:3:6: ';' where an operator or the end of the expression should be"},
        {"", "\n  Dx +\n * 2", "main.rad:5:2: '*' where a number, a name or ( should be"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        bench_refuses(rows[i].text, rows[i].expression, rows[i].message);
}

/* `count` times `part` between `head` and `tail`. */
static void repeated(char *out, const char *head, const char *part, int count, const char *tail)
{
    out += sprintf(out, "%s", head);
    for (int i = 0; i < count; i++)
        out += sprintf(out, "%s", part);
    sprintf(out, "%s", tail);
}

static void nesting_is_bounded(void **state)
{
    (void)state;
    static char text[100000];
    static const char *const parts[] = {"(", "-(", "sin(", "2^", "1+(", "x*f("};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        repeated(text, "a = ", parts[i], 10000, "1");
        struct bench b = bench_of(text);
        assert_int_equal(b.status, PM_E_LIMIT);
        assert_non_null(strstr(b.message, "nested deeper than 400 levels"));
        pm_language_free(b.language);
    }
}

static void long_sums_are_not_deep(void **state)
{
    (void)state;
    static char text[300000];
    repeated(text, "a = 0", " + Dx*2 - 1", 20000, ";");
    struct bench b = bench_of(text);
    assert_string_equal(b.message, "");
    bench_near(&b, "a", 20000 * (.36 * 2 - 1), 1e-10);
    pm_language_free(b.language);
}

static void long_names_are_refused(void **state)
{
    (void)state;
    char text[400];
    repeated(text, "", "n", 127, " = 3;");
    struct bench b = bench_of(text);
    assert_string_equal(b.message, "");
    pm_language_free(b.language);
    repeated(text, "", "n", 128, " = 3;");
    bench_refuses(text, "", "f.cal:1:1: this name is longer than 127 characters");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(operators_bind_as_in_radiance),
        cmocka_unit_test(numbers_are_read_as_written),
        cmocka_unit_test(white_space_and_comments_part_words),
        cmocka_unit_test(names_hold_letters_digits_dots_and_lines),
        cmocka_unit_test(what_calexpr_simplifies_is_not_evaluated),
        cmocka_unit_test(mistakes_are_named_with_their_place),
        cmocka_unit_test(nesting_is_bounded),
        cmocka_unit_test(long_sums_are_not_deep),
        cmocka_unit_test(long_names_are_refused),
    };
    return cmocka_run_group_tests_name("language.parse", tests, NULL, NULL);
}
