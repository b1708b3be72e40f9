#ifndef PM_BASE_SOBOL_H
#define PM_BASE_SOBOL_H

#include <stdint.h>

/* Owen-scrambled Sobol points.
 *   index      point number in the sequence
 *   dimension  0 .. PM_SOBOL_DIMENSIONS - 1
 *   scramble   any 32 bits; equal scrambles give the same sequence, others independent ones
 * Returns a number in [0, 1).
 * Source: direction numbers of Joe and Kuo 2008 (new-joe-kuo-6); hash-based Owen scrambling
 * after Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020. Test: sobol_is_a_net.
 */
enum { PM_SOBOL_DIMENSIONS = 8 };

double pm_sobol(uint32_t index, unsigned dimension, uint32_t scramble);

/* The same for who draws many points: hash = pm_hash_u32(scramble, dimension). */
double pm_sobol_hashed(uint32_t index, unsigned dimension, uint32_t hash);

/* All dimensions of a point: hash[d] and out[d] as above. Test: sobol_points_are_their_numbers.
 */
void pm_sobol_point(uint32_t index, const uint32_t hash[PM_SOBOL_DIMENSIONS],
                    double out[PM_SOBOL_DIMENSIONS]);

/* Mixes two numbers into well-spread bits; for deriving scrambles (lowbias32, Wellons 2018). */
uint32_t pm_hash_u32(uint32_t a, uint32_t b);

#endif
