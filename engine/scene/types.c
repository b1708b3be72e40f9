#include "scene/types.h"

#include <stdio.h>
#include <string.h>

#define ONE(n)        (1U << (n))
#define RGB           "red green blue"
#define TWO_ENDS      "x0 y0 z0 x1 y1 z1"
#define CENTER_RADIUS "xcenter ycenter zcenter radius"
#define PLASTIC       RGB " specularity roughness"
#define PLASTIC2      RGB " specularity urough vrough"
#define DIFFUSE3      "rfdif gfdif bfdif rbdif gbdif bbdif rtdif gtdif btdif"
#define MIST          "rext gext bext ralb galb balb g"
#define PLACE         "Ox Oy Oz Ax Ay Az Dx Dy Dz"
#define INK           "rfore gfore bfore rback gback bback"
#define NO_STRINGS    "no string arguments"
#define ORIENTED      "4 string arguments and a transform: ux uy uz funcfile"
#define ANY           "any number of reals, those of its functions"
#define TYPE(T, ...)  [T] = {__VA_ARGS__}

static const pm_type types[PM_PRIMITIVE_TYPES] = {
    TYPE(PM_LIGHT, "light", "", 0, NO_STRINGS, ONE(3), 0, "3 reals: " RGB, RGB),
    TYPE(PM_GLOW, "glow", "", 0, NO_STRINGS, ONE(4), 0, "4 reals: " RGB " maxrad",
         RGB " maxrad"),
    TYPE(PM_SPOTLIGHT, "spotlight", "", 0, NO_STRINGS, ONE(7), 0,
         "7 reals: " RGB " angle xdir ydir zdir", RGB " angle xdir ydir zdir"),
    TYPE(PM_ILLUM, "illum", "m?", 0, "at most 1 string argument: its alternate material",
         ONE(3), 0, "3 reals: " RGB, RGB),
    TYPE(PM_PLASTIC, "plastic", "", 0, NO_STRINGS, ONE(5), 0, "5 reals: " PLASTIC, PLASTIC),
    TYPE(PM_METAL, "metal", "", 0, NO_STRINGS, ONE(5), 0, "5 reals: " PLASTIC, PLASTIC),
    TYPE(PM_TRANS, "trans", "", 0, NO_STRINGS, ONE(7), 0, "7 reals: " PLASTIC " trans tspec",
         PLASTIC " trans tspec"),
    TYPE(PM_PLASTIC2, "plastic2", "eeec", 0, ORIENTED, ONE(6), 0, "6 reals: " PLASTIC2,
         PLASTIC2),
    TYPE(PM_METAL2, "metal2", "eeec", 0, ORIENTED, ONE(6), 0, "6 reals: " PLASTIC2, PLASTIC2),
    TYPE(PM_TRANS2, "trans2", "eeec", 0, ORIENTED, ONE(8), 0,
         "8 reals: " PLASTIC2 " trans tspec", PLASTIC2 " trans tspec"),
    TYPE(PM_ASHIK2, "ashik2", "eeec", 0, ORIENTED, ONE(8), 0,
         "8 reals: "
         "dred dgrn dblu sred sgrn sblu u-power v-power",
         "dred dgrn dblu sred sgrn sblu u-power v-power"),
    TYPE(PM_GLASS, "glass", "", 0, NO_STRINGS, ONE(3) | ONE(4), 0,
         "3 reals: rtn gtn btn, or 4 with the index of refraction", "rtn gtn btn index"),
    TYPE(PM_DIELECTRIC, "dielectric", "", 0, NO_STRINGS, ONE(5), 0,
         "5 reals: "
         "rtn gtn btn n hc",
         "rtn gtn btn n hc"),
    TYPE(PM_INTERFACE, "interface", "", 0, NO_STRINGS, ONE(8), 0,
         "8 reals: "
         "rtn1 gtn1 btn1 n1 rtn2 gtn2 btn2 n2",
         "rtn1 gtn1 btn1 n1 rtn2 gtn2 btn2 n2"),
    TYPE(PM_MIRROR, "mirror", "m?", 0, "at most 1 string argument: its alternate material",
         ONE(3), 0, "3 reals: " RGB, RGB),
    TYPE(PM_PRISM1, "prism1", "eeeec", 0,
         "5 string arguments and a transform: coef dx dy dz funcfile", ONE(0), 1, ANY, ""),
    TYPE(PM_PRISM2, "prism2", "eeeeeeeec", 0,
         "9 string arguments and a transform: coef1 dx1 dy1 dz1 coef2 dx2 dy2 dz2 funcfile",
         ONE(0), 1, ANY, ""),
    TYPE(PM_PLASFUNC, "plasfunc", "fc", 4, "2 string arguments and a transform: refl funcfile",
         0, 4, "at least 4 reals: " RGB " specularity, then those of the function",
         RGB " specularity"),
    TYPE(PM_METFUNC, "metfunc", "fc", 4, "2 string arguments and a transform: refl funcfile", 0,
         4, "at least 4 reals: " RGB " specularity, then those of the function",
         RGB " specularity"),
    TYPE(PM_TRANSFUNC, "transfunc", "fc", 4,
         "2 string arguments and a transform: brtd funcfile", 0, 6,
         "at least 6 reals: " RGB " rspec trans tspec, then those of the function",
         RGB " rspec trans tspec"),
    TYPE(PM_BRTDFUNC, "BRTDfunc", "eeeeeefffc", 4,
         "10 string arguments and a transform: rrefl grefl brefl rtrns gtrns btrns rbrtd gbrtd "
         "bbrtd funcfile",
         0, 9, "at least 9 reals: " DIFFUSE3 ", then those of the functions", DIFFUSE3),
    TYPE(PM_PLASDATA, "plasdata", "fdc&", 5,
         "3 string arguments, one for each dimension of the data, and a transform: func "
         "datafile funcfile x1 x2 ...",
         0, 4, "at least 4 reals: " RGB " specularity, then those of the function",
         RGB " specularity"),
    TYPE(PM_METDATA, "metdata", "fdc&", 5,
         "3 string arguments, one for each dimension of the data, and a transform: func "
         "datafile funcfile x1 x2 ...",
         0, 4, "at least 4 reals: " RGB " specularity, then those of the function",
         RGB " specularity"),
    TYPE(PM_TRANSDATA, "transdata", "fdc&", 5,
         "3 string arguments, one for each dimension of the data, and a transform: func "
         "datafile funcfile x1 x2 ...",
         0, 6, "at least 6 reals: " RGB " rspec trans tspec, then those of the function",
         RGB " rspec trans tspec"),
    TYPE(PM_BSDF, "BSDF", "ebeeec", 0,
         "6 string arguments and a transform: thick BSDFfile ux uy uz funcfile",
         ONE(0) | ONE(3) | ONE(6) | ONE(9), 0, "0, 3, 6 or 9 reals: " DIFFUSE3, DIFFUSE3),
    TYPE(PM_ABSDF, "aBSDF", "beeec", 0,
         "5 string arguments and a transform: BSDFfile ux uy uz funcfile",
         ONE(0) | ONE(3) | ONE(6) | ONE(9), 0, "0, 3, 6 or 9 reals: " DIFFUSE3, DIFFUSE3),
    TYPE(PM_MIST, "mist", "s*", 0, "", ONE(0) | ONE(3) | ONE(6) | ONE(7), 0,
         "0, 3, 6 or 7 reals: " MIST, MIST),
    TYPE(PM_ANTIMATTER, "antimatter", "mm*", 0,
         "at least 1 string argument: the materials it cuts", ONE(0), 0, "0 reals", ""),
    TYPE(PM_TEXFUNC, "texfunc", "eeec", 0,
         "4 string arguments and a transform: xpert ypert zpert funcfile", ONE(0), 1, ANY, ""),
    TYPE(PM_TEXDATA, "texdata", "fffdddc+", 3,
         "7 string arguments, one for each dimension of the data, and a transform: xfunc yfunc "
         "zfunc xdatafile ydatafile zdatafile funcfile x0 x1 ...",
         ONE(0), 1, ANY, ""),
    TYPE(PM_COLORFUNC, "colorfunc", "eeec", 0,
         "4 string arguments and a transform: rexp gexp bexp funcfile", ONE(0), 1, ANY, ""),
    TYPE(PM_BRIGHTFUNC, "brightfunc", "ec", 0,
         "2 string arguments and a transform: refl funcfile", ONE(0), 1, ANY, ""),
    TYPE(PM_COLORDATA, "colordata", "fffdddc+", 3,
         "7 string arguments, one for each dimension of the data, and a transform: rfunc gfunc "
         "bfunc rdatafile gdatafile bdatafile funcfile x1 x2 ...",
         ONE(0), 1, ANY, ""),
    TYPE(PM_BRIGHTDATA, "brightdata", "fdc+", 1,
         "3 string arguments, one for each dimension of the data, and a transform: func "
         "datafile funcfile x1 x2 ...",
         ONE(0), 1, ANY, ""),
    TYPE(PM_COLORPICT, "colorpict", "fffpcee", 3,
         "7 string arguments and a transform: rfunc gfunc bfunc pictfile funcfile u v", ONE(0),
         1, ANY, ""),
    TYPE(PM_COLORTEXT, "colortext", "tx", 0,
         "2 string arguments, fontfile textfile, or at least 3: fontfile . and the words of "
         "the text",
         ONE(15), 16, "at least 15 reals: " PLACE " " INK ", then spacings", PLACE " " INK),
    TYPE(PM_BRIGHTTEXT, "brighttext", "tx", 0,
         "2 string arguments, fontfile textfile, or at least 3: fontfile . and the words of "
         "the text",
         ONE(11), 12, "at least 11 reals: " PLACE " foreground background, then spacings",
         PLACE " foreground background"),
    TYPE(PM_SPECTRUM, "spectrum", "", 0, NO_STRINGS, 0, 5,
         "at least 5 reals: the first and the last wavelength [nm], then 3 values or more",
         "nm0 nmN"),
    TYPE(PM_SPECFILE, "specfile", "d", 0, "1 string argument: datafile", ONE(0), 1, "no reals",
         ""),
    TYPE(PM_SPECFUNC, "specfunc", "fc", 1, "2 string arguments and a transform: func funcfile",
         0, 2,
         "at least 2 reals: the shortest and the longest wavelength [nm], then those of the "
         "function",
         "nmA nmB"),
    TYPE(PM_SPECDATA, "specdata", "fdc+", 2,
         "3 string arguments, one for each dimension of the data but the last, and a transform: "
         "func datafile funcfile x1 x2 ...",
         ONE(0), 1, ANY, ""),
    TYPE(PM_SPECPICT, "specpict", "fpcee", 2,
         "5 string arguments and a transform: func pictfile funcfile u v", ONE(0), 1, ANY, ""),
    TYPE(PM_MIXFUNC, "mixfunc", "mmec", 0,
         "4 string arguments and a transform: foreground background vname funcfile", ONE(0), 1,
         ANY, ""),
    TYPE(PM_MIXDATA, "mixdata", "mmfdc+", 1,
         "5 string arguments, one for each dimension of the data, and a transform: foreground "
         "background func datafile funcfile x1 x2 ...",
         ONE(0), 1, ANY, ""),
    TYPE(PM_MIXPICT, "mixpict", "mmfpcee", 3,
         "7 string arguments and a transform: foreground background func pictfile funcfile u v",
         ONE(0), 1, ANY, ""),
    TYPE(PM_MIXTEXT, "mixtext", "mmtx", 0,
         "4 string arguments, foreground background fontfile textfile, or at least 5: "
         "foreground background fontfile . and the words of the text",
         ONE(9), 10, "at least 9 reals: " PLACE ", then spacings", PLACE),
    TYPE(PM_POLYGON, "polygon", "", 0, NO_STRINGS, 0, 0,
         "3 reals a vertex, and at least 3 vertices", ""),
    TYPE(PM_SPHERE, "sphere", "", 0, NO_STRINGS, ONE(4), 0, "4 reals: " CENTER_RADIUS,
         CENTER_RADIUS),
    TYPE(PM_BUBBLE, "bubble", "", 0, NO_STRINGS, ONE(4), 0, "4 reals: " CENTER_RADIUS,
         CENTER_RADIUS),
    TYPE(PM_CONE, "cone", "", 0, NO_STRINGS, ONE(8), 0, "8 reals: " TWO_ENDS " r0 r1",
         TWO_ENDS " r0 r1"),
    TYPE(PM_CUP, "cup", "", 0, NO_STRINGS, ONE(8), 0, "8 reals: " TWO_ENDS " r0 r1",
         TWO_ENDS " r0 r1"),
    TYPE(PM_CYLINDER, "cylinder", "", 0, NO_STRINGS, ONE(7), 0, "7 reals: " TWO_ENDS " radius",
         TWO_ENDS " radius"),
    TYPE(PM_TUBE, "tube", "", 0, NO_STRINGS, ONE(7), 0, "7 reals: " TWO_ENDS " radius",
         TWO_ENDS " radius"),
    TYPE(PM_RING, "ring", "", 0, NO_STRINGS, ONE(8), 0,
         "8 reals: "
         "xcenter ycenter zcenter xdir ydir zdir r0 r1",
         "xcenter ycenter zcenter xdir ydir zdir r0 r1"),
    TYPE(PM_SOURCE, "source", "", 0, NO_STRINGS, ONE(4), 0,
         "4 reals: "
         "xdir ydir zdir angle",
         "xdir ydir zdir angle"),
    TYPE(PM_INSTANCE, "instance", "o", 0, "1 string argument and a transform: octree", ONE(0),
         0, "0 reals", ""),
    TYPE(PM_MESH, "mesh", "g", 0, "1 string argument and a transform: meshfile", ONE(0), 0,
         "0 reals", ""),
};

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
    return pm_word_error(word, PM_E_SYNTAX, file, err,
                         "'%.*s' is no primitive type of Radiance; after the modifier comes "
                         "one, such as plastic, light, polygon or sphere",
                         PM_WORD_SHOW(*word));
}

void pm_type_real_name(pm_primitive_type type, size_t index, char *out, size_t size)
{
    if (type == PM_POLYGON) {
        snprintf(out, size, "%c of vertex %zu", "xyz"[index % 3], index / 3 + 1);
        return;
    }
    const char *at = types[type].real_names;
    for (size_t i = 0; i < index && *at; i++)
        at += strcspn(at, " ") + (at[strcspn(at, " ")] == ' ');
    if (!*at)
        snprintf(out, size, "A%zu", index + 1);
    else
        snprintf(out, size, "%.*s", (int)strcspn(at, " "), at);
}

static size_t fixed_letters(const pm_type *type)
{
    return strcspn(type->strings, "?*+&");
}

char pm_type_string_role(const pm_type *type, size_t index, size_t dimensions)
{
    size_t fixed = fixed_letters(type);
    if (index < fixed)
        return type->strings[index];
    switch (type->strings[fixed]) {
    case '*':
        return type->strings[fixed - 1];
    case '+':
        return index - fixed < dimensions ? 'e' : 0;
    case '&':
        return index - fixed < dimensions ? 'f' : 0;
    default:
        return 0;
    }
}

size_t pm_type_strings_least(const pm_type *type)
{
    size_t fixed = fixed_letters(type);
    char tail = type->strings[fixed];
    return fixed - (tail == '?' || tail == '*');
}

bool pm_type_takes_transform(const pm_type *type)
{
    return strpbrk(type->strings, "cog") != NULL;
}
