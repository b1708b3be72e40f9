#include "cmocka_first.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "forward/photon.h"
#include "harness.h"

/* Scenes, jobs and maps, with workers whose engine does what the scene's text says
 * (fake_engine.c). */

#define MAP    "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 3000}}"
#define RENDER "{\"kind\": \"render\", \"scene\": \"%s\", \"x\": 8, \"y\": 8}"

static void assert_text(const pm_json *json, const char *name, const char *expected)
{
    const char *text = pm_json_get_text(json, name, "(missing)");
    if (strcmp(text, expected) != 0)
        fail_msg("%s is %s instead of %s", name, text, expected);
}

/* Runs a job of a scene that ends it badly; its problem's detail must have these words. */
static void assert_fails(const test_server *server, const char *text, const char *words)
{
    char scene[65], id[32];
    test_scene(server, text, scene);
    test_job(server, RENDER, scene, id);
    pm_json *job = test_finish(server, id);
    assert_text(job, "state", "failed");
    const char *detail = pm_json_get_text(pm_json_get(job, "problem"), "detail", "(none)");
    if (!strstr(detail, words))
        fail_msg("\"%s\" is not in: %s", words, detail);
    pm_json_free(job);
}

/* ---- scenes ---- */

static void a_scene_is_checked_and_kept_once(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    test_reply first =
        test_post(server, "/v1/scenes", "{\"text\": \"a\", \"main\": \"x/y.rad\"}");
    assert_int_equal(first.status, 201);
    assert_text(first.json, "main", "x/y.rad");
    assert_int_equal(pm_json_get_integer(first.json, "surfaces", 0), 3);
    assert_int_equal(strlen(pm_json_get_text(first.json, "scene", "")), 64);
    assert_int_equal(pm_json_length(pm_json_get(first.json, "plan")), PM_MAP_KINDS);
    char location[256];
    assert_non_null(test_header(&first, "Location", location));
    test_reply again =
        test_post(server, "/v1/scenes", "{\"text\": \"a\", \"main\": \"x/y.rad\"}");
    assert_int_equal(again.status, 200);
    assert_text(again.json, "id", pm_json_get_text(first.json, "id", ""));
    test_reply_clear(&again);
    again = test_get(server, location);
    assert_int_equal(again.status, 200);
    assert_text(again.json, "id", pm_json_get_text(first.json, "id", ""));
    test_reply_clear(&again);
    test_reply_clear(&first);
    test_reply list = test_get(server, "/v1/scenes");
    assert_int_equal(pm_json_length(pm_json_get(list.json, "scenes")), 1);
    test_reply_clear(&list);
}

static void a_scene_with_an_error_names_its_place(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    test_reply reply =
        test_post(server, "/v1/scenes", "{\"text\": \"error\", \"main\": \"a.rad\"}");
    assert_int_equal(reply.status, 422);
    assert_text(reply.json, "file", "a.rad");
    assert_int_equal(pm_json_get_integer(reply.json, "line", 0), 3);
    assert_int_equal(pm_json_get_integer(reply.json, "column", 0), 7);
    assert_text(reply.json, "detail", "? is no number"); /* its bytes are no UTF-8 */
    test_reply_clear(&reply);
    reply = test_get(server, "/v1/scenes");
    assert_int_equal(pm_json_length(pm_json_get(reply.json, "scenes")), 0);
    test_reply_clear(&reply);
}

static void a_bad_bundle_is_refused(void **state)
{
    test_server *server = *state;
    char digest[65], body[256];
    test_server_start_plain(server);
    test_put(server, "this is no tar", 14, digest);
    snprintf(body, sizeof body, "{\"bundle\": \"%s\"}", digest);
    test_expect(test_post(server, "/v1/scenes", body), 422);
    memset(body + 12, 'e', 64); /* a digest that nobody stored */
    test_expect(test_post(server, "/v1/scenes", body), 422);
    test_expect(test_post(server, "/v1/scenes", "{}"), 422);
    snprintf(body, sizeof body, "{\"bundle\": \"%s\", \"text\": \"a\"}", digest);
    test_expect(test_post(server, "/v1/scenes", body), 422);
    test_expect(test_post(server, "/v1/scenes", "{\"text\": \"a\", \"main\": \"../a.rad\"}"),
                422);
}

static void a_crash_while_checking_ends_nothing_else(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    test_reply reply = test_post(server, "/v1/scenes", "{\"text\": \"crash at once\"}");
    assert_int_equal(reply.status, 500);
    assert_non_null(strstr(pm_json_get_text(reply.json, "detail", ""), "SIGABRT"));
    test_reply_clear(&reply);
    test_expect(test_post(server, "/v1/scenes", "{\"text\": \"a\"}"), 201);
}

/* ---- jobs ---- */

static void a_picture_is_made_and_fetched(void **state)
{
    test_server *server = *state;
    char scene[65], id[32], path[160], value[256];
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    test_job(
        server,
        "{\"kind\": \"render\", \"scene\": \"%s\", \"x\": 8, \"y\": 8, \"formats\": [\"png\", "
        "\"exr\"]}",
        scene, id);
    pm_json *job = test_finish(server, id);
    assert_text(job, "state", "done");
    assert_text(job, "cache", "none");
    assert_int_equal(pm_json_get_integer(job, "passes", 0), 2);
    assert_int_equal(pm_json_length(pm_json_get(job, "curve")), 2);
    assert_int_equal(pm_json_length(pm_json_get(job, "plan")), PM_MAP_KINDS);
    const pm_json *results = pm_json_get(job, "result");
    assert_int_equal(pm_json_length(results), 2);
    for (size_t i = 0; i < 2; i++) {
        const pm_json *result = pm_json_at(results, i);
        test_reply reply = test_get(server, pm_json_get_text(result, "url", ""));
        assert_int_equal(reply.status, 200);
        assert_int_equal(reply.body.size, pm_json_get_integer(result, "size", 0));
        char quoted[80];
        snprintf(quoted, sizeof quoted, "\"%s\"", pm_json_get_text(result, "digest", ""));
        assert_string_equal(test_header(&reply, "ETag", value), quoted);
        test_reply_clear(&reply);
    }
    pm_json_free(job);
    snprintf(path, sizeof path, "/v1/jobs/%s/result?format=png", id);
    test_reply reply = test_get(server, path);
    assert_string_equal(test_header(&reply, "Content-Type", value), "image/png");
    assert_memory_equal(reply.body.data, "\x89PNG", 4);
    test_reply_clear(&reply);
    snprintf(path, sizeof path, "/v1/jobs/%s/result?format=hdr", id);
    test_expect(test_get(server, path), 404);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    test_expect(test_ask(server, "DELETE", path, NULL, NULL, 0), 409);
}

static void values_come_a_line_a_sensor(void **state)
{
    test_server *server = *state;
    char scene[65], points[65], body[512], path[96];
    static const char text[] = "1 2 3 0 0 1\n-4.5 2 3 0 0 1\n";
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    test_put(server, text, strlen(text), points);
    snprintf(body, sizeof body, "{\"kind\": \"trace\", \"scene\": \"%s\", \"points\": \"%s\"}",
             scene, points);
    test_expect(test_post(server, "/v1/jobs", body), 202);
    pm_json_free(test_finish(server, "1"));
    strcpy(path, "/v1/jobs/1/result");
    test_reply reply = test_get(server, path);
    assert_int_equal(reply.status, 200);
    static const char expected[] = "1\t0\t0\t0\t0\t0\n-4.5\t0\t0\t0\t0\t0\n";
    assert_int_equal(reply.body.size, strlen(expected));
    assert_memory_equal(reply.body.data, expected, strlen(expected));
    test_reply_clear(&reply);
}

static void bad_points_fail_the_job_with_their_line(void **state)
{
    test_server *server = *state;
    char scene[65], points[65], body[512];
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    test_put(server, "1 2 3 0 0 1\nx\n", 14, points);
    snprintf(body, sizeof body, "{\"kind\": \"trace\", \"scene\": \"%s\", \"points\": \"%s\"}",
             scene, points);
    test_expect(test_post(server, "/v1/jobs", body), 202);
    pm_json *job = test_finish(server, "1");
    assert_text(job, "state", "failed");
    assert_text(pm_json_get(job, "problem"), "file", "points");
    assert_int_equal(pm_json_get_integer(pm_json_get(job, "problem"), "line", 0), 2);
    pm_json_free(job);
}

static void what_a_job_names_must_be_there(void **state)
{
    test_server *server = *state;
    char scene[65], body[512];
    static const char none[] =
        "0000000000000000000000000000000000000000000000000000000000000000";
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    static const char *const members[] = {"points", "global", "scene"};
    static const char *const bodies[] = {
        "{\"kind\": \"trace\", \"scene\": \"%s\", \"points\": \"%s\"}",
        "{\"kind\": \"render\", \"scene\": \"%s\", \"global\": {\"map\": \"%s\"}}"};
    for (size_t i = 0; i < 3; i++) {
        if (i < 2)
            snprintf(body, sizeof body, bodies[i], scene, none);
        else
            snprintf(body, sizeof body, "{\"kind\": \"render\", \"scene\": \"%s\"}", none);
        test_reply reply = test_post(server, "/v1/jobs", body);
        assert_int_equal(reply.status, 422);
        assert_text(reply.json, "member", members[i]);
        test_reply_clear(&reply);
    }
}

static test_reply post_with_key(const test_server *server, const char *key, const char *body)
{
    char headers[128];
    snprintf(headers, sizeof headers,
             "Content-Type: application/json\r\nIdempotency-Key: %s\r\n", key);
    return test_ask(server, "POST", "/v1/jobs", headers, body, strlen(body));
}

static void an_idempotency_key_makes_one_job(void **state)
{
    test_server *server = *state;
    char scene[65], body[256];
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    snprintf(body, sizeof body, RENDER, scene);
    test_reply first = post_with_key(server, "k1", body),
               again = post_with_key(server, "k1", body);
    assert_int_equal(first.status, 202);
    assert_int_equal(again.status, 200);
    assert_text(again.json, "id", pm_json_get_text(first.json, "id", ""));
    test_reply other = post_with_key(server, "k2", body);
    assert_int_equal(other.status, 202);
    snprintf(body, sizeof body, MAP, scene);
    test_expect(post_with_key(server, "k1", body), 422);
    test_reply_clear(&first);
    test_reply_clear(&again);
    test_reply_clear(&other);
    test_reply list = test_get(server, "/v1/jobs");
    assert_int_equal(pm_json_length(pm_json_get(list.json, "jobs")), 2);
    test_reply_clear(&list);
}

static void each_way_to_die_is_named_and_ends_one_job(void **state)
{
    test_server *server = *state;
    const char *const options[] = {"--cpu-limit", "1", NULL};
    test_server_start(server, options);
    assert_fails(server, "crash", "SIGABRT");
    assert_fails(server, "leave", "exit status 7");
    assert_fails(server, "spin", "CPU time");
    test_reply ready = test_get(server, "/readyz");
    if (pm_json_get_bool(pm_json_get(ready.json, "sandbox"), "seccomp", false)) {
        assert_fails(server, "socket", "SIGSYS");
        assert_fails(server, "open", "files are closed");
    }
    test_reply_clear(&ready);
    char scene[65], id[32];
    test_scene(server, "fine", scene);
    test_job(server, RENDER, scene, id);
    pm_json *job = test_finish(server, id);
    assert_text(job, "state", "done");
    pm_json_free(job);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
static void a_memory_limit_ends_one_job(void **state)
{
    test_server *server = *state;
    const char *const options[] = {"--memory-limit", "2g", NULL};
    test_server_start(server, options);
    assert_fails(server, "memory", "no memory");
}
#endif

static void a_worker_that_cannot_start_is_named(void **state)
{
    test_server *server = *state;
    server->worker = "/nonexistent/pmworker";
    test_server_start_plain(server);
    test_reply reply = test_post(server, "/v1/scenes", "{\"text\": \"a\"}");
    assert_int_equal(reply.status, 503);
    assert_non_null(
        strstr(pm_json_get_text(reply.json, "detail", ""), "/nonexistent/pmworker"));
    test_reply_clear(&reply);
    test_expect(test_get(server, "/readyz"), 503);
}

/* ---- waiting and cancelling ---- */

static void waiting_ends_with_the_state_or_the_time(void **state)
{
    test_server *server = *state;
    char scene[65], id[32], path[96];
    test_server_start_plain(server);
    test_scene(server, "hang", scene);
    test_job(server, RENDER, scene, id);
    test_until(server, id, "running");
    snprintf(path, sizeof path, "/v1/jobs/%s?wait=0.2", id);
    test_reply reply = test_get(server, path); /* nothing changes: the time ends it */
    assert_text(reply.json, "state", "running");
    test_reply_clear(&reply);
    do {
        test_reply_clear(&reply);
        snprintf(path, sizeof path, "/v1/jobs/%s", id);
        reply = test_get(server, path);
    } while (!pm_json_get(reply.json, "progress"));
    const pm_json *progress = pm_json_get(reply.json, "progress");
    assert_text(progress, "stage", "forward");
    assert_true(pm_json_get_number(progress, "done", 0) == .25);
    test_reply_clear(&reply);
    snprintf(path, sizeof path, "/v1/jobs/%s/result", id);
    test_expect(test_get(server, path), 409);
    /* A waiting request is answered when the job is cancelled. */
    char request[256];
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s?wait=60 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
             id);
    int socket = test_connect(server);
    test_send(socket, request, strlen(request));
    test_cancel(server, id);
    reply = test_receive(socket);
    assert_text(reply.json, "state", "cancelled");
    test_reply_clear(&reply);
}

static void a_queued_job_is_cancelled_at_once(void **state)
{
    test_server *server = *state;
    char scene[65], first[32], second[32], path[96];
    test_server_start_plain(server);
    test_scene(server, "hang", scene);
    test_job(server, RENDER, scene, first);
    test_until(server, first, "running");
    test_job(server, RENDER, scene, second);
    snprintf(path, sizeof path, "/v1/jobs/%s", second);
    test_reply reply = test_ask(server, "DELETE", path, NULL, NULL, 0);
    assert_int_equal(reply.status, 200);
    assert_text(reply.json, "state", "cancelled");
    test_reply_clear(&reply);
    /* Scenes are checked meanwhile: that does not wait behind jobs. */
    test_expect(test_post(server, "/v1/scenes", "{\"text\": \"other\"}"), 201);
    test_cancel(server, first);
    pm_json *job = test_finish(server, first);
    assert_text(job, "state", "cancelled");
    pm_json_free(job);
}

/* ---- maps and their cache ---- */

static pm_json *run_map(const test_server *server, const char *scene, unsigned count)
{
    char body[256], id[32];
    snprintf(body, sizeof body,
             "{\"kind\": \"map\", \"scene\": \"%%s\", \"global\": {\"count\": %u}}", count);
    test_job(server, body, scene, id);
    pm_json *job = test_finish(server, id);
    assert_text(job, "state", "done");
    return job;
}

static void assert_cache(pm_json *job, const char *cache, long long traced, long long cached)
{
    assert_text(job, "cache", cache);
    const pm_json *map = pm_json_at(pm_json_get(job, "maps"), 0);
    assert_text(map, "cache", cache);
    assert_int_equal(pm_json_get_integer(map, "paths_traced", -1), traced * 65536);
    assert_int_equal(pm_json_get_integer(map, "paths_cached", -1), cached * 65536);
    pm_json_free(job);
}

static void a_second_job_finds_the_first_ones_photons(void **state)
{
    test_server *server = *state;
    char scene[65], other[65];
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    test_scene(server, "b", other);
    assert_cache(run_map(server, scene, 3000), "miss", 3, 0);
    assert_cache(run_map(server, scene, 3000), "hit", 0, 3);
    assert_cache(run_map(server, scene, 5000), "extended", 2, 3);
    assert_cache(run_map(server, scene, 1000), "hit", 0, 1);
    assert_cache(run_map(server, other, 1000), "miss", 1, 0);
    test_reply list = test_get(server, "/v1/maps");
    assert_int_equal(pm_json_length(pm_json_get(list.json, "maps")), 4);
    const pm_json *map = pm_json_at(pm_json_get(list.json, "maps"), 0);
    char path[160];
    snprintf(path, sizeof path, "/v1/maps/%s", pm_json_get_text(map, "key", ""));
    test_reply one = test_get(server, path);
    assert_int_equal(one.status, 200);
    assert_text(one.json, "key", pm_json_get_text(map, "key", "-"));
    test_reply_clear(&one);
    test_reply_clear(&list);
}

static void two_jobs_for_the_same_photons_trace_them_once(void **state)
{
    test_server *server = *state;
    char scene[65], first[32], second[32];
    const char *const options[] = {"--jobs", "2", NULL};
    test_server_start(server, options);
    test_scene(server, "slow", scene);
    test_job(server, MAP, scene, first);
    test_until(server, first, "running");
    pm_json *job = NULL;
    do { /* until its photons are under way */
        char path[64];
        pm_json_free(job);
        snprintf(path, sizeof path, "/v1/jobs/%s", first);
        test_reply reply = test_get(server, path);
        job = reply.json;
        reply.json = NULL;
        test_reply_clear(&reply);
    } while (!pm_json_get(job, "progress"));
    pm_json_free(job);
    test_job(server, MAP, scene, second);
    assert_cache(test_finish(server, first), "miss", 3, 0);
    assert_cache(test_finish(server, second), "joined", 0, 3);
}

/* The first job has the family when it is cancelled, and must let it go. */
static void who_waits_for_a_dead_job_goes_on(void **state)
{
    test_server *server = *state;
    char scene[65], first[32], second[32];
    const char *const options[] = {"--jobs", "2", NULL};
    test_server_start(server, options);
    test_scene(server, "slow", scene);
    test_job(server, "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 900000}}",
             scene, first);
    test_until(server, first, "running");
    test_job(server, MAP, scene, second);
    test_until(server, second, "running");
    test_cancel(server, first);
    pm_json *job = test_finish(server, second);
    assert_text(job, "state", "done");
    pm_json_free(job);
}

#define TEST(name)                                                                             \
    cmocka_unit_test_setup_teardown(name, test_server_setup, test_server_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_scene_is_checked_and_kept_once),
        TEST(a_scene_with_an_error_names_its_place),
        TEST(a_bad_bundle_is_refused),
        TEST(a_crash_while_checking_ends_nothing_else),
        TEST(a_picture_is_made_and_fetched),
        TEST(values_come_a_line_a_sensor),
        TEST(bad_points_fail_the_job_with_their_line),
        TEST(what_a_job_names_must_be_there),
        TEST(an_idempotency_key_makes_one_job),
        TEST(each_way_to_die_is_named_and_ends_one_job),
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
        TEST(a_memory_limit_ends_one_job),
#endif
        TEST(a_worker_that_cannot_start_is_named),
        TEST(waiting_ends_with_the_state_or_the_time),
        TEST(a_queued_job_is_cancelled_at_once),
        TEST(a_second_job_finds_the_first_ones_photons),
        TEST(two_jobs_for_the_same_photons_trace_them_once),
        TEST(who_waits_for_a_dead_job_goes_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
