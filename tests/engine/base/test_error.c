#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/error.h"

static void error_first_one_wins(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_error_set_at(&err, PM_E_SYNTAX, "a.rad", 3, 7, "bad %s", "word"),
                     PM_E_SYNTAX);
    assert_int_equal(pm_error_set(&err, PM_E_MEMORY, "later"), PM_E_MEMORY);
    char text[128];
    pm_error_format(&err, text, sizeof text);
    assert_string_equal(text, "a.rad:3:7: bad word");
    assert_int_equal(err.status, PM_E_SYNTAX);
}

static void error_formats_without_place(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    char text[16];
    pm_error_set_at(&err, PM_E_IO, "b.gpm", 0, 0, "cannot be read at all");
    pm_error_format(&err, text, sizeof text);
    assert_string_equal(text, "b.gpm: cannot b"); /* cut, and terminated */
    assert_int_equal(pm_error_set(NULL, PM_E_IO, "nobody listens"), PM_E_IO);
}

static void status_names_are_known(void **state)
{
    (void)state;
    assert_string_equal(pm_status_name(PM_OK), "ok");
    assert_string_equal(pm_status_name(PM_E_CANCELLED), "cancelled");
    assert_string_equal(pm_status_name((pm_status)999), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_first_one_wins),
        cmocka_unit_test(error_formats_without_place),
        cmocka_unit_test(status_names_are_known),
    };
    return cmocka_run_group_tests_name("base.error", tests, NULL, NULL);
}
