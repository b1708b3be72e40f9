#ifndef PM_BASE_RGB_H
#define PM_BASE_RGB_H

#include <math.h>
#include <stdbool.h>

/* Linear RGB of any radiometric quantity. */
typedef struct pm_rgb {
    double r, g, b;
} pm_rgb;

static inline pm_rgb pm_rgb_make(double r, double g, double b)
{
    return (pm_rgb){r, g, b};
}

static inline pm_rgb pm_rgb_grey(double v)
{
    return (pm_rgb){v, v, v};
}

static inline pm_rgb pm_rgb_add(pm_rgb a, pm_rgb b)
{
    return (pm_rgb){a.r + b.r, a.g + b.g, a.b + b.b};
}

static inline pm_rgb pm_rgb_sub(pm_rgb a, pm_rgb b)
{
    return (pm_rgb){a.r - b.r, a.g - b.g, a.b - b.b};
}

static inline pm_rgb pm_rgb_mul(pm_rgb a, pm_rgb b)
{
    return (pm_rgb){a.r * b.r, a.g * b.g, a.b * b.b};
}

static inline pm_rgb pm_rgb_scale(pm_rgb a, double s)
{
    return (pm_rgb){a.r * s, a.g * s, a.b * s};
}

/* a + s b */
static inline pm_rgb pm_rgb_madd(pm_rgb a, double s, pm_rgb b)
{
    return (pm_rgb){a.r + s * b.r, a.g + s * b.g, a.b + s * b.b};
}

static inline double pm_rgb_max(pm_rgb a)
{
    double m = a.r > a.g ? a.r : a.g;
    return m > a.b ? m : a.b;
}

static inline double pm_rgb_mean(pm_rgb a)
{
    return (a.r + a.g + a.b) / 3;
}

/* Radiance's photopic weights of its default primaries (src/common/color.h, CIE_rf .. CIE_bf).
 */
static inline double pm_rgb_luminance(pm_rgb a)
{
    return 0.265074126 * a.r + 0.670114631 * a.g + 0.064811243 * a.b;
}

static inline bool pm_rgb_is_black(pm_rgb a)
{
    return !(a.r > 0 || a.g > 0 || a.b > 0);
}

static inline bool pm_rgb_finite(pm_rgb a)
{
    return isfinite(a.r) && isfinite(a.g) && isfinite(a.b);
}

#endif
