#ifndef PM_WORLD_CAP_H
#define PM_WORLD_CAP_H

/* The projected solid angle of a cone of directions, seen by a surface element: integral of
 * max(cos, 0) over the cone.
 *   versine  1 - cos of half the cone's angle, in [0, 2]
 *   cosine   of the angle between the cone's axis and the surface normal
 * Source: irradiance of a spherical cap that the horizon cuts, Snyder, "Area light sources for
 * real-time graphics", MSR-TR-96-11, 1996, eq. 12. Test: cap_projection_equals_quadrature. */
double pm_cap_projected(double versine, double cosine);

#endif
