#include "scene/named_files.h"

#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "files/mesh.h"
#include "files/octree_file.h"
#include "scene/pipeline.h"
#include "scene/statement.h"
#include "scene/types.h"

struct search {
    const pm_file *file;
    pm_named_file visit;
    void *context;
    pm_arena arena; /* of the statement in hand */
};

static bool names_a_file(char role)
{
    return role && strchr("dpbctxog", role) != NULL;
}

static pm_status visit_word(struct search *s, const pm_word *word, char role)
{
    return s->visit(s->context, s->file, word, role);
}

/* ---- text ---- */

/* The files among a generator's words. */
static pm_status visit_generator(struct search *s, const pm_command *command)
{
    static const char roles[] = {[PM_GENERATE_FILE] = 'v',
                                 [PM_GENERATE_FUNCTION_FILE] = 'c',
                                 [PM_GENERATE_PERHAPS_FILE] = '?'};
    const char **words = pm_arena_array(&s->arena, command->count, sizeof *words);
    pm_status st = words ? PM_OK : PM_E_MEMORY;
    for (size_t i = 0; words && i < command->count; i++)
        words[i] = command->words[i].text;
    for (size_t i = 0; !st && i < command->count; i++) {
        pm_generate_word kind = pm_generate_word_is(words, command->count, i);
        if (kind != PM_GENERATE_PLAIN)
            st = visit_word(s, &command->words[i], roles[kind]);
    }
    return st;
}

static pm_status visit_command(struct search *s, pm_lexer *lexer)
{
    pm_pipeline pipeline;
    pm_status st = pm_pipeline_read(lexer, NULL, &s->arena, &pipeline, NULL);
    if (st)
        return st == PM_E_MEMORY ? st : PM_OK;
    for (size_t i = 0; !st && i < pipeline.file_count; i++)
        st = visit_word(s, &pipeline.files[i], 'r');
    for (size_t i = 0; !st && i < pipeline.xform_count; i++)
        if (pipeline.xforms[i].list)
            st = visit_word(s, pipeline.xforms[i].list, 'v');
    return !st && pipeline.generator ? visit_generator(s, pipeline.generator) : st;
}

/* A text's "." is followed by words of the text itself; a function file's stands for none. */
static bool is_no_file(const pm_word *word)
{
    return pm_word_is(word, ".");
}

static pm_status visit_string(struct search *s, const pm_word *word, char role)
{
    pm_word terminated = *word;
    if (!names_a_file(role) || is_no_file(word))
        return PM_OK;
    terminated.text = pm_arena_text(&s->arena, word->text, word->length);
    return terminated.text ? visit_word(s, &terminated, role) : PM_E_MEMORY;
}

/* Passes the primitive's arguments. *broken if they break off: the parser, which reads strings
 * first, is to find the files of those. */
static pm_status visit_primitive(struct search *s, const pm_statement *statement,
                                 pm_lexer *lexer, bool *broken)
{
    pm_primitive_type type;
    pm_lexer strings = *lexer;
    pm_word word;
    size_t count = 0, reals;
    pm_status st = PM_OK;
    *broken = pm_type_find(&statement->type, s->file->name, &type, NULL) != PM_OK;
    if (*broken || pm_statement_count(&strings, "arguments", &word, &count, NULL))
        return PM_OK;
    for (size_t i = 0; !st && i < count; i++) {
        if (pm_lexer_word(&strings, &word, NULL) || !word.text)
            break;
        st = visit_string(s, &word, pm_type_string_role(pm_type_get(type), i, 0));
    }
    *broken = !pm_statement_skip_arguments(lexer, &reals);
    return st;
}

static pm_status visit_text(struct search *s)
{
    pm_lexer lexer;
    pm_statement statement;
    bool broken = pm_lexer_init(&lexer, s->file, NULL) != PM_OK;
    pm_status st = PM_OK;
    while (!st && !broken && !pm_statement_next(&lexer, &statement, NULL) &&
           statement.kind != PM_STATEMENT_END) {
        if (statement.kind == PM_STATEMENT_COMMAND)
            st = visit_command(s, &lexer);
        else if (statement.kind == PM_STATEMENT_PRIMITIVE)
            st = visit_primitive(s, &statement, &lexer, &broken);
        pm_arena_clear(&s->arena);
    }
    return st;
}

/* ---- octrees ---- */

static pm_word word_of(const char *text)
{
    return (pm_word){.text = text, .length = strlen(text)};
}

static pm_status visit_record(struct search *s, const pm_record *record)
{
    const pm_word name = word_of(record->type);
    pm_primitive_type type;
    pm_status st = PM_OK;
    if (pm_type_find(&name, s->file->name, &type, NULL))
        return PM_OK;
    for (uint32_t i = 0; !st && i < record->string_count; i++) {
        const pm_word word = word_of(record->strings[i]);
        char role = pm_type_string_role(pm_type_get(type), i, 0);
        if (names_a_file(role) && !is_no_file(&word))
            st = visit_word(s, &word, role);
    }
    return st;
}

static pm_status visit_octree(struct search *s)
{
    pm_octree_file octree;
    pm_status st = pm_octree_file_read(s->file->data, s->file->size, s->file->name, INT32_MAX,
                                       &s->arena, &octree, NULL);
    if (st)
        return st == PM_E_MEMORY ? st : PM_OK;
    for (uint32_t i = 0; !st && i < octree.file_count; i++) {
        const pm_word word = word_of(octree.files[i]);
        st = visit_word(s, &word, 'r');
    }
    for (size_t i = 0; !st && i < octree.records.count; i++)
        st = visit_record(s, &octree.records.items[i]);
    return st;
}

/* A compiled mesh brings its materials. */
static pm_status visit_mesh(struct search *s)
{
    pm_records materials;
    pm_status st = pm_mesh_materials(s->file->data, s->file->size, s->file->name, &s->arena,
                                     &materials, NULL);
    if (st)
        return st == PM_E_MEMORY ? st : PM_OK;
    for (size_t i = 0; !st && i < materials.count; i++)
        st = visit_record(s, &materials.items[i]);
    return st;
}

pm_status pm_named_files_visit(const pm_file *file, char role, pm_named_file visit,
                               void *context)
{
    struct search s = {.file = file, .visit = visit, .context = context};
    pm_status st = PM_OK;
    if (pm_octree_file_is(file->data, file->size))
        st = visit_octree(&s);
    else if (role == 'g')
        st = visit_mesh(&s);
    else if (role == 'r')
        st = visit_text(&s);
    pm_arena_clear(&s.arena);
    return st;
}
