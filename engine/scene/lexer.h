#ifndef PM_SCENE_LEXER_H
#define PM_SCENE_LEXER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/number.h"
#include "scene/bundle.h"

/* Words of a scene file, with their places. Reads the file in place: nothing is copied. */

typedef struct pm_word {
    const char *text; /* not terminated; NULL at the end of the file */
    size_t length;
    int line, column; /* of its first character or quote, from 1; columns count bytes */
} pm_word;

typedef struct pm_lexer {
    const char *at, *end;
    const char *line_start;
    int line;
    const char *file; /* its name, for messages */
} pm_lexer;

/* How a word goes into a message: `"'%.*s'", PM_WORD_SHOW(word)`; long ones are cut. */
enum { PM_WORD_SHOWN = 60 };
#define PM_WORD_SHOW(word)                                                                     \
    (int)((word).length < PM_WORD_SHOWN ? (word).length : PM_WORD_SHOWN), (word).text

/* PM_E_LIMIT for a file of 2 GiB or more: places are ints. */
PM_MUST_USE pm_status pm_lexer_init(pm_lexer *lexer, const pm_file *file, pm_error *err);

/* Passes white space and returns the next character without taking it; -1 at the end. */
int pm_lexer_peek(pm_lexer *lexer);

/* Passes the rest of the line. */
void pm_lexer_skip_line(pm_lexer *lexer);

/* The next word: text between white space, or between two equal quotes if it starts with " or
 * '. At the end of the file text is NULL, which is no error. PM_E_SYNTAX for a quote that is
 * not closed on its line and for control characters. Source: Radiance, src/common/fgetword.c.
 */
PM_MUST_USE pm_status pm_lexer_word(pm_lexer *lexer, pm_word *word, pm_error *err);

pm_status pm_word_error(const pm_word *word, pm_status status, const char *file, pm_error *err,
                        const char *format, ...) __attribute__((format(printf, 5, 6)));

bool pm_word_is(const pm_word *word, const char *text);

/* As base/number.h reads them. */
static inline pm_number pm_word_real(const pm_word *word, double *value)
{
    return pm_number_real(word->text, word->length, value);
}

static inline pm_number pm_word_integer(const pm_word *word, int64_t *value)
{
    return pm_number_integer(word->text, word->length, value);
}

#endif
