#ifndef PM_PIPELINE_H
#define PM_PIPELINE_H

#include <stdbool.h>
#include <stdint.h>

#include "backward/backward.h"
#include "backward/first_hit.h"
#include "base/arena.h"
#include "base/bytes.h"
#include "base/digest.h"
#include "base/error.h"
#include "forward/forward.h"
#include "photons/photon_map.h"
#include "plan/plan.h"
#include "scene/bundle.h"
#include "surround.h"
#include "world/survey.h"

/* One job from a bundle to its answer. The caller lends it a store of batches and listens. */

typedef enum pm_job_kind {
    PM_JOB_MAP,    /* mkpmap: photon maps */
    PM_JOB_RENDER, /* a picture */
    PM_JOB_TRACE,  /* values at sensors */
    PM_JOB_CHECK,  /* parse, compile and survey alone */
} pm_job_kind;

/* A map that the user brings as a file. */
typedef struct pm_map_file {
    const void *data; /* NULL: none */
    size_t size;
    const char *name; /* for messages */
} pm_map_file;

typedef struct pm_job {
    pm_job_kind kind;
    const char *main_name; /* of the scene in its bundle */
    pm_wanted wanted;
    pm_map_file
        files[PM_MAP_KINDS]; /* used instead of traced maps; gather counts from wanted */
    pm_surroundings surroundings;
    pm_forward_options forward;
    unsigned threads; /* 0 = one a processor */

    pm_view view; /* render */
    uint32_t width, height;
    const pm_sensor *sensors; /* trace */
    size_t sensor_count;
    pm_quantity quantity;
    bool first_hits; /* trace: what each sensor's ray meets first, too */

    /* Stops, whichever comes first; 0 = no such stop. With none given: error .02, 60 s. An
     * error alone, where nothing is lit, gives up after some 256 passes: error infinite. */
    uint32_t passes;
    double seconds; /* wall */
    double error;   /* relative, e.g. .02 */

    const char *command; /* as typed; for file headers; may be NULL */
} pm_job;

/* A point of the error curve. */
typedef struct pm_curve_point {
    double cpu_seconds, wall_seconds;
    uint32_t passes;
    double error;
} pm_curve_point;

typedef struct pm_progress {
    const char *stage; /* "parse", "compile", "forward", "build", "backward" */
    double done;       /* 0..1 of the stage, as well as it is known */
    uint64_t photons[PM_MAP_KINDS], paths;
    uint32_t passes;
    double error;
    double cpu_seconds, wall_seconds;
} pm_progress;

/* The world a job runs in; any pointer may be NULL. All are called from the job's own thread.
 */
typedef struct pm_job_hooks {
    void *context;
    bool (*cancelled)(void *context);
    void (*progress)(void *context, const pm_progress *progress);
    /* Batch `index` of a family as pm_batch_write wrote it, or false. The bytes stay valid
     * until `release` is called. */
    bool (*fetch)(void *context, const pm_digest *family, uint64_t index, const void **data,
                  size_t *size);
    void (*release)(void *context, const void *data, size_t size);
    /* Keeps a whole batch that was traced. */
    void (*keep)(void *context, const pm_digest *family, pm_map_kind kind, uint64_t index,
                 const pm_bytes *bytes);
    /* Called before the batches of a family are needed, with the number that the caller will
     * ask for as far as known; may block while another job makes them. */
    void (*begin)(void *context, const pm_digest *family, pm_map_kind kind);
    void (*end)(void *context, const pm_digest *family);
    /* Of a map job: takes the next bytes of a map's file, in order; files of several kinds may
     * come by turns. NULL: maps are answered in memory, sequences are dropped. */
    pm_status (*put)(void *context, pm_map_kind kind, const void *data, size_t size,
                     pm_error *err);
} pm_job_hooks;

/* A pass of a sequence: which paths it is of, and where its map lies in the file. */
typedef struct pm_pass_summary {
    uint64_t photons, first_path, paths;
    uint64_t offset, bytes;
} pm_pass_summary;

typedef struct pm_map_summary {
    bool present;
    pm_digest family;
    uint64_t photons, paths;             /* of a sequence: of all its passes */
    uint64_t paths_traced, paths_cached; /* by this job */
    char note[160];                      /* as in the file's header */
    pm_pass_summary *passes;             /* of a sequence */
    uint32_t pass_count;
} pm_map_summary;

/* How what was met is called in the scene's file. */
typedef struct pm_hit_names {
    const char *surface, *modifier, *material;
} pm_hit_names;

typedef struct pm_answer {
    pm_digest scene; /* octree hash */
    pm_world_info world;
    pm_plan plan;
    pm_survey *survey; /* of PM_JOB_CHECK */
    pm_map_summary maps[PM_MAP_KINDS];
    pm_photon_map *map[PM_MAP_KINDS]; /* of PM_JOB_MAP without `put` */
    pm_image image;                   /* of PM_JOB_RENDER */
    float *values, *half_widths;      /* of PM_JOB_TRACE: [sensor_count][3] */
    pm_first_hit *hits;               /* of PM_JOB_TRACE, if asked for: [sensor_count] */
    pm_hit_names *hit_names;          /* [sensor_count]; "*" where nothing was met */
    pm_arena names;                   /* that they live in */
    pm_curve_point *curve;
    size_t curve_count;
    uint32_t passes;
    double error; /* estimated, relative; infinity if unknown */
    double cpu_seconds, wall_seconds;
    uint64_t nonfinite;
    pm_rgb emitted, absorbed, escaped; /* [W], from the paths traced or fetched */
} pm_answer;

/* Runs the job. The bundle and everything in `job` is borrowed. */
PM_MUST_USE pm_status pm_job_run(const pm_job *job, const pm_bundle *bundle,
                                 const pm_job_hooks *hooks, pm_answer *out, pm_error *err);
void pm_answer_clear(pm_answer *answer);

#endif
