/* The caustic of a glass ball and of a mirror ball against the reference tracer, which knows no
 * photons and no densities, in the same scene text. */
#include "physics.h"

#define FLOOR "void plastic grey 0 0 5 .5 .4 .3 0 0  grey ring floor 0 0 8 0 0 0 0 0 1 0 3\n"
#define LAMP  "void light bright 0 0 3 9 8 7  bright ring lamp 0 0 8 .2 0 1.9 0 0 -1 0 .25\n"

static const char glass_ball[] =
    FLOOR LAMP "void dielectric clear 0 0 5 .8 .9 1 1.5 0  clear sphere ball 0 0 4 0 0 .6 .4\n";

static const char mirror_ball[] =
    FLOOR LAMP "void metal silver 0 0 5 .9 .8 .7 1 0  silver sphere ball 0 0 4 -.9 0 .6 .4\n";

/* Where, and how wide: a caustic's middle, its edge and beyond. */
static const struct {
    const char *name, *text;
    pm_vec3 center;
    double radius;
} discs[] = {
    {"focus of the glass ball", glass_ball, {-.08, 0, 0}, .1},
    {"around the focus", glass_ball, {-.08, 0, 0}, .35},
    {"beside the caustic", glass_ball, {.9, .3, 0}, .3},
    {"beside the mirror ball", mirror_ball, {-.2, 0, 0}, .3},
    {"behind the mirror ball", mirror_ball, {-1.3, 0, 0}, .3},
};

enum { DISCS = sizeof discs / sizeof *discs, PHOTONS = 5000 };

static struct ref_result reference(int i, double radius, uint64_t samples)
{
    pm_sensor sensor = {discs[i].center, {0, 0, 1}};
    return reference_irradiance(discs[i].text, &sensor, radius, samples);
}

/* Flux in all discs of that scene, from one map a seed. */
static void measure_discs(const char *text, struct stat got[DISCS][3])
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 40);
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        job.forward.seed = seed;
        run_job(&job, text, NULL, &answer);
        for (int i = 0; i < DISCS; i++) {
            pm_rgb flux =
                flux_within(answer.map[PM_MAP_CAUSTIC], discs[i].center, discs[i].radius);
            stat_add(&got[i][0], flux.r);
            stat_add(&got[i][1], flux.g);
            stat_add(&got[i][2], flux.b);
        }
        pm_answer_clear(&answer);
    }
}

/* Photons that are counted, not looked up: no bias but the 1 / N of a map that ends with photon
 * N (Haldane 1945). */
static void expect_flux_of_the_reference(const char *text)
{
    struct stat got[DISCS][3] = {0};
    measure_discs(text, got);
    for (int i = 0; i < DISCS; i++) {
        if (discs[i].text != text)
            continue;
        struct ref_result want = reference(i, discs[i].radius, 1 << 19);
        double area = PI * discs[i].radius * discs[i].radius;
        for (int c = 0; c < 3; c++)
            expect_equal_means(discs[i].name, &got[i][c], area * want.mean[REF_CAUSTIC][c],
                               area * want.standard_error[REF_CAUSTIC][c],
                               area * want.mean[REF_CAUSTIC][c] / PHOTONS);
    }
}

static void caustic_flux_of_a_glass_ball_equals_the_reference(void **state)
{
    (void)state;
    expect_flux_of_the_reference(glass_ball);
}

static void caustic_flux_of_a_mirror_ball_equals_the_reference(void **state)
{
    (void)state;
    expect_flux_of_the_reference(mirror_ball);
}

/* A look-up is the mean over a disc about the sensor, so at the peak of a caustic, where the
 * irradiance falls off to all sides, it lies between the irradiance there and the mean over the
 * widest disc. */
static void look_ups_at_the_peak_lie_between_its_means_over_discs(void **state)
{
    (void)state;
    const double widest = .1;
    pm_sensor sensor = {discs[0].center, {0, 0, 1}};
    struct ref_result point = reference(0, 0, 1 << 19), wide = reference(0, widest, 1 << 19);
    assert_true(point.mean[REF_CAUSTIC][1] > wide.mean[REF_CAUSTIC][1]);
    for (int i = 0; i < MODES; i++) {
        if (modes[i].ambient_bounces != 0)
            continue;
        pm_job job = job_of_mode(&modes[i], PHOTONS, 50);
        look_at(&job, &sensor, 1, PM_IRRADIANCE);
        struct stat got[3] = {0};
        run_seeds(&job, discs[0].text, SEEDS, got);
        for (int c = 0; c < 3; c++) {
            double direct = point.mean[REF_DIRECT][c];
            double middle = (point.mean[REF_CAUSTIC][c] + wide.mean[REF_CAUSTIC][c]) / 2;
            double half = (point.mean[REF_CAUSTIC][c] - wide.mean[REF_CAUSTIC][c]) / 2;
            expect_equal_means(modes[i].name, &got[c], direct + middle,
                               point.standard_error[REF_CAUSTIC][c], half + middle / PHOTONS);
        }
    }
}

/* Behind the mirror ball its shadow, with faint light from the lamp's reflection in it. A pass
 * takes the mean over discs of up to .6 there, where photons are few. */
static void no_caustic_in_the_shadow_of_a_mirror_ball(void **state)
{
    (void)state;
    pm_sensor sensors[16];
    for (int i = 0; i < 16; i++)
        sensors[i] = (pm_sensor){{-1.25 + .02 * (i % 4), .02 * (i / 4), 0}, {0, 0, 1}};
    pm_job job = job_of(PM_JOB_TRACE, 0);
    look_at(&job, sensors, 16, PM_IRRADIANCE);
    struct ref_result want = reference(4, 0, 1 << 18), wide = reference(4, .6, 1 << 18);
    double bias = fabs(wide.mean[REF_CAUSTIC][1] - want.mean[REF_CAUSTIC][1]);
    struct stat got = run_mean(&job, mirror_ball, SEEDS, 1);
    expect_equal_means("shadow", &got, want.mean[REF_DIRECT][1] + want.mean[REF_CAUSTIC][1],
                       want.total_standard_error[1], bias);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(caustic_flux_of_a_glass_ball_equals_the_reference),
        cmocka_unit_test(caustic_flux_of_a_mirror_ball_equals_the_reference),
        cmocka_unit_test(look_ups_at_the_peak_lie_between_its_means_over_discs),
        cmocka_unit_test(no_caustic_in_the_shadow_of_a_mirror_ball),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
