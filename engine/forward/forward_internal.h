#ifndef PM_FORWARD_INTERNAL_H
#define PM_FORWARD_INTERNAL_H

#include <stdatomic.h>
#include <stdint.h>

#include "forward/choice.h"
#include "forward/forward.h"
#include "world/lamps.h"
#include "world/openings.h"
#include "world/ports.h"

enum {
    PM_FORWARD_PREPASS_PATHS = 1 << 14,
    PM_FORWARD_PHOTONS_A_PATH = 4, /* stored, on average, at most */
};

struct pm_recorders;

/* What changes while a const pm_forward is shared. */
struct pm_forward_counters {
    atomic_uint_fast64_t nonfinite, rays;
    /* Of a batch that ended, for the next one: memory given back to the system is slow to come
     * by again. NULL while a batch has them. */
    _Atomic(struct pm_recorders *) spare;
};

struct pm_forward {
    const pm_world *world; /* borrowed; must outlive this */
    uint64_t seed;
    uint32_t max_events;
    struct pm_choice choice; /* what the options name */
    pm_ports *ports;         /* NULL: distant light comes from everywhere */
    pm_openings *openings;   /* NULL: there are none to aim at */
    pm_lamps *lamps;         /* outside; NULL: there are none to aim */
    struct pm_aim *aim;      /* of caustic paths; NULL: they are those of the other kinds */
    double flux_scale;
    char note[256]; /* about what is aimed */
    pm_rgb emitted;                   /* in the pre-run, on average [W / scale^2] */
    double probability[PM_MAP_KINDS]; /* of storing a deposit */
    double rate[PM_MAP_KINDS];        /* photons stored a path */
    double stretches[PM_MAP_KINDS];   /* traced a path */
    struct pm_forward_counters *counters;
};

#endif
