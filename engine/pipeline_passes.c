#include "pipeline_internal.h"

#include <math.h>
#include <stdlib.h>

#include "base/maths.h"

enum {
    NEAREST_PASSES = 16, /* samples a pixel of an N-nearest job that names no stop */
    RADIUS_PROBES = 256, /* photons that the first progressive radius is measured at */
    GLOBAL_PROBE = 20,   /* photons within the first radius */
    CAUSTIC_PROBE = 12,
    VOLUME_PROBE = 24,
    DARK_PASSES = 256, /* without any light, after which an error is no longer waited for */
};

struct stops {
    uint32_t passes;
    double seconds, error;
};

static struct stops stops_of(const pm_job *job)
{
    struct stops stops = {job->passes, job->seconds, job->error};
    if (stops.passes || stops.seconds > 0 || stops.error > 0)
        return stops;
    if (job->wanted.estimator == PM_NEAREST)
        return (struct stops){.passes = NEAREST_PASSES};
    return (struct stops){.seconds = 60, .error = .02};
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The volume map has no filter: its photons are what they are. */
static bool is_probed(const pm_photon *photon, pm_photon_filter filter)
{
    bool specular = photon->flags & PM_PHOTON_SPECULAR;
    return filter == PM_PHOTONS_ALL || specular == (filter == PM_PHOTONS_SPECULAR);
}

static size_t count_probed(const pm_photon_map *map, pm_photon_filter filter)
{
    size_t probed = 0, count = map ? pm_photon_map_count(map) : 0;
    for (size_t i = 0; i < count; i++) {
        pm_photon photon;
        pm_photon_map_photon(map, i, &photon);
        probed += is_probed(&photon, filter);
    }
    return probed;
}

/* The radius that holds `gather_count` photons around one of them. */
static double radius_at(const pm_photon_map *map, const pm_photon *photon,
                        pm_photon_filter filter, uint32_t gather_count)
{
    pm_vec3 point = pm_photon_position(photon);
    if (pm_photon_map_header(map)->kind == PM_MAP_VOLUME)
        return pm_photon_map_volume(map, point, (pm_vec3){0, 0, 1}, 0, gather_count, INFINITY)
            .radius;
    return pm_photon_map_nearest(map, point, pm_photon_normal(photon), gather_count, INFINITY,
                                 filter, NULL)
        .radius;
}

/* The radius that holds `gather_count` photons, measured at photons evenly spread over the
 * stored order; of a map with fewer photons, the radius of those it has, widened. It depends on
 * the map alone, so every view of a scene uses the same radii. Photons crowd where light is
 * focused and are sparse where it is spread: the geometric mean of the quantiles `low` and 1/2
 * keeps edges without starving the rest. 0 of a map that holds none or one. */
static double probe_radius(const pm_photon_map *map, pm_photon_filter filter,
                           uint32_t gather_count, double low)
{
    double radii[RADIUS_PROBES];
    size_t probed = count_probed(map, filter), seen = 0, found = 0;
    if (probed < 2)
        return 0;
    size_t probes = probed < RADIUS_PROBES ? probed : RADIUS_PROBES;
    uint32_t held = probed > gather_count ? gather_count : (uint32_t)(probed - 1);
    for (size_t i = 0; found < probes && i < pm_photon_map_count(map); i++) {
        pm_photon photon;
        pm_photon_map_photon(map, i, &photon);
        if (!is_probed(&photon, filter))
            continue;
        size_t nth = seen++;
        if (nth * probes / probed < seen * probes / probed)
            radii[found++] = radius_at(map, &photon, filter, held);
    }
    qsort(radii, found, sizeof *radii, by_size);
    bool volume = pm_photon_map_header(map)->kind == PM_MAP_VOLUME;
    double wider = pm_pow((double)gather_count / held, volume ? 1. / 3 : 1. / 2);
    return wider * sqrt(radii[(size_t)(low * (double)found)] * radii[found / 2]);
}

static void measure_radii(pm_photon_map *const maps[PM_MAP_KINDS], double first[PM_MAP_KINDS])
{
    if (!first[PM_MAP_GLOBAL])
        first[PM_MAP_GLOBAL] =
            probe_radius(maps[PM_MAP_GLOBAL], PM_PHOTONS_NOT_SPECULAR, GLOBAL_PROBE, .5);
    const pm_photon_map *caustics =
        maps[PM_MAP_CAUSTIC] ? maps[PM_MAP_CAUSTIC] : maps[PM_MAP_GLOBAL];
    if (!first[PM_MAP_CAUSTIC])
        first[PM_MAP_CAUSTIC] = probe_radius(caustics, PM_PHOTONS_SPECULAR, CAUSTIC_PROBE, .1);
    if (!first[PM_MAP_VOLUME])
        first[PM_MAP_VOLUME] =
            probe_radius(maps[PM_MAP_VOLUME], PM_PHOTONS_ALL, VOLUME_PROBE, .5);
}

/* Makes the maps of this pass, looks once, frees them. */
static pm_status progressive_pass(pm_run *run, pm_accumulation *accumulation, uint32_t pass,
                                  double first[PM_MAP_KINDS])
{
    pm_photon_map *maps[PM_MAP_KINDS] = {NULL};
    pm_status st = pm_run_make_pass_maps(run, pass, maps);
    if (!st) {
        measure_radii(maps, first);
        pm_backward_maps seen = {.progressive = true,
                                 .ambient_bounces = run->job->wanted.ambient_bounces};
        for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
            seen.map[kind] = maps[kind];
            seen.radius[kind] = pm_progressive_radius(first[kind], pass);
        }
        st = pm_backward_pass(accumulation, pass, &seen, run->pool, pm_run_cancelled, run,
                              run->err);
    }
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        pm_photon_map_free(maps[kind]);
    return st;
}

static pm_status nearest_pass(pm_run *run, pm_accumulation *accumulation, uint32_t pass,
                              pm_photon_map *const maps[PM_MAP_KINDS])
{
    pm_backward_maps seen = {.ambient_bounces = run->job->wanted.ambient_bounces};
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        seen.map[kind] = maps[kind];
        seen.gather_count[kind] = run->answer->plan.pass[kind].gather_count;
        seen.gather_max[kind] = run->answer->plan.pass[kind].gather_max;
        seen.bandwidth[kind] = run->answer->plan.pass[kind].bandwidth;
    }
    return pm_backward_pass(accumulation, pass, &seen, run->pool, pm_run_cancelled, run,
                            run->err);
}

/* Pass counts at which the error is estimated, a fixed series so that a stop at an error is
 * reproducible: every pass to 4, then steps of a quarter. */
static bool is_checkpoint(uint32_t passes, uint32_t *next)
{
    if (passes < *next)
        return false;
    *next = passes + (passes < 4 ? 1 : passes / 4);
    return true;
}

static pm_status add_curve_point(pm_run *run, const pm_accumulation *accumulation)
{
    pm_answer *answer = run->answer;
    pm_curve_point *curve =
        realloc(answer->curve, (answer->curve_count + 1) * sizeof *answer->curve);
    if (!curve)
        return pm_error_set(run->err, PM_E_MEMORY, "no memory for the error curve");
    answer->curve = curve;
    answer->error = pm_accumulation_error(accumulation);
    curve[answer->curve_count++] = (pm_curve_point){.cpu_seconds = pm_run_cpu_seconds(run),
                                                    .wall_seconds = pm_run_wall_seconds(run),
                                                    .passes = answer->passes,
                                                    .error = answer->error};
    run->progress.error = answer->error;
    return PM_OK;
}

static bool time_is_up(const pm_run *run, const struct stops *stops)
{
    return stops->seconds > 0 && pm_run_wall_seconds(run) >= stops->seconds;
}

/* The error is small enough; or is the only stop and can never be, as nothing is lit. */
static bool error_is_settled(const pm_run *run, const struct stops *stops)
{
    const pm_answer *answer = run->answer;
    if (!(stops->error > 0))
        return false;
    if (answer->error <= stops->error)
        return true;
    bool alone = !stops->passes && !(stops->seconds > 0);
    return alone && answer->error == INFINITY && answer->passes >= DARK_PASSES;
}

/* How far the job is towards its nearest stop. */
static double share_done(const pm_run *run, const struct stops *stops)
{
    double share = 0;
    if (stops->passes)
        share = (double)run->answer->passes / stops->passes;
    if (stops->seconds > 0)
        share = fmax(share, pm_run_wall_seconds(run) / stops->seconds);
    if (stops->error > 0 && isfinite(run->answer->error) && run->answer->error > 0)
        share = fmax(share, fmin(1, pow(stops->error / run->answer->error, 2)));
    return fmin(share, 1);
}

pm_status pm_run_passes(pm_run *run, pm_accumulation *accumulation,
                        pm_photon_map *const maps[PM_MAP_KINDS])
{
    const struct stops stops = stops_of(run->job);
    double first_radius[PM_MAP_KINDS] = {0};
    uint32_t next_checkpoint = 1;
    for (bool last = false; !last;) {
        pm_run_progress(run, "backward", share_done(run, &stops));
        uint32_t pass = run->answer->passes;
        pm_status st = run->job->wanted.estimator == PM_PROGRESSIVE
                           ? progressive_pass(run, accumulation, pass, first_radius)
                           : nearest_pass(run, accumulation, pass, maps);
        if (st)
            return st;
        run->answer->passes = run->progress.passes = pass + 1;
        last = (stops.passes && run->answer->passes >= stops.passes) || time_is_up(run, &stops);
        if (last || is_checkpoint(run->answer->passes, &next_checkpoint)) {
            st = add_curve_point(run, accumulation);
            if (st)
                return st;
            last = last || error_is_settled(run, &stops);
        }
    }
    run->answer->nonfinite += pm_accumulation_nonfinite(accumulation);
    pm_run_progress(run, "backward", 1);
    return PM_OK;
}
