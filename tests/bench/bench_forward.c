#include "bench.h"

#include "base/pool.h"
#include "forward/forward.h"

/* Photon paths emitted and photons stored a CPU second on the peers box, both surface maps at
 * once, with one thread and with two. Target: 1.5 M paths a CPU second; CPU seconds of two
 * threads at most 1.08 times those of one. The runs alternate, and of each the one with the
 * least CPU seconds counts: other work on the machine disturbed it least. */

enum { ROUNDS = 7, BATCHES = 6 };

struct result {
    bench_time time;
    double paths, photons[PM_MAP_KINDS];
};

static struct result run_batches(const pm_forward *forward, pm_pool *pool)
{
    pm_error err = PM_ERROR_INIT;
    struct result result = {.paths = BATCHES * (double)PM_BATCH_PATHS};
    bench_time start = bench_now();
    for (uint64_t index = 0; index < BATCHES; index++) {
        pm_batch out[PM_MAP_KINDS] = {0};
        unsigned kinds = 1U << PM_MAP_GLOBAL | 1U << PM_MAP_CAUSTIC;
        bench_check(pm_forward_batch(forward, index, kinds, pool, NULL, NULL, out, &err), &err);
        for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
            result.photons[kind] += (double)out[kind].count;
            pm_batch_clear(&out[kind]);
        }
    }
    result.time = bench_since(start);
    return result;
}

static void keep_better(struct result *best, const struct result *other)
{
    if (!best->paths || other->time.cpu < best->time.cpu)
        *best = *other;
}

static void print_row(unsigned threads, const struct result *r)
{
    printf("%7u %8.3f %8.3f %16.3f %18.3f %18.3f\n", threads, r->time.cpu, r->time.wall,
           1e-6 * r->paths / r->time.cpu, 1e-6 * r->photons[PM_MAP_GLOBAL] / r->time.cpu,
           1e-6 * r->photons[PM_MAP_CAUSTIC] / r->time.cpu);
}

int main(void)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = bench_world(PM_SOURCE_DIR "/scenes/peers_box/scene.rad");
    pm_pool *pools[2] = {bench_need(pm_pool_new(1)), bench_need(pm_pool_new(2))};
    struct result results[2] = {0};
    pm_forward *forward = NULL;
    pm_forward_options options = pm_forward_defaults();
    bench_check(pm_forward_new(world, &options, pools[0], &forward, &err), &err);
    for (int round = 0; round < ROUNDS; round++)
        for (int i = 0; i < 2; i++) {
            struct result result = run_batches(forward, pools[i]);
            keep_better(&results[i], &result);
        }

    bench_title("forward: photon paths on the peers box");
    printf("threads    CPU s   wall s  M paths / CPU s  M global / CPU s  M caustic / CPU s\n");
    for (int i = 0; i < 2; i++)
        print_row(pm_pool_threads(pools[i]), &results[i]);
    printf("two threads to one: %.3f of the CPU seconds, %.3f of the wall seconds\n",
           results[1].time.cpu / results[0].time.cpu,
           results[1].time.wall / results[0].time.wall);
    pm_forward_free(forward);
    for (int i = 0; i < 2; i++)
        pm_pool_free(pools[i]);
    pm_world_free(world);
    return 0;
}
