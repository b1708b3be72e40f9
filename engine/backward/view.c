#include "backward/view.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/maths.h"

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

/* Options whose neutral value alone is offered: clipping planes, shift and lift. */
static pm_status read_neutral(struct words *words, const char *refusal)
{
    double value;
    pm_status st = read_number(words, &value);
    if (!st && value != 0)
        return fail(words, PM_E_UNSUPPORTED, refusal);
    return st;
}

static pm_status read_type(struct words *words)
{
    if (word_is(words, "-vtv"))
        return PM_OK;
    return fail(words, PM_E_UNSUPPORTED, "this view type is not offered; perspective is -vtv");
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
        return read_neutral(words, "a fore clipping plane (-vo) is not offered; only -vo 0");
    if (word_is(words, "-va"))
        return read_neutral(words, "an aft clipping plane (-va) is not offered; only -va 0");
    if (word_is(words, "-vs"))
        return read_neutral(words, "a shifted view (-vs) is not offered; only -vs 0");
    if (word_is(words, "-vl"))
        return read_neutral(words, "a lifted view (-vl) is not offered; only -vl 0");
    if (words->length >= 3 && !memcmp(words->word, "-vt", 3))
        return read_type(words);
    return fail(words, PM_E_SYNTAX, "not a view option; those are -vtv -vp -vd -vu -vh -vv");
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

static double half_tangent(double degrees)
{
    return pm_tan(degrees * (PM_PI / 360));
}

static bool is_angle(double degrees)
{
    if (!(degrees > 0 && degrees < 180))
        return false;
    double tangent = half_tangent(degrees);
    return isfinite(tangent) && tangent > 0;
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
    if (!is_angle(view->horizontal))
        return pm_error_set(err, PM_E_RANGE,
                            "the view's horizontal angle (-vh) is %g degrees; "
                            "it must lie between 0 and 180",
                            view->horizontal);
    if (!is_angle(view->vertical))
        return pm_error_set(err, PM_E_RANGE,
                            "the view's vertical angle (-vv) is %g degrees; "
                            "it must lie between 0 and 180",
                            view->vertical);
    return PM_OK;
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

void pm_view_format(const pm_view *view, char *out, size_t size)
{
    const double values[11] = {view->point.x,     view->point.y,     view->point.z,
                               view->direction.x, view->direction.y, view->direction.z,
                               view->up.x,        view->up.y,        view->up.z,
                               view->horizontal,  view->vertical};
    char text[11][32];
    for (int i = 0; i < 11; i++)
        format_number(values[i], text[i]);
    snprintf(out, size, "-vtv -vp %s %s %s -vd %s %s %s -vu %s %s %s -vh %s -vv %s", text[0],
             text[1], text[2], text[3], text[4], text[5], text[6], text[7], text[8], text[9],
             text[10]);
}

/* normaspect() in Radiance's src/common/image.c, pixel aspect 1. */
void pm_view_fit(const pm_view *view, uint32_t *x, uint32_t *y)
{
    double aspect = half_tangent(view->vertical) / half_tangent(view->horizontal);
    if (aspect * *x > *y)
        *x = (uint32_t)fmax(1, *y / aspect + .5);
    else
        *y = (uint32_t)fmax(1, *x * aspect + .5);
}
