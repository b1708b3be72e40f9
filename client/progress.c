#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "forward/photon.h"

enum { BAR_CELLS = 30 };

void pm_progress_display_init(pm_progress_display *display, const pm_options *options)
{
    bool terminal = isatty(STDERR_FILENO) == 1;
    *display = (pm_progress_display){.bar = terminal && !options->quiet &&
                                            !(options->progress_seconds > 0),
                                     .interval = options->progress_seconds};
    if (!display->bar && options->verbose && !(display->interval > 0))
        display->interval = 1;
}

/* "forward pass  1.2 M photons of 3.4 M paths" */
static void describe(const pm_json *progress, char *out, size_t size)
{
    const char *stage = pm_json_get_text(progress, "stage", "waiting");
    double photons = 0;
    const pm_json *kinds = pm_json_get(progress, "photons");
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        photons += pm_json_get_number(kinds, pm_map_kind_name((pm_map_kind)kind), 0);
    double paths = pm_json_get_number(progress, "paths", 0);
    double error = pm_json_get_number(progress, "error", INFINITY);
    long passes = (long)pm_json_get_integer(progress, "passes", 0);
    if (!strcmp(stage, "forward"))
        snprintf(out, size, "forward pass: %.0f photons of %.0f paths", photons, paths);
    else if (!strcmp(stage, "backward") && isfinite(error))
        snprintf(out, size, "pass %ld, error about %.2g %%", passes, 100 * error);
    else if (!strcmp(stage, "backward"))
        snprintf(out, size, "pass %ld", passes);
    else
        snprintf(out, size, "%s", stage);
}

static void draw_bar(pm_progress_display *display, const char *text, double done,
                     double seconds)
{
    char cells[BAR_CELLS + 1];
    int full = (int)(BAR_CELLS * fmin(fmax(done, 0), 1));
    memset(cells, '.', BAR_CELLS);
    memset(cells, '#', (size_t)full);
    cells[BAR_CELLS] = '\0';
    fprintf(stderr, "\r\033[K[%s] %3.0f %%  %s  %.1f s", cells, 100 * fmin(fmax(done, 0), 1),
            text, seconds);
    fflush(stderr);
    display->drawn = true;
}

void pm_progress_display_show(pm_progress_display *display, const pm_json *job)
{
    const pm_json *progress = pm_json_get(job, "progress");
    double seconds = pm_json_get_number(progress, "wall_seconds", 0);
    double done = pm_json_get_number(progress, "done", 0);
    char text[160];
    describe(progress, text, sizeof text);
    if (display->bar) {
        draw_bar(display, text, done, seconds);
    } else if (display->interval > 0 && seconds >= display->last + display->interval) {
        display->last = seconds;
        fprintf(stderr, "%.0f s: %s, %.0f %%\n", seconds, text, 100 * done);
    }
}

void pm_progress_display_end(pm_progress_display *display)
{
    if (display->drawn)
        fprintf(stderr, "\r\033[K");
    display->drawn = false;
}

/* Of the passes that the user asked for; with no map named, of all of them. */
static void print_left_out(const pm_options *options, const pm_json *plan)
{
    bool any = false;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        any = any || options->maps[kind].given;
    for (size_t i = 0; i < pm_json_length(plan) && i < PM_MAP_KINDS; i++) {
        const pm_json *pass = pm_json_at(plan, i);
        bool looked_at = i == PM_MAP_DIRECT; /* alone, by mkpmap */
        bool asked = options->maps[i].given || (!any && !options->detected_count && !looked_at);
        if (asked && !pm_json_get_bool(pass, "needed", true))
            fprintf(stderr, "%s\n", pm_json_get_text(pass, "reason", ""));
    }
}

static double mean(const pm_json *balance, const char *name)
{
    const pm_json *color = pm_json_get(balance, name);
    double sum = 0;
    for (size_t i = 0; i < 3; i++)
        sum += pm_json_number(pm_json_at(color, i));
    return sum / 3;
}

/* What was planned and why, how many photons a path, and where the light went. */
static void print_forward(const pm_json *job)
{
    const pm_json *plan = pm_json_get(job, "plan"), *maps = pm_json_get(job, "maps");
    for (size_t i = 0; i < pm_json_length(plan); i++)
        fprintf(stderr, "%s\n", pm_json_get_text(pm_json_at(plan, i), "reason", ""));
    for (size_t i = 0; i < pm_json_length(maps); i++) {
        const pm_json *map = pm_json_at(maps, i);
        double paths = pm_json_get_number(map, "paths", 0);
        fprintf(stderr, "%s family %s: %.4g photons a path\n",
                pm_json_get_text(map, "kind", "?"), pm_json_get_text(map, "family", "?"),
                paths > 0 ? pm_json_get_number(map, "photons", 0) / paths : 0);
    }
    const pm_json *balance = pm_json_get(job, "balance");
    double emitted = mean(balance, "emitted");
    if (emitted > 0)
        fprintf(stderr, "light: %.6g W emitted, %.2f %% absorbed, %.2f %% escaped\n", emitted,
                100 * mean(balance, "absorbed") / emitted,
                100 * mean(balance, "escaped") / emitted);
}

/* Why a map fell short, and the like; mkpmap says it of each file. */
static void print_notes(const pm_json *maps)
{
    for (size_t i = 0; i < pm_json_length(maps); i++) {
        const pm_json *map = pm_json_at(maps, i);
        const char *note = pm_json_get_text(map, "note", "");
        if (*note)
            fprintf(stderr, "%s map: %s\n", pm_json_get_text(map, "kind", "?"), note);
    }
}

void pm_summary_print(const pm_options *options, const pm_json *job)
{
    if (options->quiet)
        return;
    if (options->verbose)
        print_forward(job);
    const char *cache = pm_json_get_text(job, "cache", "none");
    if (strcmp(cache, "none"))
        fprintf(stderr, "cache: %s\n", cache);
    if (options->verb != PM_VERB_MKPMAP && !options->verbose) /* mkpmap: of each file */
        print_left_out(options, pm_json_get(job, "plan"));
    if (options->verb != PM_VERB_MKPMAP)
        print_notes(pm_json_get(job, "maps"));
    const pm_json *curve = pm_json_get(job, "curve");
    size_t points = pm_json_length(curve);
    for (size_t i = options->verbose || !points ? 0 : points - 1; i < points; i++) {
        const pm_json *point = pm_json_at(curve, i);
        double error = pm_json_get_number(point, "error", INFINITY);
        fprintf(stderr, "%ld passes, %.2f CPU s, %.2f s, ",
                (long)pm_json_get_integer(point, "passes", 0),
                pm_json_get_number(point, "cpu_seconds", 0),
                pm_json_get_number(point, "wall_seconds", 0));
        if (isfinite(error))
            fprintf(stderr, "estimated relative error %.3g %%\n", 100 * error);
        else
            fprintf(stderr, "error not known yet (two passes at least)\n");
    }
}
