#include "scene/expand.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A `!` line that is being carried out. */
struct expansion {
    pm_parser *parser;
    const pm_frame *frame;
    const pm_pipeline *pipeline;
    const pm_generate_request *request; /* of a generator */
    const char *text_name;              /* of its text, as if that were a file */
    struct kept *kept;
};

/* A generator's text, if it came in one piece, for the instances of an array. */
struct kept {
    pm_bytes text;
    size_t pieces; /* of the run; 1: `text` is all */
};

/* One of those that an xform makes. */
struct copy {
    const pm_xform *xform;
    const pm_word *program;
    uint64_t instance;
};

static bool is_usable(const pm_transform *t)
{
    bool finite = isfinite(t->shift[0]) && isfinite(t->shift[1]) && isfinite(t->shift[2]);
    return finite && isnormal(t->scale) && isnormal(1 / t->scale);
}

static pm_status name_frame(const struct expansion *e, const struct copy *copy,
                            const pm_frame *frame, pm_frame *inner)
{
    const pm_xform *xform = copy->xform;
    pm_arena arena = {0};
    char *prefix = pm_arena_alloc(&arena, pm_xform_prefix_size(xform));
    pm_status st = PM_OK;
    if (prefix) {
        pm_xform_instance_prefix(xform, copy->instance, prefix);
        if (strlen(frame->prefix) + strlen(prefix) >= PM_PREFIX_MOST)
            st = pm_word_error(copy->program, PM_E_LIMIT, e->pipeline->file, e->parser->err,
                               "-n makes names longer than %d bytes; write a shorter one",
                               PM_PREFIX_MOST);
        else
            inner->prefix = pm_parser_name(e->parser, frame->prefix, prefix, strlen(prefix));
    }
    pm_arena_clear(&arena);
    return st || inner->prefix ? st : pm_parser_memory_error(e->parser);
}

/* What one instance of an xform makes of the frame in which its text is read. */
static pm_status make_frame(const struct expansion *e, const struct copy *copy,
                            const pm_frame *frame, pm_frame *inner)
{
    const pm_xform *xform = copy->xform;
    const pm_transform own = pm_xform_instance(xform, copy->instance);
    *inner = (pm_frame){.transform = pm_transform_then(&own, &frame->transform),
                        .moved = true,
                        .inverted = frame->inverted != xform->invert,
                        .modifier = frame->modifier,
                        .modifier_file = frame->modifier_file,
                        .depth = frame->depth};
    if (!inner->modifier && xform->modifier) {
        inner->modifier = xform->modifier;
        inner->modifier_file = e->pipeline->file;
    }
    if (!is_usable(&inner->transform))
        return pm_word_error(
            copy->program, PM_E_RANGE, e->pipeline->file, e->parser->err,
            "the transforms together leave the range of doubles; scale or move less");
    return name_frame(e, copy, frame, inner);
}

/* ---- where the text comes from ---- */

static pm_status read_files(const struct expansion *e, const pm_frame *frame)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < e->pipeline->file_count; i++) {
        pm_frame inner = *frame;
        inner.file =
            pm_bundle_find(e->parser->bundle, e->pipeline->files[i].text, e->pipeline->file);
        inner.depth = frame->depth + 1;
        st = pm_parser_file(e->parser, &inner);
    }
    return st;
}

/* A generator's text on its way to the parser. */
struct reading {
    const struct expansion *e;
    const pm_frame *frame;
    pm_file file; /* that the text seems to be */
};

/* Errors in the text are told as the command's, but those about words of the line itself, such
 * as -m's, have their place. */
static pm_status place_error(const struct reading *r, pm_error *err, const pm_error *why)
{
    const pm_pipeline *p = r->e->pipeline;
    if (why->file[0] && strcmp(why->file, r->file.name) != 0)
        return pm_error_set_at(err, why->status, why->file, why->line, why->column, "%s",
                               why->text);
    return pm_word_error(p->start, why->status, p->file, err, "%s: %s", p->start->text,
                         why->text);
}

static pm_status read_text(void *context, const void *text, size_t size)
{
    struct reading *r = context;
    pm_parser *parser = r->e->parser;
    pm_error *err = parser->err, why = PM_ERROR_INIT;
    pm_frame inner = *r->frame;
    r->file.data = text;
    r->file.size = size;
    inner.file = &r->file;
    inner.depth = r->frame->depth + 1;
    inner.origin = r->e->frame->origin ? r->e->frame->origin : r->e->frame->file;
    inner.place = r->e->pipeline->start;
    parser->err = &why;
    pm_status st = pm_parser_file(parser, &inner);
    parser->err = err;
    if (st == PM_E_MEMORY && !why.file[0])
        return pm_error_set(err, st, "%s", why.text);
    return st ? place_error(r, err, &why) : PM_OK;
}

static pm_status take_text(void *context, const void *text, size_t size)
{
    struct reading *r = context;
    struct kept *kept = r->e->kept;
    if (kept->pieces++ == 0 && r->e->pipeline->instances > 1)
        pm_bytes_append(&kept->text, text, size);
    else
        pm_bytes_clear(&kept->text);
    return pm_bytes_status(&kept->text) ? pm_parser_memory_error(r->e->parser)
                                        : read_text(r, text, size);
}

static pm_status run_generator(const struct expansion *e, const pm_frame *frame)
{
    size_t wrong = 0;
    pm_error why = PM_ERROR_INIT;
    struct reading r = {.e = e, .frame = frame, .file = {.name = e->text_name}};
    if (e->kept->pieces == 1)
        return read_text(&r, e->kept->text.data, e->kept->text.size);
    e->kept->pieces = 0;
    pm_status st = pm_generate_run(e->request, take_text, &r, &wrong, &why);
    if (why.status)
        return pm_parser_generate_error(e->pipeline, wrong, &why, e->parser->err);
    return st;
}

/* ---- stages ---- */

/* Reads the text as it comes out of the first `stages` xforms: those behind are in the frame.
 * PM_PIPELINE_STAGES deep at most. */
static pm_status expand(const struct expansion *e, const pm_frame *frame, size_t stages)
{
    if (!stages)
        return e->request ? run_generator(e, frame) : read_files(e, frame);
    const struct pm_pipeline_xform *xform = &e->pipeline->xforms[stages - 1];
    pm_status st = PM_OK;
    for (size_t k = 0; !st && k < xform->copy_count; k++) {
        struct copy copy = {&xform->copies[k], xform->program, 0};
        for (; !st && copy.instance < copy.xform->instances; copy.instance++) {
            pm_frame inner;
            st = make_frame(e, &copy, frame, &inner);
            if (!st)
                st = expand(e, &inner, stages - 1);
        }
    }
    return st;
}

/* Files that the text names are looked for beside the file of the command, so its own name is
 * of the same folder. */
static const char *name_text(const pm_pipeline *pipeline, pm_arena *arena)
{
    const char *from = pipeline->file, *slash = strrchr(from, '/');
    int folder = slash ? (int)(slash - from) + 1 : 0;
    size_t size = (size_t)folder + pipeline->start->length + 2;
    char *name = pm_arena_alloc(arena, size);
    if (name)
        snprintf(name, size, "%.*s!%s", folder, from, pipeline->start->text);
    return name;
}

pm_status pm_parser_expand(pm_parser *parser, const pm_frame *frame, pm_lexer *lexer)
{
    pm_arena arena = {0};
    pm_pipeline pipeline;
    pm_generate_request request;
    struct kept kept = {0};
    struct expansion e = {
        .parser = parser, .frame = frame, .pipeline = &pipeline, .kept = &kept};
    pm_status st = pm_pipeline_read(lexer, parser->bundle, &arena, &pipeline, parser->err);
    if (!st)
        st = pm_parser_check_size(parser, frame->depth, &pipeline, &arena);
    if (!st && pipeline.generator) {
        st = pm_parser_request(parser, &pipeline, &arena, &request);
        e.request = &request;
        e.text_name = name_text(&pipeline, &arena);
        if (!st && !e.text_name)
            st = pm_parser_memory_error(parser);
    }
    if (!st)
        st = expand(&e, frame, pipeline.xform_count);
    pm_bytes_clear(&kept.text);
    pm_arena_clear(&arena);
    return st;
}
