#include "pipeline_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double clock_seconds(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double pm_run_wall_seconds(const pm_run *run)
{
    return clock_seconds(CLOCK_MONOTONIC) - run->wall_start;
}

double pm_run_cpu_seconds(const pm_run *run)
{
    return clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - run->cpu_start;
}

bool pm_run_cancelled(void *context)
{
    const pm_run *run = context;
    return run->hooks->cancelled && run->hooks->cancelled(run->hooks->context);
}

void pm_run_progress(pm_run *run, const char *stage, double done)
{
    if (!run->hooks->progress)
        return;
    run->progress.stage = stage;
    run->progress.done = done;
    run->progress.cpu_seconds = pm_run_cpu_seconds(run);
    run->progress.wall_seconds = pm_run_wall_seconds(run);
    run->hooks->progress(run->hooks->context, &run->progress);
}

/* Bytes of the bundle become a world. */
static pm_status compile(pm_run *run, const pm_bundle *bundle)
{
    pm_scene *scene = NULL;
    pm_run_progress(run, "parse", 0);
    pm_status st = pm_surround_parse(bundle, run->job->main_name, &run->job->surroundings,
                                     &scene, run->err);
    if (!st) {
        pm_run_progress(run, "compile", 0);
        st = pm_world_compile(scene, &run->world, run->err);
    }
    if (!st && run->job->surroundings.no_back_faces)
        pm_world_hide_back_faces(run->world);
    if (!st && run->job->kind == PM_JOB_CHECK)
        st = pm_survey_make(scene, run->world, &run->answer->survey, run->err);
    if (!st && run->job->first_hits)
        st = pm_run_first_hits(run, scene);
    pm_scene_free(scene);
    if (st)
        return st;
    run->answer->scene = pm_world_hash(run->world);
    pm_world_info_get(run->world, &run->answer->world);
    return PM_OK;
}

/* What is said about the photons' start belongs to the first pass that is made. */
static void add_note(pm_run *run)
{
    const char *note = pm_forward_note(run->forward);
    for (int kind = 0; kind < PM_MAP_KINDS && *note; kind++) {
        pm_plan_pass *pass = &run->answer->plan.pass[kind];
        if (!pass->needed)
            continue;
        size_t length = strlen(pass->reason);
        snprintf(pass->reason + length, sizeof pass->reason - length, "; %s", note);
        return;
    }
}

static pm_status start_forward(pm_run *run)
{
    pm_wanted wanted = run->job->wanted;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        wanted.maps[kind].from_file = run->job->files[kind].data;
    wanted.sensors = run->job->forward.sensors.count;
    pm_status st = pm_plan_make(run->world, &wanted, &run->answer->plan, run->err);
    if (!st)
        st = pm_forward_new(run->world, &run->job->forward, run->pool, &run->forward, run->err);
    if (!st)
        add_note(run);
    return st;
}

static pm_status accumulation_of(pm_run *run, pm_accumulation **out)
{
    const pm_job *job = run->job;
    if (job->kind == PM_JOB_RENDER)
        return pm_accumulation_for_picture(run->world, &job->view, job->width, job->height,
                                           job->forward.seed, out, run->err);
    return pm_accumulation_for_sensors(run->world, job->sensors, job->sensor_count,
                                       job->quantity, job->forward.seed, out, run->err);
}

/* How far each pixel may still be off, and how often it was sampled. */
static pm_status add_error_layers(pm_run *run, const pm_accumulation *accumulation)
{
    pm_image *image = &run->answer->image;
    float *error = pm_image_add_layer(image, "error", 3);
    float *samples = error ? pm_image_add_layer(image, "samples", 1) : NULL;
    if (!samples)
        return pm_error_set(run->err, PM_E_MEMORY, "no memory for the picture's error");
    pm_accumulation_half_width(accumulation, error);
    for (size_t i = 0; i < pm_accumulation_count(accumulation); i++)
        samples[i] = (float)pm_accumulation_passes(accumulation);
    return PM_OK;
}

static pm_status take_values(pm_run *run, const pm_accumulation *accumulation)
{
    pm_answer *answer = run->answer;
    if (run->job->kind == PM_JOB_RENDER) {
        pm_status st = pm_image_init(&answer->image, run->job->width, run->job->height);
        if (st)
            return pm_error_set(run->err, st, "no memory for the picture");
        pm_accumulation_mean(accumulation, answer->image.rgb);
        return add_error_layers(run, accumulation);
    }
    size_t values = 3 * pm_accumulation_count(accumulation);
    answer->values = calloc(values + 1, sizeof *answer->values);
    answer->half_widths = calloc(values + 1, sizeof *answer->half_widths);
    if (!answer->values || !answer->half_widths)
        return pm_error_set(run->err, PM_E_MEMORY, "no memory for the values at sensors");
    pm_accumulation_mean(accumulation, answer->values);
    pm_accumulation_half_width(accumulation, answer->half_widths);
    return PM_OK;
}

static pm_status look(pm_run *run, pm_photon_map *const maps[PM_MAP_KINDS])
{
    pm_accumulation *accumulation = NULL;
    pm_status st = accumulation_of(run, &accumulation);
    if (!st)
        st = pm_run_passes(run, accumulation, maps);
    if (!st)
        st = take_values(run, accumulation);
    pm_accumulation_free(accumulation);
    return st;
}

/* The whole flow, on one screen. */
static pm_status flow(pm_run *run, const pm_bundle *bundle)
{
    pm_photon_map *maps[PM_MAP_KINDS] = {NULL};
    pm_status st = compile(run, bundle);
    if (st || run->job->kind == PM_JOB_CHECK)
        return st ? st
                  : pm_plan_make(run->world, &run->job->wanted, &run->answer->plan, run->err);
    st = start_forward(run);
    if (!st && run->job->wanted.estimator == PM_NEAREST)
        st = pm_run_make_maps(run, maps);
    if (!st && run->job->kind != PM_JOB_MAP)
        st = look(run, maps);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        if (!st && run->job->kind == PM_JOB_MAP)
            run->answer->map[kind] = maps[kind];
        else
            pm_photon_map_free(maps[kind]);
    }
    if (!st)
        run->answer->nonfinite += pm_forward_nonfinite(run->forward);
    return st;
}

pm_status pm_job_run(const pm_job *job, const pm_bundle *bundle, const pm_job_hooks *hooks,
                     pm_answer *out, pm_error *err)
{
    static const pm_job_hooks no_hooks;
    pm_answer answer = {.error = INFINITY};
    pm_error local = PM_ERROR_INIT;
    pm_run run = {.job = job,
                  .hooks = hooks ? hooks : &no_hooks,
                  .answer = &answer,
                  .err = err ? err : &local,
                  .wall_start = clock_seconds(CLOCK_MONOTONIC),
                  .cpu_start = clock_seconds(CLOCK_PROCESS_CPUTIME_ID),
                  .progress = {.error = INFINITY}};
    run.pool = pm_pool_new(job->threads);
    pm_status st =
        run.pool ? flow(&run, bundle)
                 : pm_error_set(run.err, PM_E_MEMORY, "cannot start %u threads", job->threads);
    answer.cpu_seconds = pm_run_cpu_seconds(&run);
    answer.wall_seconds = pm_run_wall_seconds(&run);
    pm_forward_free(run.forward);
    pm_world_free(run.world);
    pm_pool_free(run.pool);
    if (st)
        pm_answer_clear(&answer);
    else
        *out = answer;
    return st;
}

void pm_answer_clear(pm_answer *answer)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        pm_photon_map_free(answer->map[kind]);
        free(answer->maps[kind].passes);
    }
    pm_image_clear(&answer->image);
    free(answer->survey);
    free(answer->values);
    free(answer->half_widths);
    free(answer->hits);
    free(answer->hit_names);
    pm_arena_clear(&answer->names);
    free(answer->curve);
    *answer = (pm_answer){0};
}
