#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "base/maths.h"
#include "base/rgb.h"
#include "image/image.h"
#include "image/notes.h"

/* ---- tone mapping ---- */

struct tone {
    double exposure; /* radiance to scaled luminance */
    double white;    /* scaled luminance that becomes pure white */
};

static pm_rgb pixel_at(const pm_image *image, size_t i)
{
    const float *p = image->rgb + 3 * i;
    return pm_rgb_make((double)p[0], (double)p[1], (double)p[2]);
}

/* Reinhard et al. 2002, eqs. 1 and 2, over the pixels that are not black; eq. 4 with the
 * picture's greatest luminance as the white point. */
static struct tone choose_tone(const pm_image *image)
{
    const double key = 0.18;
    size_t pixels = (size_t)image->width * image->height, lit = 0;
    double logs = 0, greatest = 0;
    for (size_t i = 0; i < pixels; i++) {
        double luminance = pm_rgb_luminance(pixel_at(image, i));
        if (!(luminance > 0))
            continue;
        logs += pm_log(luminance);
        lit++;
        greatest = fmax(greatest, luminance);
    }
    if (!lit)
        return (struct tone){1, 1};
    double exposure = key / pm_exp(logs / (double)lit);
    return (struct tone){exposure, fmax(1, exposure * greatest)};
}

/* IEC 61966-2-1. */
static uint8_t srgb(double linear)
{
    double v = fmin(linear, 1);
    double encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * pm_pow(v, 1 / 2.4) - 0.055;
    return (uint8_t)(255 * encoded + 0.5);
}

static void tone_row(const pm_image *image, struct tone tone, size_t y, uint8_t *out)
{
    for (size_t x = 0; x < image->width; x++) {
        pm_rgb c = pm_rgb_scale(pixel_at(image, y * image->width + x), tone.exposure);
        double luminance = pm_rgb_luminance(c);
        double over = luminance / (tone.white * tone.white);
        c = pm_rgb_scale(c, (1 + over) / (1 + luminance));
        out[3 * x] = srgb(c.r);
        out[3 * x + 1] = srgb(c.g);
        out[3 * x + 2] = srgb(c.b);
    }
}

/* ---- libpng ---- */

struct writing {
    pm_bytes *out;
    pm_error *err;
    png_structp png;
    png_infop info;
    uint8_t *row;
};

static void on_error(png_structp png, png_const_charp text)
{
    struct writing *w = png_get_error_ptr(png);
    (void)pm_error_set(w->err, PM_E_MEMORY, "PNG: %s", text);
    longjmp(png_jmpbuf(png), 1);
}

static void on_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

static void on_write(png_structp png, png_bytep data, size_t size)
{
    struct writing *w = png_get_io_ptr(png);
    pm_bytes_append(w->out, data, size);
    if (w->out->failed)
        png_error(png, "no memory");
}

static void on_flush(png_structp png)
{
    (void)png;
}

/* Called under setjmp. */
static pm_status put_text(void *context, const char *name, const char *value)
{
    struct writing *w = context;
    png_text text = {.compression = PNG_ITXT_COMPRESSION_NONE,
                     .key = (char *)(uintptr_t)name, /* libpng copies both */
                     .text = (char *)(uintptr_t)value};
    png_set_text(w->png, w->info, &text, 1);
    return PM_OK;
}

/* Everything between setjmp and the end: libpng leaves by longjmp. */
static pm_status write_all(struct writing *w, const pm_image *image,
                           const pm_image_notes *notes)
{
    if (setjmp(png_jmpbuf(w->png)))
        return PM_E_MEMORY;
    png_set_write_fn(w->png, w, on_write, on_flush);
    png_set_user_limits(w->png, PM_IMAGE_SIDE_MAX, PM_IMAGE_SIDE_MAX);
    png_set_IHDR(w->png, w->info, image->width, image->height, 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    pm_status st = pm_image_notes_each(notes, put_text, w);
    if (st)
        return st;
    png_write_info(w->png, w->info);
    struct tone tone = choose_tone(image);
    for (size_t y = 0; y < image->height; y++) {
        tone_row(image, tone, y, w->row);
        png_write_row(w->png, w->row);
    }
    png_write_end(w->png, NULL);
    return PM_OK;
}

pm_status pm_image_write_png(const pm_image *image, const pm_image_notes *notes, pm_bytes *out,
                             pm_error *err)
{
    pm_status st = pm_image_check(image, false, err);
    if (st)
        return st;
    size_t before = out->size;
    struct writing w = {.out = out, .err = err};
    w.row = malloc(3 * (size_t)image->width);
    w.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &w, on_error, on_warning);
    w.info = w.png ? png_create_info_struct(w.png) : NULL;
    st = w.row && w.info ? write_all(&w, image, notes) : PM_E_MEMORY;
    png_destroy_write_struct(&w.png, &w.info);
    free(w.row);
    if (st) {
        out->size = before;
        return pm_error_set(err, st, "no memory for a picture of %u x %u", image->width,
                            image->height);
    }
    return PM_OK;
}
