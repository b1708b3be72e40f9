#include "world/lobe.h"

#include "base/maths.h"
#include "base/warp.h"
#include "world/fresnel.h"
#include "world/ward.h"

/* Whether the lobe scatters towards wi. A tilted normal must not let light through the surface:
 * wi lies on the same side of both. */
static bool reaches(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi, double cosine)
{
    if (!(lobe->sides & (cosine > 0 ? PM_SIDE_NEAR : PM_SIDE_FAR)))
        return false;
    return !lobe->tilted || (cosine > 0) == (pm_vec3_dot(surface->normal, wi) > 0);
}

/* ---- Lambertian ---- */

static double coat_share(const pm_lobe *lobe, double cosine)
{
    if (lobe->coat == PM_COAT_SMOOTH)
        return 1 - pm_fresnel_estimate(fabs(cosine));
    return lobe->coat == PM_COAT_SCHLICK ? 1 - pm_fresnel_schlick(fabs(cosine)) : 1;
}

static void sample_diffuse(const pm_lobe *lobe, double u, double v, pm_scatter *out)
{
    bool far = lobe->sides == PM_SIDE_FAR;
    pm_frame frame = pm_frame_make(far ? pm_vec3_negate(lobe->normal) : lobe->normal);
    pm_vec3 local = pm_warp_cosine(u, v);
    out->wi = pm_frame_to_world(&frame, local);
    out->weight = lobe->albedo;
    if (lobe->coat)
        out->weight = pm_rgb_scale(lobe->albedo, coat_share(lobe, local.z));
}

/* ---- rough ---- */

static pm_grain grain_of(const pm_lobe *lobe)
{
    return (pm_grain){lobe->normal, lobe->u.grain.u, lobe->u.grain.along, lobe->u.grain.across};
}

/* The rough transmission of ward.h is about -wo. */
static pm_vec3 behind(const pm_lobe *lobe)
{
    return pm_vec3_negate(lobe->u.rough.straight);
}

static double rough_shape(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    pm_grain grain;
    switch (lobe->kind) {
    case PM_LOBE_WARD:
        return pm_ward_reflect(lobe->normal, s->wo, wi, lobe->u.rough.alpha);
    case PM_LOBE_ROUGH:
        return pm_ward_transmit(lobe->normal, behind(lobe), wi, lobe->u.rough.alpha);
    case PM_LOBE_GRAIN_WARD:
        grain = grain_of(lobe);
        return pm_grain_ward(&grain, s->wo, wi);
    case PM_LOBE_GRAIN_ROUGH:
        grain = grain_of(lobe);
        return pm_grain_rough(&grain, lobe->u.grain.straight, wi);
    case PM_LOBE_GRAIN_PHONG:
        grain = grain_of(lobe);
        return pm_grain_phong(&grain, s->wo, wi);
    default:
        return 0;
    }
}

static double rough_pdf(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    pm_grain grain;
    switch (lobe->kind) {
    case PM_LOBE_WARD:
        return pm_ward_reflect_pdf(lobe->normal, s->wo, wi, lobe->u.rough.alpha);
    case PM_LOBE_ROUGH:
        return pm_ward_transmit_pdf(behind(lobe), wi, lobe->u.rough.alpha);
    case PM_LOBE_GRAIN_WARD:
        grain = grain_of(lobe);
        return pm_grain_ward_pdf(&grain, s->wo, wi);
    case PM_LOBE_GRAIN_ROUGH:
        grain = grain_of(lobe);
        return pm_grain_rough_pdf(&grain, lobe->u.grain.straight, wi);
    case PM_LOBE_GRAIN_PHONG:
        grain = grain_of(lobe);
        return pm_grain_phong_pdf(&grain, s->wo, wi);
    default:
        return 0;
    }
}

static pm_vec3 rough_direction(const pm_surface *s, const pm_lobe *lobe, double u, double v)
{
    pm_vec3 wi = {0, 0, 0};
    pm_grain grain;
    switch (lobe->kind) {
    case PM_LOBE_WARD:
        pm_ward_reflect_sample(lobe->normal, s->wo, lobe->u.rough.alpha, u, v, &wi);
        break;
    case PM_LOBE_ROUGH:
        pm_ward_transmit_sample(lobe->normal, behind(lobe), lobe->u.rough.alpha, u, v, &wi);
        break;
    case PM_LOBE_GRAIN_WARD:
        grain = grain_of(lobe);
        return pm_grain_ward_sample(&grain, s->wo, u, v);
    case PM_LOBE_GRAIN_ROUGH:
        grain = grain_of(lobe);
        return pm_grain_rough_sample(&grain, lobe->u.grain.straight, u, v);
    case PM_LOBE_GRAIN_PHONG:
        grain = grain_of(lobe);
        return pm_grain_phong_sample(&grain, s->wo, u, v);
    default:
        break;
    }
    return wi;
}

static void sample_rough(const pm_surface *s, const pm_lobe *lobe, double u, double v,
                         pm_scatter *out)
{
    out->wi = rough_direction(s, lobe, u, v);
    double pdf = rough_pdf(s, lobe, out->wi);
    double shape = pdf > 0 ? rough_shape(s, lobe, out->wi) / pdf : 0;
    out->weight = pm_rgb_scale(lobe->albedo, shape);
}

/* ---- functions ---- */

/* f(wi, wo), the lobe's colour and gain included. */
static pm_rgb function_value(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    pm_rgb f = pm_brdf_value(&s->functions[lobe->u.function.index], wi);
    return pm_rgb_mul(pm_rgb_mul(lobe->albedo, lobe->u.function.gain), f);
}

static double function_pdf(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    return pm_brdf_pdf(&s->functions[lobe->u.function.index], lobe->normal, s->wo,
                       lobe->u.function.front, lobe->sides == PM_SIDE_FAR, wi);
}

static void sample_function(const pm_surface *s, const pm_lobe *lobe, double u, double v,
                            pm_scatter *out)
{
    out->wi = pm_brdf_sample(&s->functions[lobe->u.function.index], lobe->normal, s->wo,
                             lobe->u.function.front, lobe->sides == PM_SIDE_FAR, u, v);
    double pdf = function_pdf(s, lobe, out->wi);
    double cosine = fabs(pm_vec3_dot(lobe->normal, out->wi));
    out->weight = pm_rgb_scale(function_value(s, lobe, out->wi), pdf > 0 ? cosine / pdf : 0);
}

/* ---- tables ---- */

static pm_rgb table_value(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    return pm_rgb_mul(lobe->u.table.gain,
                      pm_bsdf_hit_value(&s->bsdfs[lobe->u.table.index], wi));
}

static void sample_table(const pm_surface *s, const pm_lobe *lobe, double u, double v,
                         pm_scatter *out)
{
    const pm_bsdf_hit *hit = &s->bsdfs[lobe->u.table.index];
    out->wi = pm_vec3_negate(s->wo);
    out->weight = pm_rgb_grey(0);
    if (!pm_bsdf_hit_sample(hit, lobe->sides == PM_SIDE_FAR, u, v, &out->wi))
        return;
    double pdf = pm_bsdf_hit_pdf(hit, out->wi);
    double cosine = fabs(pm_vec3_dot(lobe->normal, out->wi));
    if (pdf > 0)
        out->weight = pm_rgb_scale(table_value(s, lobe, out->wi), cosine / pdf);
}

/* ---- any lobe ---- */

pm_vec3 pm_lobe_direction(const pm_surface *surface, const pm_lobe *lobe)
{
    if (lobe->kind == PM_LOBE_DIRECTION)
        return lobe->u.direction.wi;
    pm_vec3 wi = pm_vec3_reflect(surface->wo, lobe->normal);
    if (lobe->tilted && !(pm_vec3_dot(wi, surface->normal) > 0))
        wi = pm_vec3_reflect(surface->wo, surface->normal);
    return pm_vec3_normalize(wi);
}

pm_rgb pm_lobe_value(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(lobe->normal, wi);
    if (pm_lobe_is_delta(lobe) || !reaches(surface, lobe, wi, cosine))
        return pm_rgb_grey(0);
    if (lobe->kind == PM_LOBE_DIFFUSE)
        return pm_rgb_scale(lobe->albedo, coat_share(lobe, cosine) * fabs(cosine) / PM_PI);
    if (lobe->kind == PM_LOBE_FUNCTION)
        return pm_rgb_scale(function_value(surface, lobe, wi), fabs(cosine));
    if (lobe->kind == PM_LOBE_TABLE)
        return pm_rgb_scale(table_value(surface, lobe, wi), fabs(cosine));
    return pm_rgb_scale(lobe->albedo, rough_shape(surface, lobe, wi));
}

/* |cos wi| about the lobe's normal / about the surface's. */
static double tilt(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi, double cosine)
{
    if (!lobe->tilted)
        return 1;
    double own = fabs(pm_vec3_dot(surface->normal, wi));
    return fabs(cosine) < PM_TILT_MAX * own ? fabs(cosine) / own : PM_TILT_MAX;
}

pm_rgb pm_lobe_photon_weight(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(lobe->normal, wi);
    if (!reaches(surface, lobe, wi, cosine))
        return pm_rgb_grey(0);
    double scale = tilt(surface, lobe, wi, cosine);
    if (lobe->kind == PM_LOBE_FUNCTION)
        return pm_rgb_scale(function_value(surface, lobe, wi), scale);
    return pm_rgb_scale(lobe->albedo, coat_share(lobe, cosine) * scale / PM_PI);
}

double pm_lobe_pdf(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(lobe->normal, wi);
    if (!reaches(surface, lobe, wi, cosine))
        return 0;
    if (lobe->kind == PM_LOBE_DIFFUSE)
        return fabs(cosine) / PM_PI;
    if (lobe->kind == PM_LOBE_FUNCTION)
        return function_pdf(surface, lobe, wi);
    if (lobe->kind == PM_LOBE_TABLE)
        return pm_bsdf_hit_pdf(&surface->bsdfs[lobe->u.table.index], wi);
    return rough_pdf(surface, lobe, wi);
}

void pm_lobe_sample(const pm_surface *surface, const pm_lobe *lobe, double u, double v,
                    pm_scatter *out)
{
    out->event = lobe->event;
    if (pm_lobe_is_delta(lobe)) {
        out->wi = pm_lobe_direction(surface, lobe);
        out->weight = lobe->albedo;
        if (lobe->kind == PM_LOBE_DIRECTION)
            out->radiance_scale = lobe->u.direction.radiance_scale;
        out->transmitted = lobe->sides == PM_SIDE_FAR;
        return;
    }
    if (lobe->kind == PM_LOBE_DIFFUSE)
        sample_diffuse(lobe, u, v, out);
    else if (lobe->kind == PM_LOBE_FUNCTION)
        sample_function(surface, lobe, u, v, out);
    else if (lobe->kind == PM_LOBE_TABLE)
        sample_table(surface, lobe, u, v, out);
    else
        sample_rough(surface, lobe, u, v, out);
    double cosine = pm_vec3_dot(lobe->normal, out->wi);
    out->transmitted = !(cosine > 0);
    if (!reaches(surface, lobe, out->wi, cosine))
        out->event = PM_EVENT_NONE;
}
