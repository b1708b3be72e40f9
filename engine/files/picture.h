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
 * primaries. Radiance 6's hyperspectral pictures (Radiance_spectra) are read too, for specpict.
 * Source: Radiance's refer/filefmts, "Picture files"; getpict and getspec in its data.c; Ward,
 * "Real pixels", Graphics Gems II, 1991. Tests: test_picture.c. */

typedef struct pm_picture pm_picture;

/* Reads `size` bytes; `name` is for messages. Refuses a size that the bytes cannot hold before
 * memory is taken for it. */
PM_MUST_USE pm_status pm_picture_read(const void *bytes, size_t size, const char *name,
                                      pm_picture **out, pm_error *err);
void pm_picture_free(pm_picture *picture);

/* Pixels as the picture stands: width to the right, height upwards. */
uint32_t pm_picture_width(const pm_picture *picture);
uint32_t pm_picture_height(const pm_picture *picture);

/* Samples of a spectrum that each pixel has; 0: an RGBE or XYZE picture. They stand for equal
 * steps from *nm0 to *nm1 [nm], which are left untouched if there are none. */
enum { PM_PICTURE_BANDS = 24 };
unsigned pm_picture_bands(const pm_picture *picture, double *nm0, double *nm1);

/* The spectrum at (u, v) [pm_picture_bands], looked up as pm_picture_value does. */
void pm_picture_spectrum(const pm_picture *picture, double u, double v, double *samples);

/* Pixel in column x from the left, row y from the bottom; in range. Not of a spectral picture.
 */
pm_rgb pm_picture_pixel(const pm_picture *picture, uint32_t x, uint32_t y);

/* Largest u (to the right) and v (upwards): the smaller of both is 1, both start at 0. */
void pm_picture_extent(const pm_picture *picture, double *u, double *v);

/* Colour at (u, v) of a picture without bands, bilinear between the outermost pixels' centres at 0 and the extent; beyond
 * as in pm_data_value. Black if a coordinate is not a number. */
pm_rgb pm_picture_value(const pm_picture *picture, double u, double v);

#endif
