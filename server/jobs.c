#include "jobs.h"

#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/pidfd.h>

#include "problem.h"

/* A job or a ticket that has not ended. */
struct pm_work {
    struct pm_work *next;
    int64_t id; /* of the store's job; negative for a ticket */
    pm_digest bundle;
    char *main_name, *request; /* of a ticket; a job's are in the store */
    bool running, cancelled;
    atomic_bool stop;
    int worker;          /* pidfd, -1 = none */
    pm_json *progress;   /* or NULL */
    pm_json *unrecorded; /* the problem of a job whose end the store did not take */
    bool ready;          /* a ticket's outcome is there */
    bool abandoned;      /* a ticket nobody waits for */
    pm_outcome outcome;
};

struct pm_jobs {
    pm_jobs_options options;
    pm_building *building;
    pthread_t *threads;
    unsigned started;

    pthread_mutex_t lock; /* guards everything below and every work's members, but for `stop` */
    pthread_cond_t wake;
    struct pm_work *jobs, *tickets; /* in order of arrival */
    int64_t next_ticket;
    bool stopping, cancel_all;
    pm_jobs_counts counts;
};

/* ---- lists; called with the lock held ---- */

static void append(struct pm_work **list, struct pm_work *work)
{
    while (*list)
        list = &(*list)->next;
    *list = work;
}

static void take_out(struct pm_work **list, const struct pm_work *work)
{
    while (*list != work)
        list = &(*list)->next;
    *list = work->next;
}

static struct pm_work *find(struct pm_work *list, int64_t id)
{
    while (list && list->id != id)
        list = list->next;
    return list;
}

static struct pm_work *first_waiting(struct pm_work *list)
{
    while (list && (list->running || list->ready || list->unrecorded))
        list = list->next;
    return list;
}

static void clear_work(struct pm_work *work)
{
    free(work->main_name);
    free(work->request);
    pm_json_free(work->progress);
    pm_json_free(work->unrecorded);
    pm_outcome_clear(&work->outcome);
}

static struct pm_work *new_work(int64_t id)
{
    struct pm_work *work = calloc(1, sizeof *work);
    if (!work)
        return NULL;
    work->id = id;
    work->worker = -1;
    atomic_init(&work->stop, false);
    return work;
}

static void free_work(struct pm_work *work)
{
    clear_work(work);
    free(work);
}

static void stop_worker(struct pm_work *work)
{
    atomic_store(&work->stop, true);
    if (work->worker >= 0)
        pidfd_send_signal(work->worker, SIGKILL, NULL, 0);
}

/* ---- what the running task reports ---- */

struct runner {
    pm_jobs *jobs;
    struct pm_work *work;
};

static void on_started(void *context, int worker)
{
    struct runner *runner = context;
    pthread_mutex_lock(&runner->jobs->lock);
    runner->work->worker = worker;
    if (atomic_load(&runner->work->stop))
        stop_worker(runner->work);
    pthread_mutex_unlock(&runner->jobs->lock);
}

static void on_progress(void *context, pm_json *progress)
{
    struct runner *runner = context;
    pthread_mutex_lock(&runner->jobs->lock);
    pm_json *old = runner->work->progress;
    runner->work->progress = progress;
    pthread_mutex_unlock(&runner->jobs->lock);
    pm_json_free(old);
}

static void announce(pm_jobs *jobs)
{
    jobs->options.changed(jobs->options.context);
}

static void report(pm_jobs *jobs, const struct pm_work *work, const char *state)
{
    jobs->options.report(jobs->options.context, work->id, state);
}

static void run_work(pm_jobs *jobs, struct pm_work *work, const char *request,
                     const char *main_name, const pm_digest *bundle)
{
    struct runner runner = {jobs, work};
    const pm_task task = {.id = work->id,
                          .request = request,
                          .bundle = *bundle,
                          .main_name = main_name,
                          .stop = &work->stop,
                          .context = &runner,
                          .started = on_started,
                          .progress = on_progress};
    pm_run_task(&jobs->options.run, &task, &work->outcome);
}

/* ---- a job's end ---- */

/* Members of a request that bear on photons, beside seed and max_events; NULL without memory.
 */
static pm_json *about_photons(const pm_json *request)
{
    static const char *const members[] = {"max_length", "ports",   "direction_resolution",
                                          "partition",  "sensors", "exclude",
                                          "include",    "regions", "medium",
                                          "back_faces"};
    pm_json *json = pm_json_pack("{}");
    bool made = json;
    for (size_t i = 0; i < sizeof members / sizeof *members && made; i++)
        if (pm_json_get(request, members[i]))
            made =
                pm_json_put(json, members[i], pm_json_copy(pm_json_get(request, members[i])));
    if (made)
        return json;
    pm_json_free(json);
    return NULL;
}

/* What makes the map, as a member of a job. */
static pm_json *map_member(const pm_request *request, const char *kind, int64_t count)
{
    static const char *const more[] = {"passes", "gather", "fraction"};
    const pm_json *asked = pm_json_get(request->json, kind);
    pm_json *member = pm_json_pack("{s:I}", "count", (long long)count);
    bool makes =
        request->job.kind == PM_JOB_MAP || !strcmp(kind, pm_map_kind_name(PM_MAP_PRECOMPUTED));
    for (size_t i = 0; i < sizeof more / sizeof *more && makes && member; i++)
        if (pm_json_get(asked, more[i]) &&
            !pm_json_put(member, more[i], pm_json_copy(pm_json_get(asked, more[i])))) {
            pm_json_free(member);
            return NULL;
        }
    return member;
}

/* The request of a map job that makes this one map again from stored batches. */
static char *map_request(const pm_request *request, const char *kind, int64_t count)
{
    pm_json *json = about_photons(request->json);
    pm_json *rest = pm_json_pack("{s:s, s:s, s:I, s:I, s:o}", "kind", "map", "scene",
                                 request->scene, "seed", (long long)request->job.forward.seed,
                                 "max_events", (long long)request->job.forward.max_events, kind,
                                 map_member(request, kind, count));
    bool made = json && rest && pm_json_merge(json, rest);
    char *text = made ? pm_json_text(json) : NULL;
    pm_json_free(rest);
    pm_json_free(json);
    return text;
}

pm_json *pm_map_info(const pm_json *map)
{
    static const char *const members[] = {"key",   "kind",    "family", "scene",
                                          "count", "photons", "paths",  "note"};
    pm_json *info = pm_json_pack("{}");
    bool made = info;
    for (size_t i = 0; i < sizeof members / sizeof *members && made; i++)
        made = pm_json_put(info, members[i], pm_json_copy(pm_json_get(map, members[i])));
    if (made && pm_json_get(map, "passes"))
        made = pm_json_put(info, "passes", pm_json_copy(pm_json_get(map, "passes")));
    if (made)
        return info;
    pm_json_free(info);
    return NULL;
}

struct map_records {
    pm_map_record list[PM_MAP_KINDS];
    pm_json *infos[PM_MAP_KINDS];
    char *requests[PM_MAP_KINDS];
    pm_digest files[PM_MAP_KINDS];
    size_t count;
};

/* The file of a map, which a job of kind map has among its results under the map's kind. */
static const pm_run_result *map_file(const pm_outcome *outcome, const char *kind)
{
    for (size_t i = 0; i < outcome->result_count; i++)
        if (outcome->results[i].stored && !strcmp(outcome->results[i].name, kind))
            return &outcome->results[i];
    return NULL;
}

static bool add_record(struct map_records *records, const pm_request *request,
                       const pm_outcome *outcome, const pm_json *map)
{
    const char *key = pm_json_get_text(map, "key", NULL);
    const char *kind = pm_json_get_text(map, "kind", "");
    if (!key || records->count == PM_MAP_KINDS)
        return true;
    size_t n = records->count++;
    records->requests[n] = map_request(request, kind, pm_json_get_integer(map, "count", 0));
    records->infos[n] = pm_map_info(map);
    records->list[n] = (pm_map_record){key, records->infos[n], records->requests[n], NULL};
    if (!records->requests[n] || !records->infos[n])
        return false;
    const pm_run_result *file = map_file(outcome, kind);
    if (file) {
        records->files[n] = file->digest;
        records->list[n].file = &records->files[n];
    }
    return true;
}

static pm_status finish_done(pm_jobs *jobs, const struct pm_work *work,
                             const char *request_text, pm_error *err)
{
    const pm_outcome *outcome = &work->outcome;
    const pm_json *maps = pm_json_get(outcome->answer, "maps");
    struct map_records records = {.count = 0};
    pm_new_result results[PM_RUN_RESULTS];
    pm_request request;
    pm_status st = pm_request_parse(request_text, strlen(request_text), &request, err);
    if (st)
        return st;
    for (size_t i = 0; i < pm_json_length(maps) && !st; i++)
        if (!add_record(&records, &request, outcome, pm_json_at(maps, i)))
            st = pm_error_set(err, PM_E_MEMORY, "no memory for a map record");
    for (size_t i = 0; i < outcome->result_count; i++) {
        const pm_run_result *from = &outcome->results[i];
        results[i] =
            (pm_new_result){from->name, from->format, from->stored ? &from->digest : NULL,
                            from->data, from->size};
    }
    const pm_job_end end = {.state = "done",
                            .answer = outcome->answer,
                            .results = results,
                            .result_count = outcome->result_count,
                            .maps = records.list,
                            .map_count = records.count};
    if (!st)
        st = pm_store_job_finish(jobs->options.run.store, work->id, &end, err);
    for (size_t i = 0; i < records.count; i++) {
        free(records.requests[i]);
        pm_json_free(records.infos[i]);
    }
    pm_request_clear(&request);
    return st;
}

static pm_status finish_short(pm_jobs *jobs, const struct pm_work *work, const char *state,
                              const pm_json *problem, pm_error *err)
{
    const pm_job_end end = {.state = state, .problem = problem};
    return pm_store_job_finish(jobs->options.run.store, work->id, &end, err);
}

/* Writes the end into the store, whatever it is. If the store does not take an answer, the job
 * has failed for that reason; if it does not take that either, the reason is kept in memory. */
static const char *finish(pm_jobs *jobs, struct pm_work *work, const char *request)
{
    pm_outcome *outcome = &work->outcome;
    pm_error err = PM_ERROR_INIT;
    if (atomic_load(&work->stop) && !outcome->answer) {
        pm_json_free(outcome->problem);
        outcome->problem = NULL;
        (void)!finish_short(jobs, work, "cancelled", NULL, &err);
        return "cancelled";
    }
    if (outcome->answer && !finish_done(jobs, work, request, &err))
        return "done";
    if (outcome->answer)
        outcome->problem = pm_problem_of(&err);
    pm_error again = PM_ERROR_INIT;
    if (finish_short(jobs, work, "failed", outcome->problem, &again)) {
        pthread_mutex_lock(&jobs->lock);
        work->unrecorded = outcome->problem ? outcome->problem : pm_problem_of(&again);
        pthread_mutex_unlock(&jobs->lock);
        outcome->problem = NULL;
    }
    return "failed";
}

/* ---- the threads ---- */

static pm_status read_job(pm_jobs *jobs, const struct pm_work *work, char **request,
                          pm_scene_record *scene, pm_error *err)
{
    pm_json *document = NULL;
    pm_digest id;
    pm_store *store = jobs->options.run.store;
    pm_status st = pm_store_job_get(store, work->id, &document, err);
    if (st)
        return st;
    *request = pm_json_text(pm_json_get(document, "request"));
    if (!*request || !pm_digest_parse(pm_json_get_text(document, "scene", ""), &id))
        st = pm_error_set(err, PM_E_MEMORY, "no memory for a request");
    else
        st = pm_store_scene_get(store, &id, scene, err);
    pm_json_free(document);
    return st;
}

static void count_end(pm_jobs *jobs, const pm_outcome *outcome, const char *state)
{
    jobs->counts.batches_read += outcome->batches_read;
    jobs->counts.batches_kept += outcome->batches_kept;
    if (!strcmp(state, "done"))
        jobs->counts.done++;
    else if (!strcmp(state, "failed"))
        jobs->counts.failed++;
    else if (!strcmp(state, "cancelled"))
        jobs->counts.cancelled++;
}

/* A job that ran when the server was told to stop is the next server's. */
static bool goes_back(pm_jobs *jobs, const struct pm_work *work)
{
    pthread_mutex_lock(&jobs->lock);
    bool back = jobs->stopping && !jobs->cancel_all && !work->cancelled &&
                !work->outcome.answer && atomic_load(&work->stop);
    pthread_mutex_unlock(&jobs->lock);
    return back;
}

static const char *run_job(pm_jobs *jobs, struct pm_work *work)
{
    char *request = NULL;
    pm_scene_record scene = {0};
    pm_error err = PM_ERROR_INIT;
    pm_status st = read_job(jobs, work, &request, &scene, &err);
    if (!st)
        st = pm_store_job_start(jobs->options.run.store, work->id, &err);
    announce(jobs);
    report(jobs, work, "running");
    if (!st)
        run_work(jobs, work, request, scene.main_name, &scene.bundle);
    else
        work->outcome.problem = pm_problem_of(&err);
    const char *state = "queued";
    pm_error requeue = PM_ERROR_INIT;
    if (!goes_back(jobs, work))
        state = finish(jobs, work, request);
    else if (pm_store_job_requeue(jobs->options.run.store, work->id, &requeue))
        state = "running"; /* and so found by the next server */
    free(request);
    pm_scene_record_clear(&scene);
    return state;
}

static void end_job(pm_jobs *jobs, struct pm_work *work, const char *state)
{
    report(jobs, work, state);
    pthread_mutex_lock(&jobs->lock);
    count_end(jobs, &work->outcome, state);
    pm_outcome_clear(&work->outcome);
    work->running = false;
    bool forget = !work->unrecorded;
    if (forget)
        take_out(&jobs->jobs, work);
    pthread_mutex_unlock(&jobs->lock);
    if (forget)
        free_work(work);
    announce(jobs);
}

static void run_ticket(pm_jobs *jobs, struct pm_work *work)
{
    run_work(jobs, work, work->request, work->main_name, &work->bundle);
    pthread_mutex_lock(&jobs->lock);
    work->running = false;
    work->ready = true;
    jobs->counts.batches_read += work->outcome.batches_read;
    bool abandoned = work->abandoned;
    if (abandoned)
        take_out(&jobs->tickets, work);
    pthread_mutex_unlock(&jobs->lock);
    if (abandoned)
        free_work(work);
    announce(jobs);
}

/* Waits for something to do in a list. NULL when the server stops. */
static struct pm_work *next_work(pm_jobs *jobs, struct pm_work **list)
{
    pthread_mutex_lock(&jobs->lock);
    struct pm_work *work = NULL;
    while (!jobs->stopping && !(work = first_waiting(*list)))
        pthread_cond_wait(&jobs->wake, &jobs->lock);
    if (jobs->stopping)
        work = NULL;
    if (work)
        work->running = true;
    pthread_mutex_unlock(&jobs->lock);
    return work;
}

static void *job_thread(void *context)
{
    pm_jobs *jobs = context;
    for (struct pm_work *work; (work = next_work(jobs, &jobs->jobs));)
        end_job(jobs, work, run_job(jobs, work));
    return NULL;
}

/* Tickets have a thread of their own: a scene is checked while a long job runs. */
static void *ticket_thread(void *context)
{
    pm_jobs *jobs = context;
    for (struct pm_work *work; (work = next_work(jobs, &jobs->tickets));)
        run_ticket(jobs, work);
    return NULL;
}

/* ---- starting and stopping ---- */

static pm_status take_up(pm_jobs *jobs, pm_error *err)
{
    int64_t *ids = NULL;
    size_t count = 0;
    pm_status st = pm_store_job_recover(jobs->options.run.store, &ids, &count, err);
    for (size_t i = 0; i < count && !st; i++) {
        struct pm_work *work = new_work(ids[i]);
        if (work)
            append(&jobs->jobs, work);
        else
            st = pm_error_set(err, PM_E_MEMORY, "no memory for the queue");
    }
    free(ids);
    return st;
}

static pm_status start_threads(pm_jobs *jobs, pm_error *err)
{
    unsigned count = jobs->options.workers + 1;
    jobs->threads = calloc(count, sizeof *jobs->threads);
    if (!jobs->threads)
        return pm_error_set(err, PM_E_MEMORY, "no memory for threads");
    for (; jobs->started < count; jobs->started++)
        if (pthread_create(&jobs->threads[jobs->started], NULL,
                           jobs->started ? job_thread : ticket_thread, jobs))
            return pm_error_set(err, PM_E_MEMORY, "cannot start %u threads", count);
    return PM_OK;
}

pm_status pm_jobs_new(const pm_jobs_options *options, pm_jobs **out, pm_error *err)
{
    pm_jobs *jobs = calloc(1, sizeof *jobs);
    if (!jobs)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the queue");
    jobs->options = *options;
    jobs->next_ticket = -1;
    pthread_mutex_init(&jobs->lock, NULL);
    pthread_cond_init(&jobs->wake, NULL);
    jobs->building = jobs->options.run.building = pm_building_new();
    pm_status st = jobs->building ? take_up(jobs, err)
                                  : pm_error_set(err, PM_E_MEMORY, "no memory for the queue");
    if (!st)
        st = start_threads(jobs, err);
    if (st) {
        pm_jobs_stop(jobs, false);
        pm_jobs_free(jobs);
        return st;
    }
    *out = jobs;
    return PM_OK;
}

/* Called with the lock held. */
static void cancel_waiting(pm_jobs *jobs)
{
    for (struct pm_work *work = jobs->jobs, *next; work; work = next) {
        next = work->next;
        if (work->running || work->unrecorded)
            continue;
        (void)!finish_short(jobs, work, "cancelled", NULL, NULL);
        take_out(&jobs->jobs, work);
        free_work(work);
    }
}

void pm_jobs_stop(pm_jobs *jobs, bool cancel)
{
    pthread_mutex_lock(&jobs->lock);
    jobs->stopping = true;
    jobs->cancel_all = cancel;
    for (struct pm_work *work = jobs->jobs; work; work = work->next)
        stop_worker(work);
    for (struct pm_work *work = jobs->tickets; work; work = work->next)
        stop_worker(work);
    if (cancel)
        cancel_waiting(jobs);
    pthread_cond_broadcast(&jobs->wake);
    pthread_mutex_unlock(&jobs->lock);
    if (jobs->building)
        pm_building_wake(jobs->building);
    for (unsigned i = 0; i < jobs->started; i++)
        pthread_join(jobs->threads[i], NULL);
    jobs->started = 0;
}

static void free_list(struct pm_work *list)
{
    while (list) {
        struct pm_work *next = list->next;
        free_work(list);
        list = next;
    }
}

void pm_jobs_free(pm_jobs *jobs)
{
    if (!jobs)
        return;
    free_list(jobs->jobs);
    free_list(jobs->tickets);
    pm_building_free(jobs->building);
    pthread_cond_destroy(&jobs->wake);
    pthread_mutex_destroy(&jobs->lock);
    free(jobs->threads);
    free(jobs);
}

pm_jobs_counts pm_jobs_count(pm_jobs *jobs)
{
    pthread_mutex_lock(&jobs->lock);
    pm_jobs_counts counts = jobs->counts;
    for (const struct pm_work *work = jobs->jobs; work; work = work->next) {
        counts.running += work->running;
        counts.queued += !work->running && !work->unrecorded;
    }
    pthread_mutex_unlock(&jobs->lock);
    counts.waiting = pm_building_waiting(jobs->building);
    return counts;
}

/* ---- what users ask ---- */

/* Called with the lock held, so that two submissions with one key make one job. */
static pm_status submit(pm_jobs *jobs, const pm_new_job *job, int64_t *id, bool *existed,
                        pm_error *err)
{
    pm_store *store = jobs->options.run.store;
    char *request = NULL;
    pm_status st = job->idempotency_key
                       ? pm_store_job_by_key(store, job->idempotency_key, id, &request, err)
                       : PM_E_MISSING;
    *existed = !st;
    if (!st && strcmp(request, job->request) != 0)
        st = pm_error_set(err, PM_E_MISMATCH,
                          "this Idempotency-Key was used for another request");
    free(request);
    if (st != PM_E_MISSING)
        return st;
    struct pm_work *work = new_work(0);
    if (!work)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a job");
    st = pm_store_job_add(store, job, &work->id, err);
    if (st) {
        free_work(work);
        return st;
    }
    *id = work->id;
    append(&jobs->jobs, work);
    pthread_cond_broadcast(&jobs->wake);
    return PM_OK;
}

pm_status pm_jobs_submit(pm_jobs *jobs, const pm_new_job *job, int64_t *id, bool *existed,
                         pm_error *err)
{
    pthread_mutex_lock(&jobs->lock);
    pm_status st = submit(jobs, job, id, existed, err);
    pthread_mutex_unlock(&jobs->lock);
    return st;
}

/* What memory knows better than the store. Called with the lock held. */
static bool add_live(const struct pm_work *work, pm_json *document)
{
    if (work->unrecorded)
        return pm_json_put(document, "state", pm_json_pack("s", "failed")) &&
               pm_json_put(document, "problem", pm_json_copy(work->unrecorded));
    return !work->progress || pm_json_put(document, "progress", pm_json_copy(work->progress));
}

pm_status pm_jobs_get(pm_jobs *jobs, int64_t id, pm_json **out, pm_error *err)
{
    pm_json *document = NULL;
    pm_status st = pm_store_job_get(jobs->options.run.store, id, &document, err);
    if (st)
        return st;
    pthread_mutex_lock(&jobs->lock);
    const struct pm_work *work = find(jobs->jobs, id);
    bool made = !work || add_live(work, document);
    pthread_mutex_unlock(&jobs->lock);
    if (!made) {
        pm_json_free(document);
        return pm_error_set(err, PM_E_MEMORY, "no memory for a job");
    }
    *out = document;
    return PM_OK;
}

/* Called with the lock held. */
static pm_status cancel(pm_jobs *jobs, struct pm_work *work, pm_error *err)
{
    if (work->running) {
        work->cancelled = true;
        stop_worker(work);
        return PM_OK;
    }
    pm_status st = finish_short(jobs, work, "cancelled", NULL, err);
    if (!st) {
        take_out(&jobs->jobs, work);
        free_work(work);
        jobs->counts.cancelled++;
    }
    return st;
}

pm_status pm_jobs_cancel(pm_jobs *jobs, int64_t id, pm_error *err)
{
    pthread_mutex_lock(&jobs->lock);
    struct pm_work *work = find(jobs->jobs, id);
    bool active = work && !work->unrecorded;
    pm_status st = active ? cancel(jobs, work, err) : PM_OK;
    pthread_mutex_unlock(&jobs->lock);
    if (active) {
        pm_building_wake(jobs->building);
        announce(jobs);
        return st;
    }
    pm_json *document = NULL;
    st = pm_store_job_get(jobs->options.run.store, id, &document, err);
    pm_json_free(document);
    return st ? st : pm_error_set(err, PM_E_MISMATCH, "the job has ended already");
}

/* ---- tickets ---- */

pm_ticket *pm_jobs_ask(pm_jobs *jobs, const char *request, const pm_digest *bundle,
                       const char *main_name)
{
    struct pm_work *work = new_work(0);
    if (!work)
        return NULL;
    work->bundle = *bundle;
    work->main_name = strdup(main_name);
    work->request = request ? strdup(request) : NULL;
    if (!work->main_name || (request && !work->request)) {
        free_work(work);
        return NULL;
    }
    pthread_mutex_lock(&jobs->lock);
    work->id = jobs->next_ticket--;
    append(&jobs->tickets, work);
    pthread_cond_broadcast(&jobs->wake);
    pthread_mutex_unlock(&jobs->lock);
    return work;
}

bool pm_ticket_ready(pm_jobs *jobs, pm_ticket *ticket)
{
    pthread_mutex_lock(&jobs->lock);
    bool ready = ticket->ready;
    pthread_mutex_unlock(&jobs->lock);
    return ready;
}

const pm_outcome *pm_ticket_outcome(const pm_ticket *ticket)
{
    return &ticket->outcome;
}

void pm_ticket_free(pm_jobs *jobs, pm_ticket *work)
{
    if (!work)
        return;
    pthread_mutex_lock(&jobs->lock);
    bool running = work->running;
    if (running)
        work->abandoned = true;
    else
        take_out(&jobs->tickets, work);
    pthread_mutex_unlock(&jobs->lock);
    if (!running)
        free_work(work);
}
