#include <stdio.h>
#include <string.h>

#include "scene/expand.h"

/* What `!` lines will bring, known before they are carried out. */

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

static pm_generate_file find_file(void *context, const char *name)
{
    const struct pm_generate_context *c = context;
    const pm_file *file = pm_bundle_find(c->bundle, name, c->from);
    return (pm_generate_file){file ? file->data : NULL, file ? file->size : 0};
}

pm_status pm_parser_request(pm_parser *parser, const pm_pipeline *pipeline, pm_arena *arena,
                            pm_generate_request *out)
{
    const char **words = pm_arena_array(arena, pipeline->generator->count, sizeof *words);
    struct pm_generate_context *context = pm_arena_alloc(arena, sizeof *context);
    if (!words || !context)
        return pm_parser_memory_error(parser);
    *context = (struct pm_generate_context){parser->bundle, pipeline->file};
    *out = pm_pipeline_request(pipeline, words);
    out->find = find_file;
    out->find_context = context;
    out->work = &parser->generate_work;
    return PM_OK;
}

/* Adds `instances` times what is made once. */
static void add_made(pm_file_count *sum, uint64_t instances, uint64_t primitives,
                     uint64_t reals, uint64_t bytes)
{
    sum->primitives = add(sum->primitives, multiply(instances, primitives));
    sum->reals = add(sum->reals, multiply(instances, reals));
    sum->bytes = add(sum->bytes, multiply(instances, bytes));
}

static pm_status count_generator(pm_parser *parser, const pm_pipeline *pipeline,
                                 pm_arena *arena, pm_file_count *sum, pm_error *err)
{
    pm_generate_request request;
    pm_generate_size once = {0};
    pm_error why = PM_ERROR_INIT;
    size_t wrong = 0;
    pm_status st = pm_parser_request(parser, pipeline, arena, &request);
    if (st)
        return st;
    st = pm_generate_measure(&request, &once, &wrong, &why);
    if (st)
        return pm_parser_generate_error(pipeline, wrong, &why, err);
    add_made(sum, pipeline->instances, once.primitives, once.reals,
             add(once.bytes, PM_FILE_COST));
    return PM_OK;
}

/* Adds what a pipeline's files bring; *missing is the name of one that is not there. */
static pm_status count_files(pm_parser *parser, const struct chain *chain,
                             const pm_pipeline *pipeline, pm_file_count *sum,
                             const pm_word **missing)
{
    *missing = NULL;
    for (size_t i = 0; i < pipeline->file_count; i++) {
        const pm_word *name = &pipeline->files[i];
        const pm_file *file = pm_bundle_find(parser->bundle, name->text, pipeline->file);
        if (!file) {
            *missing = name;
            return PM_OK;
        }
        pm_status st = count_file(parser, chain, file, name);
        if (st)
            return st;
        const pm_file_count *once = count_of(parser, file);
        add_made(sum, pipeline->instances, once->primitives, once->reals, once->bytes);
        if (sum->depth <= once->depth)
            sum->depth = once->depth + 1;
    }
    return PM_OK;
}

/* Adds what a `!` line brings. *broken if the line is wrong: whoever parses it will say so. */
static pm_status count_command(pm_parser *parser, const struct chain *parent,
                               const pm_file *file, pm_lexer *lexer, pm_file_count *sum,
                               bool *broken)
{
    pm_pipeline pipeline;
    const pm_word *missing = NULL;
    pm_status st = pm_pipeline_read(lexer, parser->bundle, &parser->scratch, &pipeline, NULL);
    if (!st && pipeline.generator)
        st = count_generator(parser, &pipeline, &parser->scratch, sum, NULL);
    *broken = st != PM_OK;
    if (st)
        return st == PM_E_MEMORY ? pm_parser_memory_error(parser) : PM_OK;
    const struct chain chain = {parent, file->name, pipeline.start, parent->depth + 1};
    st = count_files(parser, &chain, &pipeline, sum, &missing);
    *broken = missing != NULL;
    return st;
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

pm_status pm_parser_generate_error(const pm_pipeline *pipeline, size_t wrong,
                                   const pm_error *why, pm_error *err)
{
    if (why->file[0]) /* in a file that the command names */
        return pm_error_set_at(err, why->status, why->file, why->line, why->column, "%s",
                               why->text);
    return pm_word_error(&pipeline->generator->words[wrong], why->status, pipeline->file, err,
                         "%s", why->text);
}

static pm_status missing_error(pm_parser *parser, const pm_pipeline *pipeline,
                               const pm_word *name)
{
    return pm_word_error(name, PM_E_MISSING, pipeline->file, parser->err,
                         "there is no file '%.*s', neither beside this one nor beside the main "
                         "file",
                         PM_WORD_SHOW(*name));
}

pm_status pm_parser_check_size(pm_parser *parser, unsigned depth, const pm_pipeline *pipeline,
                               pm_arena *arena)
{
    /* Files above this one matter to the count of depth alone: a circle was found when the
     * first of them was counted. */
    const struct chain chain = {NULL, pipeline->file, pipeline->start, depth};
    const pm_word *missing = NULL;
    pm_file_count sum = {0};
    pm_status st = pipeline->generator
                       ? count_generator(parser, pipeline, arena, &sum, parser->err)
                       : count_files(parser, &chain, pipeline, &sum, &missing);
    if (!st && missing)
        st = missing_error(parser, pipeline, missing);
    if (st)
        return st;
    if (add(parser->count, sum.primitives) > parser->limits.primitives ||
        add(parser->reals, sum.reals) > parser->limits.reals ||
        add(parser->bytes, sum.bytes) > parser->limits.bytes)
        return pm_word_error(pipeline->start, PM_E_LIMIT, pipeline->file, parser->err,
                             "this %.*s would make %s%llu primitives with %llu reals from %llu "
                             "bytes of text; a scene may have %zu, %zu and %zu in all",
                             PM_WORD_SHOW(*pipeline->start),
                             pipeline->generator ? "up to " : "",
                             (unsigned long long)sum.primitives, (unsigned long long)sum.reals,
                             (unsigned long long)sum.bytes, parser->limits.primitives,
                             parser->limits.reals, parser->limits.bytes);
    return PM_OK;
}
