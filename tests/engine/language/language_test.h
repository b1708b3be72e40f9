#ifndef PM_TESTS_LANGUAGE_TEST_H
#define PM_TESTS_LANGUAGE_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "language/language.h"

/* A language with one file, `f.cal`, and a ray whose values are all different. */
struct bench {
    pm_language *language;
    uint32_t context;
    struct pm_ray_values ray;
    double reals[24];
    unsigned faults;    /* of the last value */
    char message[1200]; /* of the last error, else empty */
    pm_status status;   /* of the last read or compile */
};

static inline void bench_failed(struct bench *b, pm_status status, const pm_error *err)
{
    b->status = status;
    b->message[0] = '\0';
    if (!status)
        return;
    assert_int_equal(err->status, status);
    pm_error_format(err, b->message, sizeof b->message);
}

static inline void bench_read(struct bench *b, const char *file, const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_language_read(b->language, file, text, strlen(text), &b->context, &err);
    bench_failed(b, st, &err);
}

/* With `text` read; its errors are left to the caller. */
static inline struct bench bench_of(const char *text)
{
    struct bench b = {.language = pm_language_new(PM_LANGUAGE_SCENE)};
    static const double ray[] = {
        .36, .48, -.8, .1, -.3, .948, 1.3, -2.4, .7, 12.5, .77,  2,  1,  2,  3,  1, 0,  0, 0,
        1,   0,   0,   0,  1,   3.5,  .25, .75,  .2, -.25, .947, .7, .5, .6, .7, 0, .6, .8};
    assert_non_null(b.language);
    memcpy(b.ray.value, ray, sizeof ray);
    bench_read(&b, "f.cal", text);
    return b;
}

static inline void bench_reals(struct bench *b, uint32_t count, const double *reals)
{
    memcpy(b->reals, reals, count * sizeof *reals);
    b->ray.real_count = count;
}

static inline pm_status bench_compile(struct bench *b, const char *text, unsigned arg_count,
                                      bool known_reals, pm_function *out)
{
    pm_error err = PM_ERROR_INIT;
    const struct pm_language_text where = {text, "main.rad", 3, 5};
    const struct pm_function_request request = {.context = b->context,
                                                .texts = &where,
                                                .text_count = 1,
                                                .arg_count = arg_count,
                                                .reals = known_reals ? b->reals : NULL,
                                                .real_count = b->ray.real_count};
    pm_status st = pm_language_compile(b->language, &request, out, &err);
    bench_failed(b, st, &err);
    return st;
}

/* The value with real arguments from the ray, which must be the value with them folded in. */
static inline double bench_value(struct bench *b, const char *text)
{
    pm_function loose, folded;
    double value, same;
    b->ray.reals = b->reals;
    if (bench_compile(b, text, 0, false, &loose))
        fail_msg("%s: %s", text, b->message);
    if (bench_compile(b, text, 0, true, &folded))
        fail_msg("%s: %s", text, b->message);
    unsigned faults = pm_function_values(b->language, folded, &b->ray, NULL, 0, &same);
    b->faults = pm_function_values(b->language, loose, &b->ray, NULL, 0, &value);
    assert_int_equal(faults, b->faults);
    if (!(fabs(same - value) <= 1e-13 * fabs(value)))
        fail_msg("%s: %.17g folded, %.17g not", text, same, value);
    return value;
}

static inline void bench_near(struct bench *b, const char *text, double expected,
                              double tolerance)
{
    double value = bench_value(b, text);
    if (!(fabs(value - expected) <= tolerance * fmax(1, fabs(expected))))
        fail_msg("%s is %.17g, not %.17g", text, value, expected);
}

/* The message of reading `text` and then compiling `expression`. */
static inline void bench_refuses(const char *text, const char *expression, const char *message)
{
    struct bench b = bench_of(text);
    pm_function out;
    if (!b.status)
        bench_compile(&b, expression, 0, true, &out);
    if (strcmp(b.message, message) != 0)
        fail_msg("%.300s\n%s\n  says %s\n  not  %s", text, expression, b.message, message);
    pm_language_free(b.language);
}

/* Deepest rounding: a few dozen operations of 2^-53 each, none of which cancels. */
#define ROUNDING 1e-14

#endif
