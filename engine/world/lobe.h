#ifndef PM_WORLD_LOBE_H
#define PM_WORLD_LOBE_H

#include "world/surface.h"

/* One lobe of a surface: what surface.c adds up and chooses from. */

/* Begins a surface without lobes; `normal` on wo's side. */
static inline void pm_surface_begin(pm_surface *surface, pm_vec3 normal, pm_vec3 wo)
{
    surface->normal = normal;
    surface->wo = wo;
    surface->count = surface->events = surface->function_count = surface->bsdf_count = 0;
    surface->skip = 0;
}

/* Appends a lobe of the surface's own normal, unless `albedo` is black: then NULL. Its
 * parameters are the caller's to fill in. No more than PM_LOBES_MAX: materials that would make
 * more are refused (material.c). */
static inline pm_lobe *pm_lobe_add(pm_surface *surface, pm_lobe_kind kind, pm_event event,
                                   unsigned sides, pm_rgb albedo)
{
    if (pm_rgb_is_black(albedo) || surface->count == PM_LOBES_MAX)
        return NULL;
    pm_lobe *lobe = &surface->lobes[surface->count++];
    surface->events |= 1U << event;
    lobe->kind = kind;
    lobe->event = event;
    lobe->sides = sides & 3;
    lobe->coat = PM_COAT_NONE;
    lobe->tilted = false;
    lobe->albedo = albedo;
    lobe->normal = surface->normal;
    return lobe;
}

/* Where a delta lobe points. A mirror whose tilted normal would send light below the surface
 * reflects about the surface's own (Radiance's normal.c). */
pm_vec3 pm_lobe_direction(const pm_surface *surface, const pm_lobe *lobe);

/* f(wi, wo) |cos wi|; black for delta lobes. */
pm_rgb pm_lobe_value(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi);

/* f(wi, wo) of a diffuse lobe without the cosine, for photons. */
pm_rgb pm_lobe_photon_weight(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi);

/* Density [1/sr] of pm_lobe_sample; 0 for delta lobes. */
double pm_lobe_pdf(const pm_surface *surface, const pm_lobe *lobe, pm_vec3 wi);

/* Draws a direction and its weight from one lobe; pdf is left alone. PM_EVENT_NONE where it
 * falls on the wrong side. */
void pm_lobe_sample(const pm_surface *surface, const pm_lobe *lobe, double u, double v,
                    pm_scatter *out);

#endif
