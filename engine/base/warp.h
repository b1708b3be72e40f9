#ifndef PM_BASE_WARP_H
#define PM_BASE_WARP_H

#include "base/vec3.h"

/* Maps from the unit square to directions and discs. Test: warp_moments_are_analytic. */

/* An orthonormal frame; z is the given unit normal. */
typedef struct pm_frame {
    pm_vec3 x, y, z;
} pm_frame;

/* Source: Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
pm_frame pm_frame_make(pm_vec3 normal);
pm_vec3 pm_frame_to_world(const pm_frame *frame, pm_vec3 local);
pm_vec3 pm_frame_to_local(const pm_frame *frame, pm_vec3 world);

/* Uniform in the unit disc (z = 0), concentric (Shirley and Chiu 1997). */
pm_vec3 pm_warp_disc(double u, double v);

/* The point of the unit square that pm_warp_disc maps to (x, y); each of its coordinates is in
 * [0, 1). Test: disc_and_cap_are_inverted. */
void pm_warp_disc_inverse(double x, double y, double *u, double *v);

/* Cosine-weighted about +z; pdf_solid_angle = z / pi. */
pm_vec3 pm_warp_cosine(double u, double v);

/* Uniform on the unit sphere; pdf_solid_angle = 1 / (4 pi). */
pm_vec3 pm_warp_sphere(double u, double v);

/* Uniform in the cone about +z with 1 - cos(half angle) = `versine`, which keeps its precision
 * for the smallest angles; pdf_solid_angle = 1 / (2 pi versine). */
pm_vec3 pm_warp_cone(double u, double v, double versine);

/* The same by way of the concentric disc (Lambert's azimuthal equal-area projection), which
 * keeps neighbours neighbours; and its inverse for unit directions within the cone. */
pm_vec3 pm_warp_cap(double u, double v, double versine);
void pm_warp_cap_inverse(pm_vec3 direction, double versine, double *u, double *v);

/* 1 - cos of an angle in radians, without cancellation. */
double pm_versine(double angle);

#endif
