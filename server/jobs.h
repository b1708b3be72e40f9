#ifndef PM_SERVER_JOBS_H
#define PM_SERVER_JOBS_H

#include <stdbool.h>
#include <stdint.h>

#include "run.h"

/* The queue and the threads that run it, one worker process each. Jobs live in the store from
 * the moment they are acknowledged; this adds what is under way. */
typedef struct pm_jobs pm_jobs;

typedef struct pm_jobs_options {
    pm_run_settings run; /* `building` is filled in */
    unsigned workers;    /* jobs at a time, >= 1 */
    void *context;
    void (*report)(void *context, int64_t job, const char *state); /* for a log */
    void (*changed)(void *context); /* some job or ticket has another state; from any thread */
} pm_jobs_options;

typedef struct pm_jobs_counts {
    uint64_t queued, running, waiting; /* now; waiting for the photons of another */
    uint64_t done, failed, cancelled;  /* since the start */
    uint64_t batches_read, batches_kept;
} pm_jobs_counts;

/* Takes up what an earlier server left, and starts. */
PM_MUST_USE pm_status pm_jobs_new(const pm_jobs_options *options, pm_jobs **out, pm_error *err);

/* Ends the workers and waits for them. Their jobs go back into the queue for the next server,
 * or are cancelled if `cancel`. */
void pm_jobs_stop(pm_jobs *jobs, bool cancel);
void pm_jobs_free(pm_jobs *jobs); /* after pm_jobs_stop */

pm_jobs_counts pm_jobs_count(pm_jobs *jobs);

/* What is true of a map whatever job asks for it, from the entry in the answer of one. */
pm_json *pm_map_info(const pm_json *map);

/* ---- jobs of users ---- */

/* Queues a checked request. With a key that was used before: the job of then, *existed, and
 * PM_E_MISMATCH if its request was another. */
PM_MUST_USE pm_status pm_jobs_submit(pm_jobs *jobs, const pm_new_job *job, int64_t *id,
                                     bool *existed, pm_error *err);

/* The document of GET /v1/jobs/{id}, without links. PM_E_MISSING. */
PM_MUST_USE pm_status pm_jobs_get(pm_jobs *jobs, int64_t id, pm_json **out, pm_error *err);

/* PM_E_MISSING if there is no such job, PM_E_MISMATCH if it has ended already. A running one
 * ends soon after. */
PM_MUST_USE pm_status pm_jobs_cancel(pm_jobs *jobs, int64_t id, pm_error *err);

/* ---- the server's own tasks, which are lost with it: checking scenes, building map files ----
 */

typedef struct pm_work pm_ticket;

/* Queues it; `request` NULL checks the scene. NULL if memory is short. Its owner frees it. */
pm_ticket *pm_jobs_ask(pm_jobs *jobs, const char *request, const pm_digest *bundle,
                       const char *main_name);
bool pm_ticket_ready(pm_jobs *jobs, pm_ticket *ticket);
/* Of a ticket that is ready. */
const pm_outcome *pm_ticket_outcome(const pm_ticket *ticket);
void pm_ticket_free(pm_jobs *jobs, pm_ticket *ticket);

#endif
