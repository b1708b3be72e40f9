#include "world/lobe.h"

#include "base/maths.h"
#include "base/warp.h"
#include "world/fresnel.h"
#include "world/ward.h"

pm_lobe *pm_lobe_add(pm_surface *surface, pm_lobe_kind kind, pm_event event, unsigned sides,
                     pm_rgb albedo)
{
    if (pm_rgb_is_black(albedo) || surface->count == PM_LOBES_MAX)
        return NULL;
    pm_lobe *lobe = &surface->lobes[surface->count++];
    surface->events |= 1U << event;
    lobe->kind = kind;
    lobe->event = event;
    lobe->sides = sides & 3;
    lobe->coated = lobe->tilted = false;
    lobe->albedo = albedo;
    lobe->normal = surface->normal;
    return lobe;
}

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
    return lobe->coated ? 1 - pm_fresnel_estimate(fabs(cosine)) : 1;
}

static void sample_diffuse(const pm_lobe *lobe, double u, double v, pm_scatter *out)
{
    bool far = lobe->sides == PM_SIDE_FAR;
    pm_frame frame = pm_frame_make(far ? pm_vec3_negate(lobe->normal) : lobe->normal);
    pm_vec3 local = pm_warp_cosine(u, v);
    out->wi = pm_frame_to_world(&frame, local);
    out->weight = lobe->albedo;
    if (lobe->coated)
        out->weight = pm_rgb_scale(lobe->albedo, coat_share(lobe, local.z));
}

/* ---- rough ---- */

static double rough_shape(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    if (lobe->kind == PM_LOBE_WARD)
        return pm_ward_reflect(lobe->normal, s->wo, wi, lobe->u.rough.alpha);
    return pm_ward_transmit(lobe->normal, s->wo, wi, lobe->u.rough.alpha);
}

static double rough_pdf(const pm_surface *s, const pm_lobe *lobe, pm_vec3 wi)
{
    if (lobe->kind == PM_LOBE_WARD)
        return pm_ward_reflect_pdf(lobe->normal, s->wo, wi, lobe->u.rough.alpha);
    return pm_ward_transmit_pdf(s->wo, wi, lobe->u.rough.alpha);
}

static void sample_rough(const pm_surface *s, const pm_lobe *lobe, double u, double v,
                         pm_scatter *out)
{
    double alpha = lobe->u.rough.alpha;
    if (lobe->kind == PM_LOBE_WARD)
        pm_ward_reflect_sample(lobe->normal, s->wo, alpha, u, v, &out->wi);
    else
        pm_ward_transmit_sample(lobe->normal, s->wo, alpha, u, v, &out->wi);
    double pdf = rough_pdf(s, lobe, out->wi);
    double shape = pdf > 0 ? rough_shape(s, lobe, out->wi) / pdf : 0;
    out->weight = pm_rgb_scale(lobe->albedo, shape);
}

/* ---- any lobe ---- */

pm_rgb pm_lobe_value(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi)
{
    double shape = 0, cosine = pm_vec3_dot(lobe->normal, wi);
    if (!reaches(surface, lobe, wi, cosine))
        return pm_rgb_grey(0);
    switch (lobe->kind) {
    case PM_LOBE_DIFFUSE:
        shape = coat_share(lobe, cosine) * fabs(cosine) / PM_PI;
        break;
    case PM_LOBE_WARD:
    case PM_LOBE_ROUGH:
        shape = rough_shape(surface, lobe, wi);
        break;
    default:
        break;
    }
    return pm_rgb_scale(lobe->albedo, shape);
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
    return pm_rgb_scale(lobe->albedo,
                        coat_share(lobe, cosine) * tilt(surface, lobe, wi, cosine) / PM_PI);
}

double pm_lobe_pdf(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(lobe->normal, wi);
    if (!reaches(surface, lobe, wi, cosine))
        return 0;
    switch (lobe->kind) {
    case PM_LOBE_DIFFUSE:
        return fabs(cosine) / PM_PI;
    case PM_LOBE_WARD:
    case PM_LOBE_ROUGH:
        return rough_pdf(surface, lobe, wi);
    default:
        return 0;
    }
}

void pm_lobe_sample(const pm_surface *surface, const pm_lobe *lobe, double u, double v,
                    pm_scatter *out)
{
    out->event = lobe->event;
    if (lobe->kind == PM_LOBE_DIRECTION) {
        out->wi = lobe->u.direction.wi;
        out->weight = lobe->albedo;
        out->radiance_scale = lobe->u.direction.radiance_scale;
        out->transmitted = lobe->sides == PM_SIDE_FAR;
        return;
    }
    if (lobe->kind == PM_LOBE_DIFFUSE)
        sample_diffuse(lobe, u, v, out);
    else
        sample_rough(surface, lobe, u, v, out);
    double cosine = pm_vec3_dot(lobe->normal, out->wi);
    out->transmitted = !(cosine > 0);
    if (!reaches(surface, lobe, out->wi, cosine) || pm_rgb_is_black(out->weight))
        out->event = PM_EVENT_NONE;
}
