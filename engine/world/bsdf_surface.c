#include "world/bsdf_surface.h"

#include "base/maths.h"
#include "scene/assets.h"
#include "world/material.h"
#include "world/shading.h"

/* Radiance's FTINY. */
#define TINY 1e-6

static bool has_thickness(const struct pm_material *m)
{
    return m->type == PM_BSDF;
}

static const pm_bsdf *bsdf_of(const pm_world *world, const struct pm_material *m)
{
    int32_t asset = m->modifier.assets[has_thickness(m) ? 1 : 0];
    return pm_assets_at(world->assets, asset)->bsdf;
}

/* ---- orientation ---- */

/* x = up x z, y = z x x (Radiance's SDcompXform). False if up is along z or nothing. */
static bool orient(pm_vec3 up, pm_vec3 z, pm_bsdf_hit *hit)
{
    double largest = fmax(fabs(up.x), fmax(fabs(up.y), fabs(up.z)));
    if (!(largest > 0))
        return false;
    pm_vec3 x = pm_vec3_cross(pm_vec3_scale(up, 1 / largest), z);
    if (!(pm_vec3_dot(x, x) > 1e-24))
        return false;
    hit->axis[0] = pm_vec3_normalize(x);
    hit->axis[1] = pm_vec3_cross(z, hit->axis[0]);
    hit->axis[2] = z;
    return true;
}

static pm_vec3 to_local(const pm_bsdf_hit *hit, pm_vec3 w)
{
    return (pm_vec3){pm_vec3_dot(w, hit->axis[0]), pm_vec3_dot(w, hit->axis[1]),
                     pm_vec3_dot(w, hit->axis[2])};
}

static pm_vec3 to_world(const pm_bsdf_hit *hit, pm_vec3 v)
{
    pm_vec3 w = pm_vec3_scale(hit->axis[0], v.x);
    w = pm_vec3_madd(w, v.y, hit->axis[1]);
    return pm_vec3_normalize(pm_vec3_madd(w, v.z, hit->axis[2]));
}

/* ---- shares ---- */

/* The i-th colour of the reals: diffuse reflectance in front, behind, transmittance. */
static pm_rgb real_color(const struct pm_material *m, unsigned i)
{
    const double *r = m->modifier.reals + 3 * i;
    return m->modifier.real_count >= 3 * i + 3 ? (pm_rgb){r[0], r[1], r[2]} : pm_rgb_grey(0);
}

static pm_rgb least_with_one(pm_rgb c)
{
    return (pm_rgb){fmin(c.r, 1), fmin(c.g, 1), fmin(c.b, 1)};
}

static void scale_shares(struct pm_bsdf_shares *s, double scale)
{
    for (int i = 0; i < 2; i++) {
        s->diffuse[i] = pm_rgb_scale(s->diffuse[i], scale);
        s->rest[i] = pm_rgb_scale(s->rest[i], scale);
        s->gain[i] = pm_rgb_scale(s->gain[i], scale);
    }
    s->straight = pm_rgb_scale(s->straight, scale);
}

/* What the file scatters and what the reals add may be more than all light. */
static void keep_energy(struct pm_bsdf_shares *s)
{
    pm_rgb sum = s->straight;
    for (int i = 0; i < 2; i++)
        sum = pm_rgb_add(sum, pm_rgb_add(s->diffuse[i], s->rest[i]));
    if (pm_rgb_max(sum) > 1)
        scale_shares(s, 1 / pm_rgb_max(sum));
}

static void fill_shares(const struct pm_material *m, const struct pm_shading *shading,
                        bool front, const pm_bsdf_hit *hit, struct pm_bsdf_shares *s)
{
    const pm_bsdf *bsdf = hit->bsdf;
    pm_rgb pattern = pm_shading_reflectance(shading, pm_rgb_grey(1));
    pm_rgb reflected =
        pm_rgb_add(pm_bsdf_diffuse_reflectance(bsdf, hit->in), real_color(m, front ? 0 : 1));
    pm_rgb transmitted =
        pm_rgb_add(pm_bsdf_diffuse_transmittance(bsdf, hit->in), real_color(m, 2));
    s->diffuse[0] = pm_rgb_mul(least_with_one(reflected), pattern);
    s->diffuse[1] = pm_rgb_mul(least_with_one(transmitted), pattern);
    s->gain[0] = pm_rgb_grey(1);
    s->gain[1] = pattern;
    s->rest[0] = pm_bsdf_albedo(bsdf, hit->in, false);
    s->rest[1] = pm_rgb_mul(pm_bsdf_albedo(bsdf, hit->in, true), pattern);
    s->rest[1] = pm_rgb_scale(s->rest[1], fmax(1 - hit->peak.share, 0));
    s->straight = pm_rgb_mul(hit->peak.transmittance, pattern);
    keep_energy(s);
}

/* ---- hits ---- */

/* Whether the walk meets the geometry that a proxy stands for, instead of the proxy. */
static bool passes(double thickness, bool front, enum pm_bsdf_walk walk)
{
    return fabs(thickness) > TINY && (walk != PM_BSDF_WALK || (thickness > 0) != front);
}

bool pm_bsdf_hit_at(const struct pm_material *m, struct pm_shading *shading, pm_vec3 normal,
                    bool front, enum pm_bsdf_walk walk, pm_bsdf_hit *hit,
                    struct pm_bsdf_shares *shares)
{
    double v[4] = {0}, *up = v + has_thickness(m);
    *shares = (struct pm_bsdf_shares){.passes = false};
    if (!pm_shading_evaluate(shading, &m->modifier, m->modifier.expressions, NULL, 0, v))
        return false;
    if (has_thickness(m) && passes(v[0], front, walk)) {
        shares->passes = true;
        return true;
    }
    pm_vec3 z = front ? normal : pm_vec3_negate(normal);
    hit->bsdf = bsdf_of(shading->world, m);
    hit->peak.count = 0;
    hit->peak.share = 0;
    hit->peak.transmittance = pm_rgb_grey(0);
    if (!orient(pm_shading_to_world(shading, &m->modifier, (pm_vec3){up[0], up[1], up[2]}), z,
                hit))
        return false;
    hit->in = to_local(hit, shading->wo);
    if (m->type == PM_ABSDF)
        pm_bsdf_peak_at(hit->bsdf, hit->in, &hit->peak);
    if (has_thickness(m) && fabs(v[0]) > TINY) {
        double scale = m->modifier.transform.scale / shading->world->scale;
        scale *= shading->in_instance ? shading->from_instance.scale : 1;
        shares->thickness = fabs(v[0]) * scale;
    }
    fill_shares(m, shading, front, hit, shares);
    return true;
}

/* ---- the rest ---- */

pm_rgb pm_bsdf_hit_value(const pm_bsdf_hit *hit, pm_vec3 wi)
{
    return pm_bsdf_value_without(hit->bsdf, &hit->peak, hit->in, to_local(hit, wi));
}

bool pm_bsdf_hit_sample(const pm_bsdf_hit *hit, bool far, double u, double v, pm_vec3 *wi)
{
    pm_vec3 out;
    bool drawn = far ? pm_bsdf_sample_without(hit->bsdf, &hit->peak, hit->in, u, v, &out)
                     : pm_bsdf_sample(hit->bsdf, hit->in, false, u, v, &out);
    if (drawn)
        *wi = to_world(hit, out);
    return drawn;
}

double pm_bsdf_hit_pdf(const pm_bsdf_hit *hit, pm_vec3 wi)
{
    return pm_bsdf_pdf_without(hit->bsdf, &hit->peak, hit->in, to_local(hit, wi));
}

/* ---- what materials can do ---- */

static bool colored(pm_rgb c)
{
    return !pm_rgb_is_black(c);
}

/* Whether the thickness is the same everywhere, and nothing. */
static bool never_thick(const pm_world *world, const struct pm_material *m)
{
    double v[4];
    const pm_language *language = pm_assets_language(world->assets);
    if (!has_thickness(m) || pm_function_uses(language, m->modifier.expressions))
        return !has_thickness(m);
    if (pm_function_values(language, m->modifier.expressions, NULL, NULL, 0, v))
        return false;
    return fabs(v[0]) <= TINY;
}

void pm_bsdf_set_abilities(const pm_world *world, struct pm_material *m)
{
    const pm_bsdf *bsdf = bsdf_of(world, m);
    pm_bsdf_info info;
    pm_bsdf_info_get(bsdf, &info);
    m->specular = m->diffuse = false;
    for (int front = 0; front < 2; front++) {
        pm_vec3 in = {0, 0, front ? 1 : -1};
        m->specular |= info.rest_reflects[front] || info.rest_transmits[front];
        m->diffuse |= colored(pm_bsdf_diffuse_reflectance(bsdf, in)) ||
                      colored(pm_bsdf_diffuse_transmittance(bsdf, in));
    }
    for (unsigned i = 0; i < 3; i++)
        m->diffuse |= colored(real_color(m, i));
    bool peaked = info.rest_transmits[0] || info.rest_transmits[1];
    m->straight = m->type == PM_ABSDF ? peaked : !never_thick(world, m);
}
