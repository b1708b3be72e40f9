#include <stdlib.h>
#include <string.h>

#include "service.h"

/* An upload: chunk after chunk into the store, hashed on the way. */
struct upload {
    int64_t id;
    pm_hasher *hasher;
    uint64_t size, chunks;
    size_t filled;
    pm_error err;
    bool finished;
    unsigned char chunk[PM_CHUNK_BYTES];
};

static void free_upload(void *context, void *state)
{
    pm_service *service = context;
    struct upload *upload = state;
    if (upload->id && !upload->finished)
        pm_store_upload_abandon(service->store, upload->id);
    pm_hasher_free(upload->hasher);
    free(upload);
}

static struct upload *upload_of(pm_service *service, pm_exchange *exchange)
{
    struct upload *upload = pm_exchange_state(exchange);
    if (upload)
        return upload;
    upload = calloc(1, sizeof *upload);
    if (!upload)
        return NULL;
    pm_exchange_set_state(exchange, upload, free_upload);
    upload->hasher = pm_hasher_new();
    if (!upload->hasher)
        pm_error_set(&upload->err, PM_E_MEMORY, "no memory for a digest");
    else if (pm_store_upload_begin(service->store, &upload->id, &upload->err))
        upload->id = 0;
    return upload;
}

static void flush(pm_service *service, struct upload *upload)
{
    if (!upload->filled || upload->err.status)
        return;
    pm_hasher_add(upload->hasher, upload->chunk, upload->filled);
    (void)!pm_store_upload_chunk(service->store, upload->id, upload->chunks++, upload->chunk,
                                 upload->filled, &upload->err);
    upload->size += upload->filled;
    upload->filled = 0;
}

bool pm_blob_receive(void *context, pm_exchange *exchange, const void *data, size_t size)
{
    pm_service *service = context;
    struct upload *upload = upload_of(service, exchange);
    if (!upload)
        return false;
    const char *at = data;
    while (size && !upload->err.status) {
        size_t room = PM_CHUNK_BYTES - upload->filled;
        size_t part = size < room ? size : room;
        memcpy(upload->chunk + upload->filled, at, part);
        upload->filled += part;
        at += part;
        size -= part;
        if (upload->filled == PM_CHUNK_BYTES)
            flush(service, upload);
    }
    return !upload->err.status;
}

pm_turn pm_blob_put(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    struct upload *upload = upload_of(service, exchange); /* of no bytes, if none came */
    if (!upload)
        return pm_reply_problem_json(exchange, NULL);
    flush(service, upload);
    if (upload->err.status)
        return pm_reply_store_error(exchange, &upload->err);
    bool existed = false;
    char hex[PM_DIGEST_HEX], location[PM_DIGEST_HEX + 16];
    pm_digest digest = pm_hasher_finish(upload->hasher);
    if (pm_store_upload_finish(service->store, upload->id, &digest, upload->size, &existed,
                               &upload->err))
        return pm_reply_store_error(exchange, &upload->err);
    upload->finished = true;
    pm_digest_hex(&digest, hex);
    strcpy(location, "/v1/blobs/");
    strcat(location, hex);
    pm_reply_json(exchange, existed ? 200 : 201,
                  pm_json_pack("{s:s, s:I}", "digest", hex, "size", (long long)upload->size));
    pm_reply_header(exchange, "Location", location);
    return PM_TURN_REPLY;
}

pm_turn pm_blob_get(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_digest digest;
    pm_blob blob;
    pm_error err = PM_ERROR_INIT;
    if (!pm_digest_parse(pm_exchange_part(exchange, 0), &digest))
        return pm_reply_problem(exchange, 404, "a digest has 64 lower-case hexadecimal digits");
    pm_status st = pm_store_blob_find(service->store, &digest, &blob, &err);
    if (st == PM_E_MISSING)
        return pm_reply_problem(exchange, 404, "%s", err.text);
    if (st)
        return pm_reply_store_error(exchange, &err);
    return pm_reply_blob(service, exchange, &blob, "application/octet-stream");
}
