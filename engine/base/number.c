#include "base/number.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
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

static bool read_decimal(const char *at, size_t length, struct decimal *d)
{
    const char *end = at + length;
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
static pm_number slow_real(const char *word, size_t length, double *value)
{
    char text[256];
    if (length >= sizeof text)
        return PM_NUMBER_MALFORMED;
    memcpy(text, word, length);
    text[length] = '\0';
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

pm_number pm_number_real(const char *text, size_t length, double *value)
{
    static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    struct decimal d;
    if (!read_decimal(text, length, &d))
        return PM_NUMBER_MALFORMED;
    /* Both factors are exact doubles, so one operation rounds once (Clinger 1990). */
    if (!d.exact || d.mantissa > (1ULL << 53) || d.exponent < -22 || d.exponent > 22)
        return extended_real(&d, value) ? PM_NUMBER_OK : slow_real(text, length, value);
    double m = (double)d.mantissa;
    m = d.exponent < 0 ? m / power[-d.exponent] : m * power[d.exponent];
    *value = d.negative ? 0 - m : m; /* "-0" is 0: one value, one digest */
    return PM_NUMBER_OK;
}

pm_number pm_number_integer(const char *text, size_t length, int64_t *value)
{
    struct decimal d;
    if (!read_decimal(text, length, &d))
        return PM_NUMBER_MALFORMED;
    for (size_t i = 0; i < length; i++)
        if (text[i] == '.' || text[i] == 'e' || text[i] == 'E')
            return PM_NUMBER_MALFORMED;
    if (!d.exact)
        return PM_NUMBER_HUGE;
    *value = d.negative ? -(int64_t)d.mantissa : (int64_t)d.mantissa;
    return PM_NUMBER_OK;
}
