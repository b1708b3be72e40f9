/* Which lobes each material has. */
#include "base/maths.h"
#include "base/warp.h"
#include "scene/assets.h"
#include "world/fresnel.h"
#include "world/shade.h"

static pm_rgb rgb_of(const double *v)
{
    return (pm_rgb){v[0], v[1], v[2]};
}

static pm_rgb least(pm_rgb a, pm_rgb b)
{
    return (pm_rgb){fmin(a.r, b.r), fmin(a.g, b.g), fmin(a.b, b.b)};
}

static pm_rgb rest_of(pm_rgb part)
{
    return (pm_rgb){fmax(1 - part.r, 0), fmax(1 - part.g, 0), fmax(1 - part.b, 0)};
}

/* Where a rough transmission points: straight on, but for textures (Radiance's normal.c). */
static pm_vec3 bent_straight(const struct shade *s)
{
    pm_vec3 straight = pm_vec3_negate(s->out->wo);
    pm_vec3 bent = pm_vec3_normalize(pm_vec3_sub(straight, s->shift));
    return s->tilted && pm_vec3_dot(bent, s->out->normal) < 0 &&
                   pm_vec3_dot(bent, s->normal) < 0
               ? bent
               : straight;
}

/* ---- plastic, metal, trans ---- */

static void add_rough(struct shade *s, pm_lobe_kind kind, unsigned side, pm_rgb albedo)
{
    pm_lobe *lobe = pm_shade_add(s, kind, PM_EVENT_GLOSSY, side, albedo);
    if (!lobe)
        return;
    lobe->u.rough.alpha = s->material->roughness;
    lobe->u.rough.straight = bent_straight(s);
}

/* After Radiance's normal.c. Both sides are alike. */
static void plastic(struct shade *s)
{
    const struct pm_material *m = s->material;
    if (m->specularity == 0 && m->transmission == 0) { /* the rest is black: the common case */
        pm_shade_diffuse(s, PM_SIDE_NEAR, pm_shade_color(s, m->color), PM_COAT_NONE);
        return;
    }
    bool smooth = !(m->roughness > 0);
    pm_coat coat =
        smooth && m->specularity >= PM_FRESNEL_THRESHOLD ? PM_COAT_SMOOTH : PM_COAT_NONE;
    double rise = coat ? pm_fresnel_estimate(s->cosine) : 0;
    double specular = m->specularity + rise * (1 - m->specularity);
    double rest = 1 - specular, straight = rest * m->transmission * m->straight_fraction;
    pm_rgb color = pm_shade_color(s, m->color), reflectance = pm_rgb_grey(specular);
    if (m->type == PM_METAL)
        reflectance = pm_rgb_madd(pm_rgb_grey(rise), m->specularity * (1 - rise), color);
    /* products, so that what the arguments leave nothing for is exactly black */
    pm_shade_diffuse(s, PM_SIDE_NEAR, pm_rgb_scale(color, rest * (1 - m->transmission)), coat);
    pm_shade_diffuse(s, PM_SIDE_FAR,
                     pm_rgb_scale(color, rest * m->transmission * (1 - m->straight_fraction)),
                     coat);
    if (smooth) {
        pm_shade_mirror(s, reflectance);
        pm_shade_straight(s, pm_rgb_scale(color, straight), 1);
    } else {
        add_rough(s, PM_LOBE_WARD, PM_SIDE_NEAR, reflectance);
        add_rough(s, PM_LOBE_ROUGH, PM_SIDE_FAR, pm_rgb_scale(color, straight));
    }
}

/* ---- plastic2, metal2, trans2, ashik2 ---- */

/* The normal that functions see faces wo, as after Radiance's flipsurface. */
static void turn_ray(struct shade *s)
{
    double *v = pm_shading_ray(s->shading, &s->material->modifier)->value;
    if (v[PM_RAY_RDOT] < 0)
        for (int i = 0; i < 4; i++)
            v[i < 3 ? PM_RAY_NX + i : PM_RAY_RDOT] *= -1;
}

/* The direction that the material's three expressions give, in the surface; false if they give
 * none (Radiance's getacoords in aniso.c). */
static bool orientation(struct shade *s, pm_vec3 *u)
{
    const struct pm_modifier *m = &s->material->modifier;
    double v[3];
    turn_ray(s);
    if (!pm_shading_evaluate(s->shading, m, m->expressions, NULL, 0, v))
        return false;
    /* lengths count for nothing: no square over- or underflows */
    double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0))
        return false;
    pm_vec3 given = {v[0] / largest, v[1] / largest, v[2] / largest};
    given = pm_shading_to_world(s->shading, m, given);
    given = pm_vec3_madd(given, -pm_vec3_dot(given, s->normal), s->normal);
    if (!(pm_vec3_dot(given, given) > 1e-20))
        return false;
    *u = pm_vec3_normalize(given);
    return true;
}

struct grains {
    pm_vec3 u;
    double along, across;
};

static void add_grain(struct shade *s, pm_lobe_kind kind, unsigned side, pm_rgb albedo,
                      const struct grains *grains)
{
    pm_lobe *lobe = pm_shade_add(s, kind, PM_EVENT_GLOSSY, side, albedo);
    if (!lobe)
        return;
    lobe->u.grain.u = grains->u;
    lobe->u.grain.along = grains->along;
    lobe->u.grain.across = grains->across;
    lobe->u.grain.straight = bent_straight(s);
}

static struct grains grains_of(struct shade *s)
{
    const struct pm_material *m = s->material;
    struct grains g = {{0, 0, 0}, m->roughness, m->across};
    if (orientation(s, &g.u))
        return g;
    g.u = pm_frame_make(s->normal).x;
    if (m->type == PM_ASHIK2)
        g.along = g.across = 2 / (1 / (m->roughness + 1e-5) + 1 / (m->across + 1e-5));
    else
        g.along = g.across = sqrt((m->roughness * m->roughness + m->across * m->across) / 2);
    return g;
}

/* After Radiance's aniso.c. */
static void plastic2(struct shade *s)
{
    const struct pm_material *m = s->material;
    struct grains grains = grains_of(s);
    double rest = 1 - m->specularity;
    pm_rgb color = pm_shade_color(s, m->color), reflectance = pm_rgb_grey(m->specularity);
    if (m->type == PM_METAL2)
        reflectance = pm_rgb_scale(color, m->specularity);
    pm_shade_diffuse(s, PM_SIDE_NEAR, pm_rgb_scale(color, rest * (1 - m->transmission)),
                     PM_COAT_NONE);
    pm_shade_diffuse(s, PM_SIDE_FAR,
                     pm_rgb_scale(color, rest * m->transmission * (1 - m->straight_fraction)),
                     PM_COAT_NONE);
    add_grain(s, PM_LOBE_GRAIN_WARD, PM_SIDE_NEAR, reflectance, &grains);
    add_grain(s, PM_LOBE_GRAIN_ROUGH, PM_SIDE_FAR,
              pm_rgb_scale(color, rest * m->transmission * m->straight_fraction), &grains);
}

/* What the coat of an ashik2 lets through on average, 1 - integral of (1 - c)^5 2 c dc. */
#define SCHLICK_PASSES (20. / 21)

/* The diffuse part of one channel: all of it where the specular part leaves enough. */
static double left_for(double diffuse, double specular)
{
    return fmin(diffuse, (1 - specular) / SCHLICK_PASSES);
}

/* After Radiance's ashikhmin.c, whose diffuse part knows nothing of the specular one: here what
 * both would scatter over 1, towards grazing, is taken from the diffuse part. */
static void ashik2(struct shade *s)
{
    const struct pm_material *m = s->material;
    struct grains grains = grains_of(s);
    pm_rgb color = pm_shade_color(s, m->color), specular = m->specular_color;
    if (pm_rgb_luminance(specular) > 1e-6)
        specular = pm_rgb_madd(specular, pm_fresnel_schlick(s->cosine),
                               pm_rgb_sub(pm_rgb_grey(1), specular));
    pm_rgb diffuse = {left_for(color.r, specular.r), left_for(color.g, specular.g),
                      left_for(color.b, specular.b)};
    pm_shade_diffuse(s, PM_SIDE_NEAR, diffuse, PM_COAT_SCHLICK);
    add_grain(s, PM_LOBE_GRAIN_PHONG, PM_SIDE_NEAR, specular, &grains);
}

/* ---- glass, dielectric, interface ---- */

/* A thin pane; both sides are alike (Radiance's glass.c). */
static void glass(struct shade *s)
{
    const struct pm_material *m = s->material;
    pm_pane pane = pm_pane_at(s->cosine, m->index);
    pm_rgb reflectance = {pm_pane_reflectance(&pane, m->color.r),
                          pm_pane_reflectance(&pane, m->color.g),
                          pm_pane_reflectance(&pane, m->color.b)};
    pm_rgb transmittance = {pm_pane_transmittance(&pane, m->color.r),
                            pm_pane_transmittance(&pane, m->color.g),
                            pm_pane_transmittance(&pane, m->color.b)};
    if (s->shading)
        transmittance = least(pm_shade_color(s, transmittance), rest_of(reflectance));
    pm_shade_mirror(s, reflectance);
    pm_shade_straight(s, transmittance, 2 * (m->index - 1));
}

/* Snell: the tangential part shrinks by the ratio of the indices. */
static pm_vec3 refract(pm_vec3 wo, pm_vec3 normal, double cosine, double ratio,
                       double refracted)
{
    pm_vec3 tangential = pm_vec3_madd(wo, -cosine, normal);
    pm_vec3 wi = pm_vec3_madd(pm_vec3_scale(tangential, -ratio), -refracted, normal);
    return pm_vec3_normalize(wi);
}

/* Index m->index behind over that in front (Radiance's dielectric.c). A texture that would turn
 * refraction into reflection does not bend the light. */
static void dielectric(struct shade *s)
{
    double index = s->material->index, ratio = s->front ? 1 / index : index, refracted;
    double reflectance = pm_fresnel_dielectric(s->cosine, ratio, &refracted);
    pm_shade_mirror(s, pm_rgb_grey(reflectance));
    pm_lobe *lobe = pm_shade_add(s, PM_LOBE_DIRECTION, PM_EVENT_SPECULAR, PM_SIDE_FAR,
                                 pm_rgb_grey(1 - reflectance));
    if (!lobe)
        return;
    pm_vec3 wo = s->out->wo, flat = s->out->normal;
    pm_vec3 wi = refract(wo, s->normal, s->cosine, ratio, refracted);
    if (s->tilted && !(pm_vec3_dot(wi, flat) < 0))
        wi = pm_vec3_normalize(
            pm_vec3_madd(pm_vec3_scale(wo, -ratio), ratio * s->cosine - refracted, flat));
    if (s->tilted && !(pm_vec3_dot(wi, flat) < 0))
        wi = pm_vec3_negate(wo);
    lobe->u.direction.wi = wi;
    lobe->u.direction.radiance_scale = ratio * ratio;
}

/* ---- prism1, prism2 ---- */

/* A redirection (Radiance's m_direct.c). Its coefficient is one of radiance: as a beam that
 * leaves more askew than it comes has the smaller section, the share of flux differs by the
 * ratio of the cosines. Neither way may more leave than comes. */
struct redirection {
    pm_vec3 wi;
    double flux, radiance; /* 0: none */
};

static struct redirection redirection_of(const struct shade *s, const double v[4])
{
    struct redirection r = {{0, 0, 0}, 0, 0};
    double largest = fmax(fabs(v[1]), fmax(fabs(v[2]), fabs(v[3])));
    if (!(v[0] > 0) || !(largest > 0))
        return r;
    pm_vec3 wi = {v[1] / largest, v[2] / largest, v[3] / largest};
    r.wi = pm_vec3_normalize(pm_shading_to_world(s->shading, &s->material->modifier, wi));
    double leaving = fabs(pm_vec3_dot(r.wi, s->out->normal));
    double coming = fabs(pm_vec3_dot(s->out->wo, s->out->normal));
    if (!(leaving > 1e-6) || !(coming > 1e-6)) /* Radiance's FTINY: along the surface */
        return r;
    r.flux = fmin(v[0] * leaving / coming, 1);
    r.radiance = fmin(v[0], leaving / coming);
    return r;
}

static void redirect(struct shade *s, const struct redirection *r, double flux, double radiance)
{
    unsigned side = pm_vec3_dot(r->wi, s->out->normal) > 0 ? PM_SIDE_NEAR : PM_SIDE_FAR;
    pm_lobe *lobe =
        pm_shade_add(s, PM_LOBE_DIRECTION, PM_EVENT_SPECULAR, side, pm_rgb_grey(flux));
    if (!lobe)
        return;
    lobe->u.direction.wi = r->wi;
    lobe->u.direction.radiance_scale = radiance / flux;
}

static void prism(struct shade *s)
{
    const struct pm_modifier *m = &s->material->modifier;
    double v[8] = {0};
    if (!pm_shading_evaluate(s->shading, m, m->expressions, NULL, 0, v))
        return;
    struct redirection r[2] = {redirection_of(s, v), redirection_of(s, v + 4)};
    double flux = 1 / fmax(r[0].flux + r[1].flux, 1);
    double radiance = 1 / fmax(r[0].radiance + r[1].radiance, 1);
    for (int i = 0; i < 2; i++)
        redirect(s, &r[i], r[i].flux * flux, r[i].radiance * radiance);
}

/* ---- plasfunc, metfunc, transfunc, BRTDfunc and the same with data ---- */

/* Probabilities of what tables show as black, of a function that may differ elsewhere. */
#define LEAST_ALBEDO .05

static double shrunk(double albedo, double room)
{
    if (!(albedo > room))
        return 1;
    return albedo > 1.001 * room ? room / (1.02 * albedo)
                                 : room / albedo; /* tables are coarse */
}

/* The function's lobe on one side. `scale` keeps its energy in bounds. */
static void add_function(struct shade *s, unsigned side, pm_rgb color, pm_rgb albedo,
                         pm_rgb scale)
{
    pm_rgb guess = {fmax(albedo.r, LEAST_ALBEDO), fmax(albedo.g, LEAST_ALBEDO),
                    fmax(albedo.b, LEAST_ALBEDO)};
    guess = pm_rgb_mul(guess, scale);
    pm_lobe *lobe =
        pm_shade_add(s, PM_LOBE_FUNCTION, PM_EVENT_DIFFUSE, side, pm_rgb_mul(color, guess));
    if (!lobe)
        return;
    lobe->u.function.index = s->out->function_count - 1;
    lobe->u.function.front = s->front;
    lobe->u.function.gain =
        (pm_rgb){scale.r > 0 ? scale.r / guess.r : 0, scale.g > 0 ? scale.g / guess.g : 0,
                 scale.b > 0 ? scale.b / guess.b : 0};
}

static pm_brdf *new_function(struct shade *s, bool turned, pm_rgb color)
{
    if (s->out->function_count == PM_FUNCTIONS_MAX)
        return NULL;
    pm_brdf *brdf = &s->out->functions[s->out->function_count++];
    pm_brdf_at(s->material, s->shading, s->normal, turned, color, brdf);
    return brdf;
}

/* Radiance's m_brdf2 (m_brdf.c): the sides are alike. */
static void plasfunc(struct shade *s)
{
    const struct pm_material *m = s->material;
    bool metal = m->type == PM_METFUNC || m->type == PM_METDATA;
    double rest = 1 - m->specularity;
    pm_rgb color = pm_shade_color(s, m->color);
    pm_shade_diffuse(s, PM_SIDE_NEAR, pm_rgb_scale(color, rest * (1 - m->transmission)),
                     PM_COAT_NONE);
    pm_shade_diffuse(s, PM_SIDE_FAR,
                     pm_rgb_scale(color, rest * m->transmission * (1 - m->straight_fraction)),
                     PM_COAT_NONE);
    pm_rgb colors[2] = {pm_rgb_scale(metal ? color : pm_rgb_grey(1), m->specularity),
                        pm_rgb_scale(color, rest * m->transmission * m->straight_fraction)};
    if (pm_rgb_is_black(colors[0]) && pm_rgb_is_black(colors[1]))
        return;
    const pm_brdf *brdf = new_function(s, true, color);
    for (int far = 0; brdf && far < 2; far++) {
        pm_rgb albedo = pm_brdf_albedo(brdf, s->normal, s->out->wo, s->front, far);
        pm_rgb scale = {shrunk(albedo.r, 1), shrunk(albedo.g, 1), shrunk(albedo.b, 1)};
        add_function(s, far ? PM_SIDE_FAR : PM_SIDE_NEAR, colors[far], albedo, scale);
    }
}

/* Three expressions of a BRTDfunc; what is no number is black. */
static pm_rgb share_of(const double *v)
{
    return (pm_rgb){fmin(fmax(v[0], 0), 1), fmin(fmax(v[1], 0), 1), fmin(fmax(v[2], 0), 1)};
}

/* Factor that keeps a sum of parts in `room`. */
static pm_rgb fitting(pm_rgb sum, pm_rgb room)
{
    return (pm_rgb){sum.r > room.r ? room.r / sum.r : 1, sum.g > room.g ? room.g / sum.g : 1,
                    sum.b > room.b ? room.b / sum.b : 1};
}

/* Radiance's m_brdf: diffuse, ideal and functional parts, both sides apart. Its reals are the
 * diffuse reflectances in front and behind, and the diffuse transmittance. */
static void brtdfunc(struct shade *s)
{
    const struct pm_modifier *m = &s->material->modifier;
    pm_rgb reflected = pm_shade_color(s, rgb_of(m->reals + (s->front ? 0 : 3)));
    pm_rgb passed = pm_shade_color(s, rgb_of(m->reals + 6));
    const pm_brdf *brdf = new_function(s, false, pm_shade_color(s, pm_rgb_grey(1)));
    double v[6] = {0};
    if (!brdf)
        return;
    if (pm_function_values(pm_assets_language(brdf->world->assets), m->expressions, &brdf->ray,
                           NULL, 0, v))
        for (int i = 0; i < 6; i++)
            v[i] = 0;
    pm_rgb mirrored = share_of(v), straight = share_of(v + 3);
    pm_rgb sum = pm_rgb_add(pm_rgb_add(reflected, passed), pm_rgb_add(mirrored, straight));
    pm_rgb fit = fitting(sum, pm_rgb_grey(1));
    pm_shade_diffuse(s, PM_SIDE_NEAR, pm_rgb_mul(reflected, fit), PM_COAT_NONE);
    pm_shade_diffuse(s, PM_SIDE_FAR, pm_rgb_mul(passed, fit), PM_COAT_NONE);
    pm_shade_mirror(s, pm_rgb_mul(mirrored, fit));
    pm_shade_straight(s, pm_rgb_mul(straight, fit), 1);
    pm_rgb room = rest_of(least(sum, pm_rgb_grey(1)));
    pm_rgb near = pm_brdf_albedo(brdf, s->normal, s->out->wo, s->front, false);
    pm_rgb far = pm_brdf_albedo(brdf, s->normal, s->out->wo, s->front, true);
    pm_rgb both = pm_rgb_add(near, far);
    pm_rgb scale = {shrunk(both.r, room.r), shrunk(both.g, room.g), shrunk(both.b, room.b)};
    add_function(s, PM_SIDE_NEAR, pm_rgb_grey(1), near, scale);
    add_function(s, PM_SIDE_FAR, pm_rgb_grey(1), far, scale);
}

/* ---- BSDF, aBSDF ---- */

static void add_table(struct shade *s, unsigned side, pm_rgb albedo, pm_rgb gain)
{
    pm_lobe *lobe = pm_shade_add(s, PM_LOBE_TABLE, PM_EVENT_GLOSSY, side, albedo);
    if (!lobe)
        return;
    lobe->u.table.index = s->out->bsdf_count - 1;
    lobe->u.table.gain = pm_rgb_scale(gain, s->share);
}

/* Photons do not lie where light that skips over geometry would look for them: walks follow
 * what a proxy transmits diffusely. */
static void add_transmission(struct shade *s, pm_rgb albedo, bool skips)
{
    pm_shade_add(s, PM_LOBE_DIFFUSE, skips ? PM_EVENT_GLOSSY : PM_EVENT_DIFFUSE, PM_SIDE_FAR,
                 albedo);
}

/* See bsdf_surface.h. */
static void bsdf(struct shade *s)
{
    enum pm_bsdf_walk walk = s->shadow ? PM_BSDF_SHADOW : s->seen ? PM_BSDF_SEEN : PM_BSDF_WALK;
    struct pm_bsdf_shares shares;
    if (s->out->bsdf_count == PM_BSDFS_MAX)
        return;
    pm_bsdf_hit *hit = &s->out->bsdfs[s->out->bsdf_count];
    if (!pm_bsdf_hit_at(s->material, s->shading, s->normal, s->front, walk, hit, &shares))
        return;
    if (shares.passes) {
        pm_shade_straight(s, pm_rgb_grey(1), 0);
        return;
    }
    s->out->bsdf_count++;
    s->out->skip = fmax(s->out->skip, shares.thickness);
    pm_shade_diffuse(s, PM_SIDE_NEAR, shares.diffuse[0], PM_COAT_NONE);
    add_transmission(s, shares.diffuse[1], shares.thickness > 0);
    add_table(s, PM_SIDE_NEAR, shares.rest[0], shares.gain[0]);
    add_table(s, PM_SIDE_FAR, shares.rest[1], shares.gain[1]);
    pm_shade_straight(s, shares.straight, 0);
}

/* ---- all ---- */

/* The back of a surface that is seen from the front alone. Rays from the eye, and from wherever
 * they go on, pass it (Radiance's raytrans in normal.c, aniso.c, glass.c, m_brdf.c, m_bsdf.c,
 * m_mirror.c); photons end there if it is opaque (pmapmat.c), else they take it as it is. False
 * for what has no such back. */
static bool shade_hidden(struct shade *s)
{
    switch (s->material->type) {
    case PM_PLASTIC:
    case PM_METAL:
    case PM_PLASTIC2:
    case PM_METAL2:
    case PM_ASHIK2:
    case PM_MIRROR:
    case PM_PLASFUNC:
    case PM_METFUNC:
    case PM_PLASDATA:
    case PM_METDATA:
        if (s->lit)
            return true; /* no lobe: it is black */
        break;
    case PM_TRANS:
    case PM_TRANS2:
    case PM_GLASS:
    case PM_TRANSFUNC:
    case PM_TRANSDATA:
    case PM_BRTDFUNC:
    case PM_BSDF:
    case PM_ABSDF:
        if (s->lit)
            return false;
        break;
    default:
        return false;
    }
    pm_shade_straight(s, pm_rgb_grey(1), 0);
    return true;
}

void pm_shade_model(struct shade *s)
{
    if (s->hidden && shade_hidden(s))
        return;
    switch (s->material->type) {
    case PM_PLASTIC:
    case PM_METAL:
    case PM_TRANS:
        plastic(s);
        break;
    case PM_PLASTIC2:
    case PM_METAL2:
    case PM_TRANS2:
        plastic2(s);
        break;
    case PM_ASHIK2:
        ashik2(s);
        break;
    case PM_GLASS:
        glass(s);
        break;
    case PM_DIELECTRIC:
    case PM_INTERFACE:
        dielectric(s);
        break;
    case PM_MIRROR: /* the back is black (Radiance's m_mirror.c) */
        if (s->front)
            pm_shade_mirror(s, pm_shade_color(s, s->material->color));
        break;
    case PM_PRISM1:
    case PM_PRISM2:
        prism(s);
        break;
    case PM_PLASFUNC:
    case PM_METFUNC:
    case PM_TRANSFUNC:
    case PM_PLASDATA:
    case PM_METDATA:
    case PM_TRANSDATA:
        plasfunc(s);
        break;
    case PM_BRTDFUNC:
        brtdfunc(s);
        break;
    case PM_BSDF:
    case PM_ABSDF:
        bsdf(s);
        break;
    case PM_MIST:
        pm_shade_straight(s, pm_rgb_grey(1), 0);
        break;
    default: /* lamps are black from both sides (Radiance's m_light in source.c) */
        break;
    }
}
