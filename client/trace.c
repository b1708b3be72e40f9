#include "verbs.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "job_request.h"
#include "map_files.h"
#include "progress.h"
#include "session.h"

pm_status pm_check_trace(const pm_options *options, pm_error *err)
{
    if (strcmp(options->operands[0], "-") != 0)
        return PM_OK;
    return pm_error_set(err, PM_E_RANGE,
                        "-: standard input brings the points, so the scene must be a file");
}

static pm_status read_points(pm_bytes *points, pm_error *err)
{
    char buffer[1 << 16];
    for (size_t got; (got = fread(buffer, 1, sizeof buffer, stdin)) > 0;)
        pm_bytes_append(points, buffer, got);
    if (ferror(stdin))
        return pm_error_set_at(err, PM_E_IO, "standard input", 0, 0, "cannot be read: %s",
                               strerror(errno));
    return pm_bytes_status(points)
               ? pm_error_set(err, PM_E_MEMORY, "no memory for the points of stdin")
               : PM_OK;
}

/* The header that rtrace writes before its values, but for the time of day: the same command
 * gives the same bytes. */
static void print_header(void)
{
    printf("#?RADIANCE\n%s\nSOFTWARE= pm " PM_VERSION "\nNCOMP=3\nFORMAT=ascii\n\n",
           pm_command_line);
}

/* A line of the answer holds r g b and their half-widths. */
static pm_status print_line(const pm_options *options, const char *line, pm_error *err)
{
    double v[6];
    char *end = NULL;
    unsigned columns = options->errors ? 6 : 3;
    for (unsigned i = 0; i < 6; i++) {
        v[i] = strtod(line, &end);
        if (end == line)
            return pm_error_set(err, PM_E_CORRUPT, "the server's answer is no list of values");
        line = end;
    }
    for (unsigned i = 0; i < columns; i++) {
        if (options->verb == PM_VERB_RTRACE)
            printf("%e\t", v[i]);
        else
            printf("%s%.9g", i ? " " : "", v[i]);
    }
    putchar('\n');
    return PM_OK;
}

static pm_status print_values(const pm_options *options, pm_bytes *text, pm_error *err)
{
    pm_status st = PM_OK;
    pm_bytes_u8(text, 0);
    if (pm_bytes_status(text))
        return pm_error_set(err, PM_E_MEMORY, "no memory for the values");
    if (options->verb == PM_VERB_RTRACE && !options->no_header)
        print_header();
    for (char *line = strtok((char *)text->data, "\n"); line && !st; line = strtok(NULL, "\n"))
        st = print_line(options, line, err);
    if (!st && (fflush(stdout) || ferror(stdout)))
        st = pm_error_set_at(err, PM_E_IO, "standard output", 0, 0, "cannot be written: %s",
                             strerror(errno));
    return st;
}

static pm_status run(pm_session *session, const pm_options *options, const pm_bytes *points,
                     pm_bytes *values, pm_error *err)
{
    pm_json *scene = NULL, *job = NULL;
    pm_attachments attachments = {.has_points = true};
    pm_status st = pm_session_scene(session, options->operands[0], &scene, err);
    if (!st)
        st = pm_session_upload(session, points->data, points->size, &attachments.points, err);
    if (!st)
        st = pm_map_files_attach(session, options, &attachments, err);
    if (!st) {
        attachments.scene = pm_json_get_text(scene, "id", "");
        st = pm_session_run(session,
                            pm_job_request(options, "trace", &attachments, 0, pm_command_line),
                            &job, err);
    }
    if (!st) {
        pm_summary_print(options, job);
        const pm_json *result = pm_json_at(pm_json_get(job, "result"), 0);
        st = pm_session_read(session, pm_json_get_text(result, "url", ""), values, err);
    }
    pm_json_free(job);
    pm_json_free(scene);
    return st;
}

pm_status pm_verb_trace(const pm_options *options, pm_error *err)
{
    pm_session *session = NULL;
    pm_bytes points = {0}, values = {0};
    pm_status st = read_points(&points, err);
    if (!st)
        st = pm_session_open(options, &session, err);
    if (!st)
        st = run(session, options, &points, &values, err);
    if (!st)
        st = print_values(options, &values, err);
    pm_session_close(session);
    pm_bytes_clear(&points);
    pm_bytes_clear(&values);
    return st;
}
