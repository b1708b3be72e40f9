#include "sky_test.h"

static const double degrees = PM_PI / 180;

/* Perez 1993, equation 1, with the coefficients of the sky that was made. */
static double perez_sky(double height, double from_sun, const void *context)
{
    const double *k = context; /* scale, ground, a, b, c, d, e */
    double c = cos(from_sun);
    return k[0] * (1 + k[2] * exp(k[3] / fmax(height, .01))) *
           (1 + k[4] * exp(k[5] * from_sun) + k[6] * c * c);
}

static const struct made *skyfunc(const struct scene *scene)
{
    return named(scene, "skyfunc");
}

/* In units of solar radiation the sky integrates to the diffuse irradiance given: within the
 * error of the sum over Tregenza's 145 patches, below 6 % for skies without a narrow halo. */
static void assert_diffuse(double altitude, double direct, double diffuse, double tolerance)
{
    char text[100];
    snprintf(text, sizeof text, "gendaylit -ang %g 30 -W %g %g -O 1", altitude, direct,
             diffuse);
    struct scene scene = make(text);
    const double *reals = skyfunc(&scene)->reals;
    assert_near(irradiance(perez_sky, reals + 7, reals) / diffuse, 1, tolerance);
    free_scene(&scene);
}

static void the_diffuse_irradiance_is_the_one_given(void **state)
{
    (void)state;
    assert_diffuse(30, 0, 120, .06);   /* overcast */
    assert_diffuse(45, 150, 200, .06); /* between */
    assert_diffuse(60, 350, 200, .06);
    assert_diffuse(60, 850, 90, .06); /* clear */
}

static void the_sun_gives_the_direct_irradiance(void **state)
{
    (void)state;
    struct scene normal = make("gendaylit -ang 30 0 -W 600 100 -O 1");
    struct scene horizontal = make("gendaylit -ang 30 0 -G 300 100 -O 1");
    double half = .2665 * degrees, solid_angle = 2 * PM_PI * (1 - cos(half));
    assert_near(named(&normal, "solar")->reals[0] * solid_angle, 600, 600 * 5e-4);
    assert_near(named(&horizontal, "solar")->reals[0], named(&normal, "solar")->reals[0],
                600 / solid_angle * 1e-3);
    assert_near(named(&normal, "sun")->reals[3], .533, 0);
    free_scene(&normal);
    free_scene(&horizontal);
}

/* The default output is visible radiance: luminance / 179 lm/W. */
static void outputs_differ_by_the_luminous_efficacy(void **state)
{
    (void)state;
    struct scene visible = make("gendaylit -ang 40 0 -W 500 150");
    struct scene luminance = make("gendaylit -ang 40 0 -W 500 150 -O 2");
    assert_near(skyfunc(&luminance)->reals[0] / skyfunc(&visible)->reals[0], 179, 179 * 1e-3);
    free_scene(&visible);
    free_scene(&luminance);
}

/* Daylight's efficacy is near 110 lm/W: an irradiance in W/m^2 and the illuminance that belongs
 * to it make about the same sky. */
static void illuminances_are_turned_into_irradiances(void **state)
{
    (void)state;
    struct scene sky = make("gendaylit -ang 40 0 -L 50000 15000 -O 1");
    double half = .2665 * degrees, solid_angle = 2 * PM_PI * (1 - cos(half));
    assert_near(50000 / (named(&sky, "solar")->reals[0] * solid_angle), 105, 15);
    free_scene(&sky);
}

/* Perez 1990: epsilon is 1 without direct light, so there is no sun; Delta 0.1 is dull. */
static void an_overcast_sky_has_a_dark_sun(void **state)
{
    (void)state;
    struct scene sky = make("gendaylit -ang 40 0 -P 1 .1");
    assert_near(named(&sky, "solar")->reals[0], 0, 0);
    assert_true(skyfunc(&sky)->reals[0] > 0);
    struct scene none = make("gendaylit -ang 40 0 -P 1 .1 -s");
    assert_int_equal(none.count, 1);
    free_scene(&sky);
    free_scene(&none);
}

static void what_cannot_be_is_dark(void **state)
{
    (void)state;
    static const char *const dark[] = {
        "gendaylit 12 21 23 -a 47 -o -8 -m -15 -W 100 100", /* at night */
        "gendaylit -ang 40 0 -W 1400 100",                  /* more than above the air */
        "gendaylit -ang 40 0 -W 0 0",                       /* no light by day */
        "gendaylit -ang -10 0 -W 0 0 -O 1",
    };
    for (size_t i = 0; i < sizeof dark / sizeof *dark; i++) {
        struct scene sky = make(dark[i]);
        assert_int_equal(sky.count, 1);
        for (int k = 0; k < 7; k++)
            assert_near(skyfunc(&sky)->reals[k], 0, 0);
        free_scene(&sky);
    }
}

static void a_coloured_sky_is_a_colorfunc(void **state)
{
    (void)state;
    struct scene sky = make("gendaylit -ang 40 0 -W 0 150 -C");
    assert_string_equal(skyfunc(&sky)->type, "colorfunc");
    assert_int_equal(skyfunc(&sky)->real_count, 22);
    free_scene(&sky);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_diffuse_irradiance_is_the_one_given),
        cmocka_unit_test(the_sun_gives_the_direct_irradiance),
        cmocka_unit_test(outputs_differ_by_the_luminous_efficacy),
        cmocka_unit_test(illuminances_are_turned_into_irradiances),
        cmocka_unit_test(an_overcast_sky_has_a_dark_sun),
        cmocka_unit_test(what_cannot_be_is_dark),
        cmocka_unit_test(a_coloured_sky_is_a_colorfunc),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
