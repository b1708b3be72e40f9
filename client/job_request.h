#ifndef PM_CLIENT_JOB_REQUEST_H
#define PM_CLIENT_JOB_REQUEST_H

#include "json.h"
#include "options.h"
#include "session.h"

/* The body of POST /v1/jobs for a command line: each option that was accepted is in it. */

/* Digests of what was uploaded beforehand. */
typedef struct pm_attachments {
    const char *scene; /* the scene's id */
    bool has_points;
    pm_digest points;
    bool has_map[PM_MAP_KINDS];
    pm_digest map[PM_MAP_KINDS];
    const pm_map_option *detected[PM_MAP_KINDS]; /* -ap; NULL: none */
    bool precomputed;                            /* that of the global kind */
} pm_attachments;

/* `kind` is "map", "render" or "trace". NULL if memory is short. */
pm_json *pm_job_request(const pm_options *options, const char *kind,
                        const pm_attachments *attachments, unsigned formats,
                        const char *command);

/* Bits of `formats`. */
enum { PM_WANT_EXR = 1, PM_WANT_HDR = 2, PM_WANT_PNG = 4 };

/* The format bit of a file name's ending, 0 if it has none of the three. */
unsigned pm_format_of(const char *path);
const char *pm_format_word(unsigned format);

#endif
