#include "base/radix.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { FEW = 16, SOME = 4096 }; /* that a radix sort is not worth its tables for */

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

/* Two sorted runs become one. */
static void merge(const pm_keyed *from, size_t first, size_t middle, size_t end, pm_keyed *to)
{
    size_t a = first, b = middle;
    for (size_t i = first; i < end; i++)
        to[i] = a < middle && (b >= end || from[a].key <= from[b].key) ? from[a++] : from[b++];
}

/* Runs of FEW are sorted, then merged by pairs. Where they end up is returned. */
static pm_keyed *sort_some(pm_keyed *items, pm_keyed *other, size_t count)
{
    for (size_t i = 0; i < count; i += FEW)
        sort_few(items + i, count - i < FEW ? count - i : FEW);
    for (size_t run = FEW; run < count; run *= 2) {
        for (size_t i = 0; i < count; i += 2 * run) {
            size_t middle = count - i < run ? count : i + run;
            size_t end = count - i < 2 * run ? count : i + 2 * run;
            merge(items, i, middle, end, other);
        }
        pm_keyed *swap = items;
        items = other;
        other = swap;
    }
    return items;
}

/* Where they end up is returned; NULL if memory is short. */
static pm_keyed *sort_many(pm_keyed *items, pm_keyed *other, size_t count)
{
    size_t(*place)[DIGITS] = calloc(PASSES, sizeof *place);
    if (!place)
        return NULL;
    for (size_t i = 0; i < count; i++)
        for (int pass = 0; pass < PASSES; pass++)
            place[pass][digit_of(items[i].key, pass)]++;
    for (int pass = 0; pass < PASSES; pass++) {
        if (!find_places(place[pass], count))
            continue;
        for (size_t i = 0; i < count; i++)
            other[place[pass][digit_of(items[i].key, pass)]++] = items[i];
        pm_keyed *swap = items;
        items = other;
        other = swap;
    }
    free(place);
    return items;
}

pm_status pm_radix_sort(pm_keyed *items, size_t count)
{
    if (count <= FEW) {
        sort_few(items, count);
        return PM_OK;
    }
    pm_keyed *other = malloc(count * sizeof *other);
    if (!other)
        return PM_E_MEMORY;
    pm_keyed *sorted =
        count <= SOME ? sort_some(items, other, count) : sort_many(items, other, count);
    if (sorted && sorted != items)
        memcpy(items, sorted, count * sizeof *items);
    free(other);
    return sorted ? PM_OK : PM_E_MEMORY;
}
