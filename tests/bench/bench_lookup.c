#include "bench.h"

#include <math.h>

#include "base/rng.h"
#include "forward/forward.h"
#include "photons/photon_map.h"
#include "photons/precompute.h"

/* Look-ups among photons on surfaces, M a CPU second, one thread, in batches: within the radius
 * that holds 50, of the 50 nearest, and of a precomputed map: the irradiance that the nearest
 * one holds. Queries are further photons of the same light, along the Morton curve (as the
 * pixels of a picture nearly are), and in random order. Targets in order among a million: 8,
 * 1.5 and 8; a third of each among 10^7 and on the uneven caustic map. Of several rounds the
 * fastest counts: other work on the machine disturbed it least. At last the same on two threads
 * at a time, whose CPU seconds should be at most 1.08 times one's. */

enum { QUERIES = 100000, GATHER = 50, ROUNDS = 7 };

static pm_photon_query queries[QUERIES];
static pm_estimate answers[QUERIES];

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
static void put_queries(const pm_photon_map *map, pm_batch *photons, size_t count)
{
    double seconds;
    pm_batch rest = *photons;
    rest.photons += count;
    pm_photon_map *sorted = build(&rest, QUERIES, &seconds);
    for (size_t i = 0; i < QUERIES; i++) {
        pm_photon photon;
        pm_photon_map_photon(sorted, i, &photon);
        queries[i] = (pm_photon_query){.point = pm_photon_position(&photon),
                                       .normal = pm_photon_normal(&photon),
                                       .radius = INFINITY};
    }
    pm_photon_map_nearest_batch(map, queries, QUERIES, GATHER, PM_PHOTONS_ALL, answers);
    for (size_t i = 0; i < QUERIES; i++)
        queries[i].radius = answers[i].radius;
    pm_photon_map_free(sorted);
}

static void shuffle(void)
{
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    for (size_t i = QUERIES - 1; i > 0; i--) {
        size_t k = pm_rng_u32(&rng) % (i + 1);
        pm_photon_query swap = queries[i];
        queries[i] = queries[k];
        queries[k] = swap;
    }
}

enum question { WITHIN, NEAREST, PRECOMPUTED, QUESTIONS };

struct part {
    const pm_photon_map *map;
    enum question question;
};

enum { PIECE = 1000 };

static void ask(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    const struct part *part = context;
    size_t first = piece * PIECE;
    if (part->question == WITHIN)
        pm_photon_map_within_batch(part->map, queries + first, PIECE, PM_PHOTONS_ALL,
                                   answers + first);
    else if (part->question == NEAREST)
        pm_photon_map_nearest_batch(part->map, queries + first, PIECE, GATHER, PM_PHOTONS_ALL,
                                    answers + first);
    else /* irradiances are flux's bits: their values do not matter to the time */
        pm_photon_map_precomputed_batch(part->map, queries + first, PIECE, answers + first);
}

/* M look-ups a CPU second. */
static double look_up(const pm_photon_map *map, enum question question, pm_pool *pool)
{
    double best = 0;
    struct part part = {map, question};
    for (int round = 0; round < ROUNDS; round++) {
        bench_time start = bench_now();
        pm_pool_run(pool, QUERIES / PIECE, ask, &part);
        best = fmax(best, 1e-6 * QUERIES / bench_since(start).cpu);
    }
    return best;
}

static double photons_used(void)
{
    double photons = 0;
    for (size_t i = 0; i < QUERIES; i++)
        photons += answers[i].count;
    return photons / QUERIES;
}

static void measure(const char *name, pm_batch *photons, size_t count)
{
    double seconds;
    pm_pool *one = bench_need(pm_pool_new(1)), *two = bench_need(pm_pool_new(2));
    pm_photon_map *map = build(photons, count, &seconds);
    put_queries(map, photons, count);
    for (int kind = 0; kind < 3; kind++) { /* in order; on two threads; in random order */
        static const char *const names[] = {"sorted", "sorted, two threads", "random"};
        if (kind == 2)
            shuffle();
        printf("%-24s %-20s", name, names[kind]);
        for (int question = QUESTIONS; question--;) {
            double rate = look_up(map, (enum question)question, kind == 1 ? two : one);
            printf(" %10.3f", rate);
        }
        printf(" %8.1f\n", photons_used());
    }
    printf("%-24s build %.3f CPU s, %.2f bytes a photon\n", name, seconds,
           (double)pm_photon_map_bytes(map) / (double)count);
    pm_photon_map_free(map);
    pm_pool_free(one);
    pm_pool_free(two);
}

int main(void)
{
    enum { MILLION = 1000000 };
    pm_batch photons = {.count = 10 * MILLION + QUERIES};
    photons.photons = bench_need(calloc(photons.count, sizeof *photons.photons));
    const char *scene = PM_SOURCE_DIR "/scenes/peers_box/scene.rad";
    bench_title("lookup: M look-ups a CPU second");
    printf("map                      queries            precomputed       N=%d     radius "
           "photons\n",
           GATHER);
    photons.count = MILLION + QUERIES;
    light_walls(&photons);
    measure("10^6, evenly lit walls", &photons, MILLION);
    trace_photons(scene, PM_MAP_CAUSTIC, &photons);
    measure("10^6, caustics of peers", &photons, MILLION);
    photons.kind = PM_MAP_GLOBAL;
    trace_photons(scene, PM_MAP_GLOBAL, &photons);
    measure("10^6, global of peers", &photons, MILLION);
    photons.count = 10 * MILLION + QUERIES;
    light_walls(&photons);
    measure("10^7, evenly lit walls", &photons, 10 * MILLION);
    free(photons.photons);
    return 0;
}
