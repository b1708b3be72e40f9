#ifndef PM_WORLD_SPECTRUM_H
#define PM_WORLD_SPECTRUM_H

#include "base/rgb.h"
#include "files/data.h"

/* Samples of a spectrum at equal steps of wavelength, which stand for the interval around each.
 */
enum { PM_SPECTRUM_MAX = 256 };

struct pm_spectrum {
    double first, step; /* wavelength of value[0]; step > 0 or < 0 [nm] */
    unsigned count;     /* 2 .. PM_SPECTRUM_MAX */
    double value[PM_SPECTRUM_MAX];
};

/* Wavelengths of an axis of data: those of an even one, twice as many over an uneven one, and
 * not more than PM_SPECTRUM_MAX. The values are not set. */
void pm_spectrum_of_axis(struct pm_spectrum *out, const pm_data_axis *axis);

/* Wavelengths at the middles of equal steps over what [nm0, nm1] has of visible light; false if
 * it has none. */
bool pm_spectrum_of_range(struct pm_spectrum *out, double nm0, double nm1);

double pm_spectrum_wavelength(const struct pm_spectrum *spectrum, unsigned i);
pm_rgb pm_spectrum_rgb(const struct pm_spectrum *spectrum);

#endif
