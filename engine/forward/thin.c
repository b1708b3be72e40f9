#include <assert.h>

#include "base/rng.h"
#include "forward/forward.h"

void pm_batch_thin(pm_batch *batch, uint64_t seed, double probability)
{
    assert(batch->ends || !batch->count);
    if (!(probability < 1) || !batch->count)
        return;
    uint64_t first = batch->index * PM_BATCH_PATHS;
    size_t kept = 0;
    for (uint32_t path = 0, at = 0; path < batch->paths; path++) {
        pm_rng rng;
        if (at < batch->ends[path])
            pm_rng_init(&rng, seed, PM_RNG_THIN, first + path);
        for (; at < batch->ends[path]; at++)
            if (pm_rng_uniform(&rng) < probability)
                batch->photons[kept++] = batch->photons[at];
        batch->ends[path] = (uint32_t)kept;
    }
    batch->count = kept;
}
