#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/sobol.h"
#include "compile.h"
#include "numbers.h"
#include "world/light.h"
#include "world/selection.h"

#define FLOOR                                                                                  \
    "void plastic p 0 0 5 .5 .5 .5 0 0 p polygon f 0 0 12 0 0 -9 9 0 -9 9 9 -9 0 9 -9\n"

static const char *const scenes[] = {
    "void light m 0 0 3 1 2 3 m polygon a 0 0 18 0 0 0 2 0 0 2 1 0 1 1 0 1 2 0 0 2 0",
    "void light m 0 0 3 1 2 3 m sphere a 0 0 4 1 2 3 4",
    "void glow m 0 0 4 1 2 3 0 m bubble a 0 0 4 1 2 3 4",
    "void light m 0 0 3 1 2 3 m cylinder a 0 0 7 0 0 0 1 1 1 .3",
    "void light m 0 0 3 1 2 3 m tube a 0 0 7 0 0 0 1 1 1 .3",
    "void light m 0 0 3 1 2 3 m cone a 0 0 8 0 0 0 1 1 1 .3 .9",
    "void light m 0 0 3 1 2 3 m cup a 0 0 8 0 0 0 1 1 1 .9 0",
    "void illum m 0 0 3 1 2 3 m ring a 0 0 8 0 0 0 1 2 3 1 2",
    "void spotlight m 0 0 7 1 2 3 40 0 0 1 m ring a 0 0 8 0 0 0 0 0 2 0 2",
    "void spotlight m 0 0 7 1 2 3 300 0 0 1 m ring a 0 0 8 0 0 0 0 0 2 0 2",
    "void spotlight m 0 0 7 1 2 3 100 1 0 1 m ring a 0 0 8 0 0 0 0 0 2 0 2",
    "void spotlight m 0 0 7 1 2 3 200 1 0 -1 m ring a 0 0 8 0 0 0 0 0 2 0 2",
    "void spotlight m 0 0 7 1 2 3 50 1 0 1 m sphere a 0 0 4 0 0 0 2",
    "void spotlight m 0 0 7 1 2 3 50 1 0 1 m cone a 0 0 8 0 0 0 1 1 1 .3 .9",
    FLOOR "void light m 0 0 3 1 2 3 m source a 0 0 4 0 0 1 .5",
    FLOOR "void glow m 0 0 4 1 2 3 0 m source a 0 0 4 1 0 1 180",
    FLOOR "void light m 0 0 3 1 2 3 m source a 0 0 4 1 0 1 360",
    /* many at once, of very different power */
    FLOOR "void light m 0 0 3 1 2 3 void light n 0 0 3 300 1e-3 0 m sphere a 0 0 4 0 0 0 .1\n"
          "n sphere b 0 0 4 1 1 1 .01 m source c 0 0 4 0 1 1 3",
};
enum { SCENES = sizeof scenes / sizeof *scenes, SAMPLES = 1 << 16 };

static void sobol5(uint32_t i, double u[5])
{
    for (unsigned d = 0; d < 5; d++)
        u[d] = pm_sobol(i, d, 77 + d);
}

/* Mean flux = total power, within 5 sigma of independent samples (Sobol points do better). */
static void emission_sums_to_power(void **state)
{
    (void)state;
    for (int s = 0; s < SCENES; s++) {
        pm_world *world = world_of(scenes[s]);
        pm_rgb power = pm_light_total_power(world);
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            double u[5];
            pm_emission e;
            sobol5(i, u);
            assert_true(pm_light_emit(world, u, &e));
            assert_true(e.flux.r >= 0 && isfinite(e.flux.r));
            sum += e.flux.r;
            squares += e.flux.r * e.flux.r;
        }
        double mean = sum / SAMPLES, spread = fmax(squares / SAMPLES - mean * mean, 0);
        assert_near(mean, power.r, 5 * sqrt(spread / SAMPLES) + 1e-9 * power.r);
        pm_world_free(world);
    }
}

/* All photons of one colour carry the same but for oblique beams. */
static void photons_of_plain_lamps_are_equal(void **state)
{
    (void)state;
    for (int s = 0; s < SCENES - 1; s++) {
        if (s >= 10 && s <= 13)
            continue;
        pm_world *world = world_of(scenes[s]);
        pm_rgb power = pm_light_total_power(world);
        for (uint32_t i = 0; i < 1000; i++) {
            double u[5];
            pm_emission e;
            sobol5(i, u);
            assert_true(pm_light_emit(world, u, &e));
            assert_near(e.flux.b, power.b, 1e-12 * power.b);
        }
        pm_world_free(world);
    }
}

/* A ray backwards from just before the place meets that surface's front. */
static void photons_leave_from_the_front_of_their_lamp(void **state)
{
    (void)state;
    for (int s = 0; s < 14; s++) {
        pm_world *world = world_of(scenes[s]);
        for (uint32_t i = 0; i < 1000; i++) {
            double u[5];
            pm_emission e;
            sobol5(i, u);
            assert_true(pm_light_emit(world, u, &e));
            assert_near(pm_vec3_length(e.direction), 1, 1e-12);
            if (pm_rgb_is_black(e.flux))
                continue;
            pm_ray back = {pm_vec3_madd(e.origin, 1e-7, e.direction),
                           pm_vec3_negate(e.direction), 1e-6, PM_NO_PRIMITIVE};
            pm_hit hit;
            assert_true(pm_world_intersect(world, &back, &hit));
            assert_true(pm_vec3_dot(hit.normal, e.direction) > 0);
            assert_int_equal(hit.surface, e.from);
            assert_int_equal(e.weak, s == 2 || s == 7);
        }
        pm_world_free(world);
    }
}

static void beams_stay_within_their_cone(void **state)
{
    (void)state;
    pm_world *world = world_of(scenes[10]);
    for (uint32_t i = 0; i < 10000; i++) {
        double u[5];
        pm_emission e;
        sobol5(i, u);
        assert_true(pm_light_emit(world, u, &e));
        assert_true((e.direction.x + e.direction.z) * sqrt(.5) > cos(50.0001 * PM_PI / 180));
        assert_true(pm_emission_share(&e, INFINITY) == 1);
        assert_near(pm_emission_share(&e, e.focus), .25, 1e-15);
    }
    pm_world_free(world);
}

/* The marginal over directions of a diffuse lamp is cos / pi; of a beam about the normal too,
 * within its cone. */
static double cosine_density(void *context, pm_vec3 w)
{
    double least = *(double *)context;
    return w.z > least ? w.z / (PM_PI * (1 - least * least)) : 0;
}

static void directions_are_cosine_weighted(void **state)
{
    (void)state;
    const int which[] = {0, 8};
    const double least[] = {0, cos(20 * PM_PI / 180)};
    for (int k = 0; k < 2; k++) {
        pm_world *world = world_of(scenes[which[k]]);
        struct histogram h = {.samples = 100000};
        pm_rng rng;
        pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
        double bound = least[k], beam = 0;
        for (int i = 0; i < h.samples; i++) {
            double u[5];
            pm_emission e;
            draw(&rng, u, 5);
            assert_true(pm_light_emit(world, u, &e));
            histogram_add(&h, e.direction);
            beam += (e.direction.z - bound) / h.samples;
        }
        if (k == 0) {
            histogram_expect(&h, cosine_density, &bound);
            histogram_check(&h);
        } else { /* the cone is narrow for bins: mean of cos is 2/3 (1 - c^3) / (1 - c^2) */
            double mean = 2. / 3 * (1 - pow(bound, 3)) / (1 - bound * bound);
            assert_near(beam, mean - bound, 5 * (1 - bound) / sqrt(h.samples));
        }
        pm_world_free(world);
    }
}

/* Photons of a distant source fill the bounding disc evenly and miss no part of the scene: of a
 * flat floor under a sun at 45 degrees they hit area cos / (pi R^2). */
static void distant_photons_cover_the_scene(void **state)
{
    (void)state;
    pm_world *world = world_of(scenes[14]);
    double area = 81, radius = sqrt(2) * 4.5, hits = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[5];
        pm_emission e;
        pm_hit hit;
        sobol5(i, u);
        assert_true(pm_light_emit(world, u, &e));
        pm_ray ray = {e.origin, e.direction, INFINITY, e.from};
        hits += pm_world_intersect(world, &ray, &hit);
    }
    double share = area / (PM_PI * radius * radius);
    assert_near(hits / SAMPLES, share, 5 * sqrt(share * (1 - share) / SAMPLES));
    pm_world_free(world);
}

/* ---- how many photons which light sends ---- */

/* Lamps of every shape and kind, each with its power over pi times its radiance of 10: the area
 * of its front, of the spotlights the square of their cone's sine as well. */
static const struct {
    const char *text;
    double power;
} lamps[] = {
    {"lit polygon a 0 0 12 0 0 0 2 0 0 2 1 0 0 1 0\n", 2},
    {"lit ring b 0 0 8 9 0 0 0 0 1 .5 1\n", .75 * PM_PI},
    {"lit sphere c 0 0 4 0 9 0 .5\n", PM_PI},
    {"lit bubble d 0 0 4 9 9 0 .4\n", .64 * PM_PI},
    {"lit cylinder e 0 0 7 0 0 9 0 0 11 .25\n", PM_PI},
    {"lit tube f 0 0 7 9 0 9 9 0 10 .3\n", .6 * PM_PI},
    {"lit cone g 0 0 8 0 9 9 0 9 9.4 .8 .5\n", 1.3 * PM_PI * .5},
    {"lit cup h 0 0 8 9 9 9 9 9 9.4 .5 .2\n", .7 * PM_PI * .5},
    {"hung polygon i 0 0 12 5 0 0 6 0 0 6 1 0 5 1 0\n", 1},
    {"shone polygon j 0 0 12 0 5 0 1 5 0 1 6 0 0 6 0\n", 1},
    {"beam polygon k 0 0 12 5 5 0 7 5 0 7 6 0 5 6 0\n", 2 * .25},
};
enum { LAMPS = sizeof lamps / sizeof *lamps };

static const char lamp_kinds[] = "void light lit 0 0 3 10 10 10\n"
                                 "void glow hung 0 0 4 10 10 10 0\n"
                                 "void illum shone 0 0 3 10 10 10\n"
                                 "void spotlight beam 0 0 7 10 10 10 60 0 0 1\n";

/* Which of the lamps: their names are letters in order. */
static int lamp_of(const pm_world *world, const pm_scene *scene, uint32_t surface)
{
    return scene->primitives[pm_world_surface_names(world, surface).primitive].name[0] - 'a';
}

/* Counts within 5 sigma of independent picks; Sobol points do better. */
static void lights_send_photons_in_proportion_to_their_power(void **state)
{
    (void)state;
    char text[4096];
    size_t used = (size_t)snprintf(text, sizeof text, "%s", lamp_kinds);
    double total = 0;
    for (int i = 0; i < LAMPS; i++) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%s", lamps[i].text);
        total += lamps[i].power;
    }
    pm_scene *scene = scene_of(text);
    pm_world *world = NULL;
    assert_int_equal(pm_world_compile(scene, &world, NULL), PM_OK);
    double counts[LAMPS] = {0}, flux[LAMPS] = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[5];
        pm_emission e;
        sobol5(i, u);
        assert_true(pm_light_emit(world, u, &e));
        int lamp = lamp_of(world, scene, e.from);
        assert_in_range(lamp, 0, LAMPS - 1);
        counts[lamp]++;
        flux[lamp] += e.flux.g / SAMPLES;
    }
    pm_world_info info;
    pm_world_info_get(world, &info);
    for (int i = 0; i < LAMPS; i++) {
        double share = lamps[i].power / total, sigma = sqrt(SAMPLES * share * (1 - share));
        double watts = 10 * PM_PI * lamps[i].power / (info.scale * info.scale);
        assert_near(counts[i], SAMPLES * share, 5 * sigma);
        assert_near(flux[i], watts, 5 * watts * sigma / (SAMPLES * share));
    }
    pm_world_free(world);
    pm_scene_free(scene);
}

/* A sun and a sky beside a lamp: what distant sources send is their radiance times solid angle
 * times the disc that the scene shows them, whatever that is; so counts go by the flux. */
static void distant_lights_send_photons_in_proportion_to_their_flux(void **state)
{
    (void)state;
    pm_world *world = world_of("void light sun 0 0 3 1e4 1e4 1e4 void glow sky 0 0 4 1 1 1 0\n"
                               "sun source a 0 0 4 0 .6 .8 .5 sky source b 0 0 4 0 0 1 180\n"
                               "void light lit 0 0 3 9 9 9 lit sphere s 0 0 4 0 0 0 1\n" FLOOR);
    double counts[3] = {0}, flux[3] = {0}, total = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[5];
        pm_emission e;
        sobol5(i, u);
        assert_true(pm_light_emit(world, u, &e));
        bool sun = -(.6 * e.direction.y + .8 * e.direction.z) > .99995;
        int light = e.from != PM_NO_PRIMITIVE ? 0 : sun ? 1 : 2;
        counts[light]++;
        flux[light] += e.flux.g;
        total += e.flux.g;
    }
    for (int i = 0; i < 3; i++) {
        double share = flux[i] / total;
        assert_near(counts[i] / SAMPLES, share, 5 * sqrt(share * (1 - share) / SAMPLES));
        assert_true(counts[i] > 100);
    }
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(emission_sums_to_power),
        cmocka_unit_test(photons_of_plain_lamps_are_equal),
        cmocka_unit_test(photons_leave_from_the_front_of_their_lamp),
        cmocka_unit_test(beams_stay_within_their_cone),
        cmocka_unit_test(directions_are_cosine_weighted),
        cmocka_unit_test(distant_photons_cover_the_scene),
        cmocka_unit_test(lights_send_photons_in_proportion_to_their_power),
        cmocka_unit_test(distant_lights_send_photons_in_proportion_to_their_flux),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
