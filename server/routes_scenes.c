#include <stdlib.h>
#include <string.h>

#include "fields.h"
#include "problem.h"
#include "scene/bundle.h"
#include "service.h"

/* A scene that is being checked: what the handler remembers while it waits. */
struct check {
    pm_digest id, bundle;
    pm_ticket *ticket;
    char main_name[1025];
};

static void free_check(void *context, void *state)
{
    pm_service *service = context;
    struct check *check = state;
    pm_ticket_free(service->jobs, check->ticket);
    free(check);
}

/* What is said about scenes, and which are refused: counted up when that changes, so that no
 * older answer is taken from the store. */
enum { ANSWER_VERSION = 2 };

/* A scene is named by what it is made of, so that posting it twice names it once. */
static pm_digest scene_id(const pm_digest *bundle, const char *main_name)
{
    pm_bytes bytes = {0};
    pm_bytes_u32(&bytes, ANSWER_VERSION);
    pm_bytes_append(&bytes, bundle->bytes, sizeof bundle->bytes);
    pm_bytes_text(&bytes, main_name);
    pm_digest id = pm_digest_of(bytes.data, bytes.size);
    pm_bytes_clear(&bytes);
    return id;
}

/* ---- the body ---- */

/* Text becomes a bundle of one file. */
static pm_status store_text(pm_service *service, const char *text, const char *main_name,
                            pm_digest *out, pm_error *err)
{
    pm_bytes tar = {0};
    pm_blob blob;
    bool existed;
    pm_bundle *bundle = pm_bundle_new();
    pm_status st = bundle ? pm_bundle_add(bundle, main_name, text, strlen(text), err)
                          : pm_error_set(err, PM_E_MEMORY, "no memory for a scene");
    if (!st)
        st = pm_bundle_write_tar(bundle, &tar, err);
    if (!st)
        st = pm_store_blob_put(service->store, tar.data, tar.size, &blob, &existed, err);
    if (!st)
        *out = blob.digest;
    pm_bytes_clear(&tar);
    pm_bundle_free(bundle);
    return st;
}

static pm_status read_bundle(pm_service *service, const pm_json *body, struct check *check,
                             pm_error *err)
{
    const char *text = pm_json_get_text(body, "text", NULL);
    const char *bundle = pm_json_get_text(body, "bundle", NULL);
    if (!text == !bundle)
        return pm_error_set_at(err, PM_E_MISSING, "bundle", 0, 0,
                               "or text must be there, and not both");
    if (text)
        return store_text(service, text, check->main_name, &check->bundle, err);
    pm_blob blob;
    pm_error why = PM_ERROR_INIT;
    if (!pm_digest_parse(bundle, &check->bundle))
        return pm_error_set_at(err, PM_E_RANGE, "bundle", 0, 0, "is no digest");
    pm_status st = pm_store_blob_find(service->store, &check->bundle, &blob, &why);
    return st ? pm_error_set_at(err, st, "bundle", 0, 0, "%s", why.text) : PM_OK;
}

static pm_status read_body(pm_service *service, const pm_bytes *body, struct check *check,
                           pm_error *err)
{
    pm_json *json = NULL;
    pm_status st = pm_bytes_status(body);
    if (st)
        return pm_error_set(err, st, "no memory for the body");
    st = pm_json_parse(body->data, body->size, "body", &json, err);
    if (!st)
        st = pm_fields_check(pm_fields_scene, json, err);
    if (!st) {
        strcpy(check->main_name, pm_json_get_text(json, "main", "scene.rad"));
        st = read_bundle(service, json, check, err);
    }
    if (!st)
        check->id = scene_id(&check->bundle, check->main_name);
    pm_json_free(json);
    return st;
}

/* ---- replies ---- */

static pm_turn reply_scene(pm_exchange *exchange, unsigned status, const pm_digest *id,
                           const pm_json *info)
{
    char location[PM_DIGEST_HEX + 16] = "/v1/scenes/";
    pm_digest_hex(id, location + strlen(location));
    pm_reply_json(exchange, status, pm_json_copy(info));
    pm_reply_header(exchange, "Location", location);
    return PM_TURN_REPLY;
}

static pm_json *scene_info(const struct check *check, const pm_json *answer)
{
    char id[PM_DIGEST_HEX], bundle[PM_DIGEST_HEX];
    pm_digest_hex(&check->id, id);
    pm_digest_hex(&check->bundle, bundle);
    pm_json *info =
        pm_json_pack("{s:s, s:s, s:s}", "id", id, "main", check->main_name, "bundle", bundle);
    if (info && pm_json_merge(info, answer))
        return info;
    pm_json_free(info);
    return NULL;
}

static pm_turn keep_scene(pm_service *service, pm_exchange *exchange, struct check *check,
                          const pm_json *answer)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene_record record = {.id = check->id,
                              .bundle = check->bundle,
                              .main_name = check->main_name,
                              .info = scene_info(check, answer)};
    pm_status st = PM_OK;
    if (!record.info)
        st = pm_error_set(&err, PM_E_MEMORY, "no memory for a scene");
    else if (!pm_digest_parse(pm_json_get_text(record.info, "scene", ""), &record.hash))
        st = pm_error_set(&err, PM_E_CORRUPT, "the worker answered without a hash");
    else
        st = pm_store_scene_put(service->store, &record, &err);
    pm_turn turn = st ? pm_reply_store_error(exchange, &err)
                      : reply_scene(exchange, 201, &record.id, record.info);
    pm_json_free(record.info);
    return turn;
}

static pm_turn conclude(pm_service *service, pm_exchange *exchange, struct check *check)
{
    const pm_outcome *outcome = pm_ticket_outcome(check->ticket);
    if (outcome->answer)
        return keep_scene(service, exchange, check, outcome->answer);
    return pm_reply_problem_json(exchange, pm_json_copy(outcome->problem));
}

static pm_turn start(pm_service *service, pm_exchange *exchange, struct check *check)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene_record known;
    if (read_body(service, pm_exchange_body(exchange), check, &err))
        return pm_reply_error(exchange, &err);
    pm_status st = pm_store_scene_get(service->store, &check->id, &known, &err);
    if (!st) {
        reply_scene(exchange, 200, &known.id, known.info);
        pm_scene_record_clear(&known);
        return PM_TURN_REPLY;
    }
    if (st != PM_E_MISSING)
        return pm_reply_store_error(exchange, &err);
    check->ticket = pm_jobs_ask(service->jobs, NULL, &check->bundle, check->main_name);
    return check->ticket ? PM_TURN_WAIT : pm_reply_problem_json(exchange, NULL);
}

pm_turn pm_scene_post(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    struct check *check = pm_exchange_state(exchange);
    if (check)
        return pm_ticket_ready(service->jobs, check->ticket)
                   ? conclude(service, exchange, check)
                   : PM_TURN_WAIT;
    check = calloc(1, sizeof *check);
    if (!check)
        return pm_reply_problem_json(exchange, NULL);
    pm_exchange_set_state(exchange, check, free_check);
    return start(service, exchange, check);
}

pm_turn pm_scene_list(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_json *list = NULL;
    pm_status st = pm_store_scene_list(service->store, &list, &err);
    return pm_reply_list(exchange, "scenes", st, list, &err);
}

pm_turn pm_scene_get(void *context, pm_exchange *exchange)
{
    pm_service *service = context;
    pm_error err = PM_ERROR_INIT;
    pm_digest id;
    pm_scene_record scene;
    if (!pm_digest_parse(pm_exchange_part(exchange, 0), &id))
        return pm_reply_problem(exchange, 404, "a scene's id has 64 hexadecimal digits");
    pm_status st = pm_store_scene_get(service->store, &id, &scene, &err);
    if (st == PM_E_MISSING)
        return pm_reply_problem(exchange, 404, "%s", err.text);
    if (st)
        return pm_reply_store_error(exchange, &err);
    pm_reply_json(exchange, 200, scene.info);
    scene.info = NULL;
    pm_scene_record_clear(&scene);
    return PM_TURN_REPLY;
}
