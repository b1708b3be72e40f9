#include "scene_test.h"

#include "base/rng.h"
#include "scene/names.h"

static pm_word word_of(const char *text)
{
    return (pm_word){.text = text, .length = strlen(text)};
}

static void a_name_means_its_latest_definition(void **state)
{
    (void)state;
    pm_arena arena = {0};
    pm_names names = {.arena = &arena};
    pm_word red = word_of("red"), re = word_of("re"), reds = word_of("reds"),
            none = word_of("");
    assert_int_equal(pm_names_find(&names, &red), -1);
    assert_int_equal(pm_names_set(&names, &red, 3), PM_OK);
    assert_int_equal(pm_names_find(&names, &re), -1);
    assert_int_equal(pm_names_find(&names, &reds), -1);
    assert_int_equal(pm_names_set(&names, &re, 4), PM_OK);
    assert_int_equal(pm_names_set(&names, &reds, 5), PM_OK);
    assert_int_equal(pm_names_set(&names, &none, 6), PM_OK);
    assert_int_equal(pm_names_find(&names, &red), 3);
    assert_int_equal(pm_names_set(&names, &red, 7), PM_OK);
    assert_int_equal(pm_names_find(&names, &red), 7);
    assert_int_equal(pm_names_find(&names, &re), 4);
    assert_int_equal(pm_names_find(&names, &reds), 5);
    assert_int_equal(pm_names_find(&names, &none), 6);
    pm_arena_clear(&arena);
}

/* 5,000 settings of names over a small alphabet, prefixes of each other, against a plain list.
 */
static void names_agree_with_a_list(void **state)
{
    (void)state;
    enum { SETTINGS = 5000 };
    static char texts[SETTINGS][8];
    pm_arena arena = {0};
    pm_names names = {.arena = &arena};
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (int i = 0; i < SETTINGS; i++) {
        int length = (int)(pm_rng_u32(&rng) % 7);
        for (int j = 0; j < length; j++)
            texts[i][j] = (char)("ab\xFF"[pm_rng_u32(&rng) % 3]);
        pm_word word = word_of(texts[i]);
        int32_t expected = -1;
        for (int j = 0; j < i; j++)
            expected = strcmp(texts[i], texts[j]) == 0 ? j : expected;
        assert_int_equal(pm_names_find(&names, &word), expected);
        assert_int_equal(pm_names_set(&names, &word, i), PM_OK);
        assert_int_equal(pm_names_find(&names, &word), i);
    }
    pm_arena_clear(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_name_means_its_latest_definition),
        cmocka_unit_test(names_agree_with_a_list),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
