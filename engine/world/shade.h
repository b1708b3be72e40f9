#ifndef PM_WORLD_SHADE_H
#define PM_WORLD_SHADE_H

#include "world/lobe.h"
#include "world/material.h"
#include "world/shading.h"

/* One material at one hit on its way to a list of lobes: what shade.c prepares, models.c
 * fills. */
struct shade {
    const struct pm_material *material;
    struct pm_shading *shading; /* textures applied; NULL if nothing asks for one */
    pm_vec3 normal;             /* perturbed, on wo's side, facing wo */
    pm_vec3 shift;              /* the perturbation as seen from wo's side */
    double cosine;              /* between wo and that normal, 0 .. 1 */
    double share;               /* of a mixture */
    bool tilted;                /* the normal is perturbed */
    bool front;
    bool hidden; /* the back of what can be seen from the front alone, */
    bool lit;    /* that a photon comes to */
    bool seen;   /* by the eye: straight passage shows the perturbation */
    bool shadow; /* by a ray that looks for light */
    pm_surface *out;
};

/* A colour times the patterns', in 0..1. */
static inline pm_rgb pm_shade_color(const struct shade *s, pm_rgb base)
{
    return s->shading ? pm_shading_reflectance(s->shading, base) : base;
}

/* Appends a lobe of the perturbed normal, scaled to the material's share; NULL if black. */
static inline pm_lobe *pm_shade_add(struct shade *s, pm_lobe_kind kind, pm_event event,
                                    unsigned side, pm_rgb albedo)
{
    if (s->share != 1)
        albedo = pm_rgb_scale(albedo, s->share);
    pm_lobe *lobe = pm_lobe_add(s->out, kind, event, side, albedo);
    if (lobe && s->tilted) {
        lobe->normal = s->normal;
        lobe->tilted = true;
    }
    return lobe;
}

static inline void pm_shade_diffuse(struct shade *s, unsigned side, pm_rgb albedo, pm_coat coat)
{
    pm_lobe *lobe = pm_shade_add(s, PM_LOBE_DIFFUSE, PM_EVENT_DIFFUSE, side, albedo);
    if (lobe)
        lobe->coat = coat;
}

static inline void pm_shade_direction(struct shade *s, pm_event event, unsigned side,
                                      pm_rgb albedo, pm_vec3 wi)
{
    pm_lobe *lobe = pm_shade_add(s, PM_LOBE_DIRECTION, event, side, albedo);
    if (!lobe)
        return;
    lobe->u.direction.wi = wi;
    lobe->u.direction.radiance_scale = 1;
}

/* Mirror reflection about the perturbed normal. */
static inline void pm_shade_mirror(struct shade *s, pm_rgb albedo)
{
    pm_shade_add(s, PM_LOBE_MIRROR, PM_EVENT_SPECULAR, PM_SIDE_NEAR, albedo);
}

/* ---- shade.c ---- */

/* Passage straight on; seen by the eye, along -wo - strength * shift (normal.c, glass.c). Other
 * walks and shadow rays ignore the perturbation, as in Radiance, and so agree. */
void pm_shade_straight(struct shade *s, pm_rgb albedo, double strength);

/* ---- models.c ---- */

/* Appends the lobes of s->material, which is neither a mixture nor an illum. */
void pm_shade_model(struct shade *s);

#endif
