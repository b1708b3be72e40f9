#ifndef PM_BASE_XYZ_H
#define PM_BASE_XYZ_H

#include <stddef.h>

#include "base/rgb.h"

/* Colours from CIE 1931 XYZ and from spectra, in Radiance's standard primaries: x y of red
 * 0.640 0.330, green 0.290 0.600, blue 0.150 0.060, white 1/3 1/3 (src/common/color.h), where
 * equal energy is (1, 1, 1). Nothing is clipped: a colour outside the primaries' triangle has
 * negative parts. */
pm_rgb pm_rgb_of_xyz(double x, double y, double z);

/* The wavelengths that light has [nm]. */
#define PM_NM_MIN 380.0
#define PM_NM_MAX 780.0

/* RGB of a spectrum in `count` equal steps from `nm0` to `nm1` [nm], outer edges in either
 * order, zero outside. Each tristimulus value is the mean of the spectrum weighted by its
 * matching function, so that a constant 1 over all light is white 1. As in Radiance a colour
 * outside the gamut is mixed with grey of its luminance until it is inside.
 * Source: CIE 1931 standard colorimetric observer, ISO/CIE 11664-1 (Wyszecki and Stiles, Color
 * Science, 2nd ed., table I(3.3.1)); clipgamut and scolor2rgb in Radiance's spec_rgb.c. Test:
 * xyz_* in test_xyz.c. */
pm_rgb pm_rgb_of_spectrum(const double *samples, size_t count, double nm0, double nm1);

#endif
