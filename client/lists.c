#include "verbs.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "describe.h"
#include "session.h"

/* map list|info|fetch, job list|show|cancel, scene check: looking at what the server has. */

struct call {
    pm_verb verb;
    const char *action;        /* e.g. "list" */
    const char *operand;       /* what is wanted behind it; NULL: nothing */
    const char *method, *path; /* %s is the operand; NULL: see pm_verb_look */
};

static const struct call calls[] = {
    {PM_VERB_MAP, "list", NULL, "GET", "/v1/maps"},
    {PM_VERB_MAP, "info", "a key", "GET", "/v1/maps/%s"},
    {PM_VERB_MAP, "fetch", "a key", NULL, "/v1/maps/%s/photons"},
    {PM_VERB_JOB, "list", NULL, "GET", "/v1/jobs"},
    {PM_VERB_JOB, "show", "an id", "GET", "/v1/jobs/%s"},
    {PM_VERB_JOB, "cancel", "an id", "DELETE", "/v1/jobs/%s"},
    {PM_VERB_SCENE, "check", "a scene's file", NULL, NULL},
};

enum { CALLS = sizeof calls / sizeof *calls };

/* ---- what was asked ---- */

static const struct call *find_call(const pm_options *options)
{
    for (size_t i = 0; i < CALLS && options->operand_count; i++)
        if (calls[i].verb == options->verb && !strcmp(calls[i].action, options->operands[0]))
            return &calls[i];
    return NULL;
}

static pm_status refuse_action(const pm_options *options, pm_error *err)
{
    char actions[128] = "";
    for (size_t i = 0; i < CALLS; i++) {
        size_t used = strlen(actions);
        if (calls[i].verb == options->verb)
            snprintf(actions + used, sizeof actions - used, "%s%s", used ? ", " : "",
                     calls[i].action);
    }
    if (!options->operand_count)
        return pm_error_set(err, PM_E_MISSING, "what to do is missing: one of %s", actions);
    return pm_error_set(err, PM_E_RANGE, "%s: must be one of %s", options->operands[0],
                        actions);
}

/* A key or id goes into a path, so it holds nothing that could leave its place. */
static pm_status check_name(const char *name, pm_error *err)
{
    for (const char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && *c != '-' && *c != '_')
            return pm_error_set(err, PM_E_RANGE, "%s: is no key or id; `list` shows them",
                                name);
    if (*name && strlen(name) < 256)
        return PM_OK;
    return pm_error_set(err, PM_E_RANGE, "a key or id has 1 to 255 letters");
}

pm_status pm_check_look(const pm_options *options, pm_error *err)
{
    const struct call *call = find_call(options);
    if (!call)
        return refuse_action(options, err);
    if (options->operand_count != (call->operand ? 2 : 1))
        return pm_error_set(err, PM_E_RANGE, "%s takes %s, not %u words", call->action,
                            call->operand ? call->operand : "nothing behind it",
                            options->operand_count - 1);
    bool fetch = call->verb == PM_VERB_MAP && !call->method;
    if (fetch && options->output_count != 1)
        return pm_error_set(err, PM_E_MISSING, "fetch wants one -o FILE: where to write");
    if (!fetch && options->one_pass)
        return pm_error_set(err, PM_E_UNSUPPORTED, "--pass belongs to `map fetch`");
    if (!fetch && options->output_count)
        return pm_error_set(err, PM_E_UNSUPPORTED, "-o belongs to `map fetch`");
    return call->operand && call->path ? check_name(options->operands[1], err) : PM_OK;
}

/* ---- answers ---- */

static void print_json(const pm_json *json)
{
    char *text = pm_json_pretty(json);
    if (text)
        puts(text);
    free(text);
}

static void print_answer(const struct call *call, const pm_options *options, pm_json *answer)
{
    if (options->json)
        print_json(answer);
    else if (call->verb == PM_VERB_SCENE)
        pm_describe_scene(answer, stdout);
    else if (call->verb == PM_VERB_MAP && !call->operand)
        pm_describe_maps(pm_json_get(answer, "maps"), !options->quiet, stdout);
    else if (call->verb == PM_VERB_MAP)
        pm_describe_map(answer, stdout);
    else if (!call->operand)
        pm_describe_jobs(pm_json_get(answer, "jobs"), !options->quiet, stdout);
    else
        pm_describe_job(answer, stdout);
}

/* ---- calls ---- */

static void path_of(const struct call *call, const pm_options *options, char *path, size_t size)
{
    const char *place = strstr(call->path, "%s");
    if (place)
        snprintf(path, size, "%.*s%s%s", (int)(place - call->path), call->path,
                 options->operands[1], place + 2);
    else
        snprintf(path, size, "%s", call->path);
}

static pm_status make_call(pm_session *session, const struct call *call,
                           const pm_options *options, pm_error *err)
{
    char path[512];
    pm_json *answer = NULL;
    pm_status st;
    if (call->path)
        path_of(call, options, path, sizeof path);
    if (!call->path)
        st = pm_session_scene(session, options->operands[1], &answer, err);
    else if (call->method)
        st = pm_session_call(session, call->method, path, NULL, &answer, err);
    else {
        if (options->one_pass)
            snprintf(path, sizeof path, "/v1/maps/%s/passes/%u", options->operands[1],
                     options->pass);
        return pm_session_fetch(session, path, options->outputs[0], err);
    }
    if (!st)
        print_answer(call, options, answer);
    pm_json_free(answer);
    return st;
}

pm_status pm_verb_look(const pm_options *options, pm_error *err)
{
    pm_session *session = NULL;
    pm_status st = pm_session_open(options, &session, err);
    if (!st)
        st = make_call(session, find_call(options), options, err);
    pm_session_close(session);
    return st;
}
