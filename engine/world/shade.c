/* From a hit to the lobes of its material: textures, mixtures, stand-ins. */
#include "world/shade.h"

#include "world/light.h"

/* ---- lobes ---- */

void pm_shade_straight(struct shade *s, pm_rgb albedo, double strength)
{
    pm_vec3 wi = pm_vec3_negate(s->out->wo);
    if (s->tilted && s->seen) {
        pm_vec3 bent = pm_vec3_normalize(pm_vec3_madd(wi, -strength, s->shift));
        if (pm_vec3_dot(bent, s->out->normal) < 0)
            wi = bent;
    }
    pm_shade_direction(s, PM_EVENT_STRAIGHT, PM_SIDE_FAR, albedo, wi);
}

/* ---- textures and mixtures ---- */

/* Whether its normal is interpolated. */
static bool is_smooth(const pm_hit *hit)
{
    pm_vec3 p = hit->perturbation;
    return p.x != 0 || p.y != 0 || p.z != 0;
}

static void set_normal(struct shade *s, bool side)
{
    pm_vec3 p = s->shading->perturbation;
    s->tilted = p.x != 0 || p.y != 0 || p.z != 0;
    if (!s->tilted)
        return;
    s->shift = side ? p : pm_vec3_negate(p);
    s->normal = pm_shading_normal(s->shading);
    s->normal = side ? s->normal : pm_vec3_negate(s->normal);
    s->cosine = fmin(pm_vec3_dot(s->out->wo, s->normal), 1);
    if (!(s->cosine > 0)) { /* rounding, at grazing incidence */
        s->tilted = false;
        s->normal = s->out->normal;
        s->cosine = fmin(pm_vec3_dot(s->out->wo, s->normal), 1);
    }
}

static const struct pm_material *at(const pm_world *world, uint32_t material)
{
    return material == PM_NO_PRIMITIVE ? NULL : &world->materials[material];
}

/* `m` NULL: nothing, straight passage. Everything but the material, the shading and the share
 * is the hit's. `shading` is what the modifiers above left, NULL if nothing asked for it so
 * far. Recursion is bounded by PM_MODIFIERS_MAX. */
static void shade(const pm_world *world, const pm_hit *hit, const struct shade *above,
                  const struct pm_material *m)
{
    struct shade s = *above;
    struct pm_shading shading;
    s.material = m;
    if (!m) {
        pm_shade_straight(&s, pm_rgb_grey(1), 0);
        return;
    }
    if (!m->plain || s.shading || is_smooth(hit)) {
        if (s.shading)
            shading = *s.shading;
        else
            pm_shading_init(&shading, world, hit, s.out->wo, hit->t);
        s.shading = &shading;
        pm_textures_apply(m, &shading);
        set_normal(&s, pm_vec3_dot(hit->normal, s.out->normal) > 0);
    }
    if (m->type == PM_ILLUM || m->type == PM_ANTIMATTER) {
        /* here only within mixtures: the others are resolved by pm_material_shown */
        shade(world, hit, above, m->type == PM_ILLUM ? at(world, m->alternate) : NULL);
    } else if (!pm_primitive_is_mixture(m->type)) {
        pm_shade_model(&s);
    } else {
        double share, whole = s.share;
        if (!pm_mixture_share(m, &shading, &share)) {
            pm_shade_straight(&s, pm_rgb_grey(1), 0);
            return;
        }
        s.share = whole * share;
        if (s.share > 0)
            shade(world, hit, &s, at(world, m->components[0]));
        s.share = whole * (1 - share);
        if (s.share > 0)
            shade(world, hit, &s, at(world, m->components[1]));
    }
}

/* ---- hits ---- */

enum looker { WALK, EYE, SHADOW_RAY, PHOTON };

static void surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                       const pm_media *media, enum looker looker, pm_surface *out)
{
    struct pm_shown shown = pm_material_shown(world, hit, wo, media, looker == EYE);
    double cosine = pm_vec3_dot(wo, hit->normal);
    bool front = cosine >= 0;
    pm_surface_begin(out, front ? hit->normal : pm_vec3_negate(hit->normal), wo);
    struct shade s;
    s.shading = NULL;
    s.normal = out->normal;
    s.shift = (pm_vec3){0, 0, 0};
    s.cosine = fmin(fabs(cosine), 1);
    s.share = 1;
    s.tilted = false;
    s.front = front != shown.flipped;
    s.hidden = world->hides_back_faces && !s.front;
    s.lit = looker == PHOTON;
    s.seen = looker == EYE;
    s.shadow = looker == SHADOW_RAY;
    s.out = out;
    s.material = shown.material;
    if (shown.material && shown.material->plain && !is_smooth(hit))
        pm_shade_model(&s); /* the common case */
    else
        shade(world, hit, &s, shown.material);
}

void pm_surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo, const pm_media *media,
                   pm_surface *out)
{
    surface_at(world, hit, wo, media, WALK, out);
}

void pm_surface_lit_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                       const pm_media *media, pm_surface *out)
{
    surface_at(world, hit, wo, media, PHOTON, out);
}

void pm_surface_seen_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                        const pm_media *media, pm_surface *out)
{
    surface_at(world, hit, wo, media, EYE, out);
}

void pm_surface_receiver(pm_vec3 normal, pm_surface *out)
{
    pm_surface_begin(out, normal, normal);
    pm_lobe_add(out, PM_LOBE_DIFFUSE, PM_EVENT_DIFFUSE, PM_SIDE_NEAR, pm_rgb_grey(1));
}

pm_rgb pm_material_straight(const pm_world *world, const pm_hit *hit, pm_vec3 direction,
                            const pm_media *media, bool weak)
{
    pm_vec3 wo = pm_vec3_negate(direction);
    if (!media->count && !world->hides_back_faces && !world->materials[hit->material].straight)
        return pm_rgb_grey(0);
    if (weak && pm_light_stands_in(world, hit, wo))
        return pm_rgb_grey(0);
    pm_surface surface;
    surface_at(world, hit, wo, media, SHADOW_RAY, &surface);
    return pm_surface_part(&surface, PM_EVENT_STRAIGHT, PM_SIDE_FAR);
}

bool pm_surface_is_hidden(const pm_world *world, const pm_hit *hit, const pm_media *media)
{
    return media->count && pm_material_is_hidden(world, media, hit->material);
}

bool pm_surface_may_store(const pm_world *world, const pm_hit *hit)
{
    return pm_material_is_diffuse(&world->materials[hit->material]);
}

bool pm_surface_blocks(const pm_world *world, const pm_hit *hit)
{
    const struct pm_material *m = &world->materials[hit->material];
    return !m->straight && m->type != PM_MIST;
}
