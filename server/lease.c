#include "lease.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "listen.h"

enum { LEASES_MAX = 1024 };

struct pm_lease {
    char *path;
    int listener;
    int *held; /* connections */
    size_t count;
    bool had_one;
};

pm_status pm_lease_new(const char *path, pm_lease **out, pm_error *err)
{
    pm_lease *lease = calloc(1, sizeof *lease);
    if (!lease)
        return pm_error_set(err, PM_E_MEMORY, "no memory for leases");
    lease->listener = -1;
    lease->path = strdup(path);
    lease->held = calloc(LEASES_MAX, sizeof *lease->held);
    pm_status st = lease->path && lease->held
                       ? pm_listen_unix(path, &lease->listener, err)
                       : pm_error_set(err, PM_E_MEMORY, "no memory for leases");
    if (st)
        pm_lease_free(lease);
    else
        *out = lease;
    return st;
}

void pm_lease_free(pm_lease *lease)
{
    if (!lease)
        return;
    if (lease->listener >= 0) {
        unlink(lease->path);
        close(lease->listener);
    }
    for (size_t i = 0; i < lease->count; i++)
        close(lease->held[i]);
    free(lease->held);
    free(lease->path);
    free(lease);
}

static void take_new(pm_lease *lease)
{
    int connection = accept4(lease->listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (connection < 0)
        return;
    bool is_told = lease->count < LEASES_MAX && send(connection, "+", 1, MSG_NOSIGNAL) == 1;
    if (!is_told) {
        close(connection);
        return;
    }
    lease->held[lease->count++] = connection;
    lease->had_one = true;
}

/* Nothing is expected on a lease, so whatever can be read is dropped; an end of file ends it.
 */
static bool has_gone(int connection)
{
    char nothing[64];
    ssize_t got = recv(connection, nothing, sizeof nothing, MSG_DONTWAIT);
    return !got || (got < 0 && errno != EAGAIN && errno != EINTR);
}

static void drop_gone(pm_lease *lease, const struct pollfd *polled)
{
    size_t kept = 0;
    for (size_t i = 0; i < lease->count; i++) {
        if (polled[i].revents && has_gone(lease->held[i]))
            close(lease->held[i]);
        else
            lease->held[kept++] = lease->held[i];
    }
    lease->count = kept;
}

bool pm_lease_serve(pm_lease *lease, int wake, int first_ms)
{
    struct pollfd *polled = calloc(lease->count + 2, sizeof *polled);
    if (!polled)
        return false;
    for (size_t i = 0; i < lease->count; i++)
        polled[i] = (struct pollfd){.fd = lease->held[i], .events = POLLIN};
    struct pollfd *extra = polled + lease->count;
    extra[0] = (struct pollfd){.fd = lease->listener, .events = POLLIN};
    extra[1] = (struct pollfd){.fd = wake, .events = POLLIN};
    int ready = poll(polled, lease->count + 2, lease->had_one ? -1 : first_ms);
    short arrived = extra[0].revents;
    drop_gone(lease, polled);
    if (arrived)
        take_new(lease);
    free(polled);
    return lease->count || (!lease->had_one && ready != 0);
}
