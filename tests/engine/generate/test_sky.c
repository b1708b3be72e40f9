#include "sky_test.h"

static const double degrees = PM_PI / 180;

/* Half of the last of three digits. */
static const double three_digits = 0.005;

/* CIE standard clear sky (CIE S 003, 1996), by its zenith. */
static double clear_sky(double height, double from_sun, const void *context)
{
    double sun = *(const double *)context, z = PM_PI / 2 - sun;
    double indicatrix = .91 + 10 * exp(-3 * from_sun) + .45 * pow(cos(from_sun), 2);
    double zenith = .91 + 10 * exp(-3 * z) + .45 * pow(cos(z), 2);
    return indicatrix * (1 - exp(-.32 / height)) / (zenith * (1 - exp(-.32)));
}

/* Matsuura and Iwata, "A model of daylight source for the daylight illuminance calculations on
 * the all weather conditions", 1990, by its zenith. */
static double intermediate_value(double height, double from_sun, double sun)
{
    double h = asin(height);
    return ((1.35 * sin(3.59 * h - .009) + 3.12) * sin(2.6 * sun + .312) + h + 4.799) / 2.326 *
           exp(-from_sun * .563 * ((sun - .008) * (h + 1.059) + .812));
}

static double intermediate_sky(double height, double from_sun, const void *context)
{
    double sun = *(const double *)context;
    return intermediate_value(height, from_sun, sun) /
           intermediate_value(1, PM_PI / 2 - sun, sun);
}

static const struct made *skyfunc(const struct scene *scene)
{
    return named(scene, "skyfunc");
}

/* The irradiance asked for by -B comes from a sky with this zenith: the polynomials that stand
 * for its integral are within 2 %. */
static void assert_diffuse(const char *kind, double altitude, sky_radiance *sky)
{
    char text[100];
    double sun[3] = {0, -cos(altitude * degrees), sin(altitude * degrees)};
    double radians = altitude * degrees;
    snprintf(text, sizeof text, "gensky -ang %g 0 %s -B 100", altitude, kind);
    struct scene scene = make(text);
    double got = skyfunc(&scene)->reals[1] * irradiance(sky, sun, &radians);
    assert_near(got, 100, 2);
    free_scene(&scene);
}

static void the_diffuse_irradiance_is_what_was_asked_for(void **state)
{
    (void)state;
    static const double altitudes[] = {15, 30, 45, 60, 75};
    for (int i = 0; i < 5; i++) {
        assert_diffuse("-s", altitudes[i], clear_sky);
        assert_diffuse("-i", altitudes[i], intermediate_sky);
    }
}

/* An overcast sky gives 7/9 pi of its zenith, a uniform one pi. */
static void overcast_skies_have_their_analytic_irradiance(void **state)
{
    (void)state;
    struct scene overcast = make("gensky -ang 40 0 -c -B 100");
    struct scene uniform = make("gensky -ang 40 0 -u -B 100 -g .5");
    assert_near(skyfunc(&overcast)->reals[1] * 7 / 9 * PM_PI, 100, 100 * three_digits);
    assert_near(skyfunc(&uniform)->reals[1] * PM_PI, 100, 100 * three_digits);
    assert_near(skyfunc(&uniform)->reals[2], .5 * 100 / PM_PI, 16 * three_digits);
    assert_int_equal(overcast.count, 1);
    free_scene(&overcast);
    free_scene(&uniform);
}

/* Zenith luminance of the overcast sky, Krochmann and Seidl 1974: 0.123 + 8.6 sin(altitude)
 * kcd/m^2; of the clear sky, Dogniaux 1967: (1.376 T - 1.81) tan(altitude) + 0.38. */
static void zenith_luminances_are_the_published_ones(void **state)
{
    (void)state;
    for (int altitude = 10; altitude <= 70; altitude += 20) {
        char text[100];
        double a = altitude * degrees;
        snprintf(text, sizeof text, "gensky -ang %d 0 -c", altitude);
        struct scene overcast = make(text);
        snprintf(text, sizeof text, "gensky -ang %d 0 -s -t 4", altitude);
        struct scene clear = make(text);
        double kcd = 203. / 1000, dull = .123 + 8.6 * sin(a);
        double bright = (1.376 * 4 - 1.81) * tan(a) + .38;
        assert_near(skyfunc(&overcast)->reals[1] * kcd, dull, dull * three_digits);
        assert_near(skyfunc(&clear)->reals[1] * kcd, bright, bright * three_digits);
        free_scene(&overcast);
        free_scene(&clear);
    }
}

static void the_sun_gives_the_irradiance_asked_for(void **state)
{
    (void)state;
    struct scene sky = make("gensky -ang 40 25 +s -R 350");
    const struct made *solar = named(&sky, "solar"), *sun = named(&sky, "sun");
    double half = .25 * degrees, solid_angle = PM_PI * sin(half) * sin(half);
    /* Radiance counts 6e-5 sr, which is 0.4 % more than it is. */
    assert_near(solar->reals[0] * solid_angle * sun->reals[2], 350,
                350 * (.005 + three_digits));
    assert_near(length(sun->reals), 1, 1e-6);
    assert_near(sun->reals[2], sin(40 * degrees), 1e-6);
    assert_near(sun->reals[0] / sun->reals[1], tan(25 * degrees), 1e-5);
    free_scene(&sky);
}

/* The same instant in four ways. */
static void hours_know_time_zones(void **state)
{
    (void)state;
    static const char *const same[] = {
        "gensky 9 21 14.5CEST -a 47 -o -8", "gensky 9 21 14:30cest -a 47 -o -8 -m 0",
        "gensky 9 21 14.5 -a 47 -o -8 -m -30", "gensky 9 21 13:30CET -a 47 -o -8"};
    struct scene first = make(same[0]);
    for (int i = 1; i < 4; i++) {
        struct scene scene = make(same[i]);
        for (int k = 0; k < 3; k++)
            assert_near(named(&scene, "sun")->reals[k], named(&first, "sun")->reals[k], 1e-6);
        free_scene(&scene);
    }
    free_scene(&first);
}

static void at_night_there_is_no_sun(void **state)
{
    (void)state;
    struct scene sky = make("gensky 12 21 23 -a 47 -o -8 -m -15");
    assert_int_equal(sky.count, 1);
    assert_near(skyfunc(&sky)->reals[1], 0, 0);
    free_scene(&sky);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    assert_refused("gensky 6 21 12:75", PM_E_SYNTAX, 3,
                   "gensky: '12:75' is no hour; write 14.5, 14:30, 14.5EST, or +14.5 for solar "
                   "time");
    assert_refused("gensky 6 21", PM_E_SYNTAX, 2,
                   "gensky: the hour is missing; it should come after the day");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_diffuse_irradiance_is_what_was_asked_for),
        cmocka_unit_test(overcast_skies_have_their_analytic_irradiance),
        cmocka_unit_test(zenith_luminances_are_the_published_ones),
        cmocka_unit_test(the_sun_gives_the_irradiance_asked_for),
        cmocka_unit_test(hours_know_time_zones),
        cmocka_unit_test(at_night_there_is_no_sun),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
