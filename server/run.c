#include "run.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/pidfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "problem.h"
#include "protocol.h"

enum {
    SOCKET_IN_WORKER = 3,
    FLUSH_BYTES = 32 << 20, /* batches are committed together: a commit waits for the disk */
    FLUSH_COUNT = 256,
    END_WAIT_MS = 10000,     /* for a worker that has said its last word */
    CHECK_CPU_SECONDS = 600, /* a scene that takes longer to compile is refused */
};

/* A result that comes in pieces, which go on into the store. */
struct incoming {
    char name[64]; /* "": none */
    int64_t upload;
    pm_hasher *hasher;
    uint64_t size;
};

/* A worker under way. */
struct run {
    const pm_run_settings *settings;
    const pm_task *task;
    pm_outcome *out;
    pm_request request; /* of a job */
    pid_t pid;
    int pidfd, socket;
    pm_stored_batch kept[FLUSH_COUNT]; /* not yet in the store */
    size_t kept_count, kept_bytes;
    struct incoming incoming[PM_MAP_KINDS];
    pm_error err; /* of the server's side; the first wins */
    bool finished;
};

/* ---- a blob as a memory file ---- */

static pm_status copy_blob(pm_store *store, const pm_blob *blob, int file, pm_error *err)
{
    void *chunk = malloc(PM_CHUNK_BYTES);
    if (!chunk)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a chunk");
    pm_status st = PM_OK;
    for (uint64_t at = 0; at < blob->size && !st; at += PM_CHUNK_BYTES) {
        size_t size = 0;
        st = pm_store_blob_chunk(store, blob, at / PM_CHUNK_BYTES, chunk, &size, err);
        if (!st)
            st = pm_memory_file_append(file, chunk, size, err);
    }
    free(chunk);
    return st;
}

static pm_status blob_file(pm_store *store, const pm_blob *blob, int *file, pm_error *err)
{
    int made = -1;
    pm_status st = pm_memory_file_new(&made, err);
    if (!st)
        st = copy_blob(store, blob, made, err);
    if (!st)
        st = pm_memory_file_seal(made, err);
    if (!st)
        *file = made;
    else if (made >= 0)
        close(made);
    return st;
}

static pm_status digest_file(pm_store *store, const pm_digest *digest, int *file, pm_error *err)
{
    pm_blob blob;
    char hex[PM_DIGEST_HEX];
    pm_error why = PM_ERROR_INIT;
    pm_status st = pm_store_blob_find(store, digest, &blob, &why);
    if (!st)
        st = blob_file(store, &blob, file, &why);
    if (!st)
        return PM_OK;
    pm_digest_hex(digest, hex);
    return st == PM_E_CORRUPT
               ? pm_error_set(err, st, "blob %s is damaged in the store; send it again", hex)
               : pm_error_set(err, st, "%s", why.text);
}

/* If the worker is gone, its exit status is the reason, not that it cannot be told. */
static pm_status tell(struct run *run, pm_json *json, const int *files, size_t count)
{
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_message_send(run->socket, json, files, count, &err);
    if (st && st != PM_E_MISSING)
        pm_error_set(&run->err, st, "%s", err.text);
    return st;
}

/* ---- the job's first message ---- */

struct files {
    int list[PM_MESSAGE_FILES];
    size_t count;
};

static pm_status add_blob(struct run *run, const pm_digest *digest, struct files *files)
{
    pm_status st =
        digest_file(run->settings->store, digest, &files->list[files->count], &run->err);
    if (!st)
        files->count++;
    return st;
}

static pm_status add_files(struct run *run, struct files *files)
{
    const char *request = run->task->request ? run->task->request : "";
    pm_status st = pm_memory_file_of(request, strlen(request), &files->list[0], &run->err);
    if (st)
        return st;
    files->count = 1;
    st = add_blob(run, &run->task->bundle, files);
    if (!st && run->request.has_points)
        st = add_blob(run, &run->request.points, files);
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++)
        if (run->request.has_map_file[kind])
            st = add_blob(run, &run->request.map_file[kind], files);
    return st;
}

static pm_status send_job(struct run *run)
{
    struct files files = {.count = 0};
    pm_status st = PM_OK;
    if (run->task->request)
        st = pm_request_parse(run->task->request, strlen(run->task->request), &run->request,
                              &run->err);
    if (!st)
        st = add_files(run, &files);
    if (!st)
        st = tell(run,
                  pm_json_pack("{s:s, s:s, s:b, s:i}", "type", "job", "main",
                               run->task->main_name, "check", run->task->request == NULL,
                               "threads", (int)run->settings->threads),
                  files.list, files.count);
    for (size_t i = 0; i < files.count; i++)
        close(files.list[i]);
    return st;
}

/* ---- messages of the worker; what it says is checked like anybody's ---- */

static bool read_family(const pm_message *message, pm_digest *family)
{
    return pm_digest_parse(pm_json_get_text(message->json, "family", ""), family);
}

static pm_status refuse(struct run *run)
{
    return pm_error_set(&run->err, PM_E_CORRUPT,
                        "the worker sent a message that makes no sense");
}

static pm_status on_begin(struct run *run, const pm_message *message)
{
    pm_digest family;
    if (!read_family(message, &family))
        return refuse(run);
    bool joined =
        pm_building_begin(run->settings->building, &family, run->task->id, run->task->stop);
    return tell(run, pm_json_pack("{s:s, s:b}", "type", "begun", "joined", joined), NULL, 0);
}

static void drop_kept(struct run *run)
{
    for (size_t i = 0; i < run->kept_count; i++)
        pm_memory_unmap(run->kept[i].data, run->kept[i].size);
    run->kept_count = run->kept_bytes = 0;
}

static pm_status flush(struct run *run)
{
    pm_status st = PM_OK;
    if (run->kept_count)
        st = pm_store_batches_put(run->settings->store, run->kept, run->kept_count, &run->err);
    if (!st)
        run->out->batches_kept += run->kept_count;
    drop_kept(run);
    return st;
}

static pm_status on_end(struct run *run, const pm_message *message)
{
    pm_digest family;
    if (!read_family(message, &family))
        return refuse(run);
    bool stored = !flush(run);
    pm_building_end(run->settings->building, &family, run->task->id);
    return tell(run, pm_json_pack("{s:s, s:b}", "type", "ended", "ok", stored), NULL, 0);
}

static pm_status find_batch(struct run *run, const pm_digest *family, uint64_t index, int *file)
{
    pm_store *store = run->settings->store;
    pm_blob blob;
    pm_status st = pm_store_batch_find(store, family, index, &blob, &run->err);
    if (st)
        return st;
    pm_error damaged = PM_ERROR_INIT; /* traced again, so no error of the job */
    st = blob_file(store, &blob, file, &damaged);
    if (st == PM_E_CORRUPT)
        pm_store_blob_drop(store, &blob);
    return st ? PM_E_MISSING : PM_OK;
}

static pm_status on_fetch(struct run *run, const pm_message *message)
{
    pm_digest family;
    int64_t index = pm_json_get_integer(message->json, "index", -1);
    if (!read_family(message, &family) || index < 0)
        return refuse(run);
    int file = -1;
    pm_status st = find_batch(run, &family, (uint64_t)index, &file);
    if (st && st != PM_E_MISSING)
        return st;
    run->out->batches_read += !st;
    st = tell(run, pm_json_pack("{s:s, s:b}", "type", "batch", "found", file >= 0), &file,
              file >= 0);
    if (file >= 0)
        close(file);
    return st;
}

static pm_status on_keep(struct run *run, const pm_message *message)
{
    pm_stored_batch *batch = &run->kept[run->kept_count];
    int64_t index = pm_json_get_integer(message->json, "index", -1);
    if (!read_family(message, &batch->family) || index < 0 || message->file_count != 1)
        return refuse(run);
    batch->index = (uint64_t)index;
    pm_status st = pm_memory_map(message->files[0], &batch->data, &batch->size, &run->err);
    if (st)
        return st;
    run->kept_count++;
    run->kept_bytes += batch->size;
    if (run->kept_count == FLUSH_COUNT || run->kept_bytes >= FLUSH_BYTES)
        st = flush(run);
    if (st)
        return st;
    return tell(run, pm_json_pack("{s:s}", "type", "kept"), NULL, 0);
}

/* Names go into links. */
static bool is_plain(const char *name)
{
    return *name && !name[strspn(name, "abcdefghijklmnopqrstuvwxyz-.")];
}

/* ---- results; large ones piece by piece ---- */

/* The one of that name; "": one that is free. */
static struct incoming *find_incoming(struct run *run, const char *name)
{
    for (int i = 0; i < PM_MAP_KINDS; i++)
        if (!strcmp(run->incoming[i].name, name))
            return &run->incoming[i];
    return NULL;
}

static pm_status begin_incoming(struct run *run, const char *name, struct incoming **out)
{
    struct incoming *in = find_incoming(run, "");
    if (!in || !is_plain(name) || strlen(name) >= sizeof in->name)
        return refuse(run);
    in->hasher = pm_hasher_new();
    if (!in->hasher)
        return pm_error_set(&run->err, PM_E_MEMORY, "no memory for a digest");
    strcpy(in->name, name);
    *out = in;
    return pm_store_upload_begin(run->settings->store, &in->upload, &run->err);
}

static void clear_incoming(struct run *run, struct incoming *in, bool finished)
{
    if (in->upload && !finished)
        pm_store_upload_abandon(run->settings->store, in->upload);
    pm_hasher_free(in->hasher);
    *in = (struct incoming){.upload = 0};
}

static pm_status take_piece(struct run *run, struct incoming *in, const void *data, size_t size)
{
    if (!size || size > PM_PIECE_BYTES || in->size % PM_PIECE_BYTES)
        return refuse(run);
    pm_hasher_add(in->hasher, data, size);
    pm_status st = pm_store_upload_chunk(run->settings->store, in->upload,
                                         in->size / PM_CHUNK_BYTES, data, size, &run->err);
    in->size += size;
    return st;
}

static pm_status on_piece(struct run *run, const pm_message *message)
{
    const char *name = pm_json_get_text(message->json, "name", "");
    const void *data;
    size_t size;
    if (message->file_count != 1 || !*name)
        return refuse(run);
    struct incoming *in = find_incoming(run, name);
    pm_status st = in ? PM_OK : begin_incoming(run, name, &in);
    if (!st)
        st = pm_memory_map(message->files[0], &data, &size, &run->err);
    if (st)
        return st;
    st = take_piece(run, in, data, size);
    pm_memory_unmap(data, size);
    pm_status told = tell(run, pm_json_pack("{s:s, s:b}", "type", "taken", "ok", !st), NULL, 0);
    return st ? st : told;
}

static pm_status end_incoming(struct run *run, const char *name, pm_run_result *out)
{
    struct incoming *in = find_incoming(run, name);
    bool existed;
    if (!in)
        return refuse(run);
    out->digest = pm_hasher_finish(in->hasher);
    out->size = in->size;
    out->stored = true;
    pm_status st = pm_store_upload_finish(run->settings->store, in->upload, &out->digest,
                                          in->size, &existed, &run->err);
    clear_incoming(run, in, !st);
    return st;
}

static pm_status on_result(struct run *run, const pm_message *message)
{
    pm_outcome *out = run->out;
    const char *name = pm_json_get_text(message->json, "name", "");
    const char *format = pm_json_get_text(message->json, "format", "");
    if (out->result_count == PM_RUN_RESULTS || message->file_count > 1 || !is_plain(name) ||
        !is_plain(format))
        return refuse(run);
    pm_run_result *result = &out->results[out->result_count];
    *result = (pm_run_result){.stored = false};
    snprintf(result->name, sizeof result->name, "%s", name);
    snprintf(result->format, sizeof result->format, "%s", format);
    pm_status st = message->file_count ? pm_memory_map(message->files[0], &result->data,
                                                       &result->size, &run->err)
                                       : end_incoming(run, name, result);
    if (!st)
        out->result_count++;
    return st;
}

static pm_status on_done(struct run *run, const pm_message *message)
{
    const void *data;
    size_t size;
    if (message->file_count != 1)
        return refuse(run);
    pm_status st = pm_memory_map(message->files[0], &data, &size, &run->err);
    if (st)
        return st;
    st = pm_json_parse(data, size, "answer", &run->out->answer, &run->err);
    pm_memory_unmap(data, size);
    run->finished = !st;
    return st;
}

static pm_status on_failed(struct run *run, const pm_message *message)
{
    pm_error err = {.status =
                        (pm_status)pm_json_get_integer(message->json, "status", PM_E_CORRUPT),
                    .line = (int)pm_json_get_integer(message->json, "line", 0),
                    .column = (int)pm_json_get_integer(message->json, "column", 0)};
    snprintf(err.file, sizeof err.file, "%s", pm_json_get_text(message->json, "file", ""));
    snprintf(err.text, sizeof err.text, "%s", pm_json_get_text(message->json, "text", ""));
    run->finished = true;
    /* What went wrong on our side is the cause of what the worker says. */
    run->out->problem = pm_problem_of(run->err.status ? &run->err : &err);
    return PM_OK;
}

static pm_status on_progress(struct run *run, const pm_message *message)
{
    pm_json *copy = pm_json_copy(message->json);
    if (copy)
        run->task->progress(run->task->context, copy);
    return PM_OK;
}

static const struct {
    const char *type;
    pm_status (*handle)(struct run *run, const pm_message *message);
} handlers[] = {
    {"progress", on_progress}, {"fetch", on_fetch}, {"keep", on_keep},
    {"begin", on_begin},       {"end", on_end},     {"piece", on_piece},
    {"result", on_result},     {"done", on_done},   {"failed", on_failed},
};

static pm_status handle(struct run *run, const pm_message *message)
{
    for (size_t i = 0; i < sizeof handlers / sizeof *handlers; i++)
        if (!strcmp(pm_message_type(message), handlers[i].type))
            return handlers[i].handle(run, message);
    return refuse(run);
}

/* Until the worker has said its last word, is gone, or makes no sense. */
static void converse(struct run *run)
{
    pm_status st = PM_OK;
    while (!st && !run->finished) {
        pm_message message = {0};
        pm_error gone = PM_ERROR_INIT;
        st = pm_message_receive(run->socket, &message, &gone);
        if (!st)
            st = handle(run, &message);
        else if (st != PM_E_MISSING)
            pm_error_set(&run->err, st, "%s", gone.text);
        pm_message_clear(&message);
    }
}

/* ---- the process ---- */

static int spawn(struct run *run, int socket_of_worker)
{
    char parent[24], memory[24], cpu[24];
    snprintf(parent, sizeof parent, "%ld", (long)getpid());
    snprintf(memory, sizeof memory, "%llu", (unsigned long long)run->settings->memory_bytes);
    uint64_t cpu_seconds = run->settings->cpu_seconds;
    if (!run->task->request && (!cpu_seconds || cpu_seconds > CHECK_CPU_SECONDS))
        cpu_seconds = CHECK_CPU_SECONDS;
    snprintf(cpu, sizeof cpu, "%llu", (unsigned long long)cpu_seconds);
    char *const arguments[] = {(char *)run->settings->worker_path, parent, memory, cpu, NULL};
    char *const environment[] = {(char *)"LC_ALL=C", NULL};
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none;
    sigemptyset(&none);
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&actions, socket_of_worker, SOCKET_IN_WORKER);
    /* A terminal's Ctrl-C is for the server, which ends its workers in good order. */
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setsigmask(&attributes, &none);
    int failed = posix_spawn(&run->pid, run->settings->worker_path, &actions, &attributes,
                             arguments, environment);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

static pm_status start(struct run *run)
{
    int pair[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair))
        return pm_error_set(&run->err, PM_E_MEMORY, "no socket for a worker: %s",
                            strerror(errno));
    int failed = spawn(run, pair[1]);
    close(pair[1]);
    if (failed) {
        close(pair[0]);
        return pm_error_set(&run->err, PM_E_MEMORY, "cannot start %s: %s",
                            run->settings->worker_path, strerror(failed));
    }
    run->socket = pair[0];
    run->pidfd = pidfd_open(run->pid, 0);
    return PM_OK;
}

static void reason_of_end(int status, char *out, size_t size)
{
    int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (!signal)
        snprintf(out, size, "the worker ended without an answer (exit status %d)",
                 WEXITSTATUS(status));
    else if (signal == SIGXCPU)
        snprintf(out, size, "the worker reached its limit of CPU time (SIGXCPU)");
    else if (signal == SIGSYS)
        snprintf(out, size, "the worker made a system call that its sandbox forbids (SIGSYS)");
    else if (signal == SIGKILL)
        snprintf(out, size,
                 "the worker was killed (SIGKILL): by hand, or because the machine's "
                 "memory or the job's CPU time ran out");
    else
        snprintf(out, size, "the worker crashed (SIG%s)", sigabbrev_np(signal));
}

/* Waits for the process: a while if it ended the conversation, not at all if we did. */
static int reap(struct run *run)
{
    struct pollfd ended = {.fd = run->pidfd, .events = POLLIN};
    int patience_ms = run->err.status ? 0 : END_WAIT_MS;
    if (run->pidfd < 0 || poll(&ended, 1, patience_ms) != 1)
        kill(run->pid, SIGKILL); /* not yet waited for, so the number is still its own */
    int status = 0;
    run->task->started(run->task->context, -1);
    while (waitpid(run->pid, &status, 0) < 0 && errno == EINTR)
        ;
    if (run->pidfd >= 0)
        close(run->pidfd);
    return status;
}

static void conclude(struct run *run, int status)
{
    pm_outcome *out = run->out;
    if (out->answer || out->problem)
        return;
    char reason[256];
    reason_of_end(status, reason, sizeof reason);
    out->problem = run->err.status ? pm_problem_of(&run->err) : pm_problem(500, reason);
}

void pm_run_task(const pm_run_settings *settings, const pm_task *task, pm_outcome *out)
{
    struct run *run = calloc(1, sizeof *run);
    *out = (pm_outcome){0};
    if (!run)
        return;
    run->settings = settings;
    run->task = task;
    run->out = out;
    if (!start(run)) {
        task->started(task->context, run->pidfd);
        if (!send_job(run))
            converse(run);
        close(run->socket);
        pm_building_end_all(settings->building, task->id);
        conclude(run, reap(run));
    } else {
        conclude(run, 0);
    }
    drop_kept(run);
    for (int i = 0; i < PM_MAP_KINDS; i++)
        clear_incoming(run, &run->incoming[i], false);
    pm_request_clear(&run->request);
    free(run);
}

void pm_outcome_clear(pm_outcome *outcome)
{
    for (size_t i = 0; i < outcome->result_count; i++)
        if (!outcome->results[i].stored)
            pm_memory_unmap(outcome->results[i].data, outcome->results[i].size);
    pm_json_free(outcome->answer);
    pm_json_free(outcome->problem);
    *outcome = (pm_outcome){0};
}
