#ifndef PM_IMAGE_IMAGE_H
#define PM_IMAGE_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/error.h"

/* Pictures and their files.
 *
 * In: linear float RGB. Out: bytes of OpenEXR, Radiance HDR or PNG. */

/* What else is known of each pixel, e.g. its error. EXR files alone hold it: three channels
 * are called NAME.R, NAME.G, NAME.B, one has the layer's name. */
typedef struct pm_image_layer {
    char name[24];
    unsigned channels; /* 1 or 3 */
    float *values;     /* [height][width][channels]; may be infinite */
} pm_image_layer;

enum { PM_IMAGE_LAYERS = 10 };

typedef struct pm_image {
    uint32_t width, height;
    float *rgb; /* [height][width][3], rows from the top; radiance [W/(m^2 sr)] */
    pm_image_layer layers[PM_IMAGE_LAYERS];
    unsigned layer_count;
} pm_image;

enum { PM_IMAGE_SIDE_MAX = 1 << 20, PM_IMAGE_PIXELS_MAX = 1 << 28 };

/* A black picture. PM_E_LIMIT for an empty one and beyond the limits above, PM_E_MEMORY. */
PM_MUST_USE pm_status pm_image_init(pm_image *image, uint32_t width, uint32_t height);
void pm_image_clear(pm_image *image);

/* Adds a layer of zeros, at most PM_IMAGE_LAYERS, and returns its values; NULL if memory is
 * short. */
float *pm_image_add_layer(pm_image *image, const char *name, unsigned channels);

/* Text that goes into the headers, name by name. EXR: string attributes; HDR: lines `name=
 * value`; PNG: text chunks. Control characters become spaces, so that no value can pass for
 * another line. */
typedef struct pm_image_note {
    const char *name; /* e.g. "pm.scene"; at most 79 letters of ASCII */
    const char *value;
} pm_image_note;

typedef struct pm_image_notes {
    const pm_image_note *list;
    size_t count;
    const char *view; /* "-vtv -vp ...": VIEW= line of HDR, "pm.view" elsewhere; or NULL */
    const char
        *command; /* as typed: first line of HDR's header, "pm.command" elsewhere; or NULL */
} pm_image_notes;

/* The writers append to `out`; `notes` may be NULL. A pixel that is not finite is PM_E_RANGE,
 * so is a negative one in HDR and PNG. On an error `out` keeps what it held before. */

/* Float channels B, G, R and those of the layers, ZIP compression. Tests:
 * exr_round_trip_is_bit_exact, layers_are_channels_of_their_own. */
PM_MUST_USE pm_status pm_image_write_exr(const pm_image *image, const pm_image_notes *notes,
                                         pm_bytes *out, pm_error *err);

/* Radiance's RGBE, run-length encoded (flat where a row is shorter than 8 or longer than 32767
 * pixels), mantissas truncated as readers expect (they add half a step). Values from 2^127 on
 * do not fit: PM_E_RANGE. Values below 1e-32 are black, as in Radiance (setcolr(), color.c).
 * Test: hdr_decodes_within_half_a_step. */
PM_MUST_USE pm_status pm_image_write_hdr(const pm_image *image, const pm_image_notes *notes,
                                         pm_bytes *out, pm_error *err);

/* 8-bit sRGB for looking: exposure chosen from the picture's log-average luminance, highlights
 * rolled off; the same picture gives the same bytes.
 * Source: Reinhard, Stark, Shirley, Ferwerda, "Photographic tone reproduction", SIGGRAPH 2002,
 * eqs. 1, 2, 4; IEC 61966-2-1 (sRGB). */
PM_MUST_USE pm_status pm_image_write_png(const pm_image *image, const pm_image_notes *notes,
                                         pm_bytes *out, pm_error *err);

/* Reads channels R, G and B of an EXR of scanlines (for tests and tools), or those of a layer
 * unless `layer` is NULL. PM_E_CORRUPT with the library's reason, PM_E_UNSUPPORTED for tiles,
 * deep data and channels that are not there, PM_E_LIMIT. */
PM_MUST_USE pm_status pm_image_read_exr(const void *data, size_t size, const char *name,
                                        const char *layer, pm_image *out, pm_error *err);

#endif
