#ifndef PM_BACKWARD_FIRST_HIT_H
#define PM_BACKWARD_FIRST_HIT_H

#include <stdbool.h>

#include "backward/backward.h"

/* What a sensor's ray meets first, for rtrace's -o: nothing about light. */
typedef struct pm_first_hit {
    bool met;
    double distance;          /* [scene units]; INFINITY if nothing is met */
    pm_vec3 point;            /* [scene units]; the origin if nothing is met */
    pm_vec3 normal;           /* unit, towards the ray's origin; with textures and smoothing */
    pm_vec3 geometric_normal; /* without */
    double u, v;              /* of meshes; else 0 */
    uint32_t surface;         /* of the world; PM_NO_PRIMITIVE: none */
} pm_first_hit;

/* A radiance sensor's ray; an irradiance sensor is met itself, at distance 0, as by rtrace -I.
 * Surfaces that antimatter hides are met, too. Test: test_first_hit.c. */
pm_first_hit pm_sensor_first_hit(const pm_world *world, const pm_sensor *sensor,
                                 pm_quantity quantity);

#endif
