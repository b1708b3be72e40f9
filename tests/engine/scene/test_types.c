#include "scene_test.h"

#include "scene/check.h"
#include "scene/types.h"

static pm_status find(const char *text, pm_primitive_type *type, pm_error *err)
{
    const pm_word word = {.text = text, .length = strlen(text), .line = 1, .column = 1};
    return pm_type_find(&word, "a.rad", type, err);
}

static void every_type_is_found_by_its_name(void **state)
{
    (void)state;
    for (int t = 0; t < PM_PRIMITIVE_TYPES; t++) {
        pm_primitive_type type = PM_PRIMITIVE_TYPES;
        assert_int_equal(find(pm_primitive_type_name((pm_primitive_type)t), &type, NULL),
                         PM_OK);
        assert_int_equal(type, t);
    }
}

/* The message "takes 5 reals: a b c d e" must name as many as the type takes, or those before
 * the reals of its functions. */
static void each_real_argument_has_a_name(void **state)
{
    (void)state;
    for (int t = 0; t < PM_PRIMITIVE_TYPES; t++) {
        const pm_type *type = pm_type_get((pm_primitive_type)t);
        size_t most = 0, names = type->real_names[0] != '\0';
        for (size_t n = 0; n < 32; n++)
            most = type->counts >> n & 1 ? n : most;
        for (const char *at = type->real_names; *at; at++)
            names += *at == ' ';
        assert_in_range(names, type->least > 1 ? 2 : most,
                        most > type->least ? most : type->least);
    }
    char last[8];
    pm_type_real_name(PM_PLASFUNC, 5, last, sizeof last);
    assert_string_equal(last, "A6");
    char name[32];
    pm_type_real_name(PM_TRANS, 6, name, sizeof name);
    assert_string_equal(name, "tspec");
    pm_type_real_name(PM_POLYGON, 7, name, sizeof name);
    assert_string_equal(name, "y of vertex 3");
}

static void a_typing_error_finds_the_closest_type(void **state)
{
    (void)state;
    static const char *const pairs[][2] = {
        {"plasic", "plastic"},       {"Metal", "metal"},   {"poligon", "polygon"},
        {"cylindr", "cylinder"},     {"sphear", "sphere"}, {"ligth", "light"},
        {"dielectrc", "dielectric"}, {"rings", "ring"},    {"sourse", "source"},
        {"antimater", "antimatter"}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        pm_error err = PM_ERROR_INIT;
        pm_primitive_type type;
        char expected[100];
        snprintf(expected, sizeof expected, "'%s' is no primitive type; did you mean %s?",
                 pairs[i][0], pairs[i][1]);
        assert_int_equal(find(pairs[i][0], &type, &err), PM_E_SYNTAX);
        assert_string_equal(err.text, expected);
    }
}

static void string_arguments_have_their_roles(void **state)
{
    (void)state;
    const pm_type *type = pm_type_get(PM_BRIGHTDATA);
    static const char with_two[] = {'f', 'd', 'c', 'e', 'e', 0, 0};
    for (size_t i = 0; i < sizeof with_two; i++)
        assert_int_equal(pm_type_string_role(type, i, 2), with_two[i]);
    assert_int_equal(pm_type_strings_least(type), 3);
    assert_true(pm_type_takes_transform(type));
    assert_int_equal(pm_type_string_role(pm_type_get(PM_ANTIMATTER), 7, 0), 'm');
    assert_int_equal(pm_type_strings_least(pm_type_get(PM_ANTIMATTER)), 1);
    assert_int_equal(pm_type_strings_least(pm_type_get(PM_ILLUM)), 0);
    assert_int_equal(pm_type_string_role(pm_type_get(PM_PLASDATA), 4, 2), 'f');
    assert_false(pm_type_takes_transform(pm_type_get(PM_POLYGON)));
}

/* The limits themselves are right; each list is a value that physics still allows. */
static void limiting_values_are_accepted(void **state)
{
    (void)state;
    static const struct {
        pm_primitive_type type;
        size_t count;
        double reals[8];
    } right[] = {
        {PM_PLASTIC, 5, {1, 1, 1, 1, 1}},
        {PM_METAL, 5, {0, 0, 0, 0, 0}},
        {PM_TRANS, 7, {1, 1, 1, 0, 0, 1, 1}},
        {PM_GLOW, 4, {0, 0, 0, -1}},
        {PM_SPOTLIGHT, 7, {1, 1, 1, 360, 1e-150, 0, 0}},
        {PM_GLASS, 4, {1, 1, 1, 1}},
        {PM_DIELECTRIC, 5, {1, 0, 1, 0.5, 0}},
        {PM_MIST, 7, {0, 1e6, 1, 0, 1, 1, -0.999}},
        {PM_SOURCE, 4, {0, 0, -1, 360}},
        {PM_RING, 8, {0, 0, 0, 0, 0, 1, 1, 0}},
        {PM_CONE, 8, {0, 0, 0, 0, 0, 1, 0, -1}},
        {PM_SPHERE, 4, {0, 0, 0, -1}},
    };
    for (size_t i = 0; i < sizeof right / sizeof *right; i++) {
        size_t index;
        assert_null(pm_check_reals(right[i].type, right[i].reals, right[i].count, &index));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_is_found_by_its_name),
        cmocka_unit_test(each_real_argument_has_a_name),
        cmocka_unit_test(a_typing_error_finds_the_closest_type),
        cmocka_unit_test(string_arguments_have_their_roles),
        cmocka_unit_test(limiting_values_are_accepted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
