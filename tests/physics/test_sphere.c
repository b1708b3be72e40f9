/* Integrating spheres: the wall's own light falls evenly on all of it (test_furnace.c), and so
 * does that of a lamp in the middle. */
#include "physics.h"

enum { DIRECTIONS = 32 };

static const double albedos[] = {.5, .9, .99};

/* Long paths are dear. Of 8 seeds 5 standard errors are exceeded with probability 1.6e-3. */
static const unsigned seeds[] = {SEEDS, SEEDS, SEEDS / 2};

/* A black spherical lamp of radius a and radiance 1: Phi = 4 pi^2 a^2, and its light on the
 * wall is Phi / A, A = 4 pi, everywhere. By reciprocity a share a^2 of the wall's light falls
 * on the lamp (its area over A) and is absorbed. So with s = rho (1 - a^2)
 *
 *   E = Phi / (A (1 - s)),  of which indirect Phi s / (A (1 - s)):
 *
 * Phi rho / (A (1 - rho)) for a small lamp. */
#define LAMP_RADIUS .2

static char *integrating_sphere(double albedo, double lamp)
{
    return text_of("void light bright 0 0 3 1 1 1\n"
                   "bright sphere lamp 0 0 4 0 0 0 %.17g\n"
                   "void plastic grey 0 0 5 %.17g %.17g %.17g 0 0\n"
                   "grey bubble wall 0 0 4 0 0 0 1\n",
                   lamp, albedo, albedo, albedo);
}

static double sphere_irradiance(double albedo, double lamp)
{
    return PI * lamp * lamp / (1 - albedo * (1 - lamp * lamp));
}

static void on_the_wall(pm_sensor *sensors, int count)
{
    for (int i = 0; i < count; i++) {
        sensors[i].point = sphere_point(i, count);
        sensors[i].normal = pm_vec3_negate(sensors[i].point);
    }
}

static pm_job gather_job(const pm_sensor *sensors)
{
    pm_job job = job_of(PM_JOB_TRACE, 1);
    want_map(&job, PM_MAP_GLOBAL, 60000, 60);
    look_at(&job, sensors, DIRECTIONS, PM_IRRADIANCE);
    job.passes = 4;
    return job;
}

/* The direct part has no noise to speak of: a sphere's cone, seen whole. */
static void integrating_sphere_indirect_irradiance(void **state)
{
    (void)state;
    const double direct = sphere_irradiance(0, LAMP_RADIUS);
    pm_sensor sensors[DIRECTIONS];
    on_the_wall(sensors, DIRECTIONS);
    for (int i = 0; i < 3; i++) {
        char *text = integrating_sphere(albedos[i], LAMP_RADIUS);
        double want = sphere_irradiance(albedos[i], LAMP_RADIUS) - direct;
        pm_job progressive = job_of(PM_JOB_TRACE, -1);
        look_at(&progressive, sensors, DIRECTIONS, PM_IRRADIANCE);
        pm_job gather = gather_job(sensors);
        struct stat got = run_mean(&progressive, text, seeds[i], GREY);
        got.mean -= direct;
        expect_mean("progressive", &got, want, 0);
        if (albedos[i] < .99) { /* .99 would take long and prove no more */
            got = run_mean(&gather, text, SEEDS, GREY);
            got.mean -= direct;
            expect_mean("-ab 1", &got, want, 0);
        }
        free(text);
    }
}

static void integrating_sphere_direct_irradiance(void **state)
{
    (void)state;
    pm_sensor sensors[DIRECTIONS];
    on_the_wall(sensors, DIRECTIONS);
    char *text = integrating_sphere(.9, LAMP_RADIUS);
    pm_job job = job_of(PM_JOB_TRACE, 0);
    look_at(&job, sensors, DIRECTIONS, PM_IRRADIANCE);
    struct stat got = run_mean(&job, text, SEEDS, GREY);
    expect_mean("direct", &got, sphere_irradiance(0, LAMP_RADIUS), 0);
    free(text);
}

/* A path lives for 1 / (1 - .999 (1 - a^2)) = 91 bounces with a = .1. How many it makes is
 * geometric, with a deviation like its mean, so the wall's flux has a relative error of 2^-8
 * from 2^16 paths; what the sensors scatter about it shows in them. Beyond the default bound of
 * 5000 scatterings lies exp(-5000 / 91) = 1e-24 of the light. */
static void integrating_sphere_of_albedo_999(void **state)
{
    (void)state;
    enum { POINTS = 512 };
    const double lamp = .1;
    pm_sensor sensors[POINTS];
    on_the_wall(sensors, POINTS);
    char *text = integrating_sphere(.999, lamp);
    pm_job job = job_of(PM_JOB_TRACE, -1);
    look_at(&job, sensors, POINTS, PM_IRRADIANCE);
    pm_answer answer;
    run_job(&job, text, NULL, &answer);
    struct stat got = {0};
    for (int i = 0; i < POINTS; i++)
        stat_add(&got, (double)answer.values[3 * i]);
    double want = sphere_irradiance(.999, lamp);
    expect_equal_means(".999", &got, want, want / 256, 0);
    pm_answer_clear(&answer);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integrating_sphere_indirect_irradiance),
        cmocka_unit_test(integrating_sphere_direct_irradiance),
        cmocka_unit_test(integrating_sphere_of_albedo_999),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
