#ifndef PM_LANGUAGE_NOISE_H
#define PM_LANGUAGE_NOISE_H

/* Solid noise with the values of Radiance's (src/rt/noise3.c), so that a stone looks as it did.
 * Pure functions of the point; 0 where a coordinate is beyond 2^31.
 * Test: noise_has_the_values_of_radiance. */

/* Gradient noise, about -1 .. 1, of Perlin's permutation.
 * Source: Perlin, "Improving noise", SIGGRAPH 2002. */
double pm_noise(double x, double y, double z);

/* How far behind the point the noise's derivatives are taken: noise3x and its kin are backward
 * differences, (noise(x) - noise(x - step)) / step. */
#define PM_NOISE_STEP .0005

/* Fractal noise, -1 .. 1: random values at the corners of the unit cube around the point; each
 * halving of the cube gives the middles of the cube, of its faces and of its edges the mean of
 * what surrounds them and a random offset in proportion to the cube's side (random midpoint
 * displacement: Fournier, Fussell, Carpenter, "Computer rendering of stochastic models", CACM
 * 25(6), 1982), down to PM_NOISE_STEP. */
double pm_noise_fractal(double x, double y, double z);

#endif
