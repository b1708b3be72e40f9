#include <stdlib.h>
#include <string.h>

#include "store_internal.h"

/* Scenes and photon maps: small records beside the blobs. */

/* ---- scenes ---- */

static pm_status insert_scene(pm_store *store, const pm_scene_record *record, const char *info,
                              pm_error *err)
{
    pm_blob bundle;
    pm_status st = pm_store_find_blob(store, &record->bundle, &bundle, err);
    return st ? st
              : pm_store_run(
                    store, err,
                    "INSERT OR IGNORE INTO scenes(id, hash, bundle, main, info, created)"
                    " VALUES(?, ?, ?, ?, ?, ?)",
                    "dditti", &record->id, &record->hash, bundle.id, record->main_name, info,
                    pm_store_now());
}

pm_status pm_store_scene_put(pm_store *store, const pm_scene_record *record, pm_error *err)
{
    char *info = pm_json_text(record->info);
    if (!info)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a scene");
    pm_status st = pm_store_begin(store, err);
    if (!st)
        st = pm_store_end(store, insert_scene(store, record, info, err), err);
    free(info);
    return st;
}

static pm_status read_scene(const pm_query *query, const pm_digest *id, pm_scene_record *out,
                            pm_error *err)
{
    pm_scene_record record = {.id = *id};
    const char *info = pm_query_text(query, 3);
    if (!pm_query_digest(query, 0, &record.hash) || !pm_query_digest(query, 1, &record.bundle))
        return pm_error_set(err, PM_E_CORRUPT, "a scene of the store has no digest");
    pm_status st = pm_json_parse(info, strlen(info), "store", &record.info, err);
    record.main_name = strdup(pm_query_text(query, 2));
    if (!st && !record.main_name)
        st = pm_error_set(err, PM_E_MEMORY, "no memory for a scene");
    if (st)
        pm_scene_record_clear(&record);
    else
        *out = record;
    return st;
}

pm_status pm_store_scene_get(pm_store *store, const pm_digest *id, pm_scene_record *out,
                             pm_error *err)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(store, err,
                                    "SELECT hash, digest, main, info FROM scenes JOIN blobs"
                                    " ON blobs.id = bundle WHERE scenes.id = ?",
                                    "d", id);
    pm_status st = pm_query_row(&query) ? read_scene(&query, id, out, err) : PM_E_MISSING;
    pm_status ended = pm_query_end(&query);
    pm_store_unlock(store);
    if (ended)
        return ended;
    return st == PM_E_MISSING ? pm_error_set(err, st,
                                             "there is no such scene; POST it to "
                                             "/v1/scenes")
                              : st;
}

void pm_scene_record_clear(pm_scene_record *record)
{
    free(record->main_name);
    pm_json_free(record->info);
    *record = (pm_scene_record){0};
}

pm_status pm_store_scene_list(pm_store *store, pm_json **out, pm_error *err)
{
    return pm_store_json(store, out, err,
                         "SELECT json_group_array(json(info)) FROM"
                         " (SELECT info FROM scenes ORDER BY created DESC, id LIMIT 1000)",
                         "");
}

/* ---- maps ---- */

pm_status pm_store_map_get(pm_store *store, const char *key, pm_json **info, char **request,
                           bool *has_file, pm_blob *file, pm_error *err)
{
    pm_store_lock(store);
    pm_query query = pm_query_begin(store, err,
                                    "SELECT info, request, blobs.id, digest, size FROM maps"
                                    " LEFT JOIN blobs ON blobs.id = blob WHERE key = ?",
                                    "t", key);
    pm_status st = pm_error_set(NULL, PM_E_MISSING, "no map");
    if (pm_query_row(&query)) {
        const char *text = pm_query_text(&query, 0);
        st = pm_json_parse(text, strlen(text), "store", info, err);
        *request = st ? NULL : strdup(pm_query_text(&query, 1));
        *has_file = pm_query_digest(&query, 3, &file->digest);
        file->id = pm_query_integer(&query, 2);
        file->size = (uint64_t)pm_query_integer(&query, 4);
    }
    pm_status ended = pm_query_end(&query);
    pm_store_unlock(store);
    if (!st && !*request) {
        pm_json_free(*info);
        return pm_error_set(err, PM_E_MEMORY, "no memory for a map record");
    }
    return ended ? ended : st;
}

pm_status pm_store_map_set_file(pm_store *store, const char *key, const pm_json *info,
                                const pm_digest *file, pm_error *err)
{
    char *text = pm_json_text(info);
    if (!text)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a map record");
    pm_store_lock(store);
    pm_status st =
        pm_store_run(store, err,
                     "UPDATE maps SET blob = (SELECT id FROM blobs WHERE digest = ?),"
                     " info = ? WHERE key = ?",
                     "dtt", file, text, key);
    pm_store_unlock(store);
    free(text);
    return st;
}

pm_status pm_store_map_list(pm_store *store, pm_json **out, pm_error *err)
{
    return pm_store_json(store, out, err,
                         "SELECT json_group_array(json(info)) FROM"
                         " (SELECT info FROM maps ORDER BY created DESC, key LIMIT 1000)",
                         "");
}
