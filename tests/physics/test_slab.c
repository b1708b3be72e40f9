/* Light through slabs and panes, and total reflection. */
#include "physics.h"

/* ---- Fresnel and Beer ---- */

/* Reflectances of the two polarisations going from index 1 to n at that cosine. */
static void fresnel(double n, double cosine, double *s, double *p)
{
    double inner = sqrt(1 - (1 - cosine * cosine) / (n * n));
    *s = pow((cosine - n * inner) / (cosine + n * inner), 2);
    *p = pow((inner - n * cosine) / (inner + n * cosine), 2);
}

static double mean_reflectance(double n, double cosine)
{
    double s, p;
    fresnel(n, cosine, &s, &p);
    return (s + p) / 2;
}

/* All orders of reflection between two faces of reflectance f with a between them. */
static double pane(double f, double a)
{
    return (1 - f) * (1 - f) * a / (1 - f * f * a * a);
}

/* dielectric: each interface unpolarised, tn the transmittance of a unit of length. */
static double slab_transmittance(double angle, double index, double tn, double thickness)
{
    double inner = sqrt(1 - pow(sin(angle) / index, 2));
    return pane(mean_reflectance(index, cos(angle)), pow(tn, thickness / inner));
}

/* glass: the polarisations apart, tn the transmittance of the pane's thickness at right angles.
 */
static double glass_transmittance(double angle, double index, double tn)
{
    double inner = sqrt(1 - pow(sin(angle) / index, 2)), s, p;
    fresnel(index, cos(angle), &s, &p);
    return (pane(s, pow(tn, 1 / inner)) + pane(p, pow(tn, 1 / inner))) / 2;
}

/* ---- scenes ---- */

/* A sun at that angle from the zenith; its irradiance at right angles is 1. */
static char *sun(double angle)
{
    double l = sun_radiance();
    return text_of("void light sun 0 0 3 %.17g %.17g %.17g\n"
                   "sun source s 0 0 4 %.17g 0 %.17g %.17g\n",
                   l, l, l, sin(angle), cos(angle), SUN_DEGREES);
}

/* Over the sun's disc f(angle) differs in the mean from its middle by at most the greatest
 * second difference, that at its rim. */
#define SUN_RADIUS   (SUN_DEGREES * PI / 360)
#define SUN_SLACK(f) fabs((f(angle - SUN_RADIUS) + f(angle + SUN_RADIUS)) / 2 - f(angle))

#define INDEX     1.5
#define THICKNESS .02

static const double tn[3] = {1e-9, .01, 1};
static const double angles[3] = {0, PI / 4, 80 * PI / 180};

/* A slab above a dark floor 2 x 2. At 80 degrees light enters up to .23 to the side, and each
 * reflection in the slab takes it .035 farther: the margin of .6 holds ten of them. Light that
 * enters by the slab's edges is reflected totally at its faces (index > sqrt 2), and leaves by
 * the edges. */
static char *slab_over_floor(double angle)
{
    char *light = sun(angle);
    char *text = text_of("%s"
                         "void dielectric clear 0 0 5 %g %g %g %.17g 0\n"
                         "clear polygon top 0 0 12 -1.6 -1.6 .04 1.6 -1.6 .04"
                         " 1.6 1.6 .04 -1.6 1.6 .04\n"
                         "clear polygon bottom 0 0 12 -1.6 -1.6 .02 -1.6 1.6 .02"
                         " 1.6 1.6 .02 1.6 -1.6 .02\n"
                         "clear polygon south 0 0 12 -1.6 -1.6 .02 1.6 -1.6 .02"
                         " 1.6 -1.6 .04 -1.6 -1.6 .04\n"
                         "clear polygon north 0 0 12 -1.6 1.6 .02 -1.6 1.6 .04"
                         " 1.6 1.6 .04 1.6 1.6 .02\n"
                         "clear polygon west 0 0 12 -1.6 -1.6 .02 -1.6 -1.6 .04"
                         " -1.6 1.6 .04 -1.6 1.6 .02\n"
                         "clear polygon east 0 0 12 1.6 -1.6 .02 1.6 1.6 .02"
                         " 1.6 1.6 .04 1.6 -1.6 .04\n"
                         "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
                         "dark polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n",
                         light, tn[0], tn[1], tn[2], INDEX);
    free(light);
    return text;
}

/* ---- claims ---- */

/* The floor reflects .001, of which less than all comes back. N / paths of a map that stops at
 * photon N is off by at most 1 / N (Haldane 1945). */
static void photons_through_a_slab_carry_its_transmittance(void **state)
{
    (void)state;
    enum { PHOTONS = 20000 };
    for (int i = 0; i < 3; i++) {
        double angle = angles[i];
        char *text = slab_over_floor(angle);
        pm_job job = job_of(PM_JOB_MAP, 0);
        want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 40);
        struct stat got[3];
        run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){0, 0, 0}, 2, got);
        for (int c = 0; c < 3; c++) {
#define T(a) (4 * cos(a) * slab_transmittance(a, INDEX, tn[c], THICKNESS))
            double slack = SUN_SLACK(T) + T(angle) * (.001 + 1. / PHOTONS);
            expect_mean("slab", &got[c], T(angle), slack);
#undef T
        }
        free(text);
    }
}

/* A ray at that angle through the slab sees the sky below it with the slab's transmittance. */
static void rays_through_a_slab_see_its_transmittance(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        char *slab = slab_over_floor(0);
        char *text =
            text_of("%s void glow sky 0 0 4 1 1 1 0 sky source nadir 0 0 4 0 0 -1 179\n",
                    strstr(slab, "void dielectric"));
        *strstr(text, "void plastic") = '#'; /* no floor ... */
        *strstr(text, "dark polygon") = '#';
        pm_sensor sensors[64];
        for (int k = 0; k < 64; k++)
            sensors[k] = (pm_sensor){{.001 * k, 0, .05}, {sin(angles[i]), 0, -cos(angles[i])}};
        struct stat got[3 * 64] = {0};
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, sensors, 64, PM_RADIANCE);
        job.passes = 64;
        run_seeds(&job, text, SEEDS, got);
        for (int c = 0; c < 3; c++) {
            struct stat all = {0};
            for (int k = 0; k < 64; k++)
                stat_add(&all, got[3 * k + c].mean);
            expect_mean("ray", &all, slab_transmittance(angles[i], INDEX, tn[c], THICKNESS), 0);
        }
        free(text);
        free(slab);
    }
}

/* Straight passage is no event: a pane between sun and sensor only weighs next events. */
static void next_events_through_glass_carry_its_transmittance(void **state)
{
    (void)state;
    static const double color[3] = {.96, .5, .05};
    for (int i = 0; i < 3; i++) {
        double angle = angles[i];
        char *light = sun(angle);
        char *text = text_of("%s"
                             "void glass g 0 0 4 %g %g %g %.17g\n"
                             "g ring pane 0 0 8 0 0 1 0 0 1 0 9\n"
                             "void plastic black 0 0 5 0 0 0 0 0\n"
                             "black ring floor 0 0 8 0 0 0 0 0 1 0 9\n",
                             light, color[0], color[1], color[2], 1.52);
        const pm_sensor sensors[2] = {{{0, 0, 0}, {0, 0, 1}}, {{0, 0, .5}, {0, 0, 1}}};
        struct stat got[6] = {0};
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, sensors, 2, PM_IRRADIANCE);
        job.passes = 16;
        run_seeds(&job, text, SEEDS, got);
        for (int k = 0; k < 6; k++) {
            double tint = color[k % 3];
#define T(a) (cos(a) * glass_transmittance(a, 1.52, tint))
            expect_mean("glass", &got[k], T(angle), SUN_SLACK(T));
#undef T
        }
        free(text);
        free(light);
    }
}

/* ---- total reflection ---- */

/* A prism under 45 degrees: in by the face z = 0 at right angles, reflected at x + z = 1, out
 * by x = 0. The legs reflect f, the long face r, and all orders retrace the same way: out of x
 * = 0:  (1 - f)^2 r / (1 - f^2 r^2),   out of x + z = 1:  (1 - f)(1 - r) / (1 - f r). */
#define PRISM                                                                                  \
    "glass_ polygon in 0 0 12 0 -1 0 0 1 0 1 1 0 1 -1 0\n"                                     \
    "glass_ polygon out 0 0 12 0 -1 0 0 -1 1 0 1 1 0 1 0\n"                                    \
    "glass_ polygon long 0 0 12 1 -1 0 1 1 0 0 1 1 0 -1 1\n"                                   \
    "glass_ polygon left 0 0 9 0 -1 0 1 -1 0 0 -1 1\n"                                         \
    "glass_ polygon right 0 0 9 0 1 0 0 1 1 1 1 0\n"

static double leg_reflectance(double n)
{
    return pow((n - 1) / (n + 1), 2);
}

/* From inside at 45 degrees; 1 beyond the critical angle. */
static double long_face_reflectance(double n)
{
    double sine = n * sqrt(.5);
    return sine >= 1 ? 1 : mean_reflectance(n, sqrt(1 - sine * sine));
}

/* Red shines from behind the face `out`, green from behind the long one. */
static void prism_reflects_totally_beyond_the_critical_angle(void **state)
{
    (void)state;
    static const double indices[] = {1.3, 1.5};
    pm_sensor sensors[64];
    for (int i = 0; i < 64; i++)
        sensors[i] = (pm_sensor){{.3 + .005 * i, .01 * i - .3, -1}, {0, 0, 1}};
    for (int i = 0; i < 2; i++) {
        double n = indices[i], f = leg_reflectance(n), r = long_face_reflectance(n);
        char *text = text_of("void dielectric glass_ 0 0 5 1 1 1 %.17g 0\n" PRISM
                             "void glow red 0 0 4 1 0 0 0 red ring a 0 0 8 -.1 0 .5 1 0 0 0 2\n"
                             "void glow green 0 0 4 0 1 0 0\n"
                             "green ring b 0 0 8 .6 0 .6 -1 0 -1 0 2\n",
                             n);
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, sensors, 64, PM_RADIANCE);
        job.passes = 16;
        struct stat red = run_mean(&job, text, SEEDS, 0),
                    green = run_mean(&job, text, SEEDS, 1);
        expect_mean("red", &red, (1 - f) * (1 - f) * r / (1 - f * f * r * r), 0);
        expect_mean("green", &green, (1 - f) * (1 - r) / (1 - f * r), 0);
        free(text);
    }
    assert_true(long_face_reflectance(1.5) == 1 && long_face_reflectance(1.3) < .2);
}

/* The same by photons: a sun shines into the face z = 0; what leaves x = 0 falls on a plate
 * beside it, and nothing on the one behind the long face. The plates reflect .001. */
static void photons_are_reflected_totally(void **state)
{
    (void)state;
    enum { PHOTONS = 5000 };
    char *light = sun(PI), *text;
    text = text_of("%s void dielectric glass_ 0 0 5 1 1 1 1.5 0\n" PRISM
                   "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
                   "dark polygon beside 0 0 12 -.05 -.9 .1 -.05 .9 .1 -.05 .9 .9 -.05 -.9 .9\n"
                   "dark ring behind 0 0 8 .55 0 .55 -1 0 -1 0 .5\n",
                   light);
    pm_job job = job_of(PM_JOB_MAP, 0);
    want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 40);
    double f = leg_reflectance(1.5), want = 1.8 * .8 * (1 - f) / (1 + f);
    struct stat beside[3], behind[3];
    run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){-.05, 0, .5}, .99, beside);
    run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){.55, 0, .55}, .51, behind);
    expect_mean("beside", &beside[0], want, want * (.001 + 1. / PHOTONS));
    expect_near("behind", behind[0].mean, 0, .001 * want);
    free(text);
    free(light);
}

/* Rays that start on a tinted ball, wherever rounding puts them, and look away from it. */
static void rays_that_start_on_glass_see_out(void **state)
{
    (void)state;
    enum { COUNT = 64 };
    pm_sensor rays[COUNT];
    for (int i = 0; i < COUNT; i++)
        rays[i] = (pm_sensor){sphere_point(i, COUNT), sphere_point(i, COUNT)};
    rays[0] = (pm_sensor){{.6, .8, 0}, {.6, .8, 0}}; /* inside by a last digit */
    pm_job job = job_of(PM_JOB_TRACE, 0);
    pm_answer answer;
    look_at(&job, rays, COUNT, PM_RADIANCE);
    run_job(&job,
            "void dielectric d 0 0 5 .1 .1 .1 1.5 0  d sphere ball 0 0 4 0 0 0 1\n"
            "void glow sky 0 0 4 1 1 1 0  sky source all 0 0 4 0 0 1 360\n",
            NULL, &answer);
    for (int i = 0; i < COUNT; i++)
        expect_near("sky", (double)answer.values[3 * i], 1, 0);
    pm_answer_clear(&answer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_that_start_on_glass_see_out),
        cmocka_unit_test(photons_through_a_slab_carry_its_transmittance),
        cmocka_unit_test(rays_through_a_slab_see_its_transmittance),
        cmocka_unit_test(next_events_through_glass_carry_its_transmittance),
        cmocka_unit_test(prism_reflects_totally_beyond_the_critical_angle),
        cmocka_unit_test(photons_are_reflected_totally),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
