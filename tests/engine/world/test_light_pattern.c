#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../world_text.h"
#include "base/sobol.h"
#include "numbers.h"
#include "world/light.h"

enum { SAMPLES = 1 << 15 };

#define FLOOR "void plastic p 0 0 5 .5 .5 .5 0 0\np polygon f 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n"
#define SKY(expression, angle)                                                                 \
    FLOOR "void brightfunc b 2 \"" expression "\" . 0 0\n"                                     \
          "b glow g 0 0 4 1 1 1 0\ng source s 0 0 4 0 0 1 " angle "\n"

/* ---- skies ---- */

static double overcast(pm_vec3 w)
{
    return (1 + 2 * fabs(w.z)) / 3;
}

static double bright_about(pm_vec3 w)
{
    return exp(50 * (.6 * w.x + .8 * w.z - 1));
}

static double disc(pm_vec3 w)
{
    return .6 * w.x + .8 * w.z > 1 - 1e-3 ? 1e9 : 1;
}

static double speck(pm_vec3 w)
{
    return w.z > .9999;
}

static double half(pm_vec3 w)
{
    return fmax(w.x, 0);
}

static double even(pm_vec3 w)
{
    (void)w;
    return 1;
}

/* `irradiance`: of the floor, by hand; of a disc wholly above the horizon
 * pi L (2 versine - versine^2) cos. */
static const struct {
    const char *text;
    double (*radiance)(pm_vec3 w);
    double versine, irradiance, integral; /* < 0: by quadrature */
} skies[] = {
    {SKY("(1+2*Dz)/3", "180"), overcast, 1, 7 * PM_PI / 9, -1},
    {SKY("(1+2*if(Dz,Dz,-Dz))/3", "360"), overcast, 2, 7 * PM_PI / 9, -1},
    {SKY("exp(50*(.6*Dx+.8*Dz-1))", "180"), bright_about, 1, -1, -1},
    {SKY("if(.6*Dx+.8*Dz-.999,1e9,1)", "180"), disc, 1,
     PM_PI + .8 * (1e9 - 1) * PM_PI *(2e-3 - 1e-6), 2 * PM_PI *(1 + (1e9 - 1) * 1e-3)},
    {SKY("if(Dz-.9999,1,0)", "180"), speck, 1, PM_PI *(2e-4 - 1e-8), 2 * PM_PI * 1e-4},
    {SKY("Dx", "180"), half, 1, 2. / 3, -1},
    {SKY("1/(Dx-Dx)", "180"), even, 1, PM_PI, -1},     /* a fault: no pattern */
    {SKY("Px+Py+Pz+Rdot", "180"), even, 1, PM_PI, -1}, /* no place; it faces the ray */
};
enum { SKIES = sizeof skies / sizeof *skies };

/* The midpoint rule in z and azimuth: error below 1e-3 for what is smooth. */
static double integral(double (*radiance)(pm_vec3 w), double lowest, bool projected)
{
    enum { STEPS = 1000 };
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        double z = lowest + (1 - lowest) * (i / STEPS + .5) / STEPS;
        sum += radiance(polar(z, 2 * PM_PI * (i % STEPS + .5) / STEPS)) *
               (projected ? fmax(z, 0) : 1);
    }
    return sum * 2 * PM_PI * (1 - lowest) / ((double)STEPS * STEPS);
}

static void next_event_under_skies_equals_their_integral(void **state)
{
    (void)state;
    for (int k = 0; k < SKIES; k++) {
        pm_world *world = world_of(skies[k].text);
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            pm_light_sample s;
            double u[3] = {pm_sobol(i, 0, 1), pm_sobol(i, 1, 2), pm_sobol(i, 2, 3)}, pdf;
            if (!pm_light_sample_at(world, (pm_vec3){0, 0, 0}, u, &s))
                continue;
            double wanted = skies[k].radiance(s.wi);
            assert_near(s.radiance.r, wanted, 1e-9 * wanted);
            assert_near(pm_light_distant(world, s.wi, &pdf).r, wanted, 1e-9 * wanted);
            assert_near(pdf, s.pdf, 1e-12 * pdf);
            double value = s.radiance.r * fmax(s.wi.z, 0) / s.pdf;
            sum += value / SAMPLES;
            squares += value * value / SAMPLES;
        }
        double sigma = sqrt(fmax(squares - sum * sum, 0) / SAMPLES);
        double wanted = skies[k].irradiance;
        if (wanted < 0)
            wanted = integral(skies[k].radiance, 0, true);
        if (!(fabs(sum - wanted) <= 4 * sigma + 1e-5 * wanted))
            fail_msg("sky %d: %.9g is not %.9g within 4 * %g", k, sum, wanted, sigma);
        assert_at_most(sigma * sqrt(SAMPLES), 3 * wanted); /* evenly: 90 for the specks */
        pm_world_free(world);
    }
}

static double sky_density(void *context, pm_vec3 w)
{
    double pdf;
    pm_light_distant(context, w, &pdf);
    return pdf;
}

/* Frequencies of sampled directions are the densities that bounces ask for; these never vanish
 * where a sky may shine. */
static void directions_of_skies_have_their_density(void **state)
{
    (void)state;
    for (int k = 0; k < SKIES; k++) {
        if (skies[k].radiance == disc || skies[k].radiance == speck)
            continue; /* the sums over bins would miss them; test_light_table.c has such */
        pm_world *world = world_of(skies[k].text);
        struct histogram h = {.samples = 100000};
        pm_rng rng;
        pm_rng_init(&rng, 9, PM_RNG_PATH, (uint64_t)k);
        for (int i = 0; i < h.samples; i++) {
            double u[3];
            pm_light_sample s = {.wi = {0, 0, 0}};
            draw(&rng, u, 3);
            pm_light_sample_at(world, (pm_vec3){0, 0, 0}, u, &s);
            histogram_add(&h, s.wi);
        }
        histogram_expect(&h, sky_density, world);
        histogram_check(&h);
        for (int i = 0; i < 10000; i++) {
            double z = 1 - skies[k].versine * (i % 100 + .5) / 100;
            assert_true(sky_density(world, polar(z, i)) > .05 / (2 * PM_PI * skies[k].versine));
        }
        pm_world_free(world);
    }
}

/* Photons: their mean flux is the integral over all directions, the table's power nearly so. */
static void photons_from_skies_carry_their_integral(void **state)
{
    (void)state;
    for (int k = 0; k < SKIES; k++) {
        pm_world *world = world_of(skies[k].text);
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            double u[5];
            pm_emission e;
            for (unsigned d = 0; d < 5; d++)
                u[d] = pm_sobol(i, d, 77 + d);
            assert_true(pm_light_emit(world, u, &e));
            sum += e.flux.r / SAMPLES;
            squares += e.flux.r * e.flux.r / SAMPLES;
        }
        double sigma = sqrt(fmax(squares - sum * sum, 0) / SAMPLES);
        pm_world_info info;
        pm_world_info_get(world, &info);
        double area = PM_PI * .5 / pow(info.scale, 2); /* a square's circle; in the world */
        double wanted = skies[k].integral;
        if (wanted < 0)
            wanted = integral(skies[k].radiance, 1 - skies[k].versine, false);
        wanted *= area;
        assert_near(sum, wanted, 4 * sigma + 3e-3 * wanted); /* .. is the quadrature's own */
        assert_near(pm_light_total_power(world).r, sum, 4 * sigma + .02 * sum);
        pm_world_free(world);
    }
}

static void glow_behind_a_patterned_sun_is_hidden(void **state)
{
    (void)state;
    pm_world *world =
        world_of(SKY("1+Dx", "180") "void brightfunc c 2 \"if(Dx,5,3)\" . 0 0\n"
                                    "c light l 0 0 3 2 2 2\nl source sun 0 0 4 0 0 1 20\n");
    double pdf;
    assert_near(pm_light_distant(world, polar(.99, .1), &pdf).r, 10, 1e-12);
    assert_near(pm_light_distant(world, polar(.99, 3), &pdf).r, 6, 1e-12);
    assert_near(pm_light_distant(world, polar(.8, 0), &pdf).r, 1.6, 1e-12);
    assert_near(pm_light_seen_distant(world, polar(.8, PM_PI)).r, .4, 1e-12);
    assert_near(pm_light_seen_distant(world, polar(-.8, PM_PI)).r, 0, 0);
    pm_world_free(world);
}

/* ---- lamps ---- */

#define LAMP(expression, rest) "void brightfunc b 2 \"" expression "\" . 0 0\nb " rest "\n"

/* Patterns see the ray that looks at the lamp: along w of its light, D = -w. `power`: integrals
 * by hand; `along`: the flux times w.z. */
static const struct {
    const char *text;
    double power, along;
} lamps[] = {
    /* A disc of area pi that looks down, L = cos^100. */
    {LAMP("Dz^100", "light m 0 0 3 1 1 1\nm ring a 0 0 8 0 0 3 0 0 -1 0 1"),
     PM_PI * 2 * PM_PI / 102, -PM_PI * 2 * PM_PI / 103},
    /* An L-shaped pane, a third of which is ten times as bright. */
    {LAMP("if(Px-1,10,1)",
          "glow m 0 0 4 1 1 1 0\nm polygon a 0 0 18 0 0 0 2 0 0 2 1 0 1 1 0 1 2 0 0 2 0"),
     12 * PM_PI, 12 * PM_PI * 2 / 3},
    /* A sphere: pi r^2 times the integral of 1 - w.z. */
    {LAMP("1+Dz", "light m 0 0 3 1 1 1\nm sphere a 0 0 4 1 2 3 2"), 16 * PM_PI *PM_PI,
     -16 * PM_PI *PM_PI / 3},
    {LAMP("1+Dz", "light m 0 0 3 1 1 1\nm bubble a 0 0 4 1 2 3 2"), 16 * PM_PI *PM_PI,
     -16 * PM_PI *PM_PI / 3},
    /* A sphere whose upper half alone shines. */
    {LAMP("if(Pz-3,1,0)", "light m 0 0 3 1 1 1\nm sphere a 0 0 4 1 2 3 2"), 8 * PM_PI *PM_PI,
     -1},
    /* A cylinder about z: 2 pi r h times the integral of w.z^2 w.x over w.x > 0, pi / 4. */
    {LAMP("Dz*Dz", "light m 0 0 3 1 1 1\nm cylinder a 0 0 7 0 0 0 0 0 3 .5"),
     3 * PM_PI *PM_PI / 4, 0},
    /* A spotlight whose beam is half dark. */
    {LAMP("if(Dx,1,0)", "spotlight m 0 0 7 1 1 1 40 0 0 1\nm ring a 0 0 8 0 0 0 0 0 1 0 2"), -2,
     -2},
    {LAMP("if(Dx,1,0)", "spotlight m 0 0 7 1 1 1 200 0 1 0\nm sphere a 0 0 4 0 0 0 2"), -3, 0},
    /* Dark, but for a beam that no table sees; and wholly dark. */
    {LAMP("if(Dx-.99999,1,0)", "light m 0 0 3 1 1 1\nm ring a 0 0 8 0 0 0 1 2 3 1 2"), -1, -1},
    {LAMP("0", "light m 0 0 3 1 1 1\nm ring a 0 0 8 0 0 0 1 2 3 1 2"), 0, 0},
    {LAMP("-1", "light m 0 0 3 1 1 1\nm ring a 0 0 8 0 0 0 1 2 3 1 2"), 0, 0},
};
enum { LAMPS = sizeof lamps / sizeof *lamps };

static double wanted_power(int k)
{
    double sine = sin(20 * PM_PI / 180), versine = 1 - cos(100 * PM_PI / 180);
    if (lamps[k].power == -2) /* area 4 pi, half of pi sin^2 */
        return 2 * PM_PI * PM_PI * sine * sine;
    if (lamps[k].power == -3) /* half of pi r^2 times the cone */
        return 4 * PM_PI * PM_PI * versine;
    return lamps[k].power;
}

static void photons_from_patterned_lamps_carry_their_integral(void **state)
{
    (void)state;
    for (int k = 0; k < LAMPS; k++) {
        pm_world *world = world_of(lamps[k].text);
        pm_world_info info;
        pm_world_info_get(world, &info);
        double unit = info.scale * info.scale, sum = 0, squares = 0, along = 0, spread = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            double u[5];
            pm_emission e;
            for (unsigned d = 0; d < 5; d++)
                u[d] = pm_sobol(i, d, 77 + d);
            assert_true(pm_light_emit(world, u, &e));
            double flux = e.flux.r * unit;
            assert_true(flux >= 0 && isfinite(flux));
            sum += flux / SAMPLES;
            squares += flux * flux / SAMPLES;
            along += flux * e.direction.z / SAMPLES;
            spread += pow(flux * e.direction.z, 2) / SAMPLES;
        }
        double sigma = sqrt(fmax(squares - sum * sum, 0) / SAMPLES), wanted = wanted_power(k);
        if (wanted >= 0 && !(fabs(sum - wanted) <= 4 * sigma + 1e-6 * wanted))
            fail_msg("lamp %d: %.9g is not %.9g within 4 * %g", k, sum, wanted, sigma);
        assert_near(info.power.r, sum, 4 * sigma + .02 * sum);
        double error = sqrt(fmax(spread - along * along, 0) / SAMPLES);
        if (wanted >= 0 && lamps[k].along > -1)
            assert_near(along, lamps[k].along, 4 * error + 1e-6 * wanted);
        pm_world_free(world);
    }
}

/* Next event towards the beam of a ring of radius 1 at height 3, on its axis:
 * 2 pi (1 - c^102) / 102, c = 3 / sqrt(10). And radiance of hits is the same. */
static void next_event_sees_the_pattern_of_a_lamp(void **state)
{
    (void)state;
    pm_world *world = world_of(lamps[0].text);
    pm_vec3 point = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        pm_light_sample s;
        pm_hit hit;
        double u[3] = {pm_sobol(i, 0, 1), pm_sobol(i, 1, 2), pm_sobol(i, 2, 3)};
        assert_true(pm_light_sample_at(world, point, u, &s));
        assert_near(s.radiance.r, pow(s.wi.z, 100), 1e-9);
        pm_ray ray = {point, s.wi, INFINITY, PM_NO_PRIMITIVE};
        assert_true(pm_world_intersect(world, &ray, &hit));
        pm_vec3 wo = pm_vec3_negate(s.wi);
        assert_near(pm_light_radiance(world, &hit, wo).r, s.radiance.r, 1e-9);
        assert_near(pm_light_seen_radiance(world, &hit, wo).r, s.radiance.r, 1e-9);
        double value = s.radiance.r * s.wi.z / s.pdf;
        sum += value / SAMPLES;
        squares += value * value / SAMPLES;
    }
    double sigma = sqrt(fmax(squares - sum * sum, 0) / SAMPLES);
    assert_near(sum, 2 * PM_PI * (1 - pow(.9, 51)) / 102, 4 * sigma);
    pm_world_free(world);
}

/* Beams and panes pay for their tables: nearly equal photons. Evenly drawn, relative variances
 * would be near 25 and 1. */
static void photons_of_beams_and_panes_are_nearly_equal(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        pm_world *world = world_of(lamps[k].text);
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            double u[5];
            pm_emission e;
            for (unsigned d = 0; d < 5; d++)
                u[d] = pm_sobol(i, d, 77 + d);
            assert_true(pm_light_emit(world, u, &e));
            sum += e.flux.r / SAMPLES;
            squares += e.flux.r * e.flux.r / SAMPLES;
        }
        assert_at_most(squares / (sum * sum) - 1, .2);
        pm_world_free(world);
    }
}

/* Many patterned lamps share the work: no tables, and still the right flux. */
static void a_hundred_thousand_patterned_lamps_are_bounded_work(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    char *text = malloc(COUNT * 60 + 200), *at = text;
    assert_non_null(text);
    at += sprintf(at, "%s", LAMP("Dz^2", "light m 0 0 3 1 1 1"));
    for (int i = 0; i < COUNT; i++)
        at += sprintf(at, "m ring a 0 0 8 %d %d 0 0 0 -1 0 .25\n", i % 300, i / 300);
    pm_world *world = world_of(text);
    pm_world_info info;
    pm_world_info_get(world, &info);
    double wanted = COUNT * PM_PI / 16 * PM_PI / 2;
    assert_near(info.power.r, wanted, .1 * wanted);
    pm_world_free(world);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(next_event_under_skies_equals_their_integral),
        cmocka_unit_test(directions_of_skies_have_their_density),
        cmocka_unit_test(photons_from_skies_carry_their_integral),
        cmocka_unit_test(glow_behind_a_patterned_sun_is_hidden),
        cmocka_unit_test(photons_from_patterned_lamps_carry_their_integral),
        cmocka_unit_test(next_event_sees_the_pattern_of_a_lamp),
        cmocka_unit_test(photons_of_beams_and_panes_are_nearly_equal),
        cmocka_unit_test(a_hundred_thousand_patterned_lamps_are_bounded_work),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
