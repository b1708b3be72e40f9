#ifndef PM_SERVER_STORE_H
#define PM_SERVER_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/error.h"
#include "json.h"

/* What outlives the server: one SQLite file with blobs (uploads, batches of photons, results),
 * scenes, map records and jobs. store.c, store_blobs.c, store_records.c and store_jobs.c are
 * behind this header; store.c alone includes sqlite3.h.
 *
 * Every function may be called from any thread. What a function has acknowledged is on the
 * disk. A change is whole or not there, whenever the process is killed. Bytes live in chunks of
 * 1 MiB with a CRC-32C each, which is checked on every read. Errors: PM_E_IO (the disk is full
 * or fails), PM_E_CORRUPT, PM_E_MISSING, PM_E_MEMORY. */
typedef struct pm_store pm_store;

typedef struct pm_store_options {
    const char *path;
    uint64_t limit_bytes;  /* evict above this; 0 = never */
    unsigned lock_wait_ms; /* how long to wait for another server to let go of the file */
} pm_store_options;

enum { PM_CHUNK_BYTES = 1 << 20, PM_JOB_ATTEMPTS = 3 };

/* Opens or makes the file. PM_E_MISMATCH if another process has it, PM_E_UNSUPPORTED if a newer
 * server made it, PM_E_SYNTAX if it is something else. Uploads cut short are dropped. */
PM_MUST_USE pm_status pm_store_open(const pm_store_options *options, pm_store **out,
                                    pm_error *err);
void pm_store_close(pm_store *store); /* NULL is fine */

uint64_t pm_store_bytes(pm_store *store);   /* in use */
uint64_t pm_store_evicted(pm_store *store); /* blobs evicted since opening */

/* ---- blobs: bytes by their SHA-256 ---- */

typedef struct pm_blob {
    int64_t id;
    pm_digest digest;
    uint64_t size;
} pm_blob;

PM_MUST_USE pm_status pm_store_upload_begin(pm_store *store, int64_t *upload, pm_error *err);
/* Chunk `n` and, if there are more than PM_CHUNK_BYTES, those behind it, all or none; every one
 * but the last of all has PM_CHUNK_BYTES. */
PM_MUST_USE pm_status pm_store_upload_chunk(pm_store *store, int64_t upload, uint64_t n,
                                            const void *data, size_t size, pm_error *err);
/* The blob is there when this returns; *existed tells if it was before, undamaged. */
PM_MUST_USE pm_status pm_store_upload_finish(pm_store *store, int64_t upload,
                                             const pm_digest *digest, uint64_t size,
                                             bool *existed, pm_error *err);
void pm_store_upload_abandon(pm_store *store, int64_t upload);

/* Bytes at once. */
PM_MUST_USE pm_status pm_store_blob_put(pm_store *store, const void *data, size_t size,
                                        pm_blob *out, bool *existed, pm_error *err);
PM_MUST_USE pm_status pm_store_blob_find(pm_store *store, const pm_digest *digest, pm_blob *out,
                                         pm_error *err);
/* Reads and checks chunk `n`. */
PM_MUST_USE pm_status pm_store_blob_chunk(pm_store *store, const pm_blob *blob, uint64_t n,
                                          void *buffer, size_t *size, pm_error *err);

/* Forgets a blob that was found damaged, so that it can be made again. */
void pm_store_blob_drop(pm_store *store, const pm_blob *blob);

/* ---- batches of photons ---- */

typedef struct pm_stored_batch {
    pm_digest family;
    uint64_t index;
    const void *data;
    size_t size;
} pm_stored_batch;

PM_MUST_USE pm_status pm_store_batch_find(pm_store *store, const pm_digest *family,
                                          uint64_t index, pm_blob *out, pm_error *err);
/* All of them or none. One that is there already stays. */
PM_MUST_USE pm_status pm_store_batches_put(pm_store *store, const pm_stored_batch *batches,
                                           size_t count, pm_error *err);
uint64_t pm_store_batch_count(pm_store *store);

/* ---- scenes ---- */

typedef struct pm_scene_record {
    pm_digest id, hash, bundle;
    char *main_name;
    pm_json *info; /* as GET /v1/scenes/{id} shows it */
} pm_scene_record;

PM_MUST_USE pm_status pm_store_scene_put(pm_store *store, const pm_scene_record *record,
                                         pm_error *err);
/* PM_E_MISSING if there is none. Clear *out afterwards. */
PM_MUST_USE pm_status pm_store_scene_get(pm_store *store, const pm_digest *id,
                                         pm_scene_record *out, pm_error *err);
void pm_scene_record_clear(pm_scene_record *record);
PM_MUST_USE pm_status pm_store_scene_list(pm_store *store, pm_json **out, pm_error *err);

/* ---- photon maps ---- */

typedef struct pm_map_record {
    const char *key;
    const pm_json *info;
    const char *request;   /* of the job that makes its file from stored batches */
    const pm_digest *file; /* of the map file, if it is a blob; or NULL */
} pm_map_record;

PM_MUST_USE pm_status pm_store_map_get(pm_store *store, const char *key, pm_json **info,
                                       char **request, bool *has_file, pm_blob *file,
                                       pm_error *err);
/* A file that was made again, and what is said about it. */
PM_MUST_USE pm_status pm_store_map_set_file(pm_store *store, const char *key,
                                            const pm_json *info, const pm_digest *file,
                                            pm_error *err);
PM_MUST_USE pm_status pm_store_map_list(pm_store *store, pm_json **out, pm_error *err);

/* ---- jobs ---- */

typedef struct pm_new_job {
    const char *request;
    const char *idempotency_key; /* or NULL */
    const pm_digest *inputs;     /* blobs that must stay until the job has ended */
    size_t input_count;
} pm_new_job;

typedef struct pm_new_result {
    const char *name, *format;
    const pm_digest *stored; /* of bytes that are in the store already; or NULL */
    const void *data;
    size_t size;
} pm_new_result;

typedef struct pm_job_end {
    const char *state;      /* "done", "failed" or "cancelled" */
    const pm_json *answer;  /* or NULL */
    const pm_json *problem; /* or NULL */
    const pm_new_result *results;
    size_t result_count;
    const pm_map_record *maps;
    size_t map_count;
} pm_job_end;

PM_MUST_USE pm_status pm_store_job_add(pm_store *store, const pm_new_job *job, int64_t *id,
                                       pm_error *err);
/* The job of an idempotency key and its request; PM_E_MISSING. */
PM_MUST_USE pm_status pm_store_job_by_key(pm_store *store, const char *key, int64_t *id,
                                          char **request, pm_error *err);
/* Counts an attempt. */
PM_MUST_USE pm_status pm_store_job_start(pm_store *store, int64_t id, pm_error *err);
/* Takes the attempt back: the server stops in good order. */
PM_MUST_USE pm_status pm_store_job_requeue(pm_store *store, int64_t id, pm_error *err);
/* The end, its results and its maps in one transaction. */
PM_MUST_USE pm_status pm_store_job_finish(pm_store *store, int64_t id, const pm_job_end *end,
                                          pm_error *err);
/* {id, kind, state, scene, created, started, finished, attempts, request, answer, problem,
 * result}. */
PM_MUST_USE pm_status pm_store_job_get(pm_store *store, int64_t id, pm_json **out,
                                       pm_error *err);
/* Newest first, without request and answer. */
PM_MUST_USE pm_status pm_store_job_list(pm_store *store, unsigned limit, pm_json **out,
                                        pm_error *err);
/* After a start: jobs that ran when the last server died are queued again, those that did so
 * PM_JOB_ATTEMPTS times are failed. Then the queued ones in order; *ids is to be freed. */
PM_MUST_USE pm_status pm_store_job_recover(pm_store *store, int64_t **ids, size_t *count,
                                           pm_error *err);

/* PM_E_MISSING: no such result (both NULL: the first one). *evicted: it was, and had to make
 * room. */
PM_MUST_USE pm_status pm_store_result_find(pm_store *store, int64_t job, const char *name,
                                           const char *format, pm_blob *out, bool *evicted,
                                           char found_format[16], pm_error *err);

#endif
