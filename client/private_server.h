#ifndef PM_CLIENT_PRIVATE_SERVER_H
#define PM_CLIENT_PRIVATE_SERVER_H

#include <stdbool.h>

#include "base/error.h"

/* The user's own server: one pmserver a store file, on a Unix socket of mode 0600 beside it.
 * The first command starts it, those that come while it lives share it, and it goes with the
 * last.
 *
 * Three files beside the store settle who does what.
 *
 * .lease: each client holds a shared lock for as long as it runs; the server ends when it gets
 * the exclusive one, so a client that is killed is no obstacle.
 *
 * .lock: held while a client looks for a server or starts one.
 *
 * .sock: the socket. */
typedef struct pm_private_server pm_private_server;

/* Finds the server or starts it. The store is $PM_STORE, or pm/store.sqlite in $XDG_CACHE_HOME
 * or ~/.cache. PM_E_IO with the reason if it cannot run. */
PM_MUST_USE pm_status pm_private_server_open(pm_private_server **out, pm_error *err);

const char *pm_private_server_socket(const pm_private_server *server);

/* Gives the lease back. If this process started the server and nobody else uses it, waits for
 * its end, so that its CPU time counts as ours; a signal ends the waiting. */
void pm_private_server_close(pm_private_server *server);

#endif
