#include "cmocka_first.h"

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "harness.h"

/* What a server leaves to the next one, however it ends. Workers as in test_service.c. */

#define RENDER "{\"kind\": \"render\", \"scene\": \"%s\", \"x\": 8, \"y\": 8}"
#define MAP    "{\"kind\": \"map\", \"scene\": \"%s\", \"global\": {\"count\": 3000}}"

static void assert_state(const test_server *server, const char *id, const char *expected)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    test_reply reply = test_get(server, path);
    assert_string_equal(pm_json_get_text(reply.json, "state", "?"), expected);
    test_reply_clear(&reply);
}

static int64_t attempts(const test_server *server, const char *id)
{
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    test_reply reply = test_get(server, path);
    int64_t count = pm_json_get_integer(reply.json, "attempts", -1);
    test_reply_clear(&reply);
    return count;
}

static pid_t parent_of(const char *process)
{
    char path[300];
    long parent = 0;
    snprintf(path, sizeof path, "/proc/%s/stat", process);
    FILE *file = fopen(path, "r");
    if (!file)
        return 0;                                      /* it has just ended */
    if (fscanf(file, "%*d %*s %*c %ld", &parent) != 1) /* no name here has blanks */
        parent = 0;
    fclose(file);
    return (pid_t)parent;
}

static pid_t worker_of(const test_server *server)
{
    pid_t worker = 0;
    DIR *processes = opendir("/proc");
    for (struct dirent *entry; !worker && (entry = readdir(processes));)
        if (parent_of(entry->d_name) == server->pid)
            worker = (pid_t)atol(entry->d_name);
    closedir(processes);
    assert_true(worker > 0);
    return worker;
}

static void workers_die_with_a_killed_server(void **state)
{
    test_server *server = *state;
    char hang[65], id[32];
    test_server_start_plain(server);
    test_scene(server, "hang", hang);
    test_job(server, RENDER, hang, id);
    test_until(server, id, "running");
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    for (bool started = false; !started;) {
        test_reply reply = test_get(server, path);
        started = pm_json_get(reply.json, "progress");
        test_reply_clear(&reply);
    }
    pid_t worker = worker_of(server);
    assert_int_equal(kill(worker, 0), 0);
    test_server_stop(server, SIGKILL);
    while (!kill(worker, 0)) /* for ever, if it lives on */
        usleep(1000);
}

static void finished_work_survives_kill_9(void **state)
{
    test_server *server = *state;
    char scene[65], done[32], running[32], queued[32], hang[65];
    test_server_start_plain(server);
    test_scene(server, "a", scene);
    test_scene(server, "hang", hang);
    test_job(server, MAP, scene, done);
    pm_json_free(test_finish(server, done));
    test_job(server, RENDER, scene, done);
    pm_json_free(test_finish(server, done));
    test_job(server, RENDER, hang, running);
    test_job(server, RENDER, scene, queued);
    test_until(server, running, "running");
    int status = test_server_stop(server, SIGKILL);
    assert_true(WIFSIGNALED(status));
    test_server_start_plain(server);
    assert_state(server, done, "done");
    char path[96];
    snprintf(path, sizeof path, "/v1/jobs/%s/result", done);
    test_expect(test_get(server, path), 200);
    test_until(server, running, "running"); /* again */
    assert_int_equal(attempts(server, running), 2);
    test_cancel(server, running);
    pm_json *job = test_finish(server, queued);
    assert_string_equal(pm_json_get_text(job, "state", ""), "done");
    pm_json_free(job);
    /* The photons of the first server's job are there for the second's. */
    test_job(server, MAP, scene, done);
    job = test_finish(server, done);
    assert_string_equal(pm_json_get_text(job, "cache", ""), "hit");
    pm_json_free(job);
}

static void a_job_that_kills_its_server_is_not_run_for_ever(void **state)
{
    test_server *server = *state;
    char hang[65], id[32];
    test_server_start_plain(server);
    test_scene(server, "hang", hang);
    test_job(server, RENDER, hang, id);
    for (int i = 1; i <= 3; i++) {
        test_until(server, id, "running");
        assert_int_equal(attempts(server, id), i);
        test_server_stop(server, SIGKILL);
        test_server_start_plain(server);
    }
    assert_state(server, id, "failed");
}

static void sigterm_ends_workers_and_requeues(void **state)
{
    test_server *server = *state;
    char hang[65], id[32];
    test_server_start_plain(server);
    test_scene(server, "hang", hang);
    test_job(server, RENDER, hang, id);
    for (int i = 0; i < 5; i++) { /* more often than a crash is forgiven */
        test_until(server, id, "running");
        int status = test_server_stop(server, i % 2 ? SIGINT : SIGTERM);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
        test_server_start_plain(server);
    }
    test_until(server, id, "running");
    assert_int_equal(attempts(server, id), 1);
}

/* A waiting client gets an answer, not a broken connection. */
static void stopping_answers_those_who_wait(void **state)
{
    test_server *server = *state;
    char hang[65], id[32], request[256];
    test_server_start_plain(server);
    test_scene(server, "hang", hang);
    test_job(server, RENDER, hang, id);
    test_until(server, id, "running");
    snprintf(request, sizeof request,
             "GET /v1/jobs/%s?wait=60 HTTP/1.1\r\nHost: localhost\r\n\r\n", id);
    int socket = test_connect(server);
    test_send(socket, request, strlen(request));
    test_reply probe = test_get(server, "/healthz"); /* by now the server has read it */
    test_reply_clear(&probe);
    kill(server->pid, SIGTERM);
    test_reply reply = test_receive(socket);
    assert_int_equal(reply.status, 503);
    test_reply_clear(&reply);
}

static void a_second_server_on_the_store_is_refused(void **state)
{
    test_server *server = *state;
    char command[512];
    test_server_start_plain(server);
    snprintf(command, sizeof command,
             PMSERVER " --store %s --listen 127.0.0.1:0 >/dev/null 2>%s/err", server->store,
             server->folder);
    assert_int_not_equal(system(command), 0);
    snprintf(command, sizeof command, "grep -q 'process id %ld' %s/err", (long)server->pid,
             server->folder);
    assert_int_equal(system(command), 0);
}

/* A limit on file sizes stands for a full disk; the server inherits it. */
static void limit_files(rlim_t bytes)
{
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void a_full_disk_is_507_and_loses_nothing(void **state)
{
    enum { SIZE = 12 << 20 };
    test_server *server = *state;
    char digest[65], path[96], scene[65], id[32];
    unsigned char *data = malloc(SIZE);
    for (size_t i = 0; i < SIZE; i++)
        data[i] = (unsigned char)(i * 2654435761U >> 13);
    limit_files(6 << 20);
    test_server_start_plain(server);
    limit_files(RLIM_INFINITY);
    test_put(server, data, 1000, digest);
    test_scene(server, "a", scene);
    test_expect(test_ask(server, "PUT", "/v1/blobs", NULL, data, SIZE), 507);
    snprintf(path, sizeof path, "/v1/blobs/%s", digest);
    test_expect(test_get(server, path), 200);
    test_server_stop(server, SIGTERM);
    test_server_start_plain(server); /* with room again */
    test_expect(test_get(server, path), 200);
    test_expect(test_ask(server, "PUT", "/v1/blobs", NULL, data, SIZE), 201);
    test_job(server, RENDER, scene, id);
    pm_json *job = test_finish(server, id);
    assert_string_equal(pm_json_get_text(job, "state", ""), "done");
    pm_json_free(job);
    free(data);
}

/* Three files of 4 MiB and less do not fit together: the job fails, says why and leaves none.
 */
static void a_result_that_does_not_fit_fails_its_job(void **state)
{
    test_server *server = *state;
    char scene[65], id[32];
    limit_files(6 << 20);
    test_server_start_plain(server);
    limit_files(RLIM_INFINITY);
    test_scene(server, "a", scene);
    test_job(server,
             "{\"kind\": \"render\", \"scene\": \"%s\", \"x\": 640, \"y\": 640, \"formats\": "
             "[\"exr\", \"hdr\", \"png\"]}",
             scene, id);
    pm_json *job = test_finish(server, id);
    assert_string_equal(pm_json_get_text(job, "state", ""), "failed");
    assert_int_equal(pm_json_get_integer(pm_json_get(job, "problem"), "status", 0), 507);
    assert_int_equal(pm_json_length(pm_json_get(job, "result")), 0);
    pm_json_free(job);
}

#define TEST(name)                                                                             \
    cmocka_unit_test_setup_teardown(name, test_server_setup, test_server_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(finished_work_survives_kill_9),
        TEST(workers_die_with_a_killed_server),
        TEST(a_job_that_kills_its_server_is_not_run_for_ever),
        TEST(sigterm_ends_workers_and_requeues),
        TEST(stopping_answers_those_who_wait),
        TEST(a_second_server_on_the_store_is_refused),
        TEST(a_full_disk_is_507_and_loses_nothing),
        TEST(a_result_that_does_not_fit_fails_its_job),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
