#include "service.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "problem.h"

const pm_route pm_service_routes[] = {
    {"PUT", "/v1/blobs", PM_BODY_BYTES, false, pm_blob_put, pm_blob_receive},
    {"GET", "/v1/blobs/*", PM_BODY_NONE, false, pm_blob_get, NULL},
    {"POST", "/v1/scenes", PM_BODY_JSON, false, pm_scene_post, NULL},
    {"GET", "/v1/scenes", PM_BODY_NONE, false, pm_scene_list, NULL},
    {"GET", "/v1/scenes/*", PM_BODY_NONE, false, pm_scene_get, NULL},
    {"POST", "/v1/jobs", PM_BODY_JSON, false, pm_job_post, NULL},
    {"GET", "/v1/jobs", PM_BODY_NONE, false, pm_job_list, NULL},
    {"GET", "/v1/jobs/*", PM_BODY_NONE, false, pm_job_get, NULL},
    {"DELETE", "/v1/jobs/*", PM_BODY_NONE, false, pm_job_delete, NULL},
    {"GET", "/v1/jobs/*/result", PM_BODY_NONE, false, pm_job_result, NULL},
    {"GET", "/v1/maps", PM_BODY_NONE, false, pm_map_list, NULL},
    {"GET", "/v1/maps/*", PM_BODY_NONE, false, pm_map_get, NULL},
    {"GET", "/v1/maps/*/photons", PM_BODY_NONE, false, pm_map_photons, NULL},
    {"GET", "/v1/maps/*/passes/*", PM_BODY_NONE, false, pm_map_pass, NULL},
    {"GET", "/healthz", PM_BODY_NONE, true, pm_about_health, NULL},
    {"GET", "/readyz", PM_BODY_NONE, true, pm_about_ready, NULL},
    {"GET", "/metrics", PM_BODY_NONE, false, pm_about_metrics, NULL},
    {"GET", "/openapi.json", PM_BODY_NONE, false, pm_about_openapi, NULL},
    {NULL, NULL, PM_BODY_NONE, false, NULL, NULL},
};

pm_turn pm_reply_error(pm_exchange *exchange, const pm_error *err)
{
    if (err->status == PM_E_SYNTAX && !strcmp(err->file, "body"))
        return pm_reply_problem(exchange, 400, "the body is no JSON: line %d, column %d: %s",
                                err->line, err->column, err->text);
    return pm_reply_problem_json(exchange, pm_problem_of_member(err));
}

pm_turn pm_reply_store_error(pm_exchange *exchange, const pm_error *err)
{
    unsigned status = pm_problem_status(err->status);
    return pm_reply_problem(exchange, status == 507 || status == 503 ? status : 500, "%s",
                            err->text);
}

pm_turn pm_reply_list(pm_exchange *exchange, const char *name, pm_status status, pm_json *list,
                      const pm_error *err)
{
    if (status)
        return pm_reply_store_error(exchange, err);
    return pm_reply_json(exchange, 200, pm_json_pack("{s:o}", name, list));
}

/* ---- a blob as a reply ---- */

struct blob_reader {
    pm_store *store;
    pm_blob blob;
    uint64_t first; /* byte of the blob that is sent first */
    uint64_t chunk; /* that is in `data` */
    size_t size;
    unsigned char data[PM_CHUNK_BYTES];
};

static pm_status load(struct blob_reader *reader, uint64_t chunk, pm_error *err)
{
    pm_status st = pm_store_blob_chunk(reader->store, &reader->blob, chunk, reader->data,
                                       &reader->size, err);
    reader->chunk = st ? UINT64_MAX : chunk;
    if (st == PM_E_CORRUPT) /* the next who asks has it made again, or learns that it is gone */
        pm_store_blob_drop(reader->store, &reader->blob);
    return st;
}

static int64_t read_blob(void *context, uint64_t at, void *buffer, size_t size)
{
    struct blob_reader *reader = context;
    at += reader->first;
    uint64_t chunk = at / PM_CHUNK_BYTES;
    size_t from = (size_t)(at % PM_CHUNK_BYTES);
    if (chunk != reader->chunk && load(reader, chunk, NULL))
        return -1;
    if (from >= reader->size)
        return -1;
    size_t part = reader->size - from < size ? reader->size - from : size;
    memcpy(buffer, reader->data + from, part);
    return (int64_t)part;
}

pm_turn pm_reply_blob(pm_service *service, pm_exchange *exchange, const pm_blob *blob,
                      const char *type)
{
    return pm_reply_blob_part(service, exchange, blob, 0, blob->size, "", type);
}

pm_turn pm_reply_blob_part(pm_service *service, pm_exchange *exchange, const pm_blob *blob,
                           uint64_t first, uint64_t size, const char *part, const char *type)
{
    pm_error err = PM_ERROR_INIT;
    char tag[PM_DIGEST_HEX + 32];
    struct blob_reader *reader = malloc(sizeof *reader);
    if (!reader)
        return pm_reply_problem_json(exchange, NULL);
    reader->store = service->store;
    reader->blob = *blob;
    reader->first = first;
    reader->chunk = UINT64_MAX;
    if (size && load(reader, first / PM_CHUNK_BYTES, &err)) {
        free(reader);
        if (err.status == PM_E_CORRUPT)
            return pm_reply_problem(exchange, 500,
                                    "the stored bytes fail their checksum and are given up; "
                                    "ask again, or send them again");
        return pm_reply_store_error(exchange, &err);
    }
    pm_digest_hex(&blob->digest, tag);
    snprintf(tag + PM_DIGEST_HEX - 1, sizeof tag - PM_DIGEST_HEX + 1, "%.30s", part);
    return pm_reply_source(
        exchange, (pm_source){.size = size, .context = reader, .read = read_blob, .free = free},
        type, tag);
}
