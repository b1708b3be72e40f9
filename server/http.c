#include "http.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <microhttpd.h>

#include "guard.h"
#include "problem.h"
#include "range.h"

enum {
    LISTENERS = 2,
    POOL = 2,
    JSON_BODY_MAX = 1 << 20,
    SOURCE_BLOCK = 128 << 10,
    PATH_MAX_BYTES = 512,
    TICK_MS = 500,
    LINGER_MS = 2000, /* for replies under way when the server stops */
};

struct listener {
    pm_http *http;
    struct MHD_Daemon *daemon;
    pm_door door;
    int quiet; /* its socket once it is to stop: closed when no thread of it can look any more
                */
};

struct pm_http {
    pm_http_options options;
    struct listener listeners[LISTENERS];
    unsigned listener_count;
    pm_guard *guard;
    pthread_t watch;
    bool watching;

    pthread_mutex_t lock; /* guards everything below */
    pthread_cond_t wake;  /* of the watch, and of pm_http_stop */
    uint64_t changes;
    pm_exchange *waiting; /* suspended */
    unsigned under_way;   /* exchanges */
    bool stopping;
    pm_http_counts counts;
};

struct pm_exchange {
    pm_exchange *next; /* in the list of the waiting */
    pm_http *http;
    struct MHD_Connection *connection;
    pm_guarded *guarded;
    pm_door door;
    const pm_route *route;
    char path[PATH_MAX_BYTES];
    pm_bytes body;
    uint64_t received;
    bool is_over;    /* more came than may */
    bool is_refused; /* by `receive`; the rest of the body is passed over */
    void *state;
    void (*free_state)(void *service, void *state);
    double deadline_ms; /* of waiting; 0 = not set */
    unsigned status;
    struct MHD_Response *response;
};

static double now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

/* ---- what handlers see ---- */

const char *pm_exchange_header(const pm_exchange *exchange, const char *name)
{
    return MHD_lookup_connection_value(exchange->connection, MHD_HEADER_KIND, name);
}

const char *pm_exchange_query(const pm_exchange *exchange, const char *name)
{
    return MHD_lookup_connection_value(exchange->connection, MHD_GET_ARGUMENT_KIND, name);
}

const pm_bytes *pm_exchange_body(const pm_exchange *exchange)
{
    return &exchange->body;
}

void *pm_exchange_state(const pm_exchange *exchange)
{
    return exchange->state;
}

void pm_exchange_set_state(pm_exchange *exchange, void *state,
                           void (*free_state)(void *service, void *state))
{
    exchange->state = state;
    exchange->free_state = free_state;
}

bool pm_exchange_wait(pm_exchange *exchange, double seconds)
{
    double now = now_ms();
    if (exchange->deadline_ms == 0)
        exchange->deadline_ms = now + 1e3 * seconds;
    return now < exchange->deadline_ms;
}

/* ---- replies ---- */

static void set_response(pm_exchange *exchange, unsigned status, struct MHD_Response *response)
{
    if (exchange->response)
        MHD_destroy_response(exchange->response);
    exchange->status = status;
    exchange->response = response;
}

void pm_reply_header(pm_exchange *exchange, const char *name, const char *value)
{
    if (exchange->response)
        MHD_add_response_header(exchange->response, name, value);
}

static void reply_copy(pm_exchange *exchange, unsigned status, const char *type,
                       const char *text)
{
    set_response(
        exchange, status,
        MHD_create_response_from_buffer(strlen(text), (void *)text, MHD_RESPMEM_MUST_COPY));
    pm_reply_header(exchange, MHD_HTTP_HEADER_CONTENT_TYPE, type);
    pm_reply_header(exchange, MHD_HTTP_HEADER_CACHE_CONTROL, "no-store");
}

static const char no_memory[] =
    "{\"type\":\"about:blank\",\"status\":503,\"title\":"
    "\"Service Unavailable\",\"detail\":\"no memory for a reply\"}\n";

static pm_turn reply_document(pm_exchange *exchange, unsigned status, const char *type,
                              pm_json *json)
{
    char *text = json ? pm_json_pretty(json) : NULL;
    pm_bytes line = {0};
    pm_json_free(json);
    if (text)
        pm_bytes_format(&line, "%s\n", text);
    free(text);
    if (line.size && !pm_bytes_status(&line))
        reply_copy(exchange, status, type, (const char *)line.data);
    else
        reply_copy(exchange, 503, "application/problem+json", no_memory);
    pm_bytes_clear(&line);
    return PM_TURN_REPLY;
}

pm_turn pm_reply_json(pm_exchange *exchange, unsigned status, pm_json *json)
{
    return reply_document(exchange, status, "application/json", json);
}

pm_turn pm_reply_problem_json(pm_exchange *exchange, pm_json *problem)
{
    unsigned status = (unsigned)pm_json_get_integer(problem, "status", 500);
    return reply_document(exchange, status, "application/problem+json", problem);
}

pm_turn pm_reply_problem(pm_exchange *exchange, unsigned status, const char *format, ...)
{
    char detail[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(detail, sizeof detail, format, args);
    va_end(args);
    return pm_reply_problem_json(exchange, pm_problem(status, detail));
}

pm_turn pm_reply_text(pm_exchange *exchange, unsigned status, const char *type,
                      const char *text)
{
    reply_copy(exchange, status, type, text);
    return PM_TURN_REPLY;
}

pm_turn pm_reply_empty(pm_exchange *exchange, unsigned status)
{
    set_response(exchange, status,
                 MHD_create_response_from_buffer(0, (void *)"", MHD_RESPMEM_PERSISTENT));
    return PM_TURN_REPLY;
}

/* ---- replies that are read as they are sent ---- */

struct stream {
    pm_source source;
    uint64_t first; /* of the range */
};

static ssize_t read_stream(void *context, uint64_t at, char *buffer, size_t size)
{
    const struct stream *stream = context;
    int64_t got = stream->source.read(stream->source.context, stream->first + at, buffer, size);
    return got > 0 ? (ssize_t)got : MHD_CONTENT_READER_END_WITH_ERROR;
}

static void free_stream(void *context)
{
    struct stream *stream = context;
    stream->source.free(stream->source.context);
    free(stream);
}

static pm_turn reply_range(pm_exchange *exchange, const pm_source *source, unsigned status,
                           uint64_t first, uint64_t length)
{
    struct stream *stream = malloc(sizeof *stream);
    if (!stream) {
        source->free(source->context);
        return pm_reply_problem_json(exchange, NULL);
    }
    *stream = (struct stream){*source, first};
    struct MHD_Response *response = MHD_create_response_from_callback(
        length, SOURCE_BLOCK, read_stream, stream, free_stream);
    if (!response)
        free_stream(stream);
    set_response(exchange, status, response);
    pm_guard_sending(exchange->http->guard, exchange->guarded, length);
    return PM_TURN_REPLY;
}

/* If-Range asks for the whole if the bytes are others than it knows. */
static pm_range range_of(const pm_exchange *exchange, uint64_t size, const char *tag,
                         uint64_t *first, uint64_t *length)
{
    const char *condition = pm_exchange_header(exchange, "If-Range");
    bool use = !condition || !strcmp(condition, tag);
    return pm_range_parse(use ? pm_exchange_header(exchange, "Range") : NULL, size, first,
                          length);
}

pm_turn pm_reply_source(pm_exchange *exchange, pm_source source, const char *type,
                        const char *tag)
{
    char quoted[128], content_range[96];
    uint64_t first, length;
    snprintf(quoted, sizeof quoted, "\"%s\"", tag);
    if (pm_tag_listed(pm_exchange_header(exchange, "If-None-Match"), quoted)) {
        source.free(source.context);
        pm_reply_empty(exchange, 304);
        pm_reply_header(exchange, "ETag", quoted);
        return PM_TURN_REPLY;
    }
    pm_range range = range_of(exchange, source.size, quoted, &first, &length);
    if (range == PM_RANGE_NOWHERE) {
        source.free(source.context);
        pm_reply_problem(exchange, 416, "the range begins after the end");
        snprintf(content_range, sizeof content_range, "bytes */%llu",
                 (unsigned long long)source.size);
        pm_reply_header(exchange, "Content-Range", content_range);
        return PM_TURN_REPLY;
    }
    reply_range(exchange, &source, range == PM_RANGE_PART ? 206 : 200, first, length);
    pm_reply_header(exchange, "Content-Type", type);
    pm_reply_header(exchange, "ETag", quoted);
    pm_reply_header(exchange, "Accept-Ranges", "bytes");
    pm_reply_header(exchange, "X-Content-Type-Options", "nosniff");
    if (range == PM_RANGE_PART) {
        snprintf(content_range, sizeof content_range, "bytes %llu-%llu/%llu",
                 (unsigned long long)first, (unsigned long long)(first + length - 1),
                 (unsigned long long)source.size);
        pm_reply_header(exchange, "Content-Range", content_range);
    }
    return PM_TURN_REPLY;
}

/* ---- routes ---- */

/* The n-th part of a path, counted from 0: its start and length. NULL if there are fewer. */
static const char *part_of(const char *path, unsigned n, size_t *length)
{
    for (const char *at = path; *at == '/'; n--) {
        at++;
        *length = strcspn(at, "/");
        if (!n)
            return at;
        at += *length;
    }
    return NULL;
}

static bool matches(const char *pattern, const char *path)
{
    for (unsigned n = 0;; n++) {
        size_t wanted_length = 0, length = 0;
        const char *wanted = part_of(pattern, n, &wanted_length);
        const char *part = part_of(path, n, &length);
        if (!wanted || !part)
            return !wanted && !part;
        bool is_any = wanted_length == 1 && *wanted == '*';
        if (!(is_any && length) &&
            (length != wanted_length || memcmp(part, wanted, length) != 0))
            return false;
    }
}

/* The exchange's copy of the path has its slashes cut into ends of text. */
const char *pm_exchange_part(const pm_exchange *exchange, unsigned n)
{
    const char *at = exchange->path;
    size_t length;
    for (unsigned i = 0;; i++) {
        const char *wanted = part_of(exchange->route->pattern, i, &length);
        if (!wanted)
            return "";
        if (length == 1 && *wanted == '*' && !n--)
            return at + 1;
        at += 1 + strlen(at + 1);
    }
}

static bool serves(const pm_route *route, const char *method)
{
    return !strcmp(route->method, method) ||
           (!strcmp(route->method, "GET") && !strcmp(method, "HEAD"));
}

static void refuse_method(pm_exchange *exchange, const char *path)
{
    char allow[128] = "";
    for (const pm_route *route = exchange->http->options.routes; route->method; route++) {
        if (!matches(route->pattern, path))
            continue;
        size_t used = strlen(allow);
        snprintf(allow + used, sizeof allow - used, "%s%s", used ? ", " : "",
                 !strcmp(route->method, "GET") ? "GET, HEAD" : route->method);
    }
    if (!*allow) {
        pm_reply_problem(exchange, 404, "there is nothing at this path; see /openapi.json");
        return;
    }
    pm_reply_problem(exchange, 405, "this path allows %s", allow);
    pm_reply_header(exchange, "Allow", allow);
}

/* ---- the head of a request ---- */

static bool may_enter(pm_exchange *exchange)
{
    const char *why = "";
    unsigned status = pm_access_check(exchange->http->options.access, exchange->door,
                                      pm_exchange_header(exchange, "Host"),
                                      pm_exchange_header(exchange, "Origin"),
                                      pm_exchange_header(exchange, "Authorization"), &why);
    if (!status || (status == 401 && exchange->route && exchange->route->is_open))
        return true;
    pm_reply_problem(exchange, status, "%s", why);
    if (status == 401)
        pm_reply_header(exchange, "WWW-Authenticate", "Bearer");
    return false;
}

static uint64_t body_limit(const pm_exchange *exchange)
{
    uint64_t limit = exchange->http->options.body_limit;
    if (exchange->route->body == PM_BODY_BYTES)
        return limit ? limit : UINT64_MAX;
    return exchange->route->body == PM_BODY_JSON ? JSON_BODY_MAX : 0;
}

static void refuse_size(pm_exchange *exchange)
{
    pm_reply_problem(exchange, 413, "the body may have at most %llu bytes",
                     (unsigned long long)body_limit(exchange));
}

static bool has_fitting_body(pm_exchange *exchange)
{
    const char *type = pm_exchange_header(exchange, "Content-Type");
    const char *length = pm_exchange_header(exchange, "Content-Length");
    if (length && strtoull(length, NULL, 10) > body_limit(exchange)) {
        refuse_size(exchange);
        return false;
    }
    if (exchange->route->body != PM_BODY_JSON ||
        (type && !strncasecmp(type, "application/json", 16) &&
         (!type[16] || strchr("; ", type[16]))))
        return true;
    pm_reply_problem(exchange, 415, "Content-Type must be application/json");
    return false;
}

/* Looks at the head alone. False if the reply is made already. */
static bool open_exchange(pm_exchange *exchange, const char *url, const char *method)
{
    for (const pm_route *route = exchange->http->options.routes; route->method; route++)
        if (!exchange->route && serves(route, method) && matches(route->pattern, url))
            exchange->route = route;
    if (!may_enter(exchange))
        return false;
    if (!exchange->route || strlen(url) >= sizeof exchange->path) {
        refuse_method(exchange, url);
        return false;
    }
    strcpy(exchange->path, url);
    for (char *c = exchange->path + 1; *c; c++)
        if (*c == '/')
            *c = '\0';
    return has_fitting_body(exchange);
}

/* ---- the body ---- */

static void receive(pm_exchange *exchange, const char *data, size_t size)
{
    exchange->received += size;
    pm_guard_received(exchange->http->guard, exchange->guarded, size);
    if (exchange->received > body_limit(exchange))
        exchange->is_over = true;
    else if (exchange->route->body == PM_BODY_JSON)
        pm_bytes_append(&exchange->body, data, size);
    else if (!exchange->is_refused)
        exchange->is_refused =
            !exchange->route->receive(exchange->http->options.service, exchange, data, size);
}

/* ---- answering and waiting ---- */

static enum MHD_Result queue(pm_exchange *exchange)
{
    pm_http *http = exchange->http;
    if (!exchange->response)
        return MHD_NO; /* no memory even for a reply: the connection is closed */
    pthread_mutex_lock(&http->lock);
    http->counts.requests++;
    http->counts.by_class[exchange->status / 100 < 6 ? exchange->status / 100 : 0]++;
    pthread_mutex_unlock(&http->lock);
    return MHD_queue_response(exchange->connection, exchange->status, exchange->response);
}

/* Puts the exchange aside until something changes. False if something did since `changes`. */
static bool put_aside(pm_exchange *exchange, uint64_t changes)
{
    pm_http *http = exchange->http;
    pthread_mutex_lock(&http->lock);
    bool quiet = http->changes == changes && !http->stopping;
    if (quiet) {
        MHD_suspend_connection(exchange->connection);
        exchange->next = http->waiting;
        http->waiting = exchange;
        pthread_cond_broadcast(&http->wake);
    }
    pthread_mutex_unlock(&http->lock);
    return quiet;
}

static enum MHD_Result answer(pm_exchange *exchange)
{
    pm_http *http = exchange->http;
    pm_guard_working(http->guard, exchange->guarded);
    for (;;) {
        pthread_mutex_lock(&http->lock);
        uint64_t changes = http->changes;
        bool stopping = http->stopping;
        pthread_mutex_unlock(&http->lock);
        if (stopping)
            pm_reply_problem(exchange, 503, "the server is stopping");
        else if (exchange->is_over)
            refuse_size(exchange);
        else if (exchange->route->handle(http->options.service, exchange) == PM_TURN_WAIT) {
            if (put_aside(exchange, changes))
                return MHD_YES;
            continue;
        }
        return queue(exchange);
    }
}

/* Called with the lock held. Resumes those whose time has come, or all. */
static void resume(pm_http *http, bool all)
{
    double now = now_ms();
    for (pm_exchange **at = &http->waiting; *at;) {
        pm_exchange *exchange = *at;
        if (all || (exchange->deadline_ms > 0 && exchange->deadline_ms <= now)) {
            *at = exchange->next;
            MHD_resume_connection(exchange->connection);
        } else {
            at = &exchange->next;
        }
    }
}

void pm_http_changed(pm_http *http)
{
    pthread_mutex_lock(&http->lock);
    http->changes++;
    resume(http, true);
    pthread_mutex_unlock(&http->lock);
}

/* ---- called by libmicrohttpd ---- */

static pm_guarded *guarded_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

static pm_exchange *new_exchange(struct listener *listener, struct MHD_Connection *connection)
{
    pm_exchange *exchange = calloc(1, sizeof *exchange);
    if (!exchange)
        return NULL;
    exchange->http = listener->http;
    exchange->door = listener->door;
    exchange->connection = connection;
    exchange->guarded = guarded_of(connection);
    pm_guard_receiving(listener->http->guard, exchange->guarded);
    pthread_mutex_lock(&listener->http->lock);
    listener->http->under_way++;
    pthread_mutex_unlock(&listener->http->lock);
    return exchange;
}

static enum MHD_Result on_request(void *context, struct MHD_Connection *connection,
                                  const char *url, const char *method, const char *version,
                                  const char *upload, size_t *upload_size, void **own)
{
    (void)version;
    pm_exchange *exchange = *own;
    if (!exchange) {
        exchange = *own = new_exchange(context, connection);
        if (!exchange)
            return MHD_NO;
        return open_exchange(exchange, url, method) ? MHD_YES : queue(exchange);
    }
    if (!*upload_size)
        return answer(exchange);
    receive(exchange, upload, *upload_size);
    *upload_size = 0;
    /* Who goes on sending after a refusal is cut off. */
    bool is_flood =
        exchange->is_over && exchange->received - body_limit(exchange) > JSON_BODY_MAX;
    return is_flood ? MHD_NO : MHD_YES;
}

static void on_completed(void *context, struct MHD_Connection *connection, void **own,
                         enum MHD_RequestTerminationCode code)
{
    (void)connection;
    (void)code;
    pm_http *http = context;
    pm_exchange *exchange = *own;
    if (!exchange)
        return;
    pm_guard_idle(http->guard, exchange->guarded);
    if (exchange->free_state)
        exchange->free_state(http->options.service, exchange->state);
    if (exchange->response)
        MHD_destroy_response(exchange->response);
    pm_bytes_clear(&exchange->body);
    free(exchange);
    *own = NULL;
    pthread_mutex_lock(&http->lock);
    http->under_way--;
    pthread_cond_broadcast(&http->wake);
    pthread_mutex_unlock(&http->lock);
}

static void on_connection(void *context, struct MHD_Connection *connection, void **own,
                          enum MHD_ConnectionNotificationCode code)
{
    pm_http *http = context;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
        pm_guard_remove(http->guard, *own);
        *own = NULL;
        return;
    }
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    *own = info ? pm_guard_add(http->guard, info->connect_fd) : NULL;
}

/* ---- the watch: deadlines of waiting, slow connections ---- */

/* Called with the lock held. */
static double next_look_ms(const pm_http *http)
{
    double next = now_ms() + TICK_MS;
    for (const pm_exchange *exchange = http->waiting; exchange; exchange = exchange->next)
        if (exchange->deadline_ms > 0 && exchange->deadline_ms < next)
            next = exchange->deadline_ms;
    return next;
}

static void wait_until(pm_http *http, double ms)
{
    struct timespec until = {.tv_sec = (time_t)(ms / 1e3)};
    until.tv_nsec = (long)((ms - 1e3 * (double)until.tv_sec) * 1e6);
    pthread_cond_timedwait(&http->wake, &http->lock, &until);
}

static void *watch_main(void *context)
{
    pm_http *http = context;
    pthread_mutex_lock(&http->lock);
    while (!http->stopping) {
        wait_until(http, next_look_ms(http));
        resume(http, http->stopping);
        pthread_mutex_unlock(&http->lock);
        pm_guard_sweep(http->guard);
        pthread_mutex_lock(&http->lock);
    }
    pthread_mutex_unlock(&http->lock);
    return NULL;
}

/* ---- starting and stopping ---- */

static void init_locks(pm_http *http)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&http->wake, &attributes);
    pthread_condattr_destroy(&attributes);
    pthread_mutex_init(&http->lock, NULL);
}

pm_status pm_http_new(const pm_http_options *options, pm_http **out, pm_error *err)
{
    pm_http *http = calloc(1, sizeof *http);
    if (!http)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the server");
    http->options = *options;
    init_locks(http);
    http->guard = pm_guard_new(options->patience_ms);
    http->watching = http->guard && !pthread_create(&http->watch, NULL, watch_main, http);
    if (!http->watching) {
        pm_http_free(http);
        return pm_error_set(err, PM_E_MEMORY, "cannot start a thread");
    }
    *out = http;
    return PM_OK;
}

pm_status pm_http_listen(pm_http *http, int socket, pm_door door, pm_error *err)
{
    struct listener *listener = &http->listeners[http->listener_count];
    *listener = (struct listener){.http = http, .door = door};
    unsigned seconds = http->options.patience_ms / 1000 + 1;
    listener->daemon = MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME, 0, NULL, NULL, on_request,
        listener, MHD_OPTION_LISTEN_SOCKET, socket, MHD_OPTION_THREAD_POOL_SIZE, (unsigned)POOL,
        MHD_OPTION_CONNECTION_LIMIT, http->options.connections, MHD_OPTION_CONNECTION_TIMEOUT,
        seconds, MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_NOTIFY_COMPLETED, on_completed,
        http, MHD_OPTION_NOTIFY_CONNECTION, on_connection, http, MHD_OPTION_END);
    if (!listener->daemon) {
        close(socket);
        return pm_error_set(err, PM_E_IO, "cannot start the HTTP server");
    }
    http->listener_count++;
    return PM_OK;
}

void pm_http_stop(pm_http *http)
{
    for (unsigned i = 0; i < http->listener_count; i++) {
        struct listener *listener = &http->listeners[i];
        listener->quiet = MHD_quiesce_daemon(listener->daemon);
        if (listener->quiet >= 0)
            shutdown(listener->quiet, SHUT_RDWR);
    }
    pthread_mutex_lock(&http->lock);
    http->stopping = true;
    pthread_cond_broadcast(&http->wake);
    resume(http, true);
    double end = now_ms() + LINGER_MS;
    while (http->under_way && now_ms() < end)
        wait_until(http, end);
    pthread_mutex_unlock(&http->lock);
    for (unsigned i = 0; i < http->listener_count; i++) {
        MHD_stop_daemon(http->listeners[i].daemon);
        if (http->listeners[i].quiet >= 0)
            close(http->listeners[i].quiet);
    }
    http->listener_count = 0;
    if (http->watching)
        pthread_join(http->watch, NULL);
    http->watching = false;
}

void pm_http_free(pm_http *http)
{
    if (!http)
        return;
    pm_http_stop(http);
    pm_guard_free(http->guard);
    pthread_cond_destroy(&http->wake);
    pthread_mutex_destroy(&http->lock);
    free(http);
}

pm_http_counts pm_http_count(pm_http *http)
{
    pthread_mutex_lock(&http->lock);
    pm_http_counts counts = http->counts;
    pthread_mutex_unlock(&http->lock);
    counts.connections = pm_guard_count(http->guard);
    return counts;
}
