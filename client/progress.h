#ifndef PM_CLIENT_PROGRESS_H
#define PM_CLIENT_PROGRESS_H

#include "json.h"
#include "options.h"

/* How a job is getting on: a bar that redraws itself on a terminal, lines every -t seconds if
 * asked for, nothing in a pipe. All on standard error. */
typedef struct pm_progress_display {
    bool bar;
    double interval; /* seconds between lines; 0: none */
    double last;     /* wall seconds of the newest line */
    bool drawn;
} pm_progress_display;

void pm_progress_display_init(pm_progress_display *display, const pm_options *options);

/* `job` is the description that GET /v1/jobs/{id} answers. */
void pm_progress_display_show(pm_progress_display *display, const pm_json *job);
void pm_progress_display_end(pm_progress_display *display);

/* What was done, in a few lines: cache, left-out passes and why, passes, time, error. */
void pm_summary_print(const pm_options *options, const pm_json *job);

#endif
