#ifndef PM_BACKWARD_BACKWARD_H
#define PM_BACKWARD_BACKWARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "backward/view.h"
#include "base/error.h"
#include "base/pool.h"
#include "image/image.h"
#include "photons/bias.h"
#include "photons/photon_map.h"
#include "world/world.h"

/* The backward pass: rays from the eye or from sensors, light from next events and photon maps.
 *
 * In: world and maps. Out: pictures or values at points. Next: image/image.h.
 *
 * Works in passes. Pass j takes one sample a pixel or sensor, belongs to replicate j mod 16,
 * and adds to that replicate's sums; the answer is their mean, the interval comes from the
 * replicate means. Values do not depend on threads or on the order of pixels. */

/* What the maps are and how they are looked up during a pass. Absent maps are NULL. With -ab >
 * 0 each sample sends one gather ray from its first diffuse surface; passes average them. */
typedef struct pm_backward_maps {
    const pm_photon_map *map[PM_MAP_KINDS]; /* a precomputed one in the place of the global */
    uint32_t gather_count[PM_MAP_KINDS];    /* N-nearest, if radius is 0 */
    uint32_t gather_max[PM_MAP_KINDS]; /* > gather_count: N to so many, as bandwidth says */
    pm_bandwidth bandwidth[PM_MAP_KINDS];
    double radius[PM_MAP_KINDS]; /* fixed radius [world units], if > 0. Progressive
                                    passes: the global map serves both, its specular
                                    photons with the radius of PM_MAP_CAUSTIC; 0 = not
                                    known yet: that of the other, or 2^-4 */
    bool progressive;            /* the maps are those of one progressive pass */
    int ambient_bounces;         /* -ab; see the table in plan/plan.h */
} pm_backward_maps;

typedef struct pm_sensor {
    pm_vec3 point; /* scene units */
    pm_vec3
        normal; /* irradiance: facing direction; radiance: ray direction. Need not be unit */
} pm_sensor;

typedef enum pm_quantity {
    PM_IRRADIANCE, /* [W/m^2] on the sensor's front side, as rtrace -I */
    PM_RADIANCE,   /* [W/(m^2 sr)] that arrives from the direction, as rtrace */
} pm_quantity;

/* Irradiance is what a white Lambertian receiver at the sensor gets: next event, and
 *   - if the sensor lies on a diffuse surface that faces its way (within 2^-13 of half the
 * octree cube's edge), photons on that surface, as at the eye's first diffuse surface;
 *   - elsewhere no photon is near, so one cosine-distributed ray a pass takes all indirect
 * light: it goes through specular surfaces, and next event and photon maps wait at its diffuse
 * ones. With -ab 0 only what comes by a specular surface counts, as on surfaces. Tests:
 * sensor_on_a_surface_sees_the_photons_there, sensor_in_free_space_sees_what_the_walls_send,
 * all_partitions_give_the_same_light. */

/* For photons/precompute.h: pm_photon_map_nearest at the place of a photon, with the part of
 * its disc left out that lies beyond the surface's edges or behind walls, as look-ups have it
 * during a pass. `world` is a const pm_world *. Test:
 * precomputed_corners_are_as_bright_as_they_are. */
pm_estimate pm_estimate_at_photon(const void *world, const pm_photon_map *map, pm_vec3 point,
                                  pm_vec3 normal, uint32_t gather_count, uint64_t i);

/* Sums of the passes so far, of a picture or of sensors; 456 bytes a pixel or sensor. */
typedef struct pm_accumulation pm_accumulation;

/* The world is borrowed. PM_E_RANGE for a view or sensor that cannot be, PM_E_LIMIT for more
 * than 4 GiB of sums, PM_E_MEMORY. */

PM_MUST_USE pm_status pm_accumulation_for_picture(const pm_world *world, const pm_view *view,
                                                  uint32_t width, uint32_t height,
                                                  uint64_t seed, pm_accumulation **out,
                                                  pm_error *err);
PM_MUST_USE pm_status pm_accumulation_for_sensors(const pm_world *world,
                                                  const pm_sensor *sensors, size_t count,
                                                  pm_quantity quantity, uint64_t seed,
                                                  pm_accumulation **out, pm_error *err);
void pm_accumulation_free(pm_accumulation *accumulation);

/* Adds pass number `pass` (each number once, ascending). PM_E_CANCELLED leaves the sums as they
 * were before this pass. */
PM_MUST_USE pm_status pm_backward_pass(pm_accumulation *accumulation, uint32_t pass,
                                       const pm_backward_maps *maps, pm_pool *pool,
                                       bool (*cancelled)(void *), void *context, pm_error *err);

uint32_t pm_accumulation_passes(const pm_accumulation *accumulation);
size_t pm_accumulation_count(const pm_accumulation *accumulation); /* pixels or sensors */

/* The mean so far, [count][3]; rows from the top. */
void pm_accumulation_mean(const pm_accumulation *accumulation, float *out);

/* Half-width of the 95 % interval of each value [count][3], from the replicate means by
 * Student's t and, for N-nearest maps, from the photons' own scatter. Infinity with fewer than
 * two passes of evidence. */
void pm_accumulation_half_width(const pm_accumulation *accumulation, float *out);

/* Estimated relative error of the whole: the root mean square of each value's standard error
 * over the median of its replicate means, or over the mean of all values where that is darker.
 * So neither the edge of a bright lamp nor a dark corner decides alone, and a stray sample
 * cannot hide behind its own size. Infinity while unknown, 0 only if every value is exactly
 * known to be dark. */
double pm_accumulation_error(const pm_accumulation *accumulation);

/* Non-finite samples met so far: 0 in a healthy run. They are counted, not added. */
uint64_t pm_accumulation_nonfinite(const pm_accumulation *accumulation);

/* Radius of progressive pass `pass` [world units], after Knaus and Zwicker 2011, eq. 20
 * (surfaces): r_j^2 = r_1^2 prod_{k<j} (k + alpha) / (k + 1), alpha = 2/3. */
double pm_progressive_radius(double first_radius, uint32_t pass);

#endif
