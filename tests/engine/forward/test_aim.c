#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../world_text.h"
#include "forward/forward.h"

/* Aimed light brings to each quarter of the floor what unaimed light brings: caustic photons
 * against those of the global map that are flagged as caustic, by light and by target. The
 * standard error is that of the batches; 6 of them at 30 degrees of freedom: 1.5e-6. */

enum { QUARTERS = 4, BATCHES = 16 };
#define SIGMAS 6.0

#define FLOOR                                                                                  \
    "void plastic grey 0 0 5 .7 .6 .5 0 0\n"                                                   \
    "grey polygon floor 0 0 12 -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1\n"                              \
    "grey polygon wall 0 0 12 -1 1 -1 1 1 -1 1 1 1 -1 1 1\n"
#define GLASS  "void dielectric clear 0 0 5 1 1 1 1.5 0\nclear sphere ball 0 0 4 .2 .1 -.4 .3\n"
#define MIRROR "void mirror silver 0 0 3 .9 .9 .9\nsilver ring m 0 0 8 .6 0 -.5 -1 0 -.5 0 .3\n"
#define BRIGHT "void light bright 0 0 3 9 9 9\n"

static const char *const lights[] = {
    BRIGHT "bright polygon lamp 0 0 12 -.2 -.2 .9 -.2 .2 .9 .2 .2 .9 .2 -.2 .9\n",
    BRIGHT "bright ring lamp 0 0 8 0 0 .9 0 0 -1 .1 .3\n",
    BRIGHT "bright sphere lamp 0 0 4 -.5 -.5 .5 .1\n",
    BRIGHT "bright cylinder lamp 0 0 7 -.5 -.5 .7 .5 -.5 .7 .05\n",
    "void spotlight spot 0 0 7 9 9 9 40 0 0 -1\nspot ring lamp 0 0 8 0 0 .9 0 0 -1 0 .2\n",
    BRIGHT "bright source sun 0 0 4 .2 .1 1 10\n",
    "void glow sky 0 0 4 1 1 1 0\nsky source s 0 0 4 0 0 1 180\n",
};

/* Rarer shapes and kinds: tubes and cups shine inward and out of their open ends, the patterns
 * over the lamp and over the sky. */
static const char *const rare_lights[] = {
    BRIGHT "bright cone lamp 0 0 8 -.5 -.5 .8 -.5 -.5 .5 .05 .2\n",
    BRIGHT "bright tube lamp 0 0 7 -.2 -.2 .9 -.2 -.2 .6 .2\n",
    BRIGHT "bright cup lamp 0 0 8 -.2 -.2 .9 -.2 -.2 .6 .1 .3\n",
    "void illum pane 0 0 3 9 9 9\npane ring lamp 0 0 8 0 0 .9 0 0 -1 0 .3\n",
    "void brightfunc stripes 2 1+.9*sin(20*Px) . 0 0\nstripes light lit 0 0 3 9 9 9\n"
    "lit polygon lamp 0 0 12 -.4 -.4 .9 -.4 .4 .9 .4 .4 .9 .4 -.4 .9\n",
    "void brightfunc bright_south 2 if(-Dy,-Dy,0)+.05 . 0 0\n"
    "bright_south glow sky 0 0 4 1 1 1 0\nsky source s 0 0 4 0 0 1 180\n",
};

struct sums {
    double sum[QUARTERS], squares[QUARTERS];
};

static void add_batch(const pm_batch *batch, struct sums *sums)
{
    double flux[QUARTERS] = {0};
    for (size_t i = 0; i < batch->count; i++) {
        pm_photon_record r;
        pm_photon_unpack(&batch->photons[i], 1, &r);
        if (r.specular && r.normal.z > .9)
            flux[(r.position.x > 0) + 2 * (r.position.y > 0)] += r.flux.g;
    }
    for (int q = 0; q < QUARTERS; q++) {
        sums->sum[q] += flux[q] / BATCHES;
        sums->squares[q] += flux[q] * flux[q] / BATCHES;
    }
}

static double square_error(const struct sums *s, int q)
{
    return (s->squares[q] - s->sum[q] * s->sum[q]) / (BATCHES - 1);
}

static void expect_equal_light(const char *light, const char *target)
{
    char text[2000];
    snprintf(text, sizeof text, "%s%s%s", FLOOR, target, light);
    pm_error err = PM_ERROR_INIT;
    pm_world *world = world_of(text);
    pm_pool *pool = pm_pool_new(2);
    pm_forward *forward = NULL;
    pm_forward_options options = pm_forward_defaults();
    struct sums sums[2] = {0};
    assert_int_equal(pm_forward_new(world, &options, pool, &forward, &err), PM_OK);
    for (uint64_t b = 0; b < BATCHES; b++)
        for (int i = 0; i < 2; i++) {
            pm_batch out[PM_MAP_KINDS] = {0};
            int kind = i ? PM_MAP_CAUSTIC : PM_MAP_GLOBAL;
            assert_int_equal(
                pm_forward_batch(forward, b, 1U << kind, pool, NULL, NULL, out, &err), PM_OK);
            add_batch(&out[kind], &sums[i]);
            pm_batch_clear(&out[kind]);
        }
    for (int q = 0; q < QUARTERS; q++) {
        double error = sqrt(square_error(&sums[0], q) + square_error(&sums[1], q));
        double off = sums[1].sum[q] - sums[0].sum[q];
        if (!(fabs(off) <= SIGMAS * error) || !(sums[0].sum[q] > 0))
            fail_msg("%s quarter %d: %g aimed, %g unaimed, error %g", light, q, sums[1].sum[q],
                     sums[0].sum[q], error);
    }
    pm_forward_free(forward);
    pm_pool_free(pool);
    pm_world_free(world);
}

static void aimed_light_equals_unaimed_light(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++)
        expect_equal_light(lights[i], GLASS MIRROR);
}

static void so_does_that_of_rare_lights(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rare_lights / sizeof *rare_lights; i++)
        expect_equal_light(rare_lights[i], GLASS MIRROR);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(aimed_light_equals_unaimed_light),
        cmocka_unit_test(so_does_that_of_rare_lights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
