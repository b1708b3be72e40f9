#include "generate/sun.h"

#include <math.h>

#include "base/maths.h"

#define DEGREES (PM_PI / 180)
#define HOURS   (PM_PI / 12) /* of the sky's turning */

const pm_site pm_site_default = {
    .latitude = 0.66, .longitude = 2.13, .meridian = 120 * DEGREES};

int pm_day_of_year(int month, int day)
{
    static const int before[12] = {0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334};
    return before[month - 1] + day;
}

double pm_sun_declination(int day_of_year)
{
    return 0.4093 * pm_sin(2 * PM_PI / 365 * (day_of_year - 81));
}

/* What to add to standard time [h] for solar time: the equation of time and the way to the
 * meridian. */
static double solar_adjustment(const pm_site *site, int day)
{
    return 0.170 * pm_sin(4 * PM_PI / 373 * (day - 80)) -
           0.129 * pm_sin(2 * PM_PI / 355 * (day - 8)) +
           (site->meridian - site->longitude) / HOURS;
}

/* Days since noon of January 1, 2000, universal time. */
static double almanac_days(const pm_site *site, const pm_moment *m)
{
    int years = m->year - 1949;
    int days = pm_day_of_year(m->month, m->day) + (m->month > 2 && m->year % 4 == 0) +
               years * 365 + years / 4;
    double hour = m->hour + site->meridian / HOURS;
    return days + hour / 24 + (2432916.5 - 2451545);
}

static double wrapped(double x, double period)
{
    double rest = fmod(x, period); /* exact */
    return rest < 0 ? rest + period : rest;
}

/* Michalsky 1988: mean longitude and anomaly, ecliptic longitude, obliquity; then right
 * ascension and sidereal time. */
static void almanac(const pm_site *site, const pm_moment *m, pm_sun *sun)
{
    double n = almanac_days(site, m);
    double longitude = wrapped((280.460 + 0.9856474 * n) * DEGREES, 2 * PM_PI);
    double anomaly = wrapped((357.528 + 0.9856003 * n) * DEGREES, 2 * PM_PI);
    double ecliptic =
        longitude + 1.915 * DEGREES * pm_sin(anomaly) + 0.020 * DEGREES * pm_sin(2 * anomaly);
    double obliquity = (23.439 - 4e-7 * n) * DEGREES;
    double sine = pm_sin(ecliptic);
    sun->declination = pm_asin(pm_sin(obliquity) * sine);
    if (m->solar)
        return;
    double ascension = pm_atan2(sine * pm_cos(obliquity), pm_cos(ecliptic));
    double universal = 24 * (n - floor(n)) + 12;
    double sidereal = 6.697375 + 0.0657098242 * n + universal - site->longitude / HOURS;
    sun->hour = wrapped(sidereal - ascension / HOURS + 12, 24);
}

void pm_sun_turn(const pm_site *site, double solar_hour, pm_sun *sun)
{
    double sl, cl, sd, cd, sh, ch;
    pm_sincos(site->latitude, &sl, &cl);
    pm_sincos(sun->declination, &sd, &cd);
    pm_sincos(solar_hour * HOURS, &sh, &ch);
    double sine = sl * sd - cl * cd * ch;
    sun->hour = solar_hour;
    sun->altitude = pm_asin(sine < -1 ? -1 : sine > 1 ? 1 : sine);
    sun->azimuth = -pm_atan2(cd * sh, -cl * sd - sl * cd * ch);
}

pm_sun pm_sun_find(const pm_site *site, const pm_moment *moment)
{
    int day = pm_day_of_year(moment->month, moment->day);
    pm_sun sun = {.hour = moment->hour};
    if (moment->year) {
        almanac(site, moment, &sun);
    } else {
        sun.declination = pm_sun_declination(day);
        if (!moment->solar)
            sun.hour += solar_adjustment(site, day);
    }
    pm_sun_turn(site, sun.hour, &sun);
    return sun;
}

void pm_sun_direction(double altitude, double azimuth, double out[3])
{
    double sa, ca, sz, cz;
    pm_sincos(altitude, &sa, &ca);
    pm_sincos(azimuth, &sz, &cz);
    out[0] = -sz * ca;
    out[1] = -cz * ca;
    out[2] = sa;
}
