#ifndef PM_WORLD_BSDF_SURFACE_H
#define PM_WORLD_BSDF_SURFACE_H

#include <stdbool.h>

#include "files/bsdf.h"
#include "world/world.h"

struct pm_material;
struct pm_shading;

/* The materials BSDF and aBSDF (Radiance's m_bsdf.c, pmapmat.c): a distribution from a file on
 * a surface, turned by the material's `up` vector. Lambertian parts are diffuse lobes; the rest
 * is a lobe of finite density that walks follow, as in Radiance's photon map, and for aBSDF
 * what goes straight on is straight passage. Patterns multiply everything but the rest's
 * reflection.
 *
 * A BSDF with a thickness stands for geometry that the scene also holds, behind it (> 0) or
 * before it, seen from behind (< 0). Sight, shadow rays and whatever comes from the other side
 * pass through and meet that geometry; other walks (photons, and bounces after the first
 * scattering) are scattered here, and what is transmitted goes on beyond it. Radiance's photon
 * map forgets to let photons from the other side pass; here they do.
 *
 * Radiance searches the distribution with the direction of sight as `in`, photons with that of
 * the light; so does this: a file that is not reciprocal gives two answers there, too. */

/* A BSDF as it stands at one hit. */
typedef struct pm_bsdf_hit {
    const pm_bsdf *bsdf;
    pm_vec3 axis[3];   /* its x, y, z in the world */
    pm_vec3 in;        /* wo in them */
    pm_bsdf_peak peak; /* of an aBSDF; no cells: none */
} pm_bsdf_hit;

/* What leaves on wo's side [0] and on the other one [1]. */
struct pm_bsdf_shares {
    pm_rgb diffuse[2], rest[2]; /* albedos, with the material's reals and the patterns */
    pm_rgb gain[2];             /* the rest is this times pm_bsdf_hit_value */
    pm_rgb straight;
    double thickness; /* [world]: transmitted light goes on so far behind the surface */
    bool passes;      /* all light goes straight on: a proxy that does not show */
};

enum pm_bsdf_walk {
    PM_BSDF_WALK,   /* photons, and bounces */
    PM_BSDF_SEEN,   /* from the eye with nothing but specular and straight events so far */
    PM_BSDF_SHADOW, /* looks for light */
};

/*   normal  unit, perturbed, on wo's side
 *   front   whether wo is on the surface's front side
 * False if nothing is scattered: the orientation is no direction across the normal. */
bool pm_bsdf_hit_at(const struct pm_material *material, struct pm_shading *shading,
                    pm_vec3 normal, bool front, enum pm_bsdf_walk walk, pm_bsdf_hit *hit,
                    struct pm_bsdf_shares *shares);

/* The rest, without colours: f(wi, wo) [1/sr]; a direction on one side; its density [1/sr],
 * given the side. */
pm_rgb pm_bsdf_hit_value(const pm_bsdf_hit *hit, pm_vec3 wi);
bool pm_bsdf_hit_sample(const pm_bsdf_hit *hit, bool far, double u, double v, pm_vec3 *wi);
double pm_bsdf_hit_pdf(const pm_bsdf_hit *hit, pm_vec3 wi);

/* Sets what the material's surfaces can do: specular, diffuse, straight. */
void pm_bsdf_set_abilities(const pm_world *world, struct pm_material *material);

#endif
