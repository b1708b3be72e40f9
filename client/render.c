#include "verbs.h"

#include <string.h>
#include <unistd.h>

#include "job_request.h"
#include "map_files.h"
#include "output.h"
#include "progress.h"
#include "session.h"

/* Where pictures go: the -o files, or for rpict standard output. */
static pm_status check_outputs(const pm_options *options, pm_error *err)
{
    if (!options->output_count)
        return pm_error_set(err, PM_E_MISSING,
                            "-o is missing: where to write the picture, e.g. -o picture.exr");
    pm_status st = PM_OK;
    for (unsigned i = 0; i < options->output_count && !st; i++) {
        const char *path = options->outputs[i];
        st = pm_format_of(path)
                 ? pm_output_check(path, err)
                 : pm_error_set(err, PM_E_RANGE,
                                "-o %s: the name must end in .exr, .hdr or .png", path);
    }
    return st;
}

pm_status pm_check_render(const pm_options *options, pm_error *err)
{
    pm_status st = pm_view_check(&options->view, err);
    if (st)
        return st;
    if (options->verb == PM_VERB_RENDER)
        return check_outputs(options, err);
    if (isatty(STDOUT_FILENO))
        return pm_error_set(err, PM_E_RANGE,
                            "rpict writes a Radiance picture to standard output, which is a "
                            "terminal: add `> picture.hdr`");
    return PM_OK;
}

static unsigned wanted_formats(const pm_options *options)
{
    unsigned formats = options->verb == PM_VERB_RPICT ? PM_WANT_HDR : 0;
    for (unsigned i = 0; i < options->output_count; i++)
        formats |= pm_format_of(options->outputs[i]);
    return formats;
}

static const char *result_url(const pm_json *job, const char *format)
{
    const pm_json *results = pm_json_get(job, "result");
    for (size_t i = 0; i < pm_json_length(results); i++) {
        const pm_json *result = pm_json_at(results, i);
        if (!strcmp(pm_json_get_text(result, "format", ""), format))
            return pm_json_get_text(result, "url", NULL);
    }
    return NULL;
}

static pm_status fetch_picture(pm_session *session, const pm_json *job, const char *format,
                               const char *path, pm_error *err)
{
    const char *url = result_url(job, format);
    if (!url)
        return pm_error_set(err, PM_E_MISSING, "the server gave no %s picture", format);
    return pm_session_fetch(session, url, path, err);
}

static pm_status fetch_pictures(pm_session *session, const pm_options *options,
                                const pm_json *job, pm_error *err)
{
    if (options->verb == PM_VERB_RPICT)
        return fetch_picture(session, job, "hdr", "-", err);
    pm_status st = PM_OK;
    for (unsigned i = 0; i < options->output_count && !st; i++) {
        const char *path = options->outputs[i];
        st = fetch_picture(session, job, pm_format_word(pm_format_of(path)), path, err);
        if (!st && !options->quiet)
            fprintf(stderr, "wrote %s\n", path);
    }
    return st;
}

static pm_status run(pm_session *session, const pm_options *options, pm_error *err)
{
    unsigned formats = wanted_formats(options);
    pm_json *scene = NULL, *job = NULL;
    pm_attachments attachments = {0};
    pm_status st = pm_session_scene(session, options->operands[0], &scene, err);
    if (!st)
        st = pm_map_files_attach(session, options, &attachments, err);
    if (!st) {
        attachments.scene = pm_json_get_text(scene, "id", "");
        st = pm_session_run(
            session, pm_job_request(options, "render", &attachments, formats, pm_command_line),
            &job, err);
    }
    if (!st) {
        pm_summary_print(options, job);
        st = fetch_pictures(session, options, job, err);
    }
    pm_json_free(job);
    pm_json_free(scene);
    return st;
}

pm_status pm_verb_render(const pm_options *options, pm_error *err)
{
    pm_session *session = NULL;
    pm_status st = pm_session_open(options, &session, err);
    if (!st)
        st = run(session, options, err);
    pm_session_close(session);
    return st;
}
