#ifndef PM_SERVER_STORE_INTERNAL_H
#define PM_SERVER_STORE_INTERNAL_H

#include <stdarg.h>

#include "store.h"

/* What the files behind store.h share. A query holds the store's lock between pm_query_begin
 * and pm_query_end; so does a transaction. */

struct sqlite3_stmt;

void pm_store_lock(pm_store *store);
void pm_store_unlock(pm_store *store);

/* ---- one statement; the caller holds the lock ----
 * `types` says what follows: i int64_t, t text or NULL, d const pm_digest * or NULL, b data and
 * size_t. */
typedef struct pm_query {
    pm_store *store;
    struct sqlite3_stmt *statement;
    pm_status status;
    pm_error *err;
} pm_query;

pm_query pm_query_begin(pm_store *store, pm_error *err, const char *sql, const char *types,
                        ...);
bool pm_query_row(pm_query *query); /* steps; false at the end or on an error */
int64_t pm_query_integer(const pm_query *query, int column);
bool pm_query_null(const pm_query *query, int column);
const char *pm_query_text(const pm_query *query,
                          int column); /* until the next step; "" if NULL */
const void *pm_query_bytes(const pm_query *query, int column, size_t *size);
bool pm_query_digest(const pm_query *query, int column,
                     pm_digest *out); /* false if it is none */
PM_MUST_USE pm_status pm_query_end(pm_query *query);

/* A statement without rows. */
PM_MUST_USE pm_status pm_store_run(pm_store *store, pm_error *err, const char *sql,
                                   const char *types, ...);
/* Whether so many bytes more leave the disk's reserve alone. The caller holds the lock. */
PM_MUST_USE pm_status pm_store_check_room(pm_store *store, uint64_t size, pm_error *err);
int64_t pm_store_last_id(pm_store *store);
int pm_store_changes(pm_store *store);

/* A statement that gives one JSON text. PM_E_MISSING if it gives none. Takes the lock itself.
 */
PM_MUST_USE pm_status pm_store_json(pm_store *store, pm_json **out, pm_error *err,
                                    const char *sql, const char *types, ...);

/* ---- transactions: take the lock, give it back ---- */
PM_MUST_USE pm_status pm_store_begin(pm_store *store, pm_error *err);
/* Commits if `st` is PM_OK, rolls back otherwise. Returns st or what went wrong. */
PM_MUST_USE pm_status pm_store_end(pm_store *store, pm_status st, pm_error *err);

/* ---- store_blobs.c; the caller is in a transaction ---- */
PM_MUST_USE pm_status pm_store_insert_blob(pm_store *store, const void *data, size_t size,
                                           pm_blob *out, bool *existed, pm_error *err);
/* Makes room if the store is over its limit. Takes the lock itself. A failure is no failure of
 * the caller. */
void pm_store_evict(pm_store *store);
PM_MUST_USE pm_status pm_store_find_blob(pm_store *store, const pm_digest *digest, pm_blob *out,
                                         pm_error *err);

int64_t pm_store_now(void); /* milliseconds since 1970 */
uint64_t pm_store_limit(const pm_store *store);
void pm_store_count_evicted(pm_store *store, uint64_t blobs); /* the caller holds the lock */
uint64_t pm_store_bytes_locked(pm_store *store);

#endif
