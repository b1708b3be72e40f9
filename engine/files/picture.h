#ifndef PM_FILES_PICTURE_H
#define PM_FILES_PICTURE_H

#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/rgb.h"

/* Radiance pictures (.hdr, .pic) as colorpict and mixpict use them.
 *
 * In: a file's bytes. Out: pm_picture (immutable). Next: world/texture.h looks colours up.
 *
 * Read are RGBE and XYZE pixels, flat, in old and in new runs, in all eight orientations. As in
 * Radiance's getpict the pixels count as they are stored: EXPOSURE, COLORCORR and PRIMARIES do
 * not change them; PIXASPECT shapes the coordinates. XYZE becomes RGB of Radiance's standard
 * primaries. Source: Radiance's refer/filefmts, "Picture files"; Ward, "Real pixels", Graphics
 * Gems II, 1991. Tests: test_picture.c. */

typedef struct pm_picture pm_picture;

/* Reads `size` bytes; `name` is for messages. Refuses a size that the bytes cannot hold before
 * memory is taken for it. */
PM_MUST_USE pm_status pm_picture_read(const void *bytes, size_t size, const char *name,
                                      pm_picture **out, pm_error *err);
void pm_picture_free(pm_picture *picture);

/* Pixels as the picture stands: width to the right, height upwards. */
uint32_t pm_picture_width(const pm_picture *picture);
uint32_t pm_picture_height(const pm_picture *picture);

/* Pixel in column x from the left, row y from the bottom; in range. */
pm_rgb pm_picture_pixel(const pm_picture *picture, uint32_t x, uint32_t y);

/* Largest u (to the right) and v (upwards): the smaller of both is 1, both start at 0. */
void pm_picture_extent(const pm_picture *picture, double *u, double *v);

/* Colour at (u, v), bilinear between the outermost pixels' centres at 0 and the extent; beyond
 * as in pm_data_value. Black if a coordinate is not a number. */
pm_rgb pm_picture_value(const pm_picture *picture, double u, double v);

#endif
