#include "base/arena.h"

#include <stdalign.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Blocks double up to the greatest: a scene may have thousands of small arenas. */
enum { FIRST_BLOCK = 1024, GREATEST_BLOCK = 64 * 1024 };

struct pm_arena_block {
    struct pm_arena_block *next;
    alignas(max_align_t) unsigned char bytes[];
};

static struct pm_arena_block *add_block(pm_arena *arena, size_t size)
{
    struct pm_arena_block *block = calloc(1, sizeof *block + size);
    if (!block)
        return NULL;
    block->next = arena->blocks;
    arena->blocks = block;
    arena->used = 0;
    arena->size = size;
    return block;
}

static size_t next_size(const pm_arena *arena)
{
    size_t size = 2 * arena->size;
    if (size < FIRST_BLOCK)
        return FIRST_BLOCK;
    return size < GREATEST_BLOCK ? size : GREATEST_BLOCK;
}

void *pm_arena_alloc(pm_arena *arena, size_t size)
{
    const size_t align = alignof(max_align_t);
    if (size > SIZE_MAX / 2)
        return NULL;
    size = (size + align - 1) / align * align;
    if (!arena->blocks || arena->size - arena->used < size) {
        size_t block = next_size(arena);
        if (!add_block(arena, size > block ? size : block))
            return NULL;
    }
    void *result = arena->blocks->bytes + arena->used;
    arena->used += size;
    return result;
}

void *pm_arena_array(pm_arena *arena, size_t count, size_t size)
{
    if (size && count > SIZE_MAX / size)
        return NULL;
    return pm_arena_alloc(arena, count * size);
}

char *pm_arena_text(pm_arena *arena, const char *text, size_t length)
{
    char *copy = pm_arena_alloc(arena, length + 1);
    if (copy)
        memcpy(copy, text, length);
    return copy;
}

void pm_arena_clear(pm_arena *arena)
{
    while (arena->blocks) {
        struct pm_arena_block *next = arena->blocks->next;
        free(arena->blocks);
        arena->blocks = next;
    }
    *arena = (pm_arena){0};
}
