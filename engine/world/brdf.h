#ifndef PM_WORLD_BRDF_H
#define PM_WORLD_BRDF_H

#include "base/error.h"
#include "language/language.h"
#include "world/world.h"

/* Scattering by functions and data that the scene defines: plasfunc, metfunc, transfunc,
 * BRTDfunc, plasdata, metdata, transdata (Radiance's m_brdf.c).
 *
 * A function may say anything, so two things are learnt from it when the world is made, at the
 * middles of some of the surfaces that have the material: how much it scatters from each
 * direction, and where to. The first keeps energy from growing: a direction whose share would
 * exceed 1 is scaled down to 1 (Radiance takes it as it is). The second steers sampling, which
 * also covers whatever was not found there, so nothing is ever missed. */

struct pm_material;
struct pm_shading;

/* The function as it stands at one hit. */
typedef struct pm_brdf {
    const pm_world *world;
    const struct pm_material *material;
    pm_vec3 axis[3]; /* unit vectors of the function's coordinates, in the world */
    struct pm_ray_values ray;
} pm_brdf;

/*   normal  unit, perturbed, on wo's side
 *   turned  the surface's normal is turned to wo's side for the function too (all but BRTDfunc)
 *   color   of the patterns, with the material's own */
void pm_brdf_at(const struct pm_material *material, struct pm_shading *shading, pm_vec3 normal,
                bool turned, pm_rgb color, pm_brdf *out);

/* f(wi, wo) without the material's colours and shares, nothing negative; black where the
 * function meets a fault. */
pm_rgb pm_brdf_value(const pm_brdf *brdf, pm_vec3 wi);

struct pm_brdf_table;

/* The share of light from wo that the function scatters to one side: a guess for wo, between
 * what the tables say. `front` tells on which side of the surface wo lies. */
pm_rgb pm_brdf_albedo(const pm_brdf *brdf, pm_vec3 normal, pm_vec3 wo, bool front, bool far);

/* A direction on one side and its density [1/sr]. */
pm_vec3 pm_brdf_sample(const pm_brdf *brdf, pm_vec3 normal, pm_vec3 wo, bool front, bool far,
                       double u, double v);
double pm_brdf_pdf(const pm_brdf *brdf, pm_vec3 normal, pm_vec3 wo, bool front, bool far,
                   pm_vec3 wi);

/* Makes the tables of all such materials; shapes are complete. Errors: PM_E_MEMORY. */
PM_MUST_USE pm_status pm_brdf_tables_build(pm_world *world, pm_error *err);

static inline bool pm_brdf_is(pm_primitive_type type)
{
    return type >= PM_PLASFUNC && type <= PM_TRANSDATA;
}

#endif
