/* Reads the input as a data file; whatever was read has a value everywhere. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "files/data.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_axis(const pm_data_axis *axis)
{
    check(axis->count >= 2 && axis->first != axis->last);
    check(isfinite(axis->first) && isfinite(axis->last));
    bool rises = axis->last > axis->first;
    for (uint32_t i = 1; axis->ordinates && i < axis->count; i++)
        check(axis->ordinates[i] != axis->ordinates[i - 1] &&
              (axis->ordinates[i] > axis->ordinates[i - 1]) == rises);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const double places[] = {-INFINITY, -1e9, -1, 0, 0.3, 1, 57, 1e300, NAN};
    pm_error err = PM_ERROR_INIT;
    pm_data *read = NULL;
    if (pm_data_read(data, size, "fuzz", &read, &err)) {
        check(err.status && err.text[0] && !read);
        return 0;
    }
    for (unsigned d = 0; d < pm_data_dimensions(read); d++)
        check_axis(pm_data_axis_of(read, d));
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        double at[PM_DATA_DIMENSIONS];
        for (unsigned d = 0; d < PM_DATA_DIMENSIONS; d++)
            at[d] = places[(i + d) % (sizeof places / sizeof *places)];
        (void)pm_data_value(read, at);
    }
    pm_data_free(read);
    return 0;
}
