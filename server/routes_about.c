#include <inttypes.h>
#include <unistd.h>

#include "service.h"

/* What operators and their tools ask. */

pm_turn pm_about_health(void *service, pm_exchange *exchange)
{
    (void)service;
    return pm_reply_json(exchange, 200, pm_json_pack("{s:s}", "status", "ok"));
}

static pm_json *lacking(const pm_sandbox_parts *parts)
{
    pm_json *list = pm_json_pack("[]");
    bool made =
        list && (parts->landlock || pm_json_append(list, pm_json_pack("s", "landlock"))) &&
        (parts->seccomp || pm_json_append(list, pm_json_pack("s", "seccomp"))) &&
        (parts->no_new_privs || pm_json_append(list, pm_json_pack("s", "no_new_privs")));
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

pm_turn pm_about_ready(void *context, pm_exchange *exchange)
{
    const pm_service *service = context;
    bool ready = !access(service->worker_path, X_OK);
    return pm_reply_json(
        exchange, ready ? 200 : 503,
        pm_json_pack("{s:b, s:b, s:{s:b, s:b, s:b, s:o}}", "ready", ready, "worker", ready,
                     "sandbox", "no_new_privs", service->sandbox.no_new_privs, "landlock",
                     service->sandbox.landlock, "seccomp", service->sandbox.seccomp, "lacking",
                     lacking(&service->sandbox)));
}

static void metric(pm_bytes *text, const char *name, const char *type, const char *help)
{
    pm_bytes_format(text, "# HELP pm_%s %s\n# TYPE pm_%s %s\n", name, help, name, type);
}

static void simple(pm_bytes *text, const char *name, const char *type, const char *help,
                   uint64_t value)
{
    metric(text, name, type, help);
    pm_bytes_format(text, "pm_%s %" PRIu64 "\n", name, value);
}

static void jobs_metrics(pm_bytes *text, const pm_jobs_counts *jobs)
{
    metric(text, "jobs", "gauge", "Jobs that have not ended, by state.");
    pm_bytes_format(text, "pm_jobs{state=\"queued\"} %" PRIu64 "\n", jobs->queued);
    pm_bytes_format(text, "pm_jobs{state=\"running\"} %" PRIu64 "\n", jobs->running);
    simple(text, "jobs_waiting", "gauge", "Running jobs that wait for photons of another job.",
           jobs->waiting);
    metric(text, "jobs_ended_total", "counter", "Jobs that ended since the start, by state.");
    pm_bytes_format(text, "pm_jobs_ended_total{state=\"done\"} %" PRIu64 "\n", jobs->done);
    pm_bytes_format(text, "pm_jobs_ended_total{state=\"failed\"} %" PRIu64 "\n", jobs->failed);
    pm_bytes_format(text, "pm_jobs_ended_total{state=\"cancelled\"} %" PRIu64 "\n",
                    jobs->cancelled);
    simple(text, "batches_read_total", "counter", "Batches of photons taken from the store.",
           jobs->batches_read);
    simple(text, "batches_kept_total", "counter", "Batches of photons put into the store.",
           jobs->batches_kept);
}

static void http_metrics(pm_bytes *text, const pm_http_counts *http)
{
    metric(text, "http_requests_total", "counter", "Requests by class of status.");
    for (int i = 2; i < 6; i++)
        pm_bytes_format(text, "pm_http_requests_total{code=\"%dxx\"} %" PRIu64 "\n", i,
                        http->by_class[i]);
    simple(text, "http_connections", "gauge", "Open connections.", http->connections);
}

pm_turn pm_about_metrics(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_jobs_counts jobs = pm_jobs_count(service->jobs);
    pm_http_counts http = pm_http_count(service->http);
    pm_bytes text = {0};
    jobs_metrics(&text, &jobs);
    http_metrics(&text, &http);
    simple(&text, "store_bytes", "gauge", "Bytes in use in the store.",
           pm_store_bytes(service->store));
    simple(&text, "store_batches", "gauge", "Batches of photons in the store.",
           pm_store_batch_count(service->store));
    simple(&text, "store_evicted_total", "counter", "Blobs evicted since the start.",
           pm_store_evicted(service->store));
    metric(&text, "start_time_seconds", "gauge", "Start of the server since 1970.");
    pm_bytes_format(&text, "pm_start_time_seconds %.3f\n", 1e-3 * (double)service->started_ms);
    pm_bytes_u8(&text, 0);
    pm_turn turn = pm_bytes_status(&text)
                       ? pm_reply_problem_json(exchange, NULL)
                       : pm_reply_text(exchange, 200, "text/plain; version=0.0.4",
                                       (const char *)text.data);
    pm_bytes_clear(&text);
    return turn;
}

pm_turn pm_about_openapi(void *service, pm_exchange *exchange)
{
    (void)service;
    return pm_reply_json(exchange, 200, pm_openapi());
}
