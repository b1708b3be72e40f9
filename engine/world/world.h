#ifndef PM_WORLD_WORLD_H
#define PM_WORLD_WORLD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/rgb.h"
#include "base/vec3.h"
#include "scene/scene.h"

/* The render-ready scene: immutable, shared between threads without locks.
 *
 * In: pm_scene. Out: pm_world. Next: plan/plan.h decides what to trace in it.
 *
 * World coordinates. The octree cube is mapped to [-1, 1]^3: a scene point p is at
 * (p - center) / scale. Everything behind this header works in those coordinates, so that
 * answers do not depend on where the scene lies or in which unit: lengths in units of `scale`,
 * extinction in 1 / scale, flux in W / scale^2. Radiance and irradiance are the same in both.
 */

typedef struct pm_world pm_world;

/* A ray that starts in free space; a hit on nothing. */
#define PM_NO_PRIMITIVE 0xFFFFFFFFU

/* Compiles a scene. Surfaces and materials are sorted by digest, so that equal octree hashes
 * trace equal photons. Borrows nothing from the scene. A scene without any surface or source is
 * an error. Degenerate surfaces (zero area) are refused with their place. */
PM_MUST_USE pm_status pm_world_compile(const pm_scene *scene, pm_world **out, pm_error *err);
void pm_world_free(pm_world *world);

/* From now on surfaces cannot be seen from behind, so that one may look into a room from
 * outside: rays go straight through their backs, and photons end at them if they are opaque.
 * As with Radiance's -bv-, which so takes light for granted only on the fronts (models.c).
 * Dielectrics, mists, antimatter, prisms and lamps stay what they are. The hash becomes
 * another. Test: backs_* in tests/physics/test_surroundings.c. */
void pm_world_hide_back_faces(pm_world *world);

/* The Merkle root over octree leaves and infinite sources. Test: digest_* in test_octree.c. */
pm_digest pm_world_hash(const pm_world *world);

typedef struct pm_world_info {
    pm_vec3 center;    /* of the octree cube [scene units] */
    double scale;      /* half its edge [scene units]; a power of two */
    pm_vec3 low, high; /* bounds of the local surfaces [scene units]; of instances, boxes */
    size_t surfaces;   /* local ones, those of instances as often as they are placed */
    size_t lights;     /* surfaces and distant sources that emit */
    size_t specular_surfaces; /* whose material can reflect or refract specularly or glossily */
    size_t diffuse_surfaces;  /* whose material has a diffuse part */
    size_t mist_surfaces;
    pm_rgb power; /* of all lights into the scene [W] */
    size_t octree_nodes;
} pm_world_info;

void pm_world_info_get(const pm_world *world, pm_world_info *out);

pm_vec3 pm_world_from_scene(const pm_world *world, pm_vec3 scene_point);
pm_vec3 pm_world_to_scene(const pm_world *world, pm_vec3 world_point);

/* ---- rays ---- */

typedef struct pm_ray {
    pm_vec3 origin, direction; /* unit direction */
    double t_max;              /* exclusive, > 0; INFINITY for none */
    uint32_t from;             /* surface that the origin lies on, or PM_NO_PRIMITIVE */
} pm_ray;

typedef struct pm_hit {
    double t;         /* refined in double against the exact shape */
    pm_vec3 point;    /* on the exact shape */
    pm_vec3 normal;   /* unit geometric normal, on the side that Radiance calls front */
    uint32_t surface; /* index in the world's digest order; then come those of instances */
    uint32_t material;

    /* Meshes alone, 0 for others: interpolated texture coordinates (Lu, Lv), and what smooth
     * normals add to the unit normal. */
    double u, v;
    pm_vec3 perturbation;
} pm_hit;

/* The closest surface along the ray. Exact in double: the surface `from` is never met again at
 * the origin (a curved one is met at its far root), and a surface that passes within rounding
 * of t_max is not met, so that a ray may be aimed at a point of one. Coincident surfaces have a
 * fixed order by digest, whatever their order in the file, as if they lay an infinitesimal
 * apart: a ray meets each of them once, one from the other side meets them in the opposite
 * order, and one that turns back at the first meets none of the others. Tests: test_rays.c. */
bool pm_world_intersect(const pm_world *world, const pm_ray *ray, pm_hit *hit);

/* The share of light that passes straight from the origin to t_max: 0 behind anything opaque,
 * specular or scattering; the product of transmittances through thin glass, smooth trans's
 * straight part, antimatter and invisible illum, and of exp(-extinction * length) through
 * media, of which `media` says which ones hold the origin.
 *   weak  the ray looks for weak light, which an illum stands for (light.h) */
struct pm_media;
pm_rgb pm_world_transmittance(const pm_world *world, const pm_ray *ray,
                              const struct pm_media *media, bool weak);

/* Between the coordinates of the instances that the surface belongs to and the scene's [scene
 * units], for functions. False in the main scene, and where the modifier of the outermost
 * instance stands for the surface's own: that one means the scene's. Test: test_instance.c. */
bool pm_world_instance_transform(const pm_world *world, uint32_t surface, pm_transform *from,
                                 pm_transform *to);

/* A stable 32-byte name of a surface, of an instance for what it holds; for options that name
 * surfaces. */
const pm_digest *pm_world_surface_digest(const pm_world *world, uint32_t surface);

#endif
