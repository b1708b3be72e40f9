#include "scene/lexer.h"

#include <float.h>
#include <limits.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static bool is_control(char c)
{
    return (unsigned char)c < ' ' || c == 0x7F;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

pm_status pm_lexer_init(pm_lexer *lexer, const pm_file *file, pm_error *err)
{
    if (file->size >= INT_MAX)
        return pm_error_set_at(
            err, PM_E_LIMIT, file->name, 0, 0,
            "the file has %zu bytes; a scene file must be smaller than 2 GiB: "
            "split it and join the parts with !xform lines",
            file->size);
    const char *text = (const char *)file->data;
    *lexer = (pm_lexer){.at = text, .end = text + file->size, .line_start = text, .line = 1};
    lexer->file = file->name;
    if (file->size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) /* byte order mark */
        lexer->at = lexer->line_start = text + 3;
    return PM_OK;
}

int pm_lexer_peek(pm_lexer *lexer)
{
    const char *at = lexer->at;
    while (at < lexer->end && is_space(*at)) {
        if (*at++ == '\n') {
            lexer->line++;
            lexer->line_start = at;
        }
    }
    lexer->at = at;
    return at < lexer->end ? (unsigned char)*at : -1;
}

void pm_lexer_skip_line(pm_lexer *lexer)
{
    size_t left = (size_t)(lexer->end - lexer->at);
    const char *newline = left ? memchr(lexer->at, '\n', left) : NULL;
    lexer->at = newline ? newline : lexer->end;
}

static pm_status control_error(const pm_lexer *lexer, const char *at, pm_error *err)
{
    return pm_error_set_at(
        err, PM_E_SYNTAX, lexer->file, lexer->line, (int)(at - lexer->line_start) + 1,
        "byte 0x%02X is not text; a scene file is plain text", (unsigned)(unsigned char)*at);
}

static pm_status quoted_word(pm_lexer *lexer, pm_word *word, pm_error *err)
{
    char quote = *lexer->at;
    const char *start = lexer->at + 1;
    const char *at = start;
    while (at < lexer->end && *at != quote && *at != '\n') {
        if (is_control(*at) && !is_space(*at))
            return control_error(lexer, at, err);
        at++;
    }
    if (at == lexer->end || *at != quote)
        return pm_word_error(word, PM_E_SYNTAX, lexer->file, err,
                             "the quote %c opened here is not closed on its line; "
                             "close it with another %c",
                             quote, quote);
    word->text = start;
    word->length = (size_t)(at - start);
    lexer->at = at + 1;
    return PM_OK;
}

pm_status pm_lexer_word(pm_lexer *lexer, pm_word *word, pm_error *err)
{
    int first = pm_lexer_peek(lexer);
    const char *at = lexer->at;
    *word = (pm_word){.line = lexer->line, .column = (int)(at - lexer->line_start) + 1};
    if (first < 0)
        return PM_OK;
    if (first == '"' || first == '\'')
        return quoted_word(lexer, word, err);
    word->text = at;
    while (at < lexer->end && !is_space(*at)) {
        if (is_control(*at))
            return control_error(lexer, at, err);
        at++;
    }
    word->length = (size_t)(at - word->text);
    lexer->at = at;
    return PM_OK;
}

pm_status pm_word_error(const pm_word *word, pm_status status, const char *file, pm_error *err,
                        const char *format, ...)
{
    char text[sizeof err->text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return pm_error_set_at(err, status, file, word->line, word->column, "%s", text);
}

bool pm_word_is(const pm_word *word, const char *text)
{
    return word->text && strlen(text) == word->length &&
           memcmp(word->text, text, word->length) == 0;
}

/* A decimal number in pieces: (-1)^negative * mantissa * 10^exponent. */
struct decimal {
    uint64_t mantissa;
    int64_t exponent;
    bool negative;
    bool exact; /* mantissa holds all digits */
};

/* Digits beyond the 18th are left to the slow path, which reads the text again. */
static const char *read_digits(const char *at, const char *end, struct decimal *d, int step)
{
    while (at < end && is_digit(*at)) {
        if (d->mantissa < 100000000000000000U) {
            d->mantissa = 10 * d->mantissa + (uint64_t)(*at - '0');
            d->exponent -= step;
        } else {
            d->exact = false;
        }
        at++;
    }
    return at;
}

static bool read_exponent(const char *at, const char *end, int64_t *exponent)
{
    bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+'))
        at++;
    const char *start = at;
    int64_t value = 0;
    for (; at < end && is_digit(*at); at++)
        value = value < 100000 ? 10 * value + (*at - '0') : value;
    *exponent += negative ? -value : value;
    return at == end && at > start;
}

static bool read_decimal(const pm_word *word, struct decimal *d)
{
    const char *at = word->text, *end = at + word->length;
    *d = (struct decimal){.exact = true, .negative = at < end && *at == '-'};
    if (at < end && (*at == '-' || *at == '+'))
        at++;
    const char *start = at;
    at = read_digits(at, end, d, 0);
    ptrdiff_t digits = at - start;
    if (at < end && *at == '.') {
        start = at + 1;
        at = read_digits(start, end, d, 1);
        digits += at - start;
    }
    if (!digits)
        return false;
    if (at < end && (*at == 'e' || *at == 'E'))
        return read_exponent(at + 1, end, &d->exponent);
    return at == end;
}

/* For numbers that the fast path cannot round with one operation. */
static pm_number slow_real(const pm_word *word, double *value)
{
    char text[256];
    if (word->length >= sizeof text)
        return PM_NUMBER_MALFORMED;
    memcpy(text, word->text, word->length);
    text[word->length] = '\0';
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0); /* static in glibc */
    double result = c_locale ? strtod_l(text, NULL, c_locale) : NAN;
    if (c_locale)
        freelocale(c_locale);
    if (!isfinite(result))
        return PM_NUMBER_HUGE;
    *value = result + 0.0;
    return PM_NUMBER_OK;
}

#if LDBL_MANT_DIG == 64
/* One operation of extended precision rounds to 64 bits, and the result to 53. That is the
 * nearest double unless the first rounding fell upon the middle between two. */
static bool extended_real(const struct decimal *d, double *value)
{
    static const long double power[] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,
                                        1e7L,  1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L,
                                        1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L, 1e20L,
                                        1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L};
    if (!d->exact || d->exponent < -27 || d->exponent > 27)
        return false;
    long double m = (long double)d->mantissa;
    m = d->exponent < 0 ? m / power[-d->exponent] : m * power[d->exponent];
    uint64_t bits;
    memcpy(&bits, &m, sizeof bits); /* the significand of the x87 format comes first */
    *value = d->negative ? 0 - (double)m : (double)m;
    return (bits & 0x7FF) != 0x400;
}
#else
static bool extended_real(const struct decimal *d, double *value)
{
    (void)d, (void)value;
    return false;
}
#endif

pm_number pm_word_real(const pm_word *word, double *value)
{
    static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    struct decimal d;
    if (!read_decimal(word, &d))
        return PM_NUMBER_MALFORMED;
    /* Both factors are exact doubles, so one operation rounds once (Clinger 1990). */
    if (!d.exact || d.mantissa > (1ULL << 53) || d.exponent < -22 || d.exponent > 22)
        return extended_real(&d, value) ? PM_NUMBER_OK : slow_real(word, value);
    double m = (double)d.mantissa;
    m = d.exponent < 0 ? m / power[-d.exponent] : m * power[d.exponent];
    *value = d.negative ? 0 - m : m; /* "-0" is 0: one value, one digest */
    return PM_NUMBER_OK;
}

pm_number pm_word_integer(const pm_word *word, int64_t *value)
{
    struct decimal d;
    if (!read_decimal(word, &d))
        return PM_NUMBER_MALFORMED;
    for (size_t i = 0; i < word->length; i++)
        if (word->text[i] == '.' || word->text[i] == 'e' || word->text[i] == 'E')
            return PM_NUMBER_MALFORMED;
    if (!d.exact)
        return PM_NUMBER_HUGE;
    *value = d.negative ? -(int64_t)d.mantissa : (int64_t)d.mantissa;
    return PM_NUMBER_OK;
}
