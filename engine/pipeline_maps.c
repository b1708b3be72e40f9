#include "pipeline_internal.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A map of a wanted number of photons that grows batch by batch; or a sequence of them. Pass
 * j + 1 starts with the first batch that pass j did not touch, so that no two share a path, and
 * a longer sequence starts with the passes of a shorter one. */
struct growing {
    bool active; /* still short of its number */
    bool begun;
    uint64_t wanted; /* of a pass */
    uint32_t passes; /* of a sequence, or 0 */
    pm_digest family;
    double kept;         /* share of the stored photons that this map takes, see share_kept */
    pm_photon_list list; /* of this pass, as what follows */
    uint64_t first_path, paths;
    bool gave_up;
};

/* Paths after which a map that does not fill is given up: a fixed start, and a thousandth of a
 * photon a path beyond it; fewer where paths are long, so that the work is bounded, too. The
 * user is told what was reached. */
static uint64_t path_limit(const pm_run *run, pm_map_kind kind, uint64_t photons)
{
    enum { LONG_PATH = 8 };
    double stretches = pm_forward_stretches(run->forward, kind);
    double share = stretches > LONG_PATH ? LONG_PATH / stretches : 1;
    return (uint64_t)(share * (0x1p22 + 1000 * (double)photons));
}

/* A map is cut where a path ends, so a small one takes few photons of each of many paths: then
 * it misses its number by few, and its photons are the less alike. Half a batch has them. */
static double share_kept(const pm_run *run, pm_map_kind kind, uint64_t wanted)
{
    double rate = pm_forward_rate(run->forward, kind),
           want = 2. * (double)wanted / PM_BATCH_PATHS;
    return rate > want ? floor(want / rate * 0x1p32 + 1) * 0x1p-32 : 1;
}

void pm_run_thin_header(const pm_run *run, pm_map_header *header)
{
    uint64_t wanted = run->answer->plan.pass[header->kind].count;
    double share = wanted ? share_kept(run, header->kind, wanted) : 1;
    header->flux_scale /= share;
    header->storage_probability *= share;
}

static void begin(pm_run *run, pm_map_kind kind, struct growing *map)
{
    map->family = pm_forward_family(run->forward, kind);
    map->kept = share_kept(run, kind, map->wanted);
    map->begun = true;
    if (run->hooks->begin)
        run->hooks->begin(run->hooks->context, &map->family, kind);
}

static void end(pm_run *run, struct growing *map)
{
    if (map->begun && run->hooks->end)
        run->hooks->end(run->hooks->context, &map->family);
    map->begun = false;
}

/* A stored batch, if the store has it whole and sound; a damaged one is traced again. */
static bool fetch_batch(pm_run *run, const pm_digest *family, pm_map_kind kind, uint64_t index,
                        pm_batch *out)
{
    const pm_job_hooks *hooks = run->hooks;
    const void *data = NULL;
    size_t size = 0;
    if (!hooks->fetch || !hooks->fetch(hooks->context, family, index, &data, &size))
        return false;
    pm_batch batch = {0};
    bool sound = pm_batch_read(data, size, &batch, NULL) == PM_OK;
    if (hooks->release)
        hooks->release(hooks->context, data, size);
    if (sound && batch.kind == kind && batch.index == index && batch.paths == PM_BATCH_PATHS &&
        batch.ends) {
        *out = batch;
        return true;
    }
    pm_batch_clear(&batch);
    return false;
}

static pm_status keep_batch(pm_run *run, const pm_digest *family, const pm_batch *batch)
{
    if (!run->hooks->keep)
        return PM_OK;
    pm_bytes bytes = {0};
    pm_status st = pm_batch_write(batch, &bytes, run->err);
    if (!st)
        run->hooks->keep(run->hooks->context, family, batch->kind, batch->index, &bytes);
    pm_bytes_clear(&bytes);
    return st;
}

/* Each path of a batch carries the whole power, so what is told is the mean over the paths [W].
 */
static void add_balance(pm_run *run, const pm_batch *batch)
{
    pm_answer *answer = run->answer;
    double area = answer->world.scale * answer->world.scale;
    double before = (double)run->balance_paths;
    double after = before + batch->paths;
    run->balance_paths += batch->paths;
    double kept = before / after, share = area / after;
    answer->emitted = pm_rgb_madd(pm_rgb_scale(answer->emitted, kept), share, batch->emitted);
    answer->absorbed =
        pm_rgb_madd(pm_rgb_scale(answer->absorbed, kept), share, batch->absorbed);
    answer->escaped = pm_rgb_madd(pm_rgb_scale(answer->escaped, kept), share, batch->escaped);
}

/* The greatest number of paths that have no more than `missing` photons. To stop before the
 * path that has one too many, but not before the first, biases nothing as long as no path has
 * more than all that are wanted (Glynn and Heidelberger, "Bias properties of budget constrained
 * simulations", Operations Research 38, 1990); to stop with it would. */
static uint32_t most_paths(const pm_batch *batch, uint64_t missing)
{
    uint32_t low = 0, high = batch->paths;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (batch->ends[middle] > missing)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Takes what the map still needs of a batch, which ends here. */
static pm_status settle(pm_run *run, pm_map_kind kind, struct growing *map, pm_batch *batch)
{
    uint64_t missing = map->wanted - map->list.count;
    pm_batch_thin(batch, run->job->forward.seed, map->kept);
    if (!map->paths)
        map->first_path = batch->index * PM_BATCH_PATHS;
    if (batch->count > missing) {
        uint32_t paths = most_paths(batch, missing);
        pm_batch_truncate(batch, map->paths || paths ? paths : 1);
        map->active = false;
    }
    pm_status st = pm_photon_list_append(&map->list, batch->photons, batch->count, run->err);
    map->paths += batch->paths;
    pm_batch_clear(batch);
    if (map->active && map->paths >= path_limit(run, kind, map->list.count)) {
        map->active = false;
        map->gave_up = map->list.count < map->wanted;
    }
    run->progress.photons[kind] = run->answer->maps[kind].photons + map->list.count;
    uint64_t paths = map->first_path + map->paths;
    run->progress.paths = paths > run->progress.paths ? paths : run->progress.paths;
    return st;
}

/* The next batch of every map that is still short: stored ones are fetched, the others traced
 * together and kept. */
static pm_status next_batches(pm_run *run, uint64_t index,
                              const struct growing maps[PM_MAP_KINDS],
                              pm_batch batches[PM_MAP_KINDS])
{
    unsigned missing = 0;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        if (maps[kind].active &&
            !fetch_batch(run, &maps[kind].family, (pm_map_kind)kind, index, &batches[kind]))
            missing |= 1U << kind;
    pm_status st = missing ? pm_forward_batch(run->forward, index, missing, run->pool,
                                              pm_run_cancelled, run, batches, run->err)
                           : PM_OK;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        pm_map_summary *summary = &run->answer->maps[kind];
        if (missing & (1U << kind)) {
            summary->paths_traced += batches[kind].paths;
            st = keep_batch(run, &maps[kind].family, &batches[kind]);
        } else if (maps[kind].active) {
            summary->paths_cached += batches[kind].paths;
        }
    }
    return st;
}

pm_map_header pm_run_map_header(const pm_run *run, pm_map_kind kind)
{
    const pm_world_info *info = &run->answer->world;
    return (pm_map_header){.kind = kind,
                           .scene = run->answer->scene,
                           .family = pm_forward_family(run->forward, kind),
                           .paths = 1,
                           .flux_scale = pm_forward_flux_scale(run->forward),
                           .world_scale = info->scale,
                           .world_center = info->center,
                           .seed = run->job->forward.seed,
                           .storage_probability =
                               pm_forward_storage_probability(run->forward, kind),
                           .emitted = pm_forward_emitted(run->forward)};
}

static void write_note(const pm_run *run, const struct growing *map, pm_map_header *header)
{
    const pm_answer *answer = run->answer;
    snprintf(header->note, sizeof header->note, "%s", pm_forward_note(run->forward));
    if (!map->gave_up || pm_rgb_is_black(answer->emitted))
        return;
    double share = 100 / pm_rgb_mean(answer->emitted);
    snprintf(header->note, sizeof header->note,
             "stopped at %" PRIu64 " paths with %" PRIu64 " of %" PRIu64
             " photons: too few paths end here; %.3g %% of the light escaped, %.3g %% was "
             "absorbed",
             map->paths, (uint64_t)map->list.count, map->wanted,
             share * pm_rgb_mean(answer->escaped), share * pm_rgb_mean(answer->absorbed));
}

static void summarise(pm_run *run, pm_map_kind kind, const pm_map_header *header,
                      uint64_t photons)
{
    pm_map_summary *summary = &run->answer->maps[kind];
    summary->present = true;
    summary->family = header->family;
    summary->photons += photons;
    summary->paths += header->paths;
    memcpy(summary->note, header->note, sizeof summary->note);
}

static pm_map_header header_of_map(const pm_run *run, pm_map_kind kind,
                                   const struct growing *map)
{
    const pm_plan_pass *plan = &run->answer->plan.pass[kind];
    pm_map_header header = pm_run_map_header(run, kind);
    header.first_path = map->first_path;
    pm_run_thin_header(run, &header);
    header.paths = map->paths ? map->paths : 1;
    write_note(run, map, &header);
    if (!plan->needed)
        snprintf(header.note, sizeof header.note, "%s", plan->reason);
    return header;
}

/* ---- files of map jobs ---- */

struct outlet {
    pm_run *run;
    pm_map_kind kind;
    uint64_t bytes; /* since the outlet was made */
};

static pm_status put(void *context, const void *data, size_t size, pm_error *err)
{
    struct outlet *outlet = context;
    const pm_job_hooks *hooks = outlet->run->hooks;
    outlet->bytes += size;
    return hooks->put ? hooks->put(hooks->context, outlet->kind, data, size, err) : PM_OK;
}

/* The photons go to the file and are let go. */
static pm_status stream_map(pm_run *run, const pm_map_header *header, struct growing *map,
                            const char *command, uint64_t *bytes)
{
    struct outlet outlet = {run, header->kind, 0};
    const pm_sink sink = {&outlet, put};
    uint64_t photons = map->list.count;
    pm_run_progress(run, "build", 0);
    pm_status st =
        pm_photon_list_stream(header, &map->list, command, run->pool, &sink, run->err);
    map->list.count = 0;
    if (!st)
        summarise(run, header->kind, header, photons);
    *bytes = outlet.bytes;
    return st;
}

static pm_pass_summary *add_pass(pm_map_summary *summary)
{
    pm_pass_summary *passes =
        realloc(summary->passes, (summary->pass_count + 1) * sizeof *passes);
    if (!passes)
        return NULL;
    summary->passes = passes;
    pm_pass_summary *pass = &passes[summary->pass_count++];
    *pass = (pm_pass_summary){0};
    if (summary->pass_count > 1)
        pass->offset = pass[-1].offset + pass[-1].bytes;
    return pass;
}

static pm_status end_sequence(pm_run *run, pm_map_kind kind)
{
    struct outlet outlet = {run, kind, 0};
    const pm_sink sink = {&outlet, put};
    return pm_sequence_end(run->job->command, &sink, run->err);
}

/* A pass is complete, or given up, which ends the sequence. */
static pm_status end_pass(pm_run *run, pm_map_kind kind, struct growing *map)
{
    pm_map_summary *summary = &run->answer->maps[kind];
    pm_map_header header = header_of_map(run, kind, map);
    header.pass = summary->pass_count;
    pm_pass_summary *pass = add_pass(summary);
    if (!pass)
        return pm_error_set(run->err, PM_E_MEMORY, "no memory for another pass");
    pass->photons = map->list.count;
    pass->first_path = header.first_path;
    pass->paths = header.paths;
    pm_status st = stream_map(run, &header, map, NULL, &pass->bytes);
    map->active = summary->pass_count < map->passes && !map->gave_up;
    map->paths = 0;
    return st || map->active ? st : end_sequence(run, kind);
}

/* One more batch for every map that is still short. */
static pm_status grow(pm_run *run, uint64_t index, struct growing maps[PM_MAP_KINDS])
{
    pm_batch batches[PM_MAP_KINDS] = {0};
    bool counted = false;
    pm_status st = next_batches(run, index, maps, batches);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        struct growing *map = &maps[kind];
        if (!st && map->active) {
            if (!counted)
                add_balance(run, &batches[kind]);
            counted = true;
            st = settle(run, (pm_map_kind)kind, map, &batches[kind]);
            if (!st && map->passes && !map->active)
                st = end_pass(run, (pm_map_kind)kind, map);
        }
        pm_batch_clear(&batches[kind]);
    }
    return st;
}

static double share_done(const pm_run *run, const struct growing maps[PM_MAP_KINDS])
{
    double least = 1;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        double share = (double)maps[kind].list.count / (double)maps[kind].wanted;
        double limit = (double)path_limit(run, (pm_map_kind)kind, maps[kind].list.count);
        share = fmax(share, (double)maps[kind].paths / limit); /* of a map that is given up */
        if (maps[kind].passes)
            share = (run->answer->maps[kind].pass_count + share) / maps[kind].passes;
        if (maps[kind].active)
            least = share < least ? share : least;
    }
    return least;
}

static pm_status grow_all(pm_run *run, struct growing maps[PM_MAP_KINDS])
{
    for (uint64_t index = 0;; index++) {
        bool active = false;
        for (int kind = 0; kind < PM_MAP_KINDS; kind++)
            active = active || maps[kind].active;
        if (!active)
            return PM_OK;
        if (pm_run_cancelled(run))
            return pm_error_set(run->err, PM_E_CANCELLED, "cancelled while tracing photons");
        pm_run_progress(run, "forward", share_done(run, maps));
        pm_status st = grow(run, index, maps);
        if (st)
            return st;
    }
}

/* ---- maps ---- */

/* A map job that can put its files somewhere needs no search structure. */
static bool is_streamed(const pm_run *run)
{
    return run->job->kind == PM_JOB_MAP && run->hooks->put;
}

/* A precomputed map takes the place of the global map that it is made of. */
static pm_status precompute(pm_run *run, pm_photon_map **map)
{
    pm_photon_map *global = *map;
    *map = NULL;
    pm_status st = pm_run_precompute(run, global, map);
    pm_photon_map_free(global);
    return st;
}

/* A precomputed map of a map job, which has been built in any case. */
static pm_status stream_built(pm_run *run, pm_photon_map **map)
{
    struct outlet outlet = {run, PM_MAP_GLOBAL, 0};
    const pm_sink sink = {&outlet, put};
    pm_status st = pm_photon_map_stream(*map, run->job->command, run->pool, &sink, run->err);
    pm_photon_map_free(*map);
    *map = NULL;
    return st;
}

/* The map, or its place in the store, is known. */
static pm_status finish_precomputed(pm_run *run, pm_photon_map **map)
{
    summarise(run, PM_MAP_GLOBAL, pm_photon_map_header(*map), pm_photon_map_count(*map));
    return is_streamed(run) ? stream_built(run, map) : PM_OK;
}

static pm_status build_map(pm_run *run, pm_map_kind kind, struct growing *map,
                           pm_photon_map **out)
{
    pm_map_header header = header_of_map(run, kind, map);
    uint64_t bytes;
    bool precomputed = run->job->wanted.maps[kind].precomputed;
    if (is_streamed(run) && !precomputed)
        return stream_map(run, &header, map, run->job->command, &bytes);
    pm_run_progress(run, "build", 0);
    pm_status st = pm_photon_map_take(&header, &map->list, run->pool, out, run->err);
    if (!st && precomputed)
        st = precompute(run, out);
    if (!st && precomputed)
        return finish_precomputed(run, out);
    if (!st)
        summarise(run, kind, &header, pm_photon_map_count(*out));
    return st;
}

static pm_status check_file(pm_run *run, pm_map_kind kind, const char *name,
                            const pm_photon_map *map)
{
    const pm_map_header *header = pm_photon_map_header(map);
    const pm_map_wanted *wanted = &run->job->wanted.maps[kind];
    if (header->kind != (wanted->precomputed ? PM_MAP_PRECOMPUTED : kind))
        return pm_error_set_at(
            run->err, PM_E_MISMATCH, name, 0, 0, "holds %s photons, but is given as the %s map",
            pm_map_kind_name(header->kind), pm_map_wanted_name(wanted, kind));
    if (pm_digest_equal(&header->scene, &run->answer->scene))
        return PM_OK;
    char theirs[PM_DIGEST_HEX], ours[PM_DIGEST_HEX];
    pm_digest_hex(&header->scene, theirs);
    pm_digest_hex(&run->answer->scene, ours);
    return pm_error_set_at(
        run->err, PM_E_MISMATCH, name, 0, 0,
        "was made for another scene (octree hash %.12s, this scene has %.12s);"
        " make it again with mkpmap from this scene, "
        "with the same -me -ma -mg -bv",
        theirs, ours);
}

static pm_status read_file(pm_run *run, pm_map_kind kind, pm_photon_map **out)
{
    const pm_map_file *file = &run->job->files[kind];
    pm_photon_map *map = NULL;
    pm_status st = pm_photon_map_read(file->data, file->size, file->name, &map, NULL, run->err);
    if (!st)
        st = check_file(run, kind, file->name, map);
    if (st) {
        pm_photon_map_free(map);
        return st;
    }
    summarise(run, kind, pm_photon_map_header(map), pm_photon_map_count(map));
    *out = map;
    return PM_OK;
}

/* A map is traced if the plan needs it and no file brings it; a map job also answers with an
 * empty map where the scene cannot have one. */
static bool is_made(const pm_run *run, int kind)
{
    return run->job->wanted.maps[kind].wanted && !run->job->files[kind].data &&
           (run->answer->plan.pass[kind].needed || run->job->kind == PM_JOB_MAP);
}

static pm_status finish_maps(pm_run *run, struct growing maps[PM_MAP_KINDS],
                             pm_photon_map *out[PM_MAP_KINDS])
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        pm_status st = PM_OK;
        if (out[kind])
            st = finish_precomputed(run, &out[kind]);
        else if (run->job->files[kind].data)
            st = read_file(run, (pm_map_kind)kind, &out[kind]);
        else if (is_made(run, kind) && !run->answer->maps[kind].pass_count)
            st = build_map(run, (pm_map_kind)kind, &maps[kind], &out[kind]);
        if (st)
            return st;
    }
    return PM_OK;
}

/* What a map takes beside its photons: the tree, and each thread's work. */
enum { TREE_BYTES = 2, WORK_BYTES = 32 << 20, LAST_PATH_PHOTONS = 64 };

/* All the memory that the maps will take is asked for before any work: address space, which
 * costs nothing until photons fill it. */
static pm_status reserve(pm_run *run, struct growing maps[PM_MAP_KINDS])
{
    uint64_t photons = 0;
    pm_status st = PM_OK;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        if (!maps[kind].active)
            continue;
        photons += maps[kind].wanted;
        st = pm_photon_list_reserve(&maps[kind].list, maps[kind].wanted + LAST_PATH_PHOTONS,
                                    NULL);
    }
    void *volatile rest =
        st ? NULL : malloc(TREE_BYTES * photons + WORK_BYTES * pm_pool_threads(run->pool));
    if (!rest)
        st = pm_error_set(run->err, st == PM_E_LIMIT ? st : PM_E_MEMORY,
                          "no memory for %" PRIu64 " photons, which take %.3g GB: ask for "
                          "fewer, or allow more (pmserver --memory-limit)",
                          photons, 1e-9 * (24 + TREE_BYTES) * (double)photons);
    free(rest);
    return st;
}

/* True if the map is in the store. */
static bool begin_precomputed(pm_run *run, pm_photon_map **out)
{
    const pm_digest family = pm_run_precomputed_family(run);
    if (run->hooks->begin)
        run->hooks->begin(run->hooks->context, &family, PM_MAP_GLOBAL);
    return pm_run_fetch_precomputed(run, out);
}

static void end_precomputed(pm_run *run)
{
    const pm_digest family = pm_run_precomputed_family(run);
    if (run->hooks->end)
        run->hooks->end(run->hooks->context, &family);
}

pm_status pm_run_make_maps(pm_run *run, pm_photon_map *out[PM_MAP_KINDS])
{
    struct growing maps[PM_MAP_KINDS] = {0};
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        const pm_plan_pass *pass = &run->answer->plan.pass[kind];
        maps[kind].active = is_made(run, kind) && pass->needed;
        maps[kind].wanted = pass->count;
        maps[kind].passes = run->job->wanted.maps[kind].passes;
    }
    bool precomputes =
        maps[PM_MAP_GLOBAL].active && run->job->wanted.maps[PM_MAP_GLOBAL].precomputed;
    if (precomputes)
        maps[PM_MAP_GLOBAL].active = !begin_precomputed(run, &out[PM_MAP_GLOBAL]);
    pm_status st = reserve(run, maps);
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++)
        if (maps[kind].active)
            begin(run, (pm_map_kind)kind, &maps[kind]);
    if (!st)
        st = grow_all(run, maps);
    if (!st)
        st = finish_maps(run, maps, out);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        pm_photon_list_clear(&maps[kind].list);
        end(run, &maps[kind]);
    }
    if (precomputes)
        end_precomputed(run);
    return st;
}

/* Which kinds a progressive pass traces: a global map serves the caustics too. */
static unsigned pass_kinds(const pm_run *run)
{
    unsigned kinds = 0;
    if (run->answer->plan.pass[PM_MAP_GLOBAL].needed)
        kinds |= 1U << PM_MAP_GLOBAL;
    else if (run->answer->plan.pass[PM_MAP_CAUSTIC].needed)
        kinds |= 1U << PM_MAP_CAUSTIC;
    if (run->answer->plan.pass[PM_MAP_VOLUME].needed)
        kinds |= 1U << PM_MAP_VOLUME;
    return kinds;
}

pm_status pm_run_make_pass_maps(pm_run *run, uint32_t pass, pm_photon_map *out[PM_MAP_KINDS])
{
    unsigned kinds = pass_kinds(run);
    pm_batch traced[PM_MAP_KINDS] = {0};
    pm_status st = kinds ? pm_forward_batch(run->forward, pass, kinds, run->pool,
                                            pm_run_cancelled, run, traced, run->err)
                         : PM_OK;
    bool counted = false;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        if (!(kinds & (1U << kind)))
            continue;
        pm_map_header header = pm_run_map_header(run, (pm_map_kind)kind);
        header.paths = traced[kind].paths;
        st = pm_photon_map_build(&header, &traced[kind], 1, run->pool, &out[kind], run->err);
        if (!counted)
            add_balance(run, &traced[kind]);
        counted = true;
        run->answer->maps[kind].present = true;
        run->answer->maps[kind].family = header.family;
        run->answer->maps[kind].photons += traced[kind].count;
        run->answer->maps[kind].paths += traced[kind].paths;
        run->answer->maps[kind].paths_traced += traced[kind].paths;
    }
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        if (kinds & (1U << kind))
            pm_batch_clear(&traced[kind]);
    return st;
}
