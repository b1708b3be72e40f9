#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "forward/forward.h"
#include "forward/path.h"

/* Light of a lamp outside on the floor of a closed room: photons of the forward pass against
 * paths that nothing aims. The standard error is that of 16 batches each; 6 of them at 30
 * degrees of freedom: 1.5e-6. */

enum { BATCHES = 16, PLAIN_PATHS = 1 << 18 };
#define SIGMAS 6.0

/* The lid's hole is .4 by .4; a pane in it has its normal up. */
#define ROOM                                                                                   \
    "void plastic grey 0 0 5 .5 .6 .7 0 0\n"                                                   \
    "grey polygon w1 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"                                 \
    "grey polygon w2 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"                                 \
    "grey polygon w3 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"                                     \
    "grey polygon w4 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"                                 \
    "grey polygon w5 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n"                                     \
    "grey polygon lid 0 0 30 -1 -1 1 -1 1 1 1 1 1 1 -1 1 -1 -1 1 -.2 -.2 1 .2 -.2 1 "          \
    ".2 .2 1 -.2 .2 1 -.2 -.2 1\n"
#define PANE                                                                                   \
    "void glass clear 0 0 3 .9 .8 .7\n"                                                        \
    "clear polygon p 0 0 12 -.2 -.2 1 .2 -.2 1 .2 .2 1 -.2 .2 1\n"
#define BALL   "void dielectric crystal 0 0 5 1 1 1 1.5 0\ncrystal sphere ball 0 0 4 0 0 -.5 .3\n"
#define LAMP   "void light l 0 0 3 900 900 900\nl sphere lamp 0 0 4 .2 .1 3 .1\n"
#define INDOOR "void light i 0 0 3 1 1 1\ni sphere indoor 0 0 4 .6 .6 .6 .05\n"
#define SKY    "void glow sky 0 0 4 1 1 1 0 sky source dome 0 0 4 0 0 1 180\n"

/* Of the batches: flux on the floor from above [W / scale^2 a path], photons there. */
struct floor {
    double sum, squares, photons;
};

static void add_photons(const pm_photon *photons, size_t count, double scale, bool specular,
                        double paths, struct floor *out)
{
    double flux = 0;
    for (size_t i = 0; i < count; i++) {
        pm_photon_record r;
        pm_photon_unpack(&photons[i], scale, &r);
        if ((specular && !r.specular) || !(r.normal.z > .9))
            continue;
        flux += r.flux.g;
        out->photons += 1 / (paths * BATCHES);
    }
    flux /= paths;
    out->sum += flux / BATCHES;
    out->squares += flux * flux / BATCHES;
}

static double square_error(const struct floor *f)
{
    return (f->squares - f->sum * f->sum) / (BATCHES - 1);
}

static void expect_equal(const char *scene, const struct floor *a, const struct floor *b)
{
    double error = sqrt(square_error(a) + square_error(b));
    if (!(fabs(a->sum - b->sum) <= SIGMAS * error) || !(b->sum > 0))
        fail_msg("%s: %g aimed, %g unaimed, error %g", scene, a->sum, b->sum, error);
}

static void trace_plain(const pm_world *world, struct floor *all, struct floor *specular)
{
    struct pm_tracer tracer = {.world = world,
                               .seed = 5,
                               .purpose = PM_RNG_PATH,
                               .max_events = 1000,
                               .max_collisions = 1000,
                               .max_scatterings = 1000};
    struct pm_recorder r = {.kinds = 1U << PM_MAP_GLOBAL, .flux_scale = 1};
    struct pm_photon_buffer *photons = &r.buffer[PM_MAP_GLOBAL];
    r.probability[PM_MAP_GLOBAL] = 1;
    for (unsigned b = 0; b < BATCHES; b++) {
        pm_tracer_set_replicate(&tracer, b);
        photons->count = 0;
        for (uint32_t i = 0; i < PLAIN_PATHS; i++)
            pm_path_trace(&tracer, (uint64_t)b * PLAIN_PATHS + i, i, &r);
        add_photons(photons->photons, photons->count, 1, false, PLAIN_PATHS, all);
        add_photons(photons->photons, photons->count, 1, true, PLAIN_PATHS, specular);
    }
    assert_false(r.out_of_memory);
    free(photons->photons);
}

static void trace_forward(const pm_forward *forward, pm_pool *pool, pm_map_kind kind,
                          bool specular, struct floor *out)
{
    pm_error err = PM_ERROR_INIT;
    double p = pm_forward_storage_probability(forward, kind);
    double scale = pm_forward_flux_scale(forward) / p;
    for (uint64_t b = 0; b < BATCHES; b++) {
        pm_batch batches[PM_MAP_KINDS] = {0};
        assert_int_equal(
            pm_forward_batch(forward, b, 1U << kind, pool, NULL, NULL, batches, &err), PM_OK);
        add_photons(batches[kind].photons, batches[kind].count, scale, specular, PM_BATCH_PATHS,
                    out);
        pm_batch_clear(&batches[kind]);
    }
}

static pm_forward *forward_of(const pm_world *world, const char *port, pm_pool *pool)
{
    pm_error err = PM_ERROR_INIT;
    pm_forward_options options = pm_forward_defaults();
    pm_port_option named = {port, PM_PORT_BACK};
    pm_forward *forward = NULL;
    options.ports = &named;
    options.port_count = port ? 1 : 0;
    if (pm_forward_new(world, &options, pool, &forward, &err))
        fail_msg("%s", err.text);
    return forward;
}

static const struct {
    const char *text, *port;
    double gain; /* in photons a path, at least; the closed form of world.lamps gives 39 */
} rooms[] = {
    {ROOM LAMP, NULL, 25},         {ROOM PANE LAMP, NULL, 25},
    {ROOM PANE LAMP, "clear", 35}, {ROOM LAMP INDOOR, NULL, 1},
    {ROOM BALL LAMP, NULL, 25},    {ROOM BALL PANE LAMP INDOOR, NULL, 1},
};

static void aimed_lamps_light_the_floor_as_unaimed_paths_do(void **state)
{
    (void)state;
    pm_pool *pool = pm_pool_new(2);
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        pm_world *world = world_of(rooms[i].text);
        pm_forward *forward = forward_of(world, rooms[i].port, pool);
        struct floor plain = {0}, specular = {0}, global = {0}, caustic = {0};
        assert_non_null(strstr(pm_forward_note(forward), "lamp outside"));
        trace_plain(world, &plain, &specular);
        trace_forward(forward, pool, PM_MAP_GLOBAL, false, &global);
        expect_equal(rooms[i].text, &global, &plain);
        if (!(global.photons > rooms[i].gain * plain.photons))
            fail_msg("%zu: %g photons a path, %g unaimed", i, global.photons, plain.photons);
        if (strstr(rooms[i].text, "crystal")) {
            trace_forward(forward, pool, PM_MAP_CAUSTIC, true, &caustic);
            expect_equal("caustic", &caustic, &specular);
        }
        pm_forward_free(forward);
        pm_world_free(world);
    }
    pm_pool_free(pool);
}

/* A sky, through openings or ports, keeps its photons' mean beside an aimed lamp. */
static void lamps_and_sky_are_aimed_together(void **state)
{
    (void)state;
    pm_pool *pool = pm_pool_new(2);
    pm_world *world = world_of(ROOM PANE LAMP SKY);
    struct floor plain = {0}, specular = {0};
    trace_plain(world, &plain, &specular);
    for (int named = 0; named < 2; named++) {
        pm_forward *forward = forward_of(world, named ? "clear" : NULL, pool);
        struct floor global = {0};
        assert_non_null(strstr(pm_forward_note(forward), "lamp outside"));
        trace_forward(forward, pool, PM_MAP_GLOBAL, false, &global);
        expect_equal(named ? "ports" : "openings", &global, &plain);
        pm_forward_free(forward);
    }
    pm_world_free(world);
    pm_pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(aimed_lamps_light_the_floor_as_unaimed_paths_do),
        cmocka_unit_test(lamps_and_sky_are_aimed_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
