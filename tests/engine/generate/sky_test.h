#ifndef SKY_TEST_H
#define SKY_TEST_H

#include "generate_test.h"

/* Radiance towards a direction by its height and its angle from the sun. */
typedef double sky_radiance(double sine_height, double from_sun, const void *context);

/* Horizontal irradiance of a sky by the midpoint rule, which is within 1e-4 for these. */
static inline double irradiance(sky_radiance *sky, const double sun[3], const void *context)
{
    enum { ROWS = 400, COLUMNS = 800 };
    double sum = 0;
    for (int i = 0; i < ROWS; i++) {
        double theta = (i + .5) / ROWS * PM_PI / 2, s = sin(theta), c = cos(theta);
        for (int j = 0; j < COLUMNS; j++) {
            double phi = (j + .5) / COLUMNS * 2 * PM_PI;
            double dot = s * cos(phi) * sun[0] + s * sin(phi) * sun[1] + c * sun[2];
            sum += sky(c, acos(fmin(1, dot)), context) * c * s;
        }
    }
    return sum * PM_PI / 2 / ROWS * 2 * PM_PI / COLUMNS;
}

#endif
