/* Every material that is not in test_surface.c: energy, reciprocity, sampling, directions. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"
#include "world/aniso.h"
#include "world/lobe.h"
#include "world/surface.h"

/* front up */
#define FLOOR "m polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"

/* Functions of the tests. `broad` is normalised on the hemisphere: (n + 1) / (2 pi) c^n / c of
 * light about the normal; `phong` is about the mirrored ray and loses what goes below;
 * `greedy` has albedo 3; `ridge` depends on azimuth and changes where a table is coarse. */
#define CAL                                                                                    \
    "\n#file f.cal\n"                                                                          \
    "lcos(x,y,z) = abs(NxP*x + NyP*y + NzP*z);\n"                                              \
    "broad(x,y,z) = 1.5/PI * lcos(x,y,z);\n"                                                   \
    "mx = Dx + 2*RdotP*NxP; my = Dy + 2*RdotP*NyP; mz = Dz + 2*RdotP*NzP;\n"                   \
    "mcos(x,y,z) = max(mx*x + my*y + mz*z, 0);\n"                                              \
    "max(a,b) = if(a-b, a, b);\n"                                                              \
    "phong(x,y,z,w) = (A5+2)/(2*PI) * mcos(x,y,z)^A5 * (w+1);\n"                               \
    "greedy(x,y,z) = 3/PI;\n"                                                                  \
    "ridge(x,y,z) = .8*(1 + x)*(1 + Dx*Dy)*.5/PI;\n"                                           \
    "red(x,y,z) = if(z*Dz, .15, .3)/PI; green(x,y,z) = .15/PI;\n"                              \
    "huge(x,y,z) = if(x, 1e300, 0);\n"                                                         \
    "scaled(v,x,y,z,w) = v*(1+w)/PI; polar(x,y,z) = z;\n"                                      \
    "#file d.dat\n1\n0 1 3\n.4 .8 1.2\n"

static const pm_media outside = {0};
static const pm_rgb white = {1, 1, 1};

static pm_world *floor_of(const char *material)
{
    char text[4000];
    snprintf(text, sizeof text, "%s\n" FLOOR CAL, material);
    return world_of(text);
}

static pm_surface floor_at(const pm_world *world, pm_vec3 wo)
{
    pm_surface surface;
    pm_hit hit;
    pm_ray down = {{0, 0, 1}, {0, 0, -1}, INFINITY, PM_NO_PRIMITIVE};
    assert_true(pm_world_intersect(world, &down, &hit));
    pm_surface_at(world, &hit, wo, &outside, &surface);
    return surface;
}

/* ---- energy and sampling, for all ---- */

static const char *const materials_of_density[] = {
    "void plastic2 m 4 1 .2 .3 . 0 6 .5 .5 .5 .4 .3 .15",
    "void metal2 m 4 Dy 1 0 . 0 6 .9 .5 .1 .8 .5 .2",
    "void trans2 m 4 1 1 0 . 0 8 .8 .7 .6 .2 .2 .4 .7 .6",
    "void plastic2 m 4 0 0 1 . 0 6 .5 .5 .5 .4 .3 .15", /* no direction: isotropic */
    "void ashik2 m 4 1 0 0 . 0 8 .6 .5 .4 .1 .1 .2 10 100",
    "void ashik2 m 4 1 0 0 . 0 8 .5 .5 .5 .5 .5 .5 0 0",
    "void plasfunc m 2 broad f.cal 0 4 .5 .4 .3 .6",
    "void plasfunc m 2 phong f.cal 0 5 .5 .4 .3 .6 30",
    "void metfunc m 2 phong f.cal 0 5 .9 .4 .3 .6 3",
    "void transfunc m 2 broad f.cal 0 6 .9 .8 .7 .3 .6 .5",
    "void plasfunc m 2 greedy f.cal 0 4 1 1 1 1",
    "void plasfunc m 2 ridge f.cal 0 4 .5 .5 .5 .9",
    "void BRTDfunc m 10 .1 .1 .1 .2 .1 0 red green 0 f.cal 0 9 .1 .1 .1 .2 .2 .2 .1 .1 .1",
    "void plasdata m 4 scaled d.dat f.cal polar 0 4 .5 .4 .3 .6",
    "void metdata m 4 scaled d.dat f.cal polar 0 4 .5 .4 .3 .6",
    "void transdata m 4 scaled d.dat f.cal polar 0 6 .9 .8 .7 .3 .6 .5",
    "void plastic a 0 0 5 .9 .1 .1 .05 .2\nvoid ashik2 b 4 1 0 0 . 0 8 .2 .2 .2 .3 .3 .3 20 "
    "5\n"
    "void mixfunc m 4 a b .25 . 0 0",
    "void texfunc t 4 .3 -.2 .1 . 0 0\nt plastic2 m 4 1 .2 .3 . 0 6 .5 .5 .5 .4 .3 .15",
    "void texfunc t 4 .3 -.2 .1 . 0 0\nt trans m 0 0 7 .8 .8 .8 .1 .4 .7 .6",
    "void texfunc t 4 2 1 0 . 0 0\nt plasfunc m 2 broad f.cal 0 4 .5 .4 .3 .6",
    "void colorfunc c 4 2 .5 0 . 0 0\nc plastic m 0 0 5 .8 .8 .8 .1 .3",
};
enum { FINITE = sizeof materials_of_density / sizeof *materials_of_density };

static const double cosines[] = {1, .8, .5, .2, .05};
enum { COSINES = 5 };

static pm_rgb finite_value(const pm_surface *s, pm_vec3 wi)
{
    return pm_rgb_add(pm_surface_value(s, PM_EVENT_DIFFUSE, wi),
                      pm_surface_value(s, PM_EVENT_GLOSSY, wi));
}

static pm_rgb delta_albedo(const pm_surface *s)
{
    pm_rgb sum = {0, 0, 0};
    for (unsigned i = 0; i < s->count; i++)
        if (pm_lobe_is_delta(&s->lobes[i]))
            sum = pm_rgb_add(sum, s->lobes[i].albedo);
    return sum;
}

/* Midpoint rule over the sphere, equal in solid angle. */
static pm_rgb quadrature(const pm_surface *s, int bands, int sectors)
{
    pm_rgb sum = {0, 0, 0};
    for (int i = 0; i < bands; i++)
        for (int k = 0; k < sectors; k++)
            sum = pm_rgb_add(sum, finite_value(s, polar((i + .5) / bands * 2 - 1,
                                                        2 * PM_PI * (k + .5) / sectors)));
    return pm_rgb_scale(sum, 4 * PM_PI / ((double)bands * sectors));
}

static pm_rgb albedo_of(const pm_surface *s)
{
    return pm_rgb_add(quadrature(s, 300, 300), delta_albedo(s));
}

static void energy_never_grows(void **state)
{
    (void)state;
    for (int i = 0; i < FINITE; i++) {
        pm_world *world = floor_of(materials_of_density[i]);
        for (int c = 0; c < COSINES; c++)
            for (int side = -1; side <= 1; side += 2) {
                pm_surface s = floor_at(world, polar(side * cosines[c], 1));
                pm_rgb albedo = albedo_of(&s);
                if (!(pm_rgb_max(albedo) <= 1 + 1e-6))
                    fail_msg("%s: albedo %.9g %.9g %.9g at cosine %g", materials_of_density[i],
                             albedo.r, albedo.g, albedo.b, side * cosines[c]);
            }
        pm_world_free(world);
    }
}

/* What the lobes are picked by. */
static double density(void *context, pm_vec3 wi)
{
    const pm_surface *s = context;
    double sum = 0, total = 0;
    for (unsigned i = 0; i < s->count; i++) {
        double share = pm_rgb_mean(s->lobes[i].albedo);
        total += share;
        sum += share * pm_lobe_pdf(s, &s->lobes[i], wi);
    }
    return sum / total;
}

static pm_scatter draw_scatter(const pm_surface *s, pm_rng *rng)
{
    double u[3];
    pm_scatter out;
    draw(rng, u, 3);
    pm_surface_sample(s, white, u, &out);
    return out;
}

static bool is_finite_event(pm_event event)
{
    return event == PM_EVENT_DIFFUSE || event == PM_EVENT_GLOSSY;
}

static void sampling_frequency_equals_pdf(void **state)
{
    (void)state;
    for (int i = 0; i < FINITE; i++) {
        pm_world *world = floor_of(materials_of_density[i]);
        pm_surface s = floor_at(world, polar(.6, .4));
        struct histogram h = {.samples = 100000};
        pm_rng rng;
        pm_rng_init(&rng, 21, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < h.samples; k++) {
            pm_scatter out = draw_scatter(&s, &rng);
            if (!is_finite_event(out.event))
                continue;
            assert_true(out.transmitted == (out.wi.z < 0));
            assert_near(pm_vec3_length(out.wi), 1, 1e-12);
            histogram_add(&h, out.wi);
        }
        histogram_expect(&h, density, &s);
        histogram_check(&h);
        pm_world_free(world);
    }
}

/* Mean weight = albedo, which quadrature gives: 4 sigma. */
static void mean_weight_is_the_albedo(void **state)
{
    (void)state;
    enum { SAMPLES = 100000 };
    for (int i = 0; i < FINITE; i++) {
        pm_world *world = floor_of(materials_of_density[i]);
        pm_surface s = floor_at(world, polar(-.5, 2));
        double sum = 0, squares = 0;
        pm_rng rng;
        pm_rng_init(&rng, 23, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < SAMPLES; k++) {
            pm_scatter out = draw_scatter(&s, &rng);
            double weight = out.event == PM_EVENT_NONE ? 0 : out.weight.r;
            sum += weight;
            squares += weight * weight;
        }
        double mean = sum / SAMPLES,
               sigma = sqrt(fmax(squares / SAMPLES - mean * mean, 0) / SAMPLES);
        double wanted = albedo_of(&s).r;
        if (!(fabs(mean - wanted) <= 4 * sigma + 1e-4))
            fail_msg("%s: mean weight %g +- %g, albedo %g", materials_of_density[i], mean,
                     sigma, wanted);
        pm_world_free(world);
    }
}

/* The weight of one gather ray is that of all diffuse lobes. */
static void diffuse_draws_estimate_all_diffuse_lobes(void **state)
{
    (void)state;
    enum { SAMPLES = 40000 };
    for (int i = 0; i < FINITE; i++) {
        pm_world *world = floor_of(materials_of_density[i]);
        pm_surface s = floor_at(world, polar(.4, 1));
        double sum = 0, squares = 0, wanted = 0;
        pm_rng rng;
        pm_rng_init(&rng, 25, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < SAMPLES; k++) {
            double u[2];
            pm_scatter out;
            draw(&rng, u, 2);
            pm_surface_sample_diffuse(&s, u, &out);
            double weight = out.event == PM_EVENT_NONE ? 0 : out.weight.r;
            sum += weight;
            squares += weight * weight;
        }
        for (int b = 0; b < 90000; b++)
            wanted += pm_surface_value(
                          &s, PM_EVENT_DIFFUSE,
                          polar((b / 300 + .5) / 150 - 1, 2 * PM_PI * (b % 300 + .5) / 300))
                          .r;
        wanted *= 4 * PM_PI / 90000;
        double mean = sum / SAMPLES,
               sigma = sqrt(fmax(squares / SAMPLES - mean * mean, 0) / SAMPLES);
        assert_near(mean, wanted, 4 * sigma + 1e-4);
        pm_world_free(world);
    }
}

/* A photon's weight is f, but for what a tilted normal adds. */
static void photons_are_weighed_by_f(void **state)
{
    (void)state;
    for (int i = 0; i < FINITE; i++) {
        if (strstr(materials_of_density[i], "texfunc"))
            continue;
        pm_world *world = floor_of(materials_of_density[i]);
        pm_surface s = floor_at(world, polar(.6, .4));
        for (int k = 0; k < 40; k++) {
            pm_vec3 wi = polar((k + .5) / 20 - 1, k);
            pm_rgb f = pm_surface_photon_weight(&s, wi);
            pm_rgb value = pm_surface_value(&s, PM_EVENT_DIFFUSE, wi);
            assert_near(f.r * fabs(wi.z), value.r, 1e-12);
            assert_near(f.b * fabs(wi.z), value.b, 1e-12);
        }
        pm_world_free(world);
    }
}

/* ---- values ---- */

static void anisotropic_reflection_is_reciprocal(void **state)
{
    (void)state;
    pm_grain grain = {{0, 0, 1}, {.6, .8, 0}, .2, .5}, phong = {{0, 0, 1}, {.6, .8, 0}, 30, 4};
    pm_rng rng;
    pm_rng_init(&rng, 5, PM_RNG_PATH, 0);
    for (int i = 0; i < 1000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 a = pm_warp_cosine(u[0], u[1]), b = pm_warp_cosine(u[2], u[3]);
        double there = pm_grain_ward(&grain, a, b) / b.z;
        assert_near(pm_grain_ward(&grain, b, a) / a.z, there, 1e-12 * there);
        there = pm_grain_phong(&phong, a, b) / b.z;
        assert_near(pm_grain_phong(&phong, b, a) / a.z, there, 1e-12 * there);
    }
}

/* Ward 1992 in the form of Radiance's aniso.c, written out for one pair of directions. */
static void plastic2_is_wards_with_two_widths(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plastic2 m 4 0 2 1 . 0 6 .5 .5 .5 .4 .3 .15");
    pm_vec3 wo = polar(.8, .3), wi = polar(.7, 3);
    pm_surface s = floor_at(world, wo);
    double hx = wo.x + wi.x, hy = wo.y + wi.y, hz = wo.z + wi.z;
    double e = (hy * hy / .09 + hx * hx / .0225) / (hz * hz); /* u is y */
    double wanted =
        .4 * .7 * exp(-e) * (hx * hx + hy * hy + hz * hz) / (PM_PI * pow(hz, 4) * .3 * .15);
    assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, wi).g, wanted, 1e-12);
    assert_near(pm_surface_value(&s, PM_EVENT_DIFFUSE, wi).g, .5 * .6 * .7 / PM_PI, 1e-15);
    pm_world_free(world);
}

/* Equal widths are the isotropic material of that roughness. */
static void equal_widths_are_the_isotropic_material(void **state)
{
    (void)state;
    pm_world *two = floor_of("void trans2 m 4 1 1 0 . 0 8 .8 .7 .6 .2 .3 .3 .7 .6");
    pm_world *one = floor_of("void trans m 0 0 7 .8 .7 .6 .2 .3 .7 .6");
    pm_surface a = floor_at(two, polar(.6, .4)), b = floor_at(one, polar(.6, .4));
    for (int k = 0; k < 60; k++) {
        pm_vec3 wi = polar((k + .5) / 30 - 1, 2.3 * k);
        double wanted = finite_value(&b, wi).g;
        assert_near(finite_value(&a, wi).g, wanted, 1e-12 + 1e-10 * wanted);
    }
    pm_world_free(one);
    pm_world_free(two);
}

/* Ashikhmin and Shirley 2000, eq. 4, with Radiance's Fresnel factor. */
static void ashik2_is_ashikhmins_and_shirleys(void **state)
{
    (void)state;
    pm_world *world = floor_of("void ashik2 m 4 1 0 0 . 0 8 .3 .3 .3 .1 .2 .4 10 100");
    pm_vec3 wo = polar(.8, .3), wi = polar(.6, 3);
    pm_surface s = floor_at(world, wo);
    pm_vec3 h = pm_vec3_normalize(pm_vec3_add(wo, wi));
    double e = (10 * h.x * h.x + 100 * h.y * h.y) / (1 - h.z * h.z);
    double fresnel = .2 + .8 * pow(.2, 5);
    double wanted =
        sqrt(11. * 101) / (8 * PM_PI) * pow(h.z, e) / (pm_vec3_dot(h, wi) * .8) * fresnel * .6;
    assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, wi).g, wanted, 1e-12);
    wanted = .3 * .6 / PM_PI * (1 - pow(.4, 5));
    assert_near(pm_surface_value(&s, PM_EVENT_DIFFUSE, wi).g, wanted, 1e-14);
    pm_world_free(world);
}

/* 1e-6: the albedo of `broad` is 1, which quadrature knows to that. */
static void functions_say_what_they_scatter(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plasfunc m 2 broad f.cal 0 4 .5 .4 .3 .6");
    for (int side = -1; side <= 1; side += 2) {
        pm_surface s = floor_at(world, polar(.6 * side, 1));
        pm_vec3 wi = polar(.7 * side, 2);
        pm_rgb f = pm_surface_value(&s, PM_EVENT_DIFFUSE, wi);
        double function = .6 * 1.5 / PM_PI * .7;
        assert_near(f.r, .7 * (.5 * .4 / PM_PI + function), 1e-6);
        assert_near(f.b, .7 * (.3 * .4 / PM_PI + function), 1e-6);
    }
    pm_world_free(world);
    world = floor_of("void transfunc m 2 broad f.cal 0 6 .9 .8 .7 .3 .6 .5");
    pm_surface s = floor_at(world, polar(.6, 1));
    pm_rgb f = pm_surface_value(&s, PM_EVENT_DIFFUSE, polar(-.5, 2));
    double passed = .7 * .6;
    assert_near(f.g, .5 * .8 * (passed * .5 / PM_PI + passed * .5 * 1.5 / PM_PI * .5), 1e-6);
    pm_world_free(world);
    world = floor_of("void metdata m 4 scaled d.dat f.cal polar 0 4 .5 .4 .2 .6");
    s = floor_at(world, polar(.6, 1));
    f = pm_surface_value(&s, PM_EVENT_DIFFUSE, polar(.25, 2)); /* the data say .6 */
    assert_near(f.g, .25 * .4 * (.4 + .6 * .6) / PM_PI, 1e-6);
    pm_world_free(world);
}

static const pm_lobe *delta(const pm_surface *s, pm_event event, unsigned side)
{
    for (unsigned i = 0; i < s->count; i++)
        if (s->lobes[i].event == event && s->lobes[i].sides == side)
            return &s->lobes[i];
    fail_msg("no such lobe");
    return NULL;
}

/* Its sides have diffuse parts of their own, and the functions see which one is hit. */
static void brtdfunc_has_two_sides(void **state)
{
    (void)state;
    pm_world *world = floor_of("void BRTDfunc m 10 .1 Rdot 0 .2 .15 0 red green 0 f.cal 0 9 .1 "
                               ".1 .1 .2 .2 .2 .1 .1 .1");
    pm_surface front = floor_at(world, polar(.3, 0)), back = floor_at(world, polar(-.3, 0));
    pm_rgb f = pm_surface_value(&front, PM_EVENT_DIFFUSE, polar(.5, 1));
    assert_near(f.r, .5 * (.1 + .3) / PM_PI, 1e-12); /* z and Dz differ in sign: .3 */
    assert_near(f.g, .5 * (.1 + .15) / PM_PI, 1e-12);
    assert_near(f.b, .5 * .1 / PM_PI, 1e-12);
    f = pm_surface_value(&back, PM_EVENT_DIFFUSE, polar(-.5, 1));
    assert_near(f.b, .5 * .2 / PM_PI, 1e-12);
    f = pm_surface_value(&back, PM_EVENT_DIFFUSE, polar(.5, 1));
    assert_near(f.b, .5 * .1 / PM_PI, 1e-12);
    assert_near(delta(&front, PM_EVENT_SPECULAR, PM_SIDE_NEAR)->albedo.g, .3, 1e-12);
    assert_near(delta(&back, PM_EVENT_SPECULAR, PM_SIDE_NEAR)->albedo.g, 0, 0); /* Rdot < 0 */
    assert_near(delta(&front, PM_EVENT_STRAIGHT, PM_SIDE_FAR)->albedo.g, .15, 1e-12);
    assert_near(delta(&front, PM_EVENT_STRAIGHT, PM_SIDE_FAR)->u.direction.wi.z, -.3, 1e-15);
    pm_world_free(world);
}

/* A function that would make light is scaled down, each direction to what is left for it. */
static void functions_that_make_light_are_scaled(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plasfunc m 2 greedy f.cal 0 4 1 1 1 .5");
    pm_surface s = floor_at(world, polar(.4, 0));
    pm_rgb f = pm_surface_value(&s, PM_EVENT_DIFFUSE, polar(.5, 1));
    assert_near(f.g, .5 * (.5 + .5) / PM_PI, .02 * .5 / PM_PI);
    pm_world_free(world);
}

static void huge_functions_stay_finite(void **state)
{
    (void)state;
    pm_world *world = floor_of(
        "void BRTDfunc m 10 0 0 0 0 0 0 huge green 0 f.cal 0 9 .1 .1 .1 .2 .2 .2 .1 .1 .1");
    pm_surface s = floor_at(world, polar(.4, 0));
    pm_rng rng;
    pm_rng_init(&rng, 41, PM_RNG_PATH, 0);
    for (int i = 0; i < 1000; i++) {
        pm_scatter out = draw_scatter(&s, &rng);
        assert_true(pm_rgb_finite(out.weight));
        assert_true(pm_rgb_finite(pm_surface_photon_weight(&s, out.wi)));
    }
    assert_true(pm_rgb_max(albedo_of(&s)) <= 1 + 1e-6);
    pm_world_free(world);
}

static void mixtures_put_scaled_lobes_together(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plastic a 0 0 5 .8 .4 .2 0 0\n"
                               "void glass b 0 0 3 .9 .9 .9\n"
                               "void mixfunc c 4 a b .25 . 0 0\n"
                               "void mixfunc m 4 c void .6 . 0 0");
    pm_surface s = floor_at(world, polar(.5, 0));
    assert_near(pm_surface_part(&s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR).r, .6 * .25 * .8, 1e-15);
    pm_world *glass = floor_of("void glass m 0 0 3 .9 .9 .9");
    pm_surface g = floor_at(glass, polar(.5, 0));
    double through = pm_surface_part(&g, PM_EVENT_STRAIGHT, PM_SIDE_FAR).g;
    assert_near(pm_surface_part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR).g, .6 * .75 * through + .4,
                1e-14);
    pm_world_free(glass);
    pm_world_free(world);
}

/* A plastic is two lobes; 2^3 of them are as many as fit. */
static void mixtures_of_too_much_are_refused(void **state)
{
    (void)state;
    for (int levels = 3; levels < 10; levels += 5) {
        char text[4000];
        int used = snprintf(text, sizeof text, "void plastic m0 0 0 5 .5 .5 .5 .1 .1\n");
        for (int i = 1; i <= levels; i++)
            used += snprintf(text + used, sizeof text - (size_t)used,
                             "void mixfunc m%d 4 m%d m%d .5 . 0 0\n", i, i - 1, i - 1);
        snprintf(text + used, sizeof text - (size_t)used, "m%d sphere s 0 0 4 0 0 0 1\n",
                 levels);
        pm_error err = PM_ERROR_INIT;
        pm_bundle *bundle = pm_bundle_new();
        pm_scene *scene = NULL;
        pm_world *world = NULL;
        assert_int_equal(pm_bundle_add(bundle, "s.rad", text, strlen(text), NULL), PM_OK);
        if (pm_scene_parse(bundle, "s.rad", NULL, &scene, &err))
            fail_msg("%s", err.text);
        pm_status st = pm_world_compile(scene, &world, &err);
        assert_int_equal(st, levels == 3 ? PM_OK : PM_E_UNSUPPORTED);
        if (st)
            assert_non_null(strstr(err.text, "mixes too much"));
        pm_scene_free(scene);
        pm_world_free(world);
        pm_bundle_free(bundle);
    }
}

/* ---- directions ---- */

static void expect_direction(pm_vec3 found, double x, double y, double z)
{
    pm_vec3 wanted = pm_vec3_normalize((pm_vec3){x, y, z});
    assert_near(pm_vec3_length(pm_vec3_sub(found, wanted)), 0, 1e-12);
}

/* Deflected by 30 degrees in the plane of x, and a second part sent back the way it came. */
static void prisms_redirect(void **state)
{
    (void)state;
    pm_world *world = floor_of("void prism2 m 9 .5 Dx*cos(PI/6)-Dz*sin(PI/6) Dy "
                               "Dx*sin(PI/6)+Dz*cos(PI/6) .25 -Dx -Dy -Dz . 0 0");
    pm_surface s = floor_at(world, (pm_vec3){0, 0, 1});
    const pm_lobe *first = delta(&s, PM_EVENT_SPECULAR, PM_SIDE_FAR);
    expect_direction(first->u.direction.wi, .5, 0, -sqrt(.75));
    assert_near(first->albedo.g, .5 * sqrt(.75), 1e-15); /* flux; the beam's section shrinks */
    assert_near(first->albedo.g * first->u.direction.radiance_scale, .5, 1e-15);
    const pm_lobe *second = delta(&s, PM_EVENT_SPECULAR, PM_SIDE_NEAR);
    expect_direction(second->u.direction.wi, 0, 0, 1);
    assert_near(second->albedo.g, .25, 0);
    assert_near(pm_surface_part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR).g, 0, 0);
    pm_world_free(world);
    world = floor_of("void prism1 m 7 3 Dx Dy -Dz . -rz 90 0 0"); /* as strong as can be */
    s = floor_at(world, (pm_vec3){.6, 0, .8});
    first = delta(&s, PM_EVENT_SPECULAR, PM_SIDE_NEAR);
    expect_direction(first->u.direction.wi, -.6, 0, .8);
    assert_near(first->albedo.g, 1, 0);
    pm_world_free(world);
}

/* Water over glass: Snell with the ratio of both, Fresnel at normal incidence. */
static void interfaces_refract_between_their_media(void **state)
{
    (void)state;
    pm_world *world = floor_of("void interface m 0 0 8 1 1 1 1.5 1 1 1 1.33");
    pm_surface s = floor_at(world, (pm_vec3){.6, 0, .8});
    double sine = .6 * 1.33 / 1.5;
    const pm_lobe *in = delta(&s, PM_EVENT_SPECULAR, PM_SIDE_FAR);
    expect_direction(in->u.direction.wi, -sine, 0, -sqrt(1 - sine * sine));
    assert_near(in->u.direction.radiance_scale, 1.33 * 1.33 / 2.25, 1e-14);
    s = floor_at(world, (pm_vec3){0, 0, 1});
    assert_near(pm_surface_part(&s, PM_EVENT_SPECULAR, PM_SIDE_NEAR).g, pow(.17 / 2.83, 2),
                1e-14);
    s = floor_at(world, (pm_vec3){.95, 0, -sqrt(1 - .95 * .95)}); /* critical sine .887 */
    assert_near(pm_surface_part(&s, PM_EVENT_SPECULAR, PM_SIDE_NEAR).g, 1, 0);
    pm_world_free(world);
}

/* ---- textures ---- */

/* The normal (0, 0, 1) + (.75, 0, 0), normalised: (.6, 0, .8). */
#define TILT "void texfunc t 4 .75 0 0 . 0 0\n"

static void textures_turn_mirrors(void **state)
{
    (void)state;
    pm_world *world = floor_of(TILT "t mirror m 0 0 3 .9 .8 .7");
    pm_surface s = floor_at(world, (pm_vec3){0, 0, 1});
    /* twice the angle of the normal: sin = 2 .6 .8, cos = .64 - .36 */
    expect_direction(pm_lobe_direction(&s, &s.lobes[0]), .96, 0, .28);
    /* from there the mirrored direction is below the surface: Radiance's way out */
    s = floor_at(world, (pm_vec3){-.6, 0, .8});
    expect_direction(pm_lobe_direction(&s, &s.lobes[0]), .6, 0, .8);
    pm_world_free(world);
}

/* A perturbed normal that faces away is turned about the line of sight, so that it faces wo. */
static void normals_that_face_away_are_turned(void **state)
{
    (void)state;
    pm_world *world = floor_of(TILT "t plastic m 0 0 5 .5 .5 .5 0 0");
    pm_vec3 wo = pm_vec3_normalize((pm_vec3){-1, 0, .5}); /* .6, 0, .8 is behind it: -.2 */
    pm_surface s = floor_at(world, wo);
    assert_true(s.lobes[0].tilted);
    assert_near(pm_vec3_dot(s.lobes[0].normal, wo), .2 / sqrt(1.25), 1e-12);
    pm_world_free(world);
}

static void textures_let_no_light_through(void **state)
{
    (void)state;
    const char *const materials[] = {
        "t plastic m 0 0 5 .5 .5 .5 .3 .3",
        "t plastic2 m 4 1 0 0 . 0 6 .5 .5 .5 .3 .3 .1",
        "t ashik2 m 4 1 0 0 . 0 8 .5 .5 .5 .3 .3 .3 10 10",
        "t metfunc m 2 broad f.cal 0 4 .5 .5 .5 .3",
        "t mirror m 0 0 3 1 1 1",
    };
    for (int i = 0; i < 5; i++) {
        char text[300];
        snprintf(text, sizeof text, "void texfunc t 4 1.5 .5 0 . 0 0\n%s", materials[i]);
        pm_world *world = floor_of(text);
        pm_rng rng;
        pm_rng_init(&rng, 31, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < 4000; k++) {
            double u[4];
            draw(&rng, u, 4);
            pm_vec3 wo = pm_warp_sphere(u[0], u[1]), wi = pm_warp_sphere(u[2], u[3]);
            if (wo.z < 0 && i == 4)
                continue;
            pm_surface s = floor_at(world, wo);
            if (wi.z * wo.z < 0)
                assert_true(pm_rgb_is_black(finite_value(&s, wi)));
            pm_scatter out = draw_scatter(&s, &rng);
            assert_true(out.event == PM_EVENT_NONE || out.wi.z * wo.z > 0);
            assert_true(pm_rgb_finite(out.weight));
        }
        pm_world_free(world);
    }
}

/* Glass bends what the eye sees, and nothing else. */
static void textured_glass_bends_sight_alone(void **state)
{
    (void)state;
    pm_world *world = floor_of("void texfunc t 4 .1 0 0 . 0 0\nt glass m 0 0 4 1 1 1 1.5");
    pm_hit hit = {.t = 1, .normal = {0, 0, 1}};
    pm_surface s;
    pm_surface_at(world, &hit, (pm_vec3){0, 0, 1}, &outside, &s);
    expect_direction(delta(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR)->u.direction.wi, 0, 0, -1);
    pm_surface_seen_at(world, &hit, (pm_vec3){0, 0, 1}, &outside, &s);
    expect_direction(delta(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR)->u.direction.wi, -.1, 0, -1);
    pm_world_free(world);
}

/* Waves on water: Snell about the perturbed normal. */
static void textures_turn_refraction(void **state)
{
    (void)state;
    pm_world *world = floor_of(TILT "t dielectric m 0 0 5 1 1 1 1.5 0");
    pm_surface s = floor_at(world, (pm_vec3){0, 0, 1});
    const pm_lobe *in = delta(&s, PM_EVENT_SPECULAR, PM_SIDE_FAR);
    double sine = .6 / 1.5, cosine = sqrt(1 - sine * sine); /* to the normal (.6, 0, .8) */
    expect_direction(in->u.direction.wi, .8 * sine - .6 * cosine, 0, -.6 * sine - .8 * cosine);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_never_grows),
        cmocka_unit_test(sampling_frequency_equals_pdf),
        cmocka_unit_test(mean_weight_is_the_albedo),
        cmocka_unit_test(diffuse_draws_estimate_all_diffuse_lobes),
        cmocka_unit_test(photons_are_weighed_by_f),
        cmocka_unit_test(anisotropic_reflection_is_reciprocal),
        cmocka_unit_test(plastic2_is_wards_with_two_widths),
        cmocka_unit_test(equal_widths_are_the_isotropic_material),
        cmocka_unit_test(ashik2_is_ashikhmins_and_shirleys),
        cmocka_unit_test(functions_say_what_they_scatter),
        cmocka_unit_test(brtdfunc_has_two_sides),
        cmocka_unit_test(functions_that_make_light_are_scaled),
        cmocka_unit_test(huge_functions_stay_finite),
        cmocka_unit_test(mixtures_put_scaled_lobes_together),
        cmocka_unit_test(mixtures_of_too_much_are_refused),
        cmocka_unit_test(prisms_redirect),
        cmocka_unit_test(interfaces_refract_between_their_media),
        cmocka_unit_test(textures_turn_mirrors),
        cmocka_unit_test(normals_that_face_away_are_turned),
        cmocka_unit_test(textures_let_no_light_through),
        cmocka_unit_test(textured_glass_bends_sight_alone),
        cmocka_unit_test(textures_turn_refraction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
