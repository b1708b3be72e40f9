#ifndef PM_TESTS_PHYSICS_H
#define PM_TESTS_PHYSICS_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "pipeline.h"
#include "reference.h"

/* What the tests of physical claims share: scene text through the whole engine, means over
 * independent seeds, and the reference tracer on the same text.
 *
 * Tolerances. A mean over n independent seeds carries the standard error s of those n numbers,
 * and must lie within K_SIGMA s of the truth, plus `slack`: the bias that the test derives, and
 * ROUNDING, since answers are floats. With SEEDS = 16 the distance in units of s follows
 * Student's t with 15 degrees of freedom, which exceeds 5 with probability 1.6e-4; the seeds
 * are fixed, so a test that passes keeps passing. */

#define PI       3.14159265358979323846
#define K_SIGMA  5.0
#define ROUNDING 1e-6 /* relative; floats are rounded by 2^-24 */

enum { SEEDS = 16, GREY = 3 };

/* ---- numbers ---- */

/* Running mean and sum of squared differences (Welford 1962). */
struct stat {
    double count, mean, squares;
};

void stat_add(struct stat *stat, double value);
double stat_deviation(const struct stat *stat); /* of one value; needs two */
double stat_error(const struct stat *stat);     /* of the mean */

/* Fails the test, and says by how much, unless the mean is near `want`. */
void expect_mean(const char *what, const struct stat *got, double want, double slack);

/* The same for a want that has a standard error of its own. */
void expect_equal_means(const char *what, const struct stat *got, double want,
                        double want_error, double slack);

void expect_near(const char *what, double got, double want, double slack);

/* Integral of f over [a, b]: Gauss's three points in `steps` equal pieces. */
double integrate(double (*f)(double, const void *), const void *context, double a, double b,
                 int steps);

/* Point i of `count` evenly spread over the unit sphere, by the golden angle. */
pm_vec3 sphere_point(int i, int count);

/* ---- scenes ---- */

/* Full angle of a sun whose light counts as parallel, and the radiance that gives it irradiance
 * 1 at right angles. */
#define SUN_DEGREES .1
double sun_radiance(void);

/* A wall of albedo 1/2 around a small lamp: even light, see test_sphere.c. */
#define EVEN_SPHERE                                                                            \
    "void light bright 0 0 3 1 1 1  bright sphere lamp 0 0 4 0 0 0 .02\n"                      \
    "void plastic grey 0 0 5 .5 .5 .5 0 0  grey bubble wall 0 0 4 0 0 0 1\n"

/* Scene text as by printf; to be freed. Lines `#file NAME` start the files that it names. */
char *text_of(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Four walls, floor and ceiling of [-1, 1]^3 as polygons that face inwards. */
#define BOX(modifier)                                                                          \
    modifier " polygon floor 0 0 12 -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1\n" modifier                \
             " polygon ceiling 0 0 12 -1 -1 1 -1 1 1 1 1 1 1 -1 1\n" modifier                  \
             " polygon south 0 0 12 -1 -1 -1 -1 -1 1 1 -1 1 1 -1 -1\n" modifier                \
             " polygon north 0 0 12 -1 1 -1 1 1 -1 1 1 1 -1 1 1\n" modifier                    \
             " polygon west 0 0 12 -1 -1 -1 -1 1 -1 -1 1 1 -1 -1 1\n" modifier                 \
             " polygon east 0 0 12 1 -1 -1 1 -1 1 1 1 1 1 1 -1\n"

/* ---- runs ---- */

/* One progressive pass with that -ab. */
pm_job job_of(pm_job_kind kind, int ambient_bounces);

/* The map of `count` photons with `gather_count` an estimate; the job turns N-nearest. */
void want_map(pm_job *job, pm_map_kind kind, uint64_t count, uint32_t gather_count);

/* The ways to count a path once: see the table in plan/plan.h. */
struct mode {
    const char *name;
    int ambient_bounces;
    bool progressive, global, caustic; /* which maps a mode of maps asks for */
};

enum { MODES = 8 };
extern const struct mode modes[MODES];

/* With maps of `photons`, look-ups of `gather_count`. */
pm_job job_of_mode(const struct mode *mode, uint64_t photons, uint32_t gather_count);

void look_at(pm_job *job, const pm_sensor *sensors, size_t count, pm_quantity quantity);

/* Fails the test with the engine's words if the job fails, or if a sample was not finite. */
void run_job(const pm_job *job, const char *text, const pm_job_hooks *hooks, pm_answer *answer);

/* A store of batches in memory, for jobs that share them: hooks of `fetch` and `keep`. */
struct store {
    struct stored {
        pm_digest family;
        uint64_t index;
        pm_bytes bytes;
    } * list;
    size_t count;
    size_t fetched, kept; /* calls that found a batch, that brought one */
};

pm_job_hooks store_hooks(struct store *store);
void store_clear(struct store *store);

/* Runs seeds 1 .. count; each gives one number to stats[3 * sensor + channel]. */
void run_seeds(pm_job *job, const char *text, unsigned count, struct stat *stats);

/* Mean over the sensors of a channel 0 to 2, or of all channels (GREY). */
double sensor_mean(const pm_answer *answer, size_t sensors, int channel);

/* The same; each seed gives the mean over all sensors: of channel 0 to 2, or all of them
 * (GREY). */
struct stat run_mean(pm_job *job, const char *text, unsigned count, int channel);

/* ---- photons of a map, in scene units ---- */

/* Flux of photon i [W]; its position. */
pm_rgb flux_of(const pm_photon_map *map, size_t i, pm_vec3 *position);

/* Flux of the photons within `radius` of `center` [W]. */
pm_rgb flux_within(const pm_photon_map *map, pm_vec3 center, double radius);

/* The same of a map job for seeds 1 .. SEEDS, a channel each. */
void run_flux(pm_job *job, const char *text, pm_map_kind kind, pm_vec3 center, double radius,
              struct stat flux[3]);

/* ---- the reference ---- */

struct ref_scene *reference_of(const char *text);
struct ref_result reference_irradiance(const char *text, const pm_sensor *sensor, double radius,
                                       uint64_t samples);

#endif
