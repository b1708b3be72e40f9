/* OpenEXR files. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "pictures.h"

static const struct {
    uint32_t width, height;
} sizes[] = {{1, 1}, {7, 3}, {33, 17}, {64, 16}, {5, 40}, {1, 100}, {300, 1}};

static void exr_round_trip_is_bit_exact(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        pm_image image = make_picture(sizes[i].width, sizes[i].height, 70), again;
        image.rgb[0] = -0.25F;
        image.rgb[1] = 0;
        image.rgb[2] = 1e-45F; /* the least float */
        pm_bytes bytes = {0};
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_image_write_exr(&image, NULL, &bytes, &err), PM_OK);
        assert_int_equal(pm_image_read_exr(bytes.data, bytes.size, "a.exr", NULL, &again, &err),
                         PM_OK);
        assert_int_equal(again.width, image.width);
        assert_int_equal(again.height, image.height);
        assert_memory_equal(again.rgb, image.rgb,
                            (size_t)image.width * image.height * 3 * sizeof(float));
        pm_bytes_clear(&bytes);
        pm_image_clear(&image);
        pm_image_clear(&again);
    }
}

static void layers_are_channels_of_their_own(void **state)
{
    (void)state;
    pm_image image = make_picture(33, 17, 3), other = make_picture(33, 17, 5), again;
    size_t size = (size_t)33 * 17 * sizeof(float);
    memcpy(pm_image_add_layer(&image, "error", 3), other.rgb, 3 * size);
    image.layers[0].values[5] = INFINITY;
    memcpy(pm_image_add_layer(&image, "samples", 1), other.rgb, size);
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_exr(&image, NULL, &bytes, NULL), PM_OK);
    assert_int_equal(pm_image_read_exr(bytes.data, bytes.size, "a.exr", "error", &again, NULL),
                     PM_OK);
    assert_memory_equal(again.rgb, image.layers[0].values, 3 * size);
    pm_image_clear(&again);
    assert_int_equal(pm_image_read_exr(bytes.data, bytes.size, "a.exr", NULL, &again, NULL),
                     PM_OK);
    assert_memory_equal(again.rgb, image.rgb, 3 * size);
    pm_image_clear(&again);
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(
        pm_image_read_exr(bytes.data, bytes.size, "a.exr", "samples", &again, &err),
        PM_E_UNSUPPORTED);
    assert_non_null(strstr(err.text, "samples.R"));
    pm_bytes_clear(&bytes);
    pm_image_clear(&image);
    pm_image_clear(&other);
}

static bool contains(const pm_bytes *bytes, const char *text, size_t length)
{
    return memmem(bytes->data, bytes->size, text, length);
}

/* An attribute in the file: name, type, length, value (OpenEXR file layout). */
static void notes_become_string_attributes(void **state)
{
    (void)state;
    pm_image image = make_picture(2, 2, 1);
    const pm_image_note note = {"pm.a_name_longer_than_thirty_one_letters", "deadbeef"};
    const pm_image_notes notes = {&note, 1, "-vtv -vp 1 2 3", "pmclient render\nx.rad"};
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_exr(&image, &notes, &bytes, NULL), PM_OK);
    static const char view[] = "pm.view\0string\0\016\0\0\0-vtv -vp 1 2 3";
    static const char command[] = "pm.command\0string\0\025\0\0\0pmclient render x.rad";
    static const char longer[] =
        "pm.a_name_longer_than_thirty_one_letters\0string\0\010\0\0\0deadbeef";
    assert_true(contains(&bytes, view, sizeof view - 1));
    assert_true(contains(&bytes, command, sizeof command - 1));
    assert_true(contains(&bytes, longer, sizeof longer - 1));
    pm_bytes_clear(&bytes);
    pm_image_clear(&image);
}

static void pixels_that_are_not_finite_are_refused(void **state)
{
    (void)state;
    const float bad[] = {(float)NAN, (float)INFINITY, -(float)INFINITY};
    for (int i = 0; i < 3; i++) {
        pm_image image = make_picture(3, 3, 1);
        image.rgb[14] = bad[i];
        pm_bytes bytes = {0};
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_image_write_exr(&image, NULL, &bytes, &err), PM_E_RANGE);
        assert_non_null(strstr(err.text, "pixel 1 of row 1"));
        assert_int_equal(bytes.size, 0);
        pm_image_clear(&image);
    }
}

static void equal_pictures_give_equal_bytes(void **state)
{
    (void)state;
    pm_image image = make_picture(40, 40, 3);
    pm_bytes a = {0}, b = {0};
    assert_int_equal(pm_image_write_exr(&image, NULL, &a, NULL), PM_OK);
    assert_int_equal(pm_image_write_exr(&image, NULL, &b, NULL), PM_OK);
    assert_int_equal(a.size, b.size);
    assert_memory_equal(a.data, b.data, a.size);
    pm_bytes_clear(&a);
    pm_bytes_clear(&b);
    pm_image_clear(&image);
}

/* Each cut loses bytes of the header, of the table of chunks, or of a chunk. */
static void every_truncated_file_is_refused(void **state)
{
    (void)state;
    pm_image image = make_picture(9, 20, 3);
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_exr(&image, NULL, &bytes, NULL), PM_OK);
    for (size_t size = 0; size < bytes.size; size++) {
        uint8_t *cut = malloc(size + 1); /* so that a sanitizer sees reads behind the end */
        memcpy(cut, bytes.data, size);
        pm_image again = {0};
        pm_error err = PM_ERROR_INIT;
        assert_int_not_equal(pm_image_read_exr(cut, size, "cut.exr", NULL, &again, &err),
                             PM_OK);
        assert_null(again.rgb);
        assert_string_equal(err.file, "cut.exr");
        free(cut);
    }
    pm_bytes_clear(&bytes);
    pm_image_clear(&image);
}

static void empty_and_giant_pictures_are_refused(void **state)
{
    (void)state;
    pm_image image;
    assert_int_equal(pm_image_init(&image, 0, 1), PM_E_LIMIT);
    assert_int_equal(pm_image_init(&image, 1, 0), PM_E_LIMIT);
    assert_int_equal(pm_image_init(&image, PM_IMAGE_SIDE_MAX + 1, 1), PM_E_LIMIT);
    assert_int_equal(pm_image_init(&image, 1 << 15, 1 << 15), PM_E_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_round_trip_is_bit_exact),
        cmocka_unit_test(layers_are_channels_of_their_own),
        cmocka_unit_test(notes_become_string_attributes),
        cmocka_unit_test(pixels_that_are_not_finite_are_refused),
        cmocka_unit_test(equal_pictures_give_equal_bytes),
        cmocka_unit_test(every_truncated_file_is_refused),
        cmocka_unit_test(empty_and_giant_pictures_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
