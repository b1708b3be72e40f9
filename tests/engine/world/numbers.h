#ifndef PM_TESTS_WORLD_NUMBERS_H
#define PM_TESTS_WORLD_NUMBERS_H

#include <math.h>
#include <stdio.h>

#include "base/maths.h"
#include "base/rng.h"
#include "base/vec3.h"
#include "base/warp.h"

/* Numbers for the tests of this folder. Include after <cmocka.h>. */

static inline void assert_near(double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance))
        fail_msg("%.17g is not %.17g within %g", value, wanted, tolerance);
}

static inline void assert_at_most(double value, double most)
{
    if (!(value <= most))
        fail_msg("%.17g is more than %.17g", value, most);
}

/* The unit vector at an angle from +z. */
static inline pm_vec3 polar(double cosine, double azimuth)
{
    double sine = sqrt(fmax(1 - cosine * cosine, 0));
    return (pm_vec3){sine * cos(azimuth), sine * sin(azimuth), cosine};
}

static inline void draw(pm_rng *rng, double *u, int count)
{
    for (int i = 0; i < count; i++)
        u[i] = pm_rng_uniform(rng);
}

/* Integral of a function of wi over the directions that halfway vectors of slope up to 7 alpha
 * reflect wo into: midpoint rule in slopes 7 alpha p^2, h = n + slope (cos phi x + sin phi y),
 * with d omega_h = cos^3 d slopes and d omega_i = 4 (wo h) d omega_h. */
static inline double over_reflections(double (*value)(const void *, pm_vec3),
                                      const void *context, pm_vec3 n, pm_vec3 wo, double alpha)
{
    enum { RADII = 160, ANGLES = 64 };
    pm_frame frame = pm_frame_make(n);
    double sum = 0;
    for (int i = 0; i < RADII * ANGLES; i++) {
        double p = (i / ANGLES + .5) / RADII, slope = 7 * alpha * p * p;
        double phi = 2 * PM_PI * (i % ANGLES + .5) / ANGLES, along = 1 / hypot(1, slope);
        pm_vec3 local = {slope * cos(phi), slope * sin(phi), 1};
        pm_vec3 h = pm_vec3_normalize(pm_frame_to_world(&frame, local));
        double towards = pm_vec3_dot(wo, h);
        if (towards > 0)
            sum += value(context, pm_vec3_reflect(wo, h)) * 4 * towards * pow(along, 3) *
                   slope * p;
    }
    return sum * 28 * PM_PI * alpha / ((double)RADII * ANGLES);
}

/* The same in polar coordinates about the straight direction -wo, for a lobe of that width; the
 * polar angle is pi p^4, which puts the points where a narrow lobe is. */
static inline double over_transmissions(double (*value)(const void *, pm_vec3),
                                        const void *context, pm_vec3 wo)
{
    enum { RINGS = 160, ANGLES = 64 };
    pm_frame frame = pm_frame_make(pm_vec3_negate(wo));
    double sum = 0;
    for (int i = 0; i < RINGS * ANGLES; i++) {
        double p = (i / ANGLES + .5) / RINGS, angle = PM_PI * pow(p, 4);
        double phi = 2 * PM_PI * (i % ANGLES + .5) / ANGLES;
        pm_vec3 local = {sin(angle) * cos(phi), sin(angle) * sin(phi), cos(angle)};
        sum += value(context, pm_frame_to_world(&frame, local)) * sin(angle) * pow(p, 3);
    }
    return sum * 8 * PM_PI * PM_PI / ((double)RINGS * ANGLES);
}

/* A histogram over the sphere, equal in solid angle, against a density. */
enum { BANDS = 16, SECTORS = 16, BINS = BANDS * SECTORS };

struct histogram {
    double found[BINS], wanted[BINS];
    double samples;
};

static inline void histogram_add(struct histogram *h, pm_vec3 w)
{
    int band = (int)((w.z + 1) / 2 * BANDS);
    int sector = (int)((atan2(w.y, w.x) / (2 * PM_PI) + .5) * SECTORS);
    band = band < 0 ? 0 : band >= BANDS ? BANDS - 1 : band;
    sector = sector < 0 ? 0 : sector >= SECTORS ? SECTORS - 1 : sector;
    h->found[band * SECTORS + sector]++;
}

/* Expected counts by the midpoint rule, STEPS^2 points a bin. */
static inline void histogram_expect(struct histogram *h, double (*density)(void *, pm_vec3),
                                    void *context)
{
    enum { STEPS = 40 };
    for (int b = 0; b < BINS; b++) {
        double sum = 0;
        for (int k = 0; k < STEPS * STEPS; k++) {
            double z = (b / SECTORS + (k / STEPS + .5) / STEPS) / BANDS * 2 - 1;
            double phi = ((b % SECTORS + (k % STEPS + .5) / STEPS) / SECTORS - .5) * 2 * PM_PI;
            sum += density(context, polar(z, phi));
        }
        h->wanted[b] = h->samples * sum / (STEPS * STEPS) * 4 * PM_PI / BINS;
    }
}

/* Pearson's test: p > 0.001. Bins that expect fewer than 20 go together; so do the samples that
 * came to nothing. The normal deviate is Wilson and Hilferty's (1931). */
static inline void histogram_check(const struct histogram *h)
{
    double chi = 0, found = 0, wanted = 0, small_found = 0, small_wanted = 0;
    int bins = 0;
    for (int b = 0; b < BINS; b++) {
        found += h->found[b];
        wanted += h->wanted[b];
        if (h->wanted[b] < 20) {
            small_found += h->found[b];
            small_wanted += h->wanted[b];
            continue;
        }
        chi += pow(h->found[b] - h->wanted[b], 2) / h->wanted[b];
        bins++;
    }
    small_found += h->samples - found;
    small_wanted += h->samples - wanted;
    if (small_wanted >= 20) {
        chi += pow(small_found - small_wanted, 2) / small_wanted;
        bins++;
    } else {
        assert_near(small_found, small_wanted, 30);
    }
    assert_true(bins > 5);
    double k = bins - 1;
    double deviate = (cbrt(chi / k) - (1 - 2 / (9 * k))) / sqrt(2 / (9 * k));
    if (!(deviate < 3.09))
        fail_msg("chi-squared %g with %g degrees of freedom", chi, k);
}

#endif
