#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/warp.h"
#include "numbers.h"
#include "world/ward.h"

static const pm_vec3 up = {0, 0, 1};
static const double alphas[] = {.002, .02, .1, .3, .6, 1, 3};
static const double cosines[] = {1, .9, .5, .1, .01, 1e-4, 1e-9};
enum { ALPHAS = 7, COSINES = 7 };

struct setting {
    pm_vec3 wo;
    double alpha;
};

static double reflected(const void *context, pm_vec3 wi)
{
    const struct setting *s = context;
    return pm_ward_reflect(up, s->wo, wi, s->alpha);
}

static double transmitted(const void *context, pm_vec3 wi)
{
    const struct setting *s = context;
    return pm_ward_transmit(up, s->wo, wi, s->alpha);
}

static void energy_never_grows_in_ward_reflection(void **state)
{
    (void)state;
    for (int i = 0; i < ALPHAS * COSINES; i++) {
        struct setting s = {polar(cosines[i % COSINES], 1), alphas[i / COSINES]};
        assert_at_most(over_reflections(reflected, &s, up, s.wo, s.alpha), 1 + 1e-6);
    }
    struct setting s = {polar(.9, 1), .02}; /* far from grazing it is nearly all there */
    assert_near(over_reflections(reflected, &s, up, s.wo, s.alpha), 1, .01);
}

static void energy_never_grows_in_ward_transmission(void **state)
{
    (void)state;
    for (int i = 0; i < ALPHAS * COSINES; i++) {
        struct setting s = {polar(cosines[i % COSINES], 1), alphas[i / COSINES]};
        assert_at_most(over_transmissions(transmitted, &s, s.wo), 1 + 1e-6);
    }
    struct setting s = {polar(.9, 1), .02};
    assert_near(over_transmissions(transmitted, &s, s.wo), 1, .01);
}

static void ward_is_reciprocal(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (int i = 0; i < 10000; i++) {
        double u[5];
        draw(&rng, u, 5);
        double alpha = .3 + u[4];
        pm_vec3 a = pm_warp_cosine(u[0], u[1]), b = pm_warp_cosine(u[2], u[3]);
        double there = pm_ward_reflect(up, a, b, alpha) / b.z;
        assert_near(pm_ward_reflect(up, b, a, alpha) / a.z, there, 1e-12 * there);
        /* through: seen from the other side, normal and roles change */
        pm_vec3 c = pm_vec3_negate(b);
        there = pm_ward_transmit(up, a, c, alpha) / -c.z;
        double back = pm_ward_transmit(pm_vec3_negate(up), c, a, alpha) / a.z;
        assert_near(back, there, 1e-12 * there);
    }
}

static double reflect_density(void *context, pm_vec3 wi)
{
    const struct setting *s = context;
    return pm_ward_reflect_pdf(up, s->wo, wi, s->alpha);
}

static double transmit_density(void *context, pm_vec3 wi)
{
    const struct setting *s = context;
    return wi.z < 0 ? pm_ward_transmit_pdf(s->wo, wi, s->alpha) : 0;
}

typedef bool sampler(pm_vec3 n, pm_vec3 wo, double alpha, double u, double v, pm_vec3 *wi);

static void check_frequency(sampler *sample, double (*density)(void *, pm_vec3), double side)
{
    const double widths[] = {.15, .4, 1};
    const double tilts[] = {.8, .5, .1}; /* off the pole of the bins */
    for (int i = 0; i < 9; i++) {
        struct setting s = {polar(tilts[i / 3], .4), widths[i % 3]};
        struct histogram h = {.samples = 100000};
        pm_rng rng;
        pm_rng_init(&rng, 7, PM_RNG_PATH, (uint64_t)i);
        for (int k = 0; k < h.samples; k++) {
            double u[2];
            pm_vec3 wi;
            draw(&rng, u, 2);
            if (!sample(up, s.wo, s.alpha, u[0], u[1], &wi))
                continue;
            assert_true(side * wi.z > 0);
            assert_near(pm_vec3_length(wi), 1, 1e-14);
            histogram_add(&h, wi);
        }
        histogram_expect(&h, density, &s);
        histogram_check(&h);
    }
}

static void reflected_frequency_equals_its_density(void **state)
{
    (void)state;
    check_frequency(pm_ward_reflect_sample, reflect_density, 1);
}

static void transmitted_frequency_equals_its_density(void **state)
{
    (void)state;
    check_frequency(pm_ward_transmit_sample, transmit_density, -1);
}

static void lobe_over_density_is_at_most_two(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
    for (int i = 0; i < 100000; i++) {
        double u[3];
        draw(&rng, u, 3);
        double alpha = alphas[i % ALPHAS];
        pm_vec3 wo = polar(cosines[i / ALPHAS % COSINES], u[2]), wi;
        if (pm_ward_reflect_sample(up, wo, alpha, u[0], u[1], &wi))
            assert_at_most(pm_ward_reflect(up, wo, wi, alpha),
                           (2 + 1e-9) * pm_ward_reflect_pdf(up, wo, wi, alpha));
        if (pm_ward_transmit_sample(up, wo, alpha, u[0], u[1], &wi))
            assert_at_most(pm_ward_transmit(up, wo, wi, alpha),
                           (2 + 1e-9) * pm_ward_transmit_pdf(wo, wi, alpha));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_never_grows_in_ward_reflection),
        cmocka_unit_test(energy_never_grows_in_ward_transmission),
        cmocka_unit_test(ward_is_reciprocal),
        cmocka_unit_test(reflected_frequency_equals_its_density),
        cmocka_unit_test(transmitted_frequency_equals_its_density),
        cmocka_unit_test(lobe_over_density_is_at_most_two),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
