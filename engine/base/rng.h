#ifndef PM_BASE_RNG_H
#define PM_BASE_RNG_H

#include <stdint.h>

/* Philox 4x32-10, a counter-based generator: the numbers depend on (seed, purpose, index,
 * bounce) and their order within that bounce, never on threads or on what was drawn elsewhere.
 * Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
 * Test: rng_philox_known_answers. */

/* What a stream is for. Append only: numbers are part of every stored photon. */
typedef enum pm_rng_purpose {
    PM_RNG_PATH = 1,     /* forward paths; index = path number */
    PM_RNG_PREPASS = 2,  /* forward paths of the storage-probability pre-run */
    PM_RNG_CAMERA = 3,   /* backward paths; index = pass << 32 | pixel or sensor */
    PM_RNG_SCRAMBLE = 4, /* Sobol scrambles; index = replicate */
    PM_RNG_SURVEY = 5,   /* paths of scene check; index = path number */
    PM_RNG_AIMED = 6,    /* forward paths of caustic maps */
    PM_RNG_AIMED_PREPASS = 7,
    PM_RNG_THIN = 8,        /* which photons a small map takes; index = path number */
    PM_RNG_PRECOMPUTE = 20 /* places about precomputed photons; index = photon */
} pm_rng_purpose;

typedef struct pm_rng {
    uint32_t key[2];
    uint32_t counter[4];
    uint32_t block[4];
    int used; /* words of `block` handed out */
} pm_rng;

void pm_rng_init(pm_rng *rng, uint64_t seed, pm_rng_purpose purpose, uint64_t index);

/* Jumps to the numbers of another bounce (0 after init). */
void pm_rng_bounce(pm_rng *rng, uint32_t bounce);

/* The next four words; called when `block` is used up. */
void pm_rng_refill(pm_rng *rng);

static inline uint32_t pm_rng_u32(pm_rng *rng)
{
    if (rng->used == 4)
        pm_rng_refill(rng);
    return rng->block[rng->used++];
}

/* Uniform in [0, 1), 32 random bits. */
static inline double pm_rng_uniform(pm_rng *rng)
{
    return pm_rng_u32(rng) * 0x1p-32;
}

#endif
