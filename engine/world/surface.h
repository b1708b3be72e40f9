#ifndef PM_WORLD_SURFACE_H
#define PM_WORLD_SURFACE_H

#include "base/rgb.h"
#include "world/media.h"
#include "world/world.h"

/* How a material scatters light at a hit.
 *
 * `wo` and `wi` point away from the surface: wo to where the walk comes from, wi to where it
 * goes on. The models are reciprocal: forward and backward walks use the same weights, but that
 * refraction scales radiance (not flux) by the square of the indices' ratio, as in Radiance's
 * dielectric.c: a backward walk multiplies by pm_scatter.radiance_scale. */

typedef enum pm_lobe {
    PM_LOBE_NONE,     /* absorbed */
    PM_LOBE_DIFFUSE,  /* Lambertian reflection or transmission */
    PM_LOBE_GLOSSY,   /* rough specular reflection or transmission: finite pdf, an S event */
    PM_LOBE_SPECULAR, /* delta reflection or refraction: an S event */
    PM_LOBE_STRAIGHT, /* straight passage: no event at all */
} pm_lobe;

/* The material evaluated at one hit for one wo. */
typedef struct pm_surface {
    pm_vec3 normal; /* unit, on wo's side */
    pm_vec3 wo;
    pm_rgb diffuse_reflectance; /* Lambertian albedos */
    pm_rgb diffuse_transmittance;
    pm_rgb specular_reflectance;   /* of the mirror direction, or of the Ward lobe */
    pm_rgb specular_transmittance; /* of refracted_wi, or of a lobe about it */
    pm_rgb straight_transmittance; /* thin glass, smooth trans, antimatter, mist, illum void */
    double roughness;              /* Ward's alpha; 0: the specular parts are deltas */
    pm_vec3 refracted_wi;          /* unit */
    double radiance_scale;         /* see pm_scatter */
    bool fresnel; /* the diffuse parts carry 1 - F(cos wi) (smooth plastic, metal, trans; see
                     pm_surface_diffuse): a density estimate weighs each photon by it */
} pm_surface;

typedef struct pm_scatter {
    pm_lobe lobe;
    bool transmitted; /* the walk goes through the surface: cross media */
    pm_vec3 wi;       /* unit */
    pm_rgb weight;    /* f |cos wi| / pdf: what the throughput is multiplied by */
    double pdf;       /* [1/sr] of wi among the finite lobes together, for multiple importance
                         sampling; 0 for delta and straight lobes */
    double radiance_scale; /* (index on wo's side / on wi's side)^2; 1 but for refraction */
} pm_scatter;

/* The material of `hit` seen from wo by a walk that `media` hold, for photons and for bounces.
 * An illum is its alternate material here. A surface that an antimatter in `media` hides is
 * straight passage; the boundary of an antimatter within an object that it cuts is that
 * antimatter's first material (Radiance's m_clip.c). Emission is apart: light.h. */
void pm_surface_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo, const pm_media *media,
                   pm_surface *out);

/* The same for walks from the eye that met nothing but specular and straight events so far: a
 * mirror with an alternate material shows that one (Radiance's m_mirror.c). */
void pm_surface_seen_at(const pm_world *world, const pm_hit *hit, pm_vec3 wo,
                        const pm_media *media, pm_surface *out);

/* Finite lobes: f(wi, wo) |cos wi|; diffuse and glossy parts apart. Delta lobes give nothing.
 * The diffuse part is albedo / pi * |cos wi|, times 1 - F(|cos wi|) if `fresnel` is set. */
pm_rgb pm_surface_diffuse(const pm_surface *surface, pm_vec3 wi);
pm_rgb pm_surface_glossy(const pm_surface *surface, pm_vec3 wi);

/* Draws one lobe in proportion to its mean albedo weighted by `throughput`, then a direction
 * from it. u[0] picks the lobe, u[1] and u[2] the direction. PM_LOBE_NONE if all are black, or
 * if a rough lobe's direction falls on the wrong side. Never draws absorption: E[weight] is the
 * albedo, roulette is the caller's. */
void pm_surface_sample(const pm_surface *surface, pm_rgb throughput, const double u[3],
                       pm_scatter *out);

/* Draws from the non-diffuse lobes only (glossy, specular, straight), likewise. For the
 * backward walk, which gathers the diffuse part from the photon maps. */
void pm_surface_sample_specular(const pm_surface *surface, pm_rgb throughput, const double u[3],
                                pm_scatter *out);

/* Density of pm_surface_sample_specular for a glossy direction wi (0 if no glossy lobe). */
double pm_surface_glossy_pdf(const pm_surface *surface, pm_rgb throughput, pm_vec3 wi);

bool pm_surface_is_diffuse(const pm_surface *surface); /* has a diffuse part: stores photons */

#endif
