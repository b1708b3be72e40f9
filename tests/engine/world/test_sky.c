#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "numbers.h"
#include "world/sky.h"

enum { SOURCES = 400 };

static pm_world *world_of_sources(double half_angle, uint64_t seed)
{
    pm_world *world = calloc(1, sizeof *world);
    assert_non_null(world);
    world->distants = pm_arena_array(&world->arena, SOURCES, sizeof *world->distants);
    assert_non_null(world->distants);
    world->distant_count = SOURCES;
    pm_rng rng;
    pm_rng_init(&rng, seed, PM_RNG_PATH, 0);
    for (int i = 0; i < SOURCES; i++) {
        double u[3];
        draw(&rng, u, 3);
        double half = half_angle * (i % 3 ? u[2] : 1);
        pm_vec3 d = i ? pm_warp_sphere(u[0], u[1]) : (pm_vec3){0, 0, 1};
        world->distants[i] = (struct pm_distant){d, half, pm_versine(half), 0, 0};
    }
    return world;
}

static void count_visit(void *context, uint32_t source)
{
    uint32_t *seen = context;
    seen[source]++;
}

static void compare(const pm_world *world, const struct pm_sky_index *index, pm_vec3 w)
{
    uint32_t seen[SOURCES] = {0};
    pm_sky_index_visit(index, world, w, count_visit, seen);
    for (int i = 0; i < SOURCES; i++) {
        pm_vec3 off = pm_vec3_sub(w, world->distants[i].direction);
        uint32_t wanted = pm_vec3_dot(off, off) <= 2 * world->distants[i].versine;
        if (seen[i] != wanted)
            fail_msg("source %d visited %u times at %g %g %g", i, seen[i], w.x, w.y, w.z);
    }
}

/* Every source that covers a direction, and each once; poles, the seam at azimuth pi and the
 * rims of the sources among the directions. */
static void index_finds_what_a_search_through_all_finds(void **state)
{
    (void)state;
    const double halves[] = {1e-7, .004, .1, .17, .6, PM_PI};
    for (uint64_t k = 0; k < 6; k++) {
        pm_world *world = world_of_sources(halves[k], k);
        struct pm_sky_index *index;
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_sky_index_build(world, &index, &err), PM_OK);
        pm_rng rng;
        pm_rng_init(&rng, 100 + k, PM_RNG_PATH, 0);
        for (int i = 0; i < 3000; i++) {
            double u[2];
            draw(&rng, u, 2);
            const struct pm_distant *d = &world->distants[i % SOURCES];
            pm_frame frame = pm_frame_make(d->direction);
            pm_vec3 rim = pm_warp_cone(1 - u[0] * u[0] * 1e-6, u[1], d->versine);
            compare(world, index, pm_warp_sphere(u[0], u[1]));
            compare(world, index, pm_frame_to_world(&frame, rim));
        }
        compare(world, index, (pm_vec3){0, 0, 1});
        compare(world, index, (pm_vec3){0, 0, -1});
        compare(world, index, (pm_vec3){-1, 0, 0});
        compare(world, index, (pm_vec3){-1, -0., 0});
        pm_arena_clear(&world->arena);
        free(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(index_finds_what_a_search_through_all_finds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
