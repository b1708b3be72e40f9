#include "describe.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* "name          text", if there is any */
static void print_text(FILE *to, const char *name, const pm_json *object, const char *member)
{
    const char *text = pm_json_get_text(object, member, "");
    if (*text)
        fprintf(to, "%-13s %s\n", name, text);
}

static void print_integer(FILE *to, const char *name, const pm_json *object, const char *member)
{
    if (pm_json_get(object, member))
        fprintf(to, "%-13s %" PRId64 "\n", name, pm_json_get_integer(object, member, 0));
}

static void print_vector(FILE *to, const pm_json *vector)
{
    for (size_t i = 0; i < 3; i++)
        fprintf(to, "%s%.6g", i ? " " : "", pm_json_number(pm_json_at(vector, i)));
}

/* ---- scenes ---- */

static void print_world(const pm_json *world, FILE *to)
{
    const pm_json *bounds = pm_json_get(world, "bounds");
    print_text(to, "octree hash", world, "scene");
    fprintf(to,
            "%-13s %" PRId64 " (%" PRId64 " diffuse, %" PRId64 " specular, %" PRId64
            " around mist)\n",
            "surfaces", pm_json_get_integer(world, "surfaces", 0),
            pm_json_get_integer(world, "diffuse_surfaces", 0),
            pm_json_get_integer(world, "specular_surfaces", 0),
            pm_json_get_integer(world, "mist_surfaces", 0));
    fprintf(to, "%-13s %" PRId64 " of ", "lights", pm_json_get_integer(world, "lights", 0));
    print_vector(to, pm_json_get(world, "power"));
    fprintf(to, " W (red green blue)\n%-13s ", "bounds");
    print_vector(to, pm_json_at(bounds, 0));
    fputs(" to ", to);
    print_vector(to, pm_json_at(bounds, 1));
    fputc('\n', to);
}

/* "12 polygon, 3 plastic": as many on a line as fit. */
static void print_counts(pm_json *counts, FILE *to)
{
    int width = 0;
    const char *type = NULL;
    while (counts && (type = pm_json_next(counts, type))) {
        char text[64];
        int length = snprintf(text, sizeof text, "%" PRId64 " %s",
                              pm_json_get_integer(counts, type, 0), type);
        if (!width || width + length > 80)
            fprintf(to, "%s%-13s ", width ? ",\n" : "", width ? "" : "primitives");
        else
            fputs(", ", to);
        width = (width && width + length <= 80 ? width + 2 : 14) + length;
        fputs(text, to);
    }
    if (width)
        fputc('\n', to);
}

static void print_lights(const pm_json *lights, FILE *to)
{
    for (size_t i = 0; i < pm_json_length(lights); i++) {
        const pm_json *light = pm_json_at(lights, i);
        fprintf(to, "%-13s %.4g W  %s %s of %s\n", i ? "" : "strongest",
                pm_json_get_number(light, "power", 0), pm_json_get_text(light, "type", ""),
                pm_json_get_text(light, "name", ""), pm_json_get_text(light, "material", ""));
    }
}

static void print_enclosure(const pm_json *scene, FILE *to)
{
    const pm_json *escaping = pm_json_get(scene, "escaping");
    if (pm_json_type_of(escaping) == PM_JSON_REAL)
        fprintf(to, "%-13s %.3g %% of the lamps' paths leave the scene\n", "enclosure",
                100 * pm_json_number(escaping));
}

static void print_warnings(const pm_json *warnings, FILE *to)
{
    for (size_t i = 0; i < pm_json_length(warnings); i++) {
        const pm_json *w = pm_json_at(warnings, i);
        const char *file = pm_json_get_text(w, "file", "");
        fputs("warning: ", to);
        if (*file)
            fprintf(to, "%s:%" PRId64 ":%" PRId64 ": ", file, pm_json_get_integer(w, "line", 0),
                    pm_json_get_integer(w, "column", 0));
        fprintf(to, "%s\n", pm_json_get_text(w, "text", ""));
    }
}

static void print_plan(const pm_json *plan, FILE *to)
{
    for (size_t i = 0; i < pm_json_length(plan); i++)
        fprintf(to, "%-13s %s\n", i ? "" : "plan",
                pm_json_get_text(pm_json_at(plan, i), "reason", ""));
}

void pm_describe_scene(const pm_json *scene, FILE *to)
{
    print_text(to, "scene", scene, "main");
    print_text(to, "id", scene, "id");
    print_world(scene, to);
    print_counts(pm_json_get(scene, "counts"), to);
    if (pm_json_get_integer(scene, "in_instances", 0))
        print_integer(to, "in instances", scene, "in_instances");
    if (pm_json_get_integer(scene, "media", 0))
        print_integer(to, "media", scene, "media");
    print_lights(pm_json_get(scene, "light_list"), to);
    print_enclosure(scene, to);
    print_plan(pm_json_get(scene, "plan"), to);
    print_warnings(pm_json_get(scene, "warnings"), to);
}

/* ---- maps ---- */

void pm_describe_map(const pm_json *map, FILE *to)
{
    print_text(to, "key", map, "key");
    print_text(to, "kind", map, "kind");
    print_integer(to, "wanted", map, "count");
    print_integer(to, "photons", map, "photons");
    print_integer(to, "paths", map, "paths");
    print_text(to, "octree hash", map, "scene");
    print_text(to, "family", map, "family");
    print_text(to, "note", map, "note");
}

void pm_describe_maps(const pm_json *maps, bool heading, FILE *to)
{
    static const char format[] = "%-75s  %-11s  %11s  %11s\n";
    if (heading)
        fprintf(to, format, "KEY", "KIND", "PHOTONS", "PATHS");
    for (size_t i = 0; i < pm_json_length(maps); i++) {
        const pm_json *map = pm_json_at(maps, i);
        char photons[24], paths[24];
        snprintf(photons, sizeof photons, "%" PRId64, pm_json_get_integer(map, "photons", 0));
        snprintf(paths, sizeof paths, "%" PRId64, pm_json_get_integer(map, "paths", 0));
        fprintf(to, format, pm_json_get_text(map, "key", "?"),
                pm_json_get_text(map, "kind", "?"), photons, paths);
    }
}

/* ---- jobs ---- */

void pm_describe_jobs(const pm_json *jobs, bool heading, FILE *to)
{
    static const char format[] = "%-8s  %-9s  %-6s  %-24s  %-24s  %.16s\n";
    if (heading)
        fprintf(to, format, "ID", "STATE", "KIND", "CREATED", "FINISHED", "SCENE");
    for (size_t i = 0; i < pm_json_length(jobs); i++) {
        const pm_json *job = pm_json_at(jobs, i);
        fprintf(to, format, pm_json_get_text(job, "id", "?"),
                pm_json_get_text(job, "state", "?"), pm_json_get_text(job, "kind", "?"),
                pm_json_get_text(job, "created", "-"), pm_json_get_text(job, "finished", "-"),
                pm_json_get_text(job, "scene", "-"));
    }
}

static void print_error(double error, FILE *to)
{
    if (isfinite(error))
        fprintf(to, "%.3g %%", 100 * error);
    else
        fputs("not known yet", to);
}

static void print_progress(const pm_json *progress, FILE *to)
{
    if (pm_json_type_of(progress) != PM_JSON_OBJECT)
        return;
    fprintf(to, "%-13s %s, %.0f %%, pass %" PRId64 ", error ", "progress",
            pm_json_get_text(progress, "stage", "waiting"),
            100 * pm_json_get_number(progress, "done", 0),
            pm_json_get_integer(progress, "passes", 0));
    print_error(pm_json_get_number(progress, "error", INFINITY), to);
    fprintf(to, ", %.2f CPU s, %.2f s\n", pm_json_get_number(progress, "cpu_seconds", 0),
            pm_json_get_number(progress, "wall_seconds", 0));
}

static void print_problem(const pm_json *problem, FILE *to)
{
    const char *file = pm_json_get_text(problem, "file", "");
    if (pm_json_type_of(problem) != PM_JSON_OBJECT)
        return;
    fprintf(to, "%-13s ", "problem");
    if (*file)
        fprintf(to, "%s:%" PRId64 ":%" PRId64 ": ", file,
                pm_json_get_integer(problem, "line", 0),
                pm_json_get_integer(problem, "column", 0));
    fprintf(to, "%s\n",
            pm_json_get_text(problem, "detail", pm_json_get_text(problem, "title", "")));
}

static void print_job_maps(const pm_json *maps, FILE *to)
{
    for (size_t i = 0; i < pm_json_length(maps); i++) {
        const pm_json *map = pm_json_at(maps, i);
        const char *key = pm_json_get_text(map, "key", NULL);
        fprintf(to, "%-13s %s: %" PRId64 " photons of %" PRId64 " paths", i ? "" : "maps",
                pm_json_get_text(map, "kind", "?"), pm_json_get_integer(map, "photons", 0),
                pm_json_get_integer(map, "paths", 0));
        if (key)
            fprintf(to, ", cache %s, key %s", pm_json_get_text(map, "cache", "none"), key);
        fputc('\n', to);
    }
}

static double sum(const pm_json *color)
{
    double total = 0;
    for (size_t i = 0; i < pm_json_length(color); i++)
        total += pm_json_number(pm_json_at(color, i));
    return total;
}

/* Where the photons' light went. */
static void print_balance(const pm_json *balance, FILE *to)
{
    double emitted = sum(pm_json_get(balance, "emitted"));
    if (emitted > 0)
        fprintf(to, "%-13s %.4g %% absorbed, %.4g %% escaped\n", "photons' light",
                100 * sum(pm_json_get(balance, "absorbed")) / emitted,
                100 * sum(pm_json_get(balance, "escaped")) / emitted);
}

static void print_curve(const pm_json *curve, FILE *to)
{
    if (pm_json_length(curve))
        fprintf(to, "%-13s %8s  %9s  %9s  %s\n", "curve", "passes", "CPU s", "wall s",
                "estimated relative error");
    for (size_t i = 0; i < pm_json_length(curve); i++) {
        const pm_json *at = pm_json_at(curve, i);
        fprintf(to, "%-13s %8" PRId64 "  %9.3f  %9.3f  ", "",
                pm_json_get_integer(at, "passes", 0), pm_json_get_number(at, "cpu_seconds", 0),
                pm_json_get_number(at, "wall_seconds", 0));
        print_error(pm_json_get_number(at, "error", INFINITY), to);
        fputc('\n', to);
    }
}

static void print_results(const pm_json *results, FILE *to)
{
    for (size_t i = 0; i < pm_json_length(results); i++) {
        const pm_json *result = pm_json_at(results, i);
        fprintf(to, "%-13s %s  %" PRId64 " bytes  %s\n", i ? "" : "results",
                pm_json_get_text(result, "name", "?"), pm_json_get_integer(result, "size", 0),
                pm_json_get_bool(result, "evicted", false)
                    ? "(evicted)"
                    : pm_json_get_text(result, "url", ""));
    }
}

void pm_describe_job(const pm_json *job, FILE *to)
{
    const pm_json *world = pm_json_get(job, "world");
    print_text(to, "job", job, "id");
    print_text(to, "kind", job, "kind");
    print_text(to, "state", job, "state");
    print_problem(pm_json_get(job, "problem"), to);
    print_progress(pm_json_get(job, "progress"), to);
    print_text(to, "command", pm_json_get(job, "request"), "command");
    print_text(to, "scene", job, "scene");
    print_text(to, "created", job, "created");
    print_text(to, "started", job, "started");
    print_text(to, "finished", job, "finished");
    if (world)
        print_world(world, to);
    print_plan(pm_json_get(job, "plan"), to);
    print_text(to, "cache", job, "cache");
    print_job_maps(pm_json_get(job, "maps"), to);
    print_balance(pm_json_get(job, "balance"), to);
    print_curve(pm_json_get(job, "curve"), to);
    print_results(pm_json_get(job, "result"), to);
}
