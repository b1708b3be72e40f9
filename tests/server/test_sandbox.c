#include "cmocka_first.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sandbox.h"

/* Runs `work` in a child that has entered the sandbox, and returns how it ended. */
static int inside(int (*work)(void))
{
    pid_t child = fork();
    if (!child) {
        if (pm_sandbox_enter(NULL))
            _exit(99);
        _exit(work());
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

static void skip_without(bool part)
{
    if (!part)
        skip(); /* /readyz says so */
}

static int open_files(void)
{
    bool shut =
        open("/etc/passwd", O_RDONLY) < 0 && open("/tmp/pm-x", O_CREAT | O_WRONLY, 0600) < 0;
    return shut ? 0 : 1;
}

static int connect_out(void)
{
    return socket(AF_INET, SOCK_STREAM, 0) < 0 ? 0 : 1;
}

static int run_program(void)
{
    execl("/bin/true", "true", (char *)NULL);
    return 1;
}

static int fork_process(void)
{
    return fork() < 0 ? 0 : 1;
}

static int signal_parent(void)
{
    return kill(getppid(), 0) ? 0 : 1;
}

static void *add_one(void *context)
{
    ++*(int *)context;
    return NULL;
}

static int work_as_jobs_do(void)
{
    int value = 0, file = memfd_create("x", MFD_ALLOW_SEALING);
    pthread_t thread;
    char *memory = malloc(64 << 20);
    if (file < 0 || !memory || pthread_create(&thread, NULL, add_one, &value))
        return 1;
    memset(memory, 1, 64 << 20);
    pthread_join(thread, NULL);
    free(memory);
    return value == 1 && write(file, "x", 1) == 1 && !fcntl(file, F_ADD_SEALS, F_SEAL_WRITE)
               ? 0
               : 2;
}

static int abort_itself(void)
{
    abort();
}

static void no_file_can_be_opened(void **state)
{
    (void)state;
    skip_without(pm_sandbox_available().landlock || pm_sandbox_available().seccomp);
    assert_int_equal(inside(open_files), 0);
}

static void other_system_calls_end_the_process(void **state)
{
    (void)state;
    skip_without(pm_sandbox_available().seccomp);
    int (*const forbidden[])(void) = {connect_out, run_program, fork_process, signal_parent};
    for (size_t i = 0; i < sizeof forbidden / sizeof *forbidden; i++) {
        int status = inside(forbidden[i]);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);
    }
}

static void memory_threads_and_memory_files_work(void **state)
{
    (void)state;
    assert_int_equal(inside(work_as_jobs_do), 0);
}

static void a_crash_keeps_its_signal(void **state)
{
    (void)state;
    int status = inside(abort_itself);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_file_can_be_opened),
        cmocka_unit_test(other_system_calls_end_the_process),
        cmocka_unit_test(memory_threads_and_memory_files_work),
        cmocka_unit_test(a_crash_keeps_its_signal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
