#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "caret.h"

static void assert_shown(const char *text, int line, int column, const char *expected)
{
    const pm_file file = {"a.rad", (const uint8_t *)text, strlen(text)};
    pm_error err = {.text = "wrong"};
    pm_caret_append(&err, &file, line, column);
    assert_string_equal(err.text, expected);
}

static void the_caret_stands_under_the_column(void **state)
{
    (void)state;
    assert_shown("one\ntwo words\n", 2, 5, "wrong\n    two words\n        ^");
    assert_shown("one\ntwo", 2, 1, "wrong\n    two\n    ^");
    assert_shown("one\n", 1, 4, "wrong\n    one\n       ^");
}

/* Two bytes, one place. */
static void characters_of_several_bytes_are_one_place(void **state)
{
    (void)state;
    assert_shown("t\xC3\xBCr x\n", 1, 6, "wrong\n    t\xC3\xBCr x\n        ^");
}

static void long_lines_are_cut_about_the_column(void **state)
{
    (void)state;
    char line[1001], expected[400];
    memset(line, 'a', 1000);
    line[1000] = '\0';
    line[499] = 'b';
    char shown[101];
    memset(shown, 'a', 100);
    shown[100] = '\0';
    shown[60] = 'b';
    snprintf(expected, sizeof expected, "wrong\n    %s\n    %60s^", shown, "");
    assert_shown(line, 1, 500, expected);
}

static void what_would_steer_a_terminal_is_blank(void **state)
{
    (void)state;
    assert_shown("\ta\x1B[2J b\r\n", 1, 2, "wrong\n     a [2J b \n     ^");
}

static void places_that_are_not_there_show_nothing(void **state)
{
    (void)state;
    assert_shown("one\n", 0, 0, "wrong");
    assert_shown("one\n", 3, 1, "wrong");
    assert_shown("one\n", 1, 9, "wrong");
    pm_error err = {.text = "wrong"};
    pm_caret_append(&err, NULL, 1, 1);
    assert_string_equal(err.text, "wrong");
    memset(err.text, 'x', sizeof err.text - 10);
    const pm_file file = {"a", (const uint8_t *)"a line\n", 7};
    pm_caret_append(&err, &file, 1, 1);
    assert_null(strchr(err.text, '^'));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_caret_stands_under_the_column),
        cmocka_unit_test(characters_of_several_bytes_are_one_place),
        cmocka_unit_test(long_lines_are_cut_about_the_column),
        cmocka_unit_test(what_would_steer_a_terminal_is_blank),
        cmocka_unit_test(places_that_are_not_there_show_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
