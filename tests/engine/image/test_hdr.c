/* Radiance pictures, read back by a reader of its own after refer/filefmts.html. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "pictures.h"

static void read_plane(pm_reader *in, uint8_t *rgbe, size_t width)
{
    for (size_t x = 0; x < width;) {
        unsigned code = pm_reader_u8(in);
        assert_false(in->failed);
        assert_true(code > 0);
        unsigned count = code > 128 ? code - 128 : code;
        assert_true(x + count <= width);
        uint8_t value = code > 128 ? pm_reader_u8(in) : 0;
        for (unsigned i = 0; i < count; i++, x++)
            rgbe[4 * x] = code > 128 ? value : pm_reader_u8(in);
    }
}

static void read_row(pm_reader *in, uint8_t *rgbe, size_t width)
{
    bool runs = in->at + 4 <= in->size && in->data[in->at] == 2 && in->data[in->at + 1] == 2 &&
                in->data[in->at + 2] < 128;
    if (runs && width >= 8 && width < 32768) {
        in->at += 2;
        size_t stated = (size_t)pm_reader_u8(in) << 8;
        stated |= pm_reader_u8(in);
        assert_int_equal(stated, width);
        for (size_t c = 0; c < 4; c++)
            read_plane(in, rgbe + c, width);
        return;
    }
    const uint8_t *flat = pm_reader_take(in, 4 * width);
    assert_non_null(flat);
    memcpy(rgbe, flat, 4 * width);
}

/* The header up to its empty line, and the pixels as RGBE. */
struct decoded {
    char *header;
    unsigned width, height;
    uint8_t *rgbe;
};

static struct decoded decode(const pm_bytes *bytes)
{
    struct decoded d = {0};
    const char *end = memmem(bytes->data, bytes->size, "\n\n", 2);
    assert_non_null(end);
    size_t length = (size_t)((const uint8_t *)end - bytes->data) + 1;
    d.header = strndup((const char *)bytes->data, length);
    int used = 0;
    assert_int_equal(sscanf(end + 2, "-Y %u +X %u%n", &d.height, &d.width, &used), 2);
    pm_reader in = {bytes->data, bytes->size, length + 1 + (size_t)used + 1, false};
    assert_int_equal(bytes->data[in.at - 1], '\n');
    d.rgbe = malloc((size_t)4 * d.width * d.height);
    for (size_t y = 0; y < d.height; y++)
        read_row(&in, d.rgbe + 4 * y * d.width, d.width);
    assert_int_equal(in.at, in.size);
    return d;
}

static void decoded_clear(struct decoded *d)
{
    free(d->header);
    free(d->rgbe);
}

/* value = (mantissa + .5) / 256 * 2^(exponent - 128), half a step off at most. */
static void assert_within_half_a_step(const uint8_t rgbe[4], const float rgb[3])
{
    double step = ldexp(1, rgbe[3] - 128 - 8);
    for (int c = 0; c < 3; c++)
        assert_true(fabs((rgbe[c] + .5) * step - (double)rgb[c]) <= .5 * step);
}

static void hdr_decodes_within_half_a_step(void **state)
{
    (void)state;
    static const struct {
        uint32_t width, height;
    } sizes[] = {{1, 1},   {7, 3},     {8, 2},     {129, 5},
                 {255, 3}, {32767, 1}, {32768, 1}, {40000, 1}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        pm_image image = make_picture(sizes[i].width, sizes[i].height, 6);
        pm_bytes bytes = {0};
        assert_int_equal(pm_image_write_hdr(&image, NULL, &bytes, NULL), PM_OK);
        struct decoded d = decode(&bytes);
        assert_int_equal(d.width, image.width);
        assert_int_equal(d.height, image.height);
        for (size_t p = 0; p < (size_t)d.width * d.height; p++)
            assert_within_half_a_step(d.rgbe + 4 * p, image.rgb + 3 * p);
        decoded_clear(&d);
        pm_bytes_clear(&bytes);
        pm_image_clear(&image);
    }
}

static void extreme_values_fit_or_are_refused(void **state)
{
    (void)state;
    pm_image image = make_picture(4, 1, 1);
    const float values[12] = {0, 0, 0, 0x1.fffffep126F, 1, 0, 1e-30F, 2e-30F, 0, 1e-33F, 0, 0};
    memcpy(image.rgb, values, sizeof values);
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_hdr(&image, NULL, &bytes, NULL), PM_OK);
    struct decoded d = decode(&bytes);
    const uint8_t black[4] = {0};
    assert_memory_equal(d.rgbe, black, 4);
    assert_within_half_a_step(d.rgbe + 4, values + 3);
    assert_within_half_a_step(d.rgbe + 8, values + 6);
    assert_memory_equal(d.rgbe + 12, black, 4);
    decoded_clear(&d);
    const float bad[] = {0x1p127F, (float)NAN, (float)INFINITY, -1};
    for (int i = 0; i < 4; i++) {
        size_t before = bytes.size;
        image.rgb[5] = bad[i];
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_image_write_hdr(&image, NULL, &bytes, &err), PM_E_RANGE);
        assert_int_equal(bytes.size, before);
        assert_true(strlen(err.text) > 0);
    }
    pm_bytes_clear(&bytes);
    pm_image_clear(&image);
}

static void header_lines_stand_in_order_and_cannot_be_forged(void **state)
{
    (void)state;
    pm_image image = make_picture(1, 1, 1);
    const pm_image_note note = {"pm.scene", "dead\nFORMAT=beef"};
    const pm_image_notes notes = {&note, 1, "-vtv -vp 1 2 3", "pmclient render\n\nx.rad"};
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_hdr(&image, &notes, &bytes, NULL), PM_OK);
    struct decoded d = decode(&bytes);
    assert_string_equal(d.header, "#?RADIANCE\npmclient render  x.rad\nVIEW= -vtv -vp 1 2 3\n"
                                  "pm.scene= dead FORMAT=beef\nFORMAT=32-bit_rle_rgbe\n");
    decoded_clear(&d);
    pm_bytes_clear(&bytes);
    pm_image_clear(&image);
}

/* A row of one colour: marker, then 3 runs of 127, 127, 46 in each of 4 planes. */
static void runs_are_shortened(void **state)
{
    (void)state;
    pm_image image;
    assert_int_equal(pm_image_init(&image, 300, 1), PM_OK);
    for (size_t i = 0; i < 900; i++)
        image.rgb[i] = 2;
    pm_bytes bytes = {0};
    assert_int_equal(pm_image_write_hdr(&image, NULL, &bytes, NULL), PM_OK);
    const char *header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 300\n";
    assert_int_equal(bytes.size, strlen(header) + 4 + 4 * 3 * 2);
    pm_bytes_clear(&bytes);
    pm_image_clear(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hdr_decodes_within_half_a_step),
        cmocka_unit_test(extreme_values_fit_or_are_refused),
        cmocka_unit_test(header_lines_stand_in_order_and_cannot_be_forged),
        cmocka_unit_test(runs_are_shortened),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
