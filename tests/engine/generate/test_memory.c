#include "../../support/failing_malloc.h"
#include "generate_test.h"

static pm_status ignore(void *context, const void *text, size_t size)
{
    (void)context, (void)text, (void)size;
    return PM_OK;
}

/* Leaks show under the address sanitizer. */
static void sweep(const char *text, long least)
{
    struct command command;
    pm_generate_request request = request_of(text, &command);
    long n = 0;
    for (pm_status st = PM_E_MEMORY; st; n++) {
        pm_error err = PM_ERROR_INIT;
        size_t wrong;
        until_failure = n;
        st = pm_generate_run(&request, ignore, NULL, &wrong, &err);
        bool all_done = until_failure >= 0;
        until_failure = -1;
        assert_int_equal(st, all_done ? PM_OK : PM_E_MEMORY);
        assert_int_equal(err.status, st);
    }
    assert_in_range(n, least, 100000);
}

static void every_failed_allocation_is_reported(void **state)
{
    (void)state;
    sweep("genbox m b 1 2 3 -r .1 -n 9 -s", 2);
    sweep("genprism m p 3 0 0 1 0 0 1 -r .1", 3);
    sweep("genblinds m s .1 1 2 20 33", 2);
    sweep("gensurf m s s t sqrt(s+t) 20 20 -s -e 'R=3;'", 5);
    sweep("genrev m r t t*R 9 -s -f rev.cal -e 'R=3;'", 5);
    sweep("genworm m w t t t t 9", 5);
    sweep("gensky 6 21 12", 2);
    sweep("gendaylit 6 21 12 -W 500 100", 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_failed_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
