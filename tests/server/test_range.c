#include "cmocka_first.h"

#include "range.h"

static void ranges_read_as_rfc_9110_says(void **state)
{
    (void)state;
    static const struct {
        const char *header;
        uint64_t size;
        pm_range range;
        uint64_t first, length;
    } cases[] = {
        {NULL, 10, PM_RANGE_ALL, 0, 10},
        {"bytes=0-0", 10, PM_RANGE_PART, 0, 1},
        {"bytes=2-5", 10, PM_RANGE_PART, 2, 4},
        {"Bytes=2-", 10, PM_RANGE_PART, 2, 8},
        {"bytes=2-99", 10, PM_RANGE_PART, 2, 8},
        {"bytes=9-9", 10, PM_RANGE_PART, 9, 1},
        {"bytes=-3", 10, PM_RANGE_PART, 7, 3},
        {"bytes=-99", 10, PM_RANGE_PART, 0, 10},
        {"bytes=10-", 10, PM_RANGE_NOWHERE, 0, 0},
        {"bytes=-0", 10, PM_RANGE_NOWHERE, 0, 0},
        {"bytes=0-", 0, PM_RANGE_NOWHERE, 0, 0},
        {"bytes=18446744073709551615-", 10, PM_RANGE_NOWHERE, 0, 0},
        {"bytes=99999999999999999999999-", 10, PM_RANGE_NOWHERE, 0, 0},
        /* What a server may pass over gives the whole. */
        {"bytes=5-2", 10, PM_RANGE_ALL, 0, 10},
        {"bytes=-", 10, PM_RANGE_ALL, 0, 10},
        {"bytes=0-1,3-4", 10, PM_RANGE_ALL, 0, 10},
        {"bytes= 1-2", 10, PM_RANGE_ALL, 0, 10},
        {"bytes=+1-2", 10, PM_RANGE_ALL, 0, 10},
        {"rows=1-2", 10, PM_RANGE_ALL, 0, 10},
        {"", 10, PM_RANGE_ALL, 0, 10},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint64_t first, length;
        assert_int_equal(pm_range_parse(cases[i].header, cases[i].size, &first, &length),
                         cases[i].range);
        if (cases[i].range == PM_RANGE_NOWHERE)
            continue;
        assert_int_equal(first, cases[i].first);
        assert_int_equal(length, cases[i].length);
    }
}

static void tags_match_whole_entries_of_a_list(void **state)
{
    (void)state;
    static const char tag[] = "\"abc\"";
    assert_true(pm_tag_listed("\"abc\"", tag));
    assert_true(pm_tag_listed("\"x\", \"abc\" ,\"y\"", tag));
    assert_true(pm_tag_listed("W/\"abc\"", tag));
    assert_true(pm_tag_listed("*", tag));
    assert_false(pm_tag_listed(NULL, tag));
    assert_false(pm_tag_listed("", tag));
    assert_false(pm_tag_listed("abc", tag));
    assert_false(pm_tag_listed("\"xabc\"", tag));
    assert_false(pm_tag_listed("x\"abc\"", tag));
    assert_false(pm_tag_listed("\"abc\"x", tag));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranges_read_as_rfc_9110_says),
        cmocka_unit_test(tags_match_whole_entries_of_a_list),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
