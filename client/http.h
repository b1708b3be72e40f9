#ifndef PM_CLIENT_HTTP_H
#define PM_CLIENT_HTTP_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/bytes.h"
#include "base/error.h"

/* HTTP to one server, over TCP or a Unix socket. http.c is the one file that includes curl.h.
 */
typedef struct pm_http pm_http;

typedef struct pm_response {
    long status;        /* HTTP status */
    pm_bytes body;      /* empty if it went to a file */
    char location[512]; /* header Location, or "" */
} pm_response;

/* What a request carries. Zeros are fine. */
typedef struct pm_http_body {
    const char *type; /* Content-Type */
    const void *data; /* from memory ... */
    uint64_t size;
    FILE *file; /* ... or from here, `size` bytes of it */
    const char *idempotency_key;
} pm_http_body;

/* `url` is http://HOST:PORT; `unix_path` (or NULL) replaces its connection by a socket; `token`
 * (or NULL) is sent as a bearer token. NULL if memory is short. */
pm_http *pm_http_new(const char *url, const char *unix_path, const char *token);
void pm_http_free(pm_http *http);

/* Sends and receives. `into` (or NULL) gets the body of a 2xx answer instead of out->body.
 * PM_E_UNREACHABLE if the server cannot be reached or the connection breaks, PM_E_CANCELLED if
 * a signal came meanwhile; any HTTP status is PM_OK. Clear *out with
 * pm_response_clear. */
PM_MUST_USE pm_status pm_http_send(pm_http *http, const char *method, const char *path,
                                   const pm_http_body *body, FILE *into, pm_response *out,
                                   pm_error *err);
void pm_response_clear(pm_response *response);

/* Waiting ends once pm_interrupted is at least `signals`: 1 at first, 2 for what must still be
 * said after the first. */
void pm_http_set_patience(pm_http *http, int signals);

#endif
