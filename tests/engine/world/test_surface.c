#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/warp.h"
#include "numbers.h"
#include "world/media.h"
#include "world/surface.h"

#define FLOOR "m polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n" /* front up */

static const pm_media outside = {0};
static const pm_rgb white = {1, 1, 1};
static const double cosines[] = {1, .8, .5, .2, .05, .001};
enum { COSINES = 6 };

static pm_hit floor_hit(void)
{
    return (pm_hit){.t = 1, .normal = {0, 0, 1}};
}

static pm_world *floor_of(const char *material)
{
    char text[400];
    snprintf(text, sizeof text, "%s\n" FLOOR, material);
    return world_of(text);
}

static pm_surface floor_at(const pm_world *world, pm_vec3 wo)
{
    pm_surface surface;
    pm_hit hit = floor_hit();
    pm_surface_at(world, &hit, wo, &outside, &surface);
    return surface;
}

/* ---- the parts of a surface ---- */

static pm_rgb diffuse_near(const pm_surface *s)
{
    return pm_surface_part(s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR);
}

static pm_rgb diffuse_far(const pm_surface *s)
{
    return pm_surface_part(s, PM_EVENT_DIFFUSE, PM_SIDE_FAR);
}

static pm_rgb specular_near(const pm_surface *s)
{
    return pm_rgb_add(pm_surface_part(s, PM_EVENT_GLOSSY, PM_SIDE_NEAR),
                      pm_surface_part(s, PM_EVENT_SPECULAR, PM_SIDE_NEAR));
}

static pm_rgb specular_far(const pm_surface *s)
{
    return pm_rgb_add(pm_surface_part(s, PM_EVENT_GLOSSY, PM_SIDE_FAR),
                      pm_surface_part(s, PM_EVENT_SPECULAR, PM_SIDE_FAR));
}

static pm_rgb straight(const pm_surface *s)
{
    return pm_surface_part(s, PM_EVENT_STRAIGHT, PM_SIDE_FAR);
}

/* The delta lobe on the far side. */
static const pm_lobe *refracted(const pm_surface *s)
{
    for (unsigned i = 0; i < s->count; i++)
        if (s->lobes[i].event == PM_EVENT_SPECULAR && s->lobes[i].sides == PM_SIDE_FAR)
            return &s->lobes[i];
    fail_msg("nothing is refracted");
    return NULL;
}

/* Ward's alpha; 0 if no lobe is rough. */
static double roughness(const pm_surface *s)
{
    for (unsigned i = 0; i < s->count; i++)
        if (s->lobes[i].event == PM_EVENT_GLOSSY)
            return s->lobes[i].u.rough.alpha;
    return 0;
}

/* ---- energy ---- */

/* Red stands for all: the lobes treat the colours alike. */
static double red_reflected(const void *context, pm_vec3 wi)
{
    const pm_surface *s = context;
    return pm_vec3_dot(wi, s->normal) > 0 ? pm_surface_value(s, PM_EVENT_GLOSSY, wi).r : 0;
}

static double red_transmitted(const void *context, pm_vec3 wi)
{
    const pm_surface *s = context;
    return pm_vec3_dot(wi, s->normal) > 0 ? 0 : pm_surface_value(s, PM_EVENT_GLOSSY, wi).r;
}

/* Integral of the diffuse part on one side: cos^2 in equal steps, and no azimuth to it. */
static double red_diffuse(const pm_surface *s, double side)
{
    enum { RINGS = 20000 };
    double sum = 0;
    for (int i = 0; i < RINGS; i++) {
        double cosine = sqrt((i + .5) / RINGS);
        sum +=
            pm_surface_value(s, PM_EVENT_DIFFUSE, polar(side * cosine, 1)).r * PM_PI / cosine;
    }
    return sum / RINGS;
}

static double red_albedo(const pm_surface *s)
{
    double sum = red_diffuse(s, 1) + red_diffuse(s, -1) + straight(s).r;
    if (!(roughness(s) > 0))
        return sum + specular_near(s).r + specular_far(s).r;
    return sum + over_reflections(red_reflected, s, s->normal, s->wo, roughness(s)) +
           over_transmissions(red_transmitted, s, s->wo);
}

static void check_energy(const char *material)
{
    pm_world *world = floor_of(material);
    for (int c = 0; c < COSINES; c++)
        for (int side = -1; side <= 1; side += 2) {
            pm_surface s = floor_at(world, polar(side * cosines[c], 1));
            double albedo = red_albedo(&s);
            if (!(albedo <= 1 + 1e-6))
                fail_msg("%s: albedo %.9g at cosine %g", material, albedo, side * cosines[c]);
        }
    pm_world_free(world);
}

static void check_energy_of(const char *type, const char *tail)
{
    const double specularities[] = {0, .01, .02, .3, 1};
    const double roughnesses[] = {0, .002, .05, .3, 1};
    char text[200];
    for (int i = 0; i < 25; i++) {
        snprintf(text, sizeof text, "void %s m 0 0 %s 1 1 .5 %g %g %s", type, *tail ? "7" : "5",
                 specularities[i / 5], roughnesses[i % 5], tail);
        check_energy(text);
    }
}

static void energy_never_grows_in_plastic(void **state)
{
    (void)state;
    check_energy_of("plastic", "");
}

static void energy_never_grows_in_metal(void **state)
{
    (void)state;
    check_energy_of("metal", "");
}

static void energy_never_grows_in_trans(void **state)
{
    (void)state;
    check_energy_of("trans", ".7 .4");
    check_energy_of("trans", "1 1");
}

static void energy_never_grows_in_glass_dielectric_and_mirror(void **state)
{
    (void)state;
    check_energy("void glass m 0 0 3 1 .5 0");
    check_energy("void glass m 0 0 4 1 1 .9 2.4");
    check_energy("void dielectric m 0 0 5 1 .5 .1 1.5 0");
    check_energy("void dielectric m 0 0 5 1 1 1 1 0");
    check_energy("void mirror m 0 0 3 1 .9 0");
}

/* Not only at most: smooth plastic of white colour absorbs just what its diffuse part lets the
 * light's side reflect twice, (1 - s)(1 - F(wo)) times the cosine-weighted mean of F, where
 * integral of F(c) 2 c dc = 2 (1 - (1 + k) e^-k) / k^2 - e^-k with k = 5.85. */
static void smooth_plastic_absorbs_what_is_derived(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plastic m 0 0 5 1 1 1 .05 0");
    double k = 5.85, mean = 2 * (1 - (1 + k) * exp(-k)) / (k * k) - exp(-k);
    for (int c = 0; c < COSINES; c++) {
        pm_surface s = floor_at(world, polar(cosines[c], 0));
        double rise = exp(-k * cosines[c]) - exp(-k);
        double wanted = 1 - .95 * (1 - rise) * mean;
        assert_near(red_albedo(&s), wanted, 1e-6);
    }
    pm_world_free(world);
}

/* ---- values ---- */

static void lambertian_is_rho_over_pi(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plastic m 0 0 5 .8 .4 .2 0 0");
    pm_surface s = floor_at(world, polar(.3, 0));
    pm_rgb f = pm_surface_value(&s, PM_EVENT_DIFFUSE, polar(.7, 2));
    assert_near(f.r, .8 * .7 / PM_PI, 1e-15);
    assert_near(f.g, .4 * .7 / PM_PI, 1e-15);
    assert_true(pm_rgb_is_black(pm_surface_value(&s, PM_EVENT_DIFFUSE, polar(-.7, 2))));
    assert_true(pm_surface_has(&s, PM_EVENT_DIFFUSE));
    pm_world_free(world);
}

static void diffuse_parts_are_reciprocal(void **state)
{
    (void)state;
    pm_world *world = floor_of("void trans m 0 0 7 .9 .8 .7 .1 0 .6 .3");
    pm_rng rng;
    pm_rng_init(&rng, 5, PM_RNG_PATH, 0);
    for (int i = 0; i < 1000; i++) {
        double u[4];
        draw(&rng, u, 4);
        pm_vec3 a = pm_warp_sphere(u[0], u[1]), b = pm_warp_sphere(u[2], u[3]);
        pm_surface from_a = floor_at(world, a), from_b = floor_at(world, b);
        double there = pm_surface_value(&from_a, PM_EVENT_DIFFUSE, b).g / fabs(b.z);
        assert_near(pm_surface_value(&from_b, PM_EVENT_DIFFUSE, a).g / fabs(a.z), there,
                    1e-12 * there);
    }
    pm_world_free(world);
}

/* Radiance's normal.c, written out for one set of numbers. */
static void trans_parts_are_radiances(void **state)
{
    (void)state;
    pm_world *world = floor_of("void trans m 0 0 7 .5 .6 .7 .05 0 .4 .25");
    pm_surface s = floor_at(world, polar(.6, 0));
    double rise = exp(-5.85 * .6) - 0.00287989916, specular = .05 + rise * .95;
    double transmitted = .4 * (1 - specular);
    assert_near(specular_near(&s).g, specular, 1e-14);
    assert_near(straight(&s).g, .6 * transmitted * .25, 1e-14);
    assert_near(diffuse_far(&s).b, .7 * transmitted * .75, 1e-14);
    assert_near(diffuse_near(&s).r, .5 * (1 - specular - transmitted), 1e-14);
    assert_true(s.lobes[0].coat && roughness(&s) == 0);
    pm_world_free(world);
    world = floor_of("void trans m 0 0 7 .5 .6 .7 .05 .1 .4 .25"); /* rough: no rise */
    s = floor_at(world, polar(.6, 0));
    assert_near(specular_far(&s).g, .6 * .4 * .95 * .25, 1e-14);
    assert_true(pm_rgb_is_black(straight(&s)) && !s.lobes[0].coat);
    pm_world_free(world);
}

/* A diffuse rest of 1e-17 would end gather rays and store photons. */
static void trans_that_passes_all_straight_has_no_diffuse_part(void **state)
{
    (void)state;
    for (int i = 0; i <= 100; i++)
        for (int rough = 0; rough < 2; rough++) {
            char text[100];
            snprintf(text, sizeof text, "void trans m 0 0 7 .6 .5 .4 %g %g 1 1", i / 100.,
                     .1 * rough);
            pm_world *world = floor_of(text);
            for (int c = 0; c < COSINES; c++) {
                pm_surface s = floor_at(world, polar(cosines[c], 0));
                assert_false(pm_surface_has(&s, PM_EVENT_DIFFUSE));
            }
            pm_world_free(world);
        }
}

static void metal_colours_its_reflection(void **state)
{
    (void)state;
    pm_world *world = floor_of("void metal m 0 0 5 .9 .5 .1 .8 .2");
    pm_surface s = floor_at(world, polar(.6, 0));
    assert_near(specular_near(&s).r, .72, 1e-15);
    assert_near(specular_near(&s).b, .08, 1e-15);
    assert_near(diffuse_near(&s).g, .1, 1e-15);
    pm_world_free(world);
}

static void both_sides_of_plastic_are_alike_and_a_mirrors_back_is_black(void **state)
{
    (void)state;
    pm_world *world = floor_of("void plastic m 0 0 5 .8 .4 .2 .1 .1");
    pm_surface front = floor_at(world, polar(.3, 0)), back = floor_at(world, polar(-.3, 0));
    assert_near(diffuse_near(&front).r, diffuse_near(&back).r, 0);
    assert_near(back.normal.z, -1, 0);
    pm_world_free(world);
    world = floor_of("void mirror m 0 0 3 .8 .8 .8");
    front = floor_at(world, polar(.3, 0));
    back = floor_at(world, polar(-.3, 0));
    assert_near(specular_near(&front).r, .8, 0);
    assert_true(pm_rgb_is_black(specular_near(&back)));
    pm_world_free(world);
}

static void lamps_absorb_from_both_sides(void **state)
{
    (void)state;
    const char *lamps[] = {"void light m 0 0 3 1 1 1", "void glow m 0 0 4 1 1 1 0",
                           "void spotlight m 0 0 7 1 1 1 30 0 0 1"};
    for (int i = 0; i < 3; i++) {
        pm_world *world = floor_of(lamps[i]);
        for (int side = -1; side <= 1; side += 2) {
            pm_surface s = floor_at(world, polar(.5 * side, 0));
            pm_scatter scatter;
            pm_surface_sample(&s, white, (double[3]){.5, .5, .5}, &scatter);
            assert_int_equal(scatter.event, PM_EVENT_NONE);
        }
        pm_world_free(world);
    }
}

/* Snell's law, both ways; what goes in comes out along the same line. */
static void dielectric_refracts_by_snell(void **state)
{
    (void)state;
    pm_world *world = floor_of("void dielectric m 0 0 5 1 1 1 1.5 0");
    for (int c = 0; c < COSINES; c++) {
        pm_surface in = floor_at(world, polar(cosines[c], 1));
        double sine = sqrt(1 - cosines[c] * cosines[c]);
        assert_near(hypot(refracted(&in)->u.direction.wi.x, refracted(&in)->u.direction.wi.y),
                    sine / 1.5, 1e-15);
        assert_true(refracted(&in)->u.direction.wi.z < 0);
        assert_near(refracted(&in)->u.direction.radiance_scale, 1 / 2.25, 1e-15);
        pm_surface out = floor_at(world, refracted(&in)->u.direction.wi);
        pm_vec3 back = pm_vec3_sub(refracted(&out)->u.direction.wi, polar(cosines[c], 1));
        assert_near(pm_vec3_length(back), 0, 1e-15 / cosines[c]);
        assert_near(specular_far(&out).r, specular_far(&in).r, 1e-12);
        assert_near(refracted(&out)->u.direction.radiance_scale *
                        refracted(&in)->u.direction.radiance_scale,
                    1, 1e-15);
    }
    pm_surface caught = floor_at(world, polar(-.7, 0)); /* critical cosine .745 */
    assert_true(specular_near(&caught).r == 1);
    assert_true(pm_rgb_is_black(specular_far(&caught)));
    pm_world_free(world);
}

/* Radiance adds Hartmann's constant / 500 to the index. */
static void hartmann_constant_adds_to_the_index(void **state)
{
    (void)state;
    pm_world *world = floor_of("void dielectric m 0 0 5 1 1 1 1.4 50");
    pm_surface s = floor_at(world, polar(1, 0));
    assert_near(specular_near(&s).r, .04, 1e-15);
    pm_world_free(world);
}

/* ---- sampling ---- */

static const char *const finite_materials[] = {
    "void plastic m 0 0 5 .6 .6 .6 .3 .3",
    "void metal m 0 0 5 .9 .5 .1 .7 .5",
    "void trans m 0 0 7 .8 .8 .8 .1 .4 .7 .6",
    "void plastic m 0 0 5 .6 .6 .6 0 0",
};
enum { FINITE = 4 };

struct sampled {
    pm_surface surface;
    bool specular_only;
};

static double density_seen(void *context, pm_vec3 wi)
{
    /* The density that pm_surface_sample itself reports, read back for any direction: the
     * albedos are known, so the choice of lobes is. */
    const struct sampled *s = context;
    const pm_surface *surface = &s->surface;
    double parts[4] = {pm_rgb_mean(diffuse_near(surface)), pm_rgb_mean(diffuse_far(surface)),
                       pm_rgb_mean(specular_near(surface)), pm_rgb_mean(specular_far(surface))};
    if (s->specular_only)
        return pm_surface_glossy_pdf(surface, white, wi);
    double total = parts[0] + parts[1] + parts[2] + parts[3], glossy = parts[2] + parts[3];
    double diffuse = parts[wi.z > 0 ? 0 : 1] / total * fabs(wi.z) / PM_PI;
    return diffuse + glossy / total * pm_surface_glossy_pdf(surface, white, wi);
}

static void draw_surface(const struct sampled *s, pm_rng *rng, pm_scatter *out)
{
    double u[3];
    draw(rng, u, 3);
    if (s->specular_only)
        pm_surface_sample_specular(&s->surface, white, u, out);
    else
        pm_surface_sample(&s->surface, white, u, out);
}

static void check_frequency(const pm_world *world, bool specular_only, uint64_t index)
{
    struct sampled s = {floor_at(world, polar(.6, .4)), specular_only};
    struct histogram h = {.samples = 100000};
    pm_rng rng;
    pm_rng_init(&rng, 11, PM_RNG_PATH, index);
    for (int k = 0; k < h.samples; k++) {
        pm_scatter out;
        draw_surface(&s, &rng, &out);
        if (out.event == PM_EVENT_NONE)
            continue;
        assert_true(out.transmitted == (out.wi.z < 0));
        if (specular_only)
            assert_near(out.pdf, density_seen(&s, out.wi), 1e-9 * out.pdf);
        histogram_add(&h, out.wi);
    }
    histogram_expect(&h, density_seen, &s);
    histogram_check(&h);
}

static void sampling_frequency_equals_pdf(void **state)
{
    (void)state;
    for (int i = 0; i < FINITE; i++) {
        pm_world *world = floor_of(finite_materials[i]);
        check_frequency(world, false, (uint64_t)i);
        if (i < 3)
            check_frequency(world, true, 100 + (uint64_t)i);
        pm_world_free(world);
    }
}

/* Mean weight = albedo, which quadrature gives. 4 sigma; a weight is at most 4 lobes' worth. */
static void mean_weight_is_the_albedo(void **state)
{
    (void)state;
    enum { SAMPLES = 100000 };
    for (int i = 0; i < FINITE; i++) {
        pm_world *world = floor_of(finite_materials[i]);
        struct sampled s = {floor_at(world, polar(.3, .4)), false};
        double sum = 0, squares = 0;
        pm_rng rng;
        pm_rng_init(&rng, 13, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < SAMPLES; k++) {
            pm_scatter out;
            draw_surface(&s, &rng, &out);
            double weight = out.event == PM_EVENT_NONE ? 0 : out.weight.r;
            sum += weight;
            squares += weight * weight;
        }
        double mean = sum / SAMPLES, sigma = sqrt((squares / SAMPLES - mean * mean) / SAMPLES);
        assert_near(mean, red_albedo(&s.surface), 4 * sigma + 1e-6);
        pm_world_free(world);
    }
}

/* One surface with delta and straight lobes: each is drawn as often as its share says. */
static void lobes_are_drawn_by_their_albedo(void **state)
{
    (void)state;
    enum { STEPS = 10000 };
    pm_world *world = floor_of("void trans m 0 0 7 .5 .5 .5 .2 0 .5 .5");
    pm_surface s = floor_at(world, polar(.9, 0));
    double found[5] = {0};
    pm_rgb sum = {0, 0, 0};
    for (int i = 0; i < STEPS; i++) {
        pm_scatter out;
        pm_surface_sample(&s, white, (double[3]){(i + .5) / STEPS, .3, .8}, &out);
        found[out.event]++;
        sum = pm_rgb_add(sum, out.weight);
        if (out.event != PM_EVENT_DIFFUSE)
            assert_near(out.pdf, 0, 0);
        assert_near(out.radiance_scale, 1, 0);
    }
    double total =
        diffuse_near(&s).r + diffuse_far(&s).r + specular_near(&s).r + straight(&s).r;
    assert_near(found[PM_EVENT_SPECULAR] / STEPS, specular_near(&s).r / total, 2. / STEPS);
    assert_near(found[PM_EVENT_STRAIGHT] / STEPS, straight(&s).r / total, 2. / STEPS);
    assert_near(found[PM_EVENT_NONE], 0, 0);
    pm_world_free(world);
}

static void throughput_steers_the_choice(void **state)
{
    (void)state;
    pm_world *world = floor_of("void metal m 0 0 5 1 0 0 .5 .2");
    pm_surface s = floor_at(world, polar(.9, 0));
    pm_scatter out;
    pm_surface_sample(&s, (pm_rgb){0, 1, 1}, (double[3]){.5, .5, .5}, &out);
    assert_int_equal(out.event, PM_EVENT_NONE);
    pm_surface_sample(&s, (pm_rgb){1e-30, 0, 0}, (double[3]){.5, .5, .5}, &out);
    assert_int_not_equal(out.event, PM_EVENT_NONE);
    pm_world_free(world);
}

static void illum_is_its_alternate_material(void **state)
{
    (void)state;
    pm_world *world = floor_of("void illum m 0 0 3 1 1 1");
    pm_surface s = floor_at(world, polar(.5, 0));
    assert_near(straight(&s).r, 1, 0);
    pm_world_free(world);
    world = floor_of("void glass g 0 0 3 .9 .9 .9\nvoid illum m 1 g 0 3 1 1 1");
    s = floor_at(world, polar(1, 0));
    assert_near(straight(&s).r, .8257, 1e-3); /* .9 glass at normal incidence */
    pm_world_free(world);
}

static void mirror_shows_its_alternate_to_the_eye_alone(void **state)
{
    (void)state;
    pm_world *world =
        floor_of("void plastic p 0 0 5 .3 .3 .3 0 0\nvoid mirror m 1 p 0 3 .9 .9 .9");
    pm_hit hit = floor_hit();
    pm_surface s = floor_at(world, polar(.5, 0));
    hit.material = 0;
    pm_ray down = {{0, 0, 1}, {0, 0, -1}, INFINITY, PM_NO_PRIMITIVE};
    assert_true(pm_world_intersect(world, &down, &hit));
    pm_surface_at(world, &hit, polar(.5, 0), &outside, &s);
    assert_near(specular_near(&s).r, .9, 0);
    pm_surface_seen_at(world, &hit, polar(.5, 0), &outside, &s);
    assert_near(specular_near(&s).r, 0, 0);
    assert_near(diffuse_near(&s).r, .3, 0);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_never_grows_in_plastic),
        cmocka_unit_test(energy_never_grows_in_metal),
        cmocka_unit_test(energy_never_grows_in_trans),
        cmocka_unit_test(energy_never_grows_in_glass_dielectric_and_mirror),
        cmocka_unit_test(smooth_plastic_absorbs_what_is_derived),
        cmocka_unit_test(lambertian_is_rho_over_pi),
        cmocka_unit_test(diffuse_parts_are_reciprocal),
        cmocka_unit_test(trans_parts_are_radiances),
        cmocka_unit_test(trans_that_passes_all_straight_has_no_diffuse_part),
        cmocka_unit_test(metal_colours_its_reflection),
        cmocka_unit_test(both_sides_of_plastic_are_alike_and_a_mirrors_back_is_black),
        cmocka_unit_test(lamps_absorb_from_both_sides),
        cmocka_unit_test(dielectric_refracts_by_snell),
        cmocka_unit_test(hartmann_constant_adds_to_the_index),
        cmocka_unit_test(sampling_frequency_equals_pdf),
        cmocka_unit_test(mean_weight_is_the_albedo),
        cmocka_unit_test(lobes_are_drawn_by_their_albedo),
        cmocka_unit_test(throughput_steers_the_choice),
        cmocka_unit_test(illum_is_its_alternate_material),
        cmocka_unit_test(mirror_shows_its_alternate_to_the_eye_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
