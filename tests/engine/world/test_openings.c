/* Openings of closed rooms: where they are found, and that aiming at them changes no mean. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/sobol.h"
#include "world/openings.h"

#define GREY  "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
#define SKY   "void glow sky 0 0 4 1 1 1 0 sky source dome 0 0 4 0 0 1 180\n"
#define SUN   "void light sun 0 0 3 1e4 1e4 1e4 sun source disc 0 0 4 .1 .1 1 .5\n"
#define FIELD "grey ring ground 0 0 8 0 0 -1.1 0 0 1 0 30\n"

/* A box of [-1, 1]^3 without its lid, and a lid with a hole of .4 by .4. */
#define WALLS                                                                                  \
    GREY "grey polygon w1 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"                            \
         "grey polygon w2 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"                            \
         "grey polygon w3 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"                                \
         "grey polygon w4 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"                            \
         "grey polygon w5 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n"
#define LID                                                                                    \
    "grey polygon lid 0 0 30 -1 -1 1 -1 1 1 1 1 1 1 -1 1 -1 -1 1 -.2 -.2 1 .2 -.2 1 .2 .2 1 "  \
    "-.2 .2 1 -.2 -.2 1\n"
#define PANE                                                                                   \
    "void glass clear 0 0 3 .9 .9 .9 clear polygon p 0 0 12 -.2 -.2 1 .2 -.2 1 .2 .2 1 -.2 "   \
    ".2 1\n"
#define WHOLE "grey polygon lid 0 0 12 -1 -1 1 -1 1 1 1 1 1 1 -1 1\n"

enum { SAMPLES = 1 << 15 };

static pm_openings *openings_of(const pm_world *world)
{
    pm_error err = PM_ERROR_INIT;
    pm_openings *openings = NULL;
    if (pm_openings_find(world, &openings, &err))
        fail_msg("%s", err.text);
    return openings;
}

typedef bool emission(const void *how, const double u[5], pm_emission *out);

static bool aimed(const void *how, const double u[5], pm_emission *out)
{
    return pm_openings_emit(how, u, out);
}

static bool unaimed(const void *how, const double u[5], pm_emission *out)
{
    return pm_light_emit(how, u, out);
}

/* Whether it passes the hole in the lid. */
static bool enters(const pm_world *world, const pm_emission *e)
{
    pm_vec3 from = pm_world_to_scene(world, e->origin);
    double t = (1 - from.z) / e->direction.z;
    pm_vec3 at = pm_vec3_madd(from, t, e->direction);
    return t > 0 && fabs(at.x) < .2 && fabs(at.y) < .2;
}

struct mean {
    double all, all_error, entering, entering_error;
    double share; /* of the photons that enter */
};

static struct mean mean_of(const pm_world *world, emission *emit, const void *how)
{
    double sums[2] = {0}, squares[2] = {0}, count = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[5];
        pm_emission e;
        for (unsigned d = 0; d < 5; d++)
            u[d] = pm_sobol(i, d, 3 + d);
        assert_true(emit(how, u, &e));
        assert_true(e.flux.r >= 0 && isfinite(e.flux.r));
        bool in = e.flux.r > 0 && enters(world, &e);
        double values[2] = {e.flux.r, in ? e.flux.r : 0};
        count += in;
        for (int k = 0; k < 2; k++) {
            sums[k] += values[k] / SAMPLES;
            squares[k] += values[k] * values[k] / SAMPLES;
        }
    }
    return (struct mean){sums[0], sqrt(fmax(squares[0] - sums[0] * sums[0], 0) / SAMPLES),
                         sums[1], sqrt(fmax(squares[1] - sums[1] * sums[1], 0) / SAMPLES),
                         count / SAMPLES};
}

static void expect_equal(double got, double want, double error)
{
    if (!(fabs(got - want) <= 5 * error + 1e-9 * want))
        fail_msg("got %.7g, want %.7g, error %.2g", got, want, error);
}

/* Sky and sun, glazed or not, and a lamp that shines as ever. */
static const char *const rooms[] = {
    WALLS LID SKY,
    WALLS LID SKY SUN,
    WALLS LID FIELD PANE SKY SUN,
    WALLS LID FIELD SKY "void light l 0 0 3 1 1 1 l sphere lamp 0 0 4 0 0 0 .2\n",
};

static void openings_change_no_mean(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        pm_world *world = world_of(rooms[i]);
        pm_openings *openings = openings_of(world);
        assert_non_null(openings);
        struct mean a = mean_of(world, aimed, openings), b = mean_of(world, unaimed, world);
        expect_equal(a.all, b.all, hypot(a.all_error, b.all_error));
        expect_equal(a.entering, b.entering, hypot(a.entering_error, b.entering_error));
        assert_true(a.share > 4 * b.share);
        pm_openings_free(openings);
        pm_world_free(world);
    }
}

/* Half of the photons leave for the hole; its ball has not more than 5 times its size. */
static void photons_go_where_the_hole_is(void **state)
{
    (void)state;
    pm_world *world = world_of(WALLS LID FIELD PANE SKY);
    pm_openings *openings = openings_of(world);
    assert_non_null(openings);
    assert_non_null(strstr(pm_openings_note(openings), "openings"));
    assert_true(mean_of(world, aimed, openings).share > .05);
    assert_true(mean_of(world, unaimed, world).share < .001);
    pm_openings_free(openings);
    pm_world_free(world);
}

static void nothing_is_found_where_there_is_nothing_to_find(void **state)
{
    (void)state;
    static const char *const scenes[] = {
        WALLS LID "void light l 0 0 3 1 1 1 l sphere lamp 0 0 4 0 0 0 .2\n", /* no sky */
        WALLS WHOLE SKY,                                                     /* no way in */
        WALLS SKY,                                                           /* an open box */
        GREY FIELD SKY,                                                      /* no inside */
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        pm_world *world = world_of(scenes[i]);
        pm_openings *openings = openings_of(world);
        if (openings)
            fail_msg("%zu: %s", i, pm_openings_note(openings));
        pm_world_free(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(openings_change_no_mean),
        cmocka_unit_test(photons_go_where_the_hole_is),
        cmocka_unit_test(nothing_is_found_where_there_is_nothing_to_find),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
