#include "cmocka_first.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "access.h"

static char *const tokens[] = {(char *)"correct-horse-battery",
                               (char *)"another-token-of-mine"};
static const pm_access with_tokens = {(char **)tokens, 2}, without;

static unsigned check(const pm_access *access, pm_door door, const char *host,
                      const char *origin, const char *authorization)
{
    const char *why = NULL;
    unsigned status = pm_access_check(access, door, host, origin, authorization, &why);
    assert_true(!status == !why);
    return status;
}

static void loopback_answers_loopback_names_alone(void **state)
{
    (void)state;
    static const char *const good[] = {"localhost",      "LOCALHOST:80", "127.0.0.1",
                                       "127.0.0.1:8430", "[::1]",        "[::1]:8430"};
    static const char *const bad[] = {"evil.example",
                                      "evil.example:8430",
                                      "127.0.0.1.evil.example",
                                      "localhost.evil.example",
                                      "",
                                      "[::2]:80",
                                      "10.0.0.1:80",
                                      "localhostx"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        assert_int_equal(check(&without, PM_DOOR_LOOPBACK, good[i], NULL, NULL), 0);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(check(&without, PM_DOOR_LOOPBACK, bad[i], NULL, NULL), 403);
    assert_int_equal(check(&without, PM_DOOR_LOOPBACK, NULL, NULL, NULL), 403);
    assert_int_equal(check(&without, PM_DOOR_UNIX, "anything", NULL, NULL), 0);
}

static void foreign_pages_cannot_drive_the_server(void **state)
{
    (void)state;
    static const char host[] = "127.0.0.1:8430";
    assert_int_equal(check(&without, PM_DOOR_LOOPBACK, host, "http://127.0.0.1:8430", NULL), 0);
    assert_int_equal(check(&without, PM_DOOR_LOOPBACK, host, "http://127.0.0.1:9999", NULL),
                     403);
    assert_int_equal(check(&without, PM_DOOR_LOOPBACK, host, "http://evil.example", NULL), 403);
    assert_int_equal(check(&without, PM_DOOR_LOOPBACK, host, "null", NULL), 403);
    assert_int_equal(check(&without, PM_DOOR_UNIX, host, "http://evil.example", NULL), 403);
}

static void the_network_needs_a_whole_token(void **state)
{
    (void)state;
    static const char host[] = "render.example";
    assert_int_equal(check(&with_tokens, PM_DOOR_NETWORK, host, NULL, NULL), 401);
    assert_int_equal(
        check(&with_tokens, PM_DOOR_NETWORK, host, NULL, "Bearer correct-horse-battery"), 0);
    assert_int_equal(
        check(&with_tokens, PM_DOOR_NETWORK, host, NULL, "bearer another-token-of-mine"), 0);
    assert_int_equal(
        check(&with_tokens, PM_DOOR_NETWORK, host, NULL, "Bearer correct-horse-batter"), 401);
    assert_int_equal(
        check(&with_tokens, PM_DOOR_NETWORK, host, NULL, "Bearer correct-horse-batteryx"), 401);
    assert_int_equal(check(&with_tokens, PM_DOOR_NETWORK, host, NULL, "Bearer "), 401);
    assert_int_equal(
        check(&with_tokens, PM_DOOR_NETWORK, host, NULL, "Basic correct-horse-battery"), 401);
    assert_int_equal(check(&without, PM_DOOR_NETWORK, host, NULL, "Bearer "), 401);
    assert_int_equal(check(&with_tokens, PM_DOOR_LOOPBACK, "localhost", NULL, NULL), 401);
    assert_int_equal(check(&with_tokens, PM_DOOR_UNIX, "localhost", NULL, NULL), 0);
}

static pm_status read_text(const char *text, mode_t mode, pm_access *out, pm_error *err)
{
    char path[] = "/tmp/pm-tokens-XXXXXX";
    int file = mkstemp(path);
    assert_int_equal(write(file, text, strlen(text)), strlen(text));
    fchmod(file, mode);
    close(file);
    pm_status st = pm_access_read_tokens(path, out, err);
    unlink(path);
    return st;
}

static void token_files_are_private_and_hold_long_tokens(void **state)
{
    (void)state;
    pm_access access;
    assert_int_equal(read_text("0123456789abcdef\n\nfedcba9876543210", 0600, &access, NULL),
                     PM_OK);
    assert_int_equal(access.token_count, 2);
    assert_string_equal(access.tokens[1], "fedcba9876543210");
    pm_access_clear(&access);
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(read_text("0123456789abcdef\n", 0644, &access, NULL), PM_E_RANGE);
    assert_int_equal(read_text("0123456789abcdef\nshort\n", 0600, &access, &err), PM_E_RANGE);
    assert_int_equal(err.line, 2);
    assert_int_equal(read_text("0123456789 abcdef\n", 0600, &access, NULL), PM_E_RANGE);
    assert_int_equal(read_text("\n", 0600, &access, NULL), PM_E_SYNTAX);
    assert_int_equal(pm_access_read_tokens("/nonexistent", &access, NULL), PM_E_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loopback_answers_loopback_names_alone),
        cmocka_unit_test(foreign_pages_cannot_drive_the_server),
        cmocka_unit_test(the_network_needs_a_whole_token),
        cmocka_unit_test(token_files_are_private_and_hold_long_tokens),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
