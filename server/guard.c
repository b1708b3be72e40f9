#include "guard.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <time.h>

enum { BYTES_A_MS = 16 };

struct pm_guarded {
    pm_guarded *next;
    int socket;
    bool is_due;     /* there is a deadline */
    double since_ms; /* start of this phase */
    uint64_t bytes;  /* of this phase's body */
};

struct pm_guard {
    double patience_ms;
    pthread_mutex_t lock; /* guards the list and what is in it */
    pm_guarded *list;
};

static double now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

pm_guard *pm_guard_new(unsigned patience_ms)
{
    pm_guard *guard = calloc(1, sizeof *guard);
    if (!guard)
        return NULL;
    guard->patience_ms = patience_ms;
    pthread_mutex_init(&guard->lock, NULL);
    return guard;
}

void pm_guard_free(pm_guard *guard)
{
    if (!guard)
        return;
    pthread_mutex_destroy(&guard->lock);
    free(guard);
}

pm_guarded *pm_guard_add(pm_guard *guard, int socket)
{
    pm_guarded *connection = calloc(1, sizeof *connection);
    if (!connection)
        return NULL;
    connection->socket = socket;
    connection->is_due = true;
    connection->since_ms = now_ms();
    pthread_mutex_lock(&guard->lock);
    connection->next = guard->list;
    guard->list = connection;
    pthread_mutex_unlock(&guard->lock);
    return connection;
}

void pm_guard_remove(pm_guard *guard, pm_guarded *connection)
{
    if (!connection)
        return;
    pthread_mutex_lock(&guard->lock);
    pm_guarded **at = &guard->list;
    while (*at != connection)
        at = &(*at)->next;
    *at = connection->next;
    pthread_mutex_unlock(&guard->lock);
    free(connection);
}

static void enter(pm_guard *guard, pm_guarded *connection, bool is_due, uint64_t bytes)
{
    if (!connection)
        return;
    pthread_mutex_lock(&guard->lock);
    connection->is_due = is_due;
    connection->since_ms = now_ms();
    connection->bytes = bytes;
    pthread_mutex_unlock(&guard->lock);
}

void pm_guard_receiving(pm_guard *guard, pm_guarded *connection)
{
    enter(guard, connection, true, 0);
}

void pm_guard_received(pm_guard *guard, pm_guarded *connection, uint64_t bytes)
{
    if (!connection)
        return;
    pthread_mutex_lock(&guard->lock);
    connection->bytes += bytes;
    pthread_mutex_unlock(&guard->lock);
}

void pm_guard_working(pm_guard *guard, pm_guarded *connection)
{
    enter(guard, connection, false, 0);
}

void pm_guard_sending(pm_guard *guard, pm_guarded *connection, uint64_t bytes)
{
    enter(guard, connection, true, bytes);
}

void pm_guard_idle(pm_guard *guard, pm_guarded *connection)
{
    enter(guard, connection, true, 0);
}

void pm_guard_sweep(pm_guard *guard)
{
    double now = now_ms();
    pthread_mutex_lock(&guard->lock);
    for (pm_guarded *connection = guard->list; connection; connection = connection->next) {
        double allowed = guard->patience_ms + (double)connection->bytes / BYTES_A_MS;
        if (connection->is_due && now - connection->since_ms > allowed)
            shutdown(connection->socket, SHUT_RDWR);
    }
    pthread_mutex_unlock(&guard->lock);
}

uint64_t pm_guard_count(pm_guard *guard)
{
    uint64_t count = 0;
    pthread_mutex_lock(&guard->lock);
    for (const pm_guarded *connection = guard->list; connection; connection = connection->next)
        count++;
    pthread_mutex_unlock(&guard->lock);
    return count;
}
