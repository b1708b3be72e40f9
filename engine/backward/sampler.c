#include "backward/backward_internal.h"
#include "base/sobol.h"

static const struct {
    unsigned first, count; /* Sobol dimensions */
    unsigned draws;        /* numbers in all */
} uses[] = {
    [PM_SAMPLE_LENS] = {0, 2, 2},
    [PM_SAMPLE_LIGHT] = {2, 3, 3},
    [PM_SAMPLE_GATHER] = {5, 2, 2},
    [PM_SAMPLE_LOBE] = {7, 1, 3},
};

/* Pass j takes point j / 16 of the sequence of replicate j mod 16, so that replicates are
 * independent of each other. */
void pm_sampler_init(struct pm_sampler *sampler, uint64_t seed, uint32_t pass, uint32_t item)
{
    uint32_t scramble = pm_hash_u32((uint32_t)seed, (uint32_t)(seed >> 32));
    scramble = pm_hash_u32(scramble, PM_RNG_CAMERA << 8 | pass % PM_REPLICATES);
    sampler->scramble = pm_hash_u32(scramble, item);
    sampler->index = pass / PM_REPLICATES;
    sampler->used = 0;
    sampler->lookups = 0;
    sampler->queue = NULL;
    sampler->slot = 0;
    pm_rng_init(&sampler->rng, seed, PM_RNG_CAMERA, (uint64_t)pass << 32 | item);
}

void pm_sampler_draw(struct pm_sampler *sampler, enum pm_sample_use use, double u[3])
{
    unsigned from_sobol = sampler->used & 1U << use ? 0 : uses[use].count;
    sampler->used |= 1U << use;
    for (unsigned i = 0; i < uses[use].draws; i++)
        u[i] = i < from_sobol ? pm_sobol(sampler->index, uses[use].first + i, sampler->scramble)
                              : pm_rng_uniform(&sampler->rng);
}
