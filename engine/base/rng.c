#include "base/rng.h"

void pm_rng_refill(pm_rng *rng)
{
    uint32_t k0 = rng->key[0], k1 = rng->key[1];
    uint32_t c0 = rng->counter[0], c1 = rng->counter[1], c2 = rng->counter[2],
             c3 = rng->counter[3];
#pragma GCC unroll 10
    for (int round = 0; round < 10; round++) {
        uint64_t p0 = (uint64_t)0xD2511F53U * c0, p1 = (uint64_t)0xCD9E8D57U * c2;
        c0 = (uint32_t)(p1 >> 32) ^ c1 ^ k0;
        c1 = (uint32_t)p1;
        c2 = (uint32_t)(p0 >> 32) ^ c3 ^ k1;
        c3 = (uint32_t)p0;
        k0 += 0x9E3779B9U;
        k1 += 0xBB67AE85U;
    }
    rng->block[0] = c0;
    rng->block[1] = c1;
    rng->block[2] = c2;
    rng->block[3] = c3;
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
