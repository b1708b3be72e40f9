#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "pipeline.h"

/* Instead of the engine, in tests of the service: a worker that does what the words of the
 * scene's text say. Batches of maps are eight bytes, BATCH_PHOTONS photons each. */

enum { BATCH_PHOTONS = 1000 };

struct scene {
    const char *text;
    pm_digest hash;
};

static bool says(const struct scene *scene, const char *word)
{
    return strstr(scene->text, word) != NULL;
}

static void sleep_ms(long ms)
{
    nanosleep(&(struct timespec){.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000}, NULL);
}

static void spin(void)
{
    for (volatile unsigned i = 0;; i++)
        ;
}

static pm_status eat_memory(pm_error *err)
{
    enum { PIECE = 64 << 20 };
    for (;;)
        if (!malloc(PIECE))
            return pm_error_set(err, PM_E_MEMORY, "no memory for photons");
}

static pm_status try_open(pm_error *err)
{
    int file = open("/etc/passwd", O_RDONLY);
    return file < 0 ? pm_error_set(err, PM_E_IO, "files are closed")
                    : pm_error_set(err, PM_E_IO, "files are OPEN");
}

/* What a scene does to the process; PM_OK if it does nothing to it. */
static pm_status misbehave(const struct scene *scene, const pm_job *job,
                           const pm_job_hooks *hooks, pm_error *err)
{
    if (says(scene, "error"))
        return pm_error_set_at(err, PM_E_SYNTAX, job->main_name, 3, 7, "\xff is no number");
    if (job->kind == PM_JOB_CHECK && !says(scene, "at once"))
        return PM_OK;
    if (says(scene, "crash"))
        abort();
    if (says(scene, "socket"))
        return socket(AF_INET, SOCK_STREAM, 0) < 0 ? PM_E_IO : PM_OK;
    if (says(scene, "open"))
        return try_open(err);
    if (says(scene, "spin"))
        spin();
    if (says(scene, "memory"))
        return eat_memory(err);
    if (says(scene, "leave"))
        _exit(7);
    while (says(scene, "hang")) {
        static const pm_progress progress = {
            .stage = "forward", .done = .25, .error = INFINITY};
        hooks->progress(hooks->context, &progress);
        sleep_ms(20);
    }
    return PM_OK;
}

static pm_digest family_of(const struct scene *scene, int kind)
{
    uint8_t bytes[33];
    memcpy(bytes, scene->hash.bytes, 32);
    bytes[32] = (uint8_t)kind;
    return pm_digest_of(bytes, sizeof bytes);
}

static bool fetch(const pm_job_hooks *hooks, const pm_digest *family, uint64_t index)
{
    const void *data;
    size_t size;
    if (!hooks->fetch(hooks->context, family, index, &data, &size))
        return false;
    bool same = size == sizeof index && !memcmp(data, &index, size);
    hooks->release(hooks->context, data, size);
    if (!same)
        abort();
    return true;
}

static void keep(const pm_job_hooks *hooks, const pm_digest *family, int kind, uint64_t index)
{
    pm_bytes bytes = {0};
    pm_bytes_append(&bytes, &index, sizeof index);
    hooks->keep(hooks->context, family, (pm_map_kind)kind, index, &bytes);
    pm_bytes_clear(&bytes);
}

static void make_map(const struct scene *scene, const pm_job *job, const pm_job_hooks *hooks,
                     int kind, pm_map_summary *out)
{
    uint64_t count = job->wanted.maps[kind].count;
    uint64_t batches = (count + BATCH_PHOTONS - 1) / BATCH_PHOTONS;
    pm_digest family = family_of(scene, kind);
    *out = (pm_map_summary){
        .present = true, .family = family, .photons = count, .paths = batches * PM_BATCH_PATHS};
    hooks->begin(hooks->context, &family, (pm_map_kind)kind);
    for (uint64_t i = 0; i < batches && !hooks->cancelled(hooks->context); i++) {
        const pm_progress progress = {
            .stage = "forward", .done = (double)i / (double)batches, .error = INFINITY};
        hooks->progress(hooks->context, &progress);
        if (fetch(hooks, &family, i)) {
            out->paths_cached += PM_BATCH_PATHS;
            continue;
        }
        if (says(scene, "slow"))
            sleep_ms(100);
        keep(hooks, &family, kind, i);
        out->paths_traced += PM_BATCH_PATHS;
    }
    hooks->end(hooks->context, &family);
}

/* Noise, so that files are as large as their pictures. */
static pm_status make_picture(const pm_job *job, pm_answer *out)
{
    uint32_t x = 1;
    pm_status st = pm_image_init(&out->image, job->width, job->height);
    for (size_t i = 0; !st && i < (size_t)3 * job->width * job->height; i++) {
        x = x * 1664525U + 1013904223U;
        out->image.rgb[i] = (float)x / 4294967296.F;
    }
    return st;
}

static pm_status make_values(const pm_job *job, pm_answer *out)
{
    out->values = calloc(3 * job->sensor_count, sizeof *out->values);
    out->half_widths = calloc(3 * job->sensor_count, sizeof *out->half_widths);
    if (!out->values || !out->half_widths)
        return PM_E_MEMORY;
    for (size_t i = 0; i < job->sensor_count; i++)
        out->values[3 * i] = (float)job->sensors[i].point.x;
    return PM_OK;
}

static void make_curve(pm_answer *out)
{
    out->curve = malloc(2 * sizeof *out->curve);
    if (!out->curve)
        return;
    out->curve[0] = (pm_curve_point){.1, .2, 1, INFINITY};
    out->curve[1] = (pm_curve_point){.2, .4, 2, .01};
    out->curve_count = 2;
    out->passes = 2;
    out->error = .01;
}

pm_status pm_job_run(const pm_job *job, const pm_bundle *bundle, const pm_job_hooks *hooks,
                     pm_answer *out, pm_error *err)
{
    const pm_file *file = pm_bundle_find(bundle, job->main_name, NULL);
    if (!file)
        return pm_error_set_at(err, PM_E_MISSING, job->main_name, 0, 0, "is not in the bundle");
    char *text = strndup((const char *)file->data, file->size);
    struct scene scene = {text, pm_digest_of(file->data, file->size)};
    pm_status st = misbehave(&scene, job, hooks, err);
    pm_answer answer = {.scene = scene.hash, .error = INFINITY};
    answer.world.surfaces = 3;
    answer.world.lights = 1;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++)
        if (job->wanted.maps[kind].wanted && !job->files[kind].data)
            make_map(&scene, job, hooks, kind, &answer.maps[kind]);
    free(text);
    if (!st && hooks->cancelled(hooks->context))
        st = pm_error_set(err, PM_E_CANCELLED, "cancelled");
    if (!st && job->kind == PM_JOB_RENDER)
        st = make_picture(job, &answer);
    if (!st && job->kind == PM_JOB_TRACE)
        st = make_values(job, &answer);
    if (!st && job->kind != PM_JOB_MAP)
        make_curve(&answer);
    if (st)
        pm_answer_clear(&answer);
    else
        *out = answer;
    return st;
}

void pm_answer_clear(pm_answer *answer)
{
    pm_image_clear(&answer->image);
    free(answer->values);
    free(answer->half_widths);
    free(answer->curve);
    *answer = (pm_answer){0};
}
