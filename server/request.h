#ifndef PM_SERVER_REQUEST_H
#define PM_SERVER_REQUEST_H

#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "json.h"
#include "pipeline.h"

/* A job as it was asked for: the body of POST /v1/jobs, checked and read into an engine's job.
 * The server reads it to refuse what is wrong at once, the worker to run it. */

typedef enum pm_format {
    PM_FORMAT_EXR,
    PM_FORMAT_HDR,
    PM_FORMAT_PNG,
    PM_FORMATS,
} pm_format;

const char *pm_format_name(pm_format format); /* "exr" */

#define PM_TRACE_FIELDS "odLpnNcsmM"

typedef struct pm_request {
    pm_json *json;  /* owns every text below, */
    pm_arena arena; /* and this the lists of them */
    pm_job job;     /* without bundle, sensors and map files: those are attachments */
    const char *scene;
    bool has_points;
    pm_digest points;
    bool has_map_file[PM_MAP_KINDS];
    pm_digest map_file[PM_MAP_KINDS];
    const char *fields; /* of trace: letters out of PM_TRACE_FIELDS, maybe none */
    unsigned formats;   /* bits 1 << pm_format, of render */
} pm_request;

/* Checks a body against the table of fields and the rules between members; the error's `file`
 * is the member. On success clear it with pm_request_clear. */
PM_MUST_USE pm_status pm_request_parse(const void *text, size_t size, pm_request *out,
                                       pm_error *err);
void pm_request_clear(pm_request *request);

/* Reads a sensor's line `x y z nx ny nz` after line; blank lines are passed over. PM_E_SYNTAX
 * with line and column. *out is to be freed. */
PM_MUST_USE pm_status pm_sensors_parse(const char *text, size_t size, const char *name,
                                       pm_sensor **out, size_t *count, pm_error *err);

#endif
