#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "image/image.h"
#include "image/notes.h"

/* Radiance's picture format: refer/filefmts.html, "RADIANCE Picture Files"; rows of length
 * outside these bounds are not run-length encoded (MINELEN, MAXELEN in src/common/color.c). */
enum { RUN_WIDTH_MIN = 8, RUN_WIDTH_MAX = 0x7FFF, RUN_MIN = 4, RUN_MAX = 127, COPY_MAX = 128 };

/* Mantissas of 8 bits under the greatest channel's exponent, truncated. */
static void to_rgbe(const float rgb[3], uint8_t out[4])
{
    float greatest = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    memset(out, 0, 4);
    if (greatest <= 1e-32F)
        return;
    int exponent;
    frexpf(greatest, &exponent);
    for (int i = 0; i < 3; i++)
        out[i] = (uint8_t)ldexp((double)rgb[i], 8 - exponent);
    out[3] = (uint8_t)(exponent + 128);
}

static size_t run_length(const uint8_t *plane, size_t count)
{
    size_t run = 1;
    while (run < count && run < RUN_MAX && plane[run] == plane[0])
        run++;
    return run;
}

/* One byte plane of a row: a count over 128 repeats the next byte (count - 128) times, another
 * count copies as many bytes. */
static void append_runs(pm_bytes *out, const uint8_t *plane, size_t count)
{
    size_t at = 0;
    while (at < count) {
        size_t copy = 0, run = 0;
        while (at + copy < count && copy < COPY_MAX) {
            run = run_length(plane + at + copy, count - at - copy);
            if (run >= RUN_MIN)
                break;
            copy++;
            run = 0;
        }
        if (copy) {
            pm_bytes_u8(out, (uint8_t)copy);
            pm_bytes_append(out, plane + at, copy);
        }
        at += copy;
        if (run) {
            pm_bytes_u8(out, (uint8_t)(128 + run));
            pm_bytes_u8(out, plane[at]);
        }
        at += run;
    }
}

/* `planes` is scratch memory of 4 * width bytes. */
static void append_row(pm_bytes *out, const float *rgb, size_t width, uint8_t *planes)
{
    uint8_t pixel[4];
    bool runs = width >= RUN_WIDTH_MIN && width <= RUN_WIDTH_MAX;
    for (size_t x = 0; x < width; x++) {
        to_rgbe(rgb + 3 * x, pixel);
        if (!runs)
            pm_bytes_append(out, pixel, 4);
        for (size_t c = 0; c < 4; c++)
            planes[c * width + x] = pixel[c];
    }
    if (!runs)
        return;
    const uint8_t mark[4] = {2, 2, (uint8_t)(width >> 8), (uint8_t)(width & 0xFF)};
    pm_bytes_append(out, mark, 4);
    for (size_t c = 0; c < 4; c++)
        append_runs(out, planes + c * width, width);
}

static pm_status append_line(pm_bytes *out, const char *name, const char *sign,
                             const char *text)
{
    char *clean = pm_image_note_text(text);
    if (!clean)
        return PM_E_MEMORY;
    pm_bytes_format(out, "%s%s%s\n", name, sign, clean);
    free(clean);
    return PM_OK;
}

static pm_status append_header(pm_bytes *out, const pm_image *image,
                               const pm_image_notes *notes)
{
    static const pm_image_notes none = {0};
    pm_status st = PM_OK;
    notes = notes ? notes : &none;
    pm_bytes_text(out, "#?RADIANCE\n");
    if (notes->command)
        st = append_line(out, "", "", notes->command);
    if (!st && notes->view)
        st = append_line(out, "VIEW", "= ", notes->view);
    for (size_t i = 0; !st && i < notes->count; i++)
        st = append_line(out, notes->list[i].name, "= ", notes->list[i].value);
    pm_bytes_format(out, "FORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", image->height,
                    image->width);
    return st;
}

static pm_status check_range(const pm_image *image, pm_error *err)
{
    size_t values = (size_t)image->width * image->height * 3;
    for (size_t i = 0; i < values; i++)
        if (image->rgb[i] >= 0x1p127F)
            return pm_error_set(err, PM_E_RANGE,
                                "radiance %g does not fit a Radiance picture; "
                                "OpenEXR would hold it",
                                (double)image->rgb[i]);
    return PM_OK;
}

pm_status pm_image_write_hdr(const pm_image *image, const pm_image_notes *notes, pm_bytes *out,
                             pm_error *err)
{
    pm_status st = pm_image_check(image, false, err);
    if (!st)
        st = check_range(image, err);
    if (st)
        return st;
    size_t before = out->size;
    uint8_t *planes = malloc(4 * (size_t)image->width);
    st = planes ? append_header(out, image, notes) : PM_E_MEMORY;
    for (size_t y = 0; !st && y < image->height; y++)
        append_row(out, image->rgb + 3 * y * image->width, image->width, planes);
    free(planes);
    if (!st)
        st = pm_bytes_status(out);
    if (st) {
        out->size = before;
        return pm_error_set(err, st, "no memory for a picture of %u x %u", image->width,
                            image->height);
    }
    return PM_OK;
}
