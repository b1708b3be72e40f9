#include "scene/freeze.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/maths.h"
#include "scene/assets.h"
#include "scene/names.h"
#include "scene/types.h"

struct freezer {
    const pm_scene *scene;
    const pm_bundle *bundle;
    pm_arena *arena;
    pm_arena scratch;
    pm_names names; /* what each means where the primitive in hand stands */
    pm_error *err;
};

static pm_status memory_error(const struct freezer *f)
{
    return pm_error_set(f->err, PM_E_MEMORY, "not enough memory to freeze the scene");
}

/* ---- strings ---- */

/* Strings of a record, as many as were counted before. */
struct strings {
    const char **items;
    uint32_t count;
};

static pm_word word_of(const char *text)
{
    return (pm_word){.text = text, .length = strlen(text)};
}

/* The name by which a record's string says the modifier. */
static pm_status name_of(struct freezer *f, const pm_primitive *p, uint32_t k, const char **out)
{
    int32_t reference = p->references[k];
    if (reference == PM_VOID) {
        *out = p->strings[k]; /* void, or a name that is none */
        return PM_OK;
    }
    *out = f->scene->primitives[reference].name;
    const pm_word name = word_of(*out);
    if (pm_names_find(&f->names, &name) == reference)
        return PM_OK;
    return pm_error_set_at(f->err, PM_E_UNSUPPORTED, f->scene->files[p->file], p->line,
                           p->column,
                           "%s '%.60s' names '%.60s', which has been defined again since; a "
                           "frozen octree cannot tell them apart: give one another name",
                           pm_primitive_type_name(p->type), p->name, *out);
}

/* The name that leads to the file from the top of the bundle; Radiance looks there alone. One
 * above the top stays as it was written. */
static const char *file_name(const struct freezer *f, const pm_primitive *p, uint32_t k)
{
    const pm_file *file = pm_bundle_find(f->bundle, p->strings[k], f->scene->files[p->file]);
    const pm_file *at_top = pm_bundle_find(f->bundle, p->strings[k], NULL);
    return file && file != at_top && file->name[0] != '^' ? file->name : p->strings[k];
}

static pm_status add_strings(struct freezer *f, const pm_primitive *p, struct strings *out)
{
    pm_status st = PM_OK;
    for (uint32_t k = 0; !st && k < p->string_count; k++) {
        char role = pm_type_string_role(pm_type_get(p->type), k, SIZE_MAX);
        const char **string = &out->items[out->count++];
        *string = p->strings[k];
        if (role == 'm')
            st = name_of(f, p, k, string);
        else if (strchr("dpbctog", role) || (role == 'x' && strcmp(*string, ".") != 0))
            *string = file_name(f, p, k);
    }
    return st;
}

/* ---- the words of a text ---- */

/* Text behind a "." is an asset: its words joined by blanks, and a newline. */
static const pm_asset *own_text(const struct freezer *f, const pm_primitive *p)
{
    uint32_t last = p->string_count - 1;
    if (!p->string_count || !p->assets || p->assets[last] == PM_NO_ASSET ||
        pm_type_string_role(pm_type_get(p->type), last, SIZE_MAX) != 'x' ||
        strcmp(p->strings[last], ".") != 0)
        return NULL;
    return pm_assets_at(f->scene->assets, p->assets[last]);
}

static size_t count_words(const pm_asset *text)
{
    size_t count = 1;
    for (size_t i = 0; text && i < text->text.size; i++)
        count += text->text.bytes[i] == ' ';
    return text ? count : 0;
}

static bool add_words(const struct freezer *f, const pm_asset *text, struct strings *out)
{
    const char *at = text->text.bytes, *end = at + text->text.size;
    while (at < end) {
        const char *stop = at;
        while (stop < end && *stop != ' ' && *stop != '\n')
            stop++;
        const char *word = pm_arena_text(f->arena, at, (size_t)(stop - at));
        if (!word)
            return false;
        out->items[out->count++] = word;
        at = stop + 1;
    }
    return true;
}

/* ---- the words of a transform ---- */

enum { TRANSFORM_WORDS = 13 };

static bool add_word(const struct freezer *f, const char *word, struct strings *out)
{
    return (out->items[out->count++] = pm_arena_text(f->arena, word, strlen(word))) != NULL;
}

static bool add_number(const struct freezer *f, const char *option, double value,
                       struct strings *out)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    return (!option || add_word(f, option, out)) && add_word(f, text, out);
}

/* Angles [deg] so that turning about x, then y, then z is `m` (row vectors). */
static void angles_of(double m[3][3], double angle[3])
{
    double across = sqrt(m[0][0] * m[0][0] + m[0][1] * m[0][1]);
    bool locked = across < 0x1p-40; /* y turns x upon z: the other two are one */
    angle[0] = locked ? pm_atan2(-m[2][1], m[1][1]) : pm_atan2(m[1][2], m[2][2]);
    angle[1] = pm_atan2(-m[0][2], across);
    angle[2] = locked ? 0 : pm_atan2(m[0][1], m[0][0]);
    for (int i = 0; i < 3; i++)
        angle[i] *= 180 / PM_PI;
}

/* Mirror, scale, turn, shift: each only where it does something. */
static bool add_transform(const struct freezer *f, const pm_transform *t, struct strings *out)
{
    static const char *const turns[] = {"-rx", "-ry", "-rz"};
    double m[3][3], angle[3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            m[i][k] = t->turn[i][k] / (t->mirrored && i == 0 ? -t->scale : t->scale);
    angles_of(m, angle);
    if (t->mirrored && !add_word(f, "-mx", out))
        return false;
    if (t->scale != 1 && !add_number(f, "-s", t->scale, out))
        return false;
    for (int i = 0; i < 3; i++)
        if (angle[i] != 0 && !add_number(f, turns[i], angle[i], out))
            return false;
    if (t->shift[0] == 0 && t->shift[1] == 0 && t->shift[2] == 0)
        return true;
    for (int i = 0; i < 3; i++)
        if (!add_number(f, i ? NULL : "-t", t->shift[i], out))
            return false;
    return true;
}

/* ---- records ---- */

static pm_status freeze(struct freezer *f, size_t index, pm_record *out)
{
    const pm_primitive *p = &f->scene->primitives[index];
    const pm_asset *text = own_text(f, p);
    size_t room = p->string_count + count_words(text) + (p->transform ? TRANSFORM_WORDS : 0);
    struct strings strings = {.items = pm_arena_array(f->arena, room, sizeof(char *))};
    if (!strings.items)
        return memory_error(f);
    pm_status st = add_strings(f, p, &strings);
    if (!st && text && !add_words(f, text, &strings))
        st = memory_error(f);
    if (!st && p->transform && !add_transform(f, p->transform, &strings))
        st = memory_error(f);
    const pm_word name = word_of(p->name);
    if (!st && !pm_primitive_is_surface(p->type) &&
        pm_names_set(&f->names, &name, (int32_t)index))
        st = memory_error(f);
    *out = (pm_record){.type = pm_primitive_type_name(p->type),
                       .name = p->name,
                       .strings = strings.items,
                       .string_count = strings.count,
                       .reals = p->reals,
                       .real_count = p->real_count,
                       .modifier = p->modifier};
    return st;
}

pm_status pm_scene_freeze(const pm_scene *scene, const pm_bundle *bundle, pm_arena *arena,
                          pm_record **out, pm_error *err)
{
    struct freezer f = {.scene = scene, .bundle = bundle, .arena = arena, .err = err};
    f.names.arena = &f.scratch;
    pm_record *records = pm_arena_array(arena, scene->main_count, sizeof *records);
    pm_status st = records ? PM_OK : memory_error(&f);
    for (size_t i = 0; !st && i < scene->main_count; i++)
        st = freeze(&f, i, &records[i]);
    pm_arena_clear(&f.scratch);
    if (!st)
        *out = records;
    return st;
}
