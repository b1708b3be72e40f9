#include "verbs.h"

#include <string.h>
#include <unistd.h>

#include "job_request.h"
#include "output.h"
#include "progress.h"
#include "session.h"

static pm_status check_file(const pm_options *options, int kind, pm_error *err)
{
    const char *path = options->maps[kind].file;
    for (int other = 0; other < kind; other++)
        if (options->maps[other].given && !strcmp(options->maps[other].file, path))
            return pm_error_set(err, PM_E_RANGE, "%s: is named for two maps; give each its own",
                                path);
    if (!options->overwrite && !access(path, F_OK))
        return pm_error_set_at(err, PM_E_RANGE, path, 0, 0,
                               "exists already; -fo overwrites it");
    return pm_output_check(path, err);
}

pm_status pm_check_mkpmap(const pm_options *options, pm_error *err)
{
    bool any = false;
    pm_status st = PM_OK;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        any = any || options->maps[kind].given;
        if (options->maps[kind].given)
            st = check_file(options, kind, err);
    }
    if (!st && !any)
        st = pm_error_set(err, PM_E_MISSING,
                          "no map asked for: -apg, -apc, -apv or -apd FILE N, -app FILE N BW, "
                          "e.g. -apg scene.gpm 100k");
    return st;
}

static const pm_json *find_named(const pm_json *list, const char *member, const char *name)
{
    for (size_t i = 0; i < pm_json_length(list); i++)
        if (!strcmp(pm_json_get_text(pm_json_at(list, i), member, ""), name))
            return pm_json_at(list, i);
    return NULL;
}

static void print_map(const pm_options *options, const char *path, const pm_json *map)
{
    const char *note = pm_json_get_text(map, "note", "");
    if (options->quiet)
        return;
    if (*note)
        fprintf(stderr, "%s: %s\n", path, note);
    size_t passes = pm_json_length(pm_json_get(map, "passes"));
    fprintf(stderr, "wrote %s: ", path);
    if (passes)
        fprintf(stderr, "%zu passes, ", passes);
    fprintf(stderr, "%lld photons from %lld paths\n",
            (long long)pm_json_get_integer(map, "photons", 0),
            (long long)pm_json_get_integer(map, "paths", 0));
}

static pm_status fetch_maps(pm_session *session, const pm_options *options, const pm_json *job,
                            pm_error *err)
{
    pm_status st = PM_OK;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++) {
        const pm_map_option *map = &options->maps[kind];
        const char *name = pm_map_kind_name(map->precomputed ? PM_MAP_PRECOMPUTED
                                                             : (pm_map_kind)kind),
                   *path = map->file;
        if (!options->maps[kind].given)
            continue;
        const pm_json *result = find_named(pm_json_get(job, "result"), "name", name);
        if (!result)
            return pm_error_set(err, PM_E_MISSING, "the server gave no %s map", name);
        st = pm_session_fetch(session, pm_json_get_text(result, "url", ""), path, err);
        if (!st)
            print_map(options, path, find_named(pm_json_get(job, "maps"), "kind", name));
    }
    return st;
}

static pm_status run(pm_session *session, const pm_options *options, pm_error *err)
{
    pm_json *scene = NULL, *job = NULL;
    pm_attachments attachments = {0};
    pm_status st = pm_session_scene(session, options->operands[0], &scene, err);
    if (!st) {
        attachments.scene = pm_json_get_text(scene, "id", "");
        st = pm_session_run(session,
                            pm_job_request(options, "map", &attachments, 0, pm_command_line),
                            &job, err);
    }
    if (!st) {
        pm_summary_print(options, job);
        st = fetch_maps(session, options, job, err);
    }
    pm_json_free(job);
    pm_json_free(scene);
    return st;
}

pm_status pm_verb_mkpmap(const pm_options *options, pm_error *err)
{
    pm_session *session = NULL;
    pm_status st = pm_session_open(options, &session, err);
    if (!st)
        st = run(session, options, err);
    pm_session_close(session);
    return st;
}
