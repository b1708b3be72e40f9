#include "cmocka_first.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "request.h"

#define ID   "0000000000000000000000000000000000000000000000000000000000000000"
#define HEAD "{\"scene\": \"" ID "\", \"kind\": "

static pm_status parse(const char *text, pm_request *out, pm_error *err)
{
    return pm_request_parse(text, strlen(text), out, err);
}

static void assert_refused(const char *text, const char *member)
{
    pm_error err = PM_ERROR_INIT;
    pm_request request;
    assert_int_not_equal(parse(text, &request, &err), PM_OK);
    assert_string_equal(err.file, member);
    assert_true(*err.text);
}

static void a_render_has_its_defaults(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"render\"}", &request, NULL), PM_OK);
    assert_int_equal(request.job.kind, PM_JOB_RENDER);
    assert_int_equal(request.job.wanted.estimator, PM_PROGRESSIVE);
    assert_int_equal(request.job.wanted.ambient_bounces, 1);
    assert_int_equal(request.job.width, 512);
    assert_int_equal(request.job.height, 512);
    assert_int_equal(request.job.forward.max_events, 5000);
    assert_int_equal(request.formats, 1U << PM_FORMAT_EXR);
    assert_true(request.job.view.horizontal == 45);
    assert_string_equal(request.scene, ID);
    pm_request_clear(&request);
}

static void a_view_means_the_same_as_members_and_as_text(void **state)
{
    (void)state;
    pm_request a, b;
    assert_int_equal(parse(HEAD
                           "\"render\", \"view\": {\"vp\": [1, 2, 3.5], \"vd\": [0, 0, -1], "
                           "\"vu\": [0, 1, 0], \"vh\": 60, \"vv\": 30}}",
                           &a, NULL),
                     PM_OK);
    assert_int_equal(
        parse(HEAD
              "\"render\", \"view\": \"-vtv -vp 1 2 3.5 -vd 0 0 -1 -vu 0 1 0 -vh 60 -vv 30\"}",
              &b, NULL),
        PM_OK);
    assert_memory_equal(&a.job.view, &b.job.view, sizeof a.job.view);
    assert_int_equal(a.job.width, b.job.width);
    assert_int_equal(a.job.height, b.job.height);
    assert_true(a.job.height < a.job.width); /* pixels are square */
    pm_request_clear(&a);
    pm_request_clear(&b);
}

static void pixels_need_not_be_square(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"render\", \"view\": {\"vh\": 60, \"vv\": 30}, \"x\": 100, "
                                "\"y\": 128, \"pa\": 0}",
                           &request, NULL),
                     PM_OK);
    assert_int_equal(request.job.width, 100);
    assert_int_equal(request.job.height, 128);
    pm_request_clear(&request);
}

static void naming_a_map_makes_a_job_of_nearest_photons(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"render\", \"caustic\": {\"count\": 5000, \"gather\": 60, "
                                "\"gather_max\": 600, \"bandwidth\": \"chi2\"}, "
                                "\"global\": {\"map\": \"" ID "\"}, \"ab\": -1, \"seed\": 7}",
                           &request, NULL),
                     PM_OK);
    const pm_wanted *wanted = &request.job.wanted;
    assert_int_equal(wanted->estimator, PM_NEAREST);
    assert_true(wanted->maps[PM_MAP_CAUSTIC].wanted);
    assert_int_equal(wanted->maps[PM_MAP_CAUSTIC].count, 5000);
    assert_int_equal(wanted->maps[PM_MAP_CAUSTIC].gather_count, 60);
    assert_int_equal(wanted->maps[PM_MAP_CAUSTIC].gather_max, 600);
    assert_int_equal(wanted->maps[PM_MAP_CAUSTIC].bandwidth, PM_BANDWIDTH_CHI2);
    assert_true(request.has_map_file[PM_MAP_GLOBAL]);
    assert_false(request.has_map_file[PM_MAP_CAUSTIC]);
    assert_false(wanted->maps[PM_MAP_VOLUME].wanted);
    assert_int_equal(wanted->ambient_bounces, -1);
    assert_int_equal(request.job.forward.seed, 7);
    pm_request_clear(&request);
}

static void a_precomputed_map_stands_in_for_the_global_one(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"map\", \"precomputed\": {\"count\": 5000, \"gather\": 60, "
                                "\"fraction\": 0.5}}",
                           &request, NULL),
                     PM_OK);
    const pm_map_wanted *wanted = &request.job.wanted.maps[PM_MAP_GLOBAL];
    assert_true(wanted->wanted && wanted->precomputed && wanted->fraction == .5);
    assert_int_equal(wanted->gather_count, 60);
    pm_request_clear(&request);
    assert_int_equal(
        parse(HEAD "\"render\", \"precomputed\": {\"map\": \"" ID "\"}}", &request, NULL),
        PM_OK);
    assert_true(request.job.wanted.maps[PM_MAP_GLOBAL].precomputed);
    assert_true(request.has_map_file[PM_MAP_GLOBAL]);
    pm_request_clear(&request);
}

static void contradictions_name_their_member(void **state)
{
    (void)state;
    assert_refused(HEAD "\"map\"}", "kind");
    assert_refused(HEAD "\"map\", \"global\": {\"map\": \"" ID "\"}}", "global");
    assert_refused(HEAD "\"map\", \"global\": {\"count\": 5, \"gather\": 5}}", "global");
    assert_refused(HEAD "\"map\", \"global\": {\"count\": 5, \"gather_max\": 50}}", "global");
    assert_refused(HEAD "\"render\", \"global\": {\"count\": 5, \"gather_max\": 40}}",
                   "global");
    assert_refused(HEAD "\"render\", \"global\": {\"count\": 5, \"bandwidth\": \"chi2\"}}",
                   "global");
    assert_refused(HEAD "\"render\", \"global\": {\"count\": 5, \"gather\": 50, "
                        "\"gather_max\": 500, \"bandwidth\": \"wide\"}}",
                   "global.bandwidth");
    assert_refused(HEAD "\"map\", \"precomputed\": {\"count\": 30}}", "precomputed");
    assert_refused(HEAD "\"map\", \"precomputed\": {\"count\": 50, \"gather\": 51}}",
                   "precomputed");
    assert_refused(HEAD "\"map\", \"precomputed\": {\"count\": 50, \"fraction\": 0}}",
                   "precomputed.fraction");
    assert_refused(HEAD "\"map\", \"precomputed\": {\"count\": 50, \"fraction\": 1.1}}",
                   "precomputed.fraction");
    assert_refused(HEAD "\"map\", \"precomputed\": {\"count\": 50}, \"global\": "
                        "{\"count\": 50}}",
                   "precomputed");
    assert_refused(HEAD "\"render\", \"precomputed\": {\"map\": \"" ID "\", \"gather\": 5}}",
                   "precomputed");
    assert_refused(HEAD "\"render\", \"global\": {}}", "global");
    assert_refused(HEAD "\"render\", \"volume\": {\"count\": 5, \"map\": \"" ID "\"}}",
                   "volume");
    assert_refused(HEAD "\"trace\"}", "points");
    assert_refused(HEAD "\"render\", \"view\": {\"vd\": [0, 0, 0]}}", "view");
    assert_refused(HEAD "\"render\", \"view\": {}, \"fields\": \"L\"}", "fields");
    assert_refused(HEAD "\"trace\", \"points\": \"" ID "\", \"fields\": \"Lt\"}", "fields");
    assert_refused(HEAD "\"render\", \"view\": \"-vtx\"}", "view");
    assert_refused(HEAD "\"render\", \"view\": {\"vh\": 180}}", "view");
    assert_refused(HEAD "\"render\", \"view\": {\"vt\": \"h\", \"vh\": 181}}", "view");
    assert_refused("{\"kind\": \"render\"}", "scene");
    assert_refused("{\"kind\": ", "body");
}

static void what_is_stored_where_is_read(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"map\", \"global\": {\"count\": 5}, \"max_length\": 2.5, "
                                "\"sensors\": [\"plane\"], \"exclude\": [\"a\", \"b\"], "
                                "\"regions\": [{\"box\": [0, 1, 2, 3, 4, 5]}, "
                                "{\"sphere\": [1, 2, 3, 4]}]}",
                           &request, NULL),
                     PM_OK);
    const pm_forward_options *forward = &request.job.forward;
    assert_true(forward->max_length == 2.5);
    assert_int_equal(forward->sensors.count, 1);
    assert_string_equal(forward->sensors.names[0], "plane");
    assert_int_equal(forward->exclude.count, 2);
    assert_string_equal(forward->exclude.names[1], "b");
    assert_int_equal(forward->include.count, 0);
    assert_int_equal(forward->region_count, 2);
    assert_true(!forward->regions[0].is_ball && forward->regions[0].high.z == 5);
    assert_true(forward->regions[1].is_ball && forward->regions[1].radius == 4);
    pm_request_clear(&request);
}

static void surroundings_are_read(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"render\", \"back_faces\": false, \"medium\": "
                                "{\"extinction\": [1, 2, 3], \"albedo\": [0.5, 0.25, 1], "
                                "\"g\": -0.5}}",
                           &request, NULL),
                     PM_OK);
    const pm_surroundings *s = &request.job.surroundings;
    assert_true(s->no_back_faces);
    assert_true(s->extinction.g == 2 && s->albedo.g == .25 && s->eccentricity == -.5);
    pm_request_clear(&request);
    assert_int_equal(parse(HEAD "\"render\"}", &request, NULL), PM_OK);
    assert_false(request.job.surroundings.no_back_faces);
    assert_true(pm_rgb_is_black(request.job.surroundings.extinction));
    pm_request_clear(&request);
    assert_refused(HEAD "\"render\", \"back_faces\": 0}", "back_faces");
    assert_refused(HEAD "\"render\", \"medium\": {\"albedo\": [1, 1, 1]}}",
                   "medium.extinction");
    assert_refused(HEAD "\"render\", \"medium\": {\"extinction\": [0, 0, 0]}}", "medium");
    assert_refused(HEAD "\"render\", \"medium\": {\"extinction\": [1, 1, -1]}}",
                   "medium.extinction");
    assert_refused(HEAD "\"render\", \"medium\": {\"extinction\": [1, 1, 1], \"g\": 1}}",
                   "medium.g");
}

static void ports_are_read(void **state)
{
    (void)state;
    pm_request request;
    assert_int_equal(parse(HEAD "\"map\", \"global\": {\"count\": 5}, \"partition\": 0.5, "
                                "\"ports\": [{\"modifier\": \"pane\"}, "
                                "{\"modifier\": \"door\", \"side\": \"back\"}, "
                                "{\"modifier\": \"gap\", \"side\": \"both\"}]}",
                           &request, NULL),
                     PM_OK);
    const pm_forward_options *forward = &request.job.forward;
    assert_int_equal(forward->port_count, 3);
    assert_string_equal(forward->ports[1].modifier, "door");
    assert_int_equal(forward->ports[0].sides, PM_PORT_FRONT);
    assert_int_equal(forward->ports[1].sides, PM_PORT_BACK);
    assert_int_equal(forward->ports[2].sides, PM_PORT_FRONT | PM_PORT_BACK);
    assert_true(forward->partition == .5 && forward->direction_resolution == 1000);
    pm_request_clear(&request);
}

#define MAP_HEAD HEAD "\"map\", \"global\": {\"count\": 5}, "

static void what_is_stored_nowhere_is_refused(void **state)
{
    (void)state;
    assert_refused(MAP_HEAD "\"exclude\": [\"a\"], \"include\": [\"b\"]}", "exclude");
    assert_refused(MAP_HEAD "\"exclude\": []}", "exclude");
    assert_refused(MAP_HEAD "\"exclude\": \"a\"}", "exclude");
    assert_refused(MAP_HEAD "\"exclude\": [\"a\", 5]}", "exclude[1]");
    assert_refused(MAP_HEAD "\"sensors\": [\"\"]}", "sensors[0]");
    assert_refused(MAP_HEAD "\"regions\": [{}]}", "regions");
    assert_refused(MAP_HEAD "\"regions\": [{\"box\": [0, 0, 0, 1, 1]}]}", "regions[0].box");
    assert_refused(MAP_HEAD "\"regions\": [{\"cube\": [0, 0, 0, 1]}]}", "regions[0].cube");
    assert_refused(MAP_HEAD "\"regions\": [{\"box\": [0, 0, 0, 1, 1, 0]}]}", "regions");
    assert_refused(MAP_HEAD "\"regions\": [{\"sphere\": [0, 0, 0, -1]}]}", "regions");
    assert_refused(MAP_HEAD "\"regions\": [{\"sphere\": [0, 0, 0, 1], "
                            "\"box\": [0, 0, 0, 1, 1, 1]}]}",
                   "regions");
    assert_refused(MAP_HEAD "\"max_length\": 0}", "max_length");
    assert_refused(MAP_HEAD "\"ports\": [{}]}", "ports[0].modifier");
    assert_refused(MAP_HEAD "\"ports\": [{\"modifier\": \"a\", \"side\": \"up\"}]}",
                   "ports[0].side");
    assert_refused(MAP_HEAD "\"partition\": 0.1}", "partition");
    assert_refused(MAP_HEAD "\"max_length\": -1}", "max_length");
    assert_refused(HEAD "\"render\", \"exclude\": [\"a\"]}", "exclude");
    assert_refused(HEAD "\"render\", \"sensors\": [\"a\"]}", "sensors");
    assert_refused(HEAD "\"render\", \"regions\": [{\"sphere\": [0, 0, 0, 1]}]}", "regions");
}

static void members_without_meaning_are_refused_not_ignored(void **state)
{
    (void)state;
    static const char *const members[] = {"\"ab\": 1",
                                          "\"view\": \"\"",
                                          "\"x\": 5",
                                          "\"y\": 5",
                                          "\"passes\": 5",
                                          "\"time\": 5",
                                          "\"error\": 1",
                                          "\"formats\": [\"exr\"]",
                                          "\"quantity\": \"radiance\"",
                                          "\"points\": \"" ID "\""};
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        char text[512], member[32];
        snprintf(text, sizeof text, HEAD "\"map\", \"global\": {\"count\": 5}, %s}",
                 members[i]);
        snprintf(member, sizeof member, "%.*s", (int)strcspn(members[i] + 1, "\""),
                 members[i] + 1);
        assert_refused(text, member);
    }
    assert_refused(HEAD "\"trace\", \"points\": \"" ID "\", \"view\": \"\"}", "view");
    assert_refused(HEAD "\"render\", \"quantity\": \"radiance\"}", "quantity");
}

static pm_status sensors(const char *text, pm_sensor **out, size_t *count, pm_error *err)
{
    return pm_sensors_parse(text, strlen(text), "points", out, count, err);
}

static void sensors_come_a_line_each_in_order(void **state)
{
    (void)state;
    pm_sensor *list = NULL;
    size_t count = 0;
    assert_int_equal(sensors("1 2 3  0 0 1\r\n\n -1e3\t0.5 7 0 -2 0", &list, &count, NULL),
                     PM_OK);
    assert_int_equal(count, 2);
    assert_true(list[0].point.z == 3 && list[0].normal.z == 1);
    assert_true(list[1].point.x == -1000 && list[1].normal.y == -2);
    free(list);
}

static void bad_sensors_name_line_and_column(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int line, column;
    } bad[] = {{"", 1, 1},
               {"\n\n", 1, 1},
               {"1 2 3 0 0 1\n1 2 x 0 0 1\n", 2, 5},
               {"1 2 3 0 0", 1, 10},
               {"1 2 3 0 0 1 9", 1, 13},
               {"1 2 nan 0 0 1", 1, 5},
               {"1 2 1e999 0 0 1", 1, 5},
               {"1 2 3 0 0 0", 1, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        pm_error err = PM_ERROR_INIT;
        pm_sensor *list = NULL;
        size_t count = 0;
        assert_int_not_equal(sensors(bad[i].text, &list, &count, &err), PM_OK);
        assert_null(list);
        assert_string_equal(err.file, "points");
        assert_int_equal(err.line, bad[i].line);
        assert_int_equal(err.column, bad[i].column);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_render_has_its_defaults),
        cmocka_unit_test(a_view_means_the_same_as_members_and_as_text),
        cmocka_unit_test(pixels_need_not_be_square),
        cmocka_unit_test(naming_a_map_makes_a_job_of_nearest_photons),
        cmocka_unit_test(a_precomputed_map_stands_in_for_the_global_one),
        cmocka_unit_test(contradictions_name_their_member),
        cmocka_unit_test(what_is_stored_where_is_read),
        cmocka_unit_test(surroundings_are_read),
        cmocka_unit_test(ports_are_read),
        cmocka_unit_test(what_is_stored_nowhere_is_refused),
        cmocka_unit_test(members_without_meaning_are_refused_not_ignored),
        cmocka_unit_test(sensors_come_a_line_each_in_order),
        cmocka_unit_test(bad_sensors_name_line_and_column),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
