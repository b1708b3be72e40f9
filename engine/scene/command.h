#ifndef PM_SCENE_COMMAND_H
#define PM_SCENE_COMMAND_H

#include "base/arena.h"
#include "scene/lexer.h"

/* One program of a `!` line with its words, quoted as in a shell. Nothing is executed. */
typedef struct pm_command {
    const char *file;     /* that it stands in */
    const pm_word *words; /* terminated, in the arena */
    size_t count;         /* >= 1 */
} pm_command;

/* `!a | b | c`: each reads the text that the one before it makes. */
typedef struct pm_commands {
    const pm_command *stages; /* in the arena */
    size_t count;             /* >= 1 */
} pm_commands;

/* Reads what follows the '!', to the end of the line; a backslash before the newline continues
 * it. PM_E_UNSUPPORTED for what only a shell could do. */
PM_MUST_USE pm_status pm_commands_read(pm_lexer *lexer, pm_arena *arena, pm_commands *out,
                                       pm_error *err);

#endif
