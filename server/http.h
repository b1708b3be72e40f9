#ifndef PM_SERVER_HTTP_H
#define PM_SERVER_HTTP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "access.h"
#include "base/bytes.h"
#include "json.h"

/* HTTP, over libmicrohttpd: listening, reading requests, waiting, replying. What is served is
 * in a table of routes. http.c is the one file that includes microhttpd.h. */

typedef struct pm_http pm_http;
typedef struct pm_exchange pm_exchange;

typedef enum pm_turn {
    PM_TURN_REPLY, /* the handler has made its reply */
    PM_TURN_WAIT,  /* call it again after pm_http_changed or pm_exchange_wait_until */
} pm_turn;

typedef enum pm_body {
    PM_BODY_NONE,
    PM_BODY_JSON,  /* at most 1 MiB, Content-Type application/json, in pm_exchange_body */
    PM_BODY_BYTES, /* any size, piece by piece to `receive` */
} pm_body;

typedef struct pm_route {
    const char *method;  /* GET serves HEAD too */
    const char *pattern; /* a `*` stands for one part of the path */
    pm_body body;
    bool is_open; /* needs no token */
    pm_turn (*handle)(void *service, pm_exchange *exchange);
    /* A piece of the body, or size 0 when it has begun. False: the handler is called at the end
     * to explain; nothing more is received. */
    bool (*receive)(void *service, pm_exchange *exchange, const void *data, size_t size);
} pm_route;

typedef struct pm_http_options {
    const pm_route *routes; /* ended by a NULL method */
    void *service;
    const pm_access *access;
    uint64_t body_limit;  /* of PM_BODY_BYTES; 0 = none */
    unsigned patience_ms; /* see guard.h */
    unsigned connections; /* most at a time, a listener */
} pm_http_options;

PM_MUST_USE pm_status pm_http_new(const pm_http_options *options, pm_http **out, pm_error *err);
/* Answers on a listening socket, which is taken. */
PM_MUST_USE pm_status pm_http_listen(pm_http *http, int socket, pm_door door, pm_error *err);
/* Wakes those who wait, lets replies go out and closes every connection. */
void pm_http_stop(pm_http *http);
void pm_http_free(pm_http *http); /* stops too; NULL is fine */

/* Calls every waiting handler again. From any thread. */
void pm_http_changed(pm_http *http);

typedef struct pm_http_counts {
    uint64_t requests, by_class[6]; /* by_class[4]: statuses 400 to 499 */
    uint64_t connections;           /* now */
} pm_http_counts;

pm_http_counts pm_http_count(pm_http *http);

/* ---- a request ---- */

const char *pm_exchange_header(const pm_exchange *exchange, const char *name); /* or NULL */
const char *pm_exchange_query(const pm_exchange *exchange, const char *name);  /* or NULL */
/* The part of the path for the n-th `*`, or "". */
const char *pm_exchange_part(const pm_exchange *exchange, unsigned n);
const pm_bytes *pm_exchange_body(const pm_exchange *exchange);

/* What a handler remembers between its calls; freed with the exchange. */
void *pm_exchange_state(const pm_exchange *exchange);
void pm_exchange_set_state(pm_exchange *exchange, void *state,
                           void (*free_state)(void *service, void *state));
/* Sets when a waiting handler is called again at the latest; false if that time has passed. The
 * first call fixes it. */
bool pm_exchange_wait(pm_exchange *exchange, double seconds);

/* ---- its reply; each returns PM_TURN_REPLY ---- */

pm_turn pm_reply_json(pm_exchange *exchange, unsigned status, pm_json *json); /* steals */
pm_turn pm_reply_problem(pm_exchange *exchange, unsigned status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
pm_turn pm_reply_problem_json(pm_exchange *exchange, pm_json *problem); /* steals */
pm_turn pm_reply_text(pm_exchange *exchange, unsigned status, const char *type,
                      const char *text);
pm_turn pm_reply_empty(pm_exchange *exchange, unsigned status);
void pm_reply_header(pm_exchange *exchange, const char *name, const char *value);

/* Bytes that are read as they are sent. */
typedef struct pm_source {
    uint64_t size;
    void *context;
    /* Fills the buffer from `at`; returns how many bytes, or -1 if they cannot be read. */
    int64_t (*read)(void *context, uint64_t at, void *buffer, size_t size);
    void (*free)(void *context);
} pm_source;

/* Replies with a source, or a range of it, or 304; `tag` without quotes. Takes the source. */
pm_turn pm_reply_source(pm_exchange *exchange, pm_source source, const char *type,
                        const char *tag);

#endif
