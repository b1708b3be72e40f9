#ifndef PM_GENERATE_FUNCTIONS_H
#define PM_GENERATE_FUNCTIONS_H

#include "generate/generation.h"
#include "language/language.h"

/* The functions of gensurf, genrev and genworm: arguments that are expressions of one or two
 * parameters, with definitions from -e and -f. */

enum { PM_FUNCTIONS_MOST = 4 };

typedef struct pm_functions {
    pm_generation *g;
    pm_language *language;
    const char *parameters; /* "t" or "s,t" */
    unsigned parameter_count;
    size_t words[PM_FUNCTIONS_MOST]; /* the expressions */
    unsigned count;
    pm_function all, valid;
    bool has_valid; /* -e or -f define valid(s,t) */
} pm_functions;

/* Takes the options behind the arguments: -e and -f here, others through `take`, which may be
 * NULL and is given each option in hand; *known is false if it is none of its own. */
typedef pm_status pm_take_switch(void *context, const char *option, bool *known);
PM_MUST_USE pm_status pm_functions_options(pm_functions *f, const char *others,
                                           pm_take_switch *take, void *context);

/* Makes the expressions of words `first` .. `first` + count - 1 functions, except the words of
 * which `skip` has the bit. */
PM_MUST_USE pm_status pm_functions_compile(pm_functions *f, size_t first, unsigned count,
                                           unsigned skip);

/* A number of parts, which may be an expression: at least 1. */
PM_MUST_USE pm_status pm_functions_count(pm_functions *f, size_t word, const char *what,
                                         int64_t *out);

/* All functions at the parameters, in order, skipped ones left alone. Where one is not defined,
 * as 1/0, its value is 0, as in Radiance. PM_E_LIMIT for a recursion without end,
 * and when the request's budget of work is used up. */
PM_MUST_USE pm_status pm_functions_values(const pm_functions *f, const double *parameters,
                                          double *out);

/* The functions of t at t = index / segments, of which the last is a radius: PM_E_RANGE below
 * 0, but for rounding. */
PM_MUST_USE pm_status pm_functions_along(const pm_functions *f, int64_t index, int64_t segments,
                                         double *out);

/* Whether valid(s,t) leaves the point in. */
PM_MUST_USE pm_status pm_functions_valid(const pm_functions *f, const double *parameters,
                                         bool *out);

void pm_functions_clear(pm_functions *f);

#endif
