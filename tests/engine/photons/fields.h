#ifndef PM_TESTS_PHOTONS_FIELDS_H
#define PM_TESTS_PHOTONS_FIELDS_H

#include "base/rng.h"
#include "photons/map_internal.h"

/* Photon fields with known densities, for the tests of this stage. */

/* Uniform in [low, high). */
double field_uniform(pm_rng *rng, double low, double high);

/* A uniform direction. */
pm_vec3 field_direction(pm_rng *rng);

/* Fills in photon i of a field. */
typedef void field_make(pm_rng *rng, size_t i, pm_photon_record *out);

void field_floor(pm_rng *rng, size_t i, pm_photon_record *out); /* [-.9, .9]^2 at z = -.5, up */
void field_room(pm_rng *rng, size_t i, pm_photon_record *out);  /* six walls at .9, inwards */
void field_sphere(pm_rng *rng, size_t i, pm_photon_record *out);  /* radius .5, outwards */
void field_ball(pm_rng *rng, size_t i, pm_photon_record *out);    /* volume of radius .8 */
void field_caustic(pm_rng *rng, size_t i, pm_photon_record *out); /* floor; density 1e6 : 1 */
void field_point(pm_rng *rng, size_t i, pm_photon_record *out);   /* all at one place */

/* `count` photons of a field, packed with flux scale 1; free them. */
pm_photon *field_photons(field_make *make, uint64_t seed, size_t count);

/* A map of one path around copies of photons, or of a field. */
pm_photon_map *field_map_of(const pm_photon *photons, size_t count);
pm_photon_map *field_map(field_make *make, uint64_t seed, size_t count);

/* Mean and variance of numbers as they come (Welford 1962). */
typedef struct field_moments {
    double count, mean, square;
} field_moments;

void field_add(field_moments *moments, double value);
double field_variance(const field_moments *moments);

/* Fails unless the mean is within 4 of its own standard errors of the truth. */
void field_assert_mean(const field_moments *moments, double truth);

#endif
