#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>

#include "base/pool.h"

struct job {
    unsigned char *done;
    unsigned threads;
};

static void mark(void *context, size_t i, unsigned thread)
{
    struct job *job = context;
    job->done[i]++;
    if (thread >= job->threads)
        abort();
}

static void pool_runs_each_piece_once(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 7; threads++) {
        pm_pool *pool = pm_pool_new(threads);
        assert_non_null(pool);
        assert_int_equal(pm_pool_threads(pool), threads);
        for (size_t count = 0; count < 200; count += 33) {
            struct job job = {.done = calloc(count + 1, 1), .threads = threads};
            pm_pool_run(pool, count, mark, &job);
            for (size_t i = 0; i < count; i++)
                assert_int_equal(job.done[i], 1);
            assert_int_equal(job.done[count], 0);
            free(job.done);
        }
        pm_pool_free(pool);
    }
}

static void pool_of_zero_threads_takes_every_processor(void **state)
{
    (void)state;
    pm_pool *pool = pm_pool_new(0);
    assert_true(pm_pool_threads(pool) >= 1);
    pm_pool_free(pool);
    pm_pool_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pool_runs_each_piece_once),
        cmocka_unit_test(pool_of_zero_threads_takes_every_processor),
    };
    return cmocka_run_group_tests_name("base.pool", tests, NULL, NULL);
}
