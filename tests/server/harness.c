#include "harness.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static void sleep_ms(long ms)
{
    nanosleep(&(struct timespec){.tv_nsec = ms * 1000000}, NULL);
}

/* ---- servers ---- */

int test_server_setup(void **state)
{
    test_server *server = calloc(1, sizeof *server);
    strcpy(server->folder, "/tmp/pm-server-XXXXXX");
    if (!mkdtemp(server->folder))
        return -1;
    snprintf(server->store, sizeof server->store, "%s/s.sqlite", server->folder);
    snprintf(server->output, sizeof server->output, "%s/out", server->folder);
    server->worker = FAKE_WORKER;
    *state = server;
    return 0;
}

int test_server_teardown(void **state)
{
    test_server *server = *state;
    char command[128];
    int failed = server->pid && test_server_stop(server, SIGTERM) != 0;
    snprintf(command, sizeof command, "rm -rf '%s'", server->folder);
    failed = system(command) || failed;
    free(server);
    return failed;
}

/* Reads where it listens from its first line. */
static bool read_address(test_server *server)
{
    char text[256] = "";
    FILE *file = fopen(server->output, "r");
    bool found = file && fgets(text, sizeof text, file) && strchr(text, '\n');
    if (file)
        fclose(file);
    if (!found)
        return false;
    if (sscanf(text, "listening on unix:%95s", server->socket_path) == 1)
        return true;
    return sscanf(text, "listening on http://%*[^:]:%d", &server->port) == 1;
}

static void wait_until_listening(test_server *server)
{
    while (!read_address(server)) {
        int status;
        if (waitpid(server->pid, &status, WNOHANG) == server->pid)
            fail_msg("pmserver ended with status %d", status);
        sleep_ms(5);
    }
    snprintf(server->host, sizeof server->host, "127.0.0.1:%d", server->port);
}

/* It dies with the test, also if that crashes. */
static _Noreturn void become_server(const test_server *server, char *const *arguments)
{
    int output = open(server->output, O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    if (!prctl(PR_SET_PDEATHSIG, SIGKILL) && output >= 0 && dup2(output, 1) == 1)
        execv(PMSERVER, arguments);
    _exit(127);
}

void test_server_start(test_server *server, const char *const *options)
{
    const char *arguments[32] = {"pmserver", "--store", server->store, "--worker",
                                 server->worker};
    size_t count = 5;
    bool has_address = false;
    for (; options && *options; options++) {
        has_address =
            has_address || !strcmp(*options, "--listen") || !strcmp(*options, "--unix");
        arguments[count++] = *options;
    }
    if (!has_address) {
        arguments[count++] = "--listen";
        arguments[count++] = "127.0.0.1:0";
    }
    unlink(server->output);
    server->pid = fork();
    if (!server->pid)
        become_server(server, (char *const *)(uintptr_t)arguments);
    assert_true(server->pid > 0);
    wait_until_listening(server);
}

void test_server_start_plain(test_server *server)
{
    test_server_start(server, NULL);
}

int test_server_stop(test_server *server, int signal)
{
    int status = 0;
    kill(server->pid, signal);
    while (waitpid(server->pid, &status, 0) < 0 && errno == EINTR)
        ;
    server->pid = 0;
    return status;
}

/* ---- HTTP ---- */

int test_connect(const test_server *server)
{
    if (!server->port) {
        struct sockaddr_un where = {.sun_family = AF_UNIX};
        strcpy(where.sun_path, server->socket_path);
        int made = socket(AF_UNIX, SOCK_STREAM, 0);
        assert_int_equal(connect(made, (struct sockaddr *)&where, sizeof where), 0);
        return made;
    }
    struct sockaddr_in where = {.sin_family = AF_INET,
                                .sin_port = htons((uint16_t)server->port),
                                .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int made = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(connect(made, (struct sockaddr *)&where, sizeof where), 0);
    return made;
}

/* A server that has made up its mind may close before it has read all. */
void test_send(int socket, const void *data, size_t size)
{
    const char *at = data;
    while (size) {
        ssize_t sent = send(socket, at, size, MSG_NOSIGNAL);
        if (sent < 0 && (errno == EPIPE || errno == ECONNRESET))
            return;
        assert_true(sent > 0);
        at += sent;
        size -= (size_t)sent;
    }
}

static void split(pm_bytes *all, test_reply *reply)
{
    char *end = all->size ? memmem(all->data, all->size, "\r\n\r\n", 4) : NULL;
    if (!end)
        return; /* closed without a reply: status 0 */
    size_t head = (size_t)(end - (char *)all->data);
    assert_true(head < sizeof reply->head);
    memcpy(reply->head, all->data, head);
    reply->status = atoi(reply->head + strlen("HTTP/1.1 "));
    if (reply->status == 100) {
        pm_bytes rest = {.data = all->data + head + 4, .size = all->size - head - 4};
        memset(reply->head, 0, sizeof reply->head);
        split(&rest, reply);
        return;
    }
    pm_bytes_append(&reply->body, end + 4, all->size - head - 4);
}

test_reply test_receive(int socket)
{
    test_reply reply = {0};
    pm_bytes all = {0};
    char buffer[65536];
    for (ssize_t got; (got = recv(socket, buffer, sizeof buffer, 0)) > 0;)
        pm_bytes_append(&all, buffer, (size_t)got);
    close(socket);
    split(&all, &reply);
    pm_bytes_clear(&all);
    char type[256];
    if (test_header(&reply, "Content-Type", type) && strstr(type, "json"))
        assert_int_equal(
            pm_json_parse(reply.body.data, reply.body.size, "reply", &reply.json, NULL), PM_OK);
    return reply;
}

test_reply test_ask(const test_server *server, const char *method, const char *path,
                    const char *headers, const void *body, size_t size)
{
    char head[2048], length[64] = "";
    if (body)
        snprintf(length, sizeof length, "Content-Length: %zu\r\n", size);
    bool has_host = headers && strstr(headers, "Host:");
    snprintf(head, sizeof head, "%s %s HTTP/1.1\r\n%s%s%s%s%sConnection: close\r\n\r\n", method,
             path, has_host ? "" : "Host: ", has_host ? "" : server->host,
             has_host ? "" : "\r\n", headers ? headers : "", length);
    int socket = test_connect(server);
    test_send(socket, head, strlen(head));
    if (body)
        test_send(socket, body, size);
    return test_receive(socket);
}

test_reply test_get(const test_server *server, const char *path)
{
    return test_ask(server, "GET", path, NULL, NULL, 0);
}

test_reply test_post(const test_server *server, const char *path, const char *json)
{
    return test_ask(server, "POST", path, "Content-Type: application/json\r\n", json,
                    strlen(json));
}

void test_reply_clear(test_reply *reply)
{
    pm_bytes_clear(&reply->body);
    pm_json_free(reply->json);
    reply->json = NULL;
}

const char *test_header(const test_reply *reply, const char *name, char out[256])
{
    for (const char *line = reply->head; (line = strstr(line, "\r\n"));) {
        line += 2;
        size_t length = strlen(name);
        if (strncasecmp(line, name, length) != 0 || line[length] != ':')
            continue;
        snprintf(out, 256, "%.*s", (int)strcspn(line + length + 2, "\r"), line + length + 2);
        return out;
    }
    return NULL;
}

void test_expect(test_reply reply, int status)
{
    if (reply.status != status)
        fail_msg("status %d instead of %d: %.*s", reply.status, status, (int)reply.body.size,
                 reply.body.data ? (const char *)reply.body.data : "");
    test_reply_clear(&reply);
}

/* ---- again and again ---- */

void test_put(const test_server *server, const void *data, size_t size, char digest[65])
{
    test_reply reply = test_ask(server, "PUT", "/v1/blobs", NULL, data, size);
    assert_int_equal(reply.status / 100, 2);
    strcpy(digest, pm_json_get_text(reply.json, "digest", ""));
    assert_int_equal(strlen(digest), 64);
    test_reply_clear(&reply);
}

void test_scene(const test_server *server, const char *text, char id[65])
{
    char body[1024];
    snprintf(body, sizeof body, "{\"text\": \"%s\"}", text);
    test_reply reply = test_post(server, "/v1/scenes", body);
    assert_int_equal(reply.status / 100, 2);
    strcpy(id, pm_json_get_text(reply.json, "id", ""));
    assert_int_equal(strlen(id), 64);
    test_reply_clear(&reply);
}

void test_job(const test_server *server, const char *format, const char *scene, char id[32])
{
    char body[1024];
    const char *place = strstr(format, "%s");
    snprintf(body, sizeof body, "%.*s%s%s", (int)(place - format), format, scene, place + 2);
    test_reply reply = test_post(server, "/v1/jobs", body);
    assert_int_equal(reply.status, 202);
    snprintf(id, 32, "%s", pm_json_get_text(reply.json, "id", ""));
    test_reply_clear(&reply);
}

static pm_json *look(const test_server *server, const char *id, const char *query)
{
    char path[96];
    snprintf(path, sizeof path, "/v1/jobs/%s%s", id, query);
    test_reply reply = test_get(server, path);
    assert_int_equal(reply.status, 200);
    pm_json *json = reply.json;
    reply.json = NULL;
    test_reply_clear(&reply);
    return json;
}

pm_json *test_finish(const test_server *server, const char *id)
{
    for (;;) {
        pm_json *job = look(server, id, "?wait=10");
        const char *state = pm_json_get_text(job, "state", "");
        if (strcmp(state, "queued") != 0 && strcmp(state, "running") != 0)
            return job;
        pm_json_free(job);
    }
}

void test_until(const test_server *server, const char *id, const char *wanted)
{
    for (;;) {
        pm_json *job = look(server, id, "");
        bool reached = !strcmp(pm_json_get_text(job, "state", ""), wanted);
        pm_json_free(job);
        if (reached)
            return;
        sleep_ms(10);
    }
}

void test_cancel(const test_server *server, const char *id)
{
    char path[96];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    test_reply reply = test_ask(server, "DELETE", path, NULL, NULL, 0);
    assert_true(reply.status == 202 || reply.status == 200); /* it may have ended by now */
    test_reply_clear(&reply);
}
