#ifndef PM_SCENE_PIPELINE_H
#define PM_SCENE_PIPELINE_H

#include "generate/generate.h"
#include "scene/bundle.h"
#include "scene/xform.h"

/* One xform of a pipeline. */
struct pm_pipeline_xform {
    const pm_word *program;
    const pm_xform *copies; /* one, or with -f one for each line of its file; their files are
                               the pipeline's */
    size_t copy_count;
    uint64_t instances;  /* of all; UINT64_MAX if larger */
    const pm_word *list; /* -f's file, or NULL */
};

/* A `!` line understood: where its text comes from, and the xforms that it passes through.
 *   !xform -t 1 0 0 desk.rad lamp.rad
 *   !cat desk.rad | xform -rz 90
 *   !genbox wood box 1 1 1 | xform -t 0 0 2 | xform -n row -a 10 -t 1.5 0 0 */
typedef struct pm_pipeline {
    const char *file; /* that it stands in */
    /* Either a generator's words, or files that are there to be read. */
    const pm_command *generator; /* NULL for files */
    const pm_word *files;
    size_t file_count;
    const struct pm_pipeline_xform *xforms; /* in the order of the line */
    size_t xform_count;
    const pm_word *start; /* the line's first word */
    uint64_t instances;   /* product over the xforms; UINT64_MAX if larger */
} pm_pipeline;

/* Reads what follows the '!'. Errors of pm_commands_read and pm_xform_parse; PM_E_UNSUPPORTED
 * for programs that are not offered, PM_E_LIMIT beyond PM_PIPELINE_STAGES. A generator's
 * arguments are not looked at.
 *   bundle  where files of -f are; NULL: they are not read, but named in `list` */
enum { PM_PIPELINE_STAGES = 16 };
PM_MUST_USE pm_status pm_pipeline_read(pm_lexer *lexer, const pm_bundle *bundle,
                                       pm_arena *arena, pm_pipeline *out, pm_error *err);

/* The generator's words and files, for pm_generate_measure and pm_generate_run. `words` has
 * room for the generator's count. */
pm_generate_request pm_pipeline_request(const pm_pipeline *pipeline, const char **words);

#endif
