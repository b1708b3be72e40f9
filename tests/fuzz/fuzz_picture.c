/* Reads the input as a Radiance picture; whatever was read has a finite colour everywhere. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "files/picture.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static bool is_small(const uint8_t *data, size_t size)
{
    /* a run may fill the largest picture from a few bytes: too slow to fuzz with */
    size_t digits = 0;
    for (size_t i = 0; i < size; i++) {
        digits = data[i] >= '0' && data[i] <= '9' ? digits + 1 : 0;
        if (digits > 4)
            return false;
    }
    return true;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const double places[] = {-INFINITY, -1e9, 0, 0.3, 1, 57, 1e300, NAN};
    pm_error err = PM_ERROR_INIT;
    pm_picture *picture = NULL;
    if (!is_small(data, size))
        return 0;
    if (pm_picture_read(data, size, "fuzz", &picture, &err)) {
        check(err.status && err.text[0] && !picture);
        return 0;
    }
    uint32_t width = pm_picture_width(picture), height = pm_picture_height(picture);
    check(width > 0 && height > 0);
    double samples[PM_PICTURE_BANDS], nm0, nm1;
    for (size_t i = 0; pm_picture_bands(picture, &nm0, &nm1) && i < 64; i++) {
        pm_picture_spectrum(picture, places[i & 7], places[i >> 3], samples);
        check(isfinite(samples[0]) && isfinite(samples[3]));
    }
    if (pm_picture_bands(picture, &nm0, &nm1)) {
        pm_picture_free(picture);
        return 0;
    }
    check(pm_rgb_finite(pm_picture_pixel(picture, width - 1, height - 1)));
    for (size_t i = 0; i < 8; i++)
        for (size_t j = 0; j < 8; j++)
            check(pm_rgb_finite(pm_picture_value(picture, places[i], places[j])));
    pm_picture_free(picture);
    return 0;
}
