#include "scene/types.h"

#include <stdio.h>
#include <string.h>

enum { MANY = INT32_MAX };

#define ONE(n)        (1U << (n))
#define RGB           "red green blue"
#define TWO_ENDS      "x0 y0 z0 x1 y1 z1"
#define CENTER_RADIUS "xcenter ycenter zcenter radius"
#define PLASTIC       RGB " specularity roughness"
#define MIST          "rext gext bext ralb galb balb g"
#define TYPE(T, ...)  [T] = {__VA_ARGS__}

static const pm_type types[PM_PRIMITIVE_TYPES] = {
    TYPE(PM_LIGHT, "light", 0, 0, ONE(3), "3 reals: " RGB, RGB),
    TYPE(PM_GLOW, "glow", 0, 0, ONE(4), "4 reals: " RGB " maxrad", RGB " maxrad"),
    TYPE(PM_SPOTLIGHT, "spotlight", 0, 0, ONE(7), "7 reals: " RGB " angle xdir ydir zdir",
         RGB " angle xdir ydir zdir"),
    TYPE(PM_ILLUM, "illum", 0, 1, ONE(3), "3 reals: " RGB, RGB),
    TYPE(PM_PLASTIC, "plastic", 0, 0, ONE(5), "5 reals: " PLASTIC, PLASTIC),
    TYPE(PM_METAL, "metal", 0, 0, ONE(5), "5 reals: " PLASTIC, PLASTIC),
    TYPE(PM_TRANS, "trans", 0, 0, ONE(7), "7 reals: " PLASTIC " trans tspec",
         PLASTIC " trans tspec"),
    TYPE(PM_GLASS, "glass", 0, 0, ONE(3) | ONE(4),
         "3 reals: rtn gtn btn, or 4 with the index of refraction", "rtn gtn btn index"),
    TYPE(PM_DIELECTRIC, "dielectric", 0, 0, ONE(5), "5 reals: rtn gtn btn n hc",
         "rtn gtn btn n hc"),
    TYPE(PM_MIRROR, "mirror", 0, 1, ONE(3), "3 reals: " RGB, RGB),
    TYPE(PM_MIST, "mist", 0, MANY, ONE(0) | ONE(3) | ONE(6) | ONE(7),
         "0, 3, 6 or 7 reals: " MIST, MIST),
    TYPE(PM_ANTIMATTER, "antimatter", 1, MANY, ONE(0), "0 reals", ""),
    TYPE(PM_POLYGON, "polygon", 0, 0, 0, "3 reals a vertex, and at least 3 vertices", ""),
    TYPE(PM_SPHERE, "sphere", 0, 0, ONE(4), "4 reals: " CENTER_RADIUS, CENTER_RADIUS),
    TYPE(PM_BUBBLE, "bubble", 0, 0, ONE(4), "4 reals: " CENTER_RADIUS, CENTER_RADIUS),
    TYPE(PM_CONE, "cone", 0, 0, ONE(8), "8 reals: " TWO_ENDS " r0 r1", TWO_ENDS " r0 r1"),
    TYPE(PM_CUP, "cup", 0, 0, ONE(8), "8 reals: " TWO_ENDS " r0 r1", TWO_ENDS " r0 r1"),
    TYPE(PM_CYLINDER, "cylinder", 0, 0, ONE(7), "7 reals: " TWO_ENDS " radius",
         TWO_ENDS " radius"),
    TYPE(PM_TUBE, "tube", 0, 0, ONE(7), "7 reals: " TWO_ENDS " radius", TWO_ENDS " radius"),
    TYPE(PM_RING, "ring", 0, 0, ONE(8), "8 reals: xcenter ycenter zcenter xdir ydir zdir r0 r1",
         "xcenter ycenter zcenter xdir ydir zdir r0 r1"),
    TYPE(PM_SOURCE, "source", 0, 0, ONE(4), "4 reals: xdir ydir zdir angle",
         "xdir ydir zdir angle"),
};

/* The rest of Radiance's types (src/common/otypes.h). */
static const char *const not_offered[] = {
    "texfunc",    "texdata",    "instance",   "mesh",      "plastic2",  "metal2",
    "trans2",     "ashik2",     "interface",  "plasfunc",  "metfunc",   "transfunc",
    "BRTDfunc",   "BSDF",       "aBSDF",      "plasdata",  "metdata",   "transdata",
    "brightfunc", "brightdata", "brighttext", "colorfunc", "colordata", "colortext",
    "colorpict",  "mixfunc",    "mixdata",    "mixtext",   "mixpict",   "prism1",
    "prism2",
};

static const char offered[] =
    "offered are the materials light glow spotlight illum plastic metal trans glass dielectric "
    "mirror mist antimatter and the surfaces polygon sphere bubble cone cup cylinder tube ring "
    "source";

const pm_type *pm_type_get(pm_primitive_type type)
{
    return &types[type];
}

const char *pm_primitive_type_name(pm_primitive_type type)
{
    return types[type].name;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Edits (insert, delete, replace) that turn the word into the name (Wagner and Fischer 1974).
 */
static size_t edit_distance(const pm_word *word, const char *name)
{
    enum { LONGEST = 16 };
    size_t length = strlen(name), row[LONGEST + 1];
    if (length > LONGEST || word->length > LONGEST)
        return LONGEST;
    for (size_t j = 0; j <= length; j++)
        row[j] = j;
    for (size_t i = 1; i <= word->length; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= length; j++) {
            size_t replaced = diagonal + (word->text[i - 1] != name[j - 1]);
            diagonal = row[j];
            row[j] = least(replaced, least(row[j], row[j - 1]) + 1);
        }
    }
    return row[length];
}

static const char *closest_type(const pm_word *word)
{
    size_t best = 3; /* two edits at most: more is another word */
    const char *name = NULL;
    for (size_t i = 0; i < PM_PRIMITIVE_TYPES; i++) {
        size_t distance = edit_distance(word, types[i].name);
        if (distance < best && distance < strlen(types[i].name)) {
            best = distance;
            name = types[i].name;
        }
    }
    return name;
}

pm_status pm_type_find(const pm_word *word, const char *file, pm_primitive_type *type,
                       pm_error *err)
{
    for (size_t i = 0; i < PM_PRIMITIVE_TYPES; i++) {
        if (pm_word_is(word, types[i].name)) {
            *type = (pm_primitive_type)i;
            return PM_OK;
        }
    }
    for (size_t i = 0; i < sizeof not_offered / sizeof *not_offered; i++)
        if (pm_word_is(word, not_offered[i]))
            return pm_word_error(word, PM_E_UNSUPPORTED, file, err,
                                 "Radiance's type %s is not offered yet; %s", not_offered[i],
                                 offered);
    if (pm_word_is(word, "void"))
        return pm_word_error(
            word, PM_E_SYNTAX, file, err,
            "void is a modifier, but a type should come here; write the modifier "
            "first, then the type, then a name");
    const char *name = closest_type(word);
    if (name)
        return pm_word_error(word, PM_E_SYNTAX, file, err,
                             "'%.*s' is no primitive type; did you mean %s?",
                             PM_WORD_SHOW(*word), name);
    return pm_word_error(word, PM_E_SYNTAX, file, err, "'%.*s' is no primitive type; %s",
                         PM_WORD_SHOW(*word), offered);
}

void pm_type_real_name(pm_primitive_type type, size_t index, char *out, size_t size)
{
    if (type == PM_POLYGON) {
        snprintf(out, size, "%c of vertex %zu", "xyz"[index % 3], index / 3 + 1);
        return;
    }
    const char *at = types[type].real_names;
    for (size_t i = 0; i < index; i++)
        at += strcspn(at, " ") + 1;
    snprintf(out, size, "%.*s", (int)strcspn(at, " "), at);
}
