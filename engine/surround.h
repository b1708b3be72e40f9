#ifndef PM_SURROUND_H
#define PM_SURROUND_H

#include <stdbool.h>

#include "base/error.h"
#include "base/rgb.h"
#include "scene/bundle.h"
#include "world/world.h"

/* What a user may say about all of a scene, beside its files.
 *
 * In: a bundle and its surroundings. Out: pm_scene. Next: world/world.h compiles it. */

/* Zeroed: as the files say, and no more. */
typedef struct pm_surroundings {
    /* A medium that fills the scene: -me, -ma, -mg. Extinction [1 / scene unit] of 0: none. */
    pm_rgb extinction, albedo;
    double eccentricity;
    bool no_back_faces; /* -bv-: pm_world_hide_back_faces */
} pm_surroundings;

/* The greatest extinction, and the greatest eccentricity in either direction. */
#define PM_EXTINCTION_MAX   1e9
#define PM_ECCENTRICITY_MAX 0.999999

/* PM_E_RANGE. */
PM_MUST_USE pm_status pm_surroundings_check(const pm_surroundings *surroundings, pm_error *err);

/* Parses the scene with its medium. That is a mist between the faces of a cube about the
 * scene's surfaces, a hundredth wider than the greatest of their extents. So it is in every
 * pass, adds to mists within, gives way to dielectrics, and has an end, where distant light
 * comes in: an infinite one would let none through. (In Radiance photons of distant light start
 * outside the scene's cube, while rays to such light come from infinity and are black.)
 * PM_E_RANGE for a medium around nothing: a scene without surfaces. Test: test_surround.c. */
PM_MUST_USE pm_status pm_surround_parse(const pm_bundle *bundle, const char *main_name,
                                        const pm_surroundings *surroundings, pm_scene **out,
                                        pm_error *err);

#endif
