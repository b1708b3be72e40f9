#include "language_test.h"

#include <stdlib.h>

#include "../../support/failing_malloc.h"

static pm_status compile(pm_language *language, uint32_t context, pm_error *err)
{
    static const double reals[2] = {2, 3};
    static const struct pm_language_text texts[2] = {{"r(Px) + s", "m", 1, 1},
                                                     {"arg(Px) + A2 + v3", "m", 1, 1}};
    const struct pm_function_request request = {
        .context = context, .texts = texts, .text_count = 2, .reals = reals, .real_count = 2};
    pm_function f;
    double values[2];
    pm_status st = pm_language_compile(language, &request, &f, err);
    if (!st)
        assert_int_equal(pm_function_values(language, f, NULL, NULL, 0, values), 0);
    return st;
}

/* Enough names, nodes and constants for every array to grow. */
static pm_status everything(pm_error *err)
{
    static char text[40000] = "r(n) = if(n, twice(sq, n) + r(n - 1), 0); twice(f, x) = f(f(x));"
                              "v0 = Dx; s = min(v149, 1, 2); a : sin(1)*twice(sin, PI);";
    if (!strchr(text, '\n'))
        for (int i = 1; i < 150; i++)
            sprintf(text + strlen(text), "v%d = v%d*a/2\n;", i, i - 1);
    uint32_t context;
    pm_language *language = pm_language_new(PM_LANGUAGE_SCENE);
    if (!language)
        return pm_error_set(err, PM_E_MEMORY, "new");
    pm_status st = pm_language_read(language, "f.cal", text, strlen(text), &context, err);
    if (!st)
        st = compile(language, context, err);
    pm_language_free(language);
    return st;
}

/* Leaks show under the address sanitizer. */
static void every_failed_allocation_is_reported(void **state)
{
    (void)state;
    long n = 0;
    for (pm_status st = PM_E_MEMORY; st; n++) {
        pm_error err = PM_ERROR_INIT;
        until_failure = n;
        st = everything(&err);
        bool all_done = until_failure >= 0;
        until_failure = -1;
        assert_int_equal(st, all_done ? PM_OK : PM_E_MEMORY);
        assert_int_equal(err.status, st);
    }
    assert_in_range(n, 30, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_failed_allocation_is_reported)};
    return cmocka_run_group_tests_name("language.memory", tests, NULL, NULL);
}
