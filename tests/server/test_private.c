#include "cmocka_first.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include "harness.h"

/* A server that lives as long as somebody holds its lease. */

static int hold(const char *path)
{
    int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    assert_int_equal(flock(file, LOCK_SH), 0);
    return file;
}

static const char *socket_of(const test_server *server, char socket[96])
{
    snprintf(socket, 96, "%s/sock", server->folder);
    return socket;
}

static void start_private(test_server *server, char lease[96], char socket[96])
{
    snprintf(lease, 96, "%s/lease", server->folder);
    socket_of(server, socket);
    const char *const options[] = {"--unix", socket, "--exit-when-idle", lease, NULL};
    test_server_start(server, options);
}

static void it_goes_with_the_last_of_several(void **state)
{
    test_server *server = *state;
    char lease[96], socket[96];
    snprintf(lease, sizeof lease, "%s/lease", server->folder);
    int first = hold(lease);
    start_private(server, lease, socket);
    int second = hold(lease);
    test_expect(test_get(server, "/healthz"), 200);
    close(first);
    test_expect(test_get(server, "/healthz"), 200);
    assert_int_equal(waitpid(server->pid, NULL, WNOHANG), 0);
    close(second);
    int status = 0;
    assert_int_equal(waitpid(server->pid, &status, 0), server->pid);
    server->pid = 0;
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_int_equal(access(socket, F_OK), -1);
}

/* Jobs of clients that have gone are not run by the next server. */
static void what_is_left_is_cancelled(void **state)
{
    test_server *server = *state;
    char lease[96], socket[96], scene[65], running[32], queued[32];
    snprintf(lease, sizeof lease, "%s/lease", server->folder);
    int held = hold(lease);
    start_private(server, lease, socket);
    test_scene(server, "hang", scene);
    test_job(server, "{\"kind\": \"render\", \"scene\": \"%s\"}", scene, running);
    test_job(server, "{\"kind\": \"render\", \"scene\": \"%s\"}", scene, queued);
    test_until(server, running, "running");
    close(held);
    assert_int_equal(waitpid(server->pid, NULL, 0), server->pid);
    held = hold(lease);
    start_private(server, lease, socket);
    test_until(server, running, "cancelled");
    test_until(server, queued, "cancelled");
    close(held);
    assert_int_equal(waitpid(server->pid, NULL, 0), server->pid);
    server->pid = 0;
}

/* Who gets the lease back finds the old server alive, and then it stays; or it has gone
 * altogether, and the store is free. Which of the two is up to the kernel. */
static void a_lease_taken_back_finds_a_server_whole_or_gone(void **state)
{
    test_server *server = *state;
    char lease[96], socket[96];
    snprintf(lease, sizeof lease, "%s/lease", server->folder);
    int held = hold(lease);
    for (int i = 0; i < 20; i++) {
        if (access(socket_of(server, socket), F_OK)) {
            if (server->pid)
                assert_int_equal(waitpid(server->pid, NULL, 0), server->pid);
            start_private(server, lease, socket);
        }
        test_expect(test_get(server, "/healthz"), 200);
        close(held);
        held = hold(lease);
    }
    close(held);
    assert_int_equal(waitpid(server->pid, NULL, 0), server->pid);
    server->pid = 0;
}

static void a_signal_ends_it_while_it_is_in_use(void **state)
{
    test_server *server = *state;
    char lease[96], socket[96];
    snprintf(lease, sizeof lease, "%s/lease", server->folder);
    int held = hold(lease);
    start_private(server, lease, socket);
    int status = test_server_stop(server, SIGTERM);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    close(held);
}

#define TEST(name)                                                                             \
    cmocka_unit_test_setup_teardown(name, test_server_setup, test_server_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(it_goes_with_the_last_of_several),
        TEST(what_is_left_is_cancelled),
        TEST(a_lease_taken_back_finds_a_server_whole_or_gone),
        TEST(a_signal_ends_it_while_it_is_in_use),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
