#ifndef PM_GENERATE_GENERATION_H
#define PM_GENERATE_GENERATION_H

#include "base/bytes.h"
#include "generate/generate.h"

/* One run of a generator: what the programs share. */
typedef struct pm_generation {
    const pm_generate_request *request;
    size_t at;              /* the word in hand */
    pm_generate_size *size; /* to be filled when only measuring; else NULL */
    pm_generate_sink *sink;
    void *sink_context;
    pm_bytes text;
    size_t *wrong;
    pm_error *err;
} pm_generation;

/* The programs. */
PM_MUST_USE pm_status pm_genbox(pm_generation *g);
PM_MUST_USE pm_status pm_genprism(pm_generation *g);
PM_MUST_USE pm_status pm_genblinds(pm_generation *g);
PM_MUST_USE pm_status pm_gensurf(pm_generation *g);
PM_MUST_USE pm_status pm_genrev(pm_generation *g);
PM_MUST_USE pm_status pm_genworm(pm_generation *g);
PM_MUST_USE pm_status pm_gensky(pm_generation *g);
PM_MUST_USE pm_status pm_gendaylit(pm_generation *g);

/* ---- arguments ---- */

/* The word in hand, NULL past the last. */
const char *pm_generation_word(const pm_generation *g);

/* Refuses the word of that index; the text is put behind the program's name. */
pm_status pm_generation_fail(pm_generation *g, size_t index, pm_status status,
                             const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Take the word in hand, which must be there; `what` names it in messages: "xsize". */
PM_MUST_USE pm_status pm_take_real(pm_generation *g, const char *what, double *out);
PM_MUST_USE pm_status pm_take_integer(pm_generation *g, const char *what, int64_t least,
                                      int64_t most, int64_t *out);

/* Words 1 and 2: the modifier and the name of what is made. They must be single plain words,
 * so that they cannot bring primitives or commands of their own into the text. */
PM_MUST_USE pm_status pm_take_names(pm_generation *g, const char **modifier, const char **name);

/* ---- text ---- */

/* Between reading the arguments and writing: true if text is wanted, false after noting the
 * size when only measuring. `length` is that of modifier and name together. */
bool pm_generation_begin(pm_generation *g, uint64_t primitives, uint64_t reals, size_t length);

void pm_put(pm_generation *g, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A number with 12 significant digits, as Radiance's %18.12g but without its blanks. */
void pm_put_real(pm_generation *g, double value);
void pm_put_point(pm_generation *g, const double p[3]);

/* After each primitive: passes a full piece of text on. */
PM_MUST_USE pm_status pm_generation_pass(pm_generation *g);

/* Passes on the rest. */
PM_MUST_USE pm_status pm_generation_end(pm_generation *g);

#endif
