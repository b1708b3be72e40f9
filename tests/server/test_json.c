#include "cmocka_first.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"

static pm_status parse(const char *text, pm_json **out, pm_error *err)
{
    return pm_json_parse(text, strlen(text), "body", out, err);
}

static void a_member_given_twice_is_refused_with_its_place(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_json *json = NULL;
    assert_int_equal(parse("{\"a\": 1,\n \"a\": 2}", &json, &err), PM_E_SYNTAX);
    assert_null(json);
    assert_int_equal(err.line, 2);
    assert_true(err.column > 0);
    assert_string_equal(err.file, "body");
}

static void numbers_beyond_double_and_half_documents_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"{\"a\": 1e999}",
                                      "{\"a\": NaN}",
                                      "{\"a\"",
                                      "",
                                      "{} {}",
                                      "{\"a\": \"\xff\"}",
                                      "{\"a\": 99999999999999999999}"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        pm_json *json = NULL;
        assert_int_equal(parse(bad[i], &json, NULL), PM_E_SYNTAX);
    }
}

static void every_cut_of_a_document_is_refused(void **state)
{
    (void)state;
    static const char text[] = "{\"kind\": \"map\", \"n\": [1, 2.5e3, true, null]}";
    for (size_t size = 0; size < strlen(text); size++) {
        pm_json *json = NULL;
        assert_int_equal(pm_json_parse(text, size, "body", &json, NULL), PM_E_SYNTAX);
    }
}

static void packing_fails_as_a_whole(void **state)
{
    (void)state;
    assert_null(pm_json_pack("{s:f}", "error", (double)INFINITY));
    assert_null(pm_json_pack("{s:o, s:i}", "a", (pm_json *)NULL, "b", 1));
    assert_null(pm_json_pack("{s:s}", "a", "\xff"));
    pm_json *json = pm_json_pack("{s:o}", "error", pm_json_finite(INFINITY));
    char *text = pm_json_text(json);
    assert_string_equal(text, "{\"error\":null}");
    free(text);
    pm_json_free(json);
}

static void quoting_keeps_utf8_and_marks_other_bytes(void **state)
{
    (void)state;
    pm_json *good = pm_json_quote("caf\xc3\xa9"), *bad = pm_json_quote("caf\xe9");
    assert_string_equal(pm_json_string(good), "caf\xc3\xa9");
    assert_string_equal(pm_json_string(bad), "caf?");
    pm_json_free(good);
    pm_json_free(bad);
}

static void getters_tell_missing_from_wrong_type(void **state)
{
    (void)state;
    pm_json *json = pm_json_pack("{s:s, s:i, s:f, s:b}", "t", "x", "i", 3, "f", 1.5, "b", 1);
    assert_string_equal(pm_json_get_text(json, "t", "-"), "x");
    assert_string_equal(pm_json_get_text(json, "i", "-"), "-");
    assert_int_equal(pm_json_get_integer(json, "f", -1), -1);
    assert_true(pm_json_get_number(json, "i", -1) == 3);
    assert_true(pm_json_get_bool(json, "b", false));
    assert_false(pm_json_get_bool(json, "i", false));
    assert_int_equal(pm_json_get_integer(NULL, "i", 9), 9);
    size_t names = 0;
    for (const char *name = NULL; (name = pm_json_next(json, name));)
        names++;
    assert_int_equal(names, 4);
    pm_json_free(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_member_given_twice_is_refused_with_its_place),
        cmocka_unit_test(numbers_beyond_double_and_half_documents_are_refused),
        cmocka_unit_test(every_cut_of_a_document_is_refused),
        cmocka_unit_test(packing_fails_as_a_whole),
        cmocka_unit_test(quoting_keeps_utf8_and_marks_other_bytes),
        cmocka_unit_test(getters_tell_missing_from_wrong_type),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
