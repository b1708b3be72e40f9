/* What lobes each material has. */
#include "base/maths.h"
#include "world/fresnel.h"
#include "world/light.h"
#include "world/lobe.h"
#include "world/material.h"

/* One hit on its way to a list of lobes. */
struct shade {
    const struct pm_material *material;
    double cosine; /* between wo and the normal, 0 .. 1 */
    bool front;
    pm_surface *out;
};

/* ---- lobes ---- */

static void add_diffuse(struct shade *s, unsigned side, pm_rgb albedo, bool coated)
{
    pm_lobe *lobe = pm_lobe_add(s->out, PM_LOBE_DIFFUSE, PM_EVENT_DIFFUSE, side, albedo);
    if (lobe)
        lobe->coated = coated;
}

static void add_direction(struct shade *s, pm_event event, unsigned side, pm_rgb albedo,
                          pm_vec3 wi)
{
    pm_lobe *lobe = pm_lobe_add(s->out, PM_LOBE_DIRECTION, event, side, albedo);
    if (!lobe)
        return;
    lobe->u.direction.wi = wi;
    lobe->u.direction.radiance_scale = 1;
}

static void add_mirror(struct shade *s, pm_rgb albedo)
{
    pm_vec3 wi = pm_vec3_normalize(pm_vec3_reflect(s->out->wo, s->out->normal));
    add_direction(s, PM_EVENT_SPECULAR, PM_SIDE_NEAR, albedo, wi);
}

static void add_straight(struct shade *s, pm_rgb albedo)
{
    add_direction(s, PM_EVENT_STRAIGHT, PM_SIDE_FAR, albedo, pm_vec3_negate(s->out->wo));
}

static void add_rough(struct shade *s, pm_lobe_kind kind, unsigned side, pm_rgb albedo)
{
    pm_lobe *lobe = pm_lobe_add(s->out, kind, PM_EVENT_GLOSSY, side, albedo);
    if (!lobe)
        return;
    lobe->u.rough.alpha = s->material->roughness;
    lobe->u.rough.straight = pm_vec3_negate(s->out->wo);
}

/* ---- materials ---- */

/* plastic, metal, trans, after Radiance's normal.c. Both sides are alike. */
static void shade_plastic(struct shade *s)
{
    const struct pm_material *m = s->material;
    bool smooth = !(m->roughness > 0);
    bool coated = smooth && m->specularity >= PM_FRESNEL_THRESHOLD;
    double rise = coated ? pm_fresnel_estimate(s->cosine) : 0;
    double specular = m->specularity + rise * (1 - m->specularity);
    double rest = 1 - specular, straight = rest * m->transmission * m->straight_fraction;
    pm_rgb reflectance = pm_rgb_grey(specular);
    if (m->type == PM_METAL)
        reflectance = pm_rgb_madd(pm_rgb_grey(rise), m->specularity * (1 - rise), m->color);
    /* products, so that what the arguments leave nothing for is exactly black */
    add_diffuse(s, PM_SIDE_NEAR, pm_rgb_scale(m->color, rest * (1 - m->transmission)), coated);
    add_diffuse(s, PM_SIDE_FAR,
                pm_rgb_scale(m->color, rest * m->transmission * (1 - m->straight_fraction)),
                coated);
    if (smooth) {
        add_mirror(s, reflectance);
        add_straight(s, pm_rgb_scale(m->color, straight));
    } else {
        add_rough(s, PM_LOBE_WARD, PM_SIDE_NEAR, reflectance);
        add_rough(s, PM_LOBE_ROUGH, PM_SIDE_FAR, pm_rgb_scale(m->color, straight));
    }
}

/* glass: a thin pane; both sides are alike (Radiance's glass.c). */
static void shade_glass(struct shade *s)
{
    const struct pm_material *m = s->material;
    pm_pane pane = pm_pane_at(s->cosine, m->index);
    add_mirror(s, (pm_rgb){pm_pane_reflectance(&pane, m->color.r),
                           pm_pane_reflectance(&pane, m->color.g),
                           pm_pane_reflectance(&pane, m->color.b)});
    add_straight(s, (pm_rgb){pm_pane_transmittance(&pane, m->color.r),
                             pm_pane_transmittance(&pane, m->color.g),
                             pm_pane_transmittance(&pane, m->color.b)});
}

/* dielectric: index 1 in front, m->index behind (Radiance's dielectric.c). */
static void shade_dielectric(struct shade *s)
{
    double index = s->material->index, ratio = s->front ? 1 / index : index, refracted;
    double reflectance = pm_fresnel_dielectric(s->cosine, ratio, &refracted);
    add_mirror(s, pm_rgb_grey(reflectance));
    pm_lobe *lobe = pm_lobe_add(s->out, PM_LOBE_DIRECTION, PM_EVENT_SPECULAR, PM_SIDE_FAR,
                                pm_rgb_grey(1 - reflectance));
    if (!lobe)
        return;
    /* Snell: the tangential part shrinks by the ratio of the indices */
    pm_vec3 normal = s->out->normal;
    pm_vec3 tangential = pm_vec3_madd(s->out->wo, -s->cosine, normal);
    pm_vec3 wi = pm_vec3_madd(pm_vec3_scale(tangential, -ratio), -refracted, normal);
    lobe->u.direction.wi = pm_vec3_normalize(wi);
    lobe->u.direction.radiance_scale = ratio * ratio;
}

static void shade(struct shade *s)
{
    switch (s->material->type) {
    case PM_PLASTIC:
    case PM_METAL:
    case PM_TRANS:
        shade_plastic(s);
        break;
    case PM_GLASS:
        shade_glass(s);
        break;
    case PM_DIELECTRIC:
        shade_dielectric(s);
        break;
    case PM_MIRROR: /* the back is black (Radiance's m_mirror.c) */
        if (s->front)
            add_mirror(s, s->material->color);
        break;
    case PM_MIST:
        add_straight(s, pm_rgb_grey(1));
        break;
    default: /* lamps are black from both sides (Radiance's m_light in source.c) */
        break;
    }
}

/* ---- hits ---- */

static void surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                       const pm_media *media, bool seen, pm_surface *out)
{
    struct pm_shown shown = pm_material_shown(world, hit, wo, media, seen);
    double cosine = pm_vec3_dot(wo, hit->normal);
    bool front = cosine >= 0;
    out->normal = front ? hit->normal : pm_vec3_negate(hit->normal);
    out->wo = wo;
    out->count = 0;
    out->events = 0;
    struct shade s = {.material = shown.material,
                      .cosine = fmin(fabs(cosine), 1),
                      .front = front != shown.flipped,
                      .out = out};
    if (shown.material)
        shade(&s);
    else
        add_straight(&s, pm_rgb_grey(1));
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

void pm_surface_receiver(pm_vec3 normal, pm_surface *out)
{
    out->normal = out->wo = normal;
    out->count = 0;
    out->events = 0;
    pm_lobe_add(out, PM_LOBE_DIFFUSE, PM_EVENT_DIFFUSE, PM_SIDE_NEAR, pm_rgb_grey(1));
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
    return pm_surface_part(&surface, PM_EVENT_STRAIGHT, PM_SIDE_FAR);
}
