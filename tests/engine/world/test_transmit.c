#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"
#include "world/media.h"

/* Panes of trans that pass .5, .6, .7 straight on and do nothing else. */
#define PANE    "void trans pane 0 0 7 .5 .6 .7 0 0 1 1\n"
#define FRAME   "pane sphere far 0 0 4 9 9 9 .5\npane sphere near 0 0 4 -9 -9 -9 .5\n"
#define AT(z)   "pane polygon p 0 0 12 -2 -2 " z " 2 -2 " z " 2 2 " z " -2 2 " z "\n"
#define BACK(z) "pane polygon p 0 0 12 -2 2 " z " 2 2 " z " 2 -2 " z " -2 -2 " z "\n"

/* From (x, y, 1) to (x, y, -1) in scene units, a little aslant. */
static pm_rgb between(const pm_world *world, double x, double y)
{
    pm_media media;
    pm_vec3 a = pm_world_from_scene(world, pm_vec3_make(x, y, 1));
    pm_vec3 b = pm_world_from_scene(world, pm_vec3_make(y, x, -1));
    pm_ray ray = {a, pm_vec3_normalize(pm_vec3_sub(b, a)), pm_vec3_distance(a, b),
                  PM_NO_PRIMITIVE};
    pm_media_at(world, a, &media);
    return pm_world_transmittance(world, &ray, &media, false);
}

static void assert_passes(const char *text, double r, double g, double b)
{
    pm_world *world = world_of(text);
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (int i = 0; i < 2000; i++) {
        pm_rgb t = between(world, 2 * pm_rng_uniform(&rng) - 1, 2 * pm_rng_uniform(&rng) - 1);
        assert_near(t.r, r, 1e-15);
        assert_near(t.g, g, 1e-15);
        assert_near(t.b, b, 1e-15);
    }
    pm_world_free(world);
}

static void light_passes_panes_by_the_product_of_their_transmittances(void **state)
{
    (void)state;
    assert_passes(PANE FRAME, 1, 1, 1);
    assert_passes(PANE FRAME AT("0"), .5, .6, .7);
    assert_passes(PANE FRAME AT("0") AT(".5") AT("-.7"), .125, .216, .343);
}

/* However they are written, and though no float lies between them. */
static void coincident_panes_are_passed_one_by_one(void **state)
{
    (void)state;
    assert_passes(PANE FRAME AT("0") AT("0"), .25, .36, .49);
    assert_passes(PANE FRAME AT("0.1") BACK("0.1"), .25, .36, .49);
    assert_passes(PANE FRAME AT("0.1") BACK("0.1") AT("0.1"), .125, .216, .343);
    assert_passes(PANE FRAME AT("0.1") AT("0.1000000000000001"), .25, .36, .49);
}

static void what_is_opaque_stops_light_among_panes(void **state)
{
    (void)state;
#define WALL "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
    assert_passes(PANE WALL FRAME AT("0") "grey sphere wall 0 0 4 0 0 -5 4.5\n", 0, 0, 0);
    assert_passes(PANE WALL FRAME AT("0") "grey sphere wall 0 0 4 0 0 -6 4.5\n", .5, .6, .7);
    /* without any pane the quick way is taken */
    assert_passes(WALL "grey sphere wall 0 0 4 0 0 -5 4.5\n", 0, 0, 0);
    assert_passes(WALL "grey sphere wall 0 0 4 0 0 -6 4.5\n", 1, 1, 1);
}

/* Beer-Lambert over the stretch inside a mist from z = -.5 to .5, along the vertical. */
static void media_attenuate_along_what_they_hold(void **state)
{
    (void)state;
    pm_world *world = world_of("void mist fog 0 0 7 .3 .6 .9 0 0 0 0\n"
                               "fog cylinder side 0 0 7 0 0 -.5 0 0 .5 3\n"
                               "fog ring top 0 0 8 0 0 .5 0 0 1 0 3\n"
                               "fog ring base 0 0 8 0 0 -.5 0 0 -1 0 3\n");
    pm_media media = {.count = 0};
    pm_vec3 a = pm_world_from_scene(world, pm_vec3_make(.1, .2, 2));
    pm_vec3 middle = pm_world_from_scene(world, pm_vec3_make(.1, .2, .25));
    pm_vec3 b = pm_world_from_scene(world, pm_vec3_make(.1, .2, -2));
    pm_ray ray = {a, {0, 0, -1}, pm_vec3_distance(a, b), PM_NO_PRIMITIVE};
    pm_rgb t = pm_world_transmittance(world, &ray, &media, false);
    assert_near(t.r, exp(-.3), 1e-15);
    assert_near(t.g, exp(-.6), 1e-15);
    assert_near(t.b, exp(-.9), 1e-15);
    /* ends inside */
    ray.t_max = pm_vec3_distance(a, middle);
    t = pm_world_transmittance(world, &ray, &media, false);
    assert_near(t.r, exp(-.3 * .25), 1e-15);
    /* starts inside */
    ray = (pm_ray){middle, {0, 0, -1}, INFINITY, PM_NO_PRIMITIVE};
    pm_media_at(world, middle, &media);
    assert_int_equal(media.count, 1);
    t = pm_world_transmittance(world, &ray, &media, false);
    assert_near(t.b, exp(-.9 * .75), 1e-15);
    pm_world_free(world);
}

/* Of a mist that has a top alone, a ray that comes to the top from below was in it: from z = 0
 * to 2, and then no more. One from above is in it from there to its end at z = -1. */
static void a_ray_to_the_back_of_an_open_mist_was_in_it(void **state)
{
    (void)state;
    pm_world *world = world_of("void mist fog 0 0 3 .3 .6 .9\n"
                               "fog ring top 0 0 8 0 0 2 0 0 1 0 .1\n" PANE FRAME);
    pm_vec3 below = pm_world_from_scene(world, pm_vec3_make(.01, .02, 0));
    pm_media media;
    pm_media_at(world, below, &media);
    assert_int_equal(media.count, 0); /* aslant there are ways past the top */
    pm_ray up = {below, {0, 0, 1}, INFINITY, PM_NO_PRIMITIVE};
    pm_rgb t = pm_world_transmittance(world, &up, &media, false);
    assert_near(t.r, exp(-.6), 1e-14);
    assert_near(t.b, exp(-1.8), 1e-14);
    pm_vec3 above = pm_world_from_scene(world, pm_vec3_make(.01, .02, 4));
    pm_vec3 end = pm_world_from_scene(world, pm_vec3_make(.01, .02, -1));
    pm_ray down = {above, {0, 0, -1}, pm_vec3_distance(above, end), PM_NO_PRIMITIVE};
    t = pm_world_transmittance(world, &down, &media, false);
    assert_near(t.g, exp(-1.8), 1e-14);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_passes_panes_by_the_product_of_their_transmittances),
        cmocka_unit_test(coincident_panes_are_passed_one_by_one),
        cmocka_unit_test(what_is_opaque_stops_light_among_panes),
        cmocka_unit_test(media_attenuate_along_what_they_hold),
        cmocka_unit_test(a_ray_to_the_back_of_an_open_mist_was_in_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
