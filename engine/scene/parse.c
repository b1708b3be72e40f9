#include <stdlib.h>
#include <string.h>

#include "scene/check.h"
#include "scene/parser.h"
#include "scene/types.h"

struct pm_scene_memory {
    pm_scene scene;
    pm_arena arena;
    pm_primitive *primitives;
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

/* One primitive while it is read. */
struct reading {
    pm_parser *parser;
    const pm_frame *frame;
    pm_lexer *lexer;
    const pm_statement *statement;
    const pm_type *rules;
    pm_primitive result;
    const char **strings;
    int32_t *references;
    double *reals;
    pm_lexer arguments, real_place; /* before the first of each, for messages */
};

#define FAIL(r, word, status, ...)                                                             \
    pm_word_error(word, status, (r)->frame->file->name, (r)->parser->err, __VA_ARGS__)

/* The word `index` places after the lexer's. */
static pm_word word_at(pm_lexer lexer, size_t index)
{
    pm_word word = {0};
    for (size_t i = 0; i <= index; i++)
        if (pm_lexer_word(&lexer, &word, NULL))
            break;
    return word;
}

/* ---- modifiers ---- */

/* The line below on which the name is defined, or 0. */
static int line_below(const struct reading *r, const pm_word *name)
{
    pm_lexer lexer = r->arguments;
    pm_statement s = *r->statement;
    size_t reals;
    bool going =
        s.kind != PM_STATEMENT_PRIMITIVE || pm_statement_skip_arguments(&lexer, &reals);
    while (going && !pm_statement_next(&lexer, &s, NULL) && s.kind != PM_STATEMENT_END) {
        if (s.kind == PM_STATEMENT_COMMAND) {
            pm_lexer_skip_line(&lexer);
            continue;
        }
        if (s.name.length == name->length && !memcmp(s.name.text, name->text, name->length))
            return s.name.line;
        going = s.kind == PM_STATEMENT_ALIAS || pm_statement_skip_arguments(&lexer, &reals);
    }
    return 0;
}

static const pm_primitive *surface_named(const pm_parser *parser, const pm_word *name)
{
    for (size_t i = parser->count; i-- > 0;)
        if (pm_word_is(name, parser->primitives[i].name))
            return &parser->primitives[i];
    return NULL;
}

static pm_status undefined_error(const struct reading *r, const pm_word *name, const char *file)
{
    const pm_primitive *surface = surface_named(r->parser, name);
    pm_primitive_type type;
    int line = line_below(r, name);
    pm_error *err = r->parser->err;
    if (surface)
        return pm_word_error(name, PM_E_MISSING, file, err,
                             "'%.*s' is a %s, and a surface cannot modify; name a material",
                             PM_WORD_SHOW(*name), pm_primitive_type_name(surface->type));
    if (line)
        return pm_word_error(name, PM_E_MISSING, file, err,
                             "'%.*s' is not defined before it is used; move its definition up "
                             "from line %d of %s",
                             PM_WORD_SHOW(*name), line, r->frame->file->name);
    if (pm_word_is(name, "inherit") || pm_word_is(name, "void"))
        return pm_word_error(
            name, PM_E_SYNTAX, file, err,
            "%.*s cannot stand here; name a material, or void as the modifier of "
            "a material",
            PM_WORD_SHOW(*name));
    if (!pm_type_find(name, file, &type, NULL))
        return pm_word_error(name, PM_E_MISSING, file, err,
                             "'%.*s' is a type, but a modifier should come here; write the "
                             "modifier first, then the type, then a name",
                             PM_WORD_SHOW(*name));
    return pm_word_error(
        name, PM_E_MISSING, file, err,
        "'%.*s' is not defined; define a material of that name above this line",
        PM_WORD_SHOW(*name));
}

static pm_status material_modifier(struct reading *r)
{
    const pm_word *name = &r->statement->modifier;
    r->result.modifier = PM_VOID;
    if (pm_word_is(name, "void"))
        return PM_OK;
    int32_t index = pm_names_find(&r->parser->names, name);
    if (index < 0)
        return undefined_error(r, name, r->frame->file->name);
    return FAIL(r, name, PM_E_SYNTAX,
                "a material cannot modify a material ('%.*s' is %s); write void",
                PM_WORD_SHOW(*name), pm_primitive_type_name(r->parser->primitives[index].type));
}

static bool can_be_source(pm_primitive_type material)
{
    return material == PM_LIGHT || material == PM_GLOW || material == PM_SPOTLIGHT ||
           material == PM_ILLUM;
}

static pm_status surface_modifier(struct reading *r)
{
    const pm_frame *frame = r->frame;
    const pm_word *name = frame->modifier ? frame->modifier : &r->statement->modifier;
    const char *file = frame->modifier ? frame->modifier_file : frame->file->name;
    if (pm_word_is(name, "void"))
        return pm_word_error(name, PM_E_SYNTAX, file, r->parser->err,
                             "a %s needs a material to be seen; name one instead of void",
                             r->rules->name);
    int32_t index = pm_names_find(&r->parser->names, name);
    if (index < 0)
        return undefined_error(r, name, file);
    pm_primitive_type material = r->parser->primitives[index].type;
    if (r->result.type == PM_SOURCE && !can_be_source(material))
        return pm_word_error(
            name, PM_E_RANGE, file, r->parser->err,
            "a source of %s ('%.*s') gives no light; its material must be light, "
            "glow, spotlight or illum",
            pm_primitive_type_name(material), PM_WORD_SHOW(*name));
    r->result.modifier = index;
    return PM_OK;
}

/* ---- arguments ---- */

/* So that a false count cannot ask for more memory than the file is worth. */
static pm_status check_room(const struct reading *r, const pm_word *count_word, size_t count)
{
    if (count > (size_t)(r->lexer->end - r->lexer->at))
        return FAIL(r, count_word, PM_E_SYNTAX,
                    "%zu arguments are announced, but the file ends before", count);
    return PM_OK;
}

static pm_status read_string(struct reading *r, size_t index)
{
    pm_word word;
    pm_status st = pm_statement_word(r->lexer, "a string argument", &word, r->parser->err);
    if (st)
        return st;
    r->references[index] = PM_VOID;
    r->strings[index] = pm_arena_text(r->parser->arena, word.text, word.length);
    if (!r->strings[index])
        return pm_parser_memory_error(r->parser);
    if (r->result.type == PM_MIST || pm_word_is(&word, "void"))
        return PM_OK;
    r->references[index] = pm_names_find(&r->parser->names, &word);
    if (r->references[index] < 0)
        return undefined_error(r, &word, r->frame->file->name);
    return PM_OK;
}

static pm_status read_strings(struct reading *r)
{
    pm_word word;
    size_t count;
    pm_status st =
        pm_statement_count(r->lexer, "string arguments", &word, &count, r->parser->err);
    if (st)
        return st;
    const pm_type *rules = r->rules;
    if (count < rules->strings_least || count > rules->strings_most)
        return FAIL(r, &word, PM_E_SYNTAX, "%s takes %s; here are %zu", rules->name,
                    rules->strings_least  ? "at least 1 string argument: the materials it cuts"
                    : rules->strings_most ? "at most 1 string argument: its alternate material"
                                          : "no string arguments",
                    count);
    st = check_room(r, &word, count);
    if (st || !count)
        return st;
    r->strings = pm_arena_array(r->parser->arena, count, sizeof *r->strings);
    r->references = pm_arena_array(r->parser->arena, count, sizeof *r->references);
    if (!r->strings || !r->references)
        return pm_parser_memory_error(r->parser);
    for (size_t i = 0; !st && i < count; i++)
        st = read_string(r, i);
    r->result.string_count = (uint32_t)count;
    r->result.strings = r->strings;
    r->result.references = r->references;
    return st;
}

static pm_status read_integers(struct reading *r)
{
    pm_word word;
    size_t count;
    pm_status st =
        pm_statement_count(r->lexer, "integer arguments", &word, &count, r->parser->err);
    if (!st && count)
        return FAIL(r, &word, PM_E_SYNTAX,
                    "no primitive takes integer arguments; write 0, then the count of reals");
    return st;
}

static bool count_is_right(const pm_type *rules, size_t count)
{
    if (!rules->counts) /* polygon */
        return count >= 9 && count % 3 == 0 && count <= UINT32_MAX;
    return count < 32 && (rules->counts >> count & 1);
}

static pm_status real_error(const struct reading *r, const pm_word *word, size_t index,
                            pm_number number)
{
    char name[64];
    pm_type_real_name(r->result.type, index, name, sizeof name);
    if (number == PM_NUMBER_HUGE)
        return FAIL(r, word, PM_E_RANGE, "%s's %s is %.*s, larger than a double holds",
                    r->rules->name, name, PM_WORD_SHOW(*word));
    return FAIL(r, word, PM_E_SYNTAX,
                "'%.*s' is no number; real %zu of %s's %u should come here, its %s%s",
                PM_WORD_SHOW(*word), index + 1, r->rules->name, r->result.real_count, name,
                word->text[0] == '#' ? " (a comment cannot stand inside a primitive)" : "");
}

static pm_status read_real(struct reading *r, size_t index)
{
    pm_word word;
    pm_status st = pm_lexer_word(r->lexer, &word, r->parser->err);
    if (st)
        return st;
    if (!word.text)
        return FAIL(r, &word, PM_E_SYNTAX,
                    "the file ends inside a primitive; real %zu of %s's %u should come here",
                    index + 1, r->rules->name, r->result.real_count);
    pm_number number = pm_word_real(&word, &r->reals[index]);
    return number ? real_error(r, &word, index, number) : PM_OK;
}

static pm_status read_reals(struct reading *r)
{
    pm_word word;
    size_t count;
    pm_status st =
        pm_statement_count(r->lexer, "real arguments", &word, &count, r->parser->err);
    if (st)
        return st;
    if (!count_is_right(r->rules, count))
        return FAIL(r, &word, PM_E_SYNTAX, "%s takes %s; here are %zu", r->rules->name,
                    r->rules->reals_takes, count);
    st = check_room(r, &word, count);
    if (st)
        return st;
    r->parser->reals += count;
    if (r->parser->reals > r->parser->limits.reals)
        return FAIL(r, &word, PM_E_LIMIT, "the scene has more than %zu reals; split it",
                    r->parser->limits.reals);
    r->reals = pm_arena_array(r->parser->arena, count, sizeof *r->reals);
    if (!r->reals)
        return pm_parser_memory_error(r->parser);
    r->result.real_count = (uint32_t)count;
    r->result.reals = r->reals;
    r->real_place = *r->lexer;
    for (size_t i = 0; !st && i < count; i++)
        st = read_real(r, i);
    return st;
}

static pm_status check_values(struct reading *r)
{
    size_t index;
    const char *right = pm_check_reals(r->result.type, r->reals, r->result.real_count, &index);
    if (!right)
        return PM_OK;
    char name[64];
    pm_word word = word_at(r->real_place, index);
    pm_type_real_name(r->result.type, index, name, sizeof name);
    return FAIL(r, &word, PM_E_RANGE, "%s's %s is %.*s; %s", r->rules->name, name,
                PM_WORD_SHOW(word), right);
}

static pm_status transform_values(struct reading *r)
{
    const char *reason;
    pm_check_canonical(&r->result.type, r->reals, &r->result.real_count);
    if (!r->frame->moved)
        return PM_OK;
    pm_status st =
        pm_transform_primitive(&r->frame->transform, r->frame->inverted, &r->result.type,
                               r->reals, r->result.real_count, &reason);
    if (st)
        return FAIL(r, &r->statement->type, st, "xform cannot move '%.*s': %s",
                    PM_WORD_SHOW(r->statement->name), reason);
    return PM_OK;
}

/* ---- statements ---- */

static pm_status append(struct reading *r)
{
    pm_parser *parser = r->parser;
    const pm_word *type = &r->statement->type, *name = &r->statement->name;
    if (parser->count >= parser->limits.primitives)
        return FAIL(r, type, PM_E_LIMIT, "the scene has more than %zu primitives; split it",
                    parser->limits.primitives);
    if (parser->count == parser->capacity) {
        size_t capacity = parser->capacity ? 2 * parser->capacity : 256;
        pm_primitive *more = realloc(parser->primitives, capacity * sizeof *more);
        if (!more)
            return pm_parser_memory_error(parser);
        parser->primitives = more;
        parser->capacity = capacity;
    }
    bool surface = pm_primitive_is_surface(r->result.type);
    r->result.file = (uint32_t)(r->frame->file - pm_bundle_at(parser->bundle, 0));
    r->result.line = type->line;
    r->result.column = type->column;
    r->result.name =
        pm_parser_name(parser, surface ? r->frame->prefix : "", name->text, name->length);
    if (!r->result.name)
        return pm_parser_memory_error(parser);
    if (!surface && pm_names_set(&parser->names, name, (int32_t)parser->count))
        return pm_parser_memory_error(parser);
    parser->primitives[parser->count++] = r->result;
    return PM_OK;
}

static pm_status read_primitive(struct reading *r)
{
    const char *file = r->frame->file->name;
    pm_primitive_type type;
    pm_status st = pm_type_find(&r->statement->type, file, &type, r->parser->err);
    if (st)
        return st;
    r->rules = pm_type_get(type);
    r->result.type = type;
    st = pm_primitive_is_surface(type) ? surface_modifier(r) : material_modifier(r);
    if (!st)
        st = read_strings(r);
    if (!st)
        st = read_integers(r);
    if (!st)
        st = read_reals(r);
    if (!st)
        st = check_values(r);
    if (!st)
        st = transform_values(r);
    return st ? st : append(r);
}

/* Every material's modifier is void, so an alias has no choice of its own. */
static pm_status read_alias(struct reading *r)
{
    const pm_statement *s = r->statement;
    pm_names *names = &r->parser->names;
    pm_status st = pm_word_is(&s->modifier, "inherit") ? PM_OK : material_modifier(r);
    if (st)
        return st;
    int32_t target = pm_names_find(names, &s->target);
    if (target < 0)
        return undefined_error(r, &s->target, r->frame->file->name);
    return pm_names_set(names, &s->name, target) ? pm_parser_memory_error(r->parser) : PM_OK;
}

pm_status pm_parser_file(pm_parser *parser, const pm_frame *frame)
{
    pm_lexer lexer;
    pm_statement statement = {.kind = PM_STATEMENT_COMMAND};
    pm_status st = pm_lexer_init(&lexer, frame->file, parser->err);
    parser->bytes += frame->file->size + PM_FILE_COST;
    while (!st && statement.kind != PM_STATEMENT_END) {
        struct reading r = {
            .parser = parser, .frame = frame, .lexer = &lexer, .statement = &statement};
        st = pm_statement_next(&lexer, &statement, parser->err);
        r.arguments = lexer;
        if (!st && statement.kind == PM_STATEMENT_COMMAND)
            st = pm_parser_expand(parser, frame, &lexer);
        else if (!st && statement.kind == PM_STATEMENT_ALIAS)
            st = read_alias(&r);
        else if (!st && statement.kind == PM_STATEMENT_PRIMITIVE)
            st = read_primitive(&r);
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

static pm_status parse_main(pm_parser *parser, const pm_file *file)
{
    size_t files = pm_bundle_count(parser->bundle);
    parser->counts = pm_arena_array(&parser->scratch, files, sizeof *parser->counts);
    if (!parser->counts)
        return pm_parser_memory_error(parser);
    parser->counts[file - pm_bundle_at(parser->bundle, 0)].state = PM_COUNTING;
    const pm_frame frame = {
        .file = file, .transform = pm_transform_identity(), .prefix = "", .depth = 1};
    return pm_parser_file(parser, &frame);
}

pm_status pm_scene_parse(const pm_bundle *bundle, const char *main_name,
                         const pm_scene_limits *limits, pm_scene **out, pm_error *err)
{
    const pm_file *file = pm_bundle_find(bundle, main_name, NULL);
    if (!file)
        return pm_error_set(err, PM_E_MISSING, "there is no file '%s' in the bundle",
                            main_name);
    struct pm_scene_memory *memory = calloc(1, sizeof *memory);
    if (!memory)
        return pm_error_set(err, PM_E_MEMORY, "not enough memory for the scene");
    pm_parser parser = {
        .bundle = bundle, .limits = limits_of(limits), .err = err, .arena = &memory->arena};
    parser.names.arena = &parser.scratch;
    pm_status st = parse_main(&parser, file);
    if (!st)
        st = copy_file_names(&parser, &memory->scene);
    pm_arena_clear(&parser.scratch);
    memory->primitives = parser.primitives;
    memory->scene.primitives = parser.primitives;
    memory->scene.count = parser.count;
    memory->scene.memory = memory;
    if (st)
        pm_scene_free(&memory->scene);
    else
        *out = &memory->scene;
    return st;
}

void pm_scene_free(pm_scene *scene)
{
    if (!scene)
        return;
    struct pm_scene_memory *memory = scene->memory;
    pm_arena_clear(&memory->arena);
    free(memory->primitives);
    free(memory);
}
