#ifndef PM_PLAN_PLAN_H
#define PM_PLAN_PLAN_H

#include <stdbool.h>
#include <stdint.h>

#include "base/error.h"
#include "forward/photon.h"
#include "photons/bias.h"
#include "world/world.h"

/* Which passes a scene needs, and why the others are left out.
 *
 * In: a world and what the user wants. Out: pm_plan. Next: forward/forward.h traces it.
 *
 * Who counts which light, so that each path from a light to the eye is counted once (L light, D
 * diffuse or volume event, S specular or glossy event, E eye; straight passage is no event):
 *
 *   the eye's first diffuse surface | -ab > 0            | -ab < 0             | -ab 0
 *   L D E        (direct)           | next event         | next event          | next event
 *   L ... S D E  (last event S)     | caustic map        | global map, or the  | caustic map
 *                                   |                    | caustic map if given|
 *   L ... D D E  (last event D)     | gather rays        | global map          | none
 *   L ... V D E  (last event V)     | gather rays        | global map          | none
 *   volume in-scatter on the way    | volume map         | volume map          | volume map
 *
 * A precomputed map stands in for the global map. It holds the caustics, too, so with -ab < 0 a
 * caustic map given beside it is not asked.
 * A gather ray ends at its first diffuse surface: there next event and the whole global map.
 * With a caustic map it ends in darkness at specular surfaces; without one it goes through
 * them. Progressive passes count as -ab < 0 with both maps (for -ab 0: as -ab 0).
 * Test: partition_counts_each_path_once in tests/physics. */

typedef enum pm_estimator {
    PM_PROGRESSIVE, /* no maps named: independent passes, radius shrinking */
    PM_NEAREST,     /* maps of a fixed number of photons, N nearest */
} pm_estimator;

/* One map that the user asked for. */
typedef struct pm_map_wanted {
    bool wanted;
    bool from_file;        /* the user brings it: nothing is traced, `count` says nothing */
    uint64_t count;        /* photons; of a sequence: of each pass */
    uint32_t passes;       /* of a map job: a sequence of so many; 0: one map */
    uint32_t gather_count; /* photons an estimate; 0 = 40 */
    uint32_t gather_max;   /* > gather_count: that many or fewer, as bandwidth says; 0: fixed */
    pm_bandwidth bandwidth;
    bool precomputed; /* of the global map: irradiance from gather_count photons at */
    double fraction;  /* this share of them, the rest dropped; 0 = .25; not of files */
} pm_map_wanted;

/* What it is called: "precomputed", or as its kind. */
const char *pm_map_wanted_name(const pm_map_wanted *map, pm_map_kind kind);

#define PM_PRECOMPUTE_FRACTION .25 /* by default */

typedef struct pm_wanted {
    pm_estimator estimator;
    pm_map_wanted maps[PM_MAP_KINDS]; /* of PM_NEAREST */
    int ambient_bounces;              /* -ab */
    bool sensors;                     /* surfaces store photons whatever they are made of */
} pm_wanted;

typedef struct pm_plan_pass {
    bool needed;
    uint64_t count;
    uint32_t gather_count, gather_max;
    pm_bandwidth bandwidth;
    double fraction;  /* of a precomputed map that is made, else 0 */
    char reason[160]; /* in words why it is made or left out */
} pm_plan_pass;

typedef struct pm_plan {
    pm_plan_pass pass[PM_MAP_KINDS];
} pm_plan;

/* PM_E_RANGE for counts out of range. A map asked of a scene that cannot fill it is not an
 * error: the pass is left out with the reason. */
PM_MUST_USE pm_status pm_plan_make(const pm_world *world, const pm_wanted *wanted, pm_plan *out,
                                   pm_error *err);

#endif
