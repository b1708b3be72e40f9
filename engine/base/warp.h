#ifndef PM_BASE_WARP_H
#define PM_BASE_WARP_H

#include <stdbool.h>

#include "base/maths.h"
#include "base/vec3.h"

/* Maps from the unit square to directions and discs. Those that every bounce needs are inline:
 * vectors that go through memory between functions cost more than the sums. Test:
 * warp_moments_are_analytic. */

/* An orthonormal frame; z is the given unit normal. */
typedef struct pm_frame {
    pm_vec3 x, y, z;
} pm_frame;

/* Source: Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline pm_frame pm_frame_make(pm_vec3 n)
{
    double sign = copysign(1.0, n.z);
    double a = -1 / (sign + n.z);
    double b = n.x * n.y * a;
    return (pm_frame){.x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x},
                      .y = {b, sign + n.y * n.y * a, -n.y},
                      .z = n};
}

static inline pm_vec3 pm_frame_to_world(const pm_frame *f, pm_vec3 v)
{
    return (pm_vec3){v.x * f->x.x + v.y * f->y.x + v.z * f->z.x,
                     v.x * f->x.y + v.y * f->y.y + v.z * f->z.y,
                     v.x * f->x.z + v.y * f->y.z + v.z * f->z.z};
}

static inline pm_vec3 pm_frame_to_local(const pm_frame *f, pm_vec3 v)
{
    return (pm_vec3){pm_vec3_dot(v, f->x), pm_vec3_dot(v, f->y), pm_vec3_dot(v, f->z)};
}

/* Sine and cosine for |x| <= pi/4 by Taylor's series, whose first terms left out are below
 * 5e-17 and 6e-18: a third of the cost of the general functions, and the disc needs no more.
 * Terms are added in pairs (Estrin's scheme): one after the other each would wait for the last.
 */
static inline void pm_short_sincos(double x, double *sine, double *cosine)
{
    double q = x * x, q2 = q * q, q4 = q2 * q2;
    double s01 = 1. / 6 - q * (1. / 120), s23 = 1. / 5040 - q * (1. / 362880);
    double s45 = 1. / 39916800 - q * (1. / 6227020800);
    double s = (s01 + q2 * s23) + q4 * (s45 + q2 * (1. / 1307674368000));
    *sine = x - x * (q * s);
    double c01 = .5 - q * (1. / 24), c23 = 1. / 720 - q * (1. / 40320);
    double c45 = 1. / 3628800 - q * (1. / 479001600);
    double c67 = 1. / 87178291200 - q * (1. / 20922789888000);
    double c = (c01 + q2 * c23) + q4 * (c45 + q2 * c67);
    *cosine = 1 - q * c;
}

/* Uniform in the unit disc (z = 0), concentric (Shirley and Chiu 1997). */
static inline pm_vec3 pm_warp_disc(double u, double v)
{
    double a = 2 * u - 1, b = 2 * v - 1, sine, cosine;
    if (a == 0 && b == 0)
        return (pm_vec3){0, 0, 0};
    bool across = fabs(a) > fabs(b); /* a coin: selected from, as it cannot be foreseen */
    double major = across ? a : b, minor = across ? b : a;
    pm_short_sincos(PM_PI / 4 * (minor / major), &sine,
                    &cosine); /* of the angle to that axis */
    return (pm_vec3){major * (across ? cosine : sine), major * (across ? sine : cosine), 0};
}

/* The point of the unit square that pm_warp_disc maps to (x, y); each of its coordinates is in
 * [0, 1). Test: disc_and_cap_are_inverted. */
void pm_warp_disc_inverse(double x, double y, double *u, double *v);

/* Cosine-weighted about +z; pdf_solid_angle = z / pi. */
static inline pm_vec3 pm_warp_cosine(double u, double v)
{
    pm_vec3 d = pm_warp_disc(u, v);
    double z2 = 1 - d.x * d.x - d.y * d.y;
    d.z = sqrt(z2 > 0x1p-64 ? z2 : 0x1p-64); /* never in the plane: the pdf stays positive */
    return d;
}

/* Uniform on the unit sphere; pdf_solid_angle = 1 / (4 pi). */
pm_vec3 pm_warp_sphere(double u, double v);

/* Uniform in the cone about +z with 1 - cos(half angle) = `versine`, which keeps its precision
 * for the smallest angles; pdf_solid_angle = 1 / (2 pi versine). */
pm_vec3 pm_warp_cone(double u, double v, double versine);

/* The same by way of the concentric disc (Lambert's azimuthal equal-area projection), which
 * keeps neighbours neighbours; and its inverse for unit directions within the cone. */
pm_vec3 pm_warp_cap(double u, double v, double versine);
void pm_warp_cap_inverse(pm_vec3 direction, double versine, double *u, double *v);

/* 1 - cos of an angle in radians, without cancellation. */
double pm_versine(double angle);

#endif
