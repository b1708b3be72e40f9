#include "generate/generation.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

/* ---- arguments ---- */

const char *pm_generation_word(const pm_generation *g)
{
    return g->at < g->request->count ? g->request->words[g->at] : NULL;
}

pm_status pm_generation_fail(pm_generation *g, size_t index, pm_status status,
                             const char *format, ...)
{
    char text[600];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    *g->wrong = index < g->request->count ? index : 0;
    return pm_error_set(g->err, status, "%s: %s", g->request->words[0], text);
}

static pm_status missing(pm_generation *g, const char *what)
{
    return pm_generation_fail(g, g->request->count - 1, PM_E_SYNTAX,
                              "%s is missing; it should come after '%.60s'", what,
                              g->request->words[g->request->count - 1]);
}

pm_status pm_take_real(pm_generation *g, const char *what, double *out)
{
    const char *word = pm_generation_word(g);
    if (!word)
        return missing(g, what);
    if (pm_number_real(word, strlen(word), out))
        return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                  "'%.60s' is no number; %s should come "
                                  "here",
                                  word, what);
    g->at++;
    return PM_OK;
}

pm_status pm_take_integer(pm_generation *g, const char *what, int64_t least, int64_t most,
                          int64_t *out)
{
    const char *word = pm_generation_word(g);
    if (!word)
        return missing(g, what);
    int64_t value;
    if (pm_number_integer(word, strlen(word), &value) || value < least || value > most)
        return pm_generation_fail(g, g->at, PM_E_RANGE,
                                  "'%.60s' should be %s, a whole number from %lld to %lld",
                                  word, what, (long long)least, (long long)most);
    *out = value;
    g->at++;
    return PM_OK;
}

enum { LONGEST_NAME = 1000 };

static bool is_plain(const char *word)
{
    if (!word[0] || strchr("!#\"'", word[0]) || strlen(word) > LONGEST_NAME)
        return false;
    for (; *word; word++)
        if ((unsigned char)*word <= ' ' || *word == 0x7F)
            return false;
    return true;
}

pm_status pm_take_names(pm_generation *g, const char **modifier, const char **name)
{
    const char **const names[] = {modifier, name};
    static const char *const what[] = {"the modifier", "the name"};
    for (int i = 0; i < 2; i++) {
        const char *word = pm_generation_word(g);
        if (!word)
            return missing(g, what[i]);
        if (!is_plain(word))
            return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                      "%s is '%.60s'; it must be one word of at most %d bytes "
                                      "that does not start with "
                                      "! # \" or '",
                                      what[i], word, LONGEST_NAME);
        *names[i] = word;
        g->at++;
    }
    return PM_OK;
}

/* ---- text ---- */

static uint64_t multiply(uint64_t a, uint64_t b)
{
    uint64_t product;
    return __builtin_mul_overflow(a, b, &product) ? UINT64_MAX : product;
}

bool pm_generation_begin(pm_generation *g, uint64_t primitives, uint64_t reals, size_t length)
{
    /* The longest real is -1.23456789012e-300 and a blank; type, counts and a number follow
     * each name. */
    enum { REAL = 20, STATEMENT = 100 };
    if (!g->size)
        return true;
    uint64_t bytes = multiply(primitives, STATEMENT + length);
    uint64_t numbers = multiply(reals, REAL);
    bytes = bytes > UINT64_MAX - numbers ? UINT64_MAX : bytes + numbers;
    *g->size = (pm_generate_size){primitives, reals, bytes};
    return false;
}

void pm_put(pm_generation *g, const char *format, ...)
{
    char text[4096];
    va_list args;
    va_start(args, format);
    int length = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (length >= (int)sizeof text)
        g->text.failed = true; /* not reached: names are shorter */
    else
        pm_bytes_append(&g->text, text, (size_t)length);
}

/* The decimal digits of 0 <= value < 1e12 rounded, without the zeros at their end, which go
 * into the exponent. */
static size_t write_digits(char *out, uint64_t value, int exponent)
{
    while (value % 10 == 0 && value) {
        value /= 10;
        exponent++;
    }
    if (exponent > 0 && exponent < 6) { /* 500, not 5e2 */
        for (; exponent; exponent--)
            value *= 10;
    }
    return (size_t)(exponent ? sprintf(out, "%llue%d", (unsigned long long)value, exponent)
                             : sprintf(out, "%llu", (unsigned long long)value));
}

void pm_put_real(pm_generation *g, double value)
{
    char text[40];
    double size = fabs(value);
    if (size == 0 || !(size >= 1e-12 && size < 1e12)) {
        pm_put(g, " %.12g", value + 0.0);
        return;
    }
    /* 12 digits fit a long double's 64 bits with room to spare, so one product rounds rightly
     * but for ties. */
    static const long double power[] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,
                                        1e7L,  1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L,
                                        1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L, 1e20L,
                                        1e21L, 1e22L, 1e23L, 1e24L};
    int shift = 0;
    while (shift < 24 && (long double)size * power[shift] < 1e11L)
        shift++;
    long double scaled = (long double)size * power[shift];
    size_t length = 0;
    text[length++] = ' ';
    if (value < 0)
        text[length++] = '-';
    length += write_digits(text + length, (uint64_t)(scaled + 0.5L), -shift);
    pm_bytes_append(&g->text, text, length);
}

void pm_put_point(pm_generation *g, const double p[3])
{
    for (int i = 0; i < 3; i++)
        pm_put_real(g, p[i]);
    pm_put(g, "\n");
}

pm_status pm_generation_end(pm_generation *g)
{
    if (pm_bytes_status(&g->text))
        return pm_error_set(g->err, PM_E_MEMORY, "not enough memory for what %s makes",
                            g->request->words[0]);
    pm_status st = g->text.size ? g->sink(g->sink_context, g->text.data, g->text.size) : PM_OK;
    g->text.size = 0;
    return st;
}

pm_status pm_generation_pass(pm_generation *g)
{
    static const size_t piece = (size_t)1 << 20;
    return g->text.size < piece && !g->text.failed ? PM_OK : pm_generation_end(g);
}
