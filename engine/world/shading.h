#ifndef PM_WORLD_SHADING_H
#define PM_WORLD_SHADING_H

#include <stdbool.h>

#include "base/rgb.h"
#include "base/vec3.h"
#include "language/language.h"
#include "scene/transform.h"
#include "world/world.h"

/* What textures and patterns make of one point of a surface, or of one direction of a distant
 * source, for one direction of sight.
 *
 * In: a hit, a material's list of textures. Out: the product of its patterns and the sum of its
 * textures, which surface.c, light.c and transmit.c apply to what the material says. Nothing of
 * this is touched for a material without textures.
 *
 * The rules are Radiance's (rayshade, raytexture, raymixture and raynormal in
 * src/rt/raytrace.c): patterns multiply, textures add up, a mixture of both weighs its two
 * sides, and one whose function meets a fault (a division by zero, a root of a negative number)
 * changes nothing there. */

struct pm_modifier;
struct pm_texture;
struct pm_material;

struct pm_shading {
    const pm_world *world;
    const pm_hit *hit;
    pm_vec3 wo;      /* unit, away from the surface; Radiance's ray comes along -wo */
    double distance; /* T: of the path from its start [world] */
    double segment;  /* Ts: of this ray alone [world] */
    bool far;        /* a distant source: no point, Px Py Pz are 0, the normal is wo */

    pm_rgb color;         /* product of the patterns; may be negative or above 1 */
    pm_vec3 perturbation; /* sum of the textures, added to the unit normal hit->normal */

    /* Between the coordinates of the instances that the surface belongs to and the scene's. */
    bool in_instance;
    pm_transform from_instance, to_instance;

    /* The values of the ray in the coordinates of `frame`, filled when a function first asks.
     */
    const struct pm_modifier *frame;
    struct pm_ray_values ray;
};

/* Nothing applied yet: colour 1, and the perturbation that smooth normals bring.
 *   distance  of the path from its start [world], hit->t included */
void pm_shading_init(struct pm_shading *shading, const pm_world *world, const pm_hit *hit,
                     pm_vec3 wo, double distance);

/* The same for a distant source seen along -wo; `hit` is storage that the shading borrows. */
void pm_shading_init_far(struct pm_shading *shading, const pm_world *world, pm_hit *hit,
                         pm_vec3 wo);

/* Applies the material's textures and patterns. Tests: test_texture.c. */
void pm_textures_apply(const struct pm_material *material, struct pm_shading *shading);

/* The product of the material's patterns if they are the same everywhere; false if one may vary.
 * For media, which absorb alike everywhere. */
bool pm_textures_constant_color(const pm_world *world, const struct pm_material *material,
                                pm_rgb *color);

/* The share of the foreground of a mixture of materials, 0..1; false if its function met a
 * fault: then the mixture is not there, as in Radiance, and light passes straight. */
bool pm_mixture_share(const struct pm_material *mixture, struct pm_shading *shading,
                      double *share);

/* The perturbed unit normal on the side of hit->normal, turned where it would lie on the other
 * side of wo than hit->normal does (raynormal). hit->normal if there is no perturbation. */
pm_vec3 pm_shading_normal(const struct pm_shading *shading);

/* base times the patterns' colour: for what a surface sends on of the light that it gets. Each
 * part is kept in 0..1. Radiance lets patterns raise it above 1; here energy must not grow, so
 * it is cut there, and `scene check` warns. Test: patterns_do_not_make_energy. */
pm_rgb pm_shading_reflectance(const struct pm_shading *shading, pm_rgb base);

/* base times the patterns' colour, negative parts 0: for what a lamp sends out. */
pm_rgb pm_shading_radiance(const struct pm_shading *shading, pm_rgb base);

/* ---- for materials that are functions themselves ---- */

/* The values of the ray in the modifier's own coordinates; the perturbed ones are not set.
 * Valid until another modifier asks. */
struct pm_ray_values *pm_shading_ray(struct pm_shading *shading,
                                     const struct pm_modifier *modifier);

/* All results of a function of the modifier (pm_function_values); false after a fault. */
bool pm_shading_evaluate(struct pm_shading *shading, const struct pm_modifier *modifier,
                         pm_function function, const double *args, unsigned arg_count,
                         double *values);

/* A direction from the modifier's own coordinates to the world's and back; lengths stay. */
pm_vec3 pm_shading_to_world(const struct pm_shading *shading,
                            const struct pm_modifier *modifier, pm_vec3 v);
pm_vec3 pm_shading_to_own(const struct pm_shading *shading, const struct pm_modifier *modifier,
                          pm_vec3 v);

#endif
