#include "world/spectrum.h"

#include "base/xyz.h"

/* Steps that a function of wavelength is asked at, over all of visible light. */
enum { FUNCTION_STEPS = 40 };

void pm_spectrum_of_axis(struct pm_spectrum *out, const pm_data_axis *axis)
{
    uint32_t wanted = axis->ordinates ? 2 * axis->count : axis->count;
    out->count = wanted < PM_SPECTRUM_MAX ? wanted : PM_SPECTRUM_MAX;
    out->first = axis->first;
    out->step = (axis->last - axis->first) / (out->count - 1);
}

bool pm_spectrum_of_range(struct pm_spectrum *out, double nm0, double nm1)
{
    double low = fmax(fmin(nm0, nm1), PM_NM_MIN), high = fmin(fmax(nm0, nm1), PM_NM_MAX);
    if (!(low < high))
        return false;
    double share = (high - low) / (PM_NM_MAX - PM_NM_MIN);
    out->count = 2 + (unsigned)(share * (FUNCTION_STEPS - 2));
    out->step = (high - low) / out->count;
    out->first = low + 0.5 * out->step;
    return true;
}

double pm_spectrum_wavelength(const struct pm_spectrum *spectrum, unsigned i)
{
    return spectrum->first + i * spectrum->step;
}

pm_rgb pm_spectrum_rgb(const struct pm_spectrum *s)
{
    double start = s->first - 0.5 * s->step;
    return pm_rgb_of_spectrum(s->value, s->count, start, start + s->count * s->step);
}
