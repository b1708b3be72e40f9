#include "verbs.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "columns.h"
#include "job_request.h"
#include "map_files.h"
#include "progress.h"
#include "session.h"

pm_status pm_check_trace(const pm_options *options, pm_error *err)
{
    if (!strcmp(options->operands[0], "-"))
        return pm_error_set(err, PM_E_RANGE,
                            "-: standard input brings the points, so the scene must be a file");
    if (!options->x != !options->y)
        return pm_error_set(
            err, PM_E_MISSING,
            "-x and -y belong together: the size of the picture that the values "
            "are; values come when all are done, so there is no flushing to set");
    if (options->output_format != 'a' && strpbrk(options->fields, "smM"))
        return pm_error_set(err, PM_E_RANGE,
                            "-o%s: names are text; print them with -faa, -ffa or -fda",
                            options->fields);
    if (options->output_format == 'c' && (strcmp(options->fields, "v") != 0 || options->errors))
        return pm_error_set(err, PM_E_RANGE,
                            "-f%cc: pixels hold values alone; leave out -o%s and --errors",
                            options->input_format, options->fields);
    return PM_OK;
}

/* The header that rtrace writes before its values, but for the time of day: the same command
 * gives the same bytes. */
static void print_header(const pm_options *options)
{
    printf("#?RADIANCE\n%s\nSOFTWARE= pm " PM_VERSION "\n", pm_command_line);
    if (options->output_format != 'c')
        printf("NCOMP=%d\n", pm_values_numbers(options));
    if (strchr("fd", options->output_format))
        printf("BigEndian=0\n");
    printf("FORMAT=%s\n\n", pm_number_format_name(options->output_format));
}

static pm_status print_values(const pm_options *options, pm_bytes *text, pm_error *err)
{
    pm_status st = pm_values_check(options, text, err);
    if (st)
        return st;
    if (options->verb == PM_VERB_RTRACE && !options->no_header)
        print_header(options);
    if (options->x)
        printf("-Y %u +X %u\n", options->y, options->x);
    st = pm_values_print(options, text, stdout, err);
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
    pm_status st = pm_points_read(stdin, options->input_format, &points, err);
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
