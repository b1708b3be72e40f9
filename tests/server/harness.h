#ifndef PM_TESTS_SERVER_HARNESS_H
#define PM_TESTS_SERVER_HARNESS_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "base/bytes.h"
#include "json.h"

/* A whole pmserver with a folder of its own, and an HTTP client as small as tests of a server
 * need: it sends exactly the bytes it is told, also wrong ones. Anything unexpected fails the
 * test. */

typedef struct test_server {
    char folder[64], store[96], output[96];
    pid_t pid;
    char host[64];
    int port; /* 0: Unix socket `socket_path` */
    char socket_path[96];
    const char *worker;
} test_server;

/* cmocka fixtures: *state is a test_server with its folder, not yet started. */
int test_server_setup(void **state);
/* Stops what still runs; fails unless it ends in order and, with sanitizers, without a leak. */
int test_server_teardown(void **state);

/* Starts it with the options given (NULL at the end), and waits until it listens. */
void test_server_start(test_server *server, const char *const *options);
void test_server_start_plain(test_server *server);

/* Signals and waits; returns the wait status. */
int test_server_stop(test_server *server, int signal);

/* ---- HTTP ---- */

typedef struct test_reply {
    int status;
    char head[4096];
    pm_bytes body;
    pm_json *json; /* of the body, if it is JSON */
} test_reply;

/* `headers` is NULL or lines that end in \r\n. */
test_reply test_ask(const test_server *server, const char *method, const char *path,
                    const char *headers, const void *body, size_t size);
test_reply test_get(const test_server *server, const char *path);
test_reply test_post(const test_server *server, const char *path, const char *json);
void test_reply_clear(test_reply *reply);

/* A header's value, or NULL; lives in `out`. */
const char *test_header(const test_reply *reply, const char *name, char out[256]);

/* Asserts the status, frees the reply. */
void test_expect(test_reply reply, int status);

/* A connected socket, for requests that no client would make. */
int test_connect(const test_server *server);
void test_send(int socket, const void *data, size_t size);
test_reply test_receive(int socket); /* until the other side closes; closes too */

/* ---- what tests do again and again ---- */

/* Stores bytes; their digest. */
void test_put(const test_server *server, const void *data, size_t size, char digest[65]);
/* Posts a scene's text, of which the JSON needs no escapes; its id. */
void test_scene(const test_server *server, const char *text, char id[65]);
/* Posts a job (`format` with one %s for the scene); its id. */
void test_job(const test_server *server, const char *format, const char *scene, char id[32]);
/* Waits until a job has ended; the document, to be freed. */
pm_json *test_finish(const test_server *server, const char *id);
/* Cancels a job that has not ended. */
void test_cancel(const test_server *server, const char *id);
/* Waits until a job's state is `state`. */
void test_until(const test_server *server, const char *id, const char *state);

#endif
