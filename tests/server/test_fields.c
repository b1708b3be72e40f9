#include "cmocka_first.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fields.h"

static pm_json *parse(const char *text)
{
    pm_json *json = NULL;
    assert_int_equal(pm_json_parse(text, strlen(text), "test", &json, NULL), PM_OK);
    return json;
}

static void assert_refused(const pm_field *fields, const char *text, pm_status status,
                           const char *member)
{
    pm_error err = PM_ERROR_INIT;
    pm_json *json = parse(text);
    assert_int_equal(pm_fields_check(fields, json, &err), status);
    assert_string_equal(err.file, member);
    pm_json_free(json);
}

#define ID "\"0000000000000000000000000000000000000000000000000000000000000000\""

static void unknown_members_are_named(void **state)
{
    (void)state;
    assert_refused(pm_fields_job, "{\"kind\": \"map\", \"scene\": " ID ", \"sede\": 1}",
                   PM_E_UNSUPPORTED, "sede");
    assert_refused(pm_fields_job,
                   "{\"kind\": \"map\", \"scene\": " ID ", \"global\": {\"cuont\": 1}}",
                   PM_E_UNSUPPORTED, "global.cuont");
}

static void missing_members_are_named(void **state)
{
    (void)state;
    assert_refused(pm_fields_job, "{\"scene\": " ID "}", PM_E_MISSING, "kind");
    assert_refused(pm_fields_job, "{\"kind\": \"map\"}", PM_E_MISSING, "scene");
    assert_refused(pm_fields_job, "[]", PM_E_RANGE, "");
}

static void values_of_the_wrong_type_are_refused(void **state)
{
    (void)state;
    assert_refused(pm_fields_job, "{\"kind\": 1}", PM_E_RANGE, "kind");
    assert_refused(pm_fields_job, "{\"kind\": \"rander\"}", PM_E_RANGE, "kind");
    assert_refused(pm_fields_job, "{\"seed\": 1.5}", PM_E_RANGE, "seed");
    assert_refused(pm_fields_job, "{\"seed\": true}", PM_E_RANGE, "seed");
    assert_refused(pm_fields_job, "{\"time\": \"1\"}", PM_E_RANGE, "time");
    assert_refused(pm_fields_job, "{\"scene\": \"ABC\"}", PM_E_RANGE, "scene");
    assert_refused(pm_fields_job, "{\"formats\": []}", PM_E_RANGE, "formats");
    assert_refused(pm_fields_job, "{\"formats\": [\"exr\", \"exr\"]}", PM_E_RANGE, "formats");
    assert_refused(pm_fields_job, "{\"formats\": [\"gif\"]}", PM_E_RANGE, "formats");
    assert_refused(pm_fields_job, "{\"view\": {\"vp\": [1, 2]}}", PM_E_RANGE, "view.vp");
    assert_refused(pm_fields_job, "{\"view\": {\"vp\": [1, 2, \"3\"]}}", PM_E_RANGE, "view.vp");
    assert_refused(pm_fields_job, "{\"view\": 3}", PM_E_RANGE, "view");
    assert_refused(pm_fields_job, "{\"command\": \"a\\u0007b\"}", PM_E_RANGE, "command");
    assert_refused(pm_fields_job, "{\"global\": 3}", PM_E_RANGE, "global");
}

/* Every number of every table: its ends are allowed, what lies just beyond is not. */
static void check_ends(const pm_field *field)
{
    double above =
        field->type == PM_FIELD_INTEGER ? field->high + 1 : nextafter(field->high, INFINITY);
    double below =
        field->type == PM_FIELD_INTEGER ? field->low - 1 : nextafter(field->low, -INFINITY);
    assert_int_equal(pm_field_check_number(field, field->low, field->name, NULL), PM_OK);
    assert_int_equal(pm_field_check_number(field, field->high, field->name, NULL), PM_OK);
    assert_int_equal(pm_field_check_number(field, below, field->name, NULL), PM_E_RANGE);
    if (above > field->high) /* 2^53 + 1 is no double */
        assert_int_equal(pm_field_check_number(field, above, field->name, NULL), PM_E_RANGE);
    assert_int_equal(pm_field_check_number(field, NAN, field->name, NULL), PM_E_RANGE);
    assert_int_equal(pm_field_check_number(field, INFINITY, field->name, NULL), PM_E_RANGE);
}

static const pm_field *const tables[] = {pm_fields_job, pm_fields_scene, pm_fields_map,
                                         pm_fields_view};

static void ranges_hold_to_their_ends(void **state)
{
    (void)state;
    size_t checked = 0;
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        for (const pm_field *field = tables[i]; field->name; field++)
            if (field->type == PM_FIELD_INTEGER || field->type == PM_FIELD_NUMBER) {
                check_ends(field);
                checked++;
            }
    assert_true(checked >= 12);
}

static void every_default_passes_its_own_check(void **state)
{
    (void)state;
    size_t checked = 0;
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        for (const pm_field *field = tables[i]; field->name; field++) {
            if (!field->otherwise)
                continue;
            const pm_field alone[] = {*field, {.name = NULL}};
            char text[256];
            snprintf(text, sizeof text, "{\"%s\": %s}", field->name, field->otherwise);
            pm_json *json = parse(text);
            assert_int_equal(pm_fields_check(alone, json, NULL), PM_OK);
            pm_json_free(json);
            checked++;
        }
    assert_true(checked >= 10);
}

static void the_schema_holds_every_field(void **state)
{
    (void)state;
    pm_json *schema = pm_fields_schema(pm_fields_job);
    const pm_json *properties = pm_json_get(schema, "properties");
    for (const pm_field *field = pm_fields_job; field->name; field++) {
        const pm_json *property = pm_json_get(properties, field->name);
        assert_non_null(property);
        assert_true(*pm_json_get_text(property, "description", ""));
    }
    const pm_json *x = pm_json_get(properties, "x");
    assert_int_equal(pm_json_get_integer(x, "minimum", 0), 1);
    assert_int_equal(pm_json_get_integer(x, "maximum", 0), 16384);
    assert_int_equal(pm_json_get_integer(x, "default", 0), 512);
    assert_int_equal(pm_json_length(pm_json_get(schema, "required")), 2);
    assert_false(pm_json_get_bool(schema, "additionalProperties", true));
    pm_json_free(schema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unknown_members_are_named),
        cmocka_unit_test(missing_members_are_named),
        cmocka_unit_test(values_of_the_wrong_type_are_refused),
        cmocka_unit_test(ranges_hold_to_their_ends),
        cmocka_unit_test(every_default_passes_its_own_check),
        cmocka_unit_test(the_schema_holds_every_field),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
