#include "cmocka_first.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "answer.h"

static const bool alone[PM_MAP_KINDS];

static pm_job nearest_job(void)
{
    return (pm_job){.kind = PM_JOB_RENDER, .wanted = {.estimator = PM_NEAREST}};
}

static void expect(uint64_t traced, uint64_t cached, bool joined, pm_cache expected)
{
    pm_job job = nearest_job();
    pm_answer answer = {0};
    answer.maps[PM_MAP_GLOBAL] =
        (pm_map_summary){.present = true, .paths_traced = traced, .paths_cached = cached};
    assert_int_equal(pm_cache_of(&job, &answer, PM_MAP_GLOBAL, joined), expected);
}

static void cache_words_follow_from_the_paths(void **state)
{
    (void)state;
    expect(0, 0, false, PM_CACHE_NONE); /* a file of the user, or an empty map */
    expect(5, 0, false, PM_CACHE_MISS);
    expect(0, 5, false, PM_CACHE_HIT);
    expect(0, 5, true, PM_CACHE_JOINED);
    expect(5, 5, false, PM_CACHE_EXTENDED);
    expect(5, 5, true, PM_CACHE_EXTENDED);
    expect(5, 0, true, PM_CACHE_MISS); /* the one it waited for died */
}

static const char *overall(const pm_map_summary maps[PM_MAP_KINDS],
                           const bool joined[PM_MAP_KINDS], char out[16])
{
    pm_job job = nearest_job();
    pm_answer answer = {.error = INFINITY};
    memcpy(answer.maps, maps, sizeof answer.maps);
    pm_json *json = pm_answer_json(&job, &answer, joined);
    assert_non_null(json);
    strcpy(out, pm_json_get_text(json, "cache", "?"));
    pm_json_free(json);
    return out;
}

static void a_job_hits_only_if_all_its_maps_do(void **state)
{
    (void)state;
    const pm_map_summary hit = {.present = true, .paths_cached = 1};
    const pm_map_summary miss = {.present = true, .paths_traced = 1};
    const pm_map_summary both = {.present = true, .paths_traced = 1, .paths_cached = 1};
    const pm_map_summary none = {0}, empty = {.present = true};
    const bool second[PM_MAP_KINDS] = {false, true, false};
    char word[16];
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){none, none, none}, alone, word),
                        "none");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){hit, hit, none}, alone, word),
                        "hit");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){miss, miss, none}, alone, word),
                        "miss");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){hit, miss, none}, alone, word),
                        "extended");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){miss, hit, none}, alone, word),
                        "extended");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){both, miss, none}, alone, word),
                        "extended");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){hit, hit, none}, second, word),
                        "joined");
    assert_string_equal(overall((pm_map_summary[PM_MAP_KINDS]){empty, hit, none}, alone, word),
                        "hit");
}

static void an_unknown_error_is_null_not_infinity(void **state)
{
    (void)state;
    pm_job job = nearest_job();
    pm_curve_point curve[] = {{1, 2, 1, INFINITY}, {2, 3, 2, .5}};
    pm_answer answer = {.error = INFINITY, .curve = curve, .curve_count = 2};
    pm_json *json = pm_answer_json(&job, &answer, alone);
    assert_int_equal(pm_json_type_of(pm_json_get(json, "error")), PM_JSON_NULL);
    const pm_json *points = pm_json_get(json, "curve");
    assert_int_equal(pm_json_type_of(pm_json_get(pm_json_at(points, 0), "error")),
                     PM_JSON_NULL);
    assert_true(pm_json_get_number(pm_json_at(points, 1), "error", 0) == .5);
    pm_json_free(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cache_words_follow_from_the_paths),
        cmocka_unit_test(a_job_hits_only_if_all_its_maps_do),
        cmocka_unit_test(an_unknown_error_is_null_not_infinity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
