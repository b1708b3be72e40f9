#include "cmocka_first.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/digest.h"
#include "harness.h"

/* The real engine in its sandbox: a scene over HTTP to maps, a picture and values. */

/* A closed box whose walls have albedo .5, a glass ball in it, a lamp in the ceiling. */
static const char scene_text[] =
    "void plastic wall 0 0 5 .5 .5 .5 0 0\\n"
    "void dielectric glass 0 0 5 1 1 1 1.5 0\\n"
    "void light on 0 0 3 10 10 10\\n"
    "wall polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\\n"
    "wall polygon top 0 0 12 -1 -1 2 -1 1 2 1 1 2 1 -1 2\\n"
    "wall polygon north 0 0 12 -1 1 0 1 1 0 1 1 2 -1 1 2\\n"
    "wall polygon south 0 0 12 -1 -1 0 -1 -1 2 1 -1 2 1 -1 0\\n"
    "wall polygon east 0 0 12 1 -1 0 1 -1 2 1 1 2 1 1 0\\n"
    "wall polygon west 0 0 12 -1 -1 0 -1 1 0 -1 1 2 -1 -1 2\\n"
    "glass sphere ball 0 0 4 .3 .3 .6 .3\\n"
    "on polygon lamp 0 0 12 -.3 -.3 1.99 -.3 .3 1.99 .3 .3 1.99 .3 -.3 1.99\\n";

static void start_with(test_server *server, const char *const *options, char scene[65])
{
    server->worker = PMWORKER;
    test_server_start(server, options);
    test_reply reply;
    char body[2048];
    snprintf(body, sizeof body, "{\"text\": \"%s\"}", scene_text);
    reply = test_post(server, "/v1/scenes", body);
    if (reply.status != 201)
        fail_msg("%.*s", (int)reply.body.size, reply.body.data);
    strcpy(scene, pm_json_get_text(reply.json, "id", ""));
    assert_int_equal(pm_json_get_integer(reply.json, "surfaces", 0), 8);
    assert_int_equal(pm_json_get_integer(reply.json, "lights", 0), 1);
    test_reply_clear(&reply);
}

static void start(test_server *server, char scene[65])
{
    start_with(server, NULL, scene);
}

static pm_json *run(const test_server *server, const char *format, const char *scene)
{
    char id[32];
    test_job(server, format, scene, id);
    pm_json *job = test_finish(server, id);
    if (strcmp(pm_json_get_text(job, "state", ""), "done") != 0) {
        char *text = pm_json_pretty(job);
        fail_msg("%s", text);
    }
    return job;
}

static pm_digest fetch_digest(const test_server *server, const char *path)
{
    test_reply reply = test_get(server, path);
    assert_int_equal(reply.status, 200);
    pm_digest digest = pm_digest_of(reply.body.data, reply.body.size);
    test_reply_clear(&reply);
    return digest;
}

static void errors_in_scenes_name_file_line_and_column(void **state)
{
    test_server *server = *state;
    server->worker = PMWORKER;
    test_server_start_plain(server);
    test_reply reply = test_post(server, "/v1/scenes",
                                 "{\"text\": \"void light on 0 0 3 1 1 1\\n\\non sphere s 0 0 "
                                 "4 0 0 zero 1\\n\", \"main\": \"a.rad\"}");
    assert_int_equal(reply.status, 422);
    assert_string_equal(pm_json_get_text(reply.json, "file", ""), "a.rad");
    assert_int_equal(pm_json_get_integer(reply.json, "line", 0), 3);
    assert_int_equal(pm_json_get_integer(reply.json, "column", 0), 23);
    test_reply_clear(&reply);
}

#define MAPS "\"global\": {\"count\": 20000}, \"caustic\": {\"count\": 5000}"

static void a_second_view_traces_no_photon(void **state)
{
    test_server *server = *state;
    char scene[65];
    start(server, scene);
    pm_json *a = run(server,
                     "{\"kind\": \"render\", \"scene\": \"%s\", " MAPS
                     ", \"passes\": 2, \"x\": 16, \"y\": 16, \"ab\": -1, \"view\": \"-vp 0 -.9 "
                     "1 -vd 0 1 0\"}",
                     scene);
    assert_string_equal(pm_json_get_text(a, "cache", ""), "miss");
    assert_int_equal(pm_json_get_integer(a, "passes", 0), 2);
    assert_int_equal(pm_json_get_integer(a, "nonfinite", -1), 0);
    pm_json *b = run(server,
                     "{\"kind\": \"render\", \"scene\": \"%s\", " MAPS
                     ", \"passes\": 2, \"x\": 16, \"y\": 16, \"ab\": -1, \"view\": \"-vp .9 0 "
                     "1 -vd -1 0 0\"}",
                     scene);
    assert_string_equal(pm_json_get_text(b, "cache", ""), "hit");
    const pm_json *maps = pm_json_get(b, "maps");
    for (size_t i = 0; i < pm_json_length(maps); i++)
        assert_int_equal(pm_json_get_integer(pm_json_at(maps, i), "paths_traced", -1), 0);
    pm_json_free(a);
    pm_json_free(b);
}

/* The map's file comes from a worker that reads the stored batches; it is the file that a map
 * job would have made, byte for byte, and so is its copy after a restart. */
static void a_maps_file_is_made_on_demand_and_is_always_the_same(void **state)
{
    test_server *server = *state;
    char scene[65], path[160];
    start(server, scene);
    pm_json *job = run(
        server,
        "{\"kind\": \"render\", \"scene\": \"%s\", \"global\": {\"count\": 20000}, "
        "\"passes\": 1, \"x\": 4, \"y\": 4, \"ab\": -1, \"view\": \"-vp 0 -.9 1 -vd 0 1 0\"}",
        scene);
    const pm_json *map = pm_json_at(pm_json_get(job, "maps"), 0);
    snprintf(path, sizeof path, "/v1/maps/%s/photons", pm_json_get_text(map, "key", ""));
    pm_digest first = fetch_digest(server, path), second = fetch_digest(server, path);
    assert_true(pm_digest_equal(&first, &second));
    pm_json_free(job);
    job = run(server, "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 20000}}",
              scene);
    assert_string_equal(pm_json_get_text(job, "cache", ""), "hit");
    const pm_json *result = pm_json_at(pm_json_get(job, "result"), 0);
    assert_string_equal(pm_json_get_text(result, "name", ""), "global");
    pm_digest third = fetch_digest(server, pm_json_get_text(result, "url", ""));
    assert_true(pm_digest_equal(&first, &third));
    pm_json_free(job);
}

static const pm_json *only_map(const pm_json *job)
{
    const pm_json *maps = pm_json_get(job, "maps");
    assert_int_equal(pm_json_length(maps), 1);
    return pm_json_at(maps, 0);
}

static int64_t number(const pm_json *map, const char *name)
{
    return pm_json_get_integer(map, name, -1);
}

static pm_digest result_digest(const test_server *server, const pm_json *job)
{
    const pm_json *result = pm_json_at(pm_json_get(job, "result"), 0);
    return fetch_digest(server, pm_json_get_text(result, "url", ""));
}

static pm_digest pass_digest(const test_server *server, const pm_json *job, unsigned pass)
{
    char path[160];
    snprintf(path, sizeof path, "/v1/maps/%s/passes/%u",
             pm_json_get_text(only_map(job), "key", ""), pass);
    return fetch_digest(server, path);
}

static void assert_same(pm_digest a, pm_digest b)
{
    assert_true(pm_digest_equal(&a, &b));
}

#define SEQUENCE                                                                               \
    "{\"kind\": \"map\", \"scene\": \"%%s\", \"global\": {\"count\": 20000, \"passes\": %d}}"

static pm_json *run_sequence(const test_server *server, const char *scene, int passes)
{
    char format[256];
    snprintf(format, sizeof format, SEQUENCE, passes);
    return run(server, format, scene);
}

/* Appended later: only what is missing is traced, the passes of before stay as they were, and
 * no two share a path. */
static void a_longer_sequence_traces_only_the_missing_passes(void **state)
{
    test_server *server = *state;
    char scene[65];
    start(server, scene);
    pm_json *three = run_sequence(server, scene, 3), *nine = run_sequence(server, scene, 9);
    int64_t batches = number(only_map(three), "paths_traced") / 65536;
    assert_int_equal(batches, 3); /* one a pass: 20000 photons need fewer paths */
    assert_int_equal(number(only_map(nine), "paths_traced"), 65536 * 6);
    assert_int_equal(number(only_map(nine), "paths_cached"), 65536 * 3);
    const pm_json *passes = pm_json_get(only_map(nine), "passes");
    assert_int_equal(pm_json_length(passes), 9);
    for (unsigned i = 0; i < 9; i++) {
        const pm_json *pass = pm_json_at(passes, i);
        assert_in_range(number(pass, "photons"), 19800, 20000);
        assert_int_equal(number(pass, "first_path"), 65536 * i);
        if (i < 3)
            assert_same(pass_digest(server, three, i), pass_digest(server, nine, i));
    }
    pm_digest first = pass_digest(server, nine, 0), second = pass_digest(server, nine, 1);
    assert_false(pm_digest_equal(&first, &second));
    pm_json_free(three);
    pm_json_free(nine);
}

/* Topped up, in photons or in passes, or made at once: the same bytes. */
static void topped_up_maps_are_those_made_at_once(void **state)
{
    test_server *server = *state;
    char scene[65];
    start(server, scene);
    const char *small =
                   "{\"kind\": \"map\", \"scene\": \"%s\", \"caustic\": {\"count\": 5000}}",
               *large =
                   "{\"kind\": \"map\", \"scene\": \"%s\", \"caustic\": {\"count\": 200000}}";
    pm_json *first = run(server, small, scene), *topped = run(server, large, scene);
    pm_json *few = run_sequence(server, scene, 2), *more = run_sequence(server, scene, 5);
    assert_string_equal(pm_json_get_text(topped, "cache", ""), "extended");
    pm_digest map = result_digest(server, topped), sequence = result_digest(server, more);
    pm_json_free(first);
    pm_json_free(topped);
    pm_json_free(few);
    pm_json_free(more);
    test_server_stop(server, SIGTERM);
    assert_int_equal(unlink(server->store), 0);
    start(server, scene);
    topped = run(server, large, scene);
    more = run_sequence(server, scene, 5);
    assert_string_equal(pm_json_get_text(topped, "cache", ""), "miss");
    assert_same(map, result_digest(server, topped));
    assert_same(sequence, result_digest(server, more));
    pm_json_free(topped);
    pm_json_free(more);
}

/* Killed in the middle, the next server goes on with what is stored, to the same bytes. */
static void a_sequence_survives_kill_9(void **state)
{
    test_server *server = *state;
    char scene[65], id[32], path[64];
    start(server, scene);
    test_job(server,
             "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 60000, "
             "\"passes\": 24}}",
             scene, id);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    for (int64_t photons = 0; photons < 100000;) { /* the second pass is under way */
        test_reply reply = test_get(server, path);
        const pm_json *progress = pm_json_get(reply.json, "progress");
        photons = pm_json_get_integer(pm_json_get(progress, "photons"), "global", 0);
        if (!strcmp(pm_json_get_text(reply.json, "state", ""), "done"))
            photons = INT64_MAX;
        test_reply_clear(&reply);
    }
    test_server_stop(server, SIGKILL);
    test_server_start_plain(server);
    pm_json *job = test_finish(server, id);
    assert_string_equal(pm_json_get_text(job, "state", ""), "done");
    pm_digest sequence = result_digest(server, job);
    pm_json_free(job);
    test_server_stop(server, SIGTERM);
    assert_int_equal(unlink(server->store), 0);
    start(server, scene);
    job = run(server,
              "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 60000, "
              "\"passes\": 24}}",
              scene);
    assert_same(sequence, result_digest(server, job));
    pm_json_free(job);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/* Before any work: tracing them would take minutes. */
static void more_photons_than_memory_are_refused_at_once(void **state)
{
    test_server *server = *state;
    const char *const options[] = {"--memory-limit", "2g", NULL};
    char scene[65], id[32];
    start_with(server, options, scene);
    test_job(server,
             "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 200000000}}",
             scene, id);
    pm_json *job = test_finish(server, id);
    assert_string_equal(
        pm_json_get_text(pm_json_get(job, "problem"), "detail", ""),
        "no memory for 200000000 photons, which take 5.2 GB: ask for fewer, or allow more "
        "(pmserver --memory-limit)");
    pm_json_free(job);
}
#endif

static void assert_refused(const test_server *server, const char *format, const char *scene,
                           const char *text)
{
    char body[512];
    snprintf(body, sizeof body, format, scene);
    test_reply reply = test_post(server, "/v1/jobs", body);
    assert_int_equal(reply.status, 422);
    const char *detail = pm_json_get_text(reply.json, "detail", "");
    if (!strstr(detail, text))
        fail_msg("says: %s", detail);
    test_reply_clear(&reply);
}

static void passes_that_are_not_there_are_404_and_wrong_ones_422(void **state)
{
    test_server *server = *state;
    char scene[65], path[160];
    start(server, scene);
    pm_json *job = run_sequence(server, scene, 2);
    const char *key = pm_json_get_text(only_map(job), "key", "");
    const char *wrong[] = {"2", "-1", "x", "99999999999999999999"};
    for (unsigned i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        snprintf(path, sizeof path, "/v1/maps/%s/passes/%s", key, wrong[i]);
        test_reply reply = test_get(server, path);
        assert_int_equal(reply.status, 404);
        test_reply_clear(&reply);
    }
    pm_json_free(job);
    assert_refused(server,
                   "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 1000, "
                   "\"passes\": 0}}",
                   scene, "must be 1 to 4096");
    assert_refused(server,
                   "{\"kind\": \"render\", \"scene\": \"%s\", \"global\": {\"count\": 1000, "
                   "\"passes\": 2}}",
                   scene, "in a job of kind map alone");
}

/* In a closed box all power ends in the walls: mean irradiance on walls and ball is far from
 * zero, and a sensor under the lamp sees more than one at the wall's foot. Exact numbers are
 * tests/physics' part. */
static void sensors_see_the_lamp(void **state)
{
    test_server *server = *state;
    char scene[65], points[65], body[512];
    static const char text[] = "0 0 .01 0 0 1\n.9 -.9 .01 0 0 1\n0 0 .01 0 0 -1\n";
    start(server, scene);
    test_put(server, text, strlen(text), points);
    snprintf(body, sizeof body,
             "{\"kind\": \"trace\", \"scene\": \"%%s\", \"points\": \"%s\", \"passes\": 16}",
             points);
    pm_json *job = run(server, body, scene);
    test_reply reply = test_get(
        server, pm_json_get_text(pm_json_at(pm_json_get(job, "result"), 0), "url", ""));
    double up[3], foot[3], down[3], w[3];
    pm_bytes_u8(&reply.body, 0);
    assert_int_equal(sscanf((char *)reply.body.data,
                            "%lf %lf %lf %lf %lf %lf %lf %lf %lf %*f %*f %*f %lf %lf %lf",
                            &up[0], &up[1], &up[2], &w[0], &w[1], &w[2], &foot[0], &foot[1],
                            &foot[2], &down[0], &down[1], &down[2]),
                     12);
    assert_true(up[0] > foot[0] && foot[0] > 0);
    assert_true(w[0] > 0 && w[0] < up[0]);
    assert_true(down[0] < foot[0]); /* a hair above the floor, looking down */
    test_reply_clear(&reply);
    pm_json_free(job);
}

static void a_map_of_another_scene_is_refused(void **state)
{
    test_server *server = *state;
    char scene[65], other[65], body[512], id[32];
    start(server, scene);
    pm_json *job = run(
        server, "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 1000}}", scene);
    const char *map = pm_json_get_text(pm_json_at(pm_json_get(job, "result"), 0), "digest", "");
    test_scene(server, "void light on 0 0 3 1 1 1\\non sphere s 0 0 4 0 0 0 1\\n", other);
    snprintf(body, sizeof body,
             "{\"kind\": \"render\", \"scene\": \"%%s\", \"global\": {\"map\": \"%s\"}}", map);
    test_job(server, body, other, id);
    pm_json *refused = test_finish(server, id);
    assert_string_equal(pm_json_get_text(refused, "state", ""), "failed");
    assert_non_null(strstr(pm_json_get_text(pm_json_get(refused, "problem"), "detail", ""),
                           "another scene"));
    assert_int_equal(pm_json_get_integer(pm_json_get(refused, "problem"), "status", 0), 422);
    pm_json_free(refused);
    pm_json_free(job);
}

#define TEST(name)                                                                             \
    cmocka_unit_test_setup_teardown(name, test_server_setup, test_server_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(errors_in_scenes_name_file_line_and_column),
        TEST(a_second_view_traces_no_photon),
        TEST(a_maps_file_is_made_on_demand_and_is_always_the_same),
        TEST(a_longer_sequence_traces_only_the_missing_passes),
        TEST(topped_up_maps_are_those_made_at_once),
        TEST(a_sequence_survives_kill_9),
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        TEST(more_photons_than_memory_are_refused_at_once),
#endif
        TEST(passes_that_are_not_there_are_404_and_wrong_ones_422),
        TEST(sensors_see_the_lamp),
        TEST(a_map_of_another_scene_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
