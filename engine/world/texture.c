/* Textures, patterns and mixtures: p_func.c, p_data.c, t_func.c, t_data.c, text.c, mx_func.c
 * and mx_data.c of Radiance's src/rt. */
#include "base/xyz.h"
#include "world/material.h"
#include "world/shading.h"
#include "world/spectrum.h"

/* Where a primitive's string arguments name its data, its picture. */
enum { BRIGHTDATA_FILE = 1, COLORDATA_FILE = 3, MIXDATA_FILE = 3, SPECDATA_FILE = 1 };

static const pm_asset *asset_of(const struct pm_shading *s, const struct pm_modifier *m,
                                unsigned string)
{
    return pm_assets_at(s->world->assets, m->assets[string]);
}

static bool evaluate_expressions(struct pm_shading *s, const struct pm_modifier *m,
                                 double *values)
{
    return pm_shading_evaluate(s, m, m->expressions, NULL, 0, values);
}

/* A function with one result, of `count` arguments. */
static bool evaluate_function(struct pm_shading *s, const struct pm_modifier *m,
                              const double *args, unsigned count, double *value)
{
    return pm_shading_evaluate(s, m, m->functions, args, count, value);
}

/* What is too large for a number is a fault too. */
static void multiply(struct pm_shading *s, double r, double g, double b)
{
    pm_rgb product = pm_rgb_mul(s->color, (pm_rgb){r, g, b});
    if (pm_rgb_finite(product))
        s->color = product;
}

static void perturb(struct pm_shading *s, const struct pm_modifier *m, const double v[3])
{
    pm_vec3 moved = pm_shading_to_world(s, m, (pm_vec3){v[0], v[1], v[2]});
    pm_vec3 sum = pm_vec3_add(s->perturbation, moved);
    if (pm_vec3_finite(sum))
        s->perturbation = sum;
}

/* ---- functions ---- */

static void apply_brightfunc(struct pm_shading *s, const struct pm_modifier *m)
{
    double v;
    if (evaluate_expressions(s, m, &v))
        multiply(s, v, v, v);
}

static void apply_colorfunc(struct pm_shading *s, const struct pm_modifier *m)
{
    double v[3];
    if (evaluate_expressions(s, m, v))
        multiply(s, v[0], v[1], v[2]);
}

static void apply_texfunc(struct pm_shading *s, const struct pm_modifier *m)
{
    double v[3];
    if (evaluate_expressions(s, m, v))
        perturb(s, m, v);
}

/* ---- data ---- */

static void apply_brightdata(struct pm_shading *s, const struct pm_modifier *m)
{
    double at[PM_LANGUAGE_TEXTS], v;
    if (!evaluate_expressions(s, m, at))
        return;
    double found = pm_data_value(asset_of(s, m, BRIGHTDATA_FILE)->data, at);
    if (evaluate_function(s, m, &found, 1, &v))
        multiply(s, v, v, v);
}

/* The values of three data files at the primitive's coordinates. */
static bool look_up_three(struct pm_shading *s, const struct pm_modifier *m, double found[3])
{
    double at[PM_LANGUAGE_TEXTS];
    if (!evaluate_expressions(s, m, at))
        return false;
    for (unsigned i = 0; i < 3; i++)
        found[i] = pm_data_value(asset_of(s, m, COLORDATA_FILE + i)->data, at);
    return true;
}

/* Three functions of three values; lone ones are asked again with their own value first. */
static bool evaluate_color(struct pm_shading *s, const struct pm_modifier *m,
                           const double found[3], double v[3])
{
    if (!pm_shading_evaluate(s, m, m->functions, found, 3, v))
        return false;
    for (unsigned i = 1; i < 3; i++) {
        double own[3] = {found[i], 0, 0}, values[3];
        if (!(m->lone_functions >> i & 1))
            continue;
        if (!pm_shading_evaluate(s, m, m->functions, own, 3, values))
            return false;
        v[i] = values[i];
    }
    return true;
}

static void apply_colordata(struct pm_shading *s, const struct pm_modifier *m)
{
    double found[3], v[3];
    if (look_up_three(s, m, found) && evaluate_color(s, m, found, v))
        multiply(s, v[0], v[1], v[2]);
}

static void apply_texdata(struct pm_shading *s, const struct pm_modifier *m)
{
    double found[3], v[3];
    if (look_up_three(s, m, found) && pm_shading_evaluate(s, m, m->functions, found, 3, v))
        perturb(s, m, v);
}

/* The picture's colour at the primitive's u and v. */
static bool look_up_picture(struct pm_shading *s, const struct pm_modifier *m, double found[3])
{
    double at[2];
    if (!evaluate_expressions(s, m, at))
        return false;
    pm_rgb c = pm_picture_value(asset_of(s, m, COLORDATA_FILE)->picture, at[0], at[1]);
    found[0] = c.r;
    found[1] = c.g;
    found[2] = c.b;
    return true;
}

static void apply_colorpict(struct pm_shading *s, const struct pm_modifier *m)
{
    double found[3], v[3];
    if (look_up_picture(s, m, found) && evaluate_color(s, m, found, v))
        multiply(s, v[0], v[1], v[2]);
}

/* ---- spectra ---- */

static void multiply_spectrum(struct pm_shading *s, const struct pm_spectrum *spectrum)
{
    pm_rgb c = pm_spectrum_rgb(spectrum);
    multiply(s, c.r, c.g, c.b);
}

static void apply_specfunc(struct pm_shading *s, const struct pm_modifier *m)
{
    struct pm_spectrum spectrum;
    if (!pm_spectrum_of_range(&spectrum, m->reals[0], m->reals[1]))
        return;
    for (unsigned i = 0; i < spectrum.count; i++) {
        double nm = pm_spectrum_wavelength(&spectrum, i);
        if (!evaluate_function(s, m, &nm, 1, &spectrum.value[i]))
            return;
    }
    multiply_spectrum(s, &spectrum);
}

/* The function gets each value and its wavelength. */
static void apply_specdata(struct pm_shading *s, const struct pm_modifier *m)
{
    const pm_data *data = asset_of(s, m, SPECDATA_FILE)->data;
    double at[PM_LANGUAGE_TEXTS];
    unsigned last = pm_data_dimensions(data) - 1;
    if (!evaluate_expressions(s, m, at))
        return;
    struct pm_spectrum spectrum;
    pm_spectrum_of_axis(&spectrum, pm_data_axis_of(data, last));
    for (unsigned i = 0; i < spectrum.count; i++) {
        at[last] = pm_spectrum_wavelength(&spectrum, i);
        double args[2] = {pm_data_value(data, at), at[last]};
        if (!evaluate_function(s, m, args, 2, &spectrum.value[i]))
            return;
    }
    multiply_spectrum(s, &spectrum);
}

static void apply_specpict(struct pm_shading *s, const struct pm_modifier *m)
{
    const pm_picture *picture = asset_of(s, m, SPECDATA_FILE)->picture;
    double at[2], found[PM_PICTURE_BANDS], nm0 = 0, nm1 = 0;
    if (!evaluate_expressions(s, m, at))
        return;
    struct pm_spectrum spectrum = {.count = pm_picture_bands(picture, &nm0, &nm1)};
    spectrum.step = (nm1 - nm0) / spectrum.count;
    spectrum.first = nm0 + 0.5 * spectrum.step;
    pm_picture_spectrum(picture, at[0], at[1], found);
    for (unsigned i = 0; i < spectrum.count; i++) {
        double args[2] = {found[i], pm_spectrum_wavelength(&spectrum, i)};
        if (!evaluate_function(s, m, args, 2, &spectrum.value[i]))
            return;
    }
    multiply_spectrum(s, &spectrum);
}

/* ---- text ---- */

static bool is_ink(const struct pm_shading *s, const struct pm_modifier *m)
{
    const struct pm_ink *ink = m->ink;
    if (s->far)
        return false;
    pm_vec3 p = pm_world_to_scene(s->world, s->hit->point);
    if (s->in_instance)
        p = pm_transform_point(&s->to_instance, p);
    pm_vec3 v = pm_vec3_sub(p, ink->anchor);
    return pm_text_holds(ink->text, pm_vec3_dot(v, ink->right), pm_vec3_dot(v, ink->down));
}

static void apply_brighttext(struct pm_shading *s, const struct pm_modifier *m)
{
    double v = m->reals[is_ink(s, m) ? 9 : 10];
    multiply(s, v, v, v);
}

static void apply_colortext(struct pm_shading *s, const struct pm_modifier *m)
{
    const double *v = &m->reals[is_ink(s, m) ? 9 : 12];
    multiply(s, v[0], v[1], v[2]);
}

/* ---- mixtures ---- */

static bool mixdata_value(struct pm_shading *s, const struct pm_modifier *m, double *v)
{
    double at[PM_LANGUAGE_TEXTS];
    if (!evaluate_expressions(s, m, at))
        return false;
    double found = pm_data_value(asset_of(s, m, MIXDATA_FILE)->data, at);
    return evaluate_function(s, m, &found, 1, v);
}

static bool mixpict_value(struct pm_shading *s, const struct pm_modifier *m, double *v)
{
    double found[3];
    return look_up_picture(s, m, found) && evaluate_function(s, m, found, 3, v);
}

static bool find_share(struct pm_shading *s, const struct pm_modifier *m, double *share)
{
    double v = 0;
    bool known = true;
    switch (m->type) {
    case PM_MIXFUNC:
        known = evaluate_expressions(s, m, &v);
        break;
    case PM_MIXDATA:
        known = mixdata_value(s, m, &v);
        break;
    case PM_MIXPICT:
        known = mixpict_value(s, m, &v);
        break;
    default:
        v = is_ink(s, m);
    }
    *share = v > 0 ? (v < 1 ? v : 1) : 0;
    return known;
}

bool pm_mixture_share(const struct pm_material *mixture, struct pm_shading *s, double *share)
{
    return find_share(s, &mixture->modifier, share);
}

static void apply_list(const struct pm_texture *texture, struct pm_shading *s);

/* Each side works on what came before; raymixture weighs what they make of it. */
static void apply_mixture(const struct pm_texture *texture, struct pm_shading *s)
{
    double share;
    if (!find_share(s, &texture->modifier, &share))
        return;
    const pm_rgb color = s->color;
    const pm_vec3 perturbation = s->perturbation;
    apply_list(share > 0 ? texture->components[0] : NULL, s);
    const pm_rgb fore_color = s->color;
    const pm_vec3 fore = s->perturbation;
    s->color = color;
    s->perturbation = perturbation;
    apply_list(share < 1 ? texture->components[1] : NULL, s);
    s->color = pm_rgb_madd(pm_rgb_scale(fore_color, share), 1 - share, s->color);
    s->perturbation = pm_vec3_madd(pm_vec3_scale(fore, share), 1 - share, s->perturbation);
}

/* ---- all ---- */

static void apply(const struct pm_texture *texture, struct pm_shading *s)
{
    const struct pm_modifier *m = &texture->modifier;
    switch (m->type) {
    case PM_TEXFUNC:
        apply_texfunc(s, m);
        break;
    case PM_TEXDATA:
        apply_texdata(s, m);
        break;
    case PM_COLORFUNC:
        apply_colorfunc(s, m);
        break;
    case PM_BRIGHTFUNC:
        apply_brightfunc(s, m);
        break;
    case PM_COLORDATA:
        apply_colordata(s, m);
        break;
    case PM_BRIGHTDATA:
        apply_brightdata(s, m);
        break;
    case PM_COLORPICT:
        apply_colorpict(s, m);
        break;
    case PM_COLORTEXT:
        apply_colortext(s, m);
        break;
    case PM_BRIGHTTEXT:
        apply_brighttext(s, m);
        break;
    case PM_SPECTRUM:
    case PM_SPECFILE:
        multiply(s, m->color.r, m->color.g, m->color.b);
        break;
    case PM_SPECFUNC:
        apply_specfunc(s, m);
        break;
    case PM_SPECDATA:
        apply_specdata(s, m);
        break;
    case PM_SPECPICT:
        apply_specpict(s, m);
        break;
    default:
        apply_mixture(texture, s);
    }
}

/* Recursion, into mixtures, is bounded by PM_MODIFIERS_MAX. */
static void apply_list(const struct pm_texture *texture, struct pm_shading *s)
{
    for (; texture; texture = texture->next)
        apply(texture, s);
}

void pm_textures_apply(const struct pm_material *material, struct pm_shading *s)
{
    apply_list(material->textures, s);
}

/* ---- patterns that are the same everywhere ---- */

static bool uses_nothing(const pm_world *world, pm_function function)
{
    return function == PM_NO_FUNCTION ||
           !pm_function_uses(pm_assets_language(world->assets), function);
}

static bool is_constant(const pm_world *world, const struct pm_modifier *m)
{
    return !m->ink && uses_nothing(world, m->expressions) && uses_nothing(world, m->functions);
}

static bool is_texture(pm_primitive_type type)
{
    return type == PM_TEXFUNC || type == PM_TEXDATA;
}

/* Whether it can change the colour. Recursion, into mixtures, is bounded by PM_MODIFIERS_MAX.
 */
static bool is_pattern(const struct pm_texture *texture)
{
    if (!pm_primitive_is_mixture(texture->modifier.type))
        return !is_texture(texture->modifier.type);
    for (int i = 0; i < 2; i++)
        for (const struct pm_texture *t = texture->components[i]; t; t = t->next)
            if (is_pattern(t))
                return true;
    return false;
}

static bool is_list_constant(const pm_world *world, const struct pm_texture *t)
{
    for (; t; t = t->next)
        if (is_pattern(t) &&
            !(is_constant(world, &t->modifier) && is_list_constant(world, t->components[0]) &&
              is_list_constant(world, t->components[1])))
            return false;
    return true;
}

bool pm_textures_constant_color(const pm_world *world, const struct pm_material *material,
                                pm_rgb *color)
{
    if (!is_list_constant(world, material->textures))
        return false;
    pm_hit hit;
    struct pm_shading shading;
    pm_shading_init_far(&shading, world, &hit, (pm_vec3){0, 0, 1});
    pm_textures_apply(material, &shading);
    *color = shading.color;
    return true;
}
