#ifndef PM_CLIENT_OUTPUT_H
#define PM_CLIENT_OUTPUT_H

#include <stdio.h>

#include "base/error.h"

/* A file that appears whole or not at all: written beside its place, then renamed. "-" is
 * standard output; a device or a pipe is written as it is, and a link stays one.
 * Tests: devices_and_links_stay_what_they_are. */
typedef struct pm_output {
    FILE *file;
    char path[4096];
    char temporary[4128]; /* "" for standard output */
} pm_output;

/* Whether a file could be written there, so that a long job need not find out at its end. */
PM_MUST_USE pm_status pm_output_check(const char *path, pm_error *err);

PM_MUST_USE pm_status pm_output_open(pm_output *output, const char *path, pm_error *err);

/* Makes it last (fsync) and visible. On failure, a full disk included, nothing is left. */
PM_MUST_USE pm_status pm_output_commit(pm_output *output, pm_error *err);

/* Removes what was written. Does nothing after a commit. */
void pm_output_abandon(pm_output *output);

#endif
