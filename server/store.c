#include "store_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include <sqlite3.h>

enum {
    SCHEMA = 1,               /* PRAGMA user_version */
    APPLICATION = 0x504d6170, /* PRAGMA application_id: "PMap" */
    PAGE_BYTES = 65536,       /* measured: writes 1 MiB chunks 2.5 times as fast as 4096 */
    LOCK_POLL_MS = 20,
};

struct pm_store {
    uint64_t limit_bytes;
    int lock_file; /* held while the store is open */

    pthread_mutex_t lock; /* guards db and evicted: one statement or transaction at a time */
    sqlite3 *db;
    uint64_t evicted;
};

/* Blob ids are never used twice, so that a reader that holds one cannot be given other bytes.
 * Chunk n of a blob has id blob * 2^20 + n. A blob without digest is an upload under way. */
static const char schema[] =
    "CREATE TABLE blobs(id INTEGER PRIMARY KEY AUTOINCREMENT, digest BLOB UNIQUE,"
    " size INTEGER NOT NULL, used INTEGER NOT NULL);"
    "CREATE INDEX blobs_used ON blobs(used);"
    "CREATE TABLE chunks(id INTEGER PRIMARY KEY, crc INTEGER NOT NULL, data BLOB NOT NULL);"
    "CREATE TABLE scenes(id BLOB PRIMARY KEY, hash BLOB NOT NULL, bundle INTEGER NOT NULL"
    " REFERENCES blobs, main TEXT NOT NULL, info TEXT NOT NULL, created INTEGER NOT NULL)"
    " WITHOUT ROWID;"
    "CREATE TABLE batches(family BLOB NOT NULL, n INTEGER NOT NULL, blob INTEGER NOT NULL"
    " REFERENCES blobs ON DELETE CASCADE, PRIMARY KEY(family, n)) WITHOUT ROWID;"
    "CREATE INDEX batches_blob ON batches(blob);"
    "CREATE TABLE maps(key TEXT PRIMARY KEY, info TEXT NOT NULL, request TEXT NOT NULL,"
    " blob INTEGER REFERENCES blobs ON DELETE SET NULL, created INTEGER NOT NULL) WITHOUT "
    "ROWID;"
    "CREATE INDEX maps_blob ON maps(blob);"
    "CREATE TABLE jobs(id INTEGER PRIMARY KEY AUTOINCREMENT, state TEXT NOT NULL, request TEXT "
    "NOT"
    " NULL, idempotency TEXT UNIQUE, attempts INTEGER NOT NULL DEFAULT 0, created INTEGER NOT "
    "NULL,"
    " started INTEGER, finished INTEGER, answer TEXT, problem TEXT);"
    "CREATE INDEX jobs_state ON jobs(state);"
    "CREATE TABLE inputs(job INTEGER NOT NULL REFERENCES jobs, blob INTEGER NOT NULL REFERENCES"
    " blobs ON DELETE CASCADE, PRIMARY KEY(job, blob)) WITHOUT ROWID;"
    "CREATE INDEX inputs_blob ON inputs(blob);"
    "CREATE TABLE results(job INTEGER NOT NULL REFERENCES jobs, n INTEGER NOT NULL, name TEXT "
    "NOT"
    " NULL, format TEXT NOT NULL, digest BLOB NOT NULL, size INTEGER NOT NULL, blob INTEGER"
    " REFERENCES blobs ON DELETE SET NULL, PRIMARY KEY(job, n)) WITHOUT ROWID;"
    "CREATE INDEX results_blob ON results(blob);";

int64_t pm_store_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

void pm_store_lock(pm_store *store)
{
    pthread_mutex_lock(&store->lock);
}

void pm_store_unlock(pm_store *store)
{
    pthread_mutex_unlock(&store->lock);
}

uint64_t pm_store_limit(const pm_store *store)
{
    return store->limit_bytes;
}

/* ---- statements ---- */

static pm_status status_of(int code)
{
    switch (code & 0xff) {
    case SQLITE_OK:
    case SQLITE_ROW:
    case SQLITE_DONE:
        return PM_OK;
    case SQLITE_NOMEM:
        return PM_E_MEMORY;
    case SQLITE_CORRUPT:
        return PM_E_CORRUPT;
    case SQLITE_NOTADB:
        return PM_E_SYNTAX;
    default:
        return PM_E_IO;
    }
}

static pm_status sqlite_failure(sqlite3 *db, pm_error *err)
{
    pm_status st = status_of(sqlite3_errcode(db));
    return pm_error_set(err, st ? st : PM_E_IO, "the store: %s", sqlite3_errmsg(db));
}

static int bind_digest(sqlite3_stmt *statement, int at, const pm_digest *digest)
{
    return digest ? sqlite3_bind_blob(statement, at, digest->bytes, sizeof digest->bytes,
                                      SQLITE_STATIC)
                  : sqlite3_bind_null(statement, at);
}

/* What is bound must live until pm_query_end. */
static int bind(sqlite3_stmt *statement, const char *types, va_list *args)
{
    int code = SQLITE_OK, at = 1;
    for (; *types && code == SQLITE_OK; types++, at++) {
        if (*types == 'i')
            code = sqlite3_bind_int64(statement, at, va_arg(*args, int64_t));
        else if (*types == 't')
            code = sqlite3_bind_text(statement, at, va_arg(*args, const char *), -1,
                                     SQLITE_STATIC);
        else if (*types == 'd')
            code = bind_digest(statement, at, va_arg(*args, const pm_digest *));
        else {
            const void *data = va_arg(*args, const void *);
            code =
                sqlite3_bind_blob64(statement, at, data, va_arg(*args, size_t), SQLITE_STATIC);
        }
    }
    return code;
}

static pm_query begin_query(pm_store *store, pm_error *err, const char *sql, const char *types,
                            va_list *args)
{
    pm_query query = {.store = store, .err = err};
    int code = sqlite3_prepare_v2(store->db, sql, -1, &query.statement, NULL);
    if (code == SQLITE_OK)
        code = bind(query.statement, types, args);
    if (code != SQLITE_OK)
        query.status = sqlite_failure(store->db, err);
    return query;
}

pm_query pm_query_begin(pm_store *store, pm_error *err, const char *sql, const char *types, ...)
{
    va_list args;
    va_start(args, types);
    pm_query query = begin_query(store, err, sql, types, &args);
    va_end(args);
    return query;
}

bool pm_query_row(pm_query *query)
{
    if (query->status)
        return false;
    int code = sqlite3_step(query->statement);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        query->status = sqlite_failure(query->store->db, query->err);
    return code == SQLITE_ROW;
}

int64_t pm_query_integer(const pm_query *query, int column)
{
    return sqlite3_column_int64(query->statement, column);
}

bool pm_query_null(const pm_query *query, int column)
{
    return sqlite3_column_type(query->statement, column) == SQLITE_NULL;
}

const char *pm_query_text(const pm_query *query, int column)
{
    const unsigned char *text = sqlite3_column_text(query->statement, column);
    return text ? (const char *)text : "";
}

const void *pm_query_bytes(const pm_query *query, int column, size_t *size)
{
    const void *data = sqlite3_column_blob(query->statement, column);
    *size = (size_t)sqlite3_column_bytes(query->statement, column);
    return data;
}

bool pm_query_digest(const pm_query *query, int column, pm_digest *out)
{
    size_t size = 0;
    const void *data = pm_query_bytes(query, column, &size);
    if (!data || size != sizeof out->bytes)
        return false;
    memcpy(out->bytes, data, size);
    return true;
}

pm_status pm_query_end(pm_query *query)
{
    sqlite3_finalize(query->statement);
    query->statement = NULL;
    return query->status;
}

static pm_status run(pm_store *store, pm_error *err, const char *sql, const char *types,
                     va_list *args)
{
    pm_query query = begin_query(store, err, sql, types, args);
    while (pm_query_row(&query))
        ;
    return pm_query_end(&query);
}

pm_status pm_store_run(pm_store *store, pm_error *err, const char *sql, const char *types, ...)
{
    va_list args;
    va_start(args, types);
    pm_status st = run(store, err, sql, types, &args);
    va_end(args);
    return st;
}

int64_t pm_store_last_id(pm_store *store)
{
    return sqlite3_last_insert_rowid(store->db);
}

int pm_store_changes(pm_store *store)
{
    return sqlite3_changes(store->db);
}

pm_status pm_store_json(pm_store *store, pm_json **out, pm_error *err, const char *sql,
                        const char *types, ...)
{
    va_list args;
    va_start(args, types);
    pm_store_lock(store);
    pm_query query = begin_query(store, err, sql, types, &args);
    va_end(args);
    pm_status st = PM_E_MISSING;
    if (pm_query_row(&query)) {
        const char *text = pm_query_text(&query, 0);
        st = pm_json_parse(text, strlen(text), "store", out, err);
    }
    pm_status ended = pm_query_end(&query);
    pm_store_unlock(store);
    return ended ? ended : st;
}

/* ---- transactions ---- */

pm_status pm_store_begin(pm_store *store, pm_error *err)
{
    pm_store_lock(store);
    pm_status st = pm_store_run(store, err, "BEGIN IMMEDIATE", "");
    if (st)
        pm_store_unlock(store);
    return st;
}

pm_status pm_store_end(pm_store *store, pm_status st, pm_error *err)
{
    if (!st)
        st = pm_store_run(store, err, "COMMIT", "");
    /* A failed COMMIT may or may not have ended the transaction; some errors end it earlier. */
    if (st && !sqlite3_get_autocommit(store->db))
        sqlite3_exec(store->db, "ROLLBACK", NULL, NULL, NULL);
    pm_store_unlock(store);
    return st;
}

/* ---- opening ---- */

static int64_t pragma(pm_store *store, const char *sql)
{
    pm_query query = pm_query_begin(store, NULL, sql, "");
    int64_t value = pm_query_row(&query) ? pm_query_integer(&query, 0) : 0;
    return pm_query_end(&query) ? 0 : value;
}

uint64_t pm_store_bytes_locked(pm_store *store)
{
    int64_t pages = pragma(store, "PRAGMA page_count") - pragma(store, "PRAGMA freelist_count");
    return (uint64_t)(pages > 0 ? pages : 0) * PAGE_BYTES;
}

/* What chunks leave free on the disk, so that jobs can still end, what is stored can still be
 * deleted, and the next pmserver can still open the store. */
#define RESERVE_BYTES (UINT64_C(16) << 20)

static uint64_t log_bytes(pm_store *store)
{
    struct stat about;
    const char *name = sqlite3_filename_wal(sqlite3_db_filename(store->db, "main"));
    return name && !stat(name, &about) ? (uint64_t)about.st_size : 0;
}

/* Everything goes through the write-ahead log first, and then into pages that are free, or
 * makes the file grow by as much again. */
pm_status pm_store_check_room(pm_store *store, uint64_t size, pm_error *err)
{
    struct statvfs disk;
    if (fstatvfs(store->lock_file, &disk))
        return PM_OK; /* unknown; SQLite says if it does not fit */
    uint64_t room = (uint64_t)disk.f_bavail * disk.f_frsize, log = log_bytes(store);
    if (room >= RESERVE_BYTES + log + size)
        return PM_OK;
    uint64_t reusable = (uint64_t)pragma(store, "PRAGMA freelist_count") * PAGE_BYTES;
    if (reusable >= log + size && room >= RESERVE_BYTES + size)
        return PM_OK;
    return pm_error_set(err, PM_E_IO,
                        "the store's disk is full but for a reserve: make room on it, or start "
                        "pmserver with a --store-limit that fits");
}

uint64_t pm_store_bytes(pm_store *store)
{
    pm_store_lock(store);
    uint64_t bytes = pm_store_bytes_locked(store);
    pm_store_unlock(store);
    return bytes;
}

void pm_store_count_evicted(pm_store *store, uint64_t blobs)
{
    store->evicted += blobs;
}

uint64_t pm_store_evicted(pm_store *store)
{
    pm_store_lock(store);
    uint64_t evicted = store->evicted;
    pm_store_unlock(store);
    return evicted;
}

static pm_status make_schema(pm_store *store, pm_error *err)
{
    char sql[sizeof schema + 128];
    snprintf(sql, sizeof sql,
             "BEGIN; %s PRAGMA application_id=%d; PRAGMA user_version=%d; COMMIT;", schema,
             APPLICATION, SCHEMA);
    if (sqlite3_exec(store->db, sql, NULL, NULL, NULL) != SQLITE_OK)
        return sqlite_failure(store->db, err);
    return PM_OK;
}

static pm_status check_schema(pm_store *store, const char *path, pm_error *err)
{
    pm_query query = pm_query_begin(store, err, "SELECT count(*) FROM sqlite_schema", "");
    bool empty = pm_query_row(&query) && pm_query_integer(&query, 0) == 0;
    pm_status st = pm_query_end(&query);
    if (st)
        return st;
    if (empty)
        return make_schema(store, err);
    if (pragma(store, "PRAGMA application_id") != APPLICATION)
        return pm_error_set_at(err, PM_E_SYNTAX, path, 0, 0,
                               "is a database, but no store of pmserver");
    int64_t version = pragma(store, "PRAGMA user_version");
    if (version != SCHEMA)
        return pm_error_set_at(
            err, PM_E_UNSUPPORTED, path, 0, 0,
            "has schema %lld, this pmserver knows %d; use a newer pmserver or "
            "another file",
            (long long)version, SCHEMA);
    return PM_OK;
}

static pm_status prepare(pm_store *store, const char *path, pm_error *err)
{
    static const char settings[] = "PRAGMA page_size=65536; PRAGMA journal_mode=WAL;"
                                   "PRAGMA synchronous=FULL; PRAGMA secure_delete=FAST;"
                                   "PRAGMA foreign_keys=ON; PRAGMA wal_autocheckpoint=64; "
                                   "PRAGMA journal_size_limit=4194304;";
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(path, &store->db, flags, NULL) != SQLITE_OK)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be opened: %s",
                               store->db ? sqlite3_errmsg(store->db) : "no memory");
    if (sqlite3_exec(store->db, settings, NULL, NULL, NULL) != SQLITE_OK)
        return sqlite_failure(store->db, err);
    pm_status st = check_schema(store, path, err);
    if (!st)
        st = pm_store_run(store, err,
                          "DELETE FROM chunks WHERE id >> 20 IN"
                          " (SELECT id FROM blobs WHERE digest IS NULL)",
                          "");
    if (!st)
        st = pm_store_run(store, err, "DELETE FROM blobs WHERE digest IS NULL", "");
    return st;
}

static void sleep_ms(long ms)
{
    nanosleep(&(struct timespec){.tv_nsec = ms * 1000000}, NULL);
}

/* The lock lies beside the file itself, not beside a link to it. */
static bool lock_name(const char *path, char *out, size_t size)
{
    char *real = realpath(path, NULL); /* NULL: the file is still to be made */
    int length = snprintf(out, size, "%s.pid", real ? real : path);
    free(real);
    return length < (int)size;
}

/* The lock file says which process has the store; it stays, so that nobody locks a removed one.
 */
static pm_status take_lock(pm_store *store, const pm_store_options *options, pm_error *err)
{
    char name[4096];
    if (!lock_name(options->path, name, sizeof name))
        return pm_error_set(err, PM_E_LIMIT, "the store's path is too long");
    store->lock_file = open(name, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (store->lock_file < 0)
        return pm_error_set_at(err, PM_E_IO, name, 0, 0, "cannot be made: %s", strerror(errno));
    unsigned waited = 0;
    while (flock(store->lock_file, LOCK_EX | LOCK_NB)) {
        if (waited >= options->lock_wait_ms) {
            char holder[32] = "";
            ssize_t length = pread(store->lock_file, holder, sizeof holder - 1, 0);
            holder[length > 0 ? strcspn(holder, "\n") : 0] = '\0';
            return pm_error_set_at(err, PM_E_MISMATCH, options->path, 0, 0,
                                   "is in use by the pmserver with process id %s",
                                   *holder ? holder : "unknown");
        }
        sleep_ms(LOCK_POLL_MS);
        waited += LOCK_POLL_MS;
    }
    char self[32];
    int length = snprintf(self, sizeof self, "%ld\n", (long)getpid());
    if (ftruncate(store->lock_file, 0) ||
        pwrite(store->lock_file, self, (size_t)length, 0) != length)
        return pm_error_set_at(err, PM_E_IO, name, 0, 0, "cannot be written: %s",
                               strerror(errno));
    return PM_OK;
}

pm_status pm_store_open(const pm_store_options *options, pm_store **out, pm_error *err)
{
    pm_store *store = calloc(1, sizeof *store);
    if (!store)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the store");
    store->limit_bytes = options->limit_bytes;
    store->lock_file = -1;
    pthread_mutex_init(&store->lock, NULL);
    pm_status st = take_lock(store, options, err);
    if (!st)
        st = prepare(store, options->path, err);
    if (st)
        pm_store_close(store);
    else
        *out = store;
    return st;
}

void pm_store_close(pm_store *store)
{
    if (!store)
        return;
    sqlite3_close(store->db);
    if (store->lock_file >= 0)
        close(store->lock_file);
    pthread_mutex_destroy(&store->lock);
    free(store);
}
