#ifndef PM_SERVER_ACCESS_H
#define PM_SERVER_ACCESS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/error.h"

/* Who may ask. A server on loopback or on a Unix socket needs no token, but a web page in a
 * browser on the same machine must not drive it: so its Host must be a loopback name (else a
 * foreign name was made to point here), and an Origin must be the server's own. Every other
 * address needs a token. */

typedef struct pm_access {
    char **tokens; /* at least 16 characters each */
    size_t token_count;
} pm_access;

/* Reads a file of tokens, one a line. It must belong to the user alone. */
PM_MUST_USE pm_status pm_access_read_tokens(const char *path, pm_access *out, pm_error *err);
void pm_access_clear(pm_access *access);

typedef enum pm_door {
    PM_DOOR_UNIX, /* the file's mode guards it */
    PM_DOOR_LOOPBACK,
    PM_DOOR_NETWORK,
} pm_door;

/* Each header may be NULL. Returns 0, or the HTTP status of a refusal with its reason. */
unsigned pm_access_check(const pm_access *access, pm_door door, const char *host,
                         const char *origin, const char *authorization, const char **why);

#endif
