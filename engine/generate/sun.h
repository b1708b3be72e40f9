#ifndef PM_GENERATE_SUN_H
#define PM_GENERATE_SUN_H

#include <stdbool.h>

/* Where the sun stands. Angles in radians, hours since midnight, longitudes west of Greenwich.
 */

typedef struct pm_site {
    double latitude, longitude;
    double meridian; /* of the standard time */
} pm_site;

/* Radiance's home: 37.8 degrees north, 122 west, Pacific standard time. */
extern const pm_site pm_site_default;

typedef struct pm_moment {
    int year; /* 0: any; else from 1901 to 2099 */
    int month, day;
    double hour;
    bool solar; /* the hour is solar time, not standard time */
} pm_moment;

typedef struct pm_sun {
    double declination;
    double hour;              /* solar time */
    double altitude, azimuth; /* azimuth from south, west positive */
} pm_sun;

/* Without a year the short formulas of the IES Lighting Handbook's Reference Volume of 1981
 * (equation of time and declination from the day of the year, within 1.5 degrees); with
 * one the Astronomical Almanac's approximation, within 0.01 degrees from 1950 to 2050.
 * Source: J. Michalsky, "The Astronomical Almanac's algorithm for approximate solar position
 * (1950-2050)", Solar Energy 40(3), 1988. Test: test_sun.c. */
pm_sun pm_sun_find(const pm_site *site, const pm_moment *moment);

/* Altitude and azimuth at another solar time of the same day. */
void pm_sun_turn(const pm_site *site, double solar_hour, pm_sun *sun);

int pm_day_of_year(int month, int day); /* 1 for January 1; February has 28 days */

/* Declination from the day of the year, by the short formula. */
double pm_sun_declination(int day_of_year);

/* Towards the sun: x east, y north, z up. */
void pm_sun_direction(double altitude, double azimuth, double out[3]);

#endif
