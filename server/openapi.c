#include <stdio.h>
#include <string.h>

#include "fields.h"
#include "service.h"

/* The OpenAPI document: the paths below, request bodies from the table of fields. */

struct operation {
    const char *path, *method, *summary;
    const char *request;  /* "job", "scene", "bytes" or NULL */
    const char *query;    /* names, separated by blanks, or NULL */
    const char *statuses; /* with what they mean; errors are problem documents */
};

static const struct operation operations[] = {
    {"/v1/blobs", "put", "Store bytes of any size; the answer names their SHA-256.", "bytes",
     NULL,
     "200 They were there.|201 Stored.|413 Larger than the server allows.|507 The disk is "
     "full."},
    {"/v1/blobs/{digest}", "get", "The bytes, or a range of them.", NULL, NULL,
     "200 All.|206 A range.|304 Not modified.|404 Unknown.|416 No such range."},
    {"/v1/scenes", "post", "Check a scene and keep it.", "scene", NULL,
     "200 It was known.|201 Kept.|422 An error with file, line and column."},
    {"/v1/scenes", "get", "The scenes, newest first.", NULL, NULL, "200 {scenes: [...]}."},
    {"/v1/scenes/{id}", "get", "What a scene holds.", NULL, NULL,
     "200 The scene.|404 Unknown."},
    {"/v1/jobs", "post", "Queue a job. An Idempotency-Key makes a repeat harmless.", "job",
     NULL, "200 The key's job.|202 Queued; see Location.|422 The member that is wrong."},
    {"/v1/jobs", "get", "The jobs, newest first.", NULL, "limit", "200 {jobs: [...]}."},
    {"/v1/jobs/{id}", "get", "State, progress, and the answer with its error curve.", NULL,
     "wait", "200 The job, at once or when its state changes.|404 Unknown."},
    {"/v1/jobs/{id}", "delete", "Cancel a job.", NULL, NULL,
     "200 Cancelled.|202 It is being cancelled.|404 Unknown.|409 It has ended."},
    {"/v1/jobs/{id}/result", "get", "A result by name or format; the first by default.", NULL,
     "name format",
     "200 All.|206 A range.|304 Not modified.|404 Unknown.|409 Not yet.|410 Evicted."},
    {"/v1/maps", "get", "The photon maps, newest first.", NULL, NULL, "200 {maps: [...]}."},
    {"/v1/maps/{key}", "get", "What a photon map is about.", NULL, NULL,
     "200 The map.|404 Unknown."},
    {"/v1/maps/{key}/photons", "get", "The map's file; of a sequence with all its passes.",
     NULL, NULL, "200 All.|206 A range.|304 Not modified.|404 Unknown.|416 No such range."},
    {"/v1/maps/{key}/passes/{pass}", "get",
     "The map file of one pass of a sequence, counted from 0.", NULL, NULL,
     "200 All.|206 A range.|304 Not modified.|404 Unknown.|416 No such range."},
    {"/healthz", "get", "Whether the server answers.", NULL, NULL, "200 It does."},
    {"/readyz", "get", "Whether jobs can run, and which parts of the sandbox are missing.",
     NULL, NULL, "200 They can.|503 They cannot."},
    {"/metrics", "get", "Counters as Prometheus reads them.", NULL, NULL, "200 Text."},
    {"/openapi.json", "get", "This document.", NULL, NULL, "200 It."},
};

static pm_json *parameter(const char *name, size_t length, const char *where, bool required)
{
    char copy[32];
    snprintf(copy, sizeof copy, "%.*s", (int)length, name);
    return pm_json_pack("{s:s, s:s, s:b, s:{s:s}}", "name", copy, "in", where, "required",
                        required, "schema", "type", "string");
}

static pm_json *parameters(const struct operation *operation)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    const char *at = strchr(operation->path, '{');
    if (at && made)
        made = pm_json_append(list, parameter(at + 1, strcspn(at + 1, "}"), "path", true));
    for (at = operation->query; at && *at && made; at += strspn(at, " ")) {
        size_t length = strcspn(at, " ");
        made = pm_json_append(list, parameter(at, length, "query", false));
        at += length;
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

static pm_json *responses(const struct operation *operation)
{
    pm_json *object = pm_json_pack("{}");
    bool made = object;
    for (const char *at = operation->statuses; *at && made;) {
        char status[4], text[128];
        size_t length = strcspn(at, "|");
        snprintf(status, sizeof status, "%.3s", at);
        snprintf(text, sizeof text, "%.*s", (int)length - 4, at + 4);
        pm_json *response = pm_json_pack("{s:s}", "description", text);
        if (response && *status >= '4')
            made = pm_json_put(response, "content",
                               pm_json_pack("{s:{s:{s:s}}}", "application/problem+json",
                                            "schema", "$ref", "#/components/schemas/problem"));
        made = pm_json_put(object, status, response) && made;
        at += length + (at[length] == '|');
    }
    if (made)
        return object;
    pm_json_free(object);
    return NULL;
}

static pm_json *request_body(const char *request)
{
    if (!strcmp(request, "bytes"))
        return pm_json_pack("{s:{s:{}}}", "content", "application/octet-stream");
    char reference[64];
    snprintf(reference, sizeof reference, "#/components/schemas/%s", request);
    return pm_json_pack("{s:b, s:{s:{s:{s:s}}}}", "required", 1, "content", "application/json",
                        "schema", "$ref", reference);
}

static pm_json *operation_json(const struct operation *operation)
{
    pm_json *json = pm_json_pack("{s:s, s:o, s:o}", "summary", operation->summary, "parameters",
                                 parameters(operation), "responses", responses(operation));
    if (json && operation->request &&
        !pm_json_put(json, "requestBody", request_body(operation->request))) {
        pm_json_free(json);
        return NULL;
    }
    return json;
}

static pm_json *paths(void)
{
    pm_json *object = pm_json_pack("{}");
    bool made = object;
    for (size_t i = 0; i < sizeof operations / sizeof *operations && made; i++) {
        const struct operation *operation = &operations[i];
        if (!pm_json_get(object, operation->path))
            made = pm_json_put(object, operation->path, pm_json_pack("{}"));
        made = made && pm_json_put(pm_json_get(object, operation->path), operation->method,
                                   operation_json(operation));
    }
    if (made)
        return object;
    pm_json_free(object);
    return NULL;
}

static pm_json *problem_schema(void)
{
    return pm_json_pack(
        "{s:s, s:{s:{s:s}, s:{s:s}, s:{s:s}, s:{s:s}, s:{s:s}, s:{s:s}, s:{s:s}, s:{s:s}}}",
        "type", "object", "properties", "type", "type", "string", "status", "type", "integer",
        "title", "type", "string", "detail", "type", "string", "member", "type", "string",
        "file", "type", "string", "line", "type", "integer", "column", "type", "integer");
}

pm_json *pm_openapi(void)
{
    return pm_json_pack("{s:s, s:{s:s, s:s, s:s}, s:o, s:{s:{s:o, s:o, s:o}}}", "openapi",
                        "3.1.0", "info", "title", "pmserver", "version", "1", "description",
                        "Photon maps and pictures of Radiance scenes. Linear RGB; radiance in "
                        "W/(m^2 sr), irradiance in W/m^2.",
                        "paths", paths(), "components", "schemas", "job",
                        pm_fields_schema(pm_fields_job), "scene",
                        pm_fields_schema(pm_fields_scene), "problem", problem_schema());
}
