#include "base/radix.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS, PASSES = (64 + DIGIT_BITS - 1) / DIGIT_BITS };

static unsigned digit_of(uint64_t key, int pass)
{
    return (unsigned)(key >> pass * DIGIT_BITS) & (DIGITS - 1);
}

/* Counts become places; false if one digit holds all, and there is nothing to move. */
static bool find_places(size_t *place, size_t count)
{
    size_t sum = 0;
    for (int digit = 0; digit < DIGITS; digit++) {
        size_t here = place[digit];
        if (here == count)
            return false;
        place[digit] = sum;
        sum += here;
    }
    return true;
}

static void sort_few(pm_keyed *items, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        pm_keyed item = items[i];
        size_t at = i;
        for (; at > 0 && items[at - 1].key > item.key; at--)
            items[at] = items[at - 1];
        items[at] = item;
    }
}

pm_status pm_radix_sort(pm_keyed *items, size_t count)
{
    enum { FEW = 32 };
    if (count <= FEW) {
        sort_few(items, count);
        return PM_OK;
    }
    pm_keyed *other = malloc(count * sizeof *other);
    size_t(*place)[DIGITS] = calloc(PASSES, sizeof *place);
    if (!other || !place) {
        free(other);
        free(place);
        return PM_E_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        for (int pass = 0; pass < PASSES; pass++)
            place[pass][digit_of(items[i].key, pass)]++;
    pm_keyed *from = items, *to = other;
    for (int pass = 0; pass < PASSES; pass++) {
        if (!find_places(place[pass], count))
            continue;
        for (size_t i = 0; i < count; i++)
            to[place[pass][digit_of(from[i].key, pass)]++] = from[i];
        pm_keyed *swap = from;
        from = to;
        to = swap;
    }
    if (from != items)
        memcpy(items, from, count * sizeof *items);
    free(other);
    free(place);
    return PM_OK;
}
