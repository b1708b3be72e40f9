#ifndef PM_SERVER_GUARD_H
#define PM_SERVER_GUARD_H

#include <stdint.h>

/* Ends connections that are too slow as a whole. libmicrohttpd's own time limit counts
 * inactivity alone, so that a client that sends a byte every other second would hold a
 * connection for ever. */
typedef struct pm_guard pm_guard;
typedef struct pm_guarded pm_guarded; /* a connection */

/* `patience_ms`: for a request's head, or a reply's; bodies have 16 KiB a second on top. */
pm_guard *pm_guard_new(unsigned patience_ms); /* NULL if memory is short */
void pm_guard_free(pm_guard *guard);          /* after the last connection has gone */

pm_guarded *pm_guard_add(pm_guard *guard,
                         int socket); /* waits for a head; NULL if memory is short */
void pm_guard_remove(pm_guard *guard, pm_guarded *connection); /* before its socket is closed */

void pm_guard_receiving(pm_guard *guard, pm_guarded *connection); /* the head is there */
void pm_guard_received(pm_guard *guard, pm_guarded *connection, uint64_t bytes);
void pm_guard_working(pm_guard *guard, pm_guarded *connection); /* it is the server's turn */
void pm_guard_sending(pm_guard *guard, pm_guarded *connection, uint64_t bytes);
void pm_guard_idle(pm_guard *guard, pm_guarded *connection); /* the next request may come */

/* Shuts the sockets that are late by now. To be called about every second. */
void pm_guard_sweep(pm_guard *guard);
uint64_t pm_guard_count(pm_guard *guard); /* connections */

#endif
