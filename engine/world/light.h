#ifndef PM_WORLD_LIGHT_H
#define PM_WORLD_LIGHT_H

#include "base/rgb.h"
#include "world/world.h"

/* Lights: every surface of the main scene and every distant source whose material emits (light,
 * glow of radius >= 0, spotlight, illum). A glow of negative radius, a lamp in an instance and
 * one that a mixture shows are seen but light nothing, as in Radiance (marksources in
 * source.c).
 *
 * Radiance is the material's colour times its patterns, wherever it is asked for; negative
 * parts are 0. A pattern sees the ray that looks at the lamp: D runs towards it, P lies on it,
 * Ts is the distance; of a distant source it sees the direction alone, P being 0. A photon's
 * pattern is that seen from afar, Ts being the diameter of the scene.
 *
 * An illum may show a lamp (its alternate): that is seen, and lights nothing either.
 *
 * An illum stands for all light that leaves through its front, but for light that comes
 * straight from a light or spotlight (Radiance's illumblock and badcomponent in source.c). So
 * weak light, from a glow or an illum or after any event, ends where it would leave an illum
 * through its front: forward walks and gather rays ask pm_light_stands_in, shadow rays tell
 * pm_world_transmittance. */

/* A photon leaving a light. */
typedef struct pm_emission {
    pm_vec3 origin, direction;
    pm_vec3 normal; /* of the lamp there; a distant source has none */
    uint32_t light; /* its number among the lights */
    uint32_t from;  /* surface; PM_NO_PRIMITIVE: a distant source, origin outside the scene */
    pm_rgb flux;    /* total / pdf [W / scale^2]: mean over u = total emitted power */
    double focus;   /* of a spotlight; 0 otherwise */
    bool weak;      /* from a glow or an illum */
} pm_emission;

/* The share of the flux that arrives at `distance` from the origin (straight passages counted
 * in). 1 but for spotlights: Radiance lets their light fall off as if from `focus` behind the
 * lamp (srcray in source.c), which for wide cones no conserved light does: (d / (d + focus))^2
 * of the far field's. */
double pm_emission_share(const pm_emission *emission, double distance);

/* u[0] picks the light in proportion to its power, u[1..2] the place, u[3..4] the direction.
 * Distant sources emit onto the disc that the scene's bounding sphere shows them.
 * Patterned lights send photons where they are bright (light_pattern.h), with their exact
 * weights. False if the world has no light that emits. Tests: emission_sums_to_power,
 * photons_from_skies_carry_their_integral. */
bool pm_light_emit(const pm_world *world, const double u[5], pm_emission *out);

/* Power of all lights [W / scale^2]; of patterned ones by quadrature, which steers the choice
 * of lights and biases nothing. */
pm_rgb pm_light_total_power(const pm_world *world);

/* One next-event sample. */
typedef struct pm_light_sample {
    pm_vec3 wi;       /* from the point to the light, unit */
    double distance;  /* to just before the light's surface; INFINITY for distant sources */
    pm_rgb radiance;  /* that the light sends to the point if nothing stands between */
    double pdf;       /* [1/sr], choice of the light included */
    uint32_t surface; /* the light's surface, or PM_NO_PRIMITIVE */
    bool weak;        /* a glow or an illum: for pm_world_transmittance */
    bool hidden;      /* an illum, which no bounce can hit: its weight is 1 */
} pm_light_sample;

/* Draws a light and a point on it as seen from `point`. u[0] picks the light, u[1..2] the
 * place. False if the sample brings nothing (light faces away, outside a spotlight's cone, no
 * lights). The estimate of direct light is radiance * transmittance * f cos / pdf. Small solid
 * angles are sampled without cancellation. Test: next_event_equals_quadrature. */
bool pm_light_sample_at(const pm_world *world, pm_vec3 point, const double u[3],
                        pm_light_sample *out);

/* Density [1/sr] with which pm_light_sample_at(point) draws the direction that hit `hit`
 * (a surface); 0 if it is no light. */
double pm_light_pdf_surface(const pm_world *world, pm_vec3 point, pm_vec3 wi,
                            const pm_hit *hit);

/* Radiance that the surface at `hit` emits towards wo into a point at distance hit->t; black
 * for surfaces that light nothing, and for an illum (which is seen as its alternate material).
 */
pm_rgb pm_light_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo);

/* The same for walks from the eye that met nothing but specular and straight events so far:
 * glows of negative radius show here alone, and spotlights show their full radiance, as in
 * Radiance. */
pm_rgb pm_light_seen_radiance(const pm_world *world, const pm_hit *hit, pm_vec3 wo);
pm_rgb pm_light_seen_distant(const pm_world *world, pm_vec3 direction);

/* True if light that travels along `direction` would leave an illum through its front at the
 * hit. */
bool pm_light_stands_in(const pm_world *world, const pm_hit *hit, pm_vec3 direction);

/* Radiance of the distant sources in a direction that leaves the scene, and the density [1/sr]
 * with which pm_light_sample_at draws that direction there. Where sources overlap, lights add
 * up, and a glow shows only where there is no light (as in Radiance, which takes the first of
 * the lights: here order in the file counts for nothing). */
pm_rgb pm_light_distant(const pm_world *world, pm_vec3 direction, double *pdf);

#endif
