#include "world/aniso.h"

#include "base/maths.h"

static double square(double x)
{
    return x * x;
}

static pm_vec3 across(const pm_grain *g)
{
    return pm_vec3_cross(g->n, g->u);
}

static pm_vec3 combine(pm_vec3 x, double a, pm_vec3 y, double b, pm_vec3 z, double c)
{
    return pm_vec3_madd(pm_vec3_madd(pm_vec3_scale(x, a), b, y), c, z);
}

/* A point of the unit circle stretched by `along` and `across`, and its length: what makes
 * Gaussians with elliptical contours. */
static void ellipse(const pm_grain *g, double turn, double *x, double *y)
{
    pm_sincos(2 * PM_PI * turn, y, x);
    *x *= g->along;
    *y *= g->across;
}

/* ---- Ward ---- */

/* With h = wi + wo not normalised: |h|^2, (h n)^2 and the Gaussian of the slopes of h. */
struct halfway {
    double square, square_along, gaussian;
};

static struct halfway halfway_of(const pm_grain *g, pm_vec3 wo, pm_vec3 wi)
{
    pm_vec3 h = pm_vec3_add(wi, wo);
    struct halfway out = {pm_vec3_dot(h, h), square(pm_vec3_dot(h, g->n)), 0};
    double x = pm_vec3_dot(h, g->u) / g->along, y = pm_vec3_dot(h, across(g)) / g->across;
    out.gaussian = pm_exp(-(x * x + y * y) / out.square_along) / (PM_PI * g->along * g->across);
    return out;
}

double pm_grain_ward(const pm_grain *g, pm_vec3 wo, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(g->n, wi);
    if (!(cosine > 0))
        return 0;
    struct halfway h = halfway_of(g, wo, wi);
    return cosine * h.gaussian * h.square / square(h.square_along);
}

double pm_grain_ward_pdf(const pm_grain *g, pm_vec3 wo, pm_vec3 wi)
{
    if (!(pm_vec3_dot(g->n, wi) > 0))
        return 0;
    struct halfway h = halfway_of(g, wo, wi);
    return h.gaussian * h.square / (2 * h.square_along * sqrt(h.square_along));
}

pm_vec3 pm_grain_ward_sample(const pm_grain *g, pm_vec3 wo, double u, double v)
{
    double slope = sqrt(-pm_log(1 - u)), x, y;
    ellipse(g, v, &x, &y);
    pm_vec3 h = combine(g->n, 1, g->u, slope * x, across(g), slope * y);
    return pm_vec3_normalize(pm_vec3_reflect(wo, pm_vec3_normalize(h)));
}

/* ---- rough transmission ---- */

/* Two unit vectors across the straight direction, the first in its plane with u. */
static void axes(const pm_grain *g, pm_vec3 straight, pm_vec3 *x, pm_vec3 *y)
{
    pm_vec3 other = pm_vec3_cross(straight, g->u);
    if (!(pm_vec3_dot(other, other) > 1e-20)) /* straight along u: any will do */
        other = across(g);
    *y = pm_vec3_normalize(other);
    *x = pm_vec3_cross(*y, straight);
}

/* Of the squared chord: 1 / width^2 in the plane of the chord. */
static double narrowness(const pm_grain *g, pm_vec3 straight, pm_vec3 chord, double *length2)
{
    pm_vec3 x, y;
    axes(g, straight, &x, &y);
    double a = square(pm_vec3_dot(chord, x)), b = square(pm_vec3_dot(chord, y));
    *length2 = pm_vec3_dot(chord, chord);
    if (!(a + b > 0))
        return 1 / (g->along * g->across);
    return (a / square(g->along) + b / square(g->across)) / (a + b);
}

double pm_grain_rough(const pm_grain *g, pm_vec3 straight, pm_vec3 wi)
{
    double cosine = -pm_vec3_dot(g->n, wi), cosine_out = -pm_vec3_dot(g->n, straight), length2;
    if (!(cosine > 0) || !(cosine_out > 0))
        return 0;
    double narrow = narrowness(g, straight, pm_vec3_sub(wi, straight), &length2);
    return pm_exp(-length2 * narrow) / (PM_PI * g->along * g->across) * 2 * cosine /
           (cosine + cosine_out);
}

double pm_grain_rough_pdf(const pm_grain *g, pm_vec3 straight, pm_vec3 wi)
{
    double length2, narrow = narrowness(g, straight, pm_vec3_sub(wi, straight), &length2);
    return pm_exp(-length2 * narrow) /
           (PM_PI * g->along * g->across * (1 - pm_exp(-4 * narrow)));
}

pm_vec3 pm_grain_rough_sample(const pm_grain *g, pm_vec3 straight, double u, double v)
{
    pm_vec3 side, other;
    double x, y;
    ellipse(g, v, &x, &y);
    axes(g, straight, &side, &other);
    double width2 = x * x + y * y;
    double versine = -width2 / 2 * pm_log(1 - u * (1 - pm_exp(-4 / width2)));
    double sine = sqrt(versine * fmax(2 - versine, 0)), width = sqrt(width2);
    return pm_vec3_normalize(
        combine(straight, 1 - versine, side, sine * x / width, other, sine * y / width));
}

/* ---- Ashikhmin and Shirley ---- */

/* Density of the unit halfway vector [1/sr]. */
static double phong_halfway(const pm_grain *g, pm_vec3 h)
{
    double cosine = fmin(pm_vec3_dot(h, g->n), 1), rest = 1 - cosine * cosine;
    if (!(cosine > 0))
        return 0;
    double scale = sqrt((g->along + 1) * (g->across + 1)) / (2 * PM_PI);
    double exponent =
        g->along * square(pm_vec3_dot(h, g->u)) + g->across * square(pm_vec3_dot(h, across(g)));
    return rest > 0 ? scale * pm_pow(cosine, exponent / rest) : scale;
}

double pm_grain_phong_pdf(const pm_grain *g, pm_vec3 wo, pm_vec3 wi)
{
    pm_vec3 h = pm_vec3_normalize(pm_vec3_add(wi, wo));
    double towards = pm_vec3_dot(h, wi);
    if (!(pm_vec3_dot(g->n, wi) > 0) || !(towards > 0))
        return 0;
    return phong_halfway(g, h) / (4 * towards);
}

double pm_grain_phong(const pm_grain *g, pm_vec3 wo, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(g->n, wi), cosine_out = pm_vec3_dot(g->n, wo);
    if (!(cosine > 0) || !(cosine_out > 0))
        return 0;
    return pm_grain_phong_pdf(g, wo, wi) * cosine / fmax(cosine, cosine_out);
}

pm_vec3 pm_grain_phong_sample(const pm_grain *g, pm_vec3 wo, double u, double v)
{
    double x, y;
    pm_sincos(2 * PM_PI * v, &y, &x);
    x *= sqrt(g->across + 1); /* eq. 9, for all quadrants at once */
    y *= sqrt(g->along + 1);
    double length2 = x * x + y * y;
    x /= sqrt(length2);
    y /= sqrt(length2);
    double exponent = g->along * x * x + g->across * y * y + 1;
    double cosine = u > 0 ? pm_pow(1 - u, 1 / exponent) : 1;
    double sine = sqrt(fmax(1 - cosine * cosine, 0));
    pm_vec3 h = combine(g->n, cosine, g->u, sine * x, across(g), sine * y);
    return pm_vec3_normalize(pm_vec3_reflect(wo, h));
}
