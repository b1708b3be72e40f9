#include <string.h>

#include "base/crc.h"
#include "store_internal.h"

enum {
    CHUNK_BITS = 20,            /* of a chunk's id: at most a tebibyte a blob */
    TOUCH_MS = 60000,           /* a use is noted once a minute: it costs a write */
    UPLOAD_GRACE_MS = 86400000, /* an upload that nothing refers to stays a day */
};

static int64_t chunk_id(int64_t blob, uint64_t n)
{
    return (int64_t)((uint64_t)blob << CHUNK_BITS | n);
}

static pm_status insert_chunk(pm_store *store, int64_t blob, uint64_t n, const void *data,
                              size_t size, pm_error *err)
{
    if (n >> CHUNK_BITS)
        return pm_error_set(err, PM_E_LIMIT, "a blob has more than a tebibyte");
    pm_status st = pm_store_check_room(store, size, err);
    if (st)
        return st;
    return pm_store_run(store, err, "INSERT INTO chunks(id, crc, data) VALUES(?, ?, ?)", "iib",
                        chunk_id(blob, n), (int64_t)pm_crc32c(data, size), data, size);
}

static pm_status delete_chunks(pm_store *store, int64_t blob, pm_error *err)
{
    return pm_store_run(store, err, "DELETE FROM chunks WHERE id BETWEEN ? AND ?", "ii",
                        chunk_id(blob, 0), chunk_id(blob + 1, 0) - 1);
}

static pm_status delete_blob(pm_store *store, int64_t blob, pm_error *err)
{
    pm_status st = delete_chunks(store, blob, err);
    return st ? st : pm_store_run(store, err, "DELETE FROM blobs WHERE id = ?", "i", blob);
}

static void touch(pm_store *store, int64_t blob, int64_t used)
{
    int64_t now = pm_store_now();
    /* An old time of use only makes eviction choose worse, so a failure here is harmless. */
    if (now - used > TOUCH_MS &&
        pm_store_run(store, NULL, "UPDATE blobs SET used = ? WHERE id = ?", "ii", now, blob))
        return;
}

pm_status pm_store_find_blob(pm_store *store, const pm_digest *digest, pm_blob *out,
                             pm_error *err)
{
    pm_query query = pm_query_begin(
        store, err, "SELECT id, size, used FROM blobs WHERE digest = ?", "d", digest);
    bool found = pm_query_row(&query);
    int64_t used = 0;
    if (found) {
        *out = (pm_blob){pm_query_integer(&query, 0), *digest,
                         (uint64_t)pm_query_integer(&query, 1)};
        used = pm_query_integer(&query, 2);
    }
    pm_status st = pm_query_end(&query);
    if (found && !st)
        touch(store, out->id, used);
    return st || found ? st : PM_E_MISSING;
}

pm_status pm_store_blob_find(pm_store *store, const pm_digest *digest, pm_blob *out,
                             pm_error *err)
{
    pm_store_lock(store);
    pm_status st = pm_store_find_blob(store, digest, out, err);
    pm_store_unlock(store);
    char hex[PM_DIGEST_HEX];
    pm_digest_hex(digest, hex);
    return st == PM_E_MISSING
               ? pm_error_set(err, st, "there is no blob %s; PUT it to /v1/blobs", hex)
               : st;
}

static pm_status new_blob(pm_store *store, const pm_digest *digest, uint64_t size, int64_t *id,
                          pm_error *err)
{
    pm_status st =
        pm_store_run(store, err, "INSERT INTO blobs(digest, size, used) VALUES(?, ?, ?)", "dii",
                     digest, (int64_t)size, pm_store_now());
    if (!st)
        *id = pm_store_last_id(store);
    return st;
}

/* Whether all chunks are there and sound. Asked before bytes that come again are not stored
 * again: what was damaged on the disk is healed by whoever has the bytes. */
static pm_status check_blob(pm_store *store, const pm_blob *blob, bool *sound, pm_error *err)
{
    uint64_t total = 0;
    pm_query query =
        pm_query_begin(store, err, "SELECT crc, data FROM chunks WHERE id BETWEEN ? AND ?",
                       "ii", chunk_id(blob->id, 0), chunk_id(blob->id + 1, 0) - 1);
    *sound = true;
    while (*sound && pm_query_row(&query)) {
        size_t size = 0;
        const void *data = pm_query_bytes(&query, 1, &size);
        *sound = pm_query_integer(&query, 0) == (int64_t)pm_crc32c(data, size);
        total += size;
    }
    *sound = *sound && total == blob->size;
    return pm_query_end(&query);
}

/* A blob that is there, whole. One that is damaged loses its chunks and keeps its id, so that
 * nobody who refers to it loses it: then *sound is false. */
static pm_status find_sound(pm_store *store, const pm_digest *digest, pm_blob *out, bool *sound,
                            pm_error *err)
{
    *sound = false;
    pm_status st = pm_store_find_blob(store, digest, out, err);
    if (!st)
        st = check_blob(store, out, sound, err);
    return st || *sound ? st : delete_chunks(store, out->id, err);
}

pm_status pm_store_insert_blob(pm_store *store, const void *data, size_t size, pm_blob *out,
                               bool *existed, pm_error *err)
{
    pm_blob blob = {.digest = pm_digest_of(data, size), .size = size};
    pm_status st = find_sound(store, &blob.digest, &blob, existed, err);
    if (st == PM_E_MISSING)
        st = new_blob(store, &blob.digest, size, &blob.id, err);
    for (size_t at = 0; at < size && !st && !*existed; at += PM_CHUNK_BYTES) {
        size_t part = size - at < PM_CHUNK_BYTES ? size - at : PM_CHUNK_BYTES;
        st = insert_chunk(store, blob.id, at / PM_CHUNK_BYTES, (const char *)data + at, part,
                          err);
    }
    if (!st)
        *out = blob;
    return st;
}

pm_status pm_store_blob_put(pm_store *store, const void *data, size_t size, pm_blob *out,
                            bool *existed, pm_error *err)
{
    pm_status st = pm_store_begin(store, err);
    if (st)
        return st;
    st = pm_store_end(store, pm_store_insert_blob(store, data, size, out, existed, err), err);
    pm_store_evict(store);
    return st;
}

pm_status pm_store_blob_chunk(pm_store *store, const pm_blob *blob, uint64_t n, void *buffer,
                              size_t *size, pm_error *err)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(store, err, "SELECT crc, data FROM chunks WHERE id = ?",
                                    "i", chunk_id(blob->id, n));
    bool found = pm_query_row(&query), sound = false;
    if (found) {
        const void *data = pm_query_bytes(&query, 1, size);
        sound = *size > 0 && *size <= PM_CHUNK_BYTES &&
                pm_query_integer(&query, 0) == (int64_t)pm_crc32c(data, *size);
        if (sound)
            memcpy(buffer, data, *size);
    }
    pm_status st = pm_query_end(&query);
    pm_store_unlock(store);
    if (!st && !found)
        return pm_error_set(err, PM_E_MISSING, "a blob had to make room");
    if (!st && !sound)
        return pm_error_set(err, PM_E_CORRUPT, "a chunk of the store fails its checksum");
    return st;
}

void pm_store_blob_drop(pm_store *store, const pm_blob *blob)
{
    if (pm_store_begin(store, NULL))
        return; /* a damaged chunk is found again at the next read */
    pm_status st = pm_store_end(store, delete_blob(store, blob->id, NULL), NULL);
    (void)st; /* as above */
}

/* ---- uploads ---- */

pm_status pm_store_upload_begin(pm_store *store, int64_t *upload, pm_error *err)
{
    pm_store_lock(store);
    pm_status st = new_blob(store, NULL, 0, upload, err);
    pm_store_unlock(store);
    return st;
}

pm_status pm_store_upload_chunk(pm_store *store, int64_t upload, uint64_t n, const void *data,
                                size_t size, pm_error *err)
{
    pm_status st = pm_store_begin(store, err);
    if (st)
        return st;
    for (size_t at = 0; at < size && !st; at += PM_CHUNK_BYTES) {
        size_t part = size - at < PM_CHUNK_BYTES ? size - at : PM_CHUNK_BYTES;
        st = insert_chunk(store, upload, n++, (const char *)data + at, part, err);
    }
    return pm_store_end(store, st, err);
}

/* Gives an upload's chunks to a blob that has lost its own. */
static pm_status move_chunks(pm_store *store, int64_t from, int64_t to, pm_error *err)
{
    return pm_store_run(store, err, "UPDATE chunks SET id = id + ? WHERE id BETWEEN ? AND ?",
                        "iii", chunk_id(to, 0) - chunk_id(from, 0), chunk_id(from, 0),
                        chunk_id(from + 1, 0) - 1);
}

pm_status pm_store_upload_finish(pm_store *store, int64_t upload, const pm_digest *digest,
                                 uint64_t size, bool *existed, pm_error *err)
{
    pm_status st = pm_store_begin(store, err);
    if (st)
        return st;
    pm_blob known;
    st = find_sound(store, digest, &known, existed, err);
    if (!st && !*existed)
        st = move_chunks(store, upload, known.id, err);
    if (!st)
        st = delete_blob(store, upload, err);
    else if (st == PM_E_MISSING)
        st = pm_store_run(store, err,
                          "UPDATE blobs SET digest = ?, size = ?, used = ? WHERE id = ?",
                          "diii", digest, (int64_t)size, pm_store_now(), upload);
    st = pm_store_end(store, st, err);
    pm_store_evict(store);
    return st;
}

void pm_store_upload_abandon(pm_store *store, int64_t upload)
{
    if (pm_store_begin(store, NULL))
        return; /* dropped at the next start */
    pm_status st = pm_store_end(store, delete_blob(store, upload, NULL), NULL);
    (void)st; /* as above */
}

/* ---- eviction ---- */

/* Never scenes and inputs of jobs to come; uploads that nothing refers to after a day. */
static const char victims[] =
    "SELECT id, size FROM blobs WHERE digest IS NOT NULL"
    " AND id NOT IN (SELECT bundle FROM scenes)"
    " AND id NOT IN (SELECT blob FROM inputs JOIN jobs ON job = jobs.id"
    "                WHERE state IN ('queued', 'running'))"
    " AND (used < ?"
    "      OR EXISTS (SELECT 1 FROM batches WHERE blob = blobs.id)"
    "      OR EXISTS (SELECT 1 FROM results WHERE blob = blobs.id)"
    "      OR EXISTS (SELECT 1 FROM maps WHERE blob = blobs.id))"
    " ORDER BY used, id LIMIT 64";

/* Deletes the least recently used blobs until `excess` bytes are free. */
static pm_status evict_some(pm_store *store, uint64_t excess, uint64_t *freed)
{
    int64_t ids[64];
    size_t count = 0;
    pm_query query =
        pm_query_begin(store, NULL, victims, "i", pm_store_now() - UPLOAD_GRACE_MS);
    while (*freed < excess && count < 64 && pm_query_row(&query)) {
        ids[count++] = pm_query_integer(&query, 0);
        *freed += (uint64_t)pm_query_integer(&query, 1);
    }
    pm_status st = pm_query_end(&query);
    for (size_t i = 0; i < count && !st; i++)
        st = delete_blob(store, ids[i], NULL);
    if (!st)
        pm_store_count_evicted(store, count);
    return st || count ? st : PM_E_MISSING;
}

void pm_store_evict(pm_store *store)
{
    uint64_t limit = pm_store_limit(store), freed = 0;
    if (!limit || pm_store_begin(store, NULL))
        return;
    uint64_t bytes = pm_store_bytes_locked(store);
    pm_status st = PM_OK;
    while (bytes > limit && freed < bytes - limit && !st)
        st = evict_some(store, bytes - limit, &freed);
    st = pm_store_end(store, st == PM_E_MISSING ? PM_OK : st, NULL);
    (void)st; /* the next change tries again */
}

/* ---- batches ---- */

pm_status pm_store_batch_find(pm_store *store, const pm_digest *family, uint64_t index,
                              pm_blob *out, pm_error *err)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(store, err,
                                    "SELECT blobs.id, digest, size, used FROM batches"
                                    " JOIN blobs ON blobs.id = blob WHERE family = ? AND n = ?",
                                    "di", family, (int64_t)index);
    bool found = pm_query_row(&query) && pm_query_digest(&query, 1, &out->digest);
    int64_t used = 0;
    if (found) {
        out->id = pm_query_integer(&query, 0);
        out->size = (uint64_t)pm_query_integer(&query, 2);
        used = pm_query_integer(&query, 3);
    }
    pm_status st = pm_query_end(&query);
    if (found && !st)
        touch(store, out->id, used);
    pm_store_unlock(store);
    return st || found ? st : PM_E_MISSING;
}

static pm_status put_batch(pm_store *store, const pm_stored_batch *batch, pm_error *err)
{
    pm_blob blob;
    bool existed;
    pm_status st = pm_store_insert_blob(store, batch->data, batch->size, &blob, &existed, err);
    return st ? st
              : pm_store_run(store, err,
                             "INSERT OR IGNORE INTO batches(family, n, blob) VALUES(?, ?, ?)",
                             "dii", &batch->family, (int64_t)batch->index, blob.id);
}

pm_status pm_store_batches_put(pm_store *store, const pm_stored_batch *batches, size_t count,
                               pm_error *err)
{
    pm_status st = pm_store_begin(store, err);
    if (st)
        return st;
    for (size_t i = 0; i < count && !st; i++)
        st = put_batch(store, &batches[i], err);
    st = pm_store_end(store, st, err);
    pm_store_evict(store);
    return st;
}

uint64_t pm_store_batch_count(pm_store *store)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(store, NULL, "SELECT count(*) FROM batches", "");
    uint64_t count = pm_query_row(&query) ? (uint64_t)pm_query_integer(&query, 0) : 0;
    pm_status st = pm_query_end(&query);
    pm_store_unlock(store);
    return st ? 0 : count;
}
