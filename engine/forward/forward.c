#include "forward/forward.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "forward/forward_internal.h"
#include "forward/path.h"
#include "world/light.h"

enum {
    CHUNK_PATHS = 2048,
    CHUNKS = PM_BATCH_PATHS / CHUNK_PATHS,
    PREPASS_CHUNKS = PM_FORWARD_PREPASS_PATHS / CHUNK_PATHS,
    /* A replicate's Sobol sequence has 2^32 points. */
    MAX_BATCHES = PM_REPLICATES << 16,
};

/* A piece of a run: its photons lie in the buffers of the thread that traced it. */
struct chunk {
    unsigned thread;
    size_t start[PM_MAP_KINDS], count[PM_MAP_KINDS];
    pm_rgb emitted, absorbed, escaped;
};

/* What the threads of a run write into. */
struct pm_recorders {
    unsigned threads;
    struct pm_recorder of[]; /* [threads] */
};

/* One run of the pool. Chunk c owns paths [c CHUNK_PATHS, (c + 1) CHUNK_PATHS), chunks[c] and
 * its part of `ends`; thread t owns recorders->of[t]. */
struct run {
    struct pm_tracer tracer;
    uint64_t first_path;
    uint32_t first_sobol;
    struct pm_recorders *recorders;
    struct chunk chunks[CHUNKS];
    uint32_t *ends[PM_MAP_KINDS]; /* NULL: not wanted */
    bool (*cancelled)(void *);
    void *context;
    atomic_bool stop;   /* cancelled or out of memory: no more chunks */
    bool was_cancelled; /* written by thread 0 */
};

/* ---- chunks ---- */

static void start_chunk(struct chunk *chunk, struct pm_recorder *recorder, unsigned thread)
{
    chunk->thread = thread;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        chunk->start[kind] = recorder->buffer[kind].count;
    recorder->emitted = recorder->absorbed = recorder->escaped = (pm_rgb){0, 0, 0};
}

static void finish_chunk(struct chunk *chunk, const struct pm_recorder *recorder)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        chunk->count[kind] = recorder->buffer[kind].count - chunk->start[kind];
    chunk->emitted = recorder->emitted;
    chunk->absorbed = recorder->absorbed;
    chunk->escaped = recorder->escaped;
}

/* Only the caller's own thread may ask whether to stop; it works through chunks as well. */
static bool is_stopped(struct run *run, unsigned thread)
{
    if (thread == 0 && run->cancelled && !run->was_cancelled && run->cancelled(run->context)) {
        run->was_cancelled = true;
        atomic_store(&run->stop, true);
    }
    return atomic_load(&run->stop);
}

static void trace_chunk(void *context, size_t c, unsigned thread)
{
    struct run *run = context;
    if (is_stopped(run, thread))
        return;
    struct pm_recorder recorder = run->recorders->of[thread]; /* apart from other threads' */
    struct chunk *chunk = &run->chunks[c];
    start_chunk(chunk, &recorder, thread);
    for (uint32_t i = (uint32_t)c * CHUNK_PATHS, last = i + CHUNK_PATHS; i < last; i++) {
        pm_path_trace(&run->tracer, run->first_path + i, run->first_sobol + i, &recorder);
        for (int kind = 0; kind < PM_MAP_KINDS; kind++)
            if (run->ends[kind])
                run->ends[kind][i] =
                    (uint32_t)(recorder.buffer[kind].count - chunk->start[kind]);
    }
    finish_chunk(chunk, &recorder);
    if (recorder.out_of_memory)
        atomic_store(&run->stop, true);
    run->recorders->of[thread] = recorder;
}

/* ---- runs ---- */

/* In media roulette ends a path where there is any absorption. Where there is none, a share of
 * 1 / sqrt(pi 2^17), 1 in 600, of what enters a medium without an end is lost. */
static void set_bounds(struct pm_tracer *tracer, uint32_t max_events)
{
    bool few = max_events < pm_forward_defaults().max_events;
    tracer->max_events = max_events;
    tracer->max_collisions = few ? max_events : 1U << 17;
    tracer->max_scatterings = few ? max_events : max_events + tracer->max_collisions;
}

/* Paths of caustic maps are aimed. */
static struct pm_tracer tracer_of(const pm_forward *forward, bool prepass, bool aimed,
                                  unsigned replicate)
{
    static const pm_rng_purpose purposes[2][2] = {{PM_RNG_PATH, PM_RNG_AIMED},
                                                  {PM_RNG_PREPASS, PM_RNG_AIMED_PREPASS}};
    struct pm_tracer tracer = {.world = forward->world,
                               .choice = &forward->choice,
                               .ports = forward->ports,
                               .openings = forward->openings,
                               .lamps = forward->lamps,
                               .seed = forward->seed,
                               .purpose = purposes[prepass][aimed],
                               .aim = aimed ? forward->aim : NULL};
    set_bounds(&tracer, forward->max_events);
    pm_tracer_set_replicate(&tracer, replicate);
    return tracer;
}

static void recorders_free(struct pm_recorders *r)
{
    for (unsigned t = 0; r && t < r->threads; t++)
        for (int kind = 0; kind < PM_MAP_KINDS; kind++)
            free(r->of[t].buffer[kind].photons);
    free(r);
}

/* Those of the last batch, with their room for photons, or new ones. */
static struct pm_recorders *recorders_get(const pm_forward *forward, unsigned threads)
{
    struct pm_recorders *r = atomic_exchange(&forward->counters->spare, NULL);
    if (r && r->threads == threads)
        return r;
    recorders_free(r);
    r = calloc(1, sizeof *r + threads * sizeof *r->of);
    if (r)
        r->threads = threads;
    return r;
}

static void recorders_put(const pm_forward *forward, struct pm_recorders *r)
{
    if (r)
        recorders_free(atomic_exchange(&forward->counters->spare, r));
}

static struct pm_recorders *recorders_start(const pm_forward *forward, unsigned threads,
                                            unsigned kinds, unsigned replicate)
{
    struct pm_recorders *r = recorders_get(forward, threads);
    for (unsigned t = 0; r && t < threads; t++) {
        struct pm_recorder old = r->of[t], *fresh = &r->of[t];
        *fresh = (struct pm_recorder){.kinds = kinds,
                                      .ignored = kinds ? ~kinds : 0,
                                      .replicate = replicate,
                                      .flux_scale = forward->flux_scale};
        memcpy(fresh->probability, forward->probability, sizeof forward->probability);
        for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
            fresh->buffer[kind] = old.buffer[kind];
            fresh->buffer[kind].count = 0;
        }
    }
    return r;
}

/* Traces the chunks, then sums up what the threads counted. */
static pm_status run_chunks(const pm_forward *forward, struct run *run, size_t chunks,
                            pm_pool *pool, pm_error *err)
{
    pm_pool_run(pool, chunks, trace_chunk, run);
    bool out_of_memory = false;
    for (unsigned t = 0; t < pm_pool_threads(pool); t++) {
        out_of_memory |= run->recorders->of[t].out_of_memory;
        atomic_fetch_add(&forward->counters->nonfinite, run->recorders->of[t].nonfinite);
        atomic_fetch_add(&forward->counters->rays, run->recorders->of[t].rays);
    }
    if (out_of_memory)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the photons of a batch");
    if (run->was_cancelled)
        return pm_error_set(err, PM_E_CANCELLED, "cancelled while tracing photons");
    return PM_OK;
}

/* Caustic photons have paths of their own where these can be aimed. */
static unsigned kinds_of_run(const pm_forward *forward, bool aimed)
{
    unsigned all = (1U << PM_MAP_KINDS) - 1, caustic = 1U << PM_MAP_CAUSTIC;
    if (!forward->aim)
        return aimed ? 0 : all;
    return aimed ? caustic : all & ~caustic;
}

/* ---- the pre-run ---- */

/* At most PM_FORWARD_PHOTONS_A_PATH photons a path on average, in steps that a 32-bit draw can
 * hit. */
static void set_probability(pm_forward *forward, int kind, uint64_t deposits)
{
    double mean = (double)deposits / PM_FORWARD_PREPASS_PATHS;
    double p = mean > PM_FORWARD_PHOTONS_A_PATH ? PM_FORWARD_PHOTONS_A_PATH / mean : 1;
    forward->probability[kind] = floor(p * 0x1p32 + 0.5) * 0x1p-32;
    forward->rate[kind] = mean * forward->probability[kind];
}

static pm_status run_prepass(pm_forward *forward, bool aimed, pm_pool *pool, pm_error *err)
{
    unsigned threads = pm_pool_threads(pool), kinds = kinds_of_run(forward, aimed);
    struct run run = {.tracer = tracer_of(forward, true, aimed, 0),
                      .recorders = recorders_start(forward, threads, 0, 0)};
    if (!run.recorders)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the forward pass");
    pm_status st = run_chunks(forward, &run, PREPASS_CHUNKS, pool, err);
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        uint64_t deposits = 0, stretches = 0;
        if (!(kinds & (1U << kind)))
            continue;
        for (unsigned t = 0; t < threads; t++) {
            deposits += run.recorders->of[t].deposits[kind];
            stretches += run.recorders->of[t].rays;
        }
        set_probability(forward, kind, deposits);
        forward->stretches[kind] = (double)stretches / PM_FORWARD_PREPASS_PATHS;
    }
    for (size_t c = 0; c < PREPASS_CHUNKS && !aimed; c++)
        forward->emitted =
            pm_rgb_madd(forward->emitted, 1. / PM_FORWARD_PREPASS_PATHS, run.chunks[c].emitted);
    recorders_put(forward, run.recorders);
    return st;
}

/* Named ports, or openings that are found. */
static pm_status open_ports(pm_forward *forward, const pm_forward_options *options,
                            pm_error *err)
{
    const pm_selection *chosen = forward->choice.ports;
    const pm_ports_options ports = {
        {&chosen[0], &chosen[1]}, options->direction_resolution, options->partition};
    if (chosen[0].any || chosen[1].any)
        return pm_ports_new(forward->world, &ports, &forward->ports, err);
    return pm_openings_find(forward->world, &forward->openings, err);
}

static pm_status aim_lamps(pm_forward *forward, pm_error *err)
{
    pm_status st = pm_lamps_find(forward->world, forward->choice.ports, &forward->lamps, err);
    if (st)
        return st;
    if (forward->ports)
        pm_ports_aim_lamps(forward->ports, forward->lamps);
    if (forward->openings)
        pm_openings_aim_lamps(forward->openings, forward->lamps);
    const char *sky = forward->openings ? pm_openings_note(forward->openings) : "";
    const char *lamps = forward->lamps ? pm_lamps_note(forward->lamps) : "";
    snprintf(forward->note, sizeof forward->note, "%s%s%s", sky, *sky && *lamps ? "; " : "",
             lamps);
    return PM_OK;
}

static pm_status aim_caustics(pm_forward *forward, pm_error *err)
{
    bool ports = forward->ports || forward->openings;
    const pm_targets *openings = forward->lamps ? pm_lamps_openings(forward->lamps) : NULL;
    return pm_aim_new(forward->world, ports, openings, &forward->aim, err);
}

pm_status pm_forward_new(const pm_world *world, const pm_forward_options *options,
                         pm_pool *pool, pm_forward **out, pm_error *err)
{
    pm_forward *forward = calloc(1, sizeof *forward);
    struct pm_forward_counters *counters = calloc(1, sizeof *counters);
    if (!forward || !counters) {
        free(forward);
        free(counters);
        return pm_error_set(err, PM_E_MEMORY, "no memory for the forward pass");
    }
    forward->world = world;
    forward->seed = options->seed;
    forward->max_events = options->max_events;
    forward->counters = counters;
    double power = pm_rgb_max(pm_light_total_power(world));
    forward->flux_scale = power > 0 ? power : 1;
    pm_status st = pm_choice_make(world, options, &forward->choice, err);
    if (!st)
        st = open_ports(forward, options, err);
    if (!st)
        st = aim_lamps(forward, err);
    if (!st)
        st = aim_caustics(forward, err);
    if (!st)
        st = run_prepass(forward, false, pool, err);
    if (!st && forward->aim)
        st = run_prepass(forward, true, pool, err);
    if (st) {
        pm_forward_free(forward);
        return st;
    }
    *out = forward;
    return PM_OK;
}

void pm_forward_free(pm_forward *forward)
{
    if (!forward)
        return;
    pm_ports_free(forward->ports);
    pm_openings_free(forward->openings);
    pm_lamps_free(forward->lamps);
    pm_choice_clear(&forward->choice);
    pm_aim_free(forward->aim);
    if (forward->counters)
        recorders_free(forward->counters->spare);
    free(forward->counters);
    free(forward);
}

/* ---- batches ---- */

static bool allocate_ends(struct run *run, unsigned kinds)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        if (!(kinds & (1U << kind)))
            continue;
        run->ends[kind] = malloc(PM_BATCH_PATHS * sizeof *run->ends[kind]);
        if (!run->ends[kind])
            return false;
    }
    return true;
}

/* Joins one kind's photons in chunk order; `ends` become counts from the batch's start. */
static bool join(struct run *run, int kind, pm_batch *out)
{
    size_t total = 0;
    for (size_t c = 0; c < CHUNKS; c++)
        total += run->chunks[c].count[kind];
    out->photons = total ? malloc(total * sizeof *out->photons) : NULL;
    if (total && !out->photons)
        return false;
    for (size_t c = 0; c < CHUNKS; c++) {
        const struct chunk *chunk = &run->chunks[c];
        const struct pm_photon_buffer *buffer = &run->recorders->of[chunk->thread].buffer[kind];
        if (chunk->count[kind])
            memcpy(out->photons + out->count, buffer->photons + chunk->start[kind],
                   chunk->count[kind] * sizeof *out->photons);
        for (size_t i = c * CHUNK_PATHS; i < (c + 1) * CHUNK_PATHS; i++)
            run->ends[kind][i] += (uint32_t)out->count;
        out->count += chunk->count[kind];
        out->emitted = pm_rgb_add(out->emitted, chunk->emitted);
        out->absorbed = pm_rgb_add(out->absorbed, chunk->absorbed);
        out->escaped = pm_rgb_add(out->escaped, chunk->escaped);
    }
    out->ends = run->ends[kind];
    run->ends[kind] = NULL;
    return true;
}

static pm_status join_all(struct run *run, uint64_t index, unsigned kinds,
                          pm_batch out[PM_MAP_KINDS], pm_error *err)
{
    pm_batch batches[PM_MAP_KINDS] = {0};
    bool complete = true;
    for (int kind = 0; kind < PM_MAP_KINDS && complete; kind++) {
        batches[kind].kind = (pm_map_kind)kind;
        batches[kind].index = index;
        batches[kind].paths = PM_BATCH_PATHS;
        if (kinds & (1U << kind))
            complete = join(run, kind, &batches[kind]);
    }
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        if (!complete)
            pm_batch_clear(&batches[kind]);
        else if (kinds & (1U << kind))
            out[kind] = batches[kind];
    }
    return complete ? PM_OK
                    : pm_error_set(err, PM_E_MEMORY, "no memory for a batch of photons");
}

/* The kinds that share their paths. */
struct request {
    uint64_t index;
    unsigned kinds;
    bool aimed;
    bool (*cancelled)(void *);
    void *context;
};

static pm_status trace_batch(const pm_forward *forward, const struct request *request,
                             pm_pool *pool, pm_batch out[PM_MAP_KINDS], pm_error *err)
{
    uint64_t index = request->index;
    unsigned threads = pm_pool_threads(pool), replicate = index % PM_REPLICATES;
    struct run run = {
        .tracer = tracer_of(forward, false, request->aimed, replicate),
        .first_path = index * PM_BATCH_PATHS,
        .first_sobol = (uint32_t)(index / PM_REPLICATES * PM_BATCH_PATHS),
        .recorders = recorders_start(forward, threads, request->kinds, replicate),
        .cancelled = request->cancelled,
        .context = request->context,
    };
    pm_status st = PM_OK;
    if (!run.recorders || !allocate_ends(&run, request->kinds))
        st = pm_error_set(err, PM_E_MEMORY, "no memory for a batch of photons");
    if (!st)
        st = run_chunks(forward, &run, CHUNKS, pool, err);
    if (!st)
        st = join_all(&run, index, request->kinds, out, err);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        free(run.ends[kind]);
    recorders_put(forward, run.recorders);
    return st;
}

pm_status pm_forward_batch(const pm_forward *forward, uint64_t index, unsigned kinds,
                           pm_pool *pool, bool (*cancelled)(void *), void *context,
                           pm_batch out[PM_MAP_KINDS], pm_error *err)
{
    if (index >= MAX_BATCHES)
        return pm_error_set(err, PM_E_RANGE, "batch %llu; a family has at most %d",
                            (unsigned long long)index, MAX_BATCHES);
    pm_batch traced[PM_MAP_KINDS] = {0};
    pm_status st = PM_OK;
    for (int aimed = 0; aimed < 2 && !st; aimed++) {
        struct request request = {index, kinds & kinds_of_run(forward, aimed), aimed, cancelled,
                                  context};
        if (request.kinds)
            st = trace_batch(forward, &request, pool, traced, err);
    }
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        if (st)
            pm_batch_clear(&traced[kind]);
        else if (kinds & (1U << kind))
            out[kind] = traced[kind];
    }
    return st;
}

void pm_batch_truncate(pm_batch *batch, uint32_t paths)
{
    assert(batch->ends || paths >= batch->paths);
    if (paths >= batch->paths)
        return;
    batch->count = paths ? batch->ends[paths - 1] : 0;
    batch->paths = paths;
    batch->emitted = batch->absorbed = batch->escaped = (pm_rgb){0, 0, 0};
}

/* ---- answers ---- */

double pm_forward_rate(const pm_forward *forward, pm_map_kind kind)
{
    return forward->rate[kind];
}

double pm_forward_stretches(const pm_forward *forward, pm_map_kind kind)
{
    return forward->stretches[kind];
}

double pm_forward_flux_scale(const pm_forward *forward)
{
    return forward->flux_scale;
}

const char *pm_forward_note(const pm_forward *forward)
{
    const pm_selection *chosen = forward->choice.ports;
    if ((chosen[0].any || chosen[1].any) && !forward->ports && !forward->lamps)
        return "no source is distant, so the ports have no effect";
    if (forward->ports && pm_rgb_is_black(forward->emitted))
        return "no light comes in through the ports; are their normals right?";
    return forward->note;
}

pm_rgb pm_forward_emitted(const pm_forward *forward)
{
    return forward->ports ? forward->emitted : pm_light_total_power(forward->world);
}

double pm_forward_storage_probability(const pm_forward *forward, pm_map_kind kind)
{
    return forward->probability[kind];
}

uint64_t pm_forward_rays(const pm_forward *forward)
{
    return atomic_load(&forward->counters->rays);
}

uint64_t pm_forward_nonfinite(const pm_forward *forward)
{
    return atomic_load(&forward->counters->nonfinite);
}
