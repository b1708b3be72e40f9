#ifndef PM_FORWARD_PHOTON_H
#define PM_FORWARD_PHOTON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/rgb.h"
#include "base/vec3.h"

/* The stored photon: what the forward pass writes and photon maps hold. */

typedef enum pm_map_kind {
    PM_MAP_GLOBAL,  /* every indirect hit on a diffuse surface, caustic ones included */
    PM_MAP_CAUSTIC, /* those whose last event was specular or glossy: L(D|S)*S+D */
    PM_MAP_VOLUME,  /* every scattering in a medium, the first included */
    PM_MAP_DIRECT,  /* every first hit on a diffuse surface; to be looked at, not rendered */
    PM_MAP_KINDS,
    /* Made of a global map and looked up in its place (photons/precompute.h): no kind that the
     * forward pass knows, but one that a map file may have. */
    PM_MAP_PRECOMPUTED = 16,
} pm_map_kind;

/* "global", "caustic", "volume", "direct", "precomputed" */
const char *pm_map_kind_name(pm_map_kind kind);

enum {
    PM_BATCH_PATHS = 65536,
    PM_REPLICATES = 16, /* batch b belongs to replicate b mod 16 */
};

/* 24 bytes. Positions are fixed point in the cube [-1, 1]: q = round((p + 1) * 2^31), clamped.
 * Octahedral codes after Meyer et al., "On floating-point normal vectors", EGSR 2010; axes are
 * exact. Flux is mantissa * 2^exponent relative to a scale that its map or batch carries. Each
 * channel is off by less than 2^-10 of the power of two above the largest one, up or down at
 * random (drawn from the position) so that sums of many photons are not off.
 * Tests: photon_packing_keeps_the_mean_flux, photon_packing_is_off_by_less_than_a_step. */
typedef struct pm_photon {
    uint32_t position[3];
    uint8_t normal[2];     /* octahedral; of the surface side hit; zero of a volume photon */
    uint16_t direction[2]; /* octahedral; where the photon came from (points away, wi) */
    uint8_t exponent;      /* biased by 200 */
    uint8_t flags;         /* low 4 bits replicate, bit 4 last event specular */
    uint32_t flux;         /* 3 x 10 bits, r in the low ones */
} pm_photon;

_Static_assert(sizeof(pm_photon) == 24, "a photon is 24 bytes in memory and in files");

enum { PM_PHOTON_REPLICATE = 0x0F, PM_PHOTON_SPECULAR = 0x10 };

/* A photon unpacked. Flux is in units of the scale given. */
typedef struct pm_photon_record {
    pm_vec3 position, normal, direction;
    pm_rgb flux;
    bool specular;
    unsigned replicate;
} pm_photon_record;

void pm_photon_pack(const pm_photon_record *record, double flux_scale, pm_photon *out);
void pm_photon_unpack(const pm_photon *photon, double flux_scale, pm_photon_record *out);
pm_vec3 pm_photon_position(const pm_photon *photon);
pm_vec3 pm_photon_normal(const pm_photon *photon);
pm_vec3 pm_photon_direction(const pm_photon *photon);
pm_rgb pm_photon_flux(const pm_photon *photon); /* relative to the scale */
/* The stored direction of a vector of any length > 0. */
void pm_photon_direction_code(pm_vec3 direction, uint16_t code[2]);

/* Photons of consecutive paths, in path order and within a path in order of deposit. */
typedef struct pm_batch {
    pm_map_kind kind;
    uint64_t index; /* paths [index * PM_BATCH_PATHS, + paths) */
    uint32_t paths; /* PM_BATCH_PATHS, or less in the short last batch of a map */
    uint32_t *ends; /* [paths]: photons of paths 0..i together; NULL if unknown */
    size_t count;
    pm_photon *photons; /* [count] */
    /* Flux balance of the paths: sums over them, each of which carries the whole power
     * [W/scale^2]. In expectation emitted = absorbed + escaped; what the bound on events cut
     * off counts as absorbed. Zero of a truncated batch. Test: flux_balance_*. */
    pm_rgb emitted, absorbed, escaped;
} pm_batch;

void pm_batch_clear(pm_batch *batch); /* frees what it holds */

#endif
