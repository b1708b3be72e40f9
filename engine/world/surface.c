#include "world/surface.h"

#include "base/maths.h"
#include "base/warp.h"
#include "world/fresnel.h"
#include "world/light.h"
#include "world/material.h"
#include "world/ward.h"

/* ---- materials ---- */

/* plastic, metal, trans, after Radiance's normal.c. Both sides are alike. */
static void shade_plastic(const struct pm_material *m, double cosine, pm_surface *out)
{
    bool smooth = !(m->roughness > 0);
    double rise = 0;
    out->roughness = m->roughness;
    out->fresnel = smooth && m->specularity >= PM_FRESNEL_THRESHOLD;
    if (out->fresnel)
        rise = pm_fresnel_estimate(cosine);
    double specular = m->specularity + rise * (1 - m->specularity);
    double rest = 1 - specular, straight = rest * m->transmission * m->straight_fraction;
    out->specular_reflectance = pm_rgb_grey(specular);
    if (m->type == PM_METAL)
        out->specular_reflectance =
            pm_rgb_madd(pm_rgb_grey(rise), m->specularity * (1 - rise), m->color);
    /* products, so that what the arguments leave nothing for is exactly black */
    out->diffuse_reflectance = pm_rgb_scale(m->color, rest * (1 - m->transmission));
    out->diffuse_transmittance =
        pm_rgb_scale(m->color, rest * m->transmission * (1 - m->straight_fraction));
    if (smooth)
        out->straight_transmittance = pm_rgb_scale(m->color, straight);
    else
        out->specular_transmittance = pm_rgb_scale(m->color, straight);
}

/* glass: a thin pane; both sides are alike (Radiance's glass.c). */
static void shade_glass(const struct pm_material *m, double cosine, pm_surface *out)
{
    pm_pane pane = pm_pane_at(cosine, m->index);
    out->specular_reflectance =
        (pm_rgb){pm_pane_reflectance(&pane, m->color.r), pm_pane_reflectance(&pane, m->color.g),
                 pm_pane_reflectance(&pane, m->color.b)};
    out->straight_transmittance = (pm_rgb){pm_pane_transmittance(&pane, m->color.r),
                                           pm_pane_transmittance(&pane, m->color.g),
                                           pm_pane_transmittance(&pane, m->color.b)};
}

/* dielectric: index 1 in front, m->index behind (Radiance's dielectric.c). */
static void shade_dielectric(const struct pm_material *m, double cosine, bool front,
                             pm_surface *out)
{
    double ratio = front ? 1 / m->index : m->index, refracted;
    double reflectance = pm_fresnel_dielectric(cosine, ratio, &refracted);
    out->specular_reflectance = pm_rgb_grey(reflectance);
    out->specular_transmittance = pm_rgb_grey(1 - reflectance);
    out->radiance_scale = ratio * ratio;
    /* Snell: the tangential part shrinks by the ratio of the indices */
    pm_vec3 tangential = pm_vec3_madd(out->wo, -cosine, out->normal);
    pm_vec3 wi = pm_vec3_madd(pm_vec3_scale(tangential, -ratio), -refracted, out->normal);
    out->refracted_wi = pm_vec3_normalize(wi);
}

static void shade(const struct pm_material *m, bool front, double cosine, pm_surface *out)
{
    switch (m->type) {
    case PM_PLASTIC:
    case PM_METAL:
    case PM_TRANS:
        shade_plastic(m, cosine, out);
        break;
    case PM_GLASS:
        shade_glass(m, cosine, out);
        break;
    case PM_DIELECTRIC:
        shade_dielectric(m, cosine, front, out);
        break;
    case PM_MIRROR: /* the back is black (Radiance's m_mirror.c) */
        if (front)
            out->specular_reflectance = m->color;
        break;
    case PM_MIST:
        out->straight_transmittance = pm_rgb_grey(1);
        break;
    default: /* lamps are black from both sides (Radiance's m_light in source.c) */
        break;
    }
}

static void surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                       const pm_media *media, bool seen, pm_surface *out)
{
    struct pm_shown shown = pm_material_shown(world, hit, wo, media, seen);
    double cosine = pm_vec3_dot(wo, hit->normal);
    bool front = cosine >= 0;
    *out = (pm_surface){.normal = front ? hit->normal : pm_vec3_negate(hit->normal),
                        .wo = wo,
                        .refracted_wi = pm_vec3_negate(wo),
                        .radiance_scale = 1};
    if (shown.material)
        shade(shown.material, front != shown.flipped, fmin(fabs(cosine), 1), out);
    else
        out->straight_transmittance = pm_rgb_grey(1);
}

void pm_surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo, const pm_media *media,
                   pm_surface *out)
{
    surface_at(world, hit, wo, media, false, out);
}

void pm_surface_seen_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                        const pm_media *media, pm_surface *out)
{
    surface_at(world, hit, wo, media, true, out);
}

pm_rgb pm_material_straight(const pm_world *world, const pm_hit *hit, pm_vec3 direction,
                            const pm_media *media, bool weak)
{
    pm_vec3 wo = pm_vec3_negate(direction);
    if (!media->count && !world->materials[hit->material].straight)
        return pm_rgb_grey(0);
    if (weak && pm_light_stands_in(world, hit, wo))
        return pm_rgb_grey(0);
    pm_surface surface;
    surface_at(world, hit, wo, media, false, &surface);
    return surface.straight_transmittance;
}

bool pm_surface_is_diffuse(const pm_surface *surface)
{
    return !pm_rgb_is_black(surface->diffuse_reflectance) ||
           !pm_rgb_is_black(surface->diffuse_transmittance);
}

/* ---- finite lobes ---- */

pm_rgb pm_surface_diffuse(const pm_surface *surface, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(surface->normal, wi);
    pm_rgb albedo = cosine > 0 ? surface->diffuse_reflectance : surface->diffuse_transmittance;
    cosine = fabs(cosine);
    double share = surface->fresnel ? 1 - pm_fresnel_estimate(cosine) : 1;
    return pm_rgb_scale(albedo, share * cosine / PM_PI);
}

pm_rgb pm_surface_glossy(const pm_surface *surface, pm_vec3 wi)
{
    if (!(surface->roughness > 0))
        return pm_rgb_grey(0);
    if (pm_vec3_dot(surface->normal, wi) > 0)
        return pm_rgb_scale(
            surface->specular_reflectance,
            pm_ward_reflect(surface->normal, surface->wo, wi, surface->roughness));
    return pm_rgb_scale(surface->specular_transmittance,
                        pm_ward_transmit(surface->normal, surface->wo, wi, surface->roughness));
}

/* ---- sampling ---- */

enum lobe_index {
    DIFFUSE_REFLECTION,
    DIFFUSE_TRANSMISSION,
    SPECULAR_REFLECTION,
    SPECULAR_TRANSMISSION,
    STRAIGHT,
    LOBES,
};

/* Probability of each lobe, in proportion to its mean albedo weighted by the throughput. */
struct choice {
    double of[LOBES];
};

static bool choose(const pm_surface *s, pm_rgb throughput, bool with_diffuse,
                   struct choice *out)
{
    const pm_rgb *albedos[LOBES] = {&s->diffuse_reflectance, &s->diffuse_transmittance,
                                    &s->specular_reflectance, &s->specular_transmittance,
                                    &s->straight_transmittance};
    double total = 0;
    for (int i = 0; i < LOBES; i++) {
        bool taken = with_diffuse || i >= SPECULAR_REFLECTION;
        out->of[i] = taken ? pm_rgb_mean(pm_rgb_mul(throughput, *albedos[i])) : 0;
        total += out->of[i];
    }
    if (!(total > 0))
        return false;
    for (int i = 0; i < LOBES; i++)
        out->of[i] /= total;
    return true;
}

static enum lobe_index pick(const struct choice *choice, double u)
{
    int last = 0;
    for (int i = 0; i < LOBES; i++) {
        if (!(choice->of[i] > 0))
            continue;
        last = i;
        if (u < choice->of[i])
            break;
        u -= choice->of[i];
    }
    return (enum lobe_index)last; /* rounding may leave u beyond the last */
}

/* Density of wi among the finite lobes together. */
static double density(const pm_surface *s, const struct choice *choice, pm_vec3 wi)
{
    double cosine = pm_vec3_dot(s->normal, wi);
    bool above = cosine > 0;
    double sum =
        choice->of[above ? DIFFUSE_REFLECTION : DIFFUSE_TRANSMISSION] * fabs(cosine) / PM_PI;
    if (!(s->roughness > 0))
        return sum;
    if (above)
        return sum + choice->of[SPECULAR_REFLECTION] *
                         pm_ward_reflect_pdf(s->normal, s->wo, wi, s->roughness);
    return sum +
           choice->of[SPECULAR_TRANSMISSION] * pm_ward_transmit_pdf(s->wo, wi, s->roughness);
}

static void sample_diffuse(const pm_surface *s, const double u[3], pm_scatter *out)
{
    pm_frame frame = pm_frame_make(out->transmitted ? pm_vec3_negate(s->normal) : s->normal);
    pm_vec3 local = pm_warp_cosine(u[1], u[2]);
    out->lobe = PM_LOBE_DIFFUSE;
    out->wi = pm_frame_to_world(&frame, local);
    out->weight = pm_rgb_scale(pm_surface_diffuse(s, out->wi),
                               PM_PI / fabs(pm_vec3_dot(s->normal, out->wi)));
}

static void sample_glossy(const pm_surface *s, const double u[3], pm_scatter *out)
{
    out->lobe = PM_LOBE_GLOSSY;
    double alpha = s->roughness, pdf;
    bool right;
    if (out->transmitted) {
        right = pm_ward_transmit_sample(s->normal, s->wo, alpha, u[1], u[2], &out->wi);
        pdf = pm_ward_transmit_pdf(s->wo, out->wi, alpha);
    } else {
        right = pm_ward_reflect_sample(s->normal, s->wo, alpha, u[1], u[2], &out->wi);
        pdf = pm_ward_reflect_pdf(s->normal, s->wo, out->wi, alpha);
    }
    if (!right || !(pdf > 0))
        out->lobe = PM_LOBE_NONE;
    else
        out->weight = pm_rgb_scale(pm_surface_glossy(s, out->wi), 1 / pdf);
}

static void sample_specular(const pm_surface *s, pm_scatter *out)
{
    out->lobe = PM_LOBE_SPECULAR;
    if (out->transmitted) {
        out->wi = s->refracted_wi;
        out->weight = s->specular_transmittance;
        out->radiance_scale = s->radiance_scale;
    } else {
        out->wi = pm_vec3_normalize(pm_vec3_reflect(s->wo, s->normal));
        out->weight = s->specular_reflectance;
    }
}

static void sample_lobe(const pm_surface *s, enum lobe_index lobe, const double u[3],
                        pm_scatter *out)
{
    out->transmitted = lobe != DIFFUSE_REFLECTION && lobe != SPECULAR_REFLECTION;
    if (lobe == STRAIGHT) {
        out->lobe = PM_LOBE_STRAIGHT;
        out->wi = pm_vec3_negate(s->wo);
        out->weight = s->straight_transmittance;
    } else if (lobe == DIFFUSE_REFLECTION || lobe == DIFFUSE_TRANSMISSION) {
        sample_diffuse(s, u, out);
    } else if (s->roughness > 0) {
        sample_glossy(s, u, out);
    } else {
        sample_specular(s, out);
    }
}

static void sample(const pm_surface *s, pm_rgb throughput, bool with_diffuse, const double u[3],
                   pm_scatter *out)
{
    *out = (pm_scatter){.lobe = PM_LOBE_NONE, .radiance_scale = 1};
    struct choice choice;
    if (!choose(s, throughput, with_diffuse, &choice))
        return;
    enum lobe_index lobe = pick(&choice, u[0]);
    sample_lobe(s, lobe, u, out);
    if (out->lobe == PM_LOBE_NONE)
        return;
    out->weight = pm_rgb_scale(out->weight, 1 / choice.of[lobe]);
    if (out->lobe == PM_LOBE_DIFFUSE || out->lobe == PM_LOBE_GLOSSY)
        out->pdf = density(s, &choice, out->wi);
}

void pm_surface_sample(const pm_surface *surface, pm_rgb throughput, const double u[3],
                       pm_scatter *out)
{
    sample(surface, throughput, true, u, out);
}

void pm_surface_sample_specular(const pm_surface *surface, pm_rgb throughput, const double u[3],
                                pm_scatter *out)
{
    sample(surface, throughput, false, u, out);
}

double pm_surface_glossy_pdf(const pm_surface *surface, pm_rgb throughput, pm_vec3 wi)
{
    struct choice choice;
    if (!(surface->roughness > 0) || !choose(surface, throughput, false, &choice))
        return 0;
    return density(surface, &choice, wi);
}
