#include <string.h>

#include "scene/parser.h"

/* What names of modifiers mean, and which of them may follow each other. */

/* The line below on which the name is defined, or 0. */
static int line_below(const pm_reading *r, const pm_word *name)
{
    pm_lexer lexer = r->arguments;
    pm_statement s = *r->statement;
    size_t reals;
    if (r->record)
        return 0;
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
        if (pm_primitive_is_surface(parser->primitives[i].type) &&
            pm_word_is(name, parser->primitives[i].name))
            return &parser->primitives[i];
    return NULL;
}

static pm_status undefined_error(const pm_reading *r, const pm_word *name, const char *file)
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
    if (pm_word_is(name, "inherit"))
        return pm_word_error(name, PM_E_SYNTAX, file, err,
                             "inherit can only stand before alias; name a modifier, or void");
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

pm_status pm_parser_reference(const pm_reading *r, const pm_word *name, const char *file,
                              int32_t *out)
{
    *out = PM_VOID;
    if (pm_word_is(name, "void"))
        return PM_OK;
    *out = pm_names_find(&r->parser->names, name);
    return *out < 0 ? undefined_error(r, name, file) : PM_OK;
}

/* ---- chains ---- */

static int32_t material_of(const pm_parser *parser, int32_t modifier)
{
    return modifier == PM_VOID ? PM_VOID : parser->primitives[modifier].material;
}

/* The name that stands for the primitive's modifier, and where. */
static const pm_word *modifier_word(const pm_reading *r, const char **file)
{
    const pm_frame *frame = r->frame;
    bool imposed = frame->modifier && pm_primitive_is_surface(r->result.type);
    *file = imposed ? frame->modifier_file : frame->file->name;
    return imposed ? frame->modifier : &r->statement->modifier;
}

/* Below a material come textures and patterns alone (Radiance's "conflicting material"); below
 * a mixture of materials nothing, as its own modifier would go unheard ("inappropriate
 * modifier"). */
static pm_status check_below(const pm_reading *r, const pm_primitive *p)
{
    const char *file;
    const pm_word *name = modifier_word(r, &file);
    int32_t below = material_of(r->parser, p->modifier);
    if (pm_primitive_is_material(p->type) && below != PM_VOID)
        return pm_word_error(
            name, PM_E_SYNTAX, file, r->parser->err,
            "a material cannot modify a material ('%.*s' is or leads to %s '%s'); name a "
            "texture, a pattern or void",
            PM_WORD_SHOW(*name), pm_primitive_type_name(r->parser->primitives[below].type),
            r->parser->primitives[below].name);
    bool mixes_materials = pm_primitive_is_mixture(p->type) && p->material >= 0 &&
                           (size_t)p->material == r->parser->count;
    if (mixes_materials && p->modifier != PM_VOID)
        return pm_word_error(name, PM_E_SYNTAX, file, r->parser->err,
                             "a mixture of materials takes no modifier of its own; write void "
                             "here, and modify the materials");
    return PM_OK;
}

static bool can_be_source(pm_primitive_type material)
{
    return material == PM_LIGHT || material == PM_GLOW || material == PM_SPOTLIGHT ||
           material == PM_ILLUM || pm_primitive_is_mixture(material);
}

static pm_status check_source(const pm_reading *r, const pm_primitive *p)
{
    const char *file;
    const pm_word *name = modifier_word(r, &file);
    if (p->type != PM_SOURCE || p->material == PM_VOID)
        return PM_OK;
    pm_primitive_type material = r->parser->primitives[p->material].type;
    if (can_be_source(material))
        return PM_OK;
    return pm_word_error(name, PM_E_RANGE, file, r->parser->err,
                         "a source of %s ('%.*s') gives no light; its material must be light, "
                         "glow, spotlight or illum",
                         pm_primitive_type_name(material), PM_WORD_SHOW(*name));
}

static void add_modifier(const pm_parser *parser, int32_t modifier, unsigned *depth,
                         unsigned *weight)
{
    if (modifier == PM_VOID)
        return;
    const pm_primitive *p = &parser->primitives[modifier];
    *depth = p->depth > *depth ? p->depth : *depth;
    *weight += p->weight;
}

static pm_status measure(const pm_reading *r, pm_primitive *p)
{
    unsigned depth = 0, weight = 1;
    add_modifier(r->parser, p->modifier, &depth, &weight);
    for (int i = 0; pm_primitive_is_mixture(p->type) && i < 2; i++)
        add_modifier(r->parser, p->references[i], &depth, &weight);
    if (depth == PM_MODIFIERS_MAX || weight > PM_MODIFIERS_ASKED_MAX)
        return PM_READING_FAIL(r, &r->statement->type, PM_E_LIMIT,
                               "more than %d modifiers follow each other here, or more than %d "
                               "are mixed; write a shorter chain",
                               PM_MODIFIERS_MAX, PM_MODIFIERS_ASKED_MAX);
    p->depth = (uint8_t)(depth + 1);
    p->weight = (uint16_t)weight;
    return PM_OK;
}

/* The primitive in hand gets the number parser->count. */
static int32_t own_material(const pm_parser *parser, const pm_primitive *p)
{
    bool own = pm_primitive_is_material(p->type);
    for (int i = 0; pm_primitive_is_mixture(p->type) && i < 2; i++)
        own = own || material_of(parser, p->references[i]) != PM_VOID;
    return own ? (int32_t)parser->count : material_of(parser, p->modifier);
}

pm_status pm_parser_chain(const pm_reading *r, pm_primitive *p)
{
    p->material = own_material(r->parser, p);
    pm_status st = measure(r, p);
    if (!st)
        st = check_below(r, p);
    return st ? st : check_source(r, p);
}

pm_status pm_parser_modifier(pm_reading *r)
{
    const char *file;
    const pm_word *name = modifier_word(r, &file);
    pm_status st = PM_OK;
    if (r->record)
        r->result.modifier = r->record_modifier;
    else
        st = pm_parser_reference(r, name, file, &r->result.modifier);
    if (!st)
        r->result.modifier_name = pm_names_text(&r->parser->names, name);
    return st;
}
