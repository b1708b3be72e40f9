#ifndef PM_FILES_BSDF_CELL_H
#define PM_FILES_BSDF_CELL_H

#include <stddef.h>

/* Where a direction lies among the cells over which a distribution is constant. */
struct pm_bsdf_place {
    double start, share; /* of the unit interval that picks cells */
    double projected;    /* projected solid angle of the cell [sr] */
};

/* Finds i with cumulative[i] <= target < cumulative[i + 1] among `count` steps, and how far
 * target is between them, [0, 1). */
static inline size_t pm_bsdf_step(const float *cumulative, size_t count, double target,
                                  double *fraction)
{
    size_t low = 0, high = count;
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if ((double)cumulative[middle] <= target)
            low = middle;
        else
            high = middle;
    }
    /* a target that rounding took beyond the end belongs to the last step with a width */
    while (low > 0 && !(cumulative[low + 1] > cumulative[low]))
        low--;
    double width = (double)cumulative[low + 1] - (double)cumulative[low];
    double f = width > 0 ? (target - (double)cumulative[low]) / width : 0;
    *fraction = f < 0 ? 0 : f < 1 ? f : 0x1.fffffffffffffp-1;
    return low;
}

#endif
