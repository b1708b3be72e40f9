#ifndef PM_SERVER_LEASE_H
#define PM_SERVER_LEASE_H

#include <stdbool.h>

#include "base/error.h"

/* The lifetime of a private server, which is that of the commands that use it. It listens on a
 * Unix socket; whoever connects holds a lease until the connection closes, however that comes
 * about. When the last lease has gone, the server ends.
 *
 * A client: lock STORE.start (flock), connect to the lease socket and read one byte. If that
 * comes, a server lives and will live on. If there is no socket, or the connection closes
 * without it (the server was just ending), start `pmserver --store STORE --unix PATH --lease
 * LEASE`, wait for its line `listening on ...` and connect again. Then unlock STORE.start. */
typedef struct pm_lease pm_lease;

/* PM_E_MISMATCH if another server listens on the path. */
PM_MUST_USE pm_status pm_lease_new(const char *path, pm_lease **out, pm_error *err);
void pm_lease_free(pm_lease *lease); /* NULL is fine; removes the socket */

/* Handles what has come, waiting until something does or `wake` can be read. False when there
 * was a lease and there is none any more, or none has come within `first_ms`. */
bool pm_lease_serve(pm_lease *lease, int wake, int first_ms);

#endif
