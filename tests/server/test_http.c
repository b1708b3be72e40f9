#include "cmocka_first.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/digest.h"
#include "harness.h"

/* The server as HTTP sees it: bodies, headers, limits, bad clients. */

static void assert_problem(test_reply reply, int status, const char *words)
{
    char type[256];
    assert_int_equal(reply.status, status);
    assert_non_null(test_header(&reply, "Content-Type", type));
    assert_string_equal(type, "application/problem+json");
    assert_int_equal(pm_json_get_integer(reply.json, "status", 0), status);
    assert_true(*pm_json_get_text(reply.json, "title", ""));
    if (!strstr(pm_json_get_text(reply.json, "detail", ""), words))
        fail_msg("\"%s\" is not in: %s", words, pm_json_get_text(reply.json, "detail", ""));
    test_reply_clear(&reply);
}

static void blobs_go_in_and_come_back(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    size_t size = (3 << 20) + 5;
    unsigned char *data = malloc(size);
    for (size_t i = 0; i < size; i++)
        data[i] = (unsigned char)(i * 2654435761U >> 13);
    char digest[65], hex[65], path[96], value[256];
    test_put(server, data, size, digest);
    pm_digest expected = pm_digest_of(data, size);
    pm_digest_hex(&expected, hex);
    assert_string_equal(digest, hex);
    test_expect(test_ask(server, "PUT", "/v1/blobs", NULL, data, size), 200);
    snprintf(path, sizeof path, "/v1/blobs/%s", digest);
    test_reply reply = test_get(server, path);
    assert_int_equal(reply.status, 200);
    assert_int_equal(reply.body.size, size);
    assert_memory_equal(reply.body.data, data, size);
    test_reply_clear(&reply);
    reply = test_ask(server, "HEAD", path, NULL, NULL, 0);
    assert_int_equal(reply.status, 200);
    assert_int_equal(reply.body.size, 0);
    assert_int_equal(atoi(test_header(&reply, "Content-Length", value)), size);
    test_reply_clear(&reply);
    free(data);
    test_put(server, "", 0, digest);
    snprintf(path, sizeof path, "/v1/blobs/%s", digest);
    test_expect(test_get(server, path), 200);
}

static void ranges_tags_and_conditions_hold(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    char digest[65], path[96], header[160], value[256];
    test_put(server, "0123456789", 10, digest);
    snprintf(path, sizeof path, "/v1/blobs/%s", digest);
    test_reply reply = test_ask(server, "GET", path, "Range: bytes=2-4\r\n", NULL, 0);
    assert_int_equal(reply.status, 206);
    assert_string_equal(test_header(&reply, "Content-Range", value), "bytes 2-4/10");
    assert_int_equal(reply.body.size, 3);
    assert_memory_equal(reply.body.data, "234", 3);
    test_reply_clear(&reply);
    reply = test_ask(server, "GET", path, "Range: bytes=10-\r\n", NULL, 0);
    assert_string_equal(test_header(&reply, "Content-Range", value), "bytes */10");
    assert_problem(reply, 416, "range");
    snprintf(header, sizeof header, "If-None-Match: \"%s\"\r\n", digest);
    reply = test_ask(server, "GET", path, header, NULL, 0);
    assert_int_equal(reply.body.size, 0);
    test_expect(reply, 304);
    snprintf(header, sizeof header, "Range: bytes=2-4\r\nIf-Range: \"%s\"\r\n", digest);
    test_expect(test_ask(server, "GET", path, header, NULL, 0), 206);
    test_expect(
        test_ask(server, "GET", path, "Range: bytes=2-4\r\nIf-Range: \"other\"\r\n", NULL, 0),
        200);
}

static void wrong_requests_get_their_own_status(void **state)
{
    test_server *server = *state;
    const char *const options[] = {"--blob-limit", "1000", NULL};
    char value[256];
    test_server_start(server, options);
    assert_problem(test_get(server, "/nothing"), 404, "openapi");
    assert_problem(test_get(server, "/v1/blobs/xyz"), 404, "digest");
    assert_problem(test_get(server, "/v1/jobs/17"), 404, "17");
    assert_problem(test_get(server, "/v1/jobs/17x"), 404, "17x");
    assert_problem(test_get(server, "/v1/scenes/abc"), 404, "scene");
    assert_problem(test_get(server, "/v1/maps/abc"), 404, "map");
    test_reply reply = test_ask(server, "POST", "/healthz", NULL, "", 0);
    assert_string_equal(test_header(&reply, "Allow", value), "GET, HEAD");
    assert_problem(reply, 405, "GET");
    reply = test_ask(server, "PATCH", "/v1/jobs", NULL, NULL, 0);
    assert_string_equal(test_header(&reply, "Allow", value), "POST, GET, HEAD");
    assert_problem(reply, 405, "POST");
    char *big = calloc(1, 1 << 21);
    memset(big, ' ', 1 << 21);
    assert_problem(test_ask(server, "PUT", "/v1/blobs", NULL, big, 1001), 413, "1000");
    assert_problem(test_ask(server, "POST", "/v1/jobs", "Content-Type: application/json\r\n",
                            big, (1 << 20) + 1),
                   413, "1048576");
    assert_problem(test_ask(server, "POST", "/v1/jobs", "Content-Type: application/json\r\n",
                            big, 1 << 20),
                   400, "JSON");
    free(big);
    assert_problem(
        test_ask(server, "POST", "/v1/jobs", "Content-Type: text/plain\r\n", "{}", 2), 415,
        "application/json");
    assert_problem(test_ask(server, "POST", "/v1/jobs", NULL, "{}", 2), 415,
                   "application/json");
    assert_problem(test_post(server, "/v1/jobs", "{\"kind\": \"map\",}"), 400, "line 1");
    assert_problem(test_post(server, "/v1/jobs", "{}"), 422, "kind");
    assert_problem(test_get(server, "/v1/jobs/1?wait=soon"), 422, "wait");
    assert_problem(test_get(server, "/v1/jobs/1?wait=61"), 422, "wait");
    assert_problem(test_get(server, "/v1/jobs?limit=0"), 422, "limit");
}

static void chunked_uploads_are_limited_too(void **state)
{
    test_server *server = *state;
    const char *const options[] = {"--blob-limit", "1000", NULL};
    test_server_start(server, options);
    static const char head[] =
        "PUT /v1/blobs HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
        "Transfer-Encoding: chunked\r\n\r\n";
    char piece[499]; /* 1f3 in hexadecimal */
    memset(piece, 'x', sizeof piece);
    for (int pieces = 2; pieces <= 3; pieces++) {
        int socket = test_connect(server);
        test_send(socket, head, strlen(head));
        for (int i = 0; i < pieces; i++) {
            test_send(socket, "1f3\r\n", 5);
            test_send(socket, piece, sizeof piece);
            test_send(socket, "\r\n", 2);
        }
        test_send(socket, "0\r\n\r\n", 5);
        test_expect(test_receive(socket), pieces == 2 ? 201 : 413);
    }
}

static void browsers_elsewhere_are_kept_out(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    assert_problem(test_ask(server, "GET", "/v1/jobs", "Host: evil.example\r\n", NULL, 0), 403,
                   "Host");
    assert_problem(
        test_ask(server, "GET", "/v1/jobs", "Origin: http://evil.example\r\n", NULL, 0), 403,
        "Origin");
    assert_problem(test_ask(server, "PUT", "/v1/blobs", "Origin: null\r\n", "x", 1), 403,
                   "Origin");
    test_expect(test_ask(server, "GET", "/v1/jobs", "Host: localhost:1\r\n", NULL, 0), 200);
}

static void tokens_open_the_door(void **state)
{
    test_server *server = *state;
    char path[128], value[256];
    snprintf(path, sizeof path, "%s/tokens", server->folder);
    FILE *file = fopen(path, "w");
    fputs("a-long-enough-token\n", file);
    fclose(file);
    chmod(path, 0600);
    const char *const options[] = {"--token-file", path, "--listen", "0.0.0.0:0", NULL};
    test_server_start(server, options);
    test_reply reply = test_get(server, "/v1/jobs");
    assert_string_equal(test_header(&reply, "WWW-Authenticate", value), "Bearer");
    assert_problem(reply, 401, "token");
    assert_problem(
        test_ask(server, "GET", "/v1/jobs", "Authorization: Bearer wrong\r\n", NULL, 0), 401,
        "token");
    test_expect(test_ask(server, "GET", "/v1/jobs",
                         "Authorization: Bearer a-long-enough-token\r\n", NULL, 0),
                200);
    test_expect(test_get(server, "/healthz"), 200); /* for probes */
}

static void open_addresses_without_token_are_refused(void **state)
{
    test_server *server = *state;
    char command[512];
    snprintf(command, sizeof command,
             PMSERVER " --store %s --listen 0.0.0.0:0 >/dev/null 2>%s/err", server->store,
             server->folder);
    assert_int_not_equal(system(command), 0);
    snprintf(command, sizeof command, "grep -q token-file %s/err", server->folder);
    assert_int_equal(system(command), 0);
}

/* A byte every tenth of a second: libmicrohttpd's own limit counts from the last one. */
static void a_client_that_trickles_is_shut_out(void **state)
{
    test_server *server = *state;
    const char *const options[] = {"--patience", "1", NULL};
    test_server_start(server, options);
    int socket = test_connect(server);
    bool open = true;
    test_send(socket, "GET /healthz HTTP/1.1\r\nX: ", 26);
    while (open) {
        open = send(socket, "x", 1, MSG_NOSIGNAL) == 1;
        nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    }
    close(socket);
    test_expect(test_get(server, "/healthz"), 200);
}

static void broken_requests_leave_the_server_standing(void **state)
{
    test_server *server = *state;
    static const char *const bad[] = {"",
                                      "\r\n\r\n",
                                      "GET\r\n\r\n",
                                      "GET / HTTP/9.9\r\n\r\n",
                                      "GET /healthz HTTP/1.1\r\n\r\n",
                                      "PUT /v1/blobs HTTP/1.1\r\nHost: localhost\r\n"
                                      "Content-Length: 100\r\n\r\nonly this",
                                      "PUT /v1/blobs HTTP/1.1\r\nHost: localhost\r\n"
                                      "Content-Length: -5\r\n\r\nx",
                                      "PUT /v1/blobs HTTP/1.1\r\nHost: localhost\r\n"
                                      "Transfer-Encoding: chunked\r\n\r\nzz\r\n"};
    const char *const options[] = {"--patience", "1", NULL}; /* for what they never finish */
    test_server_start(server, options);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int socket = test_connect(server);
        test_send(socket, bad[i], strlen(bad[i]));
        shutdown(socket, SHUT_WR);
        test_reply reply = test_receive(socket);
        assert_true(reply.status == 0 || reply.status >= 400);
        test_reply_clear(&reply);
    }
    test_expect(test_get(server, "/healthz"), 200);
}

static void operators_can_look(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    test_reply reply = test_get(server, "/readyz");
    assert_int_equal(reply.status, 200);
    const pm_json *sandbox = pm_json_get(reply.json, "sandbox");
    size_t missing = pm_json_length(pm_json_get(sandbox, "lacking"));
    assert_int_equal(missing, !pm_json_get_bool(sandbox, "landlock", false) +
                                  !pm_json_get_bool(sandbox, "seccomp", false));
    test_reply_clear(&reply);
    reply = test_get(server, "/metrics");
    pm_bytes_u8(&reply.body, 0);
    assert_non_null(
        strstr((char *)reply.body.data, "pm_http_requests_total{code=\"2xx\"} 1\n"));
    assert_non_null(strstr((char *)reply.body.data, "pm_jobs{state=\"running\"} 0\n"));
    test_reply_clear(&reply);
}

/* Every path of the document is served with the methods it names. */
static void the_openapi_document_is_true(void **state)
{
    test_server *server = *state;
    test_server_start_plain(server);
    test_reply reply = test_get(server, "/openapi.json");
    assert_int_equal(reply.status, 200);
    pm_json *paths = pm_json_get(reply.json, "paths");
    assert_true(pm_json_length(paths) >= 14);
    for (const char *path = NULL; (path = pm_json_next(paths, path));) {
        pm_json *methods = pm_json_get(paths, path);
        char allow[256];
        test_reply refused = test_ask(server, "TRACE", path, NULL, NULL, 0);
        assert_int_equal(refused.status, 405);
        assert_non_null(test_header(&refused, "Allow", allow));
        for (const char *method = NULL; (method = pm_json_next(methods, method));)
            assert_non_null(strcasestr(allow, method));
        test_reply_clear(&refused);
    }
    const pm_json *job =
        pm_json_get(pm_json_get(pm_json_get(reply.json, "components"), "schemas"), "job");
    assert_non_null(pm_json_get(pm_json_get(job, "properties"), "caustic"));
    test_reply_clear(&reply);
}

#define TEST(name)                                                                             \
    cmocka_unit_test_setup_teardown(name, test_server_setup, test_server_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(blobs_go_in_and_come_back),
        TEST(ranges_tags_and_conditions_hold),
        TEST(wrong_requests_get_their_own_status),
        TEST(chunked_uploads_are_limited_too),
        TEST(browsers_elsewhere_are_kept_out),
        TEST(tokens_open_the_door),
        TEST(open_addresses_without_token_are_refused),
        TEST(a_client_that_trickles_is_shut_out),
        TEST(broken_requests_leave_the_server_standing),
        TEST(operators_can_look),
        TEST(the_openapi_document_is_true),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
