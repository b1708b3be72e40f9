#include "bench.h"

#include "base/rng.h"
#include "photons/photon_map.h"

/* Building the search structure: ten million photons on the walls of a room, in random order,
 * with one thread and with two. Targets: 1.5 CPU s, with two threads at most 1.08 times as
 * many, at most 25 bytes a photon at any time. Of several rounds the fastest counts. */

enum { PHOTONS = 10000000, ROUNDS = 3 };

static void put_on_wall(pm_rng *rng, pm_photon *out)
{
    pm_photon_record record = {.flux = {1, 1, 1}};
    double place[3], side = pm_rng_u32(rng) & 1 ? 1 : -1;
    unsigned wall = pm_rng_u32(rng) % 3;
    for (unsigned a = 0; a < 3; a++)
        place[a] = a == wall ? .9 * side : 1.8 * pm_rng_uniform(rng) - .9;
    record.position = (pm_vec3){place[0], place[1], place[2]};
    record.normal =
        (pm_vec3){wall == 0 ? -side : 0, wall == 1 ? -side : 0, wall == 2 ? -side : 0};
    record.direction = record.normal;
    pm_photon_pack(&record, 1, out);
}

static double build(const pm_photon *photons, unsigned threads, double *bytes)
{
    pm_error err = PM_ERROR_INIT;
    pm_map_header header = {.paths = 1, .flux_scale = 1, .world_scale = 1};
    pm_photon_list list = {0};
    pm_photon_map *map = NULL;
    pm_pool *pool = bench_need(pm_pool_new(threads));
    bench_check(pm_photon_list_reserve(&list, PHOTONS, &err), &err);
    bench_check(pm_photon_list_append(&list, photons, PHOTONS, &err), &err);
    bench_time start = bench_now();
    bench_check(pm_photon_map_take(&header, &list, pool, &map, &err), &err);
    double seconds = bench_since(start).cpu;
    *bytes = (double)pm_photon_map_bytes(map) / PHOTONS;
    pm_photon_map_free(map);
    pm_pool_free(pool);
    return seconds;
}

int main(void)
{
    pm_photon *photons = bench_need(malloc(PHOTONS * sizeof *photons));
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (size_t i = 0; i < PHOTONS; i++)
        put_on_wall(&rng, &photons[i]);
    bench_title("build: ten million photons on walls");
    double one = 1e30, two = 1e30, bytes = 0;
    for (int round = 0; round < ROUNDS; round++) {
        double seconds = build(photons, 1, &bytes);
        one = seconds < one ? seconds : one;
        seconds = build(photons, 2, &bytes);
        two = seconds < two ? seconds : two;
    }
    printf("one thread %.3f CPU s, two %.3f (%.3f times), %.2f bytes a photon\n", one, two,
           two / one, bytes);
    free(photons);
    return 0;
}
