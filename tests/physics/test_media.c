/* Mist: attenuation, single scattering, dielectrics in it, thin and thick limits. */
#include "physics.h"

/* ---- Beer and Lambert ---- */

static const double extinctions[] = {.5, 1, 2, 10};

/* A ray through d of mist sees a glow behind it with exp(-extinction d). */
static void rays_are_attenuated_as_beer_and_lambert_say(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        char *text =
            text_of("void mist fog 0 0 3 %.17g %.17g 0  fog sphere cloud 0 0 4 0 0 0 1\n"
                    "void glow wall 0 0 4 1 1 1 0  wall ring w 0 0 8 2 0 0 -1 0 0 0 1\n",
                    extinctions[i], extinctions[i] / 3);
        pm_sensor rays[4]; /* chords of the unit sphere at height h: 2 sqrt(1 - h^2) */
        for (int k = 0; k < 4; k++)
            rays[k] = (pm_sensor){{-3, 0, .25 * k}, {1, 0, 0}};
        pm_job job = job_of(PM_JOB_TRACE, -1);
        look_at(&job, rays, 4, PM_RADIANCE);
        pm_answer answer;
        run_job(&job, text, NULL, &answer);
        for (int k = 0; k < 4; k++) {
            double d = 2 * sqrt(1 - .0625 * k * k);
            expect_near("red", (double)answer.values[3 * k], exp(-extinctions[i] * d), 0);
            expect_near("green", (double)answer.values[3 * k + 1], exp(-extinctions[i] * d / 3),
                        0);
            expect_near("blue", (double)answer.values[3 * k + 2], 1, 0);
        }
        pm_answer_clear(&answer);
        free(text);
    }
}

/* Next events through it likewise: a sensor in the middle under a sun, 1 of mist above it. */
static void next_events_are_attenuated_as_beer_and_lambert_say(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        double radiance = sun_radiance();
        char *text =
            text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                    "void mist fog 0 0 3 %.17g %.17g 0  fog sphere cloud 0 0 4 0 0 0 1\n",
                    radiance, radiance, radiance, extinctions[i], extinctions[i] / 3);
        pm_sensor sensor = {{0, 0, 0}, {0, 0, 1}};
        pm_job job = job_of(PM_JOB_TRACE, -1);
        look_at(&job, &sensor, 1, PM_IRRADIANCE);
        pm_answer answer;
        run_job(&job, text, NULL, &answer);
        /* the sun's rim is tilted by .05 degrees: cosines and lengths change by 4e-7 */
        expect_near("red", (double)answer.values[0], exp(-extinctions[i]), 1e-5);
        expect_near("green", (double)answer.values[1], exp(-extinctions[i] / 3), 1e-5);
        expect_near("blue", (double)answer.values[2], 1, 1e-5);
        pm_answer_clear(&answer);
        free(text);
    }
}

/* ---- a dielectric in mist ---- */

/* The mist ends at the ball and goes on behind it. A ray along a diameter is not bent: through
 * 2 - 2 r of mist, with the ball's faces (1 - f) / (1 + f) and its own exp(-.5 2 r). */
static void mist_goes_on_behind_a_glass_ball(void **state)
{
    (void)state;
    const double index[] = {1, 1.5}, radius = .4, own = .5;
    for (int i = 0; i < 2; i++) {
        char *text =
            text_of("void mist fog 0 0 3 1 2 0  fog sphere cloud 0 0 4 0 0 0 1\n"
                    "void dielectric clear 0 0 5 %.17g %.17g %.17g %g 0  clear sphere ball 0 0 "
                    "4 .1 0 0 .4\n"
                    "void glow wall 0 0 4 1 1 1 0  wall ring w 0 0 8 2 0 0 -1 0 0 0 1\n",
                    exp(-own), exp(-own), exp(-own), index[i]);
        pm_sensor rays[64];
        for (int k = 0; k < 64; k++)
            rays[k] = (pm_sensor){{-3, 0, 0}, {1, 0, 0}};
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, rays, 64, PM_RADIANCE);
        job.passes = 64;
        double f = pow((index[i] - 1) / (index[i] + 1), 2), inner = exp(-own * 2 * radius);
        double ball = (1 - f) * (1 - f) * inner / (1 - f * f * inner * inner);
        /* what the first face reflects sees nothing; reflections within retrace the diameter */
        for (int c = 0; c < 3; c++) {
            struct stat got = run_mean(&job, text, SEEDS, c);
            expect_mean("ball", &got, ball * exp(-(c == 2 ? 0 : c + 1) * (2 - 2 * radius)), 0);
        }
        free(text);
    }
}

/* The same for photons, where the peer loses free paths and the mist: a sun through a mist slab
 * 1 thick, in it a ball of index 1, below it a floor. The ball neither bends nor reflects, and
 * every photon through it is a caustic one: below it, on a disc of radius R, irradiance is
 * exp(-extinction (1 - 2 sqrt(r^2 - x^2))). The fog scatters nothing, or a millionth: then its
 * free paths are drawn, and all scattered light is less than a millionth. */
static double ball_shadow(double x, const void *context)
{
    double extinction = *(const double *)context;
    return 2 * PI * x * exp(-extinction * (1 - 2 * sqrt(.16 - x * x)));
}

static void photons_go_on_in_the_mist_behind_a_ball(void **state)
{
    (void)state;
    static const double albedo[] = {0, 1e-6}, fog[3] = {1, 2, 0};
    double radiance = sun_radiance();
    for (int i = 0; i < 2; i++) {
        char *text =
            text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                    "void mist fog 0 0 6 1 2 0 %g %g %g\n"
                    "fog ring top 0 0 8 0 0 1.01 0 0 1 0 .6\n"
                    "fog ring low 0 0 8 0 0 .01 0 0 -1 0 .6\n"
                    "fog cylinder side 0 0 7 0 0 .01 0 0 1.01 .6\n"
                    "void dielectric clear 0 0 5 1 1 1 1 0  clear sphere ball 0 0 4 0 0 .5 .4\n"
                    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
                    "dark ring floor 0 0 8 0 0 0 0 0 1 0 .6\n",
                    radiance, radiance, radiance, albedo[i], albedo[i], albedo[i]);
        pm_job job = job_of(PM_JOB_MAP, -1);
        want_map(&job, PM_MAP_CAUSTIC, 5000, 40);
        struct stat got[3];
        run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){0, 0, 0}, .3, got);
        for (int c = 0; c < 3; c++) {
            double want = integrate(ball_shadow, &fog[c], 0, .3, 100);
            expect_mean("behind the ball", &got[c], want, want * (1. / 5000 + .001));
        }
        free(text);
    }
}

/* ---- single scattering ---- */

/* A sun at the zenith over a cube of fog [-1, 1]^3 with albedo w = 1e-4, so that light
 * scattered again is less than 1e-4. A ray in it at depth h below the top, from x = 0 on to x =
 * 1, gets L = w s p(cos) exp(-s h) int_0^1 exp(-s x) dx = w p(cos) exp(-s h) (1 - exp(-s)),
 * with p the phase function at the angle between the sun's light and the way to the eye, and
 * s the extinction: that the peer's has a factor s too much is the first of its defects.
 *
 * Bias of a look-up with radius r. Photon density falls like exp(-s z) downwards; its mean over
 * a ball is more by 3 (u cosh u - sinh u) / u^3, u = s r. Where the ray leaves the fog, a
 * look-up at distance x < r from the side misses 1/2 - 3 x / 4r + x^3 / 4r^3 of its volume,
 * 3/16 r over all, there weighted by exp(-s) or less of what it is at the eye: -3/16 r s exp(-s
 * (1 - r)) / (1 - exp(-s)). */
#define FOG_ALBEDO 1e-4

static char *fog_cube(double extinction, double g)
{
    double radiance = sun_radiance(), w = FOG_ALBEDO;
    return text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                   "void mist fog 0 0 7 %.17g %.17g %.17g %g %g %g %g\n"
                   "fog polygon low 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"
                   "fog polygon top 0 0 12 -1 -1 1 1 -1 1 1 1 1 -1 1 1\n"
                   "fog polygon south 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n"
                   "fog polygon north 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n"
                   "fog polygon west 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n"
                   "fog polygon east 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n",
                   radiance, radiance, radiance, extinction, extinction, extinction, w, w, w,
                   g);
}

static double henyey_greenstein(double g, double cosine)
{
    return (1 - g * g) / (4 * PI * pow(1 + g * g - 2 * g * cosine, 1.5));
}

/* Of N photons of light that falls evenly on 4 units of area, at depth h the density is
 * N s exp(-s h) / 4 / (1 - exp(-2 s)) at least; K of them fill a ball of radius r. */
static double ball_radius(double extinction, double depth, double photons, double gather)
{
    double density = photons * extinction * exp(-extinction * depth) / 4;
    return cbrt(gather / (density * 4 / 3 * PI));
}

static void expect_single_scattering(double extinction, double g, double tilt, bool progressive)
{
    enum { RAYS = 16, PHOTONS = 100000, GATHER = 50 };
    double depth = fmin(.5, 1 / extinction), s = extinction;
    char *text = fog_cube(extinction, g);
    pm_sensor rays[RAYS];
    for (int i = 0; i < RAYS; i++)
        rays[i] = (pm_sensor){{0, .1 * (i - 7.5), 1 - depth}, {1, 0, tilt}};
    pm_job job = job_of(PM_JOB_TRACE, -1);
    if (!progressive)
        want_map(&job, PM_MAP_VOLUME, PHOTONS, GATHER);
    look_at(&job, rays, RAYS, PM_RADIANCE);
    job.passes = progressive ? 2 : 16;
    struct stat got = run_mean(&job, text, SEEDS, GREY);
    /* along a tilted ray the depth changes by tilt x, its length by sqrt(1 + tilt^2) */
    double slope = sqrt(1 + tilt * tilt), rate = s * (slope - tilt);
    double cosine = -tilt / slope; /* light goes down; towards the eye is (-1, 0, -tilt) */
    double want = FOG_ALBEDO * henyey_greenstein(g, -cosine) * exp(-s * depth) * s * slope *
                  (1 - exp(-rate)) / rate;
    double r = progressive ? ball_radius(s, depth, PM_BATCH_PATHS / 4., 24)
                           : ball_radius(s, depth, PHOTONS, GATHER);
    double u = s * r, spread = 3 * (u * cosh(u) - sinh(u)) / (u * u * u) - 1;
    double side = 3. / 16 * r * rate * exp(-rate * (1 - r)) / (1 - exp(-rate));
    char what[80];
    snprintf(what, sizeof what, "%s extinction %g g %g tilt %g",
             progressive ? "progressive" : "nearest", extinction, g, tilt);
    expect_mean(what, &got, want, want * (spread + side + FOG_ALBEDO));
    free(text);
}

static void single_scattering_is_that_of_the_analytic_integral(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        expect_single_scattering(extinctions[i], 0, 0, false);
        expect_single_scattering(extinctions[i], 0, 0, true);
    }
}

static void scattering_follows_the_phase_function(void **state)
{
    (void)state;
    expect_single_scattering(1, .5, 0, false);
    expect_single_scattering(1, .5, .4, false);
    expect_single_scattering(1, .5, -.4, false);
    expect_single_scattering(1, -.5, .4, true);
}

/* ---- limits ---- */

/* Extinctions of all sizes: next events have the right transmittance to the last digit of a
 * float, everything is finite and ends, and the fog takes or gives back what it gets. What a
 * cloud as thick as that scatters to the eye is not claimed: look-ups cannot be narrower than
 * their photons are apart. */
static void extreme_extinctions_have_their_limits(void **state)
{
    (void)state;
    static const double extremes[] = {1e-6, 1e-3, 1e3, 1e6};
    for (int i = 0; i < 4; i++) {
        double s = extremes[i], radiance = sun_radiance();
        char *text =
            text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                    "void mist fog 0 0 7 %g %g %g 1 .999 .5 0\n"
                    "fog sphere cloud 0 0 4 0 0 0 .5\n"
                    "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
                    "grey ring floor 0 0 8 0 0 -1 0 0 1 0 1\n",
                    radiance, radiance, radiance, s, s, s);
        const pm_sensor sensors[2] = {{{0, 0, -1}, {0, 0, 1}}, {{.9, 0, -1}, {0, 0, 1}}};
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, sensors, 2, PM_IRRADIANCE);
        pm_answer answer;
        run_job(&job, text, NULL, &answer);
        expect_near("under the cloud", (double)answer.values[0], exp(-s), 1e-5);
        expect_near("beside it", (double)answer.values[3], 1, 1e-5);
        for (int k = 0; k < 6; k++)
            assert_true(isfinite(answer.values[k]) && answer.values[k] >= 0);
        pm_rgb e = answer.emitted;
        pm_rgb rest = pm_rgb_sub(pm_rgb_sub(e, answer.absorbed), answer.escaped);
        /* of 2^16 paths, each of weight at most 3 (the channel that draws its free path) */
        expect_near("balance", pm_rgb_mean(rest) / pm_rgb_mean(e), 0, K_SIGMA * 3 / 256);
        pm_answer_clear(&answer);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_are_attenuated_as_beer_and_lambert_say),
        cmocka_unit_test(next_events_are_attenuated_as_beer_and_lambert_say),
        cmocka_unit_test(mist_goes_on_behind_a_glass_ball),
        cmocka_unit_test(photons_go_on_in_the_mist_behind_a_ball),
        cmocka_unit_test(single_scattering_is_that_of_the_analytic_integral),
        cmocka_unit_test(scattering_follows_the_phase_function),
        cmocka_unit_test(extreme_extinctions_have_their_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
