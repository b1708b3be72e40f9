#include <stdlib.h>
#include <string.h>

#include "store_internal.h"

/* Jobs, from the moment they are acknowledged to their results. */

#define TIME(column) "strftime('%Y-%m-%dT%H:%M:%fZ', " column " / 1000.0, 'unixepoch')"

static pm_status insert_inputs(pm_store *store, const pm_new_job *job, int64_t id,
                               pm_error *err)
{
    pm_status st = PM_OK;
    for (size_t i = 0; i < job->input_count && !st; i++) {
        pm_blob blob;
        st = pm_store_find_blob(store, &job->inputs[i], &blob, err);
        if (!st)
            st =
                pm_store_run(store, err, "INSERT OR IGNORE INTO inputs(job, blob) VALUES(?, ?)",
                             "ii", id, blob.id);
    }
    return st;
}

static pm_status insert_job(pm_store *store, const pm_new_job *job, int64_t *id, pm_error *err)
{
    pm_status st = pm_store_run(store, err,
                                "INSERT INTO jobs(state, request, idempotency, created)"
                                " VALUES('queued', ?, ?, ?)",
                                "tti", job->request, job->idempotency_key, pm_store_now());
    if (st)
        return st;
    *id = pm_store_last_id(store);
    return insert_inputs(store, job, *id, err);
}

pm_status pm_store_job_add(pm_store *store, const pm_new_job *job, int64_t *id, pm_error *err)
{
    pm_status st = pm_store_begin(store, err);
    return st ? st : pm_store_end(store, insert_job(store, job, id, err), err);
}

pm_status pm_store_job_by_key(pm_store *store, const char *key, int64_t *id, char **request,
                              pm_error *err)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(
        store, err, "SELECT id, request FROM jobs WHERE idempotency = ?", "t", key);
    bool found = pm_query_row(&query);
    char *text = found ? strdup(pm_query_text(&query, 1)) : NULL;
    int64_t number = found ? pm_query_integer(&query, 0) : 0;
    pm_status st = pm_query_end(&query);
    pm_store_unlock(store);
    if (!st && !found)
        return PM_E_MISSING;
    if (!st && !text)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a request");
    if (st) {
        free(text);
        return st;
    }
    *id = number;
    *request = text;
    return PM_OK;
}

static pm_status change(pm_store *store, int64_t id, const char *sql, pm_error *err)
{
    pm_store_lock(store);
    pm_status st = pm_store_run(store, err, sql, "ii", pm_store_now(), id);
    pm_store_unlock(store);
    return st;
}

pm_status pm_store_job_start(pm_store *store, int64_t id, pm_error *err)
{
    return change(store, id,
                  "UPDATE jobs SET state = 'running', started = ?, attempts = attempts + 1"
                  " WHERE id = ?",
                  err);
}

pm_status pm_store_job_requeue(pm_store *store, int64_t id, pm_error *err)
{
    return change(store, id,
                  "UPDATE jobs SET state = 'queued', attempts = attempts - 1"
                  " WHERE ? AND id = ? AND state = 'running'",
                  err);
}

static pm_status put_result(pm_store *store, int64_t job, size_t n, const pm_new_result *result,
                            pm_error *err)
{
    pm_blob blob;
    bool existed;
    pm_status st = result->stored ? pm_store_find_blob(store, result->stored, &blob, err)
                                  : pm_store_insert_blob(store, result->data, result->size,
                                                         &blob, &existed, err);
    if (st == PM_E_MISSING)
        return pm_error_set(err, PM_E_IO, "a result had to make room in the store");
    return st ? st
              : pm_store_run(store, err,
                             "INSERT INTO results(job, n, name, format, digest, size, blob)"
                             " VALUES(?, ?, ?, ?, ?, ?, ?)",
                             "iittdii", job, (int64_t)n, result->name, result->format,
                             &blob.digest, (int64_t)blob.size, blob.id);
}

/* A map's record is made once; a file that it had lost is given back. */
static pm_status put_map(pm_store *store, const pm_map_record *map, pm_error *err)
{
    char *info = pm_json_text(map->info);
    if (!info)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a map record");
    pm_status st =
        pm_store_run(store, err,
                     "INSERT INTO maps(key, info, request, blob, created)"
                     " VALUES(?, ?, ?, (SELECT id FROM blobs WHERE digest = ?), ?)"
                     " ON CONFLICT(key) DO UPDATE SET"
                     " info = iif(blob IS NULL, excluded.info, info),"
                     " blob = coalesce(blob, excluded.blob)",
                     "tttdi", map->key, info, map->request, map->file, pm_store_now());
    free(info);
    return st;
}

static pm_status write_end(pm_store *store, int64_t id, const pm_job_end *end,
                           const char *answer, const char *problem, pm_error *err)
{
    pm_status st =
        pm_store_run(store, err,
                     "UPDATE jobs SET state = ?, finished = ?, answer = ?, problem = ?"
                     " WHERE id = ?",
                     "titti", end->state, pm_store_now(), answer, problem, id);
    for (size_t i = 0; i < end->result_count && !st; i++)
        st = put_result(store, id, i, &end->results[i], err);
    for (size_t i = 0; i < end->map_count && !st; i++)
        st = put_map(store, &end->maps[i], err);
    return st;
}

pm_status pm_store_job_finish(pm_store *store, int64_t id, const pm_job_end *end, pm_error *err)
{
    char *answer = end->answer ? pm_json_text(end->answer) : NULL;
    char *problem = end->problem ? pm_json_text(end->problem) : NULL;
    pm_status st = PM_OK;
    if ((end->answer && !answer) || (end->problem && !problem))
        st = pm_error_set(err, PM_E_MEMORY, "no memory for the end of a job");
    if (!st)
        st = pm_store_begin(store, err);
    if (!st) {
        st = pm_store_end(store, write_end(store, id, end, answer, problem, err), err);
        pm_store_evict(store);
    }
    free(answer);
    free(problem);
    return st;
}

/* The result's members that a link is made of are completed by the server. */
static const char job_sql[] =
    "SELECT json_object('id', CAST(id AS TEXT), 'kind', request ->> 'kind', 'state', state,"
    " 'scene', request ->> 'scene', 'created', " TIME("created") ", 'started', " TIME(
        "started") ", 'finished', " TIME("finished") ", 'attempts', attempts,"
                                                     " 'request', json(request), 'answer', "
                                                     "json(answer), 'problem', json(problem), "
                                                     "'result',"
                                                     " (SELECT "
                                                     "json_group_array(json_object('name', "
                                                     "name, 'format', format, 'size', size,"
                                                     "  'digest', lower(hex(digest)), "
                                                     "'evicted', json(iif(blob IS NULL, "
                                                     "'true', 'false'))))"
                                                     "  FROM (SELECT * FROM results WHERE job "
                                                     "= jobs.id ORDER BY n)))"
                                                     " FROM jobs WHERE id = ?";

pm_status pm_store_job_get(pm_store *store, int64_t id, pm_json **out, pm_error *err)
{
    return pm_store_json(store, out, err, job_sql, "i", id);
}

pm_status pm_store_job_list(pm_store *store, unsigned limit, pm_json **out, pm_error *err)
{
    return pm_store_json(
        store, out, err,
        "SELECT json_group_array(json_object('id', CAST(id AS TEXT), 'kind', kind, 'state',"
        " state, 'scene', scene, 'created', created, 'finished', finished)) FROM"
        " (SELECT id, request ->> 'kind' AS kind, state, request ->> 'scene' AS scene,"
        " " TIME("created") " AS created, " TIME("finished") " AS finished FROM jobs"
                                                             " ORDER BY id DESC LIMIT ?)",
        "i", (int64_t)limit);
}

static pm_status fail_repeated(pm_store *store, pm_error *err)
{
    static const char problem[] =
        "{\"type\":\"about:blank\",\"status\":500,\"title\":\"Internal Server "
        "Error\",\"detail\":"
        "\"the server ended three times while this job ran, so it is not tried again\"}";
    return pm_store_run(store, err,
                        "UPDATE jobs SET state = 'failed', finished = ?, problem = ?"
                        " WHERE state = 'running' AND attempts >= ?",
                        "iti", pm_store_now(), problem, (int64_t)PM_JOB_ATTEMPTS);
}

static pm_status read_queue(pm_store *store, int64_t **ids, size_t *count, pm_error *err)
{
    pm_query query = pm_query_begin(
        store, err, "SELECT id FROM jobs WHERE state = 'queued' ORDER BY id", "");
    int64_t *list = NULL;
    size_t used = 0;
    pm_status st = PM_OK;
    while (!st && pm_query_row(&query)) {
        int64_t *grown = realloc(list, (used + 1) * sizeof *grown);
        if (!grown)
            st = pm_error_set(err, PM_E_MEMORY, "no memory for the queue");
        else
            (list = grown)[used++] = pm_query_integer(&query, 0);
    }
    pm_status ended = pm_query_end(&query);
    st = st ? st : ended;
    if (st) {
        free(list);
        return st;
    }
    *ids = list;
    *count = used;
    return PM_OK;
}

pm_status pm_store_job_recover(pm_store *store, int64_t **ids, size_t *count, pm_error *err)
{
    pm_status st = pm_store_begin(store, err);
    if (st)
        return st;
    st = fail_repeated(store, err);
    if (!st)
        st = pm_store_run(store, err,
                          "UPDATE jobs SET state = 'queued' WHERE state = 'running'", "");
    if (!st)
        st = read_queue(store, ids, count, err);
    return pm_store_end(store, st, err);
}

pm_status pm_store_result_find(pm_store *store, int64_t job, const char *name,
                               const char *format, pm_blob *out, bool *evicted,
                               char found_format[16], pm_error *err)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(
        store, err,
        "SELECT results.format, results.digest, results.size, results.blob FROM results"
        " WHERE job = ?1 AND (?2 IS NULL OR name = ?2) AND (?3 IS NULL OR format = ?3)"
        " ORDER BY n LIMIT 1",
        "itt", job, name, format);
    bool found = pm_query_row(&query) && pm_query_digest(&query, 1, &out->digest);
    if (found) {
        strncpy(found_format, pm_query_text(&query, 0), 15);
        found_format[15] = '\0';
        out->size = (uint64_t)pm_query_integer(&query, 2);
        out->id = pm_query_integer(&query, 3);
        *evicted = pm_query_null(&query, 3);
    }
    pm_status st = pm_query_end(&query);
    pm_store_unlock(store);
    return st || found ? st : PM_E_MISSING;
}
