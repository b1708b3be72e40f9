#include "sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <stddef.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#ifndef __has_feature /* Clang's way to say what GCC says by macros */
#define __has_feature(name) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) ||                           \
    __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
static const bool sanitized = true;
#else
static const bool sanitized = false;
#endif

/* ---- limits ---- */

static pm_status limit(int resource, rlim_t soft, rlim_t hard, const char *what, pm_error *err)
{
    struct rlimit value = {soft, hard};
    if (setrlimit((__rlimit_resource_t)resource, &value))
        return pm_error_set(err, PM_E_IO, "cannot limit %s: %s", what, strerror(errno));
    return PM_OK;
}

pm_status pm_sandbox_limit(const pm_sandbox_limits *limits, pm_error *err)
{
    pm_status st = limit(RLIMIT_CORE, 0, 0, "core files", err);
    if (!st)
        st = limit(RLIMIT_NOFILE, 64, 64, "open files", err);
    if (!st && limits->memory_bytes && !sanitized) /* whose shadow takes terabytes */
        st = limit(RLIMIT_AS, limits->memory_bytes, limits->memory_bytes, "memory", err);
    if (!st &&
        limits->cpu_seconds) /* SIGXCPU at the soft limit names the cause; SIGKILL follows */
        st = limit(RLIMIT_CPU, limits->cpu_seconds, limits->cpu_seconds + 1, "CPU time", err);
    return st;
}

/* ---- landlock: called by number, since glibc 2.36 has no wrappers ---- */

static long landlock_version(void)
{
    return syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION);
}

/* Every right that version 1 knows, allowed nowhere. */
static int landlock_enter(void)
{
    struct landlock_ruleset_attr attributes = {.handled_access_fs =
                                                   (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1};
    long rules = syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0);
    if (rules < 0)
        return -1;
    long result = syscall(SYS_landlock_restrict_self, (int)rules, 0);
    close((int)rules);
    return (int)result;
}

/* ---- seccomp ---- */

/* Memory, threads, waiting, clocks, and the descriptors that are open. */
static const int allowed[] = {
    SCMP_SYS(brk),
    SCMP_SYS(mmap),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(mprotect),
    SCMP_SYS(madvise),
    SCMP_SYS(memfd_create),
    SCMP_SYS(ftruncate),
    SCMP_SYS(fstat),
    SCMP_SYS(fcntl),
    SCMP_SYS(read),
    SCMP_SYS(write),
    SCMP_SYS(close),
    SCMP_SYS(lseek),
    SCMP_SYS(sendmsg),
    SCMP_SYS(recvmsg),
    SCMP_SYS(poll),
    SCMP_SYS(ppoll),
    SCMP_SYS(futex),
    SCMP_SYS(set_robust_list),
    SCMP_SYS(rseq),
    SCMP_SYS(sched_yield),
    SCMP_SYS(sched_getaffinity),
    SCMP_SYS(gettid),
    SCMP_SYS(getpid),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(nanosleep),
    SCMP_SYS(clock_nanosleep),
    SCMP_SYS(getrusage),
    SCMP_SYS(sysinfo),
    SCMP_SYS(getrandom),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(getrlimit),
    SCMP_SYS(membarrier),
    SCMP_SYS(getcpu),
    SCMP_SYS(sched_getparam),
    SCMP_SYS(sched_getscheduler),
};

/* Asked for by libraries (glibc, TBB, Embree) that go on without: refused, not fatal. */
static const int refused[] = {
    SCMP_SYS(open),   SCMP_SYS(openat),        SCMP_SYS(stat),
    SCMP_SYS(access), SCMP_SYS(readlink),      SCMP_SYS(readlinkat),
    SCMP_SYS(statfs), SCMP_SYS(getdents64),    SCMP_SYS(set_mempolicy),
    SCMP_SYS(mbind),  SCMP_SYS(get_mempolicy), SCMP_SYS(sched_setaffinity),
    SCMP_SYS(ioctl),  SCMP_SYS(prctl),         SCMP_SYS(uname),
    SCMP_SYS(statx),  SCMP_SYS(faccessat2),    SCMP_SYS(prlimit64),
};

/* abort() and pthread_kill() signal the process itself; nobody else may be signalled. */
static int allow_own_signals(scmp_filter_ctx filter)
{
    struct scmp_arg_cmp self = SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)getpid());
    return seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, &self);
}

/* clone(2) for threads alone: without these flags it would be a fork. clone3 hides its flags
 * behind a pointer, so it reports itself missing and glibc turns to clone. */
static int allow_threads(scmp_filter_ctx filter)
{
    enum { THREAD = 0x00010000 /* CLONE_THREAD */ };
    struct scmp_arg_cmp thread = SCMP_A0(SCMP_CMP_MASKED_EQ, THREAD, THREAD);
    int failed = seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
    return failed ? failed
                  : seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, SCMP_SYS(clone), 1, &thread);
}

/* glibc's fstat is newfstatat with AT_EMPTY_PATH; by a path it is refused. */
static int allow_fstat(scmp_filter_ctx filter)
{
    struct scmp_arg_cmp own = SCMP_A3(SCMP_CMP_MASKED_EQ, AT_EMPTY_PATH, AT_EMPTY_PATH);
    struct scmp_arg_cmp path = SCMP_A3(SCMP_CMP_MASKED_EQ, AT_EMPTY_PATH, 0);
    int failed = seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, SCMP_SYS(newfstatat), 1, &own);
    return failed ? failed
                  : seccomp_rule_add_array(filter, SCMP_ACT_ERRNO(EACCES), SCMP_SYS(newfstatat),
                                           1, &path);
}

static int add_rules(scmp_filter_ctx filter)
{
    int failed = 0;
    for (size_t i = 0; i < sizeof allowed / sizeof *allowed && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ALLOW, allowed[i], 0);
    for (size_t i = 0; i < sizeof refused / sizeof *refused && !failed; i++)
        failed = seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), refused[i], 0);
    if (!failed)
        failed = allow_fstat(filter);
    if (!failed)
        failed = allow_own_signals(filter);
    return failed ? failed : allow_threads(filter);
}

static int seccomp_enter(void)
{
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_KILL_PROCESS);
    if (!filter)
        return -1;
    int failed = add_rules(filter);
    if (!failed)
        failed = seccomp_load(filter);
    seccomp_release(filter);
    return failed;
}

static bool seccomp_available(void)
{
    const unsigned action = SCMP_ACT_KILL_PROCESS & 0xffff0000U;
    enum { GET_ACTION_AVAILABLE = 2 };
    return syscall(SYS_seccomp, GET_ACTION_AVAILABLE, 0, &action) == 0;
}

/* ---- together ---- */

pm_sandbox_parts pm_sandbox_available(void)
{
    if (sanitized)
        return (pm_sandbox_parts){.no_new_privs = true};
    return (pm_sandbox_parts){.no_new_privs = true,
                              .landlock = landlock_version() >= 1,
                              .seccomp = seccomp_available()};
}

pm_status pm_sandbox_enter(pm_error *err)
{
    pm_sandbox_parts parts = pm_sandbox_available();
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0))
        return pm_error_set(err, PM_E_IO, "no_new_privs: %s", strerror(errno));
    if (parts.landlock && landlock_enter())
        return pm_error_set(err, PM_E_IO, "landlock: %s", strerror(errno));
    if (parts.seccomp && seccomp_enter())
        return pm_error_set(err, PM_E_IO, "seccomp: the filter cannot be loaded");
    return PM_OK;
}
