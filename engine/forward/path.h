#ifndef PM_FORWARD_PATH_H
#define PM_FORWARD_PATH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/rgb.h"
#include "base/rng.h"
#include "base/sobol.h"
#include "forward/aim.h"
#include "forward/photon.h"
#include "world/lamps.h"
#include "world/openings.h"
#include "world/ports.h"
#include "world/world.h"

/* One photon path from its light to its end. Shared by the files of this folder. */

/* What every path of a run has in common. */
struct pm_tracer {
    const pm_world *world;
    const struct pm_choice *choice; /* NULL: everything is stored, and nothing cut off */
    uint64_t seed;
    pm_rng_purpose purpose;
    uint32_t max_events;                    /* most scatterings at surfaces */
    uint32_t max_collisions;                /* in media */
    uint32_t max_scatterings;               /* together */
    const pm_aim *aim;                      /* NULL: unaimed */
    uint32_t scramble[PM_SOBOL_DIMENSIONS]; /* of the emission's Sobol sequence */
    const pm_ports *ports;                  /* NULL: distant light comes from everywhere */
    const pm_openings *openings;            /* NULL: unaimed */
    const pm_lamps *lamps;                  /* NULL: unaimed */
};

/* Fills in `scramble` for a replicate. */
void pm_tracer_set_replicate(struct pm_tracer *tracer, unsigned replicate);

struct pm_photon_buffer {
    pm_photon *photons;
    size_t count, capacity;
};

/* What a thread writes down while it traces. */
struct pm_recorder {
    /* set by the caller */
    unsigned kinds;   /* bit (1 << kind): stored */
    unsigned ignored; /* bits that are not even counted: what a batch does not store */
    unsigned replicate;
    double flux_scale;
    double probability[PM_MAP_KINDS]; /* of storing a deposit */

    struct pm_photon_buffer buffer[PM_MAP_KINDS];
    uint64_t deposits[PM_MAP_KINDS]; /* before the storage probability, stored or not */
    pm_rgb emitted, absorbed, escaped;
    uint64_t nonfinite, rays;
    bool out_of_memory; /* photons were lost; the run must fail */
};

/* Path `number`, emitted by point `sobol_index` of the replicate's sequence. Allocates nothing
 * but room for photons. */
void pm_path_trace(const struct pm_tracer *tracer, uint64_t number, uint32_t sobol_index,
                   struct pm_recorder *recorder);

#endif
