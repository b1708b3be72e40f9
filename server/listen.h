#ifndef PM_SERVER_LISTEN_H
#define PM_SERVER_LISTEN_H

#include "access.h"
#include "base/error.h"

/* Listening sockets; each is close-on-exec and does not block. */

/* A Unix socket of mode 0600. One that a dead server left is replaced; PM_E_MISMATCH if
 * somebody listens there. */
PM_MUST_USE pm_status pm_listen_unix(const char *path, int *out, pm_error *err);

/* "127.0.0.1:8080", "[::1]:0", "localhost:0"; port 0 is any free one. `url` is where it
 * listens. */
PM_MUST_USE pm_status pm_listen_tcp(const char *address, int *out, pm_door *door, char url[128],
                                    pm_error *err);

#endif
