#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"
#include "world/media.h"
#include "world/surface.h"

/* ---- phase function ---- */

static const double gs[] = {0, 1e-9, .3, -.5, .9, -.99, .9999};
enum { GS = 7 };

/* Integrals over the sphere of the density times 1, cos and the second Legendre polynomial are
 * 1, g and g^2 (Henyey and Greenstein's moments). The angle is pi t^4 from the peak. */
static void phase_function_is_normalised(void **state)
{
    (void)state;
    enum { STEPS = 200000 };
    for (int k = 0; k < GS; k++) {
        double moments[3] = {0}, side = gs[k] < 0 ? -1 : 1;
        for (int i = 0; i < STEPS; i++) {
            double t = (i + .5) / STEPS, angle = PM_PI * pow(t, 4), c = side * cos(angle);
            double f =
                pm_phase(gs[k], c) * 2 * PM_PI * sin(angle) * 4 * PM_PI * pow(t, 3) / STEPS;
            moments[0] += f;
            moments[1] += f * c;
            moments[2] += f * (3 * c * c - 1) / 2;
        }
        assert_near(moments[0], 1, 1e-7);
        assert_near(moments[1], gs[k], 1e-7);
        assert_near(moments[2], gs[k] * gs[k], 1e-7);
    }
}

/* Equal steps in u: the midpoint rule for the same moments. */
static void phase_samples_have_its_moments(void **state)
{
    (void)state;
    enum { STEPS = 200000 };
    pm_vec3 forward = pm_vec3_normalize((pm_vec3){1, -2, 3});
    for (int k = 0; k < GS; k++) {
        double moments[2] = {0};
        for (int i = 0; i < STEPS; i++) {
            pm_vec3 w = pm_phase_sample(gs[k], forward, (i + .5) / STEPS, .37);
            double c = pm_vec3_dot(w, forward);
            moments[0] += c / STEPS;
            moments[1] += (3 * c * c - 1) / 2 / STEPS;
        }
        assert_near(moments[0], gs[k], 1e-6);
        assert_near(moments[1], gs[k] * gs[k], 1e-6);
    }
    pm_vec3 edge = pm_phase_sample(.9999, forward, 0, 0);
    assert_near(pm_vec3_dot(edge, forward), -1, 1e-7);
}

static double phase_density(void *context, pm_vec3 w)
{
    return pm_phase(*(const double *)context, w.x);
}

static void phase_frequency_equals_its_density(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        struct histogram h = {.samples = 100000};
        pm_rng rng;
        pm_rng_init(&rng, 1, PM_RNG_PATH, (uint64_t)k);
        for (int i = 0; i < h.samples; i++) {
            double u[2];
            draw(&rng, u, 2);
            histogram_add(&h, pm_phase_sample(gs[k], (pm_vec3){1, 0, 0}, u[0], u[1]));
        }
        double g = gs[k];
        histogram_expect(&h, phase_density, &g);
        histogram_check(&h);
    }
}

/* ---- transmittance ---- */

static void transmittance_is_beer_lambert_at_any_extinction(void **state)
{
    (void)state;
    const double extinctions[] = {0, 1e-300, 1e-6, 1, 1e6, 1e300};
    const double lengths[] = {0, 1e-300, 1e-6, .7, 1e6, 1e300, INFINITY};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 7; k++) {
            pm_medium medium = {.extinction = {extinctions[i], 1, 0}};
            pm_rgb t = pm_medium_transmittance(&medium, lengths[k]);
            double depth = extinctions[i] > 0 ? extinctions[i] * lengths[k] : 0;
            assert_near(t.r, exp(-depth), 1e-15);
            assert_near(t.b, 1, 0);
        }
}

/* ---- which media hold a point ---- */

/* A mist sphere of radius 3 about the origin, in it a dielectric sphere of radius 1 at x = 1,
 * in that a second mist of radius .5; a third mist, a box, overlaps the first from x = 2 on. */
static const char nested[] = "void mist m 0 0 7 .2 .2 .2 .5 .5 .5 .4 m sphere a 0 0 4 0 0 0 3\n"
                             "void dielectric d 0 0 5 .5 1 1 1.5 0 d sphere b 0 0 4 1 0 0 1\n"
                             "void mist n 0 0 7 .7 .7 .7 1 1 1 .1 n sphere c 0 0 4 1 0 0 .5\n"
                             "void mist o 0 0 7 .6 .6 .6 1 1 1 -.2\n"
                             "o polygon o1 0 0 12 2 -1 -1 2 -1 1 2 1 1 2 1 -1\n"
                             "o polygon o2 0 0 12 5 -1 -1 5 1 -1 5 1 1 5 -1 1\n"
                             "o polygon o3 0 0 12 2 -1 -1 5 -1 -1 5 -1 1 2 -1 1\n"
                             "o polygon o4 0 0 12 2 1 -1 2 1 1 5 1 1 5 1 -1\n"
                             "o polygon o5 0 0 12 2 -1 -1 2 1 -1 5 1 -1 5 -1 -1\n"
                             "o polygon o6 0 0 12 2 -1 1 5 -1 1 5 1 1 2 1 1\n";

static double distance_to(pm_vec3 p, double x)
{
    return sqrt((p.x - x) * (p.x - x) + p.y * p.y + p.z * p.z);
}

static const double gs_of_nested[3] = {.4, .1, -.2};

/* By the definition in media.h, from the shapes' formulas. */
static pm_medium nested_medium(pm_vec3 p)
{
    bool in_m = distance_to(p, 0) < 3, in_d = distance_to(p, 1) < 1,
         in_n = distance_to(p, 1) < .5;
    bool in_o = p.x > 2 && p.x < 5 && fabs(p.y) < 1 && fabs(p.z) < 1;
    double mists[3] = {in_m && !in_d ? .2 : 0, in_n ? .7 : 0, in_o ? .6 : 0};
    double scattering[3] = {mists[0] * .5, mists[1], mists[2]};
    double sum = mists[0] + mists[1] + mists[2];
    double scatters = scattering[0] + scattering[1] + scattering[2];
    pm_medium medium = {.extinction = {sum, sum, sum}};
    medium.extinction.r += in_d ? log(2) : 0;
    medium.albedo.g = sum > 0 ? scatters / sum : 0;
    medium.albedo.r = medium.extinction.r > 0 ? scatters / medium.extinction.r : 0;
    for (int i = 0; i < 3; i++)
        if (scattering[i] > 0)
            medium.phase[medium.phases++] =
                (struct pm_phase_part){gs_of_nested[i], pm_rgb_grey(scattering[i] / scatters)};
    return medium;
}

static void assert_medium(const pm_world *world, const pm_media *media, pm_medium wanted,
                          double scale)
{
    pm_medium medium;
    bool any = pm_media_medium(media, world, &medium);
    assert_int_equal(any, wanted.extinction.r > 0);
    assert_near(medium.extinction.r, wanted.extinction.r * scale, 1e-12 * scale);
    assert_near(medium.extinction.g, wanted.extinction.g * scale, 1e-12 * scale);
    assert_near(medium.albedo.r, wanted.albedo.r, 1e-12);
    assert_near(medium.albedo.g, wanted.albedo.g, 1e-12);
    assert_int_equal(medium.phases, wanted.phases);
    for (int i = 0; i < 5; i++) {
        pm_rgb got = pm_medium_phase(&medium, .5 * i - 1),
               want = pm_medium_phase(&wanted, .5 * i - 1);
        assert_near(got.r, want.r, 1e-12);
        assert_near(got.b, want.b, 1e-12);
    }
}

static pm_rgb mixed_phase(pm_vec3 w)
{
    const double out = .2 * pm_phase(.7, w.x), back = .2 * pm_phase(-.4, w.x);
    return (pm_rgb){.8 / .2 * out + back, out + .8 / .2 * back, .5 / .2 * (out + back)};
}

/* The mean of weight over drawn directions of a polynomial in the cosine: its integral times
 * the phase function of each channel, 1 and s .7 - (1 - s) .4, at most 5 standard errors off.
 * Red light is scattered to .8 by one mist, green to .2, blue to .5. */
static void overlapping_mists_scatter_each_by_its_own(void **state)
{
    (void)state;
    enum { SAMPLES = 200000 };
    const pm_rgb fluxes[] = {{1, 1, 1}, {1, .1, 0}, {0, 0, 3}};
    const double wanted[3] = {.8 * .7 - .2 * .4, .2 * .7 - .8 * .4, .5 * .7 - .5 * .4};
    pm_medium medium = {.phases = 2, .phase = {{.7, {.8, .2, .5}}, {-.4, {.2, .8, .5}}}};
    for (int k = 0; k < 3; k++) {
        double mean[3] = {0}, square[3] = {0}, whole[3] = {0};
        pm_rgb flux = fluxes[k];
        const double carried[3] = {flux.r, flux.g, flux.b};
        pm_rng rng;
        pm_rng_init(&rng, 3, PM_RNG_PATH, (uint64_t)k);
        for (int i = 0; i < SAMPLES; i++) {
            double u[3];
            pm_rgb weight, all;
            draw(&rng, u, 3);
            pm_vec3 w = pm_medium_scatter(&medium, flux, (pm_vec3){1, 0, 0}, u, &weight);
            all = mixed_phase(w);
            assert_near(pm_medium_phase(&medium, w.x).r, all.r, 1e-12);
            assert_near(pm_medium_phase(&medium, w.x).g, all.g, 1e-12);
            all = pm_rgb_mul(flux, weight);
            assert_near(all.r + all.g + all.b, flux.r + flux.g + flux.b, 1e-9);
            const double weights[3] = {weight.r, weight.g, weight.b};
            for (int c = 0; c < 3; c++) {
                whole[c] += weights[c] / SAMPLES;
                mean[c] += weights[c] * w.x / SAMPLES;
                square[c] += weights[c] * weights[c] / SAMPLES;
            }
        }
        for (int c = 0; c < 3; c++)
            if (carried[c] > 0) {
                double allowed = 5 * sqrt(square[c] / SAMPLES);
                assert_near(whole[c], 1, allowed);
                assert_near(mean[c], wanted[c], allowed);
            }
    }
}

static double scale_of(const pm_world *world)
{
    pm_world_info info;
    pm_world_info_get(world, &info);
    return info.scale;
}

static void media_at_a_point_are_those_that_hold_it(void **state)
{
    (void)state;
    pm_world *world = world_of(nested);
    pm_rng rng;
    pm_rng_init(&rng, 4, PM_RNG_PATH, 0);
    for (int i = 0; i < 5000; i++) {
        double u[3];
        draw(&rng, u, 3);
        pm_vec3 p = {9 * u[0] - 3.5, 3 * u[1] - 1.5, 3 * u[2] - 1.5};
        pm_media media;
        pm_media_at(world, pm_world_from_scene(world, p), &media);
        assert_medium(world, &media, nested_medium(p), scale_of(world));
    }
    pm_world_free(world);
}

/* Walks straight through everything; after each surface the list must say what holds the middle
 * of the next stretch. */
static void a_walk_keeps_the_list_right(void **state)
{
    (void)state;
    pm_world *world = world_of(nested);
    pm_rng rng;
    pm_rng_init(&rng, 6, PM_RNG_PATH, 0);
    for (int i = 0; i < 1000; i++) {
        double u[5];
        draw(&rng, u, 5);
        pm_vec3 from = {-6, 2 * u[0] - 1, 2 * u[1] - 1}, to = {6, 2 * u[2] - 1, 2 * u[3] - 1};
        pm_vec3 start = pm_world_from_scene(world, from);
        pm_vec3 way = pm_vec3_sub(pm_world_from_scene(world, to), start);
        pm_ray ray = {start, pm_vec3_normalize(way), INFINITY, PM_NO_PRIMITIVE};
        pm_media media = {0};
        pm_hit hit, next;
        while (pm_world_intersect(world, &ray, &hit)) {
            pm_media_cross(&media, world, &hit, ray.direction);
            ray.origin = hit.point;
            ray.from = hit.surface;
            if (!pm_world_intersect(world, &ray, &next))
                break;
            pm_vec3 middle = pm_vec3_madd(hit.point, next.t / 2, ray.direction);
            assert_medium(world, &media, nested_medium(pm_world_to_scene(world, middle)),
                          scale_of(world));
        }
        assert_int_equal(media.count, 0);
    }
    pm_world_free(world);
}

/* exp(-extinction * chord), whatever the unit of length. */
static void mist_attenuates_alike_at_any_scale(void **state)
{
    (void)state;
    const double units[] = {1e-6, 1, 1e6};
    for (int i = 0; i < 3; i++) {
        char text[200];
        snprintf(text, sizeof text, "void mist m 0 0 3 %g %g 1e-300 m sphere s 0 0 4 0 0 0 %g",
                 .3 / units[i], 1e6 / units[i], 2 * units[i]);
        pm_world *world = world_of(text);
        pm_ray ray = {pm_world_from_scene(world, (pm_vec3){-3 * units[i], 0, 0}),
                      {1, 0, 0},
                      INFINITY,
                      PM_NO_PRIMITIVE};
        pm_media media = {0};
        pm_rgb share = pm_world_transmittance(world, &ray, &media, false);
        assert_near(share.r, exp(-1.2), 1e-14);
        assert_near(share.g, 0, 0);
        assert_near(share.b, 1, 1e-15);
        pm_world_free(world);
    }
}

/* A colour of 0 leaves nothing after any length, and no NaN at length 0. */
static void black_dielectric_is_black_and_finite(void **state)
{
    (void)state;
    pm_world *world = world_of("void dielectric d 0 0 5 0 .5 1 1.5 0 d sphere s 0 0 4 0 0 0 1");
    pm_media media;
    pm_medium medium;
    pm_media_at(world, pm_world_from_scene(world, (pm_vec3){0, 0, 0}), &media);
    assert_true(pm_media_medium(&media, world, &medium));
    assert_true(pm_rgb_finite(medium.extinction) && pm_rgb_finite(medium.albedo));
    pm_rgb here = pm_medium_transmittance(&medium, 0),
           there = pm_medium_transmittance(&medium, 1e-9);
    assert_true(here.r == 1 && here.g == 1 && there.r == 0 && there.b == 1);
    pm_world_free(world);
}

static void a_world_without_media_lists_none(void **state)
{
    (void)state;
    pm_world *world = world_of("void dielectric d 0 0 5 1 1 1 1.5 0 d sphere s 0 0 4 0 0 0 1");
    pm_media media;
    pm_media_at(world, (pm_vec3){0, 0, 0}, &media);
    assert_int_equal(media.count, 0);
    pm_world_free(world);
}

static void too_many_volumes_are_survived(void **state)
{
    (void)state;
    char text[4000] = "void mist m 0 0 3 1 1 1\n", *at = text + strlen(text);
    for (int i = 0; i < 20; i++)
        at += sprintf(at, "m sphere s 0 0 4 0 0 0 %d\n", 20 - i);
    pm_world *world = world_of(text);
    pm_ray ray = {
        pm_world_from_scene(world, (pm_vec3){-30, 0, 0}), {1, 0, 0}, INFINITY, PM_NO_PRIMITIVE};
    pm_media media = {0};
    pm_hit hit;
    for (int i = 0; pm_world_intersect(world, &ray, &hit); i++) {
        pm_media_cross(&media, world, &hit, ray.direction);
        int depth = i < 20 ? i + 1 : 39 - i;
        assert_true(media.count <= PM_MEDIA_MAX);
        assert_true(media.count <= depth);
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    assert_int_equal(media.count, 0);
    pm_world_free(world);
}

/* ---- antimatter ---- */

struct stop {
    double x;         /* where on the x axis the walk from -x meets it */
    const char *what; /* diffuse, specular, straight */
};

/* Follows the x axis straight on through whatever it shows. */
static void check_stops(const char *text, const struct stop *stops, int count)
{
    pm_world *world = world_of(text);
    pm_ray ray = {pm_world_from_scene(world, (pm_vec3){-9, .01, .02}),
                  {1, 0, 0},
                  INFINITY,
                  PM_NO_PRIMITIVE};
    pm_media media = {0};
    pm_hit hit;
    for (int i = 0; i < count; i++) {
        assert_true(pm_world_intersect(world, &ray, &hit));
        pm_surface s;
        pm_surface_at(world, &hit, (pm_vec3){-1, 0, 0}, &media, &s);
        assert_near(pm_world_to_scene(world, hit.point).x, stops[i].x, 1e-3);
        assert_int_equal(pm_surface_has(&s, PM_EVENT_DIFFUSE),
                         strcmp(stops[i].what, "diffuse") == 0);
        assert_int_equal(pm_surface_part(&s, PM_EVENT_SPECULAR, PM_SIDE_FAR).r > 0,
                         strcmp(stops[i].what, "specular") == 0);
        assert_int_equal(pm_surface_part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR).r == 1,
                         strcmp(stops[i].what, "straight") == 0);
        pm_media_cross(&media, world, &hit, ray.direction);
        ray.origin = hit.point;
        ray.from = hit.surface;
    }
    assert_false(pm_world_intersect(world, &ray, &hit));
    assert_int_equal(media.count, 0);
    pm_world_free(world);
}

/* A ball of plastic from -1 to 1, its left part cut out by a ball of antimatter from -3 to .5:
 * the cut shows the first material. */
static void antimatter_cuts_an_opaque_ball_and_shows_the_cut(void **state)
{
    (void)state;
    const struct stop stops[] = {
        {-3, "straight"}, {-1, "straight"}, {.5, "diffuse"}, {1, "diffuse"}};
    check_stops("void plastic p 0 0 5 .5 .5 .5 0 0 p sphere s 0 0 4 0 0 0 1\n"
                "void antimatter a 1 p 0 0 a sphere c 0 0 4 -1.25 0 0 1.75",
                stops, 4);
}

/* With void first the cut shows nothing; what lies in the antimatter and is not listed stays.
 */
static void void_antimatter_leaves_no_cut(void **state)
{
    (void)state;
    const struct stop stops[] = {
        {-3, "straight"}, {-2, "diffuse"}, {-1, "straight"}, {.5, "straight"}, {1, "diffuse"}};
    check_stops("void plastic p 0 0 5 .5 .5 .5 0 0 p sphere s 0 0 4 0 0 0 1\n"
                "void plastic q 0 0 5 .5 .5 .5 0 0 q ring r 0 0 8 -2 0 0 -1 0 0 0 .5\n"
                "void antimatter a 2 void p 0 0 a sphere c 0 0 4 -1.25 0 0 1.75",
                stops, 5);
}

/* A hole in glass: its wall refracts, with the glass outside the hole. */
static void antimatter_makes_a_hole_in_glass(void **state)
{
    (void)state;
    const char *text = "void dielectric d 0 0 5 .5 .5 .5 1.5 0 d sphere s 0 0 4 0 0 0 2\n"
                       "void antimatter a 1 d 0 0 a sphere c 0 0 4 0 0 0 1";
    const struct stop stops[] = {
        {-2, "specular"}, {-1, "specular"}, {1, "specular"}, {2, "specular"}};
    check_stops(text, stops, 4);
    pm_world *world = world_of(text);
    pm_media media;
    pm_medium medium;
    pm_media_at(world, pm_world_from_scene(world, (pm_vec3){0, 0, 0}), &media);
    assert_false(pm_media_medium(&media, world, &medium));
    pm_ray ray = {
        pm_world_from_scene(world, (pm_vec3){0, 0, 0}), {1, 0, 0}, INFINITY, PM_NO_PRIMITIVE};
    pm_hit hit;
    pm_surface s;
    assert_true(pm_world_intersect(world, &ray, &hit));
    pm_surface_at(world, &hit, (pm_vec3){-.8, 0, .6}, &media, &s); /* from within the hole */
    assert_true(pm_vec3_dot(s.normal, s.wo) > 0);
    assert_near(s.lobes[1].u.direction.radiance_scale, 1 / 2.25,
                1e-14); /* from air into glass */
    pm_media_at(world, pm_world_from_scene(world, (pm_vec3){1.5, 0, 0}), &media);
    assert_true(pm_media_medium(&media, world, &medium));
    pm_surface_at(world, &hit, (pm_vec3){1, 0, 0}, &media, &s); /* from within the glass */
    assert_near(s.lobes[1].u.direction.radiance_scale, 2.25, 1e-14);
    pm_world_free(world);
}

/* ---- interfaces ---- */

/* A glass ball with a cylindrical hole, its lower half full of water, air above. */
static const char glass_of_water[] =
    "void dielectric glass 0 0 5 .5 .6 .7 1.5 0 glass sphere ball 0 0 4 0 0 0 3\n"
    "void interface wall 0 0 8 .8 .9 1 1.33 .5 .6 .7 1.5\n"
    "wall cylinder side 0 0 7 0 0 -1 0 0 0 1 wall ring bottom 0 0 8 0 0 -1 0 0 -1 0 1\n"
    "glass tube above 0 0 7 0 0 0 0 0 1 1 glass ring top 0 0 8 0 0 1 0 0 -1 0 1\n"
    "void dielectric water 0 0 5 .8 .9 1 1.33 0 water ring level 0 0 8 0 0 0 0 0 1 0 1\n";

static pm_medium in_glass_of_water(pm_vec3 p)
{
    pm_medium medium = {.extinction = {0, 0, 0}};
    bool hole = hypot(p.x, p.y) < 1 && fabs(p.z) < 1;
    if (hole && p.z < 0)
        medium.extinction = (pm_rgb){-log(.8), -log(.9), 0};
    else if (!hole && distance_to(p, 0) < 3)
        medium.extinction = (pm_rgb){-log(.5), -log(.6), -log(.7)};
    return medium;
}

static void media_of_interfaces_are_those_around_a_point(void **state)
{
    (void)state;
    pm_world *world = world_of(glass_of_water);
    pm_rng rng;
    pm_rng_init(&rng, 4, PM_RNG_PATH, 0);
    for (int i = 0; i < 5000; i++) {
        double u[3];
        draw(&rng, u, 3);
        pm_vec3 p = {7 * u[0] - 3.5, 3 * u[1] - 1.5, 3 * u[2] - 1.5};
        pm_media media;
        pm_media_at(world, pm_world_from_scene(world, p), &media);
        assert_medium(world, &media, in_glass_of_water(p), scale_of(world));
    }
    pm_world_free(world);
}

static void a_walk_changes_one_medium_for_the_other_at_interfaces(void **state)
{
    (void)state;
    pm_world *world = world_of(glass_of_water);
    pm_rng rng;
    pm_rng_init(&rng, 8, PM_RNG_PATH, 0);
    for (int i = 0; i < 2000; i++) {
        double u[5];
        draw(&rng, u, 5);
        pm_vec3 from = {-6, 3 * u[0] - 1.5, 3 * u[1] - 1.5};
        pm_vec3 to = {6, 3 * u[2] - 1.5, 3 * u[3] - 1.5};
        pm_vec3 start = pm_world_from_scene(world, i & 1 ? from : to);
        pm_vec3 way = pm_vec3_sub(pm_world_from_scene(world, i & 1 ? to : from), start);
        pm_ray ray = {start, pm_vec3_normalize(way), INFINITY, PM_NO_PRIMITIVE};
        pm_media media = {0};
        pm_hit hit;
        while (pm_world_intersect(world, &ray, &hit)) {
            pm_vec3 middle = pm_vec3_madd(ray.origin, hit.t / 2, ray.direction);
            pm_media_meet(&media, world, &hit, ray.direction);
            assert_medium(world, &media, in_glass_of_water(pm_world_to_scene(world, middle)),
                          scale_of(world));
            pm_media_cross(&media, world, &hit, ray.direction);
            ray.origin = hit.point;
            ray.from = hit.surface;
        }
        assert_int_equal(media.count, 0);
    }
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(phase_function_is_normalised),
        cmocka_unit_test(phase_samples_have_its_moments),
        cmocka_unit_test(phase_frequency_equals_its_density),
        cmocka_unit_test(overlapping_mists_scatter_each_by_its_own),
        cmocka_unit_test(transmittance_is_beer_lambert_at_any_extinction),
        cmocka_unit_test(media_at_a_point_are_those_that_hold_it),
        cmocka_unit_test(a_walk_keeps_the_list_right),
        cmocka_unit_test(mist_attenuates_alike_at_any_scale),
        cmocka_unit_test(black_dielectric_is_black_and_finite),
        cmocka_unit_test(a_world_without_media_lists_none),
        cmocka_unit_test(too_many_volumes_are_survived),
        cmocka_unit_test(antimatter_cuts_an_opaque_ball_and_shows_the_cut),
        cmocka_unit_test(void_antimatter_leaves_no_cut),
        cmocka_unit_test(antimatter_makes_a_hole_in_glass),
        cmocka_unit_test(media_of_interfaces_are_those_around_a_point),
        cmocka_unit_test(a_walk_changes_one_medium_for_the_other_at_interfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
