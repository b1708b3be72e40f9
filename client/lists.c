#include "verbs.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "session.h"

/* map list|info|fetch, job list|show|cancel, scene check: looking at what the server has. */

struct call {
    const char *verb, *action; /* e.g. "map", "list" */
    const char *method, *path; /* %s is the operand */
    bool list;                 /* a line an entry instead of the whole document */
};

static const struct call calls[] = {
    {"map", "list", "GET", "/v1/maps", true},
    {"map", "info", "GET", "/v1/maps/%s", false},
    {"job", "list", "GET", "/v1/jobs", true},
    {"job", "show", "GET", "/v1/jobs/%s", false},
    {"job", "cancel", "DELETE", "/v1/jobs/%s", false},
};

/* A key or id goes into a path, so it holds nothing that could leave its place. */
static pm_status check_name(const char *name, pm_error *err)
{
    for (const char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && *c != '-' && *c != '_')
            return pm_error_set(err, PM_E_RANGE, "%s: is no key or id; `list` shows them",
                                name);
    return *name ? PM_OK : pm_error_set(err, PM_E_RANGE, "an empty key or id");
}

static void print_entry(const pm_json *entry)
{
    printf("%s", pm_json_get_text(entry, "key", pm_json_get_text(entry, "id", "?")));
    static const char *const shown[] = {"kind",  "state", "photons",
                                        "paths", "cache", "created"};
    for (size_t i = 0; i < sizeof shown / sizeof *shown; i++) {
        const pm_json *value = pm_json_get(entry, shown[i]);
        if (pm_json_type_of(value) == PM_JSON_TEXT)
            printf("  %s", pm_json_string(value));
        else if (pm_json_type_of(value) == PM_JSON_INTEGER)
            printf("  %lld %s", (long long)pm_json_integer(value), shown[i]);
    }
    putchar('\n');
}

static void print_answer(const struct call *call, pm_json *answer)
{
    const char *member = !strcmp(call->verb, "map") ? "maps" : "jobs";
    const pm_json *list =
        pm_json_type_of(answer) == PM_JSON_ARRAY ? answer : pm_json_get(answer, member);
    for (size_t i = 0; call->list && i < pm_json_length(list); i++)
        print_entry(pm_json_at(list, i));
    if (!call->list) {
        char *text = pm_json_pretty(answer);
        if (text)
            puts(text);
        free(text);
    }
}

static pm_status make_call(pm_session *session, const struct call *call, const char *operand,
                           pm_error *err)
{
    char path[512];
    pm_json *answer = NULL;
    snprintf(path, sizeof path, "%s", call->path);
    char *place = strstr(path, "%s");
    if (place)
        snprintf(place, sizeof path - (size_t)(place - path), "%s", operand);
    pm_status st = pm_session_call(session, call->method, path, NULL, &answer, err);
    if (!st)
        print_answer(call, answer);
    pm_json_free(answer);
    return st;
}

static pm_status fetch_map(pm_session *session, const pm_options *options, pm_error *err)
{
    char path[512];
    const char *to = options->output_count ? options->outputs[0] : NULL;
    if (!to)
        return pm_error_set(err, PM_E_MISSING, "map fetch: -o FILE is missing: where to write");
    snprintf(path, sizeof path, "/v1/maps/%s/photons", options->operands[1]);
    return pm_session_fetch(session, path, to, err);
}

static const struct call *find_call(const char *verb, const char *action)
{
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++)
        if (!strcmp(calls[i].verb, verb) && !strcmp(calls[i].action, action))
            return &calls[i];
    return NULL;
}

static pm_status look(const char *verb, const char *actions, const pm_options *options,
                      pm_error *err)
{
    const char *action = options->operand_count ? options->operands[0] : "";
    const struct call *call = find_call(verb, action);
    bool fetch = !strcmp(verb, "map") && !strcmp(action, "fetch");
    unsigned wanted = call && call->list ? 1 : 2;
    if (!call && !fetch)
        return pm_error_set(err, PM_E_RANGE, "%s %s: must be one of %s", verb, action, actions);
    if (options->operand_count != wanted)
        return pm_error_set(err, PM_E_RANGE, "%s %s: takes %s", verb, action,
                            wanted == 1 ? "no operand" : "one key or id");
    pm_session *session = NULL;
    pm_status st = wanted == 2 ? check_name(options->operands[1], err) : PM_OK;
    if (!st)
        st = pm_session_open(options, &session, err);
    if (!st)
        st = fetch ? fetch_map(session, options, err)
                   : make_call(session, call, wanted == 2 ? options->operands[1] : "", err);
    pm_session_close(session);
    return st;
}

pm_status pm_verb_map(const pm_options *options, pm_error *err)
{
    return look("map", "list, info KEY, fetch KEY -o FILE", options, err);
}

pm_status pm_verb_job(const pm_options *options, pm_error *err)
{
    return look("job", "list, show ID, cancel ID", options, err);
}

pm_status pm_verb_scene(const pm_options *options, pm_error *err)
{
    pm_session *session = NULL;
    pm_json *scene = NULL;
    if (options->operand_count != 2 || strcmp(options->operands[0], "check"))
        return pm_error_set(err, PM_E_RANGE, "scene: say `scene check FILE`");
    pm_status st = pm_session_open(options, &session, err);
    if (!st)
        st = pm_session_scene(session, options->operands[1], &scene, err);
    char *text = scene ? pm_json_pretty(scene) : NULL;
    if (text)
        puts(text);
    free(text);
    pm_json_free(scene);
    pm_session_close(session);
    return st;
}
