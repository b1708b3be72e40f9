#ifndef PM_FILES_DATA_H
#define PM_FILES_DATA_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

/* Radiance data files (.dat): numbers over an even or uneven grid of up to five dimensions.
 *
 * In: a file's bytes. Out: pm_data (immutable). Next: world/texture.h looks values up.
 *
 * Format: the number of dimensions; for each `begin end count`, or `0 0 count p1 p2 ..` with
 * the ordinates of an uneven grid, rising or falling; then the values, the last dimension
 * fastest. `#` starts a comment. Source: Radiance reference manual, 2.1.3, and its
 * refer/filefmts, "Data files". */

enum { PM_DATA_DIMENSIONS = 5 };

typedef struct pm_data pm_data;

/* Reads `size` bytes; `name` is for messages. Refuses what does not parse or is not finite, a
 * count below 2, ordinates that are not monotonic, and counts that the file cannot hold, before
 * memory is taken for them. Tests: test_data.c. */
PM_MUST_USE pm_status pm_data_read(const void *bytes, size_t size, const char *name,
                                   pm_data **out, pm_error *err);
void pm_data_free(pm_data *data);

typedef struct pm_data_axis {
    double first, last;      /* coordinates of the first and of the last value */
    uint32_t count;          /* >= 2 */
    const double *ordinates; /* [count]; NULL if even */
} pm_data_axis;

unsigned pm_data_dimensions(const pm_data *data); /* 1 .. PM_DATA_DIMENSIONS */
const pm_data_axis *pm_data_axis_of(const pm_data *data, unsigned dimension);

/* The value at `at` [pm_data_dimensions], interpolated linearly in each dimension. Beyond the
 * ends Radiance's rule: one interval is extrapolated linearly, then the value falls with one
 * over the distance. Zero if a coordinate is not a number.
 * Source: datavalue in Radiance's data.c. Test: data_beyond_the_ends_tapers. */
double pm_data_value(const pm_data *data, const double *at);

/* The rule of one axis, which pictures share: the value is low * v[index] + high * v[index+1].
 */
typedef struct pm_data_place {
    uint32_t index;
    double low, high;
} pm_data_place;

pm_data_place pm_data_axis_place(const pm_data_axis *axis, double at);

#endif
