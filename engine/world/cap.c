#include "world/cap.h"

#include <math.h>

#include "base/maths.h"

/* The horizon cuts a cone of at most a hemisphere. */
static double cut_by_horizon(double versine, double cosine)
{
    double square = versine * (2 - versine); /* sin^2 of the cone's half angle */
    double cotangent = (1 - versine) / sqrt(square);
    double sine = sqrt((1 - cosine) * (1 + cosine));
    double y = -cotangent * cosine / sine;
    double root = sine * sqrt(fmax(1 - y * y, 0));
    double angle = pm_acos(fmax(-1, fmin(y, 1)));
    return (cosine * angle - cotangent * root) * square + pm_atan2(root, cotangent);
}

double pm_cap_projected(double versine, double cosine)
{
    if (versine > 1) /* the hemisphere less the rest of the sphere; which may be nothing */
        return PM_PI - (versine < 2 ? pm_cap_projected(2 - versine, -cosine) : 0);
    double square = versine * (2 - versine);
    if (cosine * cosine >= square) /* the horizon does not cut it */
        return cosine > 0 ? PM_PI * square * cosine : 0;
    return cut_by_horizon(versine, cosine);
}
