#ifndef PM_WORLD_FRESNEL_H
#define PM_WORLD_FRESNEL_H

/* Reflectances of smooth interfaces. Cosines are those of the angle of incidence, in [0, 1]. */

/* Of unpolarised light at the interface of two dielectrics; 1 beyond the critical angle.
 *   ratio            index of the incident side / index of the other
 *   cosine_refracted out; 0 where nothing is refracted
 * Source: Fresnel's equations, e.g. Born and Wolf, Principles of Optics, 1.5.2, eqs. 21a and
 * 21b. */
double pm_fresnel_dielectric(double cosine, double ratio, double *cosine_refracted);

/* A pane: two parallel interfaces, the light between them reflected to and fro without end,
 * each polarisation for itself. Source: Radiance's glass.c. */
typedef struct pm_pane {
    double reflectance[2]; /* of one interface, by polarisation */
    double path;           /* length of the way through / thickness */
} pm_pane;

pm_pane pm_pane_at(double cosine, double index);

/* `transmissivity`: share that one crossing at normal incidence leaves, in [0, 1]. */
double pm_pane_reflectance(const pm_pane *pane, double transmissivity);
double pm_pane_transmittance(const pm_pane *pane, double transmissivity);

/* Radiance's estimate of how reflectance rises towards grazing: 1 at cosine 0, 0 at 1. Of
 * smooth plastic, metal and trans whose specularity reaches PM_FRESNEL_THRESHOLD. Source:
 * Radiance's normal.c, FRESNE and FRESTHRESH. */
#define PM_FRESNEL_THRESHOLD 0.017999
double pm_fresnel_estimate(double cosine);

/* (1 - cosine)^5: Schlick, "An inexpensive BRDF model for physically-based rendering",
 * Eurographics 1994, eq. 15, for a normal reflectance of 0. */
double pm_fresnel_schlick(double cosine);

#endif
