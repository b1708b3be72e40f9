#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/maths.h"
#include "forward/path.h"

/* Every tolerance is K standard deviations at a fixed seed. Emission points are a Sobol
 * sequence, whose means scatter less than independent ones: the deviations below are upper
 * bounds. */
enum { K = 4, MAX_EVENTS = 5000 };

#define SMALL_LAMP "void light bright 0 0 3 1e6 1e6 1e6\nbright sphere lamp 0 0 4 0 0 0 .001\n"
#define PANEL_LAMP                                                                             \
    "void light bright 0 0 3 5 4 3\n"                                                          \
    "bright polygon panel 0 0 12 -.3 -.3 .9 -.3 .3 .9 .3 .3 .9 .3 -.3 .9\n"

/* A run of paths with what they wrote down. */
struct run {
    pm_world *world;
    struct pm_recorder recorder;
    double paths;
    pm_rgb imbalance, variance; /* of emitted - absorbed - escaped, a path */
};

static void accumulate(struct run *run, pm_rgb *sum, pm_rgb *sum2, struct pm_recorder *total)
{
    struct pm_recorder *r = &run->recorder;
    pm_rgb d = pm_rgb_sub(pm_rgb_sub(r->emitted, r->absorbed), r->escaped);
    *sum = pm_rgb_add(*sum, d);
    *sum2 = pm_rgb_add(*sum2, pm_rgb_mul(d, d));
    total->emitted = pm_rgb_add(total->emitted, r->emitted);
    total->absorbed = pm_rgb_add(total->absorbed, r->absorbed);
    total->escaped = pm_rgb_add(total->escaped, r->escaped);
}

static struct run trace(const char *scene, unsigned paths, unsigned kinds)
{
    struct run run = {.world = world_of(scene), .paths = paths};
    struct pm_tracer tracer = {.world = run.world,
                               .seed = 11,
                               .purpose = PM_RNG_PATH,
                               .max_events = MAX_EVENTS,
                               .max_collisions = MAX_EVENTS,
                               .max_scatterings = MAX_EVENTS};
    pm_tracer_set_replicate(&tracer, 3);
    struct pm_recorder total = {0};
    pm_rgb sum = {0, 0, 0}, sum2 = {0, 0, 0}, none = {0, 0, 0};
    run.recorder.kinds = kinds;
    run.recorder.flux_scale = 1;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        run.recorder.probability[kind] = 1;
    for (unsigned i = 0; i < paths; i++) {
        run.recorder.emitted = run.recorder.absorbed = run.recorder.escaped = none;
        pm_path_trace(&tracer, i, i, &run.recorder);
        accumulate(&run, &sum, &sum2, &total);
    }
    run.recorder.emitted = total.emitted;
    run.recorder.absorbed = total.absorbed;
    run.recorder.escaped = total.escaped;
    run.imbalance = pm_rgb_scale(sum, 1 / run.paths);
    run.variance =
        pm_rgb_sub(pm_rgb_scale(sum2, 1 / run.paths), pm_rgb_mul(run.imbalance, run.imbalance));
    assert_int_equal(run.recorder.nonfinite, 0);
    assert_false(run.recorder.out_of_memory);
    return run;
}

static void run_clear(struct run *run)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        free(run->recorder.buffer[kind].photons);
    pm_world_free(run->world);
}

static pm_rgb deposited(const struct run *run, pm_map_kind kind)
{
    pm_rgb sum = {0, 0, 0};
    const struct pm_photon_buffer *buffer = &run->recorder.buffer[kind];
    for (size_t i = 0; i < buffer->count; i++)
        sum = pm_rgb_add(sum, pm_photon_flux(&buffer->photons[i]));
    return pm_rgb_scale(sum, 1 / run->paths);
}

/* ---- flux balance ---- */

static bool balances(double mean, double variance, double paths, double emitted)
{
    double rounding = 1e-12 * emitted / paths;
    return fabs(mean) <= K * sqrt((variance > 0 ? variance : 0) / paths) + rounding;
}

static struct run check_balance(const char *scene)
{
    struct run run = trace(scene, 100000, 0);
    pm_rgb m = run.imbalance, v = run.variance, e = run.recorder.emitted;
    assert_true(e.r > 0 && e.g > 0 && e.b > 0);
    assert_true(balances(m.r, v.r, run.paths, e.r));
    assert_true(balances(m.g, v.g, run.paths, e.g));
    assert_true(balances(m.b, v.b, run.paths, e.b));
    return run;
}

static void flux_balance_of_a_closed_grey_room(void **state)
{
    (void)state;
    struct run run =
        check_balance("void plastic grey 0 0 5 .7 .7 .7 0 0\n" TEST_BOX("grey") PANEL_LAMP);
    assert_true(pm_rgb_is_black(run.recorder.escaped));
    run_clear(&run);
}

static void flux_balance_of_an_open_room_with_rough_and_smooth_gloss(void **state)
{
    (void)state;
    struct run run = check_balance(
        "void plastic shiny 0 0 5 .6 .2 .1 .05 .1\nvoid plastic waxed 0 0 5 .2 .5 .6 .04 0\n"
        "shiny polygon floor 0 0 12 -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1\n"
        "waxed polygon wall 0 0 12 -1 1 -1 1 1 -1 1 1 1 -1 1 1\n" PANEL_LAMP);
    assert_true(run.recorder.escaped.r > 0 && run.recorder.absorbed.r > 0);
    run_clear(&run);
}

static void flux_balance_of_a_tinted_glass_ball_behind_a_pane(void **state)
{
    (void)state;
    struct run run = check_balance(
        "void plastic grey 0 0 5 .7 .7 .7 0 0\n" TEST_BOX("grey") PANEL_LAMP
        "void dielectric amber 0 0 5 .8 .5 .1 1.5 0\namber sphere ball 0 0 4 0 0 -.3 .4\n"
        "void glass window 0 0 3 .9 .95 .9\nwindow polygon pane 0 0 12 -1 -1 .5 1 -1 .5 1 1 .5"
        " -1 1 .5\n");
    assert_true(pm_rgb_is_black(run.recorder.escaped));
    run_clear(&run);
}

static void flux_balance_of_coloured_mist(void **state)
{
    (void)state;
    struct run run = check_balance(
        "void mist fog 0 0 7 3 .3 30 .95 .8 .99 .5\nfog sphere cloud 0 0 4 0 0 0 .6\n"
        "void plastic grey 0 0 5 .5 .5 .5 0 0\ngrey ring floor 0 0 8 0 0 -.8 0 0 1 0 "
        "1\n" PANEL_LAMP);
    assert_true(run.recorder.escaped.g > 0);
    run_clear(&run);
}

static void flux_balance_of_a_mirror_box(void **state)
{
    (void)state;
    struct run run =
        check_balance("void metal mirror 0 0 5 .98 .95 .9 1 0\n" TEST_BOX("mirror") PANEL_LAMP);
    assert_true(pm_rgb_is_black(run.recorder.escaped));
    assert_int_equal(run.recorder.deposits[PM_MAP_GLOBAL], 0);
    run_clear(&run);
}

/* ---- deposits ---- */

/* After the first hit a photon carries rho Phi, then rho^2 Phi ...: the hits after the first
 * bring Phi rho / (1 - rho). Their number is geometric: variance rho / (1 - rho)^2 in units of
 * Phi^2 (roulette keeps the flux of grey photons). The lamp covers 1e-6 of the view. */
static void check_integrating_sphere(double rho, unsigned paths)
{
    char scene[256];
    snprintf(
        scene, sizeof scene,
        "void plastic wall 0 0 5 %g %g %g 0 0\nwall bubble sphere 0 0 4 0 0 0 1\n" SMALL_LAMP,
        rho, rho, rho);
    struct run run = trace(scene, paths, 1U << PM_MAP_GLOBAL);
    double phi = run.recorder.emitted.g / run.paths, expected = rho / (1 - rho);
    double sigma = sqrt(rho / paths) / (1 - rho);
    double found = deposited(&run, PM_MAP_GLOBAL).g / phi;
    assert_true(fabs(found - expected) < K * sigma + expected * 1e-4);
    run_clear(&run);
}

static void integrating_sphere_receives_phi_rho_over_one_minus_rho(void **state)
{
    (void)state;
    check_integrating_sphere(.5, 100000);
    check_integrating_sphere(.9, 30000);
    check_integrating_sphere(.99, 10000);
}

/* In the middle of a sphere of radius 1 every photon travels 1 to its first hit; Radiance's
 * spotlight of focus f then gives (1 / (1 + f))^2 of what it gives far away. */
static void a_focused_spotlight_keeps_back_flux_by_distance(void **state)
{
    (void)state;
    const unsigned paths = 50000;
    struct run run =
        trace("void plastic wall 0 0 5 .5 .5 .5 0 0\nwall bubble sphere 0 0 4 0 0 0 1\n"
              "void spotlight spot 0 0 7 1e6 1e6 1e6 60 0 0 -.5\n"
              "spot ring lamp 0 0 8 0 0 0 0 0 -1 0 .001\n",
              paths, 1U << PM_MAP_GLOBAL);
    double share = 1 / 1.5 / 1.5,
           found = deposited(&run, PM_MAP_GLOBAL).g * run.paths / run.recorder.emitted.g;
    assert_true(fabs(found - share) < K * share * sqrt(.5 / paths) / .5 + 1e-3 * share);
    assert_true(balances(run.imbalance.g, run.variance.g, run.paths, run.recorder.emitted.g));
    run_clear(&run);
}

/* A small lamp shines down on an illum disc of radius R at distance h: sin^2 = R^2 / (R^2 +
 * h^2) of its flux meets it. A share p of n photons has sigma sqrt(p (1 - p) / n). The illum's
 * own light is too faint to matter. */
static double absorbed_share(const char *lamp, const char *front)
{
    char scene[512];
    snprintf(scene, sizeof scene,
             "void %s bright\n0\n0\n%s\nbright ring lamp 0 0 8 0 0 .5 0 0 -1 0 .001\n"
             "void illum window 1 void 0 3 1e-12 1e-12 1e-12\nwindow ring pane 0 0 8 0 0 0 0 0 "
             "%s 0 1\n",
             lamp, strcmp(lamp, "glow") ? "3 1e6 1e6 1e6" : "4 1e6 1e6 1e6 0", front);
    struct run run = trace(scene, 20000, 0);
    double share = run.recorder.absorbed.g / run.recorder.emitted.g;
    run_clear(&run);
    return share;
}

static void an_illum_stands_for_the_weak_light_behind_it(void **state)
{
    (void)state;
    double p = 1 / (1 + .25);
    assert_true(fabs(absorbed_share("glow", "-1") - p) < K * sqrt(p * (1 - p) / 20000) + 1e-3);
    assert_true(absorbed_share("light", "-1") == 0); /* strong light goes on */
    assert_true(absorbed_share("glow", "1") == 0);   /* it leaves through the back */
}

#define FLOOR "void plastic grey 0 0 5 .5 .5 .5 0 0\ngrey ring floor 0 0 8 0 0 -1 0 0 1 0 3\n"

static void direct_photons_are_not_stored(void **state)
{
    (void)state;
    struct run run = trace(FLOOR PANEL_LAMP, 10000, 7);
    assert_true(run.recorder.absorbed.r > 0);
    assert_int_equal(run.recorder.buffer[PM_MAP_GLOBAL].count, 0);
    run_clear(&run);
}

/* A pane of index 1 reflects nothing: all its light goes straight on. */
static void straight_passage_keeps_light_direct(void **state)
{
    (void)state;
    struct run run = trace(FLOOR PANEL_LAMP "void glass film 0 0 4 .5 .5 .5 1\n"
                                            "film ring pane 0 0 8 0 0 0 0 0 1 0 3\n",
                           10000, 7);
    assert_true(run.recorder.absorbed.r > 0);
    assert_int_equal(run.recorder.buffer[PM_MAP_GLOBAL].count, 0);
    run_clear(&run);
}

/* Over a single floor nothing returns but through the ball: each photon is a caustic one. */
static void caustic_photons_follow_a_specular_event(void **state)
{
    (void)state;
    struct run run = trace(FLOOR PANEL_LAMP "void dielectric clear 0 0 5 1 1 1 1.5 0\n"
                                            "clear sphere ball 0 0 4 0 0 0 .4\n",
                           10000, 7);
    const struct pm_photon_buffer *global = &run.recorder.buffer[PM_MAP_GLOBAL];
    const struct pm_photon_buffer *caustic = &run.recorder.buffer[PM_MAP_CAUSTIC];
    assert_true(caustic->count > 100);
    assert_int_equal(global->count, caustic->count);
    assert_memory_equal(global->photons, caustic->photons, global->count * sizeof(pm_photon));
    for (size_t i = 0; i < caustic->count; i++)
        assert_true(caustic->photons[i].flags & PM_PHOTON_SPECULAR);
    run_clear(&run);
}

static void the_caustic_map_is_the_flagged_part_of_the_global_map(void **state)
{
    (void)state;
    struct run run = trace("void plastic grey 0 0 5 .6 .6 .6 0 0\n" TEST_BOX("grey") PANEL_LAMP
                           "void metal mirror 0 0 5 .9 .9 .9 1 0\n"
                           "mirror sphere ball 0 0 4 0 0 -.3 .4\n",
                           5000, 7);
    const struct pm_photon_buffer *global = &run.recorder.buffer[PM_MAP_GLOBAL];
    const struct pm_photon_buffer *caustic = &run.recorder.buffer[PM_MAP_CAUSTIC];
    size_t at = 0;
    for (size_t i = 0; i < global->count; i++)
        if (global->photons[i].flags & PM_PHOTON_SPECULAR) {
            assert_true(at < caustic->count);
            assert_memory_equal(&global->photons[i], &caustic->photons[at++],
                                sizeof(pm_photon));
        }
    assert_int_equal(at, caustic->count);
    assert_true(at > 0 && at < global->count);
    run_clear(&run);
}

/* Back along its direction a flagged photon meets the mirror ball, any other a wall. Packing
 * turns directions by up to 6e-5, which errs at the ball's rim: for less than 1 in 1000. */
static void a_photon_is_flagged_if_it_comes_from_a_specular_surface(void **state)
{
    (void)state;
    struct run run = trace("void plastic grey 0 0 5 .6 .6 .6 0 0\n" TEST_BOX("grey") PANEL_LAMP
                           "void metal mirror 0 0 5 .9 .9 .9 1 0\n"
                           "mirror sphere ball 0 0 4 0 0 -.3 .4\n",
                           5000, 1U << PM_MAP_GLOBAL);
    const struct pm_photon_buffer *global = &run.recorder.buffer[PM_MAP_GLOBAL];
    const pm_vec3 center = {0, 0, -.3};
    size_t wrong = 0;
    for (size_t i = 0; i < global->count; i++) {
        pm_photon_record p;
        pm_hit hit;
        pm_photon_unpack(&global->photons[i], 1, &p);
        pm_ray back = {pm_vec3_madd(p.position, 0x1p-20, p.normal), p.direction, INFINITY,
                       PM_NO_PRIMITIVE};
        assert_true(pm_world_intersect(run.world, &back, &hit));
        pm_vec3 from = pm_world_to_scene(run.world, hit.point);
        wrong += (fabs(pm_vec3_distance(from, center) - .4) < 1e-6) != p.specular;
    }
    assert_true(global->count > 1000 && wrong < global->count / 1000);
    run_clear(&run);
}

/* Photons lie on the surface they hit, with the normal on the side they came from. */
static void normals_look_to_the_side_that_was_hit(void **state)
{
    (void)state;
    struct run run = trace("void plastic grey 0 0 5 .6 .6 .6 0 0\n" TEST_BOX("grey") PANEL_LAMP,
                           2000, 1U << PM_MAP_GLOBAL);
    const struct pm_photon_buffer *global = &run.recorder.buffer[PM_MAP_GLOBAL];
    pm_world_info info;
    pm_world_info_get(run.world, &info);
    assert_true(global->count > 1000);
    for (size_t i = 0; i < global->count; i++) {
        pm_vec3 n = pm_photon_normal(&global->photons[i]);
        pm_vec3 p = pm_world_to_scene(run.world, pm_photon_position(&global->photons[i]));
        assert_true(fabs(pm_vec3_dot(n, p) + 1) <
                    0x1p-28 * info.scale); /* walls at distance 1 */
        assert_true(pm_vec3_dot(n, pm_photon_direction(&global->photons[i])) > 0);
    }
    run_clear(&run);
}

static void a_scene_without_light_gives_no_photons(void **state)
{
    (void)state;
    struct run run = trace(FLOOR, 1000, 7);
    assert_true(pm_rgb_is_black(run.recorder.emitted));
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        assert_int_equal(run.recorder.buffer[kind].count, 0);
    run_clear(&run);
}

/* ---- media ---- */

/* Sunlight from above on a box of mist: E = L pi sin^2(half angle) falls on 4 m^2, and of it
 * exp(-s a) - exp(-s b) collides between the depths a and b, in each channel with its own s.
 * The albedo keeps all but one in 10^9 photons from colliding twice. Sum of squared fluxes:
 * Poisson's variance of a bin. */
enum { BINS = 8 };

static void check_bins(const double sum[BINS], const double sum2[BINS], double incident,
                       double s)
{
    for (int b = 0; b < BINS; b++) {
        double lo = 1. * b / BINS, hi = 1. * (b + 1) / BINS;
        double expected = incident * (pm_exp(-s * lo) - pm_exp(-s * hi));
        assert_true(fabs(sum[b] - expected) < K * sqrt(sum2[b]));
    }
}

static void first_collisions_follow_beer_lambert_in_each_channel(void **state)
{
    (void)state;
    struct run run = trace("void light hot 0 0 3 1e6 4e6 2e5\nhot source sun 0 0 4 0 0 1 .01\n"
                           "void mist fog 0 0 7 1 4 .1 1e-9 1e-9 1e-9 0\n" TEST_BOX("fog"),
                           100000, 1U << PM_MAP_VOLUME);
    double sum[3][BINS] = {{0}}, sum2[3][BINS] = {{0}};
    const struct pm_photon_buffer *volume = &run.recorder.buffer[PM_MAP_VOLUME];
    pm_world_info info;
    pm_world_info_get(run.world, &info);
    assert_true(volume->count > 1000);
    for (size_t i = 0; i < volume->count; i++) {
        pm_vec3 p = pm_world_to_scene(run.world, pm_photon_position(&volume->photons[i]));
        pm_rgb flux = pm_rgb_scale(pm_photon_flux(&volume->photons[i]),
                                   info.scale * info.scale / run.paths);
        double c[3] = {flux.r, flux.g, flux.b};
        int bin = (int)((1 - p.z) / 2 * BINS);
        assert_true(bin >= 0 && bin < BINS);
        for (int k = 0; k < 3; k++) {
            sum[k][bin] += c[k];
            sum2[k][bin] += c[k] * c[k];
        }
    }
    double sine = pm_sin(.005 * PM_PI / 180), area = 4 * PM_PI * sine * sine;
    const double extinction[3] = {1, 4, .1}, radiance[3] = {1e6, 4e6, 2e5};
    for (int k = 0; k < 3; k++)
        check_bins(sum[k], sum2[k], radiance[k] * area, 2 * extinction[k]);
    run_clear(&run);
}

/* Collisions in mist of albedo a whose bounds no photon reaches: each photon collides 1 / (1 -
 * a) times on average (geometric: variance a / (1 - a)^2), with its flux kept by roulette. Of
 * the light that scatters back at once the lamp of radius r takes extinction * r / 4, some
 * 1e-4, a collision. */
static void thick_mist_is_hit_one_over_one_minus_albedo_times(void **state)
{
    (void)state;
    const double albedo = .98;
    const unsigned paths = 4000;
    struct run run =
        trace("void light bright 0 0 3 1e6 1e6 1e6\nbright sphere lamp 0 0 4 0 0 0 1e-5\n"
              "void mist fog 0 0 7 50 50 50 .98 .98 .98 0\nfog sphere cloud 0 0 4 0 0 0 1\n",
              paths, 1U << PM_MAP_VOLUME);
    double phi = run.recorder.emitted.g / run.paths;
    double found = deposited(&run, PM_MAP_VOLUME).g / phi, expected = 1 / (1 - albedo);
    double sigma = sqrt(albedo / paths) / (1 - albedo);
    assert_true(fabs(found - expected) < K * sigma + expected * 1e-3);
    run_clear(&run);
}

/* Photons may not slip through the panel they were emitted from, however short their free path.
 */
static void check_extremes(const char *mist)
{
    char scene[2048];
    snprintf(scene, sizeof scene,
             "%s\nvoid plastic black 0 0 5 0 0 0 0 0\n" TEST_BOX(
                 "black") "void light bright 0 0 3 1 1 1\n"
                          "bright polygon panel 0 0 12 -1 -1 -.5 1 -1 -.5 1 1 -.5 -1 1 -.5\n"
                          "fog sphere cloud 0 0 4 0 0 0 3\n",
             mist);
    struct run run = trace(scene, 3000, 1U << PM_MAP_VOLUME);
    pm_rgb m = run.imbalance, v = run.variance, e = run.recorder.emitted;
    assert_true(balances(m.r, v.r, run.paths, e.r));
    assert_true(balances(m.g, v.g, run.paths, e.g));
    assert_true(balances(m.b, v.b, run.paths, e.b));
    assert_true(pm_rgb_is_black(run.recorder.escaped));
    const struct pm_photon_buffer *volume = &run.recorder.buffer[PM_MAP_VOLUME];
    for (size_t i = 0; i < volume->count; i++) {
        pm_vec3 p = pm_world_to_scene(run.world, pm_photon_position(&volume->photons[i]));
        assert_true(p.z > -.5 - 0x1p-28);
    }
    run_clear(&run);
}

static void extreme_extinctions_neither_hang_nor_leak(void **state)
{
    (void)state;
    check_extremes("void mist fog 0 0 7 0 0 0 .5 .5 .5 0");
    check_extremes("void mist fog 0 0 7 1e-6 1e-6 1e-6 .9 .9 .9 .9");
    check_extremes("void mist fog 0 0 7 1e6 1e6 1e6 .9 .9 .9 -.9");
    check_extremes("void mist fog 0 0 7 0 1e-6 1e6 .9 .5 .9 0");
    check_extremes("void mist fog 0 0 7 1e6 1 1e-6 .999 .999 .999 .5");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flux_balance_of_a_closed_grey_room),
        cmocka_unit_test(flux_balance_of_an_open_room_with_rough_and_smooth_gloss),
        cmocka_unit_test(flux_balance_of_a_tinted_glass_ball_behind_a_pane),
        cmocka_unit_test(flux_balance_of_coloured_mist),
        cmocka_unit_test(flux_balance_of_a_mirror_box),
        cmocka_unit_test(integrating_sphere_receives_phi_rho_over_one_minus_rho),
        cmocka_unit_test(a_focused_spotlight_keeps_back_flux_by_distance),
        cmocka_unit_test(an_illum_stands_for_the_weak_light_behind_it),
        cmocka_unit_test(direct_photons_are_not_stored),
        cmocka_unit_test(straight_passage_keeps_light_direct),
        cmocka_unit_test(caustic_photons_follow_a_specular_event),
        cmocka_unit_test(the_caustic_map_is_the_flagged_part_of_the_global_map),
        cmocka_unit_test(a_photon_is_flagged_if_it_comes_from_a_specular_surface),
        cmocka_unit_test(normals_look_to_the_side_that_was_hit),
        cmocka_unit_test(a_scene_without_light_gives_no_photons),
        cmocka_unit_test(first_collisions_follow_beer_lambert_in_each_channel),
        cmocka_unit_test(thick_mist_is_hit_one_over_one_minus_albedo_times),
        cmocka_unit_test(extreme_extinctions_neither_hang_nor_leak),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
