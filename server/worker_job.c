#include "worker_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "answer.h"
#include "protocol.h"
#include "request.h"

enum { PROGRESS_MS = 200 };

/* The files that came with the job, mapped; and what was read from them. */
struct input {
    const void *data[PM_MESSAGE_FILES];
    size_t size[PM_MESSAGE_FILES];
    size_t count;
    pm_request request;
    pm_bundle *bundle;
    pm_sensor *sensors;
    char names[PM_MAP_KINDS][32];
};

/* One job under way: what the hooks need. */
struct worker {
    int socket;
    pm_job job;
    pm_error lost; /* why the server cannot go on with us; set once */
    bool joined[PM_MAP_KINDS];
    struct outgoing {
        bool begun;
        int file; /* the next piece; -1: none yet */
        size_t filled;
    } maps[PM_MAP_KINDS]; /* files under way */
    double progress_ms;   /* when it was last told */
    const char *stage;    /* that was last told */
};

/* ---- hooks ---- */

static double now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static bool is_lost(void *context)
{
    const struct worker *worker = context;
    return worker->lost.status != PM_OK;
}

static void tell(struct worker *worker, pm_json *json, const int *files, size_t count)
{
    if (is_lost(worker))
        pm_json_free(json);
    else
        (void)!pm_message_send(worker->socket, json, files, count, &worker->lost);
}

/* Sends a question and waits for the answer; empty once the server is lost. */
static pm_message ask(struct worker *worker, pm_json *json, const int *files, size_t count)
{
    pm_message answer = {0};
    tell(worker, json, files, count);
    if (!is_lost(worker))
        (void)!pm_message_receive(worker->socket, &answer, &worker->lost);
    return answer;
}

static void progress(void *context, const pm_progress *at)
{
    struct worker *worker = context;
    double now = now_ms();
    bool new_stage = !worker->stage || strcmp(worker->stage, at->stage) != 0;
    if (!new_stage && now - worker->progress_ms < PROGRESS_MS)
        return;
    worker->progress_ms = now;
    worker->stage = at->stage;
    tell(worker, pm_progress_json(at), NULL, 0);
}

static void begin(void *context, const pm_digest *family, pm_map_kind kind)
{
    struct worker *worker = context;
    char hex[PM_DIGEST_HEX];
    pm_digest_hex(family, hex);
    pm_message answer = ask(worker,
                            pm_json_pack("{s:s, s:s, s:s}", "type", "begin", "family", hex,
                                         "kind", pm_map_kind_name(kind)),
                            NULL, 0);
    worker->joined[kind] = pm_json_get_bool(answer.json, "joined", false);
    pm_message_clear(&answer);
}

static void end(void *context, const pm_digest *family)
{
    struct worker *worker = context;
    char hex[PM_DIGEST_HEX];
    pm_digest_hex(family, hex);
    pm_message answer =
        ask(worker, pm_json_pack("{s:s, s:s}", "type", "end", "family", hex), NULL, 0);
    if (!is_lost(worker) && !pm_json_get_bool(answer.json, "ok", false))
        pm_error_set(&worker->lost, PM_E_IO, "the store does not take the photons");
    pm_message_clear(&answer);
}

static bool fetch(void *context, const pm_digest *family, uint64_t index, const void **data,
                  size_t *size)
{
    struct worker *worker = context;
    char hex[PM_DIGEST_HEX];
    pm_digest_hex(family, hex);
    pm_message answer = ask(worker,
                            pm_json_pack("{s:s, s:s, s:I}", "type", "fetch", "family", hex,
                                         "index", (long long)index),
                            NULL, 0);
    bool found = pm_json_get_bool(answer.json, "found", false) && answer.file_count == 1 &&
                 !pm_memory_map(answer.files[0], data, size, &worker->lost);
    pm_message_clear(&answer);
    return found;
}

static void release(void *context, const void *data, size_t size)
{
    (void)context;
    pm_memory_unmap(data, size);
}

static void keep(void *context, const pm_digest *family, pm_map_kind kind, uint64_t index,
                 const pm_bytes *bytes)
{
    struct worker *worker = context;
    char hex[PM_DIGEST_HEX];
    int file = -1;
    pm_digest_hex(family, hex);
    if (pm_memory_file_of(bytes->data, bytes->size, &file, &worker->lost))
        return;
    pm_message answer =
        ask(worker,
            pm_json_pack("{s:s, s:s, s:s, s:I}", "type", "keep", "family", hex, "kind",
                         pm_map_kind_name(kind), "index", (long long)index),
            &file, 1);
    pm_message_clear(&answer);
    close(file);
}

/* ---- files of maps, piece by piece ---- */

static const char *map_name(const struct worker *worker, pm_map_kind kind)
{
    return pm_map_wanted_name(&worker->job.wanted.maps[kind], kind);
}

static pm_status send_piece(struct worker *worker, pm_map_kind kind, pm_error *err)
{
    struct outgoing *map = &worker->maps[kind];
    pm_status st = pm_memory_file_seal(map->file, err);
    if (!st) {
        pm_message answer = ask(
            worker, pm_json_pack("{s:s, s:s}", "type", "piece", "name", map_name(worker, kind)),
            &map->file, 1);
        if (is_lost(worker) || !pm_json_get_bool(answer.json, "ok", false))
            st = pm_error_set(err, PM_E_IO, "the store does not take the map");
        pm_message_clear(&answer);
    }
    close(map->file);
    map->file = -1;
    map->filled = 0;
    return st;
}

static pm_status put(void *context, pm_map_kind kind, const void *data, size_t size,
                     pm_error *err)
{
    struct worker *worker = context;
    struct outgoing *map = &worker->maps[kind];
    const char *at = data;
    pm_status st = PM_OK;
    map->begun = true;
    while (size && !st) {
        size_t room = PM_PIECE_BYTES - map->filled, part = size < room ? size : room;
        if (map->file < 0)
            st = pm_memory_file_new(&map->file, err);
        if (!st)
            st = pm_memory_file_append(map->file, at, part, err);
        map->filled += part;
        at += part;
        size -= part;
        if (!st && map->filled == PM_PIECE_BYTES)
            st = send_piece(worker, kind, err);
    }
    return st;
}

static pm_status end_maps(struct worker *worker, pm_error *err)
{
    pm_status st = PM_OK;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        struct outgoing *map = &worker->maps[kind];
        if (map->file >= 0)
            st = send_piece(worker, (pm_map_kind)kind, err);
        if (!st && map->begun)
            tell(worker,
                 pm_json_pack("{s:s, s:s, s:s}", "type", "result", "name",
                              map_name(worker, (pm_map_kind)kind), "format", "pm"),
                 NULL, 0);
    }
    return st ? st : worker->lost.status;
}

/* ---- what came ---- */

static pm_status map_files(const pm_message *message, struct input *in, pm_error *err)
{
    for (size_t i = 0; i < message->file_count; i++) {
        pm_status st = pm_memory_map(message->files[i], &in->data[i], &in->size[i], err);
        if (st)
            return st;
        in->count = i + 1;
    }
    return PM_OK;
}

static void clear_input(struct input *in)
{
    free(in->sensors);
    pm_bundle_free(in->bundle);
    pm_request_clear(&in->request);
    for (size_t i = 0; i < in->count; i++)
        pm_memory_unmap(in->data[i], in->size[i]);
}

/* The files after the bundle, in the order that protocol.h gives. */
static pm_status read_attachments(struct input *in, pm_job *job, pm_error *err)
{
    size_t next = 2;
    pm_status st = PM_OK;
    if (in->request.has_points && next < in->count) {
        st = pm_sensors_parse(in->data[next], in->size[next], "points", &in->sensors,
                              &job->sensor_count, err);
        job->sensors = in->sensors;
        next++;
    }
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        if (!in->request.has_map_file[kind])
            continue;
        if (next >= in->count)
            return pm_error_set(err, PM_E_CORRUPT, "a job came without its map file");
        snprintf(in->names[kind], sizeof in->names[kind], "%s map",
                 pm_map_wanted_name(&job->wanted.maps[kind], (pm_map_kind)kind));
        job->files[kind] = (pm_map_file){in->data[next], in->size[next], in->names[kind]};
        next++;
    }
    return st;
}

/* A check looks at the scene alone; its plan is that of a job with every map. */
static pm_job check_job(void)
{
    pm_job job = {.kind = PM_JOB_CHECK, .forward = pm_forward_defaults()};
    job.wanted = (pm_wanted){.estimator = PM_PROGRESSIVE, .ambient_bounces = 1};
    return job;
}

static pm_status read_job(const pm_message *message, struct input *in, pm_job *job,
                          pm_error *err)
{
    pm_status st = map_files(message, in, err);
    if (!st && (in->count < 2 || strcmp(pm_message_type(message), "job") != 0))
        st = pm_error_set(err, PM_E_CORRUPT, "no job came");
    if (!st)
        st = pm_bundle_read_tar(in->data[1], in->size[1], SIZE_MAX / 2, &in->bundle, err);
    if (!st && pm_json_get_bool(message->json, "check", false)) {
        *job = check_job();
    } else if (!st) {
        st = pm_request_parse(in->data[0], in->size[0], &in->request, err);
        if (!st) {
            *job = in->request.job;
            st = read_attachments(in, job, err);
        }
    }
    job->main_name = pm_json_get_text(message->json, "main", "");
    if (!job->threads)
        job->threads = (unsigned)pm_json_get_integer(message->json, "threads", 1);
    return st;
}

/* ---- what goes back ---- */

static pm_status send_bytes(struct worker *worker, pm_bytes *bytes, pm_json *json)
{
    int file = -1;
    pm_error *err = &worker->lost;
    pm_status st = pm_bytes_status(bytes);
    if (st)
        pm_error_set(err, st, "no memory for a result");
    else
        st = pm_memory_file_of(bytes->data, bytes->size, &file, err);
    if (st)
        pm_json_free(json);
    else
        st = pm_message_send(worker->socket, json, &file, 1, err);
    if (file >= 0)
        close(file);
    pm_bytes_clear(bytes);
    return st;
}

static pm_status send_result(struct worker *worker, pm_bytes *bytes, const char *name,
                             const char *format)
{
    return send_bytes(
        worker, bytes,
        pm_json_pack("{s:s, s:s, s:s}", "type", "result", "name", name, "format", format));
}

static pm_status write_picture(pm_format format, const pm_image *image,
                               const pm_image_notes *notes, pm_bytes *out, pm_error *err)
{
    switch (format) {
    case PM_FORMAT_EXR:
        return pm_image_write_exr(image, notes, out, err);
    case PM_FORMAT_HDR:
        return pm_image_write_hdr(image, notes, out, err);
    default:
        return pm_image_write_png(image, notes, out, err);
    }
}

/* Scene, maps and stop of a picture, so that it can be made again. */
struct notes {
    char scene[PM_DIGEST_HEX];
    char family[PM_MAP_KINDS][PM_DIGEST_HEX + 32];
    char passes[16], error[32], seed[24], ab[16], view[PM_VIEW_TEXT], aspect[32];
    pm_image_note list[6 + PM_MAP_KINDS];
    size_t count;
};

static void note(struct notes *notes, const char *name, const char *value)
{
    notes->list[notes->count++] = (pm_image_note){name, value};
}

/* As rpict: where pixels are not square, their height over their width. */
static void note_aspect(const struct worker *worker, struct notes *notes)
{
    const pm_job *job = &worker->job;
    double x, y;
    pm_view_extent(&job->view, &x, &y);
    double aspect = y / x * job->width / job->height;
    if (aspect > .99 && aspect < 1.01)
        return;
    snprintf(notes->aspect, sizeof notes->aspect, "%.6f", aspect);
    note(notes, "PIXASPECT", notes->aspect);
}

static void make_notes(const struct worker *worker, const pm_answer *answer,
                       struct notes *notes)
{
    static const char *const names[PM_MAP_KINDS] = {"pm.global", "pm.caustic", "pm.volume",
                                                    "pm.direct"};
    pm_digest_hex(&answer->scene, notes->scene);
    note(notes, "pm.scene", notes->scene);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        if (!answer->maps[kind].present)
            continue;
        pm_digest_hex(&answer->maps[kind].family, notes->family[kind]);
        snprintf(notes->family[kind] + PM_DIGEST_HEX - 1, 32, "-%llu",
                 (unsigned long long)answer->maps[kind].photons);
        note(notes, names[kind], notes->family[kind]);
    }
    snprintf(notes->passes, sizeof notes->passes, "%u", (unsigned)answer->passes);
    note(notes, "pm.passes", notes->passes);
    snprintf(notes->error, sizeof notes->error, "%.6g", answer->error);
    note(notes, "pm.error", notes->error);
    snprintf(notes->seed, sizeof notes->seed, "%llu",
             (unsigned long long)worker->job.forward.seed);
    note(notes, "pm.seed", notes->seed);
    snprintf(notes->ab, sizeof notes->ab, "%d", worker->job.wanted.ambient_bounces);
    note(notes, "pm.ab", notes->ab);
    pm_view_format(&worker->job.view, notes->view);
    note_aspect(worker, notes);
}

static pm_status send_pictures(struct worker *worker, const pm_answer *answer, unsigned formats,
                               pm_error *err)
{
    struct notes notes = {0};
    make_notes(worker, answer, &notes);
    const pm_image_notes all = {.list = notes.list,
                                .count = notes.count,
                                .view = notes.view,
                                .command = worker->job.command};
    pm_status st = PM_OK;
    for (int format = 0; format < PM_FORMATS && !st; format++) {
        if (!(formats & (1U << format)))
            continue;
        const char *extension = pm_format_name((pm_format)format);
        char name[32];
        snprintf(name, sizeof name, "picture.%s", extension);
        pm_bytes bytes = {0};
        st = write_picture((pm_format)format, &answer->image, &all, &bytes, err);
        if (!st)
            st = send_result(worker, &bytes, name, extension);
        pm_bytes_clear(&bytes);
    }
    return st;
}

static void put_vector(pm_bytes *out, pm_vec3 v)
{
    pm_bytes_format(out, "\t%.12g\t%.12g\t%.12g", v.x, v.y, v.z);
}

/* One of rtrace's columns. Where nothing is met the distance is 1e10, as in Radiance. */
static void put_field(pm_bytes *out, char letter, const pm_sensor *sensor,
                      const pm_first_hit *hit, const pm_hit_names *names)
{
    switch (letter) {
    case 'o':
        put_vector(out, sensor->point);
        break;
    case 'd':
        put_vector(out, pm_view_unit(sensor->normal));
        break;
    case 'L':
        pm_bytes_format(out, "\t%.12g", hit->met ? hit->distance : 1e10);
        break;
    case 'p':
        put_vector(out, hit->point);
        break;
    case 'n':
        put_vector(out, hit->normal);
        break;
    case 'N':
        put_vector(out, hit->geometric_normal);
        break;
    case 'c':
        pm_bytes_format(out, "\t%.12g\t%.12g", hit->u, hit->v);
        break;
    default:
        pm_bytes_format(out, "\t%s",
                        letter == 's'   ? names->surface
                        : letter == 'm' ? names->modifier
                                        : names->material);
    }
}

/* A line a sensor: r g b and the half-widths of their 95 % intervals, then the fields. Nine
 * digits give a float back exactly. */
static pm_status send_values(struct worker *worker, const pm_answer *answer, const char *fields)
{
    pm_bytes bytes = {0};
    for (size_t i = 0; i < worker->job.sensor_count; i++) {
        const float *v = &answer->values[3 * i], *w = &answer->half_widths[3 * i];
        pm_bytes_format(&bytes, "%.9g\t%.9g\t%.9g\t%.9g\t%.9g\t%.9g", (double)v[0],
                        (double)v[1], (double)v[2], (double)w[0], (double)w[1], (double)w[2]);
        for (const char *letter = fields; *letter; letter++)
            put_field(&bytes, *letter, &worker->job.sensors[i], &answer->hits[i],
                      &answer->hit_names[i]);
        pm_bytes_u8(&bytes, '\n');
    }
    return send_result(worker, &bytes, "values.txt", "txt");
}

static pm_status send_results(struct worker *worker, const pm_answer *answer,
                              const pm_request *request, pm_error *err)
{
    switch (worker->job.kind) {
    case PM_JOB_RENDER:
        return send_pictures(worker, answer, request->formats, err);
    case PM_JOB_TRACE:
        return send_values(worker, answer, request->fields);
    case PM_JOB_MAP:
        return end_maps(worker, err);
    case PM_JOB_CHECK:
        break;
    }
    return PM_OK;
}

static pm_status send_done(struct worker *worker, const pm_answer *answer, pm_error *err)
{
    pm_json *json = worker->job.kind == PM_JOB_CHECK
                        ? pm_answer_scene_json(answer)
                        : pm_answer_json(&worker->job, answer, worker->joined);
    char *text = json ? pm_json_text(json) : NULL;
    pm_json_free(json);
    if (!text)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the answer");
    pm_bytes bytes = {0};
    pm_bytes_text(&bytes, text);
    free(text);
    return send_bytes(worker, &bytes, pm_json_pack("{s:s}", "type", "done"));
}

/* ---- together ---- */

static const pm_job_hooks hooks = {.cancelled = is_lost,
                                   .progress = progress,
                                   .fetch = fetch,
                                   .release = release,
                                   .keep = keep,
                                   .begin = begin,
                                   .end = end,
                                   .put = put};

static pm_status run(struct worker *worker, const struct input *in, pm_error *err)
{
    pm_answer answer = {0};
    pm_job_hooks own = hooks;
    own.context = worker;
    pm_status st = pm_job_run(&worker->job, in->bundle, &own, &answer, err);
    if (st)
        return st;
    st = send_results(worker, &answer, &in->request, err);
    if (!st)
        st = send_done(worker, &answer, err);
    pm_answer_clear(&answer);
    return st;
}

static pm_status send_failed(int socket, const pm_error *why)
{
    return pm_message_send(
        socket,
        pm_json_pack("{s:s, s:i, s:o, s:o, s:i, s:i}", "type", "failed", "status",
                     (int)why->status, "text", pm_json_quote(why->text), "file",
                     pm_json_quote(why->file), "line", why->line, "column", why->column),
        NULL, 0, NULL);
}

int pm_worker_serve(int socket)
{
    struct worker worker = {.socket = socket};
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        worker.maps[kind].file = -1;
    struct input in = {0};
    pm_message message = {0};
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_message_receive(socket, &message, &err);
    if (!st)
        st = read_job(&message, &in, &worker.job, &err);
    if (!st)
        st = run(&worker, &in, &err);
    /* What the server lacks explains a cancelled job; a lost socket cannot be told anything. */
    if (st)
        st = send_failed(socket, worker.lost.status ? &worker.lost : &err);
    clear_input(&in);
    pm_message_clear(&message);
    return st ? 1 : 0;
}
