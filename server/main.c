#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

#include "lease.h"
#include "listen.h"
#include "options.h"
#include "service.h"

/* pmserver: options, then everything is started, then signals are waited for, then everything
 * is stopped in the opposite order. */

/* How long to wait for the store: the process of a worker that a killed server was just
 * starting holds it for a moment; a private server that is ending holds it until its workers
 * have gone. */
enum { LOCK_WAIT_MS = 2000, PRIVATE_LOCK_WAIT_MS = 10000 };

struct server {
    pm_options options;
    pm_access access;
    pm_service service;
    pm_lease *lease;
    int signals; /* signalfd */
};

static void say(const struct server *server, const char *text)
{
    if (server->options.verbose)
        fprintf(stderr, "pmserver: %s\n", text);
}

static int complain(const pm_error *err)
{
    char text[1200];
    pm_error_format(err, text, sizeof text);
    fprintf(stderr, "pmserver: %s\n", text);
    return 1;
}

/* SIGINT and SIGTERM are read from a descriptor; every thread inherits the mask. */
static pm_status take_signals(struct server *server, pm_error *err)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGHUP);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file size limit is a full disk */
    if (pthread_sigmask(SIG_BLOCK, &set, NULL) ||
        (server->signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK)) < 0)
        return pm_error_set(err, PM_E_IO, "signals: %s", strerror(errno));
    return PM_OK;
}

static void on_change(void *context)
{
    const struct server *server = context;
    pm_http_changed(server->service.http);
}

static void on_report(void *context, int64_t job, const char *state)
{
    const struct server *server = context;
    if (server->options.verbose)
        fprintf(stderr, "pmserver: job %" PRId64 ": %s\n", job, state);
}

static pm_status open_store(struct server *server, pm_error *err)
{
    const pm_store_options options = {
        .path = server->options.store,
        .limit_bytes = server->options.store_limit,
        .lock_wait_ms = server->options.exit_when_idle ? PRIVATE_LOCK_WAIT_MS : LOCK_WAIT_MS};
    return pm_store_open(&options, &server->service.store, err);
}

static pm_status start_jobs(struct server *server, pm_error *err)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    long share = processors / (long)server->options.jobs;
    const pm_jobs_options options = {.run = {.store = server->service.store,
                                             .worker_path = server->options.worker,
                                             .memory_bytes = server->options.memory_limit,
                                             .cpu_seconds = server->options.cpu_limit,
                                             .threads = share > 1 ? (unsigned)share : 1},
                                     .workers = server->options.jobs,
                                     .context = server,
                                     .report = on_report,
                                     .changed = on_change};
    return pm_jobs_new(&options, &server->service.jobs, err);
}

static pm_status start_http(struct server *server, pm_error *err)
{
    const pm_http_options options = {.routes = pm_service_routes,
                                     .service = &server->service,
                                     .access = &server->access,
                                     .body_limit = server->options.blob_limit,
                                     .patience_ms = 1000 * server->options.patience_s,
                                     .connections = server->options.connections};
    return pm_http_new(&options, &server->service.http, err);
}

/* ---- listening ---- */

static pm_status listen_tcp(struct server *server, pm_error *err)
{
    int socket;
    pm_door door;
    char url[128];
    pm_status st = pm_listen_tcp(server->options.listen, &socket, &door, url, err);
    if (st)
        return st;
    if (door == PM_DOOR_NETWORK && !server->access.token_count) {
        close(socket);
        return pm_error_set(err, PM_E_RANGE,
                            "--listen %s can be reached from elsewhere: give --token-file too",
                            server->options.listen);
    }
    st = pm_http_listen(server->service.http, socket, door, err);
    if (!st)
        printf("listening on %s\n", url);
    return st;
}

static pm_status listen_unix(struct server *server, pm_error *err)
{
    int socket;
    pm_status st = pm_listen_unix(server->options.unix_path, &socket, err);
    if (!st)
        st = pm_http_listen(server->service.http, socket, PM_DOOR_UNIX, err);
    if (!st)
        printf("listening on unix:%s\n", server->options.unix_path);
    return st;
}

static pm_status open_doors(struct server *server, pm_error *err)
{
    pm_status st = PM_OK;
    if (server->options.exit_when_idle)
        st = pm_lease_new(server->options.exit_when_idle, &server->lease, err);
    if (!st && server->options.listen)
        st = listen_tcp(server, err);
    if (!st && server->options.unix_path)
        st = listen_unix(server, err);
    fflush(stdout);
    return st;
}

/* ---- life ---- */

static pm_status start(struct server *server, pm_error *err)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    server->service.started_ms = (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
    server->service.sandbox = pm_sandbox_available();
    server->service.worker_path = server->options.worker;
    pm_status st = take_signals(server, err);
    if (!st && server->options.token_file)
        st = pm_access_read_tokens(server->options.token_file, &server->access, err);
    if (!st)
        st = open_store(server, err);
    if (!st)
        st = start_http(server, err);
    if (!st)
        st = start_jobs(server, err);
    return st ? st : open_doors(server, err);
}

/* Until a signal comes or nobody uses a private server any more. True in the second case. */
static bool serve(struct server *server)
{
    struct pollfd ends[] = {
        {.fd = server->signals, .events = POLLIN},
        {.fd = server->lease ? pm_lease_descriptor(server->lease) : -1, .events = POLLIN}};
    while (poll(ends, 2, -1) < 0 && errno == EINTR)
        ;
    return ends[1].revents != 0;
}

/* Jobs that go on running are the next server's, unless `cancel`: their clients have gone. The
 * lease is let go last: who waits for it finds everything closed. */
static void stop(struct server *server, bool cancel)
{
    pm_service *service = &server->service;
    if (server->options.unix_path && service->http)
        unlink(server->options.unix_path);
    if (service->http)
        pm_http_stop(service->http);
    if (service->jobs)
        pm_jobs_stop(service->jobs, cancel);
    pm_jobs_free(service->jobs);
    pm_http_free(service->http);
    pm_store_close(service->store);
    pm_lease_free(server->lease);
    pm_access_clear(&server->access);
    pm_options_clear(&server->options);
}

int main(int argc, char **argv)
{
    struct server server = {.signals = -1};
    pm_error err = PM_ERROR_INIT;
    if (pm_options_parse(argc, argv, &server.options, &err))
        return complain(&err) + 1;
    if (server.options.help) {
        fputs(pm_options_help, stdout);
        pm_options_clear(&server.options);
        return 0;
    }
    int status = start(&server, &err) ? complain(&err) : 0;
    bool cancel = false;
    if (!status) {
        say(&server, "serving");
        cancel = serve(&server);
        say(&server, cancel ? "the last client has gone" : "stopping");
    }
    stop(&server, cancel);
    return status;
}
