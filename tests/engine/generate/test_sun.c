#include "generate_test.h"

#include "generate/sun.h"

static const double degrees = PM_PI / 180;

/* Altitude and azimuth after J. Meeus, Astronomical Algorithms (2nd ed. 1998), chapters 12, 13,
 * 22 and 25 (low accuracy, 0.01 degrees), from the universal time. Longitude east. */
static void meeus(double julian_day, double latitude, double longitude, double *altitude,
                  double *azimuth)
{
    double t = (julian_day - 2451545) / 36525;
    double l0 = 280.46646 + t * (36000.76983 + t * 0.0003032);
    double m = (357.52911 + t * (35999.05029 - t * 0.0001537)) * degrees;
    double c = (1.914602 - t * (0.004817 + t * 0.000014)) * sin(m) +
               (0.019993 - 0.000101 * t) * sin(2 * m) + 0.000289 * sin(3 * m);
    double omega = (125.04 - 1934.136 * t) * degrees;
    double lambda = (l0 + c - 0.00569 - 0.00478 * sin(omega)) * degrees;
    double eps = (23.43929111 - 0.013004167 * t + 0.00256 * cos(omega)) * degrees;
    double ra = atan2(cos(eps) * sin(lambda), cos(lambda));
    double dec = asin(sin(eps) * sin(lambda));
    double sidereal = 280.46061837 + 360.98564736629 * (julian_day - 2451545) +
                      t * t * 0.000387933 - 0.00478 * sin(omega) * cos(eps);
    double h = (sidereal + longitude) * degrees - ra, phi = latitude * degrees;
    *altitude = asin(sin(phi) * sin(dec) + cos(phi) * cos(dec) * cos(h)) / degrees;
    *azimuth = atan2(sin(h), cos(h) * sin(phi) - tan(dec) * cos(phi)) / degrees;
}

struct place {
    double latitude, longitude, meridian; /* degrees; longitudes west */
    int year, month, day;
    double hour, julian_day; /* of 0 h universal time on that date */
};

/* The angles are each within 0.01 degrees, so they differ by less than twice that; azimuth by
 * more near the zenith, where these are not. */
static void the_almanac_agrees_with_meeus(void **state)
{
    (void)state;
    static const struct place places[] = {
        {47.2, -8.5, -15, 2026, 3, 20, 10.5, 2461119.5},   /* Lucerne, spring */
        {37.8, 122.4, 120, 2026, 6, 21, 15.25, 2461212.5}, /* San Francisco, summer */
        {-33.9, -151.2, -150, 2026, 12, 21, 9, 2461395.5}, /* Sydney, summer */
        {60.2, -24.9, -30, 2040, 12, 21, 12, 2466509.5},   /* Helsinki, winter */
    };
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        const struct place *p = &places[i];
        const pm_site site = {p->latitude * degrees, p->longitude * degrees,
                              p->meridian * degrees};
        const pm_moment moment = {p->year, p->month, p->day, p->hour, false};
        double altitude, azimuth;
        meeus(p->julian_day + (p->hour + p->meridian / 15) / 24, p->latitude, -p->longitude,
              &altitude, &azimuth);
        pm_sun sun = pm_sun_find(&site, &moment);
        assert_near(sun.altitude / degrees, altitude, 0.02);
        assert_near(remainder(sun.azimuth / degrees - azimuth, 360), 0,
                    0.02 / cos(altitude * degrees));
    }
}

/* I. Reda, A. Andreas, Solar Position Algorithm (NREL/TP-560-34302, 2003), example: zenith
 * angle 50.11162, azimuth 194.34024 from north, with 0.02 degrees of refraction. */
static void the_almanac_agrees_with_the_published_example(void **state)
{
    (void)state;
    const pm_site site = {39.742476 * degrees, 105.1786 * degrees, 105 * degrees};
    const pm_moment moment = {2003, 10, 17, 12 + 30.5 / 60, false};
    pm_sun sun = pm_sun_find(&site, &moment);
    assert_near(sun.altitude / degrees, 90 - 50.11162 - 0.02, 0.02);
    assert_near(sun.azimuth / degrees, 194.34024 - 180, 0.02);
}

/* Equal seasons and the solstices: the height of the sun at solar noon. */
static void noon_heights_follow_the_declination(void **state)
{
    (void)state;
    static const struct {
        int month, day;
        double declination;
    } dates[] = {{3, 21, 0}, {6, 21, 23.44}, {9, 23, 0}, {12, 21, -23.44}};
    for (size_t i = 0; i < 4; i++) {
        const pm_site site = {40 * degrees, 0, 0};
        const pm_moment moment = {0, dates[i].month, dates[i].day, 12, true};
        pm_sun sun = pm_sun_find(&site, &moment);
        /* The short formula is a day or two out at the equinoxes, 0.4 degrees each. */
        assert_near(sun.altitude / degrees, 50 + dates[i].declination, 1.1);
        assert_near(sun.azimuth, 0, 1e-12);
        assert_near(sun.hour, 12, 0);
    }
}

static void the_short_formula_is_near_the_almanac(void **state)
{
    (void)state;
    double worst = 0;
    for (int month = 1; month <= 12; month++) {
        for (int day = 1; day <= 28; day++) {
            const pm_site site = {45 * degrees, 0, 0};
            const pm_moment quick = {0, month, day, 12, false};
            const pm_moment exact = {2026, month, day, 12, false};
            double difference =
                pm_sun_find(&site, &quick).altitude - pm_sun_find(&site, &exact).altitude;
            worst = fmax(worst, fabs(difference) / degrees);
        }
    }
    assert_near(worst, 0, 1.5);
}

static void the_direction_points_where_the_angles_say(void **state)
{
    (void)state;
    double d[3];
    pm_sun_direction(30 * degrees, 90 * degrees, d); /* in the west */
    assert_near(d[0], -cos(30 * degrees), 1e-15);
    assert_near(d[1], 0, 1e-15);
    assert_near(d[2], 0.5, 1e-15);
    pm_sun_direction(0, 0, d); /* in the south */
    assert_near(d[1], -1, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_almanac_agrees_with_meeus),
        cmocka_unit_test(the_almanac_agrees_with_the_published_example),
        cmocka_unit_test(noon_heights_follow_the_declination),
        cmocka_unit_test(the_short_formula_is_near_the_almanac),
        cmocka_unit_test(the_direction_points_where_the_angles_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
