#include "cmocka_first.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "listen.h"

static void port_0_is_a_free_one_that_is_told(void **state)
{
    (void)state;
    int a, b;
    pm_door door;
    char url[128], other[128];
    assert_int_equal(pm_listen_tcp("127.0.0.1:0", &a, &door, url, NULL), PM_OK);
    assert_int_equal(door, PM_DOOR_LOOPBACK);
    assert_int_equal(strncmp(url, "http://127.0.0.1:", 17), 0);
    assert_true(atoi(url + 17) > 0);
    assert_int_equal(pm_listen_tcp("127.0.0.1:0", &b, &door, other, NULL), PM_OK);
    assert_string_not_equal(url, other);
    close(a);
    close(b);
}

static void addresses_that_can_be_reached_are_told_from_loopback(void **state)
{
    (void)state;
    int socket;
    pm_door door;
    char url[128];
    assert_int_equal(pm_listen_tcp("0.0.0.0:0", &socket, &door, url, NULL), PM_OK);
    assert_int_equal(door, PM_DOOR_NETWORK);
    close(socket);
}

static void addresses_without_sense_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "", "8080", ":8080", "127.0.0.1", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:99999999"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int socket = -1;
        pm_door door;
        char url[128];
        assert_int_equal(pm_listen_tcp(bad[i], &socket, &door, url, NULL), PM_E_SYNTAX);
        assert_int_equal(socket, -1);
    }
}

static void a_unix_socket_is_private_and_replaces_a_dead_one(void **state)
{
    (void)state;
    char folder[] = "/tmp/pm-listen-XXXXXX", path[64], longer[256];
    struct stat about;
    int first, second = -1;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/s", folder);
    assert_int_equal(pm_listen_unix(path, &first, NULL), PM_OK);
    assert_int_equal(stat(path, &about), 0);
    assert_int_equal(about.st_mode & 0777, 0600);
    assert_int_equal(pm_listen_unix(path, &second, NULL), PM_E_MISMATCH);
    close(first); /* the file stays, nobody listens */
    assert_int_equal(pm_listen_unix(path, &second, NULL), PM_OK);
    close(second);
    unlink(path);
    FILE *file = fopen(path, "w"); /* a file of somebody is not removed */
    fclose(file);
    assert_int_equal(pm_listen_unix(path, &second, NULL), PM_E_IO);
    assert_int_equal(stat(path, &about), 0);
    unlink(path);
    rmdir(folder);
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    assert_int_equal(pm_listen_unix(longer, &second, NULL), PM_E_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(port_0_is_a_free_one_that_is_told),
        cmocka_unit_test(addresses_that_can_be_reached_are_told_from_loopback),
        cmocka_unit_test(addresses_without_sense_are_refused),
        cmocka_unit_test(a_unix_socket_is_private_and_replaces_a_dead_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
