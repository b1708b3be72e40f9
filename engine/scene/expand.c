#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/parser.h"

/* Where a chain of files that name each other has come to; for the message about a circle. */
struct chain {
    const struct chain *parent;
    const char *file;
    const pm_word *command;
    unsigned depth;
};

static uint64_t add(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

static uint64_t multiply(uint64_t a, uint64_t b)
{
    uint64_t product;
    return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}

static pm_file_count *count_of(const pm_parser *parser, const pm_file *file)
{
    return &parser->counts[file - pm_bundle_at(parser->bundle, 0)];
}

static pm_status circle_error(pm_parser *parser, const struct chain *chain, const pm_word *name)
{
    char text[512] = "";
    for (const struct chain *c = chain; c; c = c->parent) {
        char link[300];
        snprintf(link, sizeof link, "%s%s line %d", c == chain ? "" : ", reached from ",
                 c->file, c->command->line);
        strncat(text, link, sizeof text - 1 - strlen(text));
    }
    return pm_word_error(
        name, PM_E_LIMIT, chain->file, parser->err,
        "'%.*s' would contain itself: it is named by %s; take one of these lines "
        "out",
        PM_WORD_SHOW(*name), text);
}

static pm_status nesting_error(pm_parser *parser, const char *file, const pm_word *name)
{
    return pm_word_error(name, PM_E_LIMIT, file, parser->err,
                         "files are nested more than %u deep here; join some of them",
                         parser->limits.nesting);
}

static pm_status count_file(pm_parser *parser, const struct chain *chain, const pm_file *file,
                            const pm_word *name);

/* Adds what an `!xform` line brings. *broken if the line is wrong: whoever parses it will say
 * so. */
static pm_status count_command(pm_parser *parser, const struct chain *parent,
                               const pm_file *file, pm_lexer *lexer, pm_file_count *sum,
                               bool *broken)
{
    pm_command command;
    pm_xform xform;
    pm_status st = pm_command_read(lexer, &parser->scratch, &command, NULL);
    if (!st)
        st = pm_xform_parse(&command, &parser->scratch, &xform, NULL);
    *broken = st != PM_OK;
    if (st)
        return st == PM_E_MEMORY ? pm_parser_memory_error(parser) : PM_OK;
    const struct chain chain = {parent, file->name, command.words, parent->depth + 1};
    for (size_t i = 0; i < xform.file_count; i++) {
        const pm_file *named = pm_bundle_find(parser->bundle, xform.files[i].text, file->name);
        *broken = !named;
        if (!named)
            return PM_OK;
        st = count_file(parser, &chain, named, &xform.files[i]);
        if (st)
            return st;
        const pm_file_count *once = count_of(parser, named);
        sum->primitives = add(sum->primitives, multiply(xform.instances, once->primitives));
        sum->reals = add(sum->reals, multiply(xform.instances, once->reals));
        sum->bytes = add(sum->bytes, multiply(xform.instances, once->bytes));
        if (sum->depth <= once->depth)
            sum->depth = once->depth + 1;
    }
    return PM_OK;
}

static pm_status count_statements(pm_parser *parser, const struct chain *chain,
                                  const pm_file *file, pm_file_count *sum)
{
    pm_lexer lexer;
    pm_statement statement = {.kind = PM_STATEMENT_END};
    pm_status st = pm_lexer_init(&lexer, file, parser->err);
    bool broken = false;
    while (!st && !broken) {
        size_t reals;
        broken =
            pm_statement_next(&lexer, &statement, NULL) || statement.kind == PM_STATEMENT_END;
        if (!broken && statement.kind == PM_STATEMENT_COMMAND) {
            st = count_command(parser, chain, file, &lexer, sum, &broken);
        } else if (!broken && statement.kind == PM_STATEMENT_PRIMITIVE) {
            broken = !pm_statement_skip_arguments(&lexer, &reals);
            sum->primitives = add(sum->primitives, 1);
            sum->reals = add(sum->reals, broken ? 0 : reals);
        }
    }
    return st;
}

/* Fills the file's count, once. The chain ends with the command that names it. */
static pm_status count_file(pm_parser *parser, const struct chain *chain, const pm_file *file,
                            const pm_word *name)
{
    pm_file_count *count = count_of(parser, file);
    if (count->state == PM_COUNTING)
        return circle_error(parser, chain, name);
    if (count->state == PM_UNCOUNTED) {
        if (chain->depth >= parser->limits.nesting)
            return nesting_error(parser, chain->file, name);
        pm_file_count sum = {.bytes = add(file->size, PM_FILE_COST), .depth = 1};
        count->state = PM_COUNTING;
        pm_status st = count_statements(parser, chain, file, &sum);
        if (st)
            return st;
        sum.state = PM_COUNTED;
        *count = sum;
    }
    return chain->depth + count->depth > parser->limits.nesting
               ? nesting_error(parser, chain->file, name)
               : PM_OK;
}

/* Refuses an array that is too large before anything of it is made. */
static pm_status check_size(pm_parser *parser, const pm_frame *frame, const pm_command *command,
                            const pm_xform *xform)
{
    /* Files above this one matter to the count of depth alone: a circle was found when the
     * first of them was counted. */
    const struct chain chain = {NULL, frame->file->name, command->words, frame->depth};
    pm_file_count sum = {0};
    for (size_t i = 0; i < xform->file_count; i++) {
        const pm_word *name = &xform->files[i];
        const pm_file *file = pm_bundle_find(parser->bundle, name->text, frame->file->name);
        if (!file)
            return pm_word_error(
                name, PM_E_MISSING, frame->file->name, parser->err,
                "there is no file '%.*s', neither beside this one nor beside the "
                "main file",
                PM_WORD_SHOW(*name));
        pm_status st = count_file(parser, &chain, file, name);
        if (st)
            return st;
        const pm_file_count *once = count_of(parser, file);
        sum.primitives = add(sum.primitives, multiply(xform->instances, once->primitives));
        sum.reals = add(sum.reals, multiply(xform->instances, once->reals));
        sum.bytes = add(sum.bytes, multiply(xform->instances, once->bytes));
    }
    if (add(parser->count, sum.primitives) > parser->limits.primitives ||
        add(parser->reals, sum.reals) > parser->limits.reals ||
        add(parser->bytes, sum.bytes) > parser->limits.bytes)
        return pm_word_error(&command->words[0], PM_E_LIMIT, frame->file->name, parser->err,
                             "this xform would make %llu primitives with %llu reals from %llu "
                             "bytes of text; a scene may have %zu, %zu and %zu in all",
                             (unsigned long long)sum.primitives, (unsigned long long)sum.reals,
                             (unsigned long long)sum.bytes, parser->limits.primitives,
                             parser->limits.reals, parser->limits.bytes);
    return PM_OK;
}

static bool is_usable(const pm_transform *t)
{
    bool finite = isfinite(t->shift[0]) && isfinite(t->shift[1]) && isfinite(t->shift[2]);
    return finite && isnormal(t->scale) && isnormal(1 / t->scale);
}

/* An `!xform` line that is being carried out. */
struct expansion {
    pm_parser *parser;
    const pm_frame *frame;
    pm_command command;
    pm_xform xform;
    char *prefix; /* scratch, of pm_xform_prefix_size */
};

static pm_status make_frame(const struct expansion *e, uint64_t index, pm_frame *inner)
{
    const pm_frame *frame = e->frame;
    const pm_transform own = pm_xform_instance(&e->xform, index);
    *inner = (pm_frame){.transform = pm_transform_then(&own, &frame->transform),
                        .moved = true,
                        .inverted = frame->inverted != e->xform.invert,
                        .modifier = frame->modifier,
                        .modifier_file = frame->modifier_file,
                        .depth = frame->depth + 1};
    if (!inner->modifier && e->xform.modifier) {
        inner->modifier = e->xform.modifier;
        inner->modifier_file = frame->file->name;
    }
    if (!is_usable(&inner->transform))
        return pm_word_error(
            &e->command.words[0], PM_E_RANGE, frame->file->name, e->parser->err,
            "the transforms together leave the range of doubles; scale or move "
            "less");
    pm_xform_instance_prefix(&e->xform, index, e->prefix);
    if (strlen(frame->prefix) + strlen(e->prefix) >= PM_PREFIX_MOST)
        return pm_word_error(
            &e->command.words[0], PM_E_LIMIT, frame->file->name, e->parser->err,
            "-n makes names longer than %d bytes; write a shorter one", PM_PREFIX_MOST);
    inner->prefix = pm_parser_name(e->parser, frame->prefix, e->prefix, strlen(e->prefix));
    return inner->prefix ? PM_OK : pm_parser_memory_error(e->parser);
}

static pm_status expand_instances(const struct expansion *e)
{
    pm_status st = PM_OK;
    for (uint64_t i = 0; !st && i < e->xform.instances; i++) {
        pm_frame inner;
        st = make_frame(e, i, &inner);
        for (size_t k = 0; !st && k < e->xform.file_count; k++) {
            inner.file =
                pm_bundle_find(e->parser->bundle, e->xform.files[k].text, e->frame->file->name);
            st = pm_parser_file(e->parser, &inner);
        }
    }
    return st;
}

pm_status pm_parser_expand(pm_parser *parser, const pm_frame *frame, pm_lexer *lexer)
{
    pm_arena arena = {0};
    struct expansion e = {.parser = parser, .frame = frame};
    pm_status st = pm_command_read(lexer, &arena, &e.command, parser->err);
    if (!st)
        st = pm_xform_parse(&e.command, &arena, &e.xform, parser->err);
    if (!st)
        st = check_size(parser, frame, &e.command, &e.xform);
    if (!st) {
        e.prefix = pm_arena_alloc(&arena, pm_xform_prefix_size(&e.xform));
        st = e.prefix ? expand_instances(&e) : pm_parser_memory_error(parser);
    }
    pm_arena_clear(&arena);
    return st;
}
