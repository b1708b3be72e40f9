#ifndef PM_SCENE_STATEMENT_H
#define PM_SCENE_STATEMENT_H

#include "scene/lexer.h"

/* The grammar of a scene file, shared by those who parse it and those who look for the files
 * that it names: # comment modifier type name  n S1 .. Sn  0  m R1 .. Rm modifier alias new old
 *   !command
 */
typedef enum pm_statement_kind {
    PM_STATEMENT_END,
    PM_STATEMENT_PRIMITIVE, /* its arguments follow */
    PM_STATEMENT_ALIAS,
    PM_STATEMENT_COMMAND, /* its words follow the '!' */
} pm_statement_kind;

typedef struct pm_statement {
    pm_statement_kind kind;
    pm_word modifier, type, name;
    pm_word target; /* of an alias */
} pm_statement;

/* Reads the next statement up to its arguments, passing comments. */
PM_MUST_USE pm_status pm_statement_next(pm_lexer *lexer, pm_statement *out, pm_error *err);

/* Reads a word that must be there; `what` says which, for the message. */
PM_MUST_USE pm_status pm_statement_word(pm_lexer *lexer, const char *what, pm_word *out,
                                        pm_error *err);

/* Reads a count of arguments; `what` as in "string arguments". */
PM_MUST_USE pm_status pm_statement_count(pm_lexer *lexer, const char *what, pm_word *word,
                                         size_t *out, pm_error *err);

/* Passes a primitive's arguments and says how many reals there are. False where they break off.
 */
bool pm_statement_skip_arguments(pm_lexer *lexer, size_t *reals);

#endif
