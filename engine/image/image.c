#include "image/image.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/notes.h"

pm_status pm_image_init(pm_image *image, uint32_t width, uint32_t height)
{
    if (!width || !height || width > PM_IMAGE_SIDE_MAX || height > PM_IMAGE_SIDE_MAX ||
        (uint64_t)width * height > PM_IMAGE_PIXELS_MAX)
        return PM_E_LIMIT;
    float *rgb = calloc((size_t)width * height, 3 * sizeof *rgb);
    if (!rgb)
        return PM_E_MEMORY;
    *image = (pm_image){.width = width, .height = height, .rgb = rgb};
    return PM_OK;
}

float *pm_image_add_layer(pm_image *image, const char *name, unsigned channels)
{
    assert(image->layer_count < PM_IMAGE_LAYERS);
    pm_image_layer *layer = &image->layers[image->layer_count];
    *layer = (pm_image_layer){.channels = channels};
    snprintf(layer->name, sizeof layer->name, "%s", name);
    layer->values =
        calloc((size_t)image->width * image->height, channels * sizeof *layer->values);
    image->layer_count += layer->values != NULL;
    return layer->values;
}

void pm_image_clear(pm_image *image)
{
    for (unsigned i = 0; i < image->layer_count; i++)
        free(image->layers[i].values);
    free(image->rgb);
    *image = (pm_image){0};
}

char *pm_image_note_text(const char *text)
{
    char *copy = strdup(text);
    for (char *c = copy; c && *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7F)
            *c = ' ';
    return copy;
}

static pm_status put_clean(pm_status (*put)(void *, const char *, const char *), void *context,
                           const char *name, const char *value)
{
    char *clean = pm_image_note_text(value);
    pm_status st = clean ? put(context, name, clean) : PM_E_MEMORY;
    free(clean);
    return st;
}

pm_status pm_image_notes_each(const pm_image_notes *notes,
                              pm_status (*put)(void *context, const char *name,
                                               const char *value),
                              void *context)
{
    pm_status st = PM_OK;
    for (size_t i = 0; notes && !st && i < notes->count; i++)
        st = put_clean(put, context, notes->list[i].name, notes->list[i].value);
    if (!st && notes && notes->view)
        st = put_clean(put, context, "pm.view", notes->view);
    if (!st && notes && notes->command)
        st = put_clean(put, context, "pm.command", notes->command);
    return st;
}

pm_status pm_image_check(const pm_image *image, bool negative_allowed, pm_error *err)
{
    size_t values = (size_t)image->width * image->height * 3;
    for (size_t i = 0; i < values; i++) {
        float v = image->rgb[i];
        if (isfinite(v) && (negative_allowed || v >= 0))
            continue;
        size_t pixel = i / 3;
        return pm_error_set(err, PM_E_RANGE,
                            "pixel %zu of row %zu is %g; a picture holds finite%s "
                            "numbers only",
                            pixel % image->width, pixel / image->width, (double)v,
                            negative_allowed ? "" : ", non-negative");
    }
    return PM_OK;
}
