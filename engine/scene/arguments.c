#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/check.h"
#include "scene/parser.h"

/* ---- counts ---- */

/* So that a false count cannot ask for more memory than the file is worth. */
static pm_status check_room(const pm_reading *r, const pm_word *count_word, size_t count)
{
    if (!r->record && count > (size_t)(r->lexer->end - r->lexer->at))
        return PM_READING_FAIL(r, count_word, PM_E_SYNTAX,
                               "%zu arguments are announced, but the file ends before", count);
    return PM_OK;
}

static pm_status string_count_error(const pm_reading *r, const pm_word *word, size_t count)
{
    return PM_READING_FAIL(r, word, PM_E_SYNTAX, "%s takes %s; here are %zu", r->rules->name,
                           r->rules->strings_takes, count);
}

/* ---- string arguments ---- */

static pm_word record_word(const char *text)
{
    return (pm_word){.text = text, .length = strlen(text)};
}

static pm_status count_strings(const pm_reading *r, pm_word *word, size_t *count)
{
    *word = r->statement->type;
    if (!r->record)
        return pm_statement_count(r->lexer, "string arguments", word, count, r->parser->err);
    *count = r->record->string_count;
    return PM_OK;
}

/* The words of the string arguments, in the parser's buffer. */
static pm_status read_words(pm_reading *r, size_t count)
{
    pm_parser *parser = r->parser;
    if (count > parser->word_capacity) {
        pm_word *more = realloc(parser->words, count * sizeof *more);
        if (!more)
            return pm_parser_memory_error(parser);
        parser->words = more;
        parser->word_capacity = count;
    }
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < count; i++)
        if (r->record)
            parser->words[i] = record_word(r->record->strings[i]);
        else
            st = pm_statement_word(r->lexer, "a string argument", &parser->words[i],
                                   parser->err);
    return st;
}

/* String arguments that are being resolved: the primitive's arrays, still to be written. */
struct strings {
    pm_reading *reading;
    const pm_word *words; /* [count], the transform's included */
    size_t count, own;    /* without the transform */
    const char **text;
    int32_t *references, *assets;
};

static bool allocate(struct strings *s)
{
    pm_arena *arena = s->reading->parser->arena;
    const char *roles = s->reading->rules->strings;
    s->text = pm_arena_array(arena, s->count, sizeof *s->text);
    bool made = s->text != NULL;
    if (strchr(roles, 'm')) {
        s->references = pm_arena_array(arena, s->count, sizeof *s->references);
        made = made && s->references;
    }
    if (strpbrk(roles, "dpbctxog")) {
        s->assets = pm_arena_array(arena, s->count, sizeof *s->assets);
        made = made && s->assets;
    }
    for (size_t i = 0; made && i < s->count; i++) {
        if (s->references)
            s->references[i] = PM_VOID;
        if (s->assets)
            s->assets[i] = PM_NO_ASSET;
    }
    return made;
}

static pm_status copy_text(struct strings *s, size_t index)
{
    const pm_word *word = &s->words[index];
    s->text[index] = pm_arena_text(s->reading->parser->arena, word->text, word->length);
    return s->text[index] ? PM_OK : pm_parser_memory_error(s->reading->parser);
}

static const char *kind_name(char role)
{
    switch (role) {
    case 'd':
        return "data file";
    case 'p':
        return "picture";
    case 'b':
        return "BSDF file";
    case 'c':
        return "function file";
    case 't':
        return "font";
    case 'x':
        return "text";
    case 'o':
        return "octree";
    default:
        return "mesh";
    }
}

/* The bundle's file, or the function file of that name that comes with the program. */
static pm_status find_file(const struct strings *s, size_t index, char role, pm_file *storage,
                           const pm_file **out)
{
    const pm_reading *r = s->reading;
    const char *name = s->text[index];
    *out = pm_bundle_find(r->parser->bundle, name, r->frame->file->name);
    if (*out)
        return PM_OK;
    if (role == 'c' || role == 't') {
        *storage = (pm_file){.name = name};
        storage->data = (const uint8_t *)(role == 'c' ? pm_language_standard
                                                      : pm_font_standard)(name, &storage->size);
        *out = storage;
        if (storage->data)
            return PM_OK;
    }
    return PM_READING_FAIL(
        r, &s->words[index], PM_E_MISSING,
        "there is no %s '%.*s', neither beside this file nor beside the main "
        "file",
        kind_name(role), PM_WORD_SHOW(s->words[index]));
}

static pm_asset_kind asset_kind(char role)
{
    switch (role) {
    case 'd':
        return PM_ASSET_DATA;
    case 'p':
        return PM_ASSET_PICTURE;
    case 'b':
        return PM_ASSET_BSDF;
    case 'c':
        return PM_ASSET_FUNCTIONS;
    case 't':
        return PM_ASSET_FONT;
    default:
        return PM_ASSET_TEXT;
    }
}

/* All data files of a primitive are asked at the same coordinates. */
static pm_status note_dimensions(pm_reading *r, int32_t asset, const pm_word *word)
{
    unsigned dimensions = pm_data_dimensions(pm_assets_at(r->parser->assets, asset)->data);
    if (r->dimensions && r->dimensions != dimensions)
        return PM_READING_FAIL(
            r, word, PM_E_RANGE,
            "'%.*s' has %u dimensions, the data file before it %u; they must "
            "have as many",
            PM_WORD_SHOW(*word), dimensions, r->dimensions);
    if (r->result.type == PM_SPECFILE && dimensions != 1)
        return PM_READING_FAIL(r, word, PM_E_RANGE,
                               "'%.*s' has %u dimensions; a spectrum has one, the wavelength",
                               PM_WORD_SHOW(*word), dimensions);
    if (r->result.type == PM_SPECDATA && dimensions < 2)
        return PM_READING_FAIL(r, word, PM_E_RANGE,
                               "'%.*s' has 1 dimension; specdata takes 2 or more, of which the "
                               "last is the wavelength",
                               PM_WORD_SHOW(*word));
    r->dimensions = dimensions - (r->result.type == PM_SPECDATA);
    return PM_OK;
}

/* specpict takes spectra, the others colours. */
static pm_status check_picture(const pm_reading *r, int32_t asset, const pm_word *word)
{
    double nm0, nm1;
    const pm_picture *picture = pm_assets_at(r->parser->assets, asset)->picture;
    bool spectral = pm_picture_bands(picture, &nm0, &nm1) > 0;
    if (spectral == (r->result.type == PM_SPECPICT))
        return PM_OK;
    return PM_READING_FAIL(r, word, PM_E_MISMATCH, "'%.*s' holds %s; %s takes a picture of %s",
                           PM_WORD_SHOW(*word), spectral ? "spectra" : "colours",
                           r->rules->name, spectral ? "colours" : "spectra (Radiance_spectra)");
}

static pm_status load_file(struct strings *s, size_t index, char role)
{
    pm_reading *r = s->reading;
    pm_parser *parser = r->parser;
    pm_file standard;
    const pm_file *file;
    pm_status st = find_file(s, index, role, &standard, &file);
    if (st)
        return st;
    if (role == 'o' || role == 'g')
        return pm_parser_prototype(r, file, &s->words[index], &s->assets[index]);
    st = pm_assets_load(parser->assets, asset_kind(role), file, &s->assets[index], parser->err);
    if (st)
        return st;
    if (role == 'c')
        r->context = pm_assets_at(parser->assets, s->assets[index])->context;
    if (role == 'p')
        return check_picture(r, s->assets[index], &s->words[index]);
    return role == 'd' ? note_dimensions(r, s->assets[index], &s->words[index]) : PM_OK;
}

/* The text of colortext and its like: a file, or the words after a ".", joined by blanks. */
static pm_status load_text(struct strings *s, size_t index)
{
    pm_parser *parser = s->reading->parser;
    if (!pm_word_is(&s->words[index], ".")) {
        if (index + 1 < s->count)
            return string_count_error(s->reading, &s->words[index + 1], s->count);
        return load_file(s, index, 'x');
    }
    size_t size = 0;
    for (size_t i = index + 1; i < s->count; i++)
        size += s->words[i].length + 1;
    char *text = pm_arena_alloc(parser->arena, size + 1), *at = text;
    if (!text)
        return pm_parser_memory_error(parser);
    for (size_t i = index + 1; i < s->count; i++) {
        memcpy(at, s->words[i].text, s->words[i].length);
        at += s->words[i].length;
        *at++ = i + 1 < s->count ? ' ' : '\n';
    }
    s->own = index + 1;
    return pm_assets_add_text(parser->assets, text, size, &s->assets[index], parser->err);
}

/* What is no function: those need the function file, which comes after them. */
static pm_status resolve_name(struct strings *s, size_t index, char role)
{
    const pm_reading *r = s->reading;
    switch (role) {
    case 'm':
        return pm_parser_reference(r, &s->words[index], r->frame->file->name,
                                   &s->references[index]);
    case 'x':
        return load_text(s, index);
    case 'c':
        if (pm_word_is(&s->words[index], "."))
            return PM_OK;
        return load_file(s, index, role);
    case 's':
    case 'e':
    case 'f':
        return PM_OK;
    default:
        return load_file(s, index, role);
    }
}

static pm_status resolve_names(struct strings *s)
{
    pm_status st = PM_OK;
    s->own = s->count;
    for (size_t i = 0; !st && i < s->own; i++) {
        char role = pm_type_string_role(s->reading->rules, i, s->reading->dimensions);
        if (!role) {
            s->own = i;
            break;
        }
        st = copy_text(s, i);
        if (!st)
            st = resolve_name(s, i, role);
    }
    return st;
}

/* As many expressions as the data have dimensions, then nothing but a transform. */
static pm_status check_own_count(const struct strings *s)
{
    const pm_type *rules = s->reading->rules;
    size_t least = pm_type_strings_least(rules) +
                   s->reading->dimensions * (strpbrk(rules->strings, "+&") != NULL);
    bool rest_is_right = s->own == s->count || strchr(rules->strings, 'x') ||
                         (pm_type_takes_transform(rules) && s->words[s->own].text[0] == '-');
    if (s->own >= least && rest_is_right)
        return PM_OK;
    return string_count_error(s->reading, &s->words[rest_is_right ? 0 : s->own], s->count);
}

static pm_status read_transform(const struct strings *s)
{
    pm_reading *r = s->reading;
    size_t count = s->count - s->own;
    if (!pm_type_takes_transform(r->rules) || !count)
        return PM_OK;
    pm_transform *transform = pm_arena_alloc(r->parser->arena, sizeof *transform);
    if (!transform)
        return pm_parser_memory_error(r->parser);
    r->result.transform = transform;
    return pm_xform_parse_transform(s->words + s->own, count, r->frame->file->name, transform,
                                    r->parser->err);
}

static pm_status resolve_strings(pm_reading *r, const pm_word *count_word, size_t count)
{
    struct strings s = {.reading = r, .words = r->parser->words, .count = count};
    if (!allocate(&s))
        return pm_parser_memory_error(r->parser);
    if (count < pm_type_strings_least(r->rules))
        return string_count_error(r, count_word, count);
    pm_status st = resolve_names(&s);
    if (!st)
        st = check_own_count(&s);
    if (!st)
        st = read_transform(&s);
    r->result.strings = s.text;
    r->result.references = s.references;
    r->result.assets = s.assets;
    r->result.string_count = (uint32_t)s.own;
    return st;
}

static pm_status read_strings(pm_reading *r)
{
    pm_word word;
    size_t count;
    pm_status st = count_strings(r, &word, &count);
    if (st)
        return st;
    bool fixed = !strpbrk(r->rules->strings, "*x+&") && !pm_type_takes_transform(r->rules);
    if (count < pm_type_strings_least(r->rules) ||
        (fixed && count > strcspn(r->rules->strings, "?")))
        return string_count_error(r, &word, count);
    st = check_room(r, &word, count);
    if (!st && count)
        st = read_words(r, count);
    return st || !count ? st : resolve_strings(r, &word, count);
}

/* ---- integer and real arguments ---- */

static pm_status read_integers(pm_reading *r)
{
    pm_word word;
    size_t count;
    if (r->record)
        return PM_OK; /* it has none */
    pm_status st =
        pm_statement_count(r->lexer, "integer arguments", &word, &count, r->parser->err);
    if (!st && count)
        return PM_READING_FAIL(
            r, &word, PM_E_SYNTAX,
            "no primitive takes integer arguments; write 0, then the count of reals");
    return st;
}

static bool count_is_right(const pm_reading *r, size_t count)
{
    if (r->result.type == PM_POLYGON)
        return count >= 9 && count % 3 == 0 && count <= UINT32_MAX;
    if (r->rules->least && count >= r->rules->least)
        return count <= UINT32_MAX;
    return count < 32 && (r->rules->counts >> count & 1);
}

static pm_status real_error(const pm_reading *r, const pm_word *word, size_t index,
                            pm_number number)
{
    char name[64];
    pm_type_real_name(r->result.type, index, name, sizeof name);
    if (number == PM_NUMBER_HUGE)
        return PM_READING_FAIL(r, word, PM_E_RANGE,
                               "%s's %s is %.*s, larger than a double holds", r->rules->name,
                               name, PM_WORD_SHOW(*word));
    return PM_READING_FAIL(
        r, word, PM_E_SYNTAX,
        "'%.*s' is no number; real %zu of %s's %u should come here, its %s%s",
        PM_WORD_SHOW(*word), index + 1, r->rules->name, r->result.real_count, name,
        word->text[0] == '#' ? " (a comment cannot stand inside a primitive)" : "");
}

static pm_status read_real(const pm_reading *r, size_t index, double *out)
{
    pm_word word;
    if (r->record) {
        *out = r->record->reals[index];
        return PM_OK;
    }
    pm_status st = pm_lexer_word(r->lexer, &word, r->parser->err);
    if (st)
        return st;
    if (!word.text)
        return PM_READING_FAIL(
            r, &word, PM_E_SYNTAX,
            "the file ends inside a primitive; real %zu of %s's %u should come here", index + 1,
            r->rules->name, r->result.real_count);
    pm_number number = pm_word_real(&word, out);
    return number ? real_error(r, &word, index, number) : PM_OK;
}

/* The word `index` places after the lexer's. */
static pm_word word_at(pm_lexer lexer, size_t index)
{
    pm_word word = {0};
    for (size_t i = 0; i <= index; i++)
        if (pm_lexer_word(&lexer, &word, NULL))
            break;
    return word;
}

static pm_status check_values(const pm_reading *r, const double *reals, const pm_lexer *place)
{
    size_t index;
    const char *right = pm_check_reals(r->result.type, reals, r->result.real_count, &index);
    if (!right)
        return PM_OK;
    char name[64], number[32];
    snprintf(number, sizeof number, "%.9g", reals[index]);
    pm_word word = place ? word_at(*place, index) : record_word(number);
    pm_type_real_name(r->result.type, index, name, sizeof name);
    return PM_READING_FAIL(r, &word, PM_E_RANGE, "%s's %s is %.*s; %s", r->rules->name, name,
                           PM_WORD_SHOW(word), right);
}

/* The frame's transform moves what the reals say, or what the primitive's own transform says.
 */
static pm_status move(pm_reading *r, double *reals)
{
    const pm_frame *frame = r->frame;
    const char *reason;
    if (!frame->moved)
        return PM_OK;
    if (pm_type_takes_transform(r->rules)) {
        pm_transform *moved = pm_arena_alloc(r->parser->arena, sizeof *moved);
        if (!moved)
            return pm_parser_memory_error(r->parser);
        *moved = r->result.transform ? pm_transform_then(r->result.transform, &frame->transform)
                                     : frame->transform;
        r->result.transform = moved;
    }
    pm_status st = pm_transform_primitive(&frame->transform, frame->inverted, &r->result.type,
                                          reals, r->result.real_count, &reason);
    if (st)
        return PM_READING_FAIL(r, &r->statement->type, st, "xform cannot move '%.*s': %s",
                               PM_WORD_SHOW(r->statement->name), reason);
    return PM_OK;
}

static pm_status count_reals(const pm_reading *r, pm_word *word, size_t *count)
{
    *word = r->statement->type;
    if (!r->record)
        return pm_statement_count(r->lexer, "real arguments", word, count, r->parser->err);
    *count = r->record->real_count;
    return PM_OK;
}

static pm_status read_reals(pm_reading *r)
{
    pm_word word;
    size_t count;
    pm_status st = count_reals(r, &word, &count);
    if (st)
        return st;
    if (!count_is_right(r, count))
        return PM_READING_FAIL(r, &word, PM_E_SYNTAX, "%s takes %s; here are %zu",
                               r->rules->name, r->rules->reals_takes, count);
    st = check_room(r, &word, count);
    if (st)
        return st;
    r->parser->reals += count;
    if (r->parser->reals > r->parser->limits.reals)
        return PM_READING_FAIL(r, &word, PM_E_LIMIT,
                               "the scene has more than %zu reals; split it",
                               r->parser->limits.reals);
    double *reals = pm_arena_array(r->parser->arena, count, sizeof *reals);
    if (!reals)
        return pm_parser_memory_error(r->parser);
    const pm_lexer place = r->record ? (pm_lexer){0} : *r->lexer;
    r->result.real_count = (uint32_t)count;
    r->result.reals = reals;
    for (size_t i = 0; !st && i < count; i++)
        st = read_real(r, i, &reals[i]);
    if (!st)
        st = check_values(r, reals, r->record ? NULL : &place);
    if (st)
        return st;
    pm_check_canonical(&r->result.type, reals, &r->result.real_count);
    st = move(r, reals);
    r->result.empty = r->result.type == PM_POLYGON && !pm_check_has_area(reals, count);
    return st;
}

/* ---- functions ---- */

/* Where a string argument goes: 'e' expressions, 'f' functions of data, '&' functions of a
 * direction; 0 elsewhere. */
static char group_of(const pm_reading *r, size_t index)
{
    const char *roles = r->rules->strings;
    char role = pm_type_string_role(r->rules, index, r->dimensions);
    if (role == 'f' && index >= strcspn(roles, "?*+&"))
        return '&';
    return role == 'e' || role == 'f' ? role : 0;
}

/* Compiles the strings of one group into one function with a result for each. */
static pm_status compile_group(pm_reading *r, char group, unsigned arguments, pm_function *out)
{
    struct pm_language_text texts[PM_LANGUAGE_TEXTS];
    unsigned count = 0;
    for (size_t i = 0; i < r->result.string_count; i++) {
        const pm_word *word = &r->parser->words[i];
        if (group_of(r, i) != group)
            continue;
        texts[count++] = (struct pm_language_text){r->result.strings[i], r->frame->file->name,
                                                   word->line, word->column};
    }
    const struct pm_function_request request = {.context = r->context,
                                                .texts = texts,
                                                .text_count = count,
                                                .arg_count = arguments,
                                                .reals = r->result.reals,
                                                .real_count = r->result.real_count};
    *out = PM_NO_FUNCTION;
    if (!count)
        return PM_OK;
    return pm_language_compile(pm_assets_language(r->parser->assets), &request, out,
                               r->parser->err);
}

static void find_lone_functions(pm_reading *r)
{
    if (r->result.type != PM_COLORDATA && r->result.type != PM_COLORPICT)
        return;
    const pm_language *language = pm_assets_language(r->parser->assets);
    for (unsigned i = 0; i < 3; i++) {
        unsigned parameters = 0;
        pm_language_meaning(language, r->context, r->result.strings[i], &parameters);
        if (parameters < 3)
            r->result.lone_functions |= (uint8_t)(1U << i);
    }
}

static pm_status compile_functions(pm_reading *r)
{
    enum { DIRECTION = 4 }; /* and the source's solid angle */
    find_lone_functions(r);
    pm_status st = compile_group(r, 'e', 0, &r->result.expressions);
    if (!st)
        st = compile_group(r, 'f', r->rules->arguments, &r->result.functions);
    if (!st)
        st = compile_group(r, '&', DIRECTION, &r->result.coordinates);
    return st;
}

/* Textures and patterns are asked before there is what these values are made of. */
static pm_status check_values_used(pm_reading *r)
{
    const pm_language *language = pm_assets_language(r->parser->assets);
    const pm_function functions[] = {r->result.expressions, r->result.functions};
    uint64_t uses = 0;
    if (pm_primitive_is_material(r->result.type))
        return PM_OK;
    for (int i = 0; i < 2; i++)
        if (functions[i] != PM_NO_FUNCTION)
            uses |= pm_function_uses(language, functions[i]);
    if (!(uses & (PM_RAY_OF_MATERIALS | PM_RAY_OF_PRISMS)))
        return PM_OK;
    return PM_READING_FAIL(r, &r->statement->type, PM_E_MISSING,
                           "%s '%.*s' uses one of NxP NyP NzP RdotP CrP CgP CbP DxA DyA DzA, "
                           "which only materials have",
                           r->rules->name, PM_WORD_SHOW(r->statement->name));
}

pm_status pm_parser_arguments(pm_reading *r)
{
    pm_status st = read_strings(r);
    if (!st)
        st = read_integers(r);
    if (!st)
        st = read_reals(r);
    if (!st)
        st = compile_functions(r);
    return st ? st : check_values_used(r);
}
