#include "base/rng.h"

#include <string.h>

static inline void philox_round(uint32_t c[4], const uint32_t key[2])
{
    uint64_t p0 = (uint64_t)0xD2511F53U * c[0];
    uint64_t p1 = (uint64_t)0xCD9E8D57U * c[2];
    uint32_t c0 = (uint32_t)(p1 >> 32) ^ c[1] ^ key[0];
    uint32_t c2 = (uint32_t)(p0 >> 32) ^ c[3] ^ key[1];
    c[1] = (uint32_t)p1;
    c[3] = (uint32_t)p0;
    c[0] = c0;
    c[2] = c2;
}

static void philox_block(pm_rng *rng)
{
    uint32_t key[2] = {rng->key[0], rng->key[1]};
    memcpy(rng->block, rng->counter, sizeof rng->block);
    for (int round = 0; round < 10; round++) {
        philox_round(rng->block, key);
        key[0] += 0x9E3779B9U;
        key[1] += 0xBB67AE85U;
    }
    rng->counter[0]++;
    rng->used = 0;
}

void pm_rng_init(pm_rng *rng, uint64_t seed, pm_rng_purpose purpose, uint64_t index)
{
    rng->key[0] = (uint32_t)seed;
    rng->key[1] = (uint32_t)(seed >> 32);
    rng->counter[0] = (uint32_t)purpose << 24;
    rng->counter[1] = 0;
    rng->counter[2] = (uint32_t)index;
    rng->counter[3] = (uint32_t)(index >> 32);
    rng->used = 4;
}

void pm_rng_bounce(pm_rng *rng, uint32_t bounce)
{
    rng->counter[0] &= 0xFF000000U;
    rng->counter[1] = bounce;
    rng->used = 4;
}

uint32_t pm_rng_u32(pm_rng *rng)
{
    if (rng->used == 4)
        philox_block(rng);
    return rng->block[rng->used++];
}

double pm_rng_uniform(pm_rng *rng)
{
    return pm_rng_u32(rng) * 0x1p-32;
}
