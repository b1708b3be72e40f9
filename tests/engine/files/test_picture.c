#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/bytes.h"
#include "base/xyz.h"
#include "files/picture.h"

static pm_picture *read_bytes(const pm_bytes *bytes)
{
    pm_error err = PM_ERROR_INIT;
    pm_picture *picture = NULL;
    if (pm_picture_read(bytes->data, bytes->size, "p.hdr", &picture, &err))
        fail_msg("%s", err.text);
    return picture;
}

static void refuses(const char *text, size_t size, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_picture *picture = NULL;
    char said[1200];
    pm_status st = pm_picture_read(text, size, "p.hdr", &picture, &err);
    assert_true(st && st == err.status);
    assert_null(picture);
    pm_error_format(&err, said, sizeof said);
    assert_string_equal(said, message);
}

static void near(double a, double b)
{
    if (!(fabs(a - b) <= 1e-12 * (1 + fabs(b))))
        fail_msg("%.17g is not %.17g", a, b);
}

static void near_rgb(pm_rgb c, double r, double g, double b)
{
    near(c.r, r);
    near(c.g, g);
    near(c.b, b);
}

static void header(pm_bytes *out, const char *lines, const char *size)
{
    pm_bytes_format(out, "#?RADIANCE\n%s\n%s\n", lines, size);
}

/* With exponent 136 a mantissa m is m + 1/2. */
static void pixel(pm_bytes *out, int r, int g, int b)
{
    const uint8_t p[4] = {(uint8_t)r, (uint8_t)g, (uint8_t)b, 136};
    pm_bytes_append(out, p, 4);
}

/* The same picture of 3 x 2, in each order; red is 10 (column + 1), green 20 (row + 1). */
static void each_orientation_is_turned_upright(void **state)
{
    (void)state;
    static const struct {
        const char *size;
        int slow_y, y_down, x_down;
    } order[] = {
        {"-Y 2 +X 3", 1, 1, 0}, {"-Y 2 -X 3", 1, 1, 1}, {"+Y 2 -X 3", 1, 0, 1},
        {"+Y 2 +X 3", 1, 0, 0}, {"+X 3 +Y 2", 0, 0, 0}, {"-X 3 +Y 2", 0, 0, 1},
        {"-X 3 -Y 2", 0, 1, 1}, {"+X 3 -Y 2", 0, 1, 0},
    };
    for (size_t i = 0; i < 8; i++) {
        pm_bytes bytes = {0};
        header(&bytes, "FORMAT=32-bit_rle_rgbe\n", order[i].size);
        for (int k = 0; k < 6; k++) {
            int x = order[i].slow_y ? k % 3 : k / 2, y = order[i].slow_y ? k / 3 : k % 2;
            x = order[i].x_down ? 2 - x : x;
            y = order[i].y_down ? 1 - y : y;
            pixel(&bytes, 10 * (x + 1), 20 * (y + 1), 7);
        }
        pm_picture *p = read_bytes(&bytes);
        assert_int_equal(pm_picture_width(p), 3);
        assert_int_equal(pm_picture_height(p), 2);
        for (uint32_t x = 0; x < 3; x++)
            for (uint32_t y = 0; y < 2; y++)
                near_rgb(pm_picture_pixel(p, x, y), 10 * (x + 1) + .5, 20 * (y + 1) + .5, 7.5);
        pm_picture_free(p);
        pm_bytes_clear(&bytes);
    }
}

/* u runs over the wider side's ratio; the outermost pixels lie on the edges. */
static void colours_between_pixels_are_bilinear(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    header(&bytes, "", "+Y 2 +X 4");
    for (int k = 0; k < 8; k++)
        pixel(&bytes, k % 4, k / 4, 0);
    pm_picture *p = read_bytes(&bytes);
    double u, v;
    pm_picture_extent(p, &u, &v);
    near(u, 2);
    near(v, 1);
    near_rgb(pm_picture_value(p, 0, 0), .5, .5, .5);
    near_rgb(pm_picture_value(p, 2, 1), 3.5, 1.5, .5);
    near_rgb(pm_picture_value(p, 1, .25), 2, .75, .5);
    near(pm_picture_value(p, NAN, 0).r, 0);
    near(pm_picture_value(p, 0, INFINITY).r, 0);
    /* two intervals above: (2 y1 - y0) / 4 of rows 0.5 and 1.5 */
    near(pm_picture_value(p, 0, 3).g, 2.5 / 4);
    pm_picture_free(p);
    pm_bytes_clear(&bytes);
}

static void pixaspect_shapes_and_exposure_does_not_count(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    double u, v;
    header(&bytes, "EXPOSURE=4\nPIXASPECT= 0.5\nPIXASPECT=0.5\nCOLORCORR= 2 2 2\n",
           "-Y 2 +X 1");
    pixel(&bytes, 8, 9, 10);
    pixel(&bytes, 4, 5, 6);
    pm_picture *p = read_bytes(&bytes);
    pm_picture_extent(p, &u, &v);
    near(u, 2);
    near(v, 1);
    near_rgb(pm_picture_value(p, 77, 1), 8.5, 9.5, 10.5);
    pm_picture_free(p);
    pm_bytes_clear(&bytes);
}

static void xyz_pixels_become_rgb(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    header(&bytes, "FORMAT=32-bit_rle_xyze\n", "-Y 1 +X 2");
    pixel(&bytes, 99, 99, 99);
    pixel(&bytes, 40, 50, 60);
    pm_picture *p = read_bytes(&bytes);
    near_rgb(pm_picture_pixel(p, 0, 0), 99.5, 99.5, 99.5);
    pm_rgb c = pm_rgb_of_xyz(40.5, 50.5, 60.5);
    near_rgb(pm_picture_pixel(p, 1, 0), c.r, c.g, c.b);
    pm_picture_free(p);
    pm_bytes_clear(&bytes);
}

/* Two rows of two pixels of four bands; with exponent 136 a mantissa m is m + 1/2. */
static void spectra_are_bilinear(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    double samples[PM_PICTURE_BANDS], nm0 = 0, nm1 = 0;
    header(&bytes, "NCOMP=4\nWAVELENGTH_SPLITS= 780 588 480 380\nFORMAT=Radiance_spectra\n",
           "-Y 2 +X 2");
    pm_bytes_append(&bytes, "\1\2\3\4\210\5\6\7\10\210\11\12\13\14\210\0\0\0\0\0", 20);
    pm_picture *p = read_bytes(&bytes);
    assert_int_equal(pm_picture_bands(p, &nm0, &nm1), 4);
    near(nm0, 780);
    near(nm1, 380);
    pm_picture_spectrum(p, 0, 1, samples);
    for (int i = 0; i < 4; i++)
        near(samples[i], i + 1.5);
    pm_picture_spectrum(p, 0.5, 0.5, samples);
    for (int i = 0; i < 4; i++)
        near(samples[i], (i + 1.5 + i + 5.5 + i + 9.5) / 4);
    pm_picture_spectrum(p, NAN, 0, samples);
    near(samples[3], 0);
    pm_picture_free(p);
    pm_bytes_clear(&bytes);
}

static void runs_of_both_kinds_are_expanded(void **state)
{
    (void)state;
    pm_bytes old = {0}, new = {0};
    header(&old, "", "-Y 1 +X 300");
    pixel(&old, 5, 6, 7);
    pm_bytes_append(&old, "\1\1\1\xd", 4); /* 13 */
    pm_bytes_append(&old, "\1\1\1\1", 4);  /* 256 */
    pixel(&old, 8, 9, 10);
    pm_bytes_append(&old, "\1\1\1\xff", 4); /* more than the line has left */
    header(&new, "", "-Y 1 +X 300");
    pm_bytes_append(&new, "\2\2\1\x2c", 4);
    for (int c = 0; c < 4; c++) {
        const uint8_t a = (uint8_t[]){5, 6, 7, 136}[c], b = (uint8_t[]){8, 9, 10, 136}[c];
        const uint8_t plane[] = {255, a, 255, a, 128 + 15, a, 1, a, 128 + 29, b, 1, b};
        pm_bytes_append(&new, plane, sizeof plane);
    }
    pm_picture *p = read_bytes(&old), *q = read_bytes(&new);
    for (uint32_t x = 0; x < 300; x++) {
        double r = x < 270 ? 5.5 : 8.5;
        near_rgb(pm_picture_pixel(p, x, 0), r, r + 1, r + 2);
        near_rgb(pm_picture_pixel(q, x, 0), r, r + 1, r + 2);
    }
    pm_picture_free(p);
    pm_picture_free(q);
    pm_bytes_clear(&old);
    pm_bytes_clear(&new);
}

static void each_truncation_is_refused(void **state)
{
    (void)state;
    pm_bytes bytes = {0};
    header(&bytes, "FORMAT=32-bit_rle_rgbe\n", "-Y 2 +X 8");
    for (int line = 0; line < 2; line++)
        pm_bytes_append(&bytes, "\2\2\0\x8\x88\1\x88\2\x84\3\4\4\5\6\7\x88\x80", 17);
    pm_picture_free(read_bytes(&bytes));
    for (size_t size = 0; size < bytes.size; size++) {
        pm_picture *p = NULL;
        pm_error err = PM_ERROR_INIT;
        uint8_t *exact = malloc(size + !size);
        memcpy(exact, bytes.data, size);
        assert_true(pm_picture_read(exact, size, "p.hdr", &p, &err));
        assert_true(err.status && !p);
        free(exact);
    }
    pm_bytes_clear(&bytes);
}

static void pictures_say_what_is_wrong(void **state)
{
    (void)state;
#define REFUSES(text, message) refuses(text, sizeof(text) - 1, message)
    REFUSES("", "p.hdr: the picture is empty");
    REFUSES("\x89PNG\n", "p.hdr: no Radiance picture: it does not start with '#?'");
    REFUSES("#?RADIANCE\nX=1\n", "p.hdr: the picture's header has no end");
    REFUSES("#?RADIANCE\nFORMAT=ascii\n\n",
            "p.hdr: the picture's format is 'ascii'; 32-bit_rle_rgbe, 32-bit_rle_xyze and "
            "Radiance_spectra are read");
    REFUSES("#?RADIANCE\nFORMAT=Radiance_spectra\n\n-Y 1 +X 1\n",
            "p.hdr: a spectral picture must say NCOMP, 4 to 24, and WAVELENGTH_SPLITS");
    REFUSES("#?RADIANCE\nNCOMP=25\n\n", "p.hdr: NCOMP must be a number from 3 to 24");
    REFUSES("#?RADIANCE\nWAVELENGTH_SPLITS= 780 588 480\n\n",
            "p.hdr: WAVELENGTH_SPLITS must be four wavelengths in nanometres");
    REFUSES("#?RADIANCE\nFORMAT=Radiance_spectra\nNCOMP=4\nWAVELENGTH_SPLITS=780 588 480 "
            "380\n\n+X 1 -Y 1\nabcde",
            "p.hdr: a spectral picture's size must be of the kind -Y +X");
    REFUSES("#?RADIANCE\nPIXASPECT=0\n\n",
            "p.hdr: PIXASPECT must be a number from 1e-6 to 1e6");
    REFUSES("#?RADIANCE\n\n-Y 2 +Y 3\n",
            "p.hdr: the picture's size must follow its header, such as '-Y 480 +X 640'");
    REFUSES("#?RADIANCE\n\n-Y 0 +X 3\n",
            "p.hdr: the picture's size must follow its header, such as '-Y 480 +X 640'");
    REFUSES("#?RADIANCE\n\n-Y 2147483647 +X 2147483647\nabcd",
            "p.hdr: the picture has 2147483647 x 2147483647 pixels; 2^27 are allowed");
    REFUSES("#?RADIANCE\n\n-Y 1000000 +X 10\nabcd",
            "p.hdr: the picture of 10 x 1000000 pixels is cut short");
    REFUSES("#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\x9zzzzzzzz",
            "p.hdr: scan line 1 of the picture's 1 is damaged or missing");
    REFUSES("#?RADIANCE\n\n-Y 1 +X 3\n\1\1\1\2zzzz",
            "p.hdr: scan line 1 of the picture's 1 is damaged or missing");
#undef REFUSES
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_orientation_is_turned_upright),
        cmocka_unit_test(colours_between_pixels_are_bilinear),
        cmocka_unit_test(pixaspect_shapes_and_exposure_does_not_count),
        cmocka_unit_test(xyz_pixels_become_rgb),
        cmocka_unit_test(spectra_are_bilinear),
        cmocka_unit_test(runs_of_both_kinds_are_expanded),
        cmocka_unit_test(each_truncation_is_refused),
        cmocka_unit_test(pictures_say_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
