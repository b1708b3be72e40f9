#include "physics.h"

/* Skies, suns, patterned panes and measured luminaires, against integrals that are taken here
 * from the published formulas.
 *
 * 32 seeds; the mean's distance from the truth in standard errors follows Student's t with 31
 * degrees of freedom, beyond 4 with probability 3.7e-4. */
enum { MANY = 32 };

static void expect_within_4(const char *what, const struct stat *got, double want, double slack)
{
    double allowed = 4 * stat_error(got) + slack + ROUNDING * fabs(want);
    if (!(fabs(got->mean - want) <= allowed))
        fail_msg("%s: got %.7g, want %.7g (%+.3f %%), allowed %.3g", what, got->mean, want,
                 100 * (got->mean / want - 1), allowed);
}

/* stats[3 * sensor + channel] */
static void next_events_at(const char *text, const pm_sensor *sensors, size_t count,
                           struct stat *stats)
{
    pm_job job = job_of(PM_JOB_TRACE, 0);
    look_at(&job, sensors, count, PM_IRRADIANCE);
    job.passes = 64;
    memset(stats, 0, 3 * count * sizeof *stats);
    run_seeds(&job, text, MANY, stats);
}

static struct stat next_events(const char *text, pm_sensor sensor)
{
    struct stat stats[3];
    next_events_at(text, &sensor, 1, stats);
    return stats[0];
}

/* ---- skies ---- */

#define SOMETHING "void plastic p 0 0 5 0 0 0 0 0\np sphere a 0 0 4 9 9 -9 .1\n"

static const pm_vec3 sun = {.5, -.33166247903554, .8}; /* unit */

static double from_sun(pm_vec3 w)
{
    return acos(fmax(-1, fmin(pm_vec3_dot(w, sun), 1)));
}

/* Kittler 1967, and what it gives at the zenith. 1 - exp(-32) is 1 in double, so that the
 * horizon is level. */
static double kittler(double gamma, double height)
{
    return (.91 + 10 * exp(-3 * gamma) + .45 * pow(cos(gamma), 2)) *
           (1 - exp(-.32 / fmax(height, .01)));
}

static double clear(pm_vec3 w)
{
    return 7 * kittler(from_sun(w), w.z) / kittler(acos(sun.z), 1);
}

/* Matsuura and Iwata 1990, likewise. */
static double matsuura(double gamma, double eta)
{
    double zenith = acos(sun.z);
    return ((1.35 * sin(5.631 - 3.59 * eta) + 3.12) * sin(4.396 - 2.6 * zenith) + 6.37 - eta) /
           2.326 * exp(-.563 * gamma * ((2.629 - eta) * (1.562 - zenith) + .812));
}

static double intermediate(pm_vec3 w)
{
    return 7 * matsuura(from_sun(w), acos(w.z)) / matsuura(acos(sun.z), 0);
}

/* Perez, Seals and Michalsky 1993, eq. 1, with the coefficients of some hazy sky. */
static double perez(pm_vec3 w)
{
    double gamma = from_sun(w);
    return 3 * (1 - .8 * exp(-.3 / fmax(w.z, .01))) *
           (1 + 15 * exp(-3 * gamma) + .3 * pow(cos(gamma), 2));
}

/* Moon and Spencer 1942. */
static double overcast(pm_vec3 w)
{
    return 7 * (1 + 2 * w.z) / 3;
}

static double uniform(pm_vec3 w)
{
    (void)w;
    return 7;
}

/* The files of gensky and gendaylit blend the sky and a ground of radiance 2 at the horizon. */
static double with_ground(double (*sky)(pm_vec3 w), pm_vec3 w)
{
    double a = pow(w.z + 1.01, 10);
    return (a * sky(w) + 2 / a) / (a + 1 / a);
}

static const struct {
    const char *name, *pattern;
    double (*sky)(pm_vec3 w);
} skies[] = {
    {"uniform", "2 skybr skybright.cal 0 7 3 7 2 1", uniform},
    {"overcast", "2 skybr skybright.cal 0 7 2 7 2 1", overcast},
    {"clear", "2 skybr skybright.cal 0 7 1 7 2", clear},
    {"intermediate", "2 skybr skybright.cal 0 7 4 7 2", intermediate},
    {"Perez", "2 skybright perezlum.cal 0 10 3 2 -.8 -.3 15 -3 .3", perez},
};
enum { SKIES = sizeof skies / sizeof *skies };

/* Both hemispheres, as everybody writes them below gensky. */
static char *sky_text(int i, const char *rest)
{
    char norm[32] = "";
    if (skies[i].sky == clear)
        snprintf(norm, sizeof norm, "%.17g", kittler(acos(sun.z), 1));
    if (skies[i].sky == intermediate)
        snprintf(norm, sizeof norm, "%.17g", matsuura(acos(sun.z), 0));
    return text_of("void brightfunc skyfunc %s %s %.17g %.17g %.17g\n"
                   "skyfunc glow sky_glow 0 0 4 1 1 1 0\n"
                   "sky_glow source sky 0 0 4 0 0 1 180\n"
                   "skyfunc glow ground_glow 0 0 4 1 1 1 0\n"
                   "ground_glow source ground 0 0 4 0 0 -1 180\n%s",
                   skies[i].pattern, norm, sun.x, sun.y, sun.z, rest);
}

/* Midpoints in height and azimuth; where the integrand has kinks, at the sun, at the horizon
 * and edge on, the error is of order steps^-2. */
static double sky_irradiance(double (*sky)(pm_vec3 w), pm_vec3 n)
{
    enum { STEPS = 800 };
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        double z = (i / STEPS + .5) / STEPS * 2 - 1, r = sqrt(1 - z * z);
        double phi = 2 * PI * (i % STEPS + .5) / STEPS;
        pm_vec3 w = {r * cos(phi), r * sin(phi), z};
        double cosine = pm_vec3_dot(w, n);
        if (cosine > 0)
            sum += cosine * with_ground(sky, w);
    }
    return sum * 4 * PI / ((double)STEPS * STEPS);
}

/* By next events; and these are as good under the unevenest sky as under an even one. */
static void skies_give_the_irradiance_of_their_formulas(void **state)
{
    (void)state;
    const pm_sensor sensors[] = {{{0, 0, 0}, {0, 0, 1}},
                                 {{0, 0, 0}, {.6, 0, .8}},
                                 {{0, 0, 0}, {-1, 0, 0}},
                                 {{0, 0, 0}, {0, 0, -1}}};
    double even[4] = {0};
    for (int i = 0; i < SKIES; i++) {
        char *text = sky_text(i, SOMETHING);
        struct stat got[12];
        next_events_at(text, sensors, 4, got);
        free(text);
        for (int k = 0; k < 4; k++) {
            double want = sky_irradiance(skies[i].sky, sensors[k].normal);
            double relative = stat_deviation(&got[3 * k]) / want;
            expect_within_4(skies[i].name, &got[3 * k], want, 1e-4 * want);
            if (i == 0)
                even[k] = relative;
            else if (k < 2 && !(relative < 1.6 * even[k]))
                fail_msg("%s: %g of the mean, %g of an even sky", skies[i].name, relative,
                         even[k]);
        }
    }
}

/* Moon and Spencer's sky without a blend: 7 pi / 9 times the zenith's luminance. */
static void overcast_sky_gives_seven_ninths_pi(void **state)
{
    (void)state;
    struct stat got =
        next_events("void brightfunc b 2 \"(1+2*Dz)/3\" . 0 0\n"
                    "b glow g 0 0 4 7 7 7 0\ng source s 0 0 4 0 0 1 180\n" SOMETHING,
                    (pm_sensor){{0, 0, 0}, {0, 0, 1}});
    expect_within_4("overcast", &got, 49 * PI / 9, 0);
}

/* A mirror's picture of a part of the sky on the underside of a dark disc, which throws no
 * shadow on that part: by photons, by look-ups in maps, by gather rays. The sky shines from
 * within acos(.95) of 45 degrees; a ray to the disc's point p passes the disc's height at 1.02
 * or more from p. The light is parallel in each direction, so that look-ups have no bias but
 * the disc's rim, .3 away. */
#define PART "if((Dx+Dz)/sqrt(2)-.95,1+Dy+Dz,0)"

static double part_irradiance(void)
{
    enum { STEPS = 500 };
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        double c = .95 + .05 * (i / STEPS + .5) / STEPS, r = sqrt(1 - c * c);
        double phi = 2 * PI * (i % STEPS + .5) / STEPS;
        double x = c / sqrt(2) + r * cos(phi) / sqrt(2), y = r * sin(phi);
        double z = c / sqrt(2) - r * cos(phi) / sqrt(2);
        (void)x;
        sum += z * (1 + y + z);
    }
    return sum * 2 * PI * .05 / ((double)STEPS * STEPS);
}

static void a_sky_in_a_mirror_counts_once_in_all_modes(void **state)
{
    (void)state;
    const char *text =
        "void brightfunc b 2 \"" PART "\" . 0 0\n"
        "b glow g 0 0 4 9 9 9 0\ng source s 0 0 4 0 0 1 180\n"
        "void mirror silver 0 0 3 .8 .8 .8\nsilver ring m 0 0 8 0 0 0 0 0 1 0 4\n"
        "void plastic dark 0 0 5 .001 .001 .001 0 0\ndark ring disc 0 0 8 0 0 1 0 0 -1 0 .5\n";
    pm_sensor sensors[16];
    for (int i = 0; i < 16; i++) {
        double phi = PI * i / 8;
        sensors[i] = (pm_sensor){{.1 * cos(phi), .1 * sin(phi), 1}, {0, 0, -1}};
    }
    double want = 9 * .8 * part_irradiance();
    for (int i = 0; i < MODES; i++) {
        pm_job job = job_of_mode(&modes[i], 2000, 50);
        look_at(&job, sensors, 16, PM_IRRADIANCE);
        job.passes = modes[i].progressive ? 1 : 16;
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_mean(modes[i].name, &got, want, .001 * want);
    }
}

/* ---- suns ---- */

/* The sun and a clear sky through an opening of a closed room, radiance by the pattern of each:
 * on the floor in the sun's patch and out of it. */
#define OPENING                                                                                \
    "void plastic wall 0 0 5 0 0 0 0 0\n"                                                      \
    "wall polygon floor 0 0 12 -2 -2 0 2 -2 0 2 2 0 -2 2 0\n"                                  \
    "wall polygon ceiling 0 0 30 -2 -2 3 -2 2 3 2 2 3 2 -2 3 -2 -2 3\n"                        \
    "-1 -1 3 1 -1 3 1 1 3 -1 1 3 -1 -1 3\n"                                                    \
    "wall polygon s 0 0 12 -2 -2 0 -2 -2 3 2 -2 3 2 -2 0\n"                                    \
    "wall polygon n 0 0 12 -2 2 0 2 2 0 2 2 3 -2 2 3\n"                                        \
    "wall polygon w 0 0 12 -2 -2 0 -2 2 0 -2 2 3 -2 -2 3\n"                                    \
    "wall polygon e 0 0 12 2 -2 0 2 -2 3 2 2 3 2 2 0\n"

static double sky_through_opening(double x, double y)
{
    enum { STEPS = 500 };
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        pm_vec3 w = {(i / STEPS + .5) / STEPS * 2 - 1 - x, (i % STEPS + .5) / STEPS * 2 - 1 - y,
                     3};
        double d = pm_vec3_length(w);
        w = pm_vec3_scale(w, 1 / d);
        sum += w.z * w.z / (d * d) * with_ground(clear, w);
    }
    return sum * 4 / ((double)STEPS * STEPS);
}

static void sun_and_sky_shine_through_an_opening(void **state)
{
    (void)state;
    /* a disc of 2 degrees whose pattern is 3 all over but at the sky's own places */
    char *part = text_of("void brightfunc c 2 \"2+Dz/.8\" . 0 0\n"
                         "c light solar 0 0 3 1000 1000 1000\n"
                         "solar source sun 0 0 4 %.17g %.17g %.17g 2\n" OPENING,
                         sun.x, sun.y, sun.z);
    char *text = sky_text(2, part);
    double sine = sin(PI / 180), solar = 3000 * PI * sine * sine * sun.z;
    /* 3 up, the sun's direction moves by 1.875, -1.2437 */
    double lit = sky_through_opening(-1.5, 1), dark = sky_through_opening(1.5, -1);
    struct stat got = next_events(text, (pm_sensor){{-1.5, 1, 0}, {0, 0, 1}});
    /* The pattern's mean over the disc is that in its middle, but for (1 degree)^2 / 4. The
     * disc hides a part of the sky, of radiance clear(sun), which the sum above does not. */
    double hidden = with_ground(clear, sun) * PI * sine * sine * sun.z;
    expect_within_4("in the sun", &got, lit + solar - hidden,
                    1e-4 * (lit + solar) + .001 * hidden);
    got = next_events(text, (pm_sensor){{1.5, -1, 0}, {0, 0, 1}});
    expect_within_4("beside it", &got, dark, 1e-4 * dark);
    free(text);
    free(part);
}

/* ---- environment maps ---- */

enum { WIDE = 64, HIGH = 32, SPOT_X = 40, SPOT_Y = 24 }; /* y from the bottom */

/* A picture in Radiance's oldest form, four bytes a pixel: grey of 2^-1, and one pixel of
 * 2^19. No byte is 0. */
static char *environment_text(void)
{
    static const char scene[] =
        "void colorpict env 7 red green blue env.hdr . \"Atan2(Dy,Dx)/PI+1\" "
        "\"1-Acos(Dz)/PI\" 0 0\n"
        "env glow g 0 0 4 1 1 1 0\ng source s 0 0 4 0 0 1 360\n" SOMETHING
        "#file env.hdr\n#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    char *text = malloc(sizeof scene + 4 * WIDE * HIGH), *at = text + sizeof scene - 1;
    assert_non_null(text);
    memcpy(text, scene, sizeof scene);
    for (int row = HIGH; row-- > 0;)
        for (int column = 0; column < WIDE; column++) {
            int exponent = row == SPOT_Y && column == SPOT_X ? 128 + 20 : 128;
            for (int i = 0; i < 3; i++)
                *at++ = (char)128;
            *at++ = (char)exponent;
        }
    *at = 0;
    return text;
}

/* Bilinear between the pixels' centres, the outermost of which lie on the rim: a pyramid of
 * height 2^19 over 2 x 2 steps, on a floor of 1/2. A pixel that reads 128 stands for 128.5. */
static double spot_irradiance(void)
{
    enum { STEPS = 400 };
    const double unit = 128.5 / 256, step_v = 1. / (HIGH - 1), step_u = 2. / (WIDE - 1);
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        double x = 2 * (i / STEPS + .5) / STEPS - 1, y = 2 * (i % STEPS + .5) / STEPS - 1;
        double eta = PI * (1 - (SPOT_Y + y) * step_v);
        sum += (1 - fabs(x)) * (1 - fabs(y)) * sin(eta) * fmax(cos(eta), 0);
    }
    sum *= 4 * step_u * PI * step_v * PI / ((double)STEPS * STEPS);
    return unit * (PI + (0x1p20 - 1) * sum);
}

static void one_bright_pixel_of_an_environment_is_found(void **state)
{
    (void)state;
    char *text = environment_text();
    struct stat got = next_events(text, (pm_sensor){{0, 0, 0}, {0, 0, 1}});
    double want = spot_irradiance();
    expect_within_4("environment", &got, want, 1e-4 * want);
    assert_true(stat_deviation(&got) < .2 * want);
    free(text);
}

/* ---- panes and luminaires ---- */

/* A pane of 2 x 1 at height 1 in 8 squares, of which four shine; colours differ. */
static void a_checked_pane_lights_by_its_bright_squares(void **state)
{
    (void)state;
    const char *text = "void colorfunc c 4 \"if(mod(floor(Px*2)+floor(Py*2),2)-.5,3,0)\" 1 "
                       "\"if(Px,0,6)\" . 0 0\n"
                       "c glow g 0 0 4 2 1 1 0\n"
                       "g polygon pane 0 0 12 -1 0 1 -1 1 1 1 1 1 1 0 1\n" SOMETHING;
    enum { STEPS = 1000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS / 2; k++) {
            double x = 2 * (i + .5) / STEPS - 1, y = 2 * (k + .5) / STEPS;
            bool odd = ((int)floor(2 * x) + (int)floor(2 * y)) & 1;
            double radiance = 2 * (odd ? 3 : 0);
            sum += radiance / pow(x * x + y * y + 1, 2);
        }
    double want = sum * 4 / STEPS / STEPS;
    struct stat got[3];
    next_events_at(text, &(pm_sensor){{0, 0, 0}, {0, 0, 1}}, 1, got);
    expect_within_4("pane, red", &got[0], want, 1e-4 * want);
    /* green is 1 in all: two unit squares over a corner of theirs (Howell's B-4) */
    double corner = sqrt(.5) * atan(sqrt(.5));
    expect_within_4("pane, green", &got[1], 2 * corner, 0);
    expect_within_4("pane, blue", &got[2], 6 * corner, 0);
}

/* Intensities [W/sr] at 0, 15, .. 90 degrees from straight down, linear between. */
static const double intensities[] = {120, 110, 80, 45, 20, 5, 0};

static double intensity_at(double degrees)
{
    int i = (int)fmin(degrees / 15, 5);
    double t = degrees / 15 - i;
    return (1 - t) * intensities[i] + t * intensities[i + 1];
}

/* As ies2rad writes a round luminaire of radius .001 that looks down: radiance is intensity
 * over projected area. */
#define LUMINAIRE                                                                              \
    "void brightdata d 4 flatcorr lamp.dat source.cal src_theta 0 1 %.17g\n"                   \
    "d light l 0 0 3 1 1 1\nl ring lamp 0 0 8 0 0 3 0 0 -1 0 .001\n"
#define TABLE "#file lamp.dat\n1\n0 90 7\n120 110 80 45 20 5 0\n"

static void a_luminaire_has_its_measured_intensities(void **state)
{
    (void)state;
    enum { ANGLES = 9 };
    const double d = 5;
    pm_sensor sensors[ANGLES];
    struct stat got[3 * ANGLES];
    for (int i = 0; i < ANGLES; i++) {
        double angle = i * PI / 18, sine = sin(angle), cosine = cos(angle);
        sensors[i] = (pm_sensor){{d * sine, 0, 3 - d * cosine}, {-sine, 0, cosine}};
    }
    char *text = text_of(LUMINAIRE SOMETHING TABLE, 1 / (PI * 1e-6));
    next_events_at(text, sensors, ANGLES, got);
    free(text);
    /* The lamp's extent is +- .0115 degrees; the steepest bend is 1.3 W / sr a degree. */
    for (int i = 0; i < ANGLES; i++)
        expect_within_4("luminaire", &got[3 * i], intensity_at(10 * i) / (d * d),
                        .0115 * 1.3 / (d * d));
}

/* Its photons by way of a mirror of albedo 1 on the floor: what a disc at the lamp's height
 * catches that looks down is the beam between the angles to its rims in the mirror. */
static void photons_of_a_luminaire_follow_its_intensities(void **state)
{
    (void)state;
    char *text = text_of(
        LUMINAIRE "void mirror silver 0 0 3 1 1 1\nsilver ring m 0 0 8 0 0 0 0 0 1 0 50\n"
                  "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
                  "dark ring disc 0 0 8 0 0 3.1 0 0 -1 2 4\n" TABLE,
        1 / (PI * 1e-6));
    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_CAUSTIC, 4000, 40);
    struct stat got[3];
    run_flux(&job, text, PM_MAP_CAUSTIC, (pm_vec3){0, 0, 3.1}, 5, got);
    double low = atan(2 / 6.1), high = atan(4 / 6.1), sum = 0;
    for (int i = 0; i < 1000; i++) {
        double angle = low + (high - low) * (i + .5) / 1000;
        sum += intensity_at(angle * 180 / PI) * sin(angle) * (high - low) / 1000;
    }
    /* the lamp's extent blurs the rims by .001 of 2; N / paths is off by 1 / N */
    expect_mean("beam", &got[0], 2 * PI * sum, (1. / 4000 + 1e-4) * 2 * PI * sum);
    free(text);
}

/* As mkillum writes a window: radiance over squared cosine and azimuth of the light, in the
 * frame of the window, which here looks down: rows of the table are altitudes 0 and 1. */
static void an_illum_has_its_distribution_in_all_modes(void **state)
{
    (void)state;
    const char *text =
        "void brightdata dist 5 noneg il.dat illum.cal il_alth il_azih\n"
        "0 9 1 0 0 0 -1 0 0 0 -1\n"
        "dist illum window 0 0 3 1 1 1\n"
        "window polygon pane 0 0 12 -.5 -.5 1 -.5 .5 1 .5 .5 1 .5 -.5 1\n"
        "void plastic black 0 0 5 0 0 0 0 0\nblack ring floor 0 0 8 .3 .2 0 0 0 1 0 2\n"
        "#file il.dat\n2\n0 1 2\n0 6.283185307179586 5\n1 2 3 4 1\n9 9 9 9 9\n";
    const double rows[2][5] = {{1, 2, 3, 4, 1}, {9, 9, 9, 9, 9}};
    pm_sensor sensors[16];
    for (int i = 0; i < 16; i++)
        sensors[i] = (pm_sensor){{.3, .2, 0}, {0, 0, 1}};
    enum { STEPS = 500 };
    double want = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        /* the way of the light, from the pane to the sensor */
        pm_vec3 w = {.3 - ((i / STEPS + .5) / STEPS - .5), .2 - ((i % STEPS + .5) / STEPS - .5),
                     -1};
        double d = pm_vec3_length(w), c = 1 / d;
        double azimuth = atan2(-w.y, w.x);
        double place = (azimuth > 0 ? azimuth : azimuth + 2 * PI) / (2 * PI) * 4;
        int k = (int)fmin(place, 3);
        double low = rows[0][k] + (place - k) * (rows[0][k + 1] - rows[0][k]);
        want += (low + c * c * (9 - low)) * c * c / (d * d) / ((double)STEPS * STEPS);
    }
    for (int i = 0; i < MODES; i++) {
        pm_job job = job_of_mode(&modes[i], 2000, 50);
        look_at(&job, sensors, 16, PM_IRRADIANCE);
        job.passes = modes[i].progressive ? 1 : 16;
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_mean(modes[i].name, &got, want, 1e-4 * want);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(skies_give_the_irradiance_of_their_formulas),
        cmocka_unit_test(overcast_sky_gives_seven_ninths_pi),
        cmocka_unit_test(a_sky_in_a_mirror_counts_once_in_all_modes),
        cmocka_unit_test(sun_and_sky_shine_through_an_opening),
        cmocka_unit_test(one_bright_pixel_of_an_environment_is_found),
        cmocka_unit_test(a_checked_pane_lights_by_its_bright_squares),
        cmocka_unit_test(a_luminaire_has_its_measured_intensities),
        cmocka_unit_test(photons_of_a_luminaire_follow_its_intensities),
        cmocka_unit_test(an_illum_has_its_distribution_in_all_modes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
