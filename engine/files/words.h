#ifndef PM_FILES_WORDS_H
#define PM_FILES_WORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

/* Numbers in text files: white space between them, `#` starts a comment up to the line's end.
 * Source: fgetval in Radiance's src/common/fgetval.c. */
typedef struct pm_words {
    const char *at, *end;
    const char *line_start;
    int line;
    const char *file; /* its name, for messages */
} pm_words;

/* PM_E_LIMIT for 2 GiB or more: places are ints. */
PM_MUST_USE pm_status pm_words_init(pm_words *words, const void *bytes, size_t size,
                                    const char *name, pm_error *err);

/* Passes white space and comments; false at the end. */
bool pm_words_more(pm_words *words);

/* Passes the next word if it is `word`. */
bool pm_words_take(pm_words *words, const char *word);

/* The next number. `what` completes "... must be", e.g. "the number of dimensions"; errors have
 * the place. Reals are finite. */
PM_MUST_USE pm_status pm_words_real(pm_words *words, const char *what, double *out,
                                    pm_error *err);
PM_MUST_USE pm_status pm_words_integer(pm_words *words, const char *what, int64_t least,
                                       int64_t most, int64_t *out, pm_error *err);

/* An error at the next word; text as in printf. Returns `status`. */
pm_status pm_words_error(const pm_words *words, pm_status status, pm_error *err,
                         const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Bytes not yet read: at least 2 a number, but for the last. */
size_t pm_words_left(const pm_words *words);

#endif
