#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "forward/forward.h"

/* Linked with --wrap: the allocation with number `failing` (from 0) fails, all others work. */
static long allocations, failing = -1;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

void *__wrap_malloc(size_t size)
{
    return allocations++ == failing ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return allocations++ == failing ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    return allocations++ == failing ? NULL : __real_realloc(old, size);
}

static const char room[] = "void plastic grey 0 0 5 .6 .6 .6 0 0\n" TEST_BOX(
    "grey") "void light bright 0 0 3 5 4 3\nbright ring lamp 0 0 8 0 0 .9 0 0 -1 0 .3\n"
            "void metal mirror 0 0 5 .9 .9 .9 1 0\nmirror sphere ball 0 0 4 0 0 -.5 .4\n";

/* One pre-run and one batch; on failure nothing may be left behind (the sanitizers watch). */
static pm_status make_batch(const pm_world *world, pm_pool *pool, pm_batch out[PM_MAP_KINDS])
{
    pm_error err = PM_ERROR_INIT;
    pm_forward *forward = NULL;
    pm_forward_options options = pm_forward_defaults();
    pm_status st = pm_forward_new(world, &options, pool, &forward, &err);
    if (!st)
        st = pm_forward_batch(forward, 0, 1U << PM_MAP_GLOBAL | 1U << PM_MAP_CAUSTIC, pool,
                              NULL, NULL, out, &err);
    pm_forward_free(forward);
    assert_int_equal(err.status, st);
    return st;
}

static void every_failed_allocation_is_reported(void **state)
{
    (void)state;
    pm_world *world = world_of(room);
    pm_pool *pool = pm_pool_new(1);
    pm_batch out[PM_MAP_KINDS] = {0};
    long failures = 0;
    for (;; failures++) {
        allocations = 0;
        failing = failures;
        pm_status st = make_batch(world, pool, out);
        failing = -1;
        if (!st)
            break;
        assert_int_equal(st, PM_E_MEMORY);
        for (int kind = 0; kind < PM_MAP_KINDS; kind++)
            assert_true(!out[kind].ends && !out[kind].photons);
    }
    assert_true(failures > 10);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        pm_batch_clear(&out[kind]);
    pm_pool_free(pool);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_failed_allocation_is_reported)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
