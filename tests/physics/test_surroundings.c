/* What is said about all of a scene beside its files: a medium that fills it, back faces. */
#include "physics.h"

/* Two glowing rings, 4 apart: the medium fills a cube of half width 2.02 about the origin. */
#define RINGS                                                                                  \
    "void glow wall 0 0 4 1 1 1 0  wall ring east 0 0 8 2 0 0 -1 0 0 0 1\n"                    \
    "wall ring west 0 0 8 -2 0 0 1 0 0 0 1\n"

/* The same extents of black walls. */
#define BLOCKS                                                                                 \
    "void plastic black 0 0 5 0 0 0 0 0  black ring east 0 0 8 2 0 0 -1 0 0 0 1\n"             \
    "black ring west 0 0 8 -2 0 0 1 0 0 0 1\n"

static const double half_width = 2.02;

static pm_surroundings medium(double red, double green, double albedo)
{
    return (pm_surroundings){.extinction = {red, green, 0}, .albedo = {albedo, albedo, albedo}};
}

/* From within, from outside the cube, and out of it to a sky. */
static void rays_are_attenuated_over_their_way_through_the_medium(void **state)
{
    (void)state;
    static const char text[] = RINGS "wall source sky 0 0 4 0 0 1 60\n";
    const pm_sensor rays[] = {{{-1, 0, 0}, {1, 0, 0}},
                              {{-6, 3, 0}, {.8, -.3, 0}}, /* to (2, 0, 0) */
                              {{0, .5, -1}, {0, 0, 1}},
                              {{0, 0, 5}, {0, 0, 1}}};
    double slope = hypot(.8, .3) / .8;
    const double ways[] = {3, (2 + half_width) * slope, half_width + 1, 0};
    pm_job job = job_of(PM_JOB_TRACE, -1);
    job.surroundings = medium(.5, 2, 0);
    look_at(&job, rays, 4, PM_RADIANCE);
    pm_answer answer;
    run_job(&job, text, NULL, &answer);
    for (int i = 0; i < 4; i++) {
        expect_near("red", (double)answer.values[3 * i], exp(-.5 * ways[i]), 0);
        expect_near("green", (double)answer.values[3 * i + 1], exp(-2 * ways[i]), 0);
        expect_near("blue", (double)answer.values[3 * i + 2], 1, 0);
    }
    pm_answer_clear(&answer);
}

/* A sun comes in where the cube ends, 2.02 above the sensor. */
static void a_sun_shines_in_from_where_the_medium_ends(void **state)
{
    (void)state;
    char *text = text_of(BLOCKS "void light sun 0 0 3 %.17g %.17g %.17g\n"
                                "sun source s 0 0 4 0 0 1 .1\n",
                         sun_radiance(), sun_radiance(), sun_radiance());
    pm_sensor sensor = {{0, .5, 0}, {0, 0, 1}};
    pm_job job = job_of(PM_JOB_TRACE, 0);
    job.surroundings = medium(.5, 2, 0);
    look_at(&job, &sensor, 1, PM_IRRADIANCE);
    pm_answer answer;
    run_job(&job, text, NULL, &answer);
    /* the sun's rim is tilted by .05 degrees: cosines and lengths change by 4e-7 */
    expect_near("red", (double)answer.values[0], exp(-.5 * half_width), 1e-5);
    expect_near("green", (double)answer.values[1], exp(-2 * half_width), 1e-5);
    expect_near("blue", (double)answer.values[2], 1, 1e-5);
    pm_answer_clear(&answer);
    free(text);
}

/* A tiny lamp in a black bubble of radius 1: of its light 1 - exp(-extinction) collides once on
 * its straight way, and next to nothing again. The way from the lamp's surface to the bubble
 * is .98 to 1 long. */
static void volume_photons_lie_where_light_collides(void **state)
{
    (void)state;
    static const char text[] =
        "void light bright 0 0 3 1 1 1  bright sphere lamp 0 0 4 0 0 0 .02\n"
        "void plastic black 0 0 5 0 0 0 0 0  black bubble wall 0 0 4 0 0 0 1\n";
    const double extinctions[] = {.5, 2};
    double power = PI * 4 * PI * .02 * .02;
    for (int i = 0; i < 2; i++) {
        double x = extinctions[i];
        pm_job job = job_of(PM_JOB_MAP, -1);
        job.surroundings =
            (pm_surroundings){.extinction = {x, x, x}, .albedo = {1e-6, 1e-6, 1e-6}};
        want_map(&job, PM_MAP_VOLUME, 20000, 0);
        struct stat flux[3] = {{0}};
        run_flux(&job, text, PM_MAP_VOLUME, (pm_vec3){0, 0, 0}, 2, flux);
        double shortest = 1 - exp(-.98 * x), longest = 1 - exp(-x);
        expect_mean("collided", &flux[1], power * (shortest + longest) / 2,
                    power * (longest - shortest) / 2);
    }
}

/* ---- back faces ---- */

/* A room of albedo 1/2 whose walls face inwards, with a lamp in it, under a sun. */
static char *room_under_sun(void)
{
    return text_of("void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
                   "void glow panel 0 0 4 3 3 3 0\n"
                   "panel ring lamp 0 0 8 0 0 .999 0 0 -1 0 .1\n"
                   "void plastic grey 0 0 5 .5 .5 .5 0 0\n" BOX("grey"),
                   sun_radiance(), sun_radiance(), sun_radiance());
}

/* From above one sees the roof under the sun, .5 / pi, or else the floor, which is darker. From
 * below the floor is a roof in the dark, or one sees the lamp. */
static void backs_that_are_hidden_let_one_look_in(void **state)
{
    (void)state;
    char *text = room_under_sun();
    const pm_sensor rays[] = {{{.5, .5, 3}, {0, 0, -1}}, {{0, 0, -3}, {0, 0, 1}}};
    for (int hidden = 0; hidden < 2; hidden++) {
        pm_job job = job_of(PM_JOB_TRACE, 0);
        job.surroundings.no_back_faces = hidden;
        struct stat stats[6] = {{0}};
        look_at(&job, rays, 2, PM_RADIANCE);
        run_seeds(&job, text, SEEDS, stats);
        if (hidden)
            assert_true(stats[1].mean < .25 / PI);
        else
            expect_mean("roof", &stats[1], .5 / PI, 1e-5);
        expect_mean("lamp", &stats[4], 3 * hidden, 0);
    }
    free(text);
}

/* What comes to a sensor from outside passes backs, what leaves the room meets fronts: a shadow
 * ray from the floor to the sun ends at the ceiling, one from below the floor to the lamp does
 * not. */
static void backs_that_are_hidden_let_shadow_rays_in_and_none_out(void **state)
{
    (void)state;
    char *text = room_under_sun();
    const pm_sensor sensors[] = {{{.5, .5, -.5}, {0, 0, 1}}, {{0, 0, -3}, {0, 0, 1}}};
    double lamp = 3 * PI * .01 / (.01 + 3.999 * 3.999); /* Lambertian disc on its axis */
    for (int hidden = 0; hidden < 2; hidden++) {
        struct stat stats[6] = {{0}};
        pm_job job = job_of(PM_JOB_TRACE, 0);
        job.surroundings.no_back_faces = hidden;
        look_at(&job, sensors, 2, PM_IRRADIANCE);
        run_seeds(&job, text, SEEDS, stats);
        assert_true(stats[1].mean < .1);
        expect_mean("lamp through the floor's back", &stats[4], hidden * lamp, 0);
    }
    free(text);
}

/* The room's photons are those of its lamp in either case, as the sun's end outside. */
static void backs_that_are_hidden_stop_photons(void **state)
{
    (void)state;
    char *text = room_under_sun();
    double lamp = 3 * PI * PI * .01;
    for (int hidden = 0; hidden < 2; hidden++) {
        pm_job job = job_of(PM_JOB_MAP, -1);
        job.surroundings.no_back_faces = hidden;
        want_map(&job, PM_MAP_GLOBAL, 20000, 0);
        struct stat flux[3] = {{0}};
        run_flux(&job, text, PM_MAP_GLOBAL, (pm_vec3){0, 0, 0}, 2, flux);
        expect_mean("indirect", &flux[1], lamp,
                    .01 * lamp); /* 1/2 + 1/4 + ...; a lamp absorbs */
    }
    free(text);
}

/* ---- identity ---- */

static pm_digest scene_of(const char *text, pm_surroundings surroundings)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    job.surroundings = surroundings;
    want_map(&job, PM_MAP_GLOBAL, 10, 0);
    pm_answer answer;
    run_job(&job, text, NULL, &answer);
    pm_digest scene = answer.scene;
    pm_answer_clear(&answer);
    return scene;
}

static void each_surrounding_makes_another_scene(void **state)
{
    (void)state;
    const pm_surroundings all[] = {
        {.no_back_faces = false},
        {.no_back_faces = true},
        {.extinction = {1, 1, 1}},
        {.extinction = {1, 1, 2}},
        {.extinction = {1, 1, 1}, .albedo = {.5, .5, .5}},
        {.extinction = {1, 1, 1}, .albedo = {.5, .5, .5}, .eccentricity = .5}};
    pm_digest scenes[6];
    for (int i = 0; i < 6; i++) {
        scenes[i] = scene_of(EVEN_SPHERE, all[i]);
        for (int j = 0; j < i; j++)
            assert_false(pm_digest_equal(&scenes[i], &scenes[j]));
        pm_digest again = scene_of("# the same\n" EVEN_SPHERE, all[i]);
        assert_true(pm_digest_equal(&scenes[i], &again));
    }
}

/* ---- refusals ---- */

static void assert_refused(const char *text, pm_surroundings surroundings, const char *why)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    job.surroundings = surroundings;
    job.main_name = "scene.rad";
    pm_error err = PM_ERROR_INIT;
    pm_answer answer;
    pm_bundle *bundle = pm_bundle_new();
    assert_int_equal(pm_bundle_add(bundle, "scene.rad", text, strlen(text), NULL), PM_OK);
    want_map(&job, PM_MAP_GLOBAL, 10, 0);
    assert_int_equal(pm_job_run(&job, bundle, NULL, &answer, &err), PM_E_RANGE);
    if (!strstr(err.text, why))
        fail_msg("%s", err.text);
    pm_bundle_free(bundle);
}

static void surroundings_out_of_range_are_refused(void **state)
{
    (void)state;
    assert_refused(EVEN_SPHERE, (pm_surroundings){.extinction = {1, -1, 1}}, "-me 1 -1 1");
    assert_refused(EVEN_SPHERE, (pm_surroundings){.extinction = {1, NAN, 1}}, "an extinction");
    assert_refused(EVEN_SPHERE, (pm_surroundings){.extinction = {1, INFINITY, 1}},
                   "an extinction");
    assert_refused(EVEN_SPHERE, (pm_surroundings){.extinction = {1, 1, 1}, .albedo = {0, 2, 0}},
                   "an albedo");
    assert_refused(EVEN_SPHERE, (pm_surroundings){.extinction = {1, 1, 1}, .eccentricity = -1},
                   "an eccentricity");
    assert_refused(EVEN_SPHERE, (pm_surroundings){.eccentricity = .5},
                   "without its extinction");
    assert_refused("void light sun 0 0 3 1 1 1  sun source s 0 0 4 0 0 1 .1\n",
                   (pm_surroundings){.extinction = {1, 1, 1}}, "the scene has none");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_are_attenuated_over_their_way_through_the_medium),
        cmocka_unit_test(a_sun_shines_in_from_where_the_medium_ends),
        cmocka_unit_test(volume_photons_lie_where_light_collides),
        cmocka_unit_test(backs_that_are_hidden_let_one_look_in),
        cmocka_unit_test(backs_that_are_hidden_let_shadow_rays_in_and_none_out),
        cmocka_unit_test(backs_that_are_hidden_stop_photons),
        cmocka_unit_test(each_surrounding_makes_another_scene),
        cmocka_unit_test(surroundings_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
