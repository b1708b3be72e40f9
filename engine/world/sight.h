#ifndef PM_WORLD_SIGHT_H
#define PM_WORLD_SIGHT_H

#include "world/world.h"

/* Looking around, to tell inside from outside. What lets light through ends no line of sight.
 * Tests: test_openings.c, test_lamps.c. */

enum { PM_SIGHTS = 64 }; /* lines of sight from a place */

/* Share of the lines of sight that end, inside. */
#define PM_SIGHT_CLOSED .86

typedef struct pm_sight_place {
    pm_vec3 point;
    double closed; /* share of the lines of sight that end */
    double room;   /* harmonic mean of their lengths: short in a gap, however long that is */
} pm_sight_place;

pm_sight_place pm_sight_around(const pm_world *world, pm_vec3 point);

/* The i-th of PM_SIGHTS directions, even over the sphere. */
pm_vec3 pm_sight_direction(uint32_t i);

/* Whether the line leaves the scene.
 *   last    out: where it ends, or where it passes the last surface on its way, if it
 *   passes  out: does */
bool pm_sight_out(const pm_world *world, pm_vec3 point, pm_vec3 direction, pm_vec3 *last,
                  bool *passes);

/* Whether a line that starts on surface `from` gets to just before its end. */
bool pm_sight_reaches(const pm_world *world, pm_vec3 point, uint32_t from, pm_vec3 end);

#endif
