#ifndef PM_GENERATE_GENERATE_H
#define PM_GENERATE_GENERATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

/* Radiance's generators, run inside the process: genbox, genprism, genblinds, gensurf, genrev,
 * genworm, gensky, gendaylit. Nothing is executed and no file is opened.
 *
 * In: the words of a command. Out: scene text with the same primitives, names, order and
 * numbers (to the digits that Radiance prints) as Radiance's program of that name; its comments
 * are left out. Next: scene/ parses the text. */

/* A file that a command names, in memory; NULL data if there is none of that name. */
typedef struct pm_generate_file {
    const void *data;
    size_t size;
} pm_generate_file;

typedef struct pm_generate_request {
    const char *const *words; /* [0] the program; [count] is not read */
    size_t count;
    pm_generate_file (*find)(void *context, const char *name); /* NULL: there are no files */
    void *find_context;
    /* What functions may still cost, in units of PM_LANGUAGE_WORK; lessened. NULL: no limit. */
    uint64_t *work;
} pm_generate_request;

/* What a command will make at most, known before anything is made. Saturating. */
typedef struct pm_generate_size {
    uint64_t primitives, reals, bytes;
} pm_generate_size;

/* Takes a piece of the text that ends between primitives, at most a few MiB. A status other
 * than PM_OK ends the generator, which returns it. */
typedef pm_status pm_generate_sink(void *context, const void *text, size_t size);

/* True for the name of a program that is offered. */
bool pm_generate_knows(const char *program);

/* "genbox, gensurf, ...": all that are offered, for messages. */
const char *pm_generate_programs(void);

/* What a word of a command is, for those who look for a scene's files. */
typedef enum pm_generate_word {
    PM_GENERATE_PLAIN,
    PM_GENERATE_FILE,          /* a file that must be there */
    PM_GENERATE_FUNCTION_FILE, /* likewise, or a standard one */
    PM_GENERATE_PERHAPS_FILE,  /* a file if there is one of that name, else an expression */
} pm_generate_word;
pm_generate_word pm_generate_word_is(const char *const *words, size_t count, size_t index);

/* Checks a command and says how much it will make. `*wrong` is the index of the word that an
 * error is about. PM_E_SYNTAX, PM_E_RANGE, PM_E_MISSING, PM_E_UNSUPPORTED, PM_E_LIMIT; the text
 * begins with the program's name. Its place is set only in a file that the command names.
 * Test: test_generate.c; each program has a test of its own. */
PM_MUST_USE pm_status pm_generate_measure(const pm_generate_request *request,
                                          pm_generate_size *out, size_t *wrong, pm_error *err);

/* Runs it. Errors as above, and whatever the sink returns. */
PM_MUST_USE pm_status pm_generate_run(const pm_generate_request *request,
                                      pm_generate_sink *sink, void *sink_context, size_t *wrong,
                                      pm_error *err);

#endif
