#ifndef PM_BASE_ARENA_H
#define PM_BASE_ARENA_H

#include <stddef.h>

/* Memory that is freed all at once. Zero-initialised storage is an empty arena. Not
 * thread-safe. */
typedef struct pm_arena {
    struct pm_arena_block *blocks;
    size_t used, size; /* of the newest block [bytes] */
} pm_arena;

/* `size` zeroed bytes, aligned for any type; NULL if memory is short. */
void *pm_arena_alloc(pm_arena *arena, size_t size);

/* `count` zeroed elements; NULL if memory is short or count * size overflows. */
void *pm_arena_array(pm_arena *arena, size_t count, size_t size);

/* A terminated copy of `length` bytes. */
char *pm_arena_text(pm_arena *arena, const char *text, size_t length);

void pm_arena_clear(pm_arena *arena);

#endif
