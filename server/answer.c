#include "answer.h"

#include <stdio.h>

const char *pm_cache_name(pm_cache cache)
{
    static const char *const names[] = {"none", "hit", "joined", "extended", "miss"};
    return names[cache];
}

pm_cache pm_cache_of(const pm_job *job, const pm_answer *answer, pm_map_kind kind, bool joined)
{
    const pm_map_summary *map = &answer->maps[kind];
    if (job->wanted.estimator != PM_NEAREST || !map->present ||
        !(map->paths_traced | map->paths_cached))
        return PM_CACHE_NONE;
    if (!map->paths_cached)
        return PM_CACHE_MISS;
    if (map->paths_traced)
        return PM_CACHE_EXTENDED;
    return joined ? PM_CACHE_JOINED : PM_CACHE_HIT;
}

static pm_json *color(pm_rgb c)
{
    return pm_json_pack("[o, o, o]", pm_json_finite(c.r), pm_json_finite(c.g),
                        pm_json_finite(c.b));
}

static pm_json *point(pm_vec3 p)
{
    return pm_json_pack("[o, o, o]", pm_json_finite(p.x), pm_json_finite(p.y),
                        pm_json_finite(p.z));
}

static pm_json *digest(const pm_digest *value)
{
    char hex[PM_DIGEST_HEX];
    pm_digest_hex(value, hex);
    return pm_json_pack("s", hex);
}

static pm_json *plan_json(const pm_plan *plan)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (int kind = 0; kind < PM_MAP_KINDS && made; kind++) {
        const pm_plan_pass *pass = &plan->pass[kind];
        made =
            pm_json_append(list, pm_json_pack("{s:s, s:b, s:I, s:i, s:i, s:s}", "pass",
                                              pm_map_kind_name((pm_map_kind)kind), "needed",
                                              pass->needed, "count", (long long)pass->count,
                                              "gather", (int)pass->gather_count, "gather_max",
                                              (int)pass->gather_max, "reason", pass->reason));
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

static pm_json *world_json(const pm_answer *answer)
{
    const pm_world_info *info = &answer->world;
    return pm_json_pack(
        "{s:o, s:I, s:I, s:I, s:I, s:I, s:I, s:o, s:[o, o]}", "scene", digest(&answer->scene),
        "surfaces", (long long)info->surfaces, "lights", (long long)info->lights,
        "diffuse_surfaces", (long long)info->diffuse_surfaces, "specular_surfaces",
        (long long)info->specular_surfaces, "mist_surfaces", (long long)info->mist_surfaces,
        "octree_nodes", (long long)info->octree_nodes, "power", color(info->power), "bounds",
        point(info->low), point(info->high));
}

/* ---- what a check says ---- */

/* How many primitives there are of each type; types that are not there are left out. */
static pm_json *counts_json(const pm_survey *survey)
{
    pm_json *object = pm_json_pack("{}");
    bool made = object;
    for (int type = 0; type < PM_PRIMITIVE_TYPES && made; type++)
        if (survey->counts[type])
            made = pm_json_put(object, pm_primitive_type_name((pm_primitive_type)type),
                               pm_json_pack("I", (long long)survey->counts[type]));
    if (made)
        return object;
    pm_json_free(object);
    return NULL;
}

static pm_json *light_list_json(const pm_survey *survey)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (size_t i = 0; i < survey->light_count && made; i++) {
        const pm_survey_light *light = &survey->lights[i];
        made = pm_json_append(list, pm_json_pack("{s:o, s:s, s:o, s:o}", "name",
                                                 pm_json_quote(light->name), "type",
                                                 pm_primitive_type_name(light->type),
                                                 "material", pm_json_quote(light->material),
                                                 "power", pm_json_finite(light->power)));
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

static pm_json *warnings_json(const pm_survey *survey)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (size_t i = 0; i < survey->warning_count && made; i++) {
        const pm_warning *w = &survey->warnings[i];
        made = pm_json_append(list, pm_json_pack("{s:s, s:o, s:o, s:i, s:i}", "kind",
                                                 pm_warning_kind_name(w->kind), "text",
                                                 pm_json_quote(w->text), "file",
                                                 pm_json_quote(w->file), "line", w->line,
                                                 "column", w->column));
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

static bool put_survey(pm_json *object, const pm_survey *survey)
{
    return !survey ||
           (pm_json_put(object, "counts", counts_json(survey)) &&
            pm_json_put(object, "media", pm_json_pack("I", (long long)survey->media)) &&
            pm_json_put(object, "in_instances",
                        pm_json_pack("I", (long long)survey->in_prototypes)) &&
            pm_json_put(object, "light_list", light_list_json(survey)) &&
            pm_json_put(object, "escaping",
                        survey->has_paths ? pm_json_finite(survey->escaping)
                                          : pm_json_pack("n")) &&
            pm_json_put(object, "warnings", warnings_json(survey)));
}

pm_json *pm_answer_scene_json(const pm_answer *answer)
{
    pm_json *world = world_json(answer);
    if (world && put_survey(world, answer->survey) &&
        pm_json_put(world, "plan", plan_json(&answer->plan)))
        return world;
    pm_json_free(world);
    return NULL;
}

/* The key of a stored map, or null: a family and a wanted count; of a sequence also how many
 * passes. */
static pm_json *key_json(const pm_job *job, const pm_answer *answer, int kind)
{
    const pm_map_wanted *wanted = &job->wanted.maps[kind];
    char hex[PM_DIGEST_HEX], key[PM_DIGEST_HEX + 48];
    if (job->wanted.estimator != PM_NEAREST || job->files[kind].data)
        return pm_json_pack("n");
    pm_digest_hex(&answer->maps[kind].family, hex);
    int used = snprintf(key, sizeof key, "%s-%llu", hex, (unsigned long long)wanted->count);
    if (wanted->passes)
        snprintf(key + used, sizeof key - (size_t)used, "-%u", wanted->passes);
    return pm_json_pack("s", key);
}

static pm_json *passes_json(const pm_map_summary *map)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (uint32_t i = 0; i < map->pass_count && made; i++) {
        const pm_pass_summary *pass = &map->passes[i];
        made = pm_json_append(
            list, pm_json_pack("{s:I, s:I, s:I, s:I, s:I}", "photons", (long long)pass->photons,
                               "first_path", (long long)pass->first_path, "paths",
                               (long long)pass->paths, "offset", (long long)pass->offset,
                               "bytes", (long long)pass->bytes));
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

static pm_json *map_json(const pm_job *job, const pm_answer *answer, int kind, pm_cache cache)
{
    const pm_map_summary *map = &answer->maps[kind];
    pm_json *json = pm_json_pack(
        "{s:s, s:o, s:o, s:o, s:I, s:I, s:I, s:I, s:I, s:s, s:s}", "kind",
        pm_map_wanted_name(&job->wanted.maps[kind], (pm_map_kind)kind), "key",
        key_json(job, answer, kind), "family", digest(&map->family), "scene",
        digest(&answer->scene), "count", (long long)job->wanted.maps[kind].count, "photons",
        (long long)map->photons, "paths", (long long)map->paths, "paths_traced",
        (long long)map->paths_traced, "paths_cached", (long long)map->paths_cached, "cache",
        pm_cache_name(cache), "note", map->note);
    if (!json || !map->pass_count || pm_json_put(json, "passes", passes_json(map)))
        return json;
    pm_json_free(json);
    return NULL;
}

/* A job missed if any of its maps did; it hit only if all did. */
static pm_json *maps_json(const pm_job *job, const pm_answer *answer,
                          const bool joined[PM_MAP_KINDS], pm_cache *overall)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    *overall = PM_CACHE_NONE;
    for (int kind = 0; kind < PM_MAP_KINDS && made; kind++) {
        if (!answer->maps[kind].present)
            continue;
        pm_cache cache = pm_cache_of(job, answer, (pm_map_kind)kind, joined[kind]);
        if (*overall == PM_CACHE_NONE)
            *overall = cache;
        else if (cache == PM_CACHE_EXTENDED ||
                 (cache != PM_CACHE_NONE &&
                  (cache == PM_CACHE_MISS) != (*overall == PM_CACHE_MISS)))
            *overall = PM_CACHE_EXTENDED;
        else if (cache > *overall)
            *overall = cache;
        made = pm_json_append(list, map_json(job, answer, kind, cache));
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

static pm_json *curve_json(const pm_answer *answer)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (size_t i = 0; i < answer->curve_count && made; i++) {
        const pm_curve_point *at = &answer->curve[i];
        made = pm_json_append(
            list, pm_json_pack("{s:f, s:f, s:I, s:o}", "cpu_seconds", at->cpu_seconds,
                               "wall_seconds", at->wall_seconds, "passes",
                               (long long)at->passes, "error", pm_json_finite(at->error)));
    }
    if (made)
        return list;
    pm_json_free(list);
    return NULL;
}

pm_json *pm_answer_json(const pm_job *job, const pm_answer *answer,
                        const bool joined[PM_MAP_KINDS])
{
    pm_cache cache;
    pm_json *maps = maps_json(job, answer, joined, &cache);
    return pm_json_pack(
        "{s:o, s:o, s:o, s:s, s:o, s:I, s:o, s:f, s:f, s:I, s:{s:o, s:o, s:o}}", "world",
        world_json(answer), "plan", plan_json(&answer->plan), "maps", maps, "cache",
        pm_cache_name(cache), "curve", curve_json(answer), "passes", (long long)answer->passes,
        "error", pm_json_finite(answer->error), "cpu_seconds", answer->cpu_seconds,
        "wall_seconds", answer->wall_seconds, "nonfinite", (long long)answer->nonfinite,
        "balance", "emitted", color(answer->emitted), "absorbed", color(answer->absorbed),
        "escaped", color(answer->escaped));
}

pm_json *pm_progress_json(const pm_progress *progress)
{
    return pm_json_pack(
        "{s:s, s:s, s:o, s:{s:I, s:I, s:I, s:I}, s:I, s:I, s:o, s:f, s:f}", "type", "progress",
        "stage", progress->stage, "done", pm_json_finite(progress->done), "photons", "global",
        (long long)progress->photons[PM_MAP_GLOBAL], "caustic",
        (long long)progress->photons[PM_MAP_CAUSTIC], "volume",
        (long long)progress->photons[PM_MAP_VOLUME], "direct",
        (long long)progress->photons[PM_MAP_DIRECT], "paths", (long long)progress->paths,
        "passes", (long long)progress->passes, "error", pm_json_finite(progress->error),
        "cpu_seconds", progress->cpu_seconds, "wall_seconds", progress->wall_seconds);
}
