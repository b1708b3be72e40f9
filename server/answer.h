#ifndef PM_SERVER_ANSWER_H
#define PM_SERVER_ANSWER_H

#include "json.h"
#include "pipeline.h"

/* An answer of the engine as JSON, the way the service shows it. */

/* How a map came about. */
typedef enum pm_cache {
    PM_CACHE_NONE, /* not from the store, and not for it: no map, a file, progressive passes */
    PM_CACHE_HIT,  /* every batch was stored */
    PM_CACHE_JOINED,   /* another job was making the batches, and this one waited for them */
    PM_CACHE_EXTENDED, /* some were stored, the missing ones traced */
    PM_CACHE_MISS,     /* all were traced */
} pm_cache;

const char *pm_cache_name(pm_cache cache);
pm_cache pm_cache_of(const pm_job *job, const pm_answer *answer, pm_map_kind kind, bool joined);

/* What a scene holds: {scene, surfaces, lights, ..., power, plan}. NULL if memory is short. */
pm_json *pm_answer_scene_json(const pm_answer *answer);

/* The whole answer of a job. NULL if memory is short. */
pm_json *pm_answer_json(const pm_job *job, const pm_answer *answer,
                        const bool joined[PM_MAP_KINDS]);

pm_json *pm_progress_json(const pm_progress *progress);

#endif
