#ifndef PM_CLIENT_INTERRUPT_H
#define PM_CLIENT_INTERRUPT_H

#include <signal.h>

/* How often SIGINT, SIGTERM or SIGHUP came. The first ends waiting and has the running job
 * cancelled; the second ends that, too. Waiting system calls return EINTR at each. */
extern volatile sig_atomic_t pm_interrupted;

#endif
