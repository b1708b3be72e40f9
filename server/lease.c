#include "lease.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>

enum { WAKE_SIGNAL = SIGUSR1, RETRY_NS = 1000000 };

struct pm_lease {
    int file, ended; /* `ended` is an eventfd */
    bool waiting;    /* the thread was started */
    pthread_t thread;
    atomic_bool stop;
};

static void ignore(int signal)
{
    (void)signal; /* interrupting flock is all it is for */
}

static void *wait_main(void *context)
{
    pm_lease *lease = context;
    const uint64_t one = 1;
    int failed;
    do {
        failed = flock(lease->file, LOCK_EX);
    } while (failed && errno == EINTR && !atomic_load(&lease->stop));
    if (!failed && write(lease->ended, &one, sizeof one) != sizeof one)
        return NULL; /* cannot happen: an eventfd takes 2^64 - 2 of them */
    return NULL;
}

static pm_status start(pm_lease *lease, const char *path, pm_error *err)
{
    struct sigaction action = {.sa_handler = ignore}; /* without SA_RESTART */
    sigemptyset(&action.sa_mask);
    lease->file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (lease->file < 0)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be opened: %s",
                               strerror(errno));
    lease->ended = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (lease->ended < 0 || sigaction(WAKE_SIGNAL, &action, NULL) ||
        pthread_create(&lease->thread, NULL, wait_main, lease))
        return pm_error_set(err, PM_E_MEMORY, "cannot wait for the lease: %s", strerror(errno));
    lease->waiting = true;
    return PM_OK;
}

pm_status pm_lease_new(const char *path, pm_lease **out, pm_error *err)
{
    pm_lease *lease = calloc(1, sizeof *lease);
    if (!lease)
        return pm_error_set(err, PM_E_MEMORY, "no memory for a lease");
    lease->file = lease->ended = -1;
    atomic_init(&lease->stop, false);
    pm_status st = start(lease, path, err);
    if (st)
        pm_lease_free(lease);
    else
        *out = lease;
    return st;
}

/* A signal that comes between the thread's look at `stop` and its flock is lost, so it is sent
 * until the thread has ended. */
static void end_thread(pm_lease *lease)
{
    atomic_store(&lease->stop, true);
    do {
        pthread_kill(lease->thread, WAKE_SIGNAL);
        nanosleep(&(struct timespec){.tv_nsec = RETRY_NS}, NULL);
    } while (pthread_tryjoin_np(lease->thread, NULL) == EBUSY);
}

void pm_lease_free(pm_lease *lease)
{
    if (!lease)
        return;
    if (lease->waiting)
        end_thread(lease);
    if (lease->ended >= 0)
        close(lease->ended);
    if (lease->file >= 0)
        close(lease->file);
    free(lease);
}

int pm_lease_descriptor(const pm_lease *lease)
{
    return lease->ended;
}
