#include "pipeline_internal.h"

#include <stdlib.h>

#include "photons/precompute.h"

/* Precomputed maps are kept in the store as one batch: its only path holds all photons, its
 * index says how many paths the global map was made of. */

pm_digest pm_run_precomputed_family(const pm_run *run)
{
    const pm_plan_pass *pass = &run->answer->plan.pass[PM_MAP_GLOBAL];
    pm_digest global = pm_forward_family(run->forward, PM_MAP_GLOBAL);
    return pm_precompute_family(&global, pass->count, pass->gather_count, pass->fraction);
}

static pm_precompute options_of(const pm_run *run)
{
    const pm_plan_pass *pass = &run->answer->plan.pass[PM_MAP_GLOBAL];
    return (pm_precompute){.gather_count = pass->gather_count,
                           .fraction = pass->fraction,
                           .family = pm_run_precomputed_family(run),
                           .seed = run->job->forward.seed,
                           .estimate = pm_estimate_at_photon,
                           .context = run->world};
}

/* ---- keeping it ---- */

/* The balance of a kept map's only path is the mean of the paths behind it. */
static pm_rgb a_path(const pm_run *run, pm_rgb flux)
{
    const double scale = run->answer->world.scale;
    return pm_rgb_scale(flux, 1 / (scale * scale));
}

static pm_status keep(pm_run *run, const pm_photon_map *map)
{
    const pm_map_header *header = pm_photon_map_header(map);
    size_t count = pm_photon_map_count(map);
    uint32_t end = (uint32_t)count;
    pm_batch batch = {.kind = PM_MAP_GLOBAL,
                      .index = header->paths,
                      .paths = 1,
                      .ends = &end,
                      .count = count,
                      .photons = malloc((count + 1) * sizeof(pm_photon)),
                      .emitted = a_path(run, run->answer->emitted),
                      .absorbed = a_path(run, run->answer->absorbed),
                      .escaped = a_path(run, run->answer->escaped)};
    pm_bytes bytes = {0};
    if (!batch.photons)
        return pm_error_set(run->err, PM_E_MEMORY, "no memory to keep a precomputed map");
    for (size_t i = 0; i < count; i++)
        pm_photon_map_photon(map, i, &batch.photons[i]);
    pm_status st = pm_batch_write(&batch, &bytes, run->err);
    if (!st)
        run->hooks->keep(run->hooks->context, &header->family, PM_MAP_GLOBAL, 0, &bytes);
    pm_bytes_clear(&bytes);
    free(batch.photons);
    return st;
}

/* A map that fell short of its number is made again each time: its note tells of this run. */
pm_status pm_run_precompute(pm_run *run, const pm_photon_map *global, pm_photon_map **out)
{
    const pm_precompute how = options_of(run);
    pm_photon_map *map = NULL;
    pm_run_progress(run, "precompute", 0);
    pm_status st = pm_photon_map_precompute(global, &how, run->pool, pm_run_cancelled, run,
                                            &map, run->err);
    if (!st && run->hooks->keep && pm_photon_map_count(map) &&
        !pm_photon_map_header(map)->note[0])
        st = keep(run, map);
    if (st)
        pm_photon_map_free(map);
    else
        *out = map;
    return st;
}

/* ---- having it back ---- */

static bool read_kept(const pm_run *run, const pm_digest *family, pm_batch *out)
{
    const pm_job_hooks *hooks = run->hooks;
    const void *data = NULL;
    size_t size = 0;
    if (!hooks->fetch || !hooks->fetch(hooks->context, family, 0, &data, &size))
        return false;
    bool sound = pm_batch_read(data, size, out, NULL) == PM_OK;
    if (hooks->release)
        hooks->release(hooks->context, data, size);
    return sound;
}

static pm_status rebuild(pm_run *run, const pm_batch *batch, pm_photon_map **out)
{
    const pm_precompute how = options_of(run);
    pm_map_header header = pm_run_map_header(run, PM_MAP_GLOBAL);
    pm_photon_list list = {0};
    header.paths = batch->index;
    pm_run_thin_header(run, &header);
    pm_precompute_header(&header, &how);
    pm_status st = pm_photon_list_append(&list, batch->photons, batch->count, NULL);
    if (!st)
        st = pm_photon_map_take(&header, &list, run->pool, out, NULL);
    pm_photon_list_clear(&list);
    return st;
}

bool pm_run_fetch_precomputed(pm_run *run, pm_photon_map **out)
{
    pm_answer *answer = run->answer;
    const pm_digest family = pm_run_precomputed_family(run);
    pm_batch batch = {0};
    if (!read_kept(run, &family, &batch))
        return false;
    bool had = batch.paths == 1 && batch.index > 0 && !rebuild(run, &batch, out);
    if (had) {
        double area = answer->world.scale * answer->world.scale;
        answer->maps[PM_MAP_GLOBAL].paths_cached = batch.index;
        answer->emitted = pm_rgb_scale(batch.emitted, area);
        answer->absorbed = pm_rgb_scale(batch.absorbed, area);
        answer->escaped = pm_rgb_scale(batch.escaped, area);
        run->balance_paths = batch.index;
    }
    pm_batch_clear(&batch);
    return had;
}
