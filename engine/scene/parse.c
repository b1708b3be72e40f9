#include <stdlib.h>
#include <string.h>

#include "scene/parser.h"

struct pm_scene_memory {
    pm_scene scene;
    pm_arena arena;
    pm_primitive *primitives;
    pm_prototype *prototypes;
    uint32_t *aliases;
};

pm_status pm_parser_memory_error(pm_parser *parser)
{
    return pm_error_set(parser->err, PM_E_MEMORY, "not enough memory for the scene");
}

const char *pm_parser_name(pm_parser *parser, const char *prefix, const char *name,
                           size_t length)
{
    size_t before = strlen(prefix);
    if (!before || !length)
        return before ? prefix : pm_arena_text(parser->arena, name, length);
    char *text = pm_arena_alloc(parser->arena, before + length + 2);
    if (!text)
        return NULL;
    memcpy(text, prefix, before);
    text[before] = '.';
    memcpy(text + before + 1, name, length);
    return text;
}

/* ---- statements ---- */

static pm_status reserve(pm_reading *r)
{
    pm_parser *parser = r->parser;
    if (parser->count >= parser->limits.primitives)
        return PM_READING_FAIL(r, &r->statement->type, PM_E_LIMIT,
                               "the scene has more than %zu primitives; split it",
                               parser->limits.primitives);
    if (parser->count < parser->capacity)
        return PM_OK;
    size_t capacity = parser->capacity ? 2 * parser->capacity : 256;
    pm_primitive *more = realloc(parser->primitives, capacity * sizeof *more);
    if (!more)
        return pm_parser_memory_error(parser);
    parser->primitives = more;
    parser->capacity = capacity;
    return PM_OK;
}

/* Adds the primitive under the statement's name. */
static pm_status append(pm_reading *r)
{
    pm_parser *parser = r->parser;
    const pm_word *type = &r->statement->type, *name = &r->statement->name;
    pm_primitive *p = &r->result;
    pm_status st = reserve(r);
    if (!st)
        st = pm_parser_chain(r, p);
    if (st)
        return st;
    bool surface = pm_primitive_is_surface(p->type);
    const pm_file *file = r->frame->origin ? r->frame->origin : r->frame->file;
    const pm_word *place = r->frame->place ? r->frame->place : type;
    p->file = (uint32_t)(file - pm_bundle_at(parser->bundle, 0));
    p->line = place->line;
    p->column = place->column;
    p->name = pm_parser_name(parser, surface ? r->frame->prefix : "", name->text, name->length);
    if (!p->name)
        return pm_parser_memory_error(parser);
    if (!surface && pm_names_set(&parser->names, name, (int32_t)parser->count))
        return pm_parser_memory_error(parser);
    parser->primitives[parser->count++] = *p;
    return PM_OK;
}

pm_status pm_parser_primitive(pm_reading *r)
{
    const char *file = r->frame->file->name;
    pm_status st = pm_type_find(&r->statement->type, file, &r->result.type, r->parser->err);
    if (st)
        return st;
    r->rules = pm_type_get(r->result.type);
    st = pm_parser_modifier(r);
    if (!st)
        st = pm_parser_arguments(r);
    return st ? st : append(r);
}

static bool note_alias(pm_parser *parser)
{
    if (parser->alias_count == parser->alias_capacity) {
        size_t capacity = parser->alias_capacity ? 2 * parser->alias_capacity : 16;
        uint32_t *more = realloc(parser->aliases, capacity * sizeof *more);
        if (!more)
            return false;
        parser->aliases = more;
        parser->alias_capacity = capacity;
    }
    parser->aliases[parser->alias_count++] = (uint32_t)parser->count;
    return true;
}

/* What the alias `new` stands for: a record whose alias has no modifier of its own says it as
 * the modifier. */
static pm_status alias_target(const pm_reading *r, bool *inherits, int32_t *out)
{
    const pm_statement *s = r->statement;
    *inherits = r->record ? !s->target.text : pm_word_is(&s->modifier, "inherit");
    if (r->record && *inherits)
        *out = r->record_modifier;
    else if (pm_word_is(&s->target, "void"))
        *out = PM_VOID;
    else
        return pm_parser_reference(r, &s->target, r->frame->file->name, out);
    return PM_OK;
}

/* `modifier alias new old`: what the old name means, or with a modifier of the alias's own a
 * copy of it (Radiance's readobj.c and m_alias.c). */
pm_status pm_parser_alias(pm_reading *r)
{
    const pm_statement *s = r->statement;
    pm_parser *parser = r->parser;
    int32_t target;
    bool inherits;
    pm_status st = alias_target(r, &inherits, &target);
    if (!st && target == PM_VOID)
        return PM_READING_FAIL(r, &s->target, PM_E_SYNTAX,
                               "void cannot be aliased; name a modifier");
    if (!st && !inherits)
        st = pm_parser_modifier(r);
    if (st)
        return st;
    int32_t modifier = r->result.modifier;
    const char *modifier_name = r->result.modifier_name;
    if (inherits || modifier == parser->primitives[target].modifier) {
        bool added = note_alias(parser) && !pm_names_set(&parser->names, &s->name, target);
        return added ? PM_OK : pm_parser_memory_error(parser);
    }
    r->result = parser->primitives[target];
    r->result.modifier = modifier;
    r->result.modifier_name = modifier_name;
    return append(r);
}

/* Files that are read again and again cost time, even if they hold nothing. */
static pm_status note_text(pm_parser *parser, const pm_file *file)
{
    parser->bytes += file->size + PM_FILE_COST;
    if (parser->bytes > parser->limits.bytes)
        return pm_error_set_at(parser->err, PM_E_LIMIT, file->name, 0, 0,
                               "the scene has more than %zu bytes of text; split it",
                               parser->limits.bytes);
    return PM_OK;
}

pm_status pm_parser_top_file(pm_parser *parser, const pm_frame *frame)
{
    pm_file_count *count = &parser->counts[frame->file - pm_bundle_at(parser->bundle, 0)];
    const pm_file_count before = *count;
    count->state = PM_COUNTING; /* who names it from below closes a circle */
    pm_status st = pm_parser_file(parser, frame);
    *count = before;
    return st;
}

/* What starts as Radiance's binary files do, and is none that is read here. */
static pm_status check_is_text(const pm_parser *parser, const pm_file *file)
{
    if (file->size < 2 || memcmp(file->data, "#?", 2) != 0)
        return PM_OK;
    return pm_error_set_at(parser->err, PM_E_CORRUPT, file->name, 1, 1,
                           "this is no scene: an octree that is cut short, or a picture?");
}

pm_status pm_parser_file(pm_parser *parser, const pm_frame *frame)
{
    pm_lexer lexer;
    pm_statement statement = {.kind = PM_STATEMENT_COMMAND};
    pm_status st = check_is_text(parser, frame->file);
    if (!st)
        st = note_text(parser, frame->file);
    if (!st)
        st = pm_lexer_init(&lexer, frame->file, parser->err);
    while (!st && statement.kind != PM_STATEMENT_END) {
        pm_reading r = {
            .parser = parser, .frame = frame, .lexer = &lexer, .statement = &statement};
        st = pm_statement_next(&lexer, &statement, parser->err);
        r.arguments = lexer;
        if (!st && statement.kind == PM_STATEMENT_COMMAND)
            st = pm_parser_expand(parser, frame, &lexer);
        else if (!st && statement.kind == PM_STATEMENT_ALIAS)
            st = pm_parser_alias(&r);
        else if (!st && statement.kind == PM_STATEMENT_PRIMITIVE)
            st = pm_parser_primitive(&r);
    }
    return st;
}

/* ---- the scene ---- */

static pm_scene_limits limits_of(const pm_scene_limits *given)
{
    pm_scene_limits limits = given ? *given : (pm_scene_limits){0};
    if (!limits.primitives || limits.primitives > INT32_MAX)
        limits.primitives = limits.primitives ? INT32_MAX : 20000000;
    if (!limits.reals)
        limits.reals = 400000000;
    if (!limits.bytes)
        limits.bytes = (size_t)16 << 30;
    if (!limits.nesting)
        limits.nesting = 32;
    return limits;
}

static pm_status copy_file_names(pm_parser *parser, pm_scene *scene)
{
    scene->file_count = pm_bundle_count(parser->bundle);
    const char **names = pm_arena_array(parser->arena, scene->file_count, sizeof *names);
    scene->files = names;
    for (size_t i = 0; names && i < scene->file_count; i++) {
        const char *name = pm_bundle_at(parser->bundle, i)->name;
        names[i] = pm_arena_text(parser->arena, name, strlen(name));
        if (!names[i])
            names = NULL;
    }
    return names ? PM_OK : pm_parser_memory_error(parser);
}

static pm_status allocate_by_file(pm_parser *parser)
{
    size_t files = pm_bundle_count(parser->bundle);
    parser->counts = pm_arena_array(&parser->scratch, files, sizeof *parser->counts);
    parser->newest_prototype =
        pm_arena_array(&parser->scratch, files, sizeof *parser->newest_prototype);
    return parser->counts && parser->newest_prototype ? PM_OK : pm_parser_memory_error(parser);
}

static pm_status parse_main(pm_parser *parser, const char *name)
{
    const pm_file *file = pm_bundle_find(parser->bundle, name, NULL);
    if (!file)
        return pm_error_set(parser->err, PM_E_MISSING, "there is no file '%s' in the bundle",
                            name);
    const pm_frame frame = {
        .file = file, .transform = pm_transform_identity(), .prefix = "", .depth = 1};
    return pm_octree_file_is(file->data, file->size) ? pm_parser_octree(parser, &frame)
                                                     : pm_parser_top_file(parser, &frame);
}

static pm_status parse(pm_parser *parser, const char *const *names, size_t count,
                       pm_scene *scene)
{
    pm_status st = allocate_by_file(parser);
    for (size_t i = 0; !st && i < count; i++)
        st = parse_main(parser, names[i]);
    scene->main_count = parser->count;
    scene->alias_count = parser->alias_count;
    if (!st)
        st = pm_parser_prototypes(parser);
    if (!st)
        st = copy_file_names(parser, scene);
    return st;
}

/* The scene takes what was made for it. */
static void hand_over(pm_parser *parser, struct pm_scene_memory *memory)
{
    pm_arena_clear(&parser->scratch);
    free(parser->words);
    free(parser->prototype_origins);
    free(parser->slots);
    memory->primitives = parser->primitives;
    memory->prototypes = parser->prototypes;
    memory->aliases = parser->aliases;
    memory->scene.primitives = parser->primitives;
    memory->scene.count = parser->count;
    memory->scene.prototypes = parser->prototypes;
    memory->scene.prototype_count = parser->prototype_count;
    memory->scene.aliases = parser->aliases;
    memory->scene.assets = parser->assets;
    memory->scene.memory = memory;
}

pm_status pm_scene_parse_files(const pm_bundle *bundle, const char *const *names, size_t count,
                               const pm_scene_limits *limits, pm_scene **out, pm_error *err)
{
    struct pm_scene_memory *memory = calloc(1, sizeof *memory);
    if (!memory)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for the scene");
    pm_parser parser = {.bundle = bundle,
                        .limits = limits_of(limits),
                        .err = err,
                        .arena = &memory->arena,
                        .generate_work = (uint64_t)1 << 30, /* some 20 s */
                        .assets = pm_assets_new()};
    parser.names.arena = &memory->arena;
    pm_status st = parser.assets ? parse(&parser, names, count, &memory->scene)
                                 : pm_parser_memory_error(&parser);
    hand_over(&parser, memory);
    if (st)
        pm_scene_free(&memory->scene);
    else
        *out = &memory->scene;
    return st;
}

pm_status pm_scene_parse(const pm_bundle *bundle, const char *main_name,
                         const pm_scene_limits *limits, pm_scene **out, pm_error *err)
{
    return pm_scene_parse_files(bundle, &main_name, 1, limits, out, err);
}

void pm_scene_free(pm_scene *scene)
{
    if (!scene)
        return;
    struct pm_scene_memory *memory = scene->memory;
    pm_arena_clear(&memory->arena);
    pm_assets_free(scene->assets);
    free(memory->primitives);
    free(memory->prototypes);
    free(memory->aliases);
    free(memory);
}
