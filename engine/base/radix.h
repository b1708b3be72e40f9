#ifndef PM_BASE_RADIX_H
#define PM_BASE_RADIX_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

typedef struct pm_keyed {
    uint64_t key;
    uint32_t value;
} pm_keyed;

/* Sorts by key, ascending; those with equal keys keep their order. A radix sort: a million in a
 * few hundredths of a second. PM_E_MEMORY: `items` are as they were. Test: test_radix.c. */
PM_MUST_USE pm_status pm_radix_sort(pm_keyed *items, size_t count);

#endif
