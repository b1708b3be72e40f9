#include "base/warp.h"

#include <stdbool.h>

#include "base/maths.h"

/* From [-1, 1] and what rounding adds to it. */
static double unit_of(double a)
{
    return fmax(0, fmin((a + 1) / 2, 1 - 0x1p-53));
}

void pm_warp_disc_inverse(double x, double y, double *u, double *v)
{
    double radius = sqrt(x * x + y * y);
    bool across = fabs(x) > fabs(y);
    double major = across ? x : y, minor = across ? y : x;
    double a = copysign(radius, major);
    double b = a * (4 / PM_PI) * (major != 0 ? pm_atan2(minor / major, 1) : 0);
    *u = unit_of(across ? a : b);
    *v = unit_of(across ? b : a);
}

static pm_vec3 around_axis(double radius, double v, double z)
{
    double sine, cosine;
    pm_sincos(2 * PM_PI * v, &sine, &cosine);
    return (pm_vec3){radius * cosine, radius * sine, z};
}

pm_vec3 pm_warp_sphere(double u, double v)
{
    double z = 1 - 2 * u;
    double r2 = 1 - z * z;
    return around_axis(sqrt(r2 > 0 ? r2 : 0), v, z);
}

pm_vec3 pm_warp_cone(double u, double v, double versine)
{
    double w = u * versine; /* 1 - cos(theta) */
    return around_axis(sqrt(w * (2 - w)), v, 1 - w);
}

/* With w = 1 - cos and r the radius on the disc, w = r^2 versine, and the radius on the sphere
 * is sqrt(w (2 - w)). */
pm_vec3 pm_warp_cap(double u, double v, double versine)
{
    pm_vec3 d = pm_warp_disc(u, v);
    double w = fmin((d.x * d.x + d.y * d.y) * versine, 2);
    double stretch = sqrt(versine * (2 - w));
    return (pm_vec3){stretch * d.x, stretch * d.y, 1 - w};
}

void pm_warp_cap_inverse(pm_vec3 d, double versine, double *u, double *v)
{
    double square = d.x * d.x + d.y * d.y;
    double w = d.z > 0 ? square / (1 + d.z) : 1 - d.z; /* without cancellation at the axis */
    double stretch = sqrt(versine * fmax(2 - w, 0));
    if (stretch > 0)
        pm_warp_disc_inverse(d.x / stretch, d.y / stretch, u, v);
    else
        pm_warp_disc_inverse(1, 0, u, v); /* straight behind: the rim is one direction */
}

double pm_versine(double angle)
{
    double s = pm_sin(angle / 2);
    return 2 * s * s;
}
