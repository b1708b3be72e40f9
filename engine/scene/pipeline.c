#include "scene/pipeline.h"

#include <string.h>

#include "scene/xform_list.h"

struct reader {
    const pm_commands *commands;
    pm_arena *arena;
    pm_error *err;
    pm_pipeline *pipeline;
    const pm_bundle *bundle;
    struct pm_pipeline_xform *xforms;
};

#define EXPAND                                                                                 \
    "put its output in place of this line, or expand the scene beforehand with Radiance's "    \
    "\"xform scene.rad > expanded.rad\""

static pm_status unknown_program(const struct reader *r, const pm_command *stage, bool first)
{
    const pm_word *program = &stage->words[0];
    if (!first && pm_generate_knows(program->text))
        return pm_word_error(program, PM_E_SYNTAX, stage->file, r->err,
                             "'%.*s' reads no text from a pipe; put it on a line of its own",
                             PM_WORD_SHOW(*program));
    if (!first)
        return pm_word_error(
            program, PM_E_UNSUPPORTED, stage->file, r->err,
            "'%.*s' is not run here, only xform and cat are behind a '|'; " EXPAND,
            PM_WORD_SHOW(*program));
    return pm_word_error(program, PM_E_UNSUPPORTED, stage->file, r->err,
                         "'%.*s' is not run here, only %s, xform and cat are; " EXPAND,
                         PM_WORD_SHOW(*program), pm_generate_programs());
}

/* Files belong to the first stage, which has nothing else to read. */
static pm_status take_files(struct reader *r, const pm_command *stage, const pm_word *files,
                            size_t count, bool first)
{
    if (first && !count)
        return pm_word_error(&stage->words[0], PM_E_SYNTAX, stage->file, r->err,
                             "this %s names no file, and there is no standard input to read; "
                             "write the file's name at the end",
                             stage->words[0].text);
    if (!first && count)
        return pm_word_error(
            &files[0], PM_E_SYNTAX, stage->file, r->err,
            "'%.*s' would be read instead of what comes through the pipe; take "
            "out the file, or what stands before the '|'",
            PM_WORD_SHOW(files[0]));
    if (first) {
        r->pipeline->files = files;
        r->pipeline->file_count = count;
    }
    return PM_OK;
}

static pm_status read_cat(struct reader *r, const pm_command *stage, bool first)
{
    for (size_t i = 1; i < stage->count; i++)
        if (stage->words[i].text[0] == '-')
            return pm_word_error(&stage->words[i], PM_E_UNSUPPORTED, stage->file, r->err,
                                 "cat takes nothing but files here; take out '%.*s'",
                                 PM_WORD_SHOW(stage->words[i]));
    return take_files(r, stage, stage->words + 1, stage->count - 1, first);
}

/* The copies that the lines of -f's file make. */
static pm_status read_list(struct reader *r, const pm_command *stage,
                           struct pm_pipeline_xform *out)
{
    const pm_file *file = pm_bundle_find(r->bundle, out->list->text, stage->file);
    if (!file)
        return pm_word_error(out->list, PM_E_MISSING, stage->file, r->err,
                             "there is no file '%.*s', neither beside this one nor beside the "
                             "main file",
                             PM_WORD_SHOW(*out->list));
    return pm_xform_list_parse(stage, out->copies, file->data, file->size, r->arena,
                               &out->copies, &out->copy_count, r->err);
}

static uint64_t count_instances(const struct pm_pipeline_xform *xform)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < xform->copy_count; i++)
        if (__builtin_add_overflow(sum, xform->copies[i].instances, &sum))
            return UINT64_MAX;
    return sum;
}

static pm_status read_xform(struct reader *r, const pm_command *stage, bool first)
{
    pm_pipeline *p = r->pipeline;
    struct pm_pipeline_xform *out = &r->xforms[p->xform_count];
    pm_xform *xform = pm_arena_alloc(r->arena, sizeof *xform);
    if (!xform)
        return pm_error_set(r->err, PM_E_MEMORY,
                            "not enough memory for a command of the scene");
    pm_status st = pm_xform_parse(stage, r->arena, xform, r->err);
    if (!st)
        st = take_files(r, stage, xform->files, xform->file_count, first);
    *out = (struct pm_pipeline_xform){&stage->words[0], xform, 1, 0, xform->list};
    if (!st && out->list && r->bundle)
        st = read_list(r, stage, out);
    if (st)
        return st;
    p->xform_count++;
    out->instances = count_instances(out);
    if (__builtin_mul_overflow(p->instances, out->instances, &p->instances))
        p->instances = UINT64_MAX;
    return PM_OK;
}

static pm_status read_stage(struct reader *r, size_t index)
{
    const pm_command *stage = &r->commands->stages[index];
    const pm_word *program = &stage->words[0];
    if (pm_word_is(program, "xform"))
        return read_xform(r, stage, index == 0);
    if (pm_word_is(program, "cat"))
        return read_cat(r, stage, index == 0);
    if (index > 0 || !pm_generate_knows(program->text))
        return unknown_program(r, stage, index == 0);
    r->pipeline->generator = stage;
    return PM_OK;
}

pm_status pm_pipeline_read(pm_lexer *lexer, const pm_bundle *bundle, pm_arena *arena,
                           pm_pipeline *out, pm_error *err)
{
    pm_commands commands;
    pm_status st = pm_commands_read(lexer, arena, &commands, err);
    if (st)
        return st;
    const pm_word *start = &commands.stages[0].words[0];
    if (commands.count > PM_PIPELINE_STAGES)
        return pm_word_error(
            &commands.stages[PM_PIPELINE_STAGES].words[0], PM_E_LIMIT, lexer->file, err,
            "more than %d commands are joined by '|' here; join fewer", PM_PIPELINE_STAGES);
    pm_pipeline pipeline = {.file = lexer->file, .start = start, .instances = 1};
    struct reader r = {.commands = &commands,
                       .arena = arena,
                       .err = err,
                       .pipeline = &pipeline,
                       .bundle = bundle};
    pipeline.xforms = r.xforms = pm_arena_array(arena, commands.count, sizeof *r.xforms);
    if (!r.xforms)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for a command of the scene");
    for (size_t i = 0; !st && i < commands.count; i++)
        st = read_stage(&r, i);
    if (!st)
        *out = pipeline;
    return st;
}

pm_generate_request pm_pipeline_request(const pm_pipeline *pipeline, const char **words)
{
    for (size_t i = 0; i < pipeline->generator->count; i++)
        words[i] = pipeline->generator->words[i].text;
    return (pm_generate_request){.words = words, .count = pipeline->generator->count};
}
