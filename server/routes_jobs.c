#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "service.h"

enum { WAIT_MAX = 60, LIST_DEFAULT = 100, LIST_MAX = 1000, KEY_MAX = 255 };

/* ---- submitting ---- */

struct inputs {
    pm_digest list[1 + PM_MAP_KINDS];
    size_t count;
};

static pm_status need_blob(pm_service *service, const pm_digest *digest, const char *member,
                           struct inputs *inputs, pm_error *err)
{
    pm_blob blob;
    pm_error why = PM_ERROR_INIT;
    pm_status st = pm_store_blob_find(service->store, digest, &blob, &why);
    if (st)
        return pm_error_set_at(err, st, member, 0, 0, "%s", why.text);
    inputs->list[inputs->count++] = *digest;
    return PM_OK;
}

/* Everything the request names must be there. */
static pm_status check_references(pm_service *service, const pm_request *request,
                                  struct inputs *inputs, pm_error *err)
{
    pm_digest id;
    pm_scene_record scene;
    pm_error why = PM_ERROR_INIT;
    pm_status st = pm_digest_parse(request->scene, &id)
                       ? pm_store_scene_get(service->store, &id, &scene, &why)
                       : PM_E_MISSING;
    if (st)
        return pm_error_set_at(err, st, "scene", 0, 0, "%s", why.text);
    pm_scene_record_clear(&scene);
    if (request->has_points)
        st = need_blob(service, &request->points, "points", inputs, err);
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++)
        if (request->has_map_file[kind])
            st = need_blob(service, &request->map_file[kind],
                           pm_map_kind_name((pm_map_kind)kind), inputs, err);
    return st;
}

static const char *location_of(int64_t id, char out[48])
{
    snprintf(out, 48, "/v1/jobs/%lld", (long long)id);
    return out;
}

static pm_turn reply_submitted(pm_exchange *exchange, int64_t id, bool existed)
{
    char number[24], location[48];
    snprintf(number, sizeof number, "%lld", (long long)id);
    pm_reply_json(exchange, existed ? 200 : 202,
                  existed ? pm_json_pack("{s:s}", "id", number)
                          : pm_json_pack("{s:s, s:s}", "id", number, "state", "queued"));
    pm_reply_header(exchange, "Location", location_of(id, location));
    return PM_TURN_REPLY;
}

static pm_turn submit(pm_service *service, pm_exchange *exchange, const pm_request *request)
{
    pm_error err = PM_ERROR_INIT;
    struct inputs inputs = {.count = 0};
    const char *key = pm_exchange_header(exchange, "Idempotency-Key");
    if (key && (!*key || strlen(key) > KEY_MAX))
        return pm_reply_problem(exchange, 400, "Idempotency-Key has 1 to %d characters",
                                KEY_MAX);
    pm_status st = check_references(service, request, &inputs, &err);
    if (st)
        return pm_reply_error(exchange, &err);
    char *text = pm_json_text(request->json);
    if (!text)
        return pm_reply_problem_json(exchange, NULL);
    int64_t id = 0;
    bool existed = false;
    const pm_new_job job = {text, key, inputs.list, inputs.count};
    st = pm_jobs_submit(service->jobs, &job, &id, &existed, &err);
    free(text);
    if (st == PM_E_MISMATCH)
        return pm_reply_error(exchange, &err);
    return st ? pm_reply_store_error(exchange, &err) : reply_submitted(exchange, id, existed);
}

pm_turn pm_job_post(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_request request;
    const pm_bytes *body = pm_exchange_body(exchange);
    if (pm_bytes_status(body))
        return pm_reply_problem_json(exchange, NULL);
    if (pm_request_parse(body->data, body->size, &request, &err))
        return pm_reply_error(exchange, &err);
    pm_turn turn = submit(service, exchange, &request);
    pm_request_clear(&request);
    return turn;
}

/* ---- looking ---- */

static bool read_id(pm_exchange *exchange, int64_t *id)
{
    char *end;
    const char *text = pm_exchange_part(exchange, 0);
    *id = strtoll(text, &end, 10);
    return end != text && !*end && *id > 0;
}

static pm_turn reply_no_job(pm_exchange *exchange)
{
    return pm_reply_problem(exchange, 404, "there is no job %.32s",
                            pm_exchange_part(exchange, 0));
}

/* Links go into the list of results; the answer's members to the top. */
static bool complete(pm_json *document, int64_t id)
{
    pm_json *answer = pm_json_get(document, "answer"), *list = pm_json_get(document, "result");
    bool made = pm_json_type_of(answer) != PM_JSON_OBJECT || pm_json_merge(document, answer);
    pm_json_remove(document, "answer");
    if (pm_json_type_of(pm_json_get(document, "problem")) == PM_JSON_NULL)
        pm_json_remove(document, "problem");
    for (size_t i = 0; i < pm_json_length(list) && made; i++) {
        char url[160];
        pm_json *result = pm_json_at(list, i);
        snprintf(url, sizeof url, "/v1/jobs/%lld/result?name=%s", (long long)id,
                 pm_json_get_text(result, "name", ""));
        made = pm_json_put(result, "url", pm_json_pack("s", url));
    }
    return made;
}

static bool is_over(const pm_json *document)
{
    const char *state = pm_json_get_text(document, "state", "");
    return strcmp(state, "queued") != 0 && strcmp(state, "running") != 0;
}

/* The state that the caller saw when it began to wait. */
struct seen {
    char state[16];
};

static void free_seen(void *service, void *state)
{
    (void)service;
    free(state);
}

static bool has_changed(pm_exchange *exchange, const pm_json *document)
{
    const char *state = pm_json_get_text(document, "state", "");
    struct seen *seen = pm_exchange_state(exchange);
    if (seen)
        return strcmp(seen->state, state) != 0;
    seen = calloc(1, sizeof *seen);
    if (!seen)
        return true;
    snprintf(seen->state, sizeof seen->state, "%s", state);
    pm_exchange_set_state(exchange, seen, free_seen);
    return false;
}

static bool read_wait(pm_exchange *exchange, double *seconds)
{
    const char *text = pm_exchange_query(exchange, "wait");
    char *end;
    *seconds = 0;
    if (!text)
        return true;
    *seconds = strtod(text, &end);
    return end != text && !*end && *seconds >= 0 && *seconds <= WAIT_MAX;
}

pm_turn pm_job_get(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_json *document = NULL;
    int64_t id;
    double seconds;
    if (!read_wait(exchange, &seconds))
        return pm_reply_problem(exchange, 422, "wait is 0 to %d seconds", WAIT_MAX);
    if (!read_id(exchange, &id))
        return reply_no_job(exchange);
    pm_status st = pm_jobs_get(service->jobs, id, &document, &err);
    if (st)
        return st == PM_E_MISSING ? reply_no_job(exchange)
                                  : pm_reply_store_error(exchange, &err);
    if (seconds > 0 && !is_over(document) && !has_changed(exchange, document) &&
        pm_exchange_wait(exchange, seconds)) {
        pm_json_free(document);
        return PM_TURN_WAIT;
    }
    if (!complete(document, id)) {
        pm_json_free(document);
        document = NULL;
    }
    return pm_reply_json(exchange, 200, document);
}

pm_turn pm_job_list(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_json *list = NULL;
    const char *text = pm_exchange_query(exchange, "limit");
    char *end = NULL;
    long limit = text ? strtol(text, &end, 10) : LIST_DEFAULT;
    if ((text && (end == text || *end)) || limit < 1 || limit > LIST_MAX)
        return pm_reply_problem(exchange, 422, "limit is 1 to %d jobs", LIST_MAX);
    pm_status st = pm_store_job_list(service->store, (unsigned)limit, &list, &err);
    return pm_reply_list(exchange, "jobs", st, list, &err);
}

/* ---- cancelling ---- */

pm_turn pm_job_delete(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    int64_t id;
    if (!read_id(exchange, &id))
        return reply_no_job(exchange);
    pm_status st = pm_jobs_cancel(service->jobs, id, &err);
    if (st == PM_E_MISSING)
        return reply_no_job(exchange);
    if (st == PM_E_MISMATCH)
        return pm_reply_problem(exchange, 409, "%s", err.text);
    if (st)
        return pm_reply_store_error(exchange, &err);
    pm_json *document = NULL;
    st = pm_jobs_get(service->jobs, id, &document, &err);
    if (st)
        return pm_reply_store_error(exchange, &err);
    bool ended = is_over(document);
    pm_json_free(document);
    char number[24];
    snprintf(number, sizeof number, "%lld", (long long)id);
    return pm_reply_json(
        exchange, ended ? 200 : 202,
        pm_json_pack("{s:s, s:s}", "id", number, "state", ended ? "cancelled" : "cancelling"));
}

/* ---- results ---- */

static const char *type_of(const char *format)
{
    static const struct {
        const char *format, *type;
    } types[] = {{"exr", "image/x-exr"},
                 {"hdr", "image/vnd.radiance"},
                 {"png", "image/png"},
                 {"txt", "text/plain; charset=utf-8"},
                 {"pm", "application/octet-stream"}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcmp(types[i].format, format))
            return types[i].type;
    return "application/octet-stream";
}

static pm_turn reply_no_result(pm_service *service, pm_exchange *exchange, int64_t id)
{
    pm_error err = PM_ERROR_INIT;
    pm_json *document = NULL;
    if (pm_jobs_get(service->jobs, id, &document, &err))
        return reply_no_job(exchange);
    bool over = is_over(document);
    pm_json_free(document);
    return over ? pm_reply_problem(exchange, 404, "the job has no such result")
                : pm_reply_problem(exchange, 409,
                                   "the job has not ended yet; ask "
                                   "/v1/jobs/%lld?wait=30",
                                   (long long)id);
}

pm_turn pm_job_result(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_blob blob;
    bool evicted = false;
    char format[16];
    int64_t id;
    if (!read_id(exchange, &id))
        return reply_no_job(exchange);
    pm_status st = pm_store_result_find(service->store, id, pm_exchange_query(exchange, "name"),
                                        pm_exchange_query(exchange, "format"), &blob, &evicted,
                                        format, &err);
    if (st == PM_E_MISSING)
        return reply_no_result(service, exchange, id);
    if (st)
        return pm_reply_store_error(exchange, &err);
    if (evicted)
        return pm_reply_problem(exchange, 410,
                                "the result had to make room in the store; run the job again");
    return pm_reply_blob(service, exchange, &blob, type_of(format));
}
