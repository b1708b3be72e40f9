#ifndef PM_SERVER_RUN_H
#define PM_SERVER_RUN_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "building.h"
#include "request.h"
#include "store.h"

/* One task in one worker process, from its start to its end. Blocks the calling thread, which
 * must live longer than the worker. */

typedef struct pm_run_settings {
    pm_store *store;
    pm_building *building;
    const char *worker_path;
    uint64_t memory_bytes, cpu_seconds; /* 0 = no limit */
    unsigned threads;                   /* of a job that leaves the choice open */
} pm_run_settings;

typedef struct pm_task {
    int64_t id;          /* tells tasks apart; negative ones are no jobs of the store */
    const char *request; /* NULL: check the scene alone */
    pm_digest bundle;
    const char *main_name;
    const atomic_bool *stop; /* give up; whoever sets it also kills the worker */
    void *context;
    /* Both may be called from the running thread. `worker` is a pidfd, -1 when it has ended. */
    void (*started)(void *context, int worker);
    void (*progress)(void *context, pm_json *progress); /* steals */
} pm_task;

typedef struct pm_run_result {
    char name[64], format[16];
    bool stored; /* it came in pieces, which are in the store */
    pm_digest digest;
    const void *data; /* otherwise */
    size_t size;
} pm_run_result;

enum { PM_RUN_RESULTS = 8 };

typedef struct pm_outcome {
    pm_json *answer;  /* NULL if it failed */
    pm_json *problem; /* why */
    pm_run_result results[PM_RUN_RESULTS];
    size_t result_count;
    uint64_t batches_read, batches_kept;
} pm_outcome;

/* Always fills *out. Clear it afterwards. */
void pm_run_task(const pm_run_settings *settings, const pm_task *task, pm_outcome *out);
void pm_outcome_clear(pm_outcome *outcome);

#endif
