#ifndef PM_PIPELINE_INTERNAL_H
#define PM_PIPELINE_INTERNAL_H

#include "pipeline.h"

/* One running job. */
typedef struct pm_run {
    const pm_job *job;
    const pm_job_hooks *hooks; /* never NULL; its pointers may be */
    pm_answer *answer;
    pm_error *err;
    pm_pool *pool;
    pm_world *world;
    pm_forward *forward;
    double wall_start, cpu_start;
    uint64_t balance_paths; /* that the answer's flux balance is the mean of */
    pm_progress progress;
} pm_run;

bool pm_run_cancelled(void *run); /* for the stages' `cancelled` parameters */
void pm_run_progress(pm_run *run, const char *stage, double done);
double pm_run_wall_seconds(const pm_run *run);
double pm_run_cpu_seconds(const pm_run *run);

/* The maps that the plan needs, or the user's files: from the store as far as it has their
 * batches, the rest traced. out[kind] is NULL where there is none. (pipeline_maps.c) */
PM_MUST_USE pm_status pm_run_make_maps(pm_run *run, pm_photon_map *out[PM_MAP_KINDS]);

/* The precomputed map of a global one, or as it was kept. (pipeline_precompute.c) */
pm_digest pm_run_precomputed_family(const pm_run *run);
PM_MUST_USE pm_status pm_run_precompute(pm_run *run, const pm_photon_map *global,
                                        pm_photon_map **out);
bool pm_run_fetch_precomputed(pm_run *run, pm_photon_map **out);

/* The header of a map of this run, as of one path. (pipeline_maps.c) */
pm_map_header pm_run_map_header(const pm_run *run, pm_map_kind kind);

/* Of the photons that paths store a map of so many takes a share: its fluxes are to be taken
 * over that. (pipeline_maps.c) */
void pm_run_thin_header(const pm_run *run, pm_map_header *header);

/* The maps of one progressive pass: batch `pass` of the global family (of the caustic one, if
 * the plan wants no global map) and of the volume family. */
PM_MUST_USE pm_status pm_run_make_pass_maps(pm_run *run, uint32_t pass,
                                            pm_photon_map *out[PM_MAP_KINDS]);

/* Fills in what the sensors' rays meet first. (pipeline_hits.c) */
PM_MUST_USE pm_status pm_run_first_hits(pm_run *run, const pm_scene *scene);

/* Adds passes until a stop is met, and writes the curve. (pipeline_passes.c) */
PM_MUST_USE pm_status pm_run_passes(pm_run *run, pm_accumulation *accumulation,
                                    pm_photon_map *const maps[PM_MAP_KINDS]);

#endif
