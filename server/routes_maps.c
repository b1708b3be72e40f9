#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "problem.h"
#include "service.h"

/* A map's file is a blob if a job made it; otherwise a worker makes it from the stored batches
 * when somebody asks. */

pm_turn pm_map_list(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_json *list = NULL;
    pm_status st = pm_store_map_list(service->store, &list, &err);
    return pm_reply_list(exchange, "maps", st, list, &err);
}

struct found {
    pm_json *info;
    char *request;
    bool has_file;
    pm_blob file;
};

static void clear_found(struct found *found)
{
    pm_json_free(found->info);
    free(found->request);
}

static pm_status find_map(pm_service *service, pm_exchange *exchange, struct found *found,
                          pm_error *err)
{
    *found = (struct found){0};
    pm_status st = pm_store_map_get(service->store, pm_exchange_part(exchange, 0), &found->info,
                                    &found->request, &found->has_file, &found->file, err);
    if (st == PM_E_MISSING)
        pm_reply_problem(exchange, 404, "there is no such map; see /v1/maps");
    else if (st)
        pm_reply_store_error(exchange, err);
    return st;
}

pm_turn pm_map_get(void *context, pm_exchange *exchange)
{
    pm_error err = PM_ERROR_INIT;
    struct found found;
    if (find_map(context, exchange, &found, &err))
        return PM_TURN_REPLY;
    pm_reply_json(exchange, 200, found.info);
    found.info = NULL;
    clear_found(&found);
    return PM_TURN_REPLY;
}

/* ---- the file ---- */

static void free_ticket(void *context, void *state)
{
    pm_service *service = context;
    pm_ticket_free(service->jobs, state);
}

static pm_status ask_for_file(pm_service *service, pm_exchange *exchange,
                              const struct found *found, pm_error *err)
{
    pm_json *request = NULL;
    pm_scene_record scene;
    pm_digest id;
    pm_status st =
        pm_json_parse(found->request, strlen(found->request), "store", &request, err);
    if (!st && !pm_digest_parse(pm_json_get_text(request, "scene", ""), &id))
        st = pm_error_set(err, PM_E_CORRUPT, "a map of the store has no scene");
    if (!st)
        st = pm_store_scene_get(service->store, &id, &scene, err);
    pm_json_free(request);
    if (st)
        return st;
    pm_ticket *ticket =
        pm_jobs_ask(service->jobs, found->request, &scene.bundle, scene.main_name);
    pm_scene_record_clear(&scene);
    if (!ticket)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a map's file");
    pm_exchange_set_state(exchange, ticket, free_ticket);
    return PM_OK;
}

/* Bytes of a map's file: all, or those of one pass. */
static pm_turn reply_photons(pm_service *service, pm_exchange *exchange, const pm_json *info,
                             const pm_blob *file, bool one_pass)
{
    static const char type[] = "application/octet-stream";
    if (!one_pass)
        return pm_reply_blob(service, exchange, file, type);
    const char *text = pm_exchange_part(exchange, 1);
    const pm_json *passes = pm_json_get(info, "passes"), *pass;
    size_t n = strtoul(text, NULL, 10), count = pm_json_length(passes);
    if (!*text || text[strspn(text, "0123456789")] || strlen(text) > 6 || n >= count)
        return count ? pm_reply_problem(exchange, 404, "there are passes 0 to %zu", count - 1)
                     : pm_reply_problem(exchange, 404,
                                        "this map is no sequence of passes; its file is at "
                                        "/v1/maps/{key}/photons");
    pass = pm_json_at(passes, n);
    uint64_t first = (uint64_t)pm_json_get_integer(pass, "offset", 0),
             size = (uint64_t)pm_json_get_integer(pass, "bytes", 0);
    if (first > file->size || size > file->size - first)
        return pm_reply_problem(exchange, 500, "the store's record of this map is damaged");
    char part[24];
    snprintf(part, sizeof part, "-%zu", n);
    return pm_reply_blob_part(service, exchange, file, first, size, part, type);
}

static pm_turn conclude(pm_service *service, pm_exchange *exchange, const pm_outcome *outcome,
                        bool one_pass)
{
    pm_error err = PM_ERROR_INIT;
    pm_blob blob;
    if (!outcome->answer || outcome->result_count != 1 || !outcome->results[0].stored)
        return pm_reply_problem_json(exchange, pm_json_copy(outcome->problem));
    pm_json *info = pm_map_info(pm_json_at(pm_json_get(outcome->answer, "maps"), 0));
    pm_status st = pm_store_blob_find(service->store, &outcome->results[0].digest, &blob, &err);
    if (!st)
        st = pm_store_map_set_file(service->store, pm_exchange_part(exchange, 0), info,
                                   &blob.digest, &err);
    pm_turn turn = st ? pm_reply_store_error(exchange, &err)
                      : reply_photons(service, exchange, info, &blob, one_pass);
    pm_json_free(info);
    return turn;
}

static pm_turn photons(pm_service *service, pm_exchange *exchange, bool one_pass)
{
    pm_error err = PM_ERROR_INIT;
    pm_ticket *ticket = pm_exchange_state(exchange);
    if (ticket)
        return pm_ticket_ready(service->jobs, ticket)
                   ? conclude(service, exchange, pm_ticket_outcome(ticket), one_pass)
                   : PM_TURN_WAIT;
    struct found found;
    if (find_map(service, exchange, &found, &err))
        return PM_TURN_REPLY;
    pm_turn turn = PM_TURN_WAIT;
    if (found.has_file)
        turn = reply_photons(service, exchange, found.info, &found.file, one_pass);
    else if (ask_for_file(service, exchange, &found, &err))
        turn = pm_reply_store_error(exchange, &err);
    clear_found(&found);
    return turn;
}

pm_turn pm_map_photons(void *context, pm_exchange *exchange)
{
    return photons(context, exchange, false);
}

pm_turn pm_map_pass(void *context, pm_exchange *exchange)
{
    return photons(context, exchange, true);
}
