/* PNG pictures, read back through libpng's simplified reader. */
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "pictures.h"

/* RGB rows, to be freed. */
static uint8_t *decode(const pm_bytes *bytes, uint32_t width, uint32_t height)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_memory(&png, bytes->data, bytes->size));
    assert_int_equal(png.width, width);
    assert_int_equal(png.height, height);
    png.format = PNG_FORMAT_RGB;
    uint8_t *rgb = malloc(PNG_IMAGE_SIZE(png));
    assert_true(png_image_finish_read(&png, NULL, rgb, 0, NULL));
    return rgb;
}

static uint8_t *written(const pm_image *image)
{
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_png(image, NULL, &bytes, NULL), PM_OK);
    uint8_t *rgb = decode(&bytes, image->width, image->height);
    pm_bytes_clear(&bytes);
    return rgb;
}

static pm_image uniform(uint32_t width, uint32_t height, float value)
{
    pm_image image;
    assert_int_equal(pm_image_init(&image, width, height), PM_OK);
    for (size_t i = 0; i < (size_t)3 * width * height; i++)
        image.rgb[i] = value;
    return image;
}

/* Key .18 over itself: x = .18, x (1 + x) / (1 + x) = .18 since the white point is at least 1;
 * sRGB of .18 is 1.055 .18^(1/2.4) - .055 = .4614: byte 118. */
static void even_grey_of_any_brightness_becomes_the_same_grey(void **state)
{
    (void)state;
    const float values[] = {1e-30F, 1e-3F, 1, 1e9F, 1e30F};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        pm_image image = uniform(3, 2, values[i]);
        uint8_t *rgb = written(&image);
        for (int p = 0; p < 18; p++)
            assert_int_equal(rgb[p], 118);
        free(rgb);
        pm_image_clear(&image);
    }
}

static void black_stays_black(void **state)
{
    (void)state;
    pm_image image = uniform(5, 1, 0);
    uint8_t *rgb = written(&image);
    for (int p = 0; p < 15; p++)
        assert_int_equal(rgb[p], 0);
    free(rgb);
    pm_image_clear(&image);
}

/* A ramp over six decades: bytes never fall, the brightest is white and only it. */
static void brighter_pixels_never_become_darker(void **state)
{
    (void)state;
    pm_image image = uniform(200, 1, 0);
    for (size_t x = 0; x < 200; x++)
        for (size_t c = 0; c < 3; c++)
            image.rgb[3 * x + c] = powf(10, (float)x * .03F - 3);
    uint8_t *rgb = written(&image);
    for (size_t x = 1; x < 200; x++)
        assert_true(rgb[3 * x] >= rgb[3 * x - 3]);
    assert_int_equal(rgb[3 * 199], 255);
    assert_true(rgb[3 * 150] < 255);
    assert_true(rgb[0] < 32);
    free(rgb);
    pm_image_clear(&image);
}

static void text_chunks_hold_the_notes(void **state)
{
    (void)state;
    pm_image image = uniform(1, 1, 1);
    const pm_image_note note = {"pm.scene", "deadbeef"};
    const pm_image_notes notes = {&note, 1, "-vtv", "pmclient render"};
    pm_bytes a = {0}, b = {0};
    assert_int_equal(pm_image_write_png(&image, &notes, &a, NULL), PM_OK);
    assert_int_equal(pm_image_write_png(&image, &notes, &b, NULL), PM_OK);
    assert_int_equal(a.size, b.size);
    assert_memory_equal(a.data, b.data, a.size);
    assert_non_null(memmem(a.data, a.size, "pm.scene", 8));
    assert_non_null(memmem(a.data, a.size, "deadbeef", 8));
    assert_non_null(memmem(a.data, a.size, "pm.view", 7));
    assert_non_null(memmem(a.data, a.size, "pmclient render", 15));
    pm_bytes_clear(&a);
    pm_bytes_clear(&b);
    pm_image_clear(&image);
}

static void pixels_out_of_range_are_refused(void **state)
{
    (void)state;
    const float bad[] = {(float)NAN, (float)INFINITY, -1e-9F};
    for (int i = 0; i < 3; i++) {
        pm_image image = uniform(2, 2, 1);
        image.rgb[11] = bad[i];
        pm_bytes bytes = {0};
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_image_write_png(&image, NULL, &bytes, &err), PM_E_RANGE);
        assert_non_null(strstr(err.text, "pixel 1 of row 1"));
        assert_int_equal(bytes.size, 0);
        pm_image_clear(&image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(even_grey_of_any_brightness_becomes_the_same_grey),
        cmocka_unit_test(black_stays_black),
        cmocka_unit_test(brighter_pixels_never_become_darker),
        cmocka_unit_test(text_chunks_hold_the_notes),
        cmocka_unit_test(pixels_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
