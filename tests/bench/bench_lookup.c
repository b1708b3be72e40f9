#include "bench.h"

#include <math.h>

#include "base/rng.h"
#include "forward/forward.h"
#include "photons/photon_map.h"

/* Look-ups of 50 photons among a million a CPU second, one thread: nearest, and within the
 * radius that holds 50. Queries are further photons of the same light, along the Morton curve
 * (as the pixels of a picture nearly are), in random order, and raised from the surfaces, where
 * hardly a photon counts. Target: 0.5 M nearest look-ups a CPU second in order on evenly lit
 * walls, a third of that on the caustics of the peers box. Of several rounds the fastest
 * counts: other work on the machine disturbed it least. */

enum { PHOTONS = 1000000, QUERIES = 100000, GATHER = 50, ROUNDS = 7 };

struct queries {
    pm_vec3 point[QUERIES], normal[QUERIES];
    double radius[QUERIES];
};

/* Six walls of a room, each lit evenly. */
static void put_on_wall(pm_rng *rng, pm_photon *out)
{
    pm_photon_record record = {.flux = {1, 1, 1}};
    double along = 1.8 * pm_rng_uniform(rng) - .9, across = 1.8 * pm_rng_uniform(rng) - .9;
    unsigned wall = pm_rng_u32(rng) % 6;
    double side = wall & 1 ? 1 : -1;
    pm_vec3 n[3] = {{side, 0, 0}, {0, side, 0}, {0, 0, side}};
    record.normal = pm_vec3_negate(n[wall / 2]);
    record.position = pm_vec3_scale(n[wall / 2], .9);
    record.position = pm_vec3_madd(record.position, along, n[(wall / 2 + 1) % 3]);
    record.position = pm_vec3_madd(record.position, across, n[(wall / 2 + 2) % 3]);
    record.direction = record.normal;
    pm_photon_pack(&record, 1, out);
}

static void light_walls(pm_batch *photons)
{
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (size_t i = 0; i < photons->count; i++)
        put_on_wall(&rng, &photons->photons[i]);
}

/* Photons of a scene, from as many paths as it takes. */
static void trace_photons(const char *scene, pm_map_kind kind, pm_batch *photons)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = bench_world(scene);
    pm_pool *pool = bench_need(pm_pool_new(1));
    pm_forward *forward = NULL;
    pm_forward_options options = pm_forward_defaults();
    bench_check(pm_forward_new(world, &options, pool, &forward, &err), &err);
    size_t count = 0;
    for (uint64_t index = 0; count < photons->count; index++) {
        pm_batch out[PM_MAP_KINDS] = {0};
        bench_check(pm_forward_batch(forward, index, 1U << kind, pool, NULL, NULL, out, &err),
                    &err);
        const pm_batch *more = &out[kind];
        for (size_t i = 0; i < more->count && count < photons->count; i++)
            photons->photons[count++] = more->photons[i];
        pm_batch_clear(&out[kind]);
    }
    pm_forward_free(forward);
    pm_pool_free(pool);
    pm_world_free(world);
}

static pm_photon_map *build(pm_batch *photons, size_t count, double *seconds)
{
    pm_error err = PM_ERROR_INIT;
    pm_map_header header = {
        .kind = photons->kind, .paths = 1, .flux_scale = 1, .world_scale = 1};
    pm_photon_map *map = NULL;
    pm_batch part = *photons;
    part.count = count;
    bench_time start = bench_now();
    bench_check(pm_photon_map_build(&header, &part, 1, NULL, &map, &err), &err);
    *seconds = bench_since(start).cpu;
    return map;
}

/* The photons behind the map's own, in stored order of a map of their own. */
static void put_queries(const pm_photon_map *map, pm_batch *photons, struct queries *out)
{
    double seconds;
    pm_batch rest = *photons;
    rest.photons += PHOTONS;
    pm_photon_map *sorted = build(&rest, QUERIES, &seconds);
    for (size_t i = 0; i < QUERIES; i++) {
        pm_photon photon;
        pm_photon_map_photon(sorted, i, &photon);
        out->point[i] = pm_photon_position(&photon);
        out->normal[i] = pm_photon_normal(&photon);
        out->radius[i] = pm_photon_map_nearest(map, out->point[i], out->normal[i], GATHER,
                                               INFINITY, PM_PHOTONS_ALL, NULL)
                             .radius;
    }
    pm_photon_map_free(sorted);
}

static void shuffle(struct queries *q)
{
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    for (size_t i = QUERIES - 1; i > 0; i--) {
        size_t k = pm_rng_u32(&rng) % (i + 1);
        pm_vec3 point = q->point[i], normal = q->normal[i];
        double radius = q->radius[i];
        q->point[i] = q->point[k], q->normal[i] = q->normal[k], q->radius[i] = q->radius[k];
        q->point[k] = point, q->normal[k] = normal, q->radius[k] = radius;
    }
}

/* M look-ups a CPU second; `used` counts the photons, so that nothing is optimised away. */
static double look_up(const pm_photon_map *map, const struct queries *q, int nearest,
                      double *used)
{
    double best = 0;
    for (int round = 0; round < ROUNDS; round++) {
        double photons = 0;
        bench_time start = bench_now();
        for (size_t i = 0; i < QUERIES; i++)
            photons += nearest ? pm_photon_map_nearest(map, q->point[i], q->normal[i], GATHER,
                                                       INFINITY, PM_PHOTONS_ALL, NULL)
                                     .count
                               : pm_photon_map_within(map, q->point[i], q->normal[i],
                                                      q->radius[i], PM_PHOTONS_ALL, NULL)
                                     .count;
        best = fmax(best, 1e-6 * QUERIES / bench_since(start).cpu);
        *used = photons / QUERIES;
    }
    return best;
}

static void measure(const char *name, pm_batch *photons, struct queries *queries)
{
    double seconds, used;
    pm_photon_map *map = build(photons, PHOTONS, &seconds);
    put_queries(map, photons, queries);
    for (int random = 0; random < 2; random++) {
        double nearest = look_up(map, queries, 1, &used);
        double within = look_up(map, queries, 0, &used);
        printf("%-24s %-7s %15.3f %15.3f %8.1f\n", name, random ? "random" : "sorted", nearest,
               within, used);
        shuffle(queries);
    }
    printf("%-24s build %.3f CPU s, %.2f bytes a photon\n", name, seconds,
           (double)pm_photon_map_bytes(map) / PHOTONS);
    pm_photon_map_free(map);
}

int main(void)
{
    pm_batch photons = {.count = PHOTONS + QUERIES};
    photons.photons = bench_need(calloc(photons.count, sizeof *photons.photons));
    struct queries *queries = bench_need(malloc(sizeof *queries));
    const char *scene = PM_SOURCE_DIR "/scenes/peers_box/scene.rad";
    bench_title("lookup: 50 photons among a million, one thread");
    printf("map                      queries M nearest/CPU s  M within/CPU s  photons\n");
    light_walls(&photons);
    measure("evenly lit walls", &photons, queries);
    trace_photons(scene, PM_MAP_CAUSTIC, &photons);
    measure("caustics of peers box", &photons, queries);
    photons.count = QUERIES;
    photons.photons += PHOTONS;
    trace_photons(scene, PM_MAP_GLOBAL, &photons);
    photons.count += PHOTONS;
    photons.photons -= PHOTONS;
    measure("the same, all surfaces", &photons, queries);
    free(queries);
    free(photons.photons);
    return 0;
}
