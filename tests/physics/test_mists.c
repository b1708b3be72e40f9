/* Mists with other things in them: dielectrics, other mists, lights, antimatter; against the
 * reference tracer, which knows no photons. Fluxes on discs are counted, not looked up. */
#include "physics.h"

/* The reference's own precision; photons have as much for a second each. */
enum { SAMPLES = 1 << 17, PHOTONS = 8000, DISCS_MAX = 3 };

struct disc {
    double x, y, radius;
};

/* All indirect flux on discs of the floor z = 0 from one global map a seed, channel by channel,
 * is the reference's: caustic or scattered. A map that ends with photon N has bias 1 / N. */
static void expect_reference(const char *what, const char *text, const struct disc *discs,
                             int count, uint64_t samples)
{
    struct stat got[DISCS_MAX][3] = {0};
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_GLOBAL, PHOTONS, 40);
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        job.forward.seed = seed;
        run_job(&job, text, NULL, &answer);
        for (int i = 0; i < count; i++) {
            pm_vec3 center = {discs[i].x, discs[i].y, 0};
            pm_rgb flux = flux_within(answer.map[PM_MAP_GLOBAL], center, discs[i].radius);
            stat_add(&got[i][0], flux.r);
            stat_add(&got[i][1], flux.g);
            stat_add(&got[i][2], flux.b);
        }
        pm_answer_clear(&answer);
    }
    for (int i = 0; i < count; i++) {
        pm_sensor sensor = {{discs[i].x, discs[i].y, 0}, {0, 0, 1}};
        struct ref_result want = reference_irradiance(text, &sensor, discs[i].radius, samples);
        double area = PI * discs[i].radius * discs[i].radius;
        for (int c = 0; c < 3; c++) {
            double mean = want.mean[REF_CAUSTIC][c] + want.mean[REF_INDIRECT][c];
            double error = hypot(want.standard_error[REF_CAUSTIC][c],
                                 want.standard_error[REF_INDIRECT][c]);
            char name[120];
            snprintf(name, sizeof name, "%s, disc %d, channel %d", what, i, c);
            expect_equal_means(name, &got[i][c], area * mean, area * error,
                               area * mean / PHOTONS);
        }
    }
}

#define FLOOR "void plastic grey 0 0 5 .5 .4 .3 0 0  grey ring floor 0 0 8 0 0 0 0 0 1 0 2\n"
#define LAMP  "void light bright 0 0 3 9 8 7  bright ring lamp 0 0 8 .2 0 1.9 0 0 -1 0 .25\n"
#define BALL  "void dielectric clear 0 0 5 .8 .9 1 1.5 0  clear sphere ball 0 0 4 0 0 .6 .4\n"

static const struct disc discs[DISCS_MAX] = {{-.08, 0, .15}, {.7, .3, .3}, {0, 0, 1.5}};

static void a_glass_ball_in_mist_has_the_references_light(void **state)
{
    (void)state;
    expect_reference("ball in mist",
                     FLOOR LAMP BALL "void mist fog 0 0 7 .8 .5 .2 .9 .6 .3 .5\n"
                                     "fog sphere cloud 0 0 4 0 0 .5 1.8\n",
                     discs, 3, SAMPLES);
}

/* Two clouds of opposite eccentricity and other colours that overlap, and a third of the first
 * one's material within it. */
static void overlapping_mists_have_the_references_light(void **state)
{
    (void)state;
    expect_reference("clouds",
                     FLOOR LAMP "void mist red 0 0 7 1.5 .2 .1 .9 .9 .9 .8\n"
                                "red sphere a 0 0 4 -.3 0 .9 .7\n"
                                "red sphere c 0 0 4 -.3 0 .9 .4\n"
                                "void mist blue 0 0 7 .1 .3 2 .9 .8 .7 -.6\n"
                                "blue sphere b 0 0 4 .4 0 .9 .7\n",
                     discs, 3, SAMPLES);
}

/* A lamp within a cloud, and one that lies in the cloud's own top, which lights into it. */
static void lights_in_mist_have_the_references_light(void **state)
{
    (void)state;
    expect_reference("lamps in mist",
                     FLOOR
                     "void light bright 0 0 3 9 8 7  bright sphere bulb 0 0 4 -.5 0 .8 .1\n"
                     "bright polygon tube 0 0 12 .3 -.2 1.2 .3 .2 1.2 .7 .2 1.2 .7 -.2 1.2\n"
                     "void mist fog 0 0 7 1.5 .9 .4 .9 .6 .3 .3\n"
                     "fog polygon low 0 0 12 -1 -1 .3 -1 1 .3 1 1 .3 1 -1 .3\n"
                     "fog polygon top 0 0 12 -1 -1 1.2 1 -1 1.2 1 1 1.2 -1 1 1.2\n"
                     "fog polygon south 0 0 12 -1 -1 .3 1 -1 .3 1 -1 1.2 -1 -1 1.2\n"
                     "fog polygon north 0 0 12 -1 1 .3 -1 1 1.2 1 1 1.2 1 1 .3\n"
                     "fog polygon west 0 0 12 -1 -1 .3 -1 -1 1.2 -1 1 1.2 -1 1 .3\n"
                     "fog polygon east 0 0 12 1 -1 .3 1 1 .3 1 1 1.2 1 -1 1.2\n",
                     discs, 3, SAMPLES);
}

/* A lamp within glass, that in mist; a ball of mist within another ball of glass. */
static void lights_in_glass_have_the_references_light(void **state)
{
    (void)state;
    expect_reference("lamp in glass",
                     FLOOR "void light bright 0 0 3 9 8 7  bright sphere bulb 0 0 4 .5 0 1 .1\n"
                           "void dielectric amber 0 0 5 .9 .5 .2 1.4 0\n"
                           "amber sphere globe 0 0 4 .5 0 1 .3\n"
                           "void dielectric clear 0 0 5 .8 .9 1 1.5 0\n"
                           "clear sphere ball 0 0 4 -.4 0 .6 .4\n"
                           "void mist smoke 0 0 7 3 2 1 .9 .8 .7 .6\n"
                           "smoke sphere within 0 0 4 -.4 0 .6 .2\n"
                           "void mist fog 0 0 7 .6 .4 .2 .9 .6 .3 -.3\n"
                           "fog sphere cloud 0 0 4 0 0 .5 1.8\n",
                     discs, 3, SAMPLES);
}

/* A sun, so wide that the reference meets it, comes in through the cloud's boundary; a ball
 * stands in it. */
static void sun_into_mist_has_the_references_light(void **state)
{
    (void)state;
    expect_reference("sun",
                     FLOOR BALL "void light sun 0 0 3 40 35 30  sun source s 0 0 4 .3 0 1 20\n"
                                "void mist fog 0 0 7 1 .6 .3 .95 .8 .5 .7\n"
                                "fog sphere cloud 0 0 4 0 0 .5 1.8\n",
                     discs, 3, SAMPLES);
}

/* ---- thick media ----
 *
 * A sun at the zenith over a cloud without an end below, of single-scattering albedo w: the
 * share 1 - H(1) sqrt(1 - w) comes back (Chandrasekhar, Radiative Transfer, 1960, eq. 5.26
 * ff.), with 1 / H(m) = sqrt(1 - w) + w/2 int_0^1 x H(x) / (m + x) dx. */
enum { NODES = 400 };

static double albedo_of_a_deep_cloud(double w)
{
    double h[NODES + 1], next[NODES + 1]; /* the last is at m = 1 */
    for (int i = 0; i <= NODES; i++)
        h[i] = 1;
    for (int round = 0; round < 400; round++) {
        for (int i = 0; i <= NODES; i++) {
            double m = i < NODES ? (i + .5) / NODES : 1, sum = 0;
            for (int k = 0; k < NODES; k++) {
                double x = (k + .5) / NODES;
                sum += x * h[k] / (m + x) / NODES;
            }
            next[i] = 1 / (sqrt(1 - w) + w / 2 * sum);
        }
        for (int i = 0; i <= NODES; i++)
            h[i] = (h[i] + next[i]) / 2;
    }
    return 1 - h[NODES] * sqrt(1 - w);
}

#define FOG_CUBE                                                                               \
    "fog polygon low 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"                                 \
    "fog polygon top 0 0 12 -1 -1 1 1 -1 1 1 1 1 -1 1 1\n"                                     \
    "fog polygon south 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"                               \
    "fog polygon north 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"                                   \
    "fog polygon west 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"                                \
    "fog polygon east 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n"

/* Optical thicknesses of 2000 and 6 10^4. The cloud takes 4 (1 - albedo) of the sun's light,
 * all else escapes, and paths live as long as they do: with .9999, of what enters 1 in 180 is
 * scattered 5000 times or more, but for roulette. Light that diffuses through a length 1 / (s
 * sqrt(3 (1 - w))) may leave by the sides, as far from them: of what is taken there, a share.
 */
static void expect_deep_cloud(double extinction, double w)
{
    double radiance = sun_radiance();
    char *text =
        text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                "void mist fog 0 0 7 %g %g %g %.17g %.17g %.17g 0\n" FOG_CUBE,
                radiance, radiance, radiance, extinction, extinction, extinction, w, w, w);
    pm_sensor sensor = {{0, 0, 5}, {0, 0, 1}};
    pm_job job = job_of(PM_JOB_TRACE, -1);
    look_at(&job, &sensor, 1, PM_IRRADIANCE);
    struct stat taken = {0}, rest = {0};
    for (unsigned seed = 1; seed <= 4; seed++) {
        pm_answer answer;
        job.forward.seed = seed;
        run_job(&job, text, NULL, &answer);
        stat_add(&taken, answer.absorbed.r / 4);
        stat_add(&rest, (answer.emitted.r - answer.absorbed.r - answer.escaped.r) / 4);
        pm_answer_clear(&answer);
    }
    double want = 1 - albedo_of_a_deep_cloud(w);
    double side = 2 / (extinction * sqrt(3 * (1 - w)));
    char what[60];
    snprintf(what, sizeof what, "extinction %g albedo %g", extinction, w);
    expect_mean(what, &taken, want, want * (2 * side + 1e-3));
    expect_mean("balance", &rest, 0, ROUNDING);
    free(text);
}

static void thick_clouds_reflect_what_theory_says(void **state)
{
    (void)state;
    expect_deep_cloud(1e3, .9);
    expect_deep_cloud(3e4, .9999);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_glass_ball_in_mist_has_the_references_light),
        cmocka_unit_test(overlapping_mists_have_the_references_light),
        cmocka_unit_test(lights_in_mist_have_the_references_light),
        cmocka_unit_test(lights_in_glass_have_the_references_light),
        cmocka_unit_test(sun_into_mist_has_the_references_light),
        cmocka_unit_test(thick_clouds_reflect_what_theory_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
