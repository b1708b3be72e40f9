#include "world/ward.h"

#include "base/maths.h"
#include "base/warp.h"

/* With h = wi + wo not normalised: |h|^2, (h n)^2 and the Gaussian of the slope of h. */
struct halfway {
    double square, square_along, gaussian;
};

static struct halfway halfway_of(pm_vec3 n, pm_vec3 wo, pm_vec3 wi, double alpha)
{
    pm_vec3 h = pm_vec3_add(wi, wo);
    double along = pm_vec3_dot(h, n);
    struct halfway out = {.square = pm_vec3_dot(h, h), .square_along = along * along};
    double tilt = (out.square - out.square_along) / out.square_along; /* tan^2 */
    out.gaussian = pm_exp(-tilt / (alpha * alpha)) / (PM_PI * alpha * alpha);
    return out;
}

double pm_ward_reflect(pm_vec3 n, pm_vec3 wo, pm_vec3 wi, double alpha)
{
    double cosine = pm_vec3_dot(n, wi);
    if (!(cosine > 0))
        return 0;
    struct halfway h = halfway_of(n, wo, wi, alpha);
    return cosine * h.gaussian * h.square / (h.square_along * h.square_along);
}

double pm_ward_reflect_pdf(pm_vec3 n, pm_vec3 wo, pm_vec3 wi, double alpha)
{
    if (!(pm_vec3_dot(n, wi) > 0))
        return 0;
    struct halfway h = halfway_of(n, wo, wi, alpha);
    return h.gaussian * h.square / (2 * h.square_along * sqrt(h.square_along));
}

bool pm_ward_reflect_sample(pm_vec3 n, pm_vec3 wo, double alpha, double u, double v,
                            pm_vec3 *wi)
{
    double slope = alpha * sqrt(-pm_log(1 - u)), sine, cosine;
    pm_sincos(2 * PM_PI * v, &sine, &cosine);
    pm_frame frame = pm_frame_make(n);
    pm_vec3 h = pm_frame_to_world(&frame, (pm_vec3){slope * cosine, slope * sine, 1});
    *wi = pm_vec3_normalize(pm_vec3_reflect(wo, pm_vec3_normalize(h)));
    return pm_vec3_dot(*wi, n) > 0;
}

/* The unbounded Gaussian of the chord; its integral over the sphere is 1 - exp(-4 / alpha^2).
 */
static double chord_gaussian(pm_vec3 wo, pm_vec3 wi, double alpha)
{
    pm_vec3 chord = pm_vec3_add(wi, wo); /* from the straight direction -wo */
    return pm_exp(-pm_vec3_dot(chord, chord) / (alpha * alpha)) / (PM_PI * alpha * alpha);
}

static double sphere_share(double alpha)
{
    return 1 - pm_exp(-4 / (alpha * alpha));
}

double pm_ward_transmit(pm_vec3 n, pm_vec3 wo, pm_vec3 wi, double alpha)
{
    double cosine = -pm_vec3_dot(n, wi), cosine_out = pm_vec3_dot(n, wo);
    if (!(cosine > 0))
        return 0;
    return chord_gaussian(wo, wi, alpha) * 2 * cosine / (cosine + cosine_out);
}

double pm_ward_transmit_pdf(pm_vec3 wo, pm_vec3 wi, double alpha)
{
    return chord_gaussian(wo, wi, alpha) / sphere_share(alpha);
}

bool pm_ward_transmit_sample(pm_vec3 n, pm_vec3 wo, double alpha, double u, double v,
                             pm_vec3 *wi)
{
    double versine = -alpha * alpha / 2 * pm_log(1 - u * sphere_share(alpha));
    double sine, cosine, radius = sqrt(versine * fmax(2 - versine, 0));
    pm_sincos(2 * PM_PI * v, &sine, &cosine);
    pm_frame frame = pm_frame_make(pm_vec3_negate(wo));
    pm_vec3 local = {radius * cosine, radius * sine, 1 - versine};
    *wi = pm_vec3_normalize(pm_frame_to_world(&frame, local));
    return pm_vec3_dot(*wi, n) < 0;
}
