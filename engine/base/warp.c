#include "base/warp.h"

#include <stdbool.h>

#include "base/maths.h"

pm_frame pm_frame_make(pm_vec3 n)
{
    double sign = copysign(1.0, n.z);
    double a = -1 / (sign + n.z);
    double b = n.x * n.y * a;
    return (pm_frame){.x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x},
                      .y = {b, sign + n.y * n.y * a, -n.y},
                      .z = n};
}

pm_vec3 pm_frame_to_world(const pm_frame *f, pm_vec3 v)
{
    return (pm_vec3){v.x * f->x.x + v.y * f->y.x + v.z * f->z.x,
                     v.x * f->x.y + v.y * f->y.y + v.z * f->z.y,
                     v.x * f->x.z + v.y * f->y.z + v.z * f->z.z};
}

pm_vec3 pm_frame_to_local(const pm_frame *f, pm_vec3 v)
{
    return (pm_vec3){pm_vec3_dot(v, f->x), pm_vec3_dot(v, f->y), pm_vec3_dot(v, f->z)};
}

/* Sine and cosine for |x| <= pi/4 by Taylor's series, whose first terms left out are below
 * 5e-17 and 6e-18: a third of the cost of the general functions, and the disc needs no more. */
static void short_sincos(double x, double *sine, double *cosine)
{
    double q = x * x;
    double s = 1. / 1307674368000;
    s = 1. / 6227020800 - q * s;
    s = 1. / 39916800 - q * s;
    s = 1. / 362880 - q * s;
    s = 1. / 5040 - q * s;
    s = 1. / 120 - q * s;
    s = 1. / 6 - q * s;
    *sine = x - x * (q * s);
    double c = 1. / 20922789888000;
    c = 1. / 87178291200 - q * c;
    c = 1. / 479001600 - q * c;
    c = 1. / 3628800 - q * c;
    c = 1. / 40320 - q * c;
    c = 1. / 720 - q * c;
    c = 1. / 24 - q * c;
    c = .5 - q * c;
    *cosine = 1 - q * c;
}

pm_vec3 pm_warp_disc(double u, double v)
{
    double a = 2 * u - 1, b = 2 * v - 1, sine, cosine;
    if (a == 0 && b == 0)
        return (pm_vec3){0, 0, 0};
    if (fabs(a) > fabs(b)) {
        short_sincos(PM_PI / 4 * (b / a), &sine, &cosine);
        return (pm_vec3){a * cosine, a * sine, 0};
    }
    short_sincos(PM_PI / 4 * (a / b), &sine, &cosine); /* of the angle to the y axis */
    return (pm_vec3){b * sine, b * cosine, 0};
}

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

pm_vec3 pm_warp_cosine(double u, double v)
{
    pm_vec3 d = pm_warp_disc(u, v);
    double z2 = 1 - d.x * d.x - d.y * d.y;
    d.z = sqrt(z2 > 0x1p-64 ? z2 : 0x1p-64); /* never in the plane: the pdf stays positive */
    return d;
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
