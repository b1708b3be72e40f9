#include <string.h>

#include "scene/parser.h"

/* Octree files: their records go through the checks of text, word for word; the scene files
 * that they name are read as if `!xform` lines named them. */

/* ---- records ---- */

/* Records that are turned into primitives. */
struct listing {
    pm_parser *parser;
    const pm_frame *frame;
    const pm_records *records;
    int32_t *map; /* [records->count] */
};

enum { SURFACE = -2 }; /* in the map, while it is made */

static pm_word word_of(const char *text)
{
    return (pm_word){.text = text, .length = strlen(text)};
}

/* What the checks of text say lacks the place in a binary file. */
static pm_status with_place(const struct listing *l, size_t index, const pm_error *inner,
                            pm_error *err)
{
    const pm_record *record = &l->records->items[index];
    if (inner->line > 0 || inner->status == PM_E_MEMORY)
        return pm_error_set_at(err, inner->status, inner->file, inner->line, inner->column,
                               "%s", inner->text);
    return pm_error_set_at(err, inner->status, l->frame->file->name, 0, 0,
                           "primitive %zu, %.60s '%.60s': %s", index + 1, record->type,
                           record->name, inner->text);
}

static pm_status find_modifier(const struct listing *l, const pm_record *record, int32_t *out)
{
    *out = record->modifier == PM_VOID ? PM_VOID : l->map[record->modifier];
    if (*out != SURFACE)
        return PM_OK;
    return pm_error_set(l->parser->err, PM_E_CORRUPT,
                        "its modifier '%.60s' is a surface; the file is damaged",
                        l->records->items[record->modifier].name);
}

static pm_status read_record(const struct listing *l, size_t index)
{
    pm_parser *parser = l->parser;
    const pm_record *record = &l->records->items[index];
    pm_statement statement = {.type = word_of(record->type), .name = word_of(record->name)};
    pm_reading r = {
        .parser = parser, .frame = l->frame, .record = record, .statement = &statement};
    pm_status st = find_modifier(l, record, &r.record_modifier);
    if (st)
        return st;
    statement.modifier = word_of(
        record->modifier == PM_VOID ? "void" : l->records->items[record->modifier].name);
    bool alias = pm_word_is(&statement.type, "alias");
    if (alias && record->string_count)
        statement.target = word_of(record->strings[0]);
    st = alias ? pm_parser_alias(&r) : pm_parser_primitive(&r);
    if (st)
        return st;
    bool surface = !alias && pm_primitive_is_surface(r.result.type);
    l->map[index] = surface ? SURFACE : pm_names_find(&parser->names, &statement.name);
    return PM_OK;
}

pm_status pm_parser_records(pm_parser *parser, const pm_frame *frame, const pm_records *records,
                            int32_t *map)
{
    pm_error inner = PM_ERROR_INIT, *err = parser->err;
    pm_arena arena = {0};
    struct listing l = {.parser = parser, .frame = frame, .records = records, .map = map};
    if (!map)
        l.map = pm_arena_array(&arena, records->count, sizeof *l.map);
    if (!l.map)
        return pm_parser_memory_error(parser);
    pm_status st = PM_OK;
    parser->err = &inner;
    for (size_t i = 0; !st && i < records->count; i++) {
        st = read_record(&l, i);
        if (st)
            with_place(&l, i, &inner, err);
    }
    parser->err = err;
    for (size_t i = 0; !st && i < records->count; i++)
        if (l.map[i] == SURFACE)
            l.map[i] = PM_VOID;
    pm_arena_clear(&arena);
    return st;
}

/* ---- named files ---- */

static pm_status read_named_file(pm_parser *parser, const pm_frame *frame, const char *name)
{
    const char *octree = frame->file->name;
    if (name[0] == '!')
        return pm_error_set_at(parser->err, PM_E_UNSUPPORTED, octree, 0, 0,
                               "it was made from the output of '%.100s', and commands are not "
                               "executed; put that line into a scene file, or freeze the "
                               "octree (oconv -f)",
                               name);
    const pm_file *file = pm_bundle_find(parser->bundle, name, octree);
    if (!file)
        return pm_error_set_at(parser->err, PM_E_MISSING, octree, 0, 0,
                               "there is no scene file '%.200s', neither beside this octree "
                               "nor beside the main file; freeze the octree (oconv -f) to have "
                               "all in one",
                               name);
    if (pm_octree_file_is(file->data, file->size))
        return pm_error_set_at(parser->err, PM_E_RANGE, octree, 0, 0,
                               "'%.200s' is an octree itself; an octree names scene files",
                               name);
    pm_frame inner = *frame;
    inner.file = file;
    inner.depth = frame->depth + 1;
    return pm_parser_top_file(parser, &inner);
}

static pm_status read_named_files(pm_parser *parser, const pm_frame *frame,
                                  const pm_octree_file *octree)
{
    uint64_t before = parser->count + parser->alias_count;
    pm_status st = PM_OK;
    for (uint32_t i = 0; !st && i < octree->file_count; i++)
        st = read_named_file(parser, frame, octree->files[i]);
    uint64_t objects = parser->count + parser->alias_count - before;
    if (st || objects == octree->objects)
        return st;
    return pm_error_set_at(parser->err, PM_E_MISMATCH, frame->file->name, 0, 0,
                           "the octree was made of %llu primitives, and its scene files now "
                           "hold %llu; make it again (oconv)",
                           (unsigned long long)octree->objects, (unsigned long long)objects);
}

pm_status pm_parser_octree(pm_parser *parser, const pm_frame *frame)
{
    const pm_file *file = frame->file;
    pm_arena arena = {0};
    pm_octree_file octree;
    size_t left = parser->limits.primitives - parser->count;
    pm_status st = pm_octree_file_read(file->data, file->size, file->name, left, &arena,
                                       &octree, parser->err);
    if (!st && octree.file_count)
        st = read_named_files(parser, frame, &octree);
    else if (!st)
        st = pm_parser_records(parser, frame, &octree.records, NULL);
    pm_arena_clear(&arena);
    return st;
}
