#ifndef PM_SERVER_SANDBOX_H
#define PM_SERVER_SANDBOX_H

#include <stdbool.h>
#include <stdint.h>

#include "base/error.h"

/* Closes a worker off: a bug in a parser of what came from the network must not reach files,
 * the network or other processes. Each part may be missing in a kernel; what is missing is
 * reported by /readyz. */

typedef struct pm_sandbox_parts {
    bool no_new_privs; /* exec cannot gain rights */
    bool landlock;     /* no file can be opened, made or removed by name */
    bool seccomp;      /* only the system calls that a job needs; the rest end the process */
} pm_sandbox_parts;

/* What this kernel and this build have. Sanitizers need files and system calls of their own, so
 * a build with them has no sandbox. */
pm_sandbox_parts pm_sandbox_available(void);

/* Resource limits of a worker; 0 = none. */
typedef struct pm_sandbox_limits {
    uint64_t memory_bytes; /* address space */
    uint64_t cpu_seconds;
} pm_sandbox_limits;

PM_MUST_USE pm_status pm_sandbox_limit(const pm_sandbox_limits *limits, pm_error *err);

/* Closes everything that is available, for this process and all threads to come. Only memory,
 * threads, clocks and the file descriptors that are open remain. */
PM_MUST_USE pm_status pm_sandbox_enter(pm_error *err);

#endif
