#ifndef PM_GENERATE_SKY_H
#define PM_GENERATE_SKY_H

#include "generate/generation.h"
#include "generate/sun.h"

/* What gensky and gendaylit share. */

/* The words that say when and where: `month day hour`, or `-ang altitude azimuth`. */
typedef struct pm_sky_time {
    pm_site site;
    pm_moment moment; /* month 0: the angles are given */
    double altitude, azimuth;
    bool zone; /* the hour names its time zone, which overrides -m */
} pm_sky_time;

PM_MUST_USE pm_status pm_take_sky_time(pm_generation *g, bool zones, pm_sky_time *out);

/* Takes -y, -a, -o or -m in hand; *known is false for another option. */
PM_MUST_USE pm_status pm_take_site(pm_generation *g, pm_sky_time *time, bool *known);

/* The clear or intermediate distribution at the zenith, by which it is divided to be 1 there.
 */
double pm_sky_zenith(double altitude, bool intermediate);

/* Diffuse irradiance of a sky by its zenith's radiance, E / (pi L): a polynomial in the sun's
 * altitude [radian] of the integral of the CIE clear sky or, if `intermediate`, of Matsuura's,
 * as Radiance has it. */
double pm_sky_zenith_factor(double altitude, bool intermediate);

#endif
