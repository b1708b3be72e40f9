#include "cmocka_first.h"

#include <stdbool.h>

#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "guard.h"

enum { PATIENCE_MS = 50 };

static void sleep_ms(long ms)
{
    nanosleep(&(struct timespec){.tv_nsec = ms * 1000000}, NULL);
}

static bool is_shut(int socket)
{
    char byte;
    return recv(socket, &byte, 1, MSG_DONTWAIT) == 0;
}

struct line {
    pm_guard *guard;
    pm_guarded *connection;
    int ends[2];
};

static struct line open_line(void)
{
    struct line line = {.guard = pm_guard_new(PATIENCE_MS)};
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, line.ends), 0);
    line.connection = pm_guard_add(line.guard, line.ends[0]);
    assert_int_equal(pm_guard_count(line.guard), 1);
    return line;
}

static void close_line(struct line *line)
{
    pm_guard_remove(line->guard, line->connection);
    assert_int_equal(pm_guard_count(line->guard), 0);
    pm_guard_free(line->guard);
    close(line->ends[0]);
    close(line->ends[1]);
}

static void a_late_head_is_shut(void **state)
{
    (void)state;
    struct line line = open_line();
    pm_guard_sweep(line.guard);
    assert_false(is_shut(line.ends[1]));
    sleep_ms(2 * PATIENCE_MS);
    pm_guard_sweep(line.guard);
    assert_true(is_shut(line.ends[1]));
    close_line(&line);
}

static void the_servers_own_time_does_not_count(void **state)
{
    (void)state;
    struct line line = open_line();
    pm_guard_receiving(line.guard, line.connection);
    pm_guard_working(line.guard, line.connection);
    sleep_ms(2 * PATIENCE_MS);
    pm_guard_sweep(line.guard);
    assert_false(is_shut(line.ends[1]));
    pm_guard_idle(line.guard, line.connection); /* its time begins anew */
    pm_guard_sweep(line.guard);
    assert_false(is_shut(line.ends[1]));
    close_line(&line);
}

/* 16 MiB at 16 KiB a second have 1024 s, however slowly the rest comes. */
static void bodies_have_time_by_their_size(void **state)
{
    (void)state;
    struct line line = open_line();
    pm_guard_receiving(line.guard, line.connection);
    pm_guard_received(line.guard, line.connection, 16 << 20);
    sleep_ms(2 * PATIENCE_MS);
    pm_guard_sweep(line.guard);
    assert_false(is_shut(line.ends[1]));
    pm_guard_sending(line.guard, line.connection, 1);
    sleep_ms(2 * PATIENCE_MS);
    pm_guard_sweep(line.guard);
    assert_true(is_shut(line.ends[1]));
    close_line(&line);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_late_head_is_shut),
        cmocka_unit_test(the_servers_own_time_does_not_count),
        cmocka_unit_test(bodies_have_time_by_their_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
