#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "base/arena.h"

static void arena_gives_zeroed_aligned_memory(void **state)
{
    (void)state;
    pm_arena arena = {0};
    for (size_t size = 0; size < 5000; size += 37) {
        unsigned char *bytes = pm_arena_alloc(&arena, size);
        assert_non_null(bytes);
        assert_int_equal((uintptr_t)bytes % _Alignof(max_align_t), 0);
        for (size_t i = 0; i < size; i++)
            assert_int_equal(bytes[i], 0);
        memset(bytes, 0xA5, size);
    }
    pm_arena_clear(&arena);
    assert_null(arena.blocks);
}

static void arena_refuses_overflow(void **state)
{
    (void)state;
    pm_arena arena = {0};
    assert_null(pm_arena_array(&arena, SIZE_MAX / 2, 16));
    assert_null(pm_arena_alloc(&arena, SIZE_MAX - 3));
    assert_string_equal(pm_arena_text(&arena, "photon map", 6), "photon");
    assert_non_null(pm_arena_alloc(&arena, 10 * 1000 * 1000));
    pm_arena_clear(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arena_gives_zeroed_aligned_memory),
        cmocka_unit_test(arena_refuses_overflow),
    };
    return cmocka_run_group_tests_name("base.arena", tests, NULL, NULL);
}
