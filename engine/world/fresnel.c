#include "world/fresnel.h"

#include <math.h>

#include "base/maths.h"

static double square(double x)
{
    return x * x;
}

double pm_fresnel_dielectric(double cosine, double ratio, double *cosine_refracted)
{
    double square_refracted = 1 - square(ratio) * (1 - square(cosine));
    *cosine_refracted = 0;
    if (!(square_refracted > 0) || !(cosine > 0))
        return 1;
    double other = *cosine_refracted = sqrt(square_refracted);
    double parallel = (cosine - ratio * other) / (cosine + ratio * other);
    double perpendicular = (other - ratio * cosine) / (other + ratio * cosine);
    return (square(parallel) + square(perpendicular)) / 2;
}

pm_pane pm_pane_at(double cosine, double index)
{
    pm_pane pane = {.path = 1};
    double other;
    pm_fresnel_dielectric(cosine, 1 / index, &other);
    if (!(other > 0)) /* index below 1, beyond the critical angle; or exactly grazing */
        return (pm_pane){{1, 1}, 1};
    pane.path = 1 / other;
    pane.reflectance[0] = square((cosine - index * other) / (cosine + index * other));
    pane.reflectance[1] = square((other - index * cosine) / (other + index * cosine));
    return pane;
}

/* Share that one crossing leaves. */
static double crossing(const pm_pane *pane, double transmissivity)
{
    if (transmissivity <= 0 || transmissivity == 1)
        return transmissivity <= 0 ? 0 : 1;
    return pm_pow(transmissivity, pane->path);
}

static double slab_transmittance(double r, double a)
{
    return r < 1 ? square(1 - r) * a / ((1 - r * a) * (1 + r * a)) : 0;
}

double pm_pane_transmittance(const pm_pane *pane, double transmissivity)
{
    double a = crossing(pane, transmissivity);
    return (slab_transmittance(pane->reflectance[0], a) +
            slab_transmittance(pane->reflectance[1], a)) /
           2;
}

double pm_pane_reflectance(const pm_pane *pane, double transmissivity)
{
    double a = crossing(pane, transmissivity), sum = 0;
    for (int i = 0; i < 2; i++) {
        double r = pane->reflectance[i];
        sum += r + r * a * slab_transmittance(r, a);
    }
    return sum / 2;
}

double pm_fresnel_estimate(double cosine)
{
    return pm_exp(-5.85 * cosine) - 0.00287989916;
}

double pm_fresnel_schlick(double cosine)
{
    double rest = 1 - cosine;
    return square(square(rest)) * rest;
}
