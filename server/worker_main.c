#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "sandbox.h"
#include "worker_job.h"

/* pmworker: runs one job for pmserver and ends. Not for the command line. */

enum { SOCKET = 3 };

static int complain(const pm_error *err)
{
    char text[1200];
    pm_error_format(err, text, sizeof text);
    fprintf(stderr, "pmworker: %s\n", text);
    return 1;
}

static int usage(void)
{
    fputs("usage: pmworker PARENT MEMORY_BYTES CPU_SECONDS\n"
          "pmserver starts it, with a socket as file descriptor 3.\n",
          stderr);
    return 2;
}

static bool read_number(const char *text, uint64_t *out)
{
    char *end;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return !errno && end != text && !*end;
}

int main(int argc, char **argv)
{
    uint64_t parent;
    pm_sandbox_limits limits;
    pm_error err = PM_ERROR_INIT;
    if (argc != 4 || !read_number(argv[1], &parent) ||
        !read_number(argv[2], &limits.memory_bytes) ||
        !read_number(argv[3], &limits.cpu_seconds))
        return usage();
    /* A worker must not outlive its server; if that died before this line, its place was taken.
     */
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) || (uint64_t)getppid() != parent)
        return 1;
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    if (pm_sandbox_limit(&limits, &err) || pm_sandbox_enter(&err))
        return complain(&err);
    return pm_worker_serve(SOCKET);
}
