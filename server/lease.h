#ifndef PM_SERVER_LEASE_H
#define PM_SERVER_LEASE_H

#include "base/error.h"

/* The lifetime of a private server, which is that of the commands that use it. Each of them
 * holds a shared flock on one file, from before it looks for the server until it ends, however
 * it ends. The server waits for the exclusive lock: it gets it when the last command has gone,
 * and keeps it until it has gone too. So a command that comes meanwhile waits, and then starts
 * its own. */
typedef struct pm_lease pm_lease;

PM_MUST_USE pm_status pm_lease_new(const char *path, pm_lease **out, pm_error *err);

/* Lets the file go. NULL is fine. */
void pm_lease_free(pm_lease *lease);

/* A descriptor that can be read once nobody uses the server. */
int pm_lease_descriptor(const pm_lease *lease);

#endif
