#ifndef PM_IMAGE_IMAGE_H
#define PM_IMAGE_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#include "base/bytes.h"
#include "base/error.h"

/* Pictures and their files.
 *
 * In: linear float RGB. Out: bytes of OpenEXR, Radiance HDR or PNG. */

typedef struct pm_image {
    uint32_t width, height;
    float *rgb; /* [height][width][3], rows from the top; radiance [W/(m^2 sr)] */
} pm_image;

PM_MUST_USE pm_status pm_image_init(pm_image *image, uint32_t width, uint32_t height);
void pm_image_clear(pm_image *image);

/* Text that goes into the headers, name by name. */
typedef struct pm_image_note {
    const char *name;  /* EXR attribute name, e.g. "pm.scene" */
    const char *value;
} pm_image_note;

typedef struct pm_image_notes {
    const pm_image_note *list;
    size_t count;
    const char *view;    /* "-vtv -vp ..." : VIEW= line of HDR and attribute "view" of EXR; or NULL */
    const char *command; /* the command line as typed; or NULL */
} pm_image_notes;

/* Float channels B, G, R, ZIP compression. */
PM_MUST_USE pm_status pm_image_write_exr(const pm_image *image, const pm_image_notes *notes,
                                         pm_bytes *out, pm_error *err);

/* Radiance's RGBE, run-length encoded, mantissas truncated as readers expect (they add half a
 * step). Negative or non-finite pixels are PM_E_RANGE. */
PM_MUST_USE pm_status pm_image_write_hdr(const pm_image *image, const pm_image_notes *notes,
                                         pm_bytes *out, pm_error *err);

/* 8-bit sRGB for looking: exposure chosen from the picture's log-average luminance, highlights
 * rolled off; the same picture gives the same bytes. */
PM_MUST_USE pm_status pm_image_write_png(const pm_image *image, const pm_image_notes *notes,
                                         pm_bytes *out, pm_error *err);

/* Reads the two float formats that are written here (for tests and tools). */
PM_MUST_USE pm_status pm_image_read_exr(const void *data, size_t size, const char *name,
                                        pm_image *out, pm_error *err);

#endif
