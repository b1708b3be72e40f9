/* What the textures and patterns of a scene need before they can be asked. */
#include <stdio.h>

#include "base/xyz.h"
#include "world/material.h"
#include "world/spectrum.h"

enum { TEXT_MAX = 1 << 22 }; /* bytes of all texts that a scene sets */

struct preparing {
    struct pm_modifier *modifier;
    pm_world *world;
    const pm_scene *scene;
    const pm_primitive *primitive;
    pm_error *err;
};

static pm_status refuse(const struct preparing *p, pm_status status, const char *what)
{
    const pm_primitive *q = p->primitive;
    return pm_error_set_at(p->err, status, p->scene->files[q->file], q->line, q->column,
                           "%s '%s' %s", pm_primitive_type_name(q->type), q->name, what);
}

/* ---- text ---- */

/* Which string names the font (the text follows), and how many reals come before the spacing.
 */
static void text_arguments(pm_primitive_type type, uint32_t *font, uint32_t *spacing)
{
    *font = type == PM_MIXTEXT ? 2 : 0;
    *spacing = type == PM_MIXTEXT ? 9 : type == PM_BRIGHTTEXT ? 11 : 15;
}

/* right and down are not orthogonal in general, so each is measured across the other: right is
 * in the plane of both, orthogonal to the motion `down`, and right . (motion right) = 1
 * (gettext in Radiance's text.c). */
static bool set_ink_vectors(struct pm_ink *ink, const double *reals)
{
    pm_vec3 right = {reals[3], reals[4], reals[5]}, down = {reals[6], reals[7], reals[8]};
    pm_vec3 normal = pm_vec3_cross(down, right);
    pm_vec3 across = pm_vec3_cross(normal, down), along = pm_vec3_cross(right, normal);
    double across2 = pm_vec3_dot(across, across), along2 = pm_vec3_dot(along, along);
    if (!(across2 > 1e-24) || !(along2 > 1e-24))
        return false;
    ink->anchor = (pm_vec3){reals[0], reals[1], reals[2]};
    ink->right = pm_vec3_scale(across, pm_vec3_dot(down, down) / across2);
    ink->down = pm_vec3_scale(along, pm_vec3_dot(right, right) / along2);
    return pm_vec3_finite(ink->right) && pm_vec3_finite(ink->down);
}

static pm_status prepare_ink(const struct preparing *p)
{
    uint32_t font, spacing;
    const struct pm_modifier *m = p->modifier;
    struct pm_ink *ink = pm_arena_alloc(&p->world->arena, sizeof *ink);
    if (!ink)
        return refuse(p, PM_E_MEMORY, "finds no memory");
    text_arguments(m->type, &font, &spacing);
    if (!set_ink_vectors(ink, m->reals))
        return refuse(p, PM_E_RANGE,
                      "has its vectors to the right and down parallel, or too short");
    const pm_asset *words = pm_assets_at(p->world->assets, m->assets[font + 1]);
    p->world->text_size += words->text.size;
    if (p->world->text_size > TEXT_MAX)
        return refuse(p, PM_E_LIMIT, "brings the scene's texts to more than 4 MiB");
    pm_error why = PM_ERROR_INIT;
    if (pm_text_new(pm_assets_at(p->world->assets, m->assets[font])->font, words->text.bytes,
                    words->text.size, m->real_count > spacing ? &m->reals[spacing] : NULL,
                    &p->world->arena, &ink->text, &why)) {
        char text[sizeof why.text + 32];
        snprintf(text, sizeof text, "cannot be set: %s", why.text);
        return refuse(p, why.status, text);
    }
    p->modifier->ink = ink;
    return PM_OK;
}

/* ---- spectra ---- */

/* reals: the outer samples' wavelengths, then the samples (p_spectrum in Radiance's p_data.c).
 */
static pm_status prepare_spectrum(const struct preparing *p)
{
    const double *reals = p->modifier->reals;
    uint32_t count = p->modifier->real_count - 2;
    double half = 0.5 * (reals[1] - reals[0]) / (count - 1);
    if (half == 0)
        return refuse(p, PM_E_RANGE, "has its first wavelength equal to its last");
    p->modifier->color = pm_rgb_of_spectrum(reals + 2, count, reals[0] - half, reals[1] + half);
    return PM_OK;
}

static void prepare_specfile(const struct preparing *p)
{
    const pm_data *data = pm_assets_at(p->world->assets, p->modifier->assets[0])->data;
    struct pm_spectrum spectrum;
    pm_spectrum_of_axis(&spectrum, pm_data_axis_of(data, 0));
    for (unsigned i = 0; i < spectrum.count; i++) {
        double nm = pm_spectrum_wavelength(&spectrum, i);
        spectrum.value[i] = pm_data_value(data, &nm);
    }
    p->modifier->color = pm_spectrum_rgb(&spectrum);
}

pm_status pm_modifier_prepare(struct pm_modifier *modifier, pm_world *world,
                              const pm_scene *scene, const pm_primitive *primitive,
                              pm_error *err)
{
    const struct preparing p = {modifier, world, scene, primitive, err};
    modifier->inverse = pm_transform_inverse(&modifier->transform);
    switch (modifier->type) {
    case PM_COLORTEXT:
    case PM_BRIGHTTEXT:
    case PM_MIXTEXT:
        return prepare_ink(&p);
    case PM_SPECTRUM:
        return prepare_spectrum(&p);
    case PM_SPECFILE:
        prepare_specfile(&p);
        return PM_OK;
    default:
        return PM_OK;
    }
}
