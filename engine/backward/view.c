#include "backward/view.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/maths.h"

const char pm_view_letters[] = "vlhcas";

pm_view pm_view_default(void)
{
    return (pm_view){.direction = {0, 1, 0}, .up = {0, 0, 1}, .horizontal = 45, .vertical = 45};
}

/* ---- reading ---- */

/* The words of one text, with the place of the latest one. */
struct words {
    const char *at;   /* behind the latest word */
    const char *word; /* not terminated */
    size_t length;
    const char *name;
    const char *start; /* of the current line */
    int line;
    pm_error *err;
};

static pm_status fail(const struct words *words, pm_status status, const char *text)
{
    return pm_error_set_at(words->err, status, words->name, words->line,
                           (int)(words->word - words->start) + 1, "%s", text);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

/* The next word of the current line; false at its end. */
static bool next_word(struct words *words)
{
    while (is_blank(*words->at))
        words->at++;
    words->word = words->at;
    while (*words->at && *words->at != '\n' && !is_blank(*words->at))
        words->at++;
    words->length = (size_t)(words->at - words->word);
    return words->length > 0;
}

static bool next_line(struct words *words)
{
    words->at += strcspn(words->at, "\n");
    if (!*words->at)
        return false;
    words->start = ++words->at;
    words->line++;
    return true;
}

static bool word_is(const struct words *words, const char *text)
{
    return words->length == strlen(text) && !memcmp(words->word, text, words->length);
}

static pm_status read_number(struct words *words, double *out)
{
    char copy[64];
    if (!next_word(words))
        return fail(words, PM_E_SYNTAX, "a number is missing after the view option");
    if (words->length >= sizeof copy || strspn(words->word, "0123456789+-.eE") < words->length)
        return fail(words, PM_E_SYNTAX, "not a decimal number");
    memcpy(copy, words->word, words->length);
    copy[words->length] = 0;
    char *end;
    double value = strtod(copy, &end);
    if (*end)
        return fail(words, PM_E_SYNTAX, "not a decimal number");
    if (!isfinite(value))
        return fail(words, PM_E_RANGE, "the number is too large");
    *out = value;
    return PM_OK;
}

static pm_status read_vector(struct words *words, pm_vec3 *out)
{
    pm_vec3 v;
    pm_status st = read_number(words, &v.x);
    if (!st)
        st = read_number(words, &v.y);
    if (!st)
        st = read_number(words, &v.z);
    if (!st)
        *out = v;
    return st;
}

static pm_status read_type(const struct words *words, pm_view *view)
{
    const char *letter = words->length == 4 ? strchr(pm_view_letters, words->word[3]) : NULL;
    if (!letter)
        return fail(words, PM_E_SYNTAX,
                    "no view type; there are -vtv (perspective), -vtl (parallel), -vth "
                    "(hemispherical), -vtc (cylindrical), -vta (angular fisheye) and -vts "
                    "(stereographic)");
    view->type = (pm_view_type)(letter - pm_view_letters);
    return PM_OK;
}

static pm_status read_option(struct words *words, pm_view *view)
{
    if (word_is(words, "-vp"))
        return read_vector(words, &view->point);
    if (word_is(words, "-vd"))
        return read_vector(words, &view->direction);
    if (word_is(words, "-vu"))
        return read_vector(words, &view->up);
    if (word_is(words, "-vh"))
        return read_number(words, &view->horizontal);
    if (word_is(words, "-vv"))
        return read_number(words, &view->vertical);
    if (word_is(words, "-vo"))
        return read_number(words, &view->fore);
    if (word_is(words, "-va"))
        return read_number(words, &view->aft);
    if (word_is(words, "-vs"))
        return read_number(words, &view->shift);
    if (word_is(words, "-vl"))
        return read_number(words, &view->lift);
    if (words->length >= 3 && !memcmp(words->word, "-vt", 3))
        return read_type(words, view);
    return fail(words, PM_E_SYNTAX,
                "not a view option; those are -vt -vp -vd -vu -vh -vv -vs -vl -vo -va");
}

/* A view line starts with VIEW= or the name of a program that shows views (isview() in
 * Radiance's src/common/image.c), or directly with an option. Leaves the reader before the
 * first option. */
static bool starts_view(struct words *words)
{
    static const char *const programs[] = {"rvu", "rview", "rpict", "rpiece", "pinterp"};
    if (words->word[0] == '-') {
        words->at = words->word;
        return true;
    }
    if (words->length >= 5 && !memcmp(words->word, "VIEW=", 5)) {
        words->at = words->word + 5;
        return true;
    }
    const char *base = words->word;
    for (size_t i = 0; i < words->length; i++)
        base = words->word[i] == '/' ? words->word + i + 1 : base;
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++) {
        size_t length = strlen(programs[i]);
        if ((size_t)(words->at - base) == length && !memcmp(base, programs[i], length))
            return true;
    }
    return false;
}

/* Reads the current line; *found is set if it gave an option. */
static pm_status read_line(struct words *words, pm_view *view, bool *found)
{
    pm_status st = PM_OK;
    if (!next_word(words) || words->word[0] == '#')
        return PM_OK;
    if (!starts_view(words))
        return fail(words, PM_E_SYNTAX,
                    "not a view line; it would start with rvu, rpict, VIEW= or an option");
    while (!st && next_word(words)) {
        st = read_option(words, view);
        *found = true;
    }
    return st;
}

pm_status pm_view_parse(const char *text, const char *name, pm_view *view, pm_error *err)
{
    struct words words = {
        .at = text, .word = text, .name = name, .start = text, .line = 1, .err = err};
    pm_view read = *view;
    bool found = false;
    do {
        pm_status st = read_line(&words, &read, &found);
        if (st)
            return st;
    } while (next_line(&words));
    if (!found)
        return pm_error_set_at(err, PM_E_SYNTAX, name, 1, 1,
                               "no view in here; a line like \"rvu -vtv -vp 0 1 -4 -vd 0 0 1 "
                               "-vu 0 1 0 -vh 40 -vv 40\" would be one");
    *view = read;
    return PM_OK;
}

/* ---- checking and writing ---- */

pm_vec3 pm_view_unit(pm_vec3 v)
{
    double greatest = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    if (!(greatest > 0))
        return (pm_vec3){0, 0, 0};
    return pm_vec3_normalize((pm_vec3){v.x / greatest, v.y / greatest, v.z / greatest});
}

/* The greatest size that the type shows; exclusive where the projection is infinite there. */
static const struct bound {
    double horizontal, vertical;
    bool open[2];
} bounds[PM_VIEW_TYPES] = {
    [PM_VIEW_PERSPECTIVE] = {180, 180, {true, true}},
    [PM_VIEW_PARALLEL] = {INFINITY, INFINITY, {true, true}},
    [PM_VIEW_HEMISPHERICAL] = {180, 180, {false, false}},
    [PM_VIEW_CYLINDRICAL] = {360, 180, {false, true}},
    [PM_VIEW_ANGULAR] = {360, 360, {false, false}},
    [PM_VIEW_STEREOGRAPHIC] = {360, 360, {true, true}},
};

static pm_status check_size(const char *option, double size, double bound, bool open,
                            double extent, pm_error *err)
{
    bool within = size > 0 && (open ? size < bound : size <= bound);
    if (within && isfinite(extent) && extent > 0)
        return PM_OK;
    if (isinf(bound))
        return pm_error_set(err, PM_E_RANGE,
                            "the parallel view's size (%s) is %g; it must be a length greater "
                            "than 0",
                            option, size);
    return pm_error_set(err, PM_E_RANGE,
                        "the view's angle (%s) is %g degrees; for this type it must be greater "
                        "than 0 and %s %g",
                        option, size, open ? "less than" : "at most", bound);
}

static pm_status check_clipping(const pm_view *view, pm_error *err)
{
    if (!isfinite(view->shift) || !isfinite(view->lift) || !isfinite(view->fore) ||
        !isfinite(view->aft))
        return pm_error_set(err, PM_E_RANGE, "the view has a number that is not finite");
    if (view->fore < 0)
        return pm_error_set(err, PM_E_RANGE,
                            "the fore clipping distance (-vo) is %g; it must not be negative",
                            view->fore);
    if (view->aft < 0 || (view->aft > 0 && view->aft <= view->fore))
        return pm_error_set(err, PM_E_RANGE,
                            "the aft clipping distance (-va) is %g; it must be 0 for none, or "
                            "greater than the fore one (-vo %g)",
                            view->aft, view->fore);
    return PM_OK;
}

pm_status pm_view_check(const pm_view *view, pm_error *err)
{
    /* Radiance's bound on the sine between direction and up (FTINY in setview(), image.c). */
    const double least_sine = 1e-6;
    if (!pm_vec3_finite(view->point) || !pm_vec3_finite(view->direction) ||
        !pm_vec3_finite(view->up))
        return pm_error_set(err, PM_E_RANGE, "the view has a number that is not finite");
    pm_vec3 direction = pm_view_unit(view->direction), up = pm_view_unit(view->up);
    if (pm_vec3_length(direction) == 0)
        return pm_error_set(err, PM_E_RANGE, "the view direction (-vd) is zero");
    if (pm_vec3_length(up) == 0)
        return pm_error_set(err, PM_E_RANGE, "the view's up vector (-vu) is zero");
    if (pm_vec3_length(pm_vec3_cross(direction, up)) <= least_sine)
        return pm_error_set(err, PM_E_RANGE,
                            "the view's up vector (-vu) is parallel to its "
                            "direction (-vd)");
    const struct bound *bound = &bounds[view->type];
    double x, y;
    pm_view_extent(view, &x, &y);
    pm_status st =
        check_size("-vh", view->horizontal, bound->horizontal, bound->open[0], x, err);
    if (!st)
        st = check_size("-vv", view->vertical, bound->vertical, bound->open[1], y, err);
    return st ? st : check_clipping(view, err);
}

/* The shortest decimal that reads back as the same number. */
static void format_number(double value, char out[32])
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(out, 32, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            return;
    }
}

static size_t put_number(char *out, size_t at, const char *before, double value)
{
    char text[32];
    format_number(value, text);
    return at + (size_t)snprintf(out + at, PM_VIEW_TEXT - at, "%s%s", before, text);
}

static size_t put_vector(char *out, size_t at, const char *before, pm_vec3 v)
{
    at = put_number(out, at, before, v.x);
    at = put_number(out, at, " ", v.y);
    return put_number(out, at, " ", v.z);
}

void pm_view_format(const pm_view *view, char out[PM_VIEW_TEXT])
{
    const struct {
        const char *option;
        double value;
    } rare[] = {{" -vo ", view->fore},
                {" -va ", view->aft},
                {" -vs ", view->shift},
                {" -vl ", view->lift}};
    size_t at = (size_t)snprintf(out, PM_VIEW_TEXT, "-vt%c", pm_view_letters[view->type]);
    at = put_vector(out, at, " -vp ", view->point);
    at = put_vector(out, at, " -vd ", view->direction);
    at = put_vector(out, at, " -vu ", view->up);
    at = put_number(out, at, " -vh ", view->horizontal);
    at = put_number(out, at, " -vv ", view->vertical);
    for (size_t i = 0; i < sizeof rare / sizeof *rare; i++)
        if (rare[i].value != 0)
            at = put_number(out, at, rare[i].option, rare[i].value);
}

/* ---- geometry ---- */

/* setview() in Radiance's src/common/image.c says which. */
static double extent(pm_view_type type, double size)
{
    double half = size * (PM_PI / 360);
    switch (type) {
    case PM_VIEW_PARALLEL:
        return size / 2;
    case PM_VIEW_HEMISPHERICAL:
        return pm_sin(half);
    case PM_VIEW_ANGULAR:
        return half;
    case PM_VIEW_STEREOGRAPHIC:
        return pm_tan(half / 2);
    default:
        return pm_tan(half);
    }
}

void pm_view_extent(const pm_view *view, double *x, double *y)
{
    bool cylinder = view->type == PM_VIEW_CYLINDRICAL;
    *x = extent(cylinder ? PM_VIEW_ANGULAR : view->type, view->horizontal);
    *y = extent(view->type, view->vertical);
}

/* normaspect() in Radiance's src/common/image.c. */
void pm_view_fit(const pm_view *view, double pixel_aspect, uint32_t *x, uint32_t *y)
{
    double width, height;
    if (!(pixel_aspect > 0))
        return;
    pm_view_extent(view, &width, &height);
    double aspect = height / width / pixel_aspect;
    if (aspect * *x > *y)
        *x = (uint32_t)fmax(1, *y / aspect + .5);
    else
        *y = (uint32_t)fmax(1, *x * aspect + .5);
}
