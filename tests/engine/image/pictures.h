#ifndef PM_TESTS_IMAGE_PICTURES_H
#define PM_TESTS_IMAGE_PICTURES_H

#include <assert.h>
#include <stdint.h>

#include "base/rng.h"
#include "image/image.h"

/* A picture of noise over `decades` decades about 1, with runs of equal pixels. */
static inline pm_image make_picture(uint32_t width, uint32_t height, double decades)
{
    pm_image image;
    pm_status st = pm_image_init(&image, width, height);
    assert(!st);
    (void)st;
    pm_rng rng;
    pm_rng_init(&rng, 7, PM_RNG_PATH, (uint64_t)width << 32 | height);
    size_t pixels = (size_t)width * height;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < 3; c++) {
            double exponent = decades * (pm_rng_uniform(&rng) - .5);
            float value = powf(10, (float)exponent);
            image.rgb[3 * i + (size_t)c] = (i / 9) % 2 ? 1.5F : value;
        }
    return image;
}

#endif
