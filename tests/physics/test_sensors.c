/* Sensor surfaces in free space (-aps), and direct maps (-apd). */
#include "physics.h"

static const char *const plane[] = {"sheet"};

/* A job of a map of one kind, with the sheet as its sensor. */
static pm_job job_of_map(pm_map_kind kind)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    job.forward.sensors = (pm_name_list){plane, 1};
    want_map(&job, kind, 20000, 0);
    return job;
}

/* The share of a Lambertian disc's light that comes to a parallel one on the same axis
 * (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-41). */
static double disc_to_disc(double from, double to, double distance)
{
    double a = from / distance, b = to / distance, s = 1 + (1 + b * b) / (a * a);
    return (s - sqrt(s * s - 4 * (b * b) / (a * a))) / 2;
}

/* A lamp of radius .3 and radiance 3, and a sheet of radius .5 that faces it from 1 below, with
 * nothing else in the scene. */
#define LAMP_AND_SHEET(modifier)                                                               \
    "void light bright 0 0 3 3 2 1  bright ring lamp 0 0 8 0 0 1 0 0 -1 0 .3\n"                \
    "void antimatter sheet 1 void 0 0\n" modifier " ring plane 0 0 8 0 0 0 0 0 1 0 .5\n"

static void a_sensor_in_free_space_receives_the_flux_of_the_closed_form(void **state)
{
    (void)state;
    pm_job job = job_of_map(PM_MAP_DIRECT);
    double emitted = 3 * PI * PI * .09;
    struct stat flux[3] = {{0}}, middle[3] = {{0}};
    run_flux(&job, LAMP_AND_SHEET("sheet"), PM_MAP_DIRECT, (pm_vec3){0, 0, 0}, 2, flux);
    for (int c = 0; c < 3; c++)
        expect_mean("all of it", &flux[c], emitted * (3 - c) / 3 * disc_to_disc(.3, .5, 1), 0);
    /* irradiance on the axis is pi L r^2 / (r^2 + 1); to .1 aside it falls by less than 2 % */
    run_flux(&job, LAMP_AND_SHEET("sheet"), PM_MAP_DIRECT, (pm_vec3){0, 0, 0}, .1, middle);
    double axis = 3 * PI * .09 / 1.09 * PI * .01;
    expect_mean("the middle", &middle[0], axis * .99, axis * .01);
}

#define FLOOR "void plastic white 0 0 5 .9 .9 .9 0 0\nwhite ring floor 0 0 8 0 0 -1 0 0 1 0 2\n"

/* The floor's direct light is what the sheet lets through and what passes beside it. */
static void a_sensor_holds_nothing_back(void **state)
{
    (void)state;
    struct stat direct[3] = {{0}};
    pm_job job = job_of_map(PM_MAP_DIRECT);
    run_flux(&job, LAMP_AND_SHEET("sheet") FLOOR, PM_MAP_DIRECT, (pm_vec3){0, 0, -1}, 2.01,
             direct);
    expect_mean("direct", &direct[0],
                3 * PI * PI * .09 * (disc_to_disc(.3, .5, 1) + disc_to_disc(.3, 2, 2)), 0);
}

/* The light of a floor and of a wall below the sheet comes to its back, and is not stored. */
static void a_sensor_stores_nothing_from_behind(void **state)
{
    (void)state;
    pm_job job = job_of_map(PM_MAP_GLOBAL);
    job.forward.seed = 1;
    pm_answer answer;
    run_job(&job, LAMP_AND_SHEET("sheet") FLOOR "white tube wall 0 0 7 0 0 -1 0 0 -.1 2\n",
            NULL, &answer);
    const pm_photon_map *map = answer.map[PM_MAP_GLOBAL];
    assert_true(flux_within(map, (pm_vec3){0, 0, -1}, 2.5).r > .1);
    assert_true(pm_rgb_is_black(flux_within(map, (pm_vec3){0, 0, 0}, .6)));
    pm_answer_clear(&answer);
}

/* A lamp shines up into a mirror 1 above; its image is 2 above the sheet, which lies around the
 * lamp: indirect light, and a caustic. */
static void light_over_a_mirror_is_of_the_global_and_the_caustic_map(void **state)
{
    (void)state;
    static const char text[] =
        "void light bright 0 0 3 3 2 1  bright ring lamp 0 0 8 0 0 1 0 0 1 0 .3\n"
        "void metal silver 0 0 5 1 1 1 1 0  silver ring mirror 0 0 8 0 0 2 0 0 -1 0 20\n"
        "void antimatter sheet 1 void 0 0  sheet ring plane 0 0 8 0 0 1 0 0 1 1 2\n";
    double emitted = 3 * PI * PI * .09;
    double share = disc_to_disc(.3, 2, 2) - disc_to_disc(.3, 1, 2);
    const pm_map_kind kinds[] = {PM_MAP_GLOBAL, PM_MAP_CAUSTIC};
    for (int i = 0; i < 2; i++) {
        pm_job job = job_of_map(kinds[i]);
        struct stat flux[3] = {{0}};
        run_flux(&job, text, kinds[i], (pm_vec3){0, 0, 1}, 3, flux);
        expect_mean("image", &flux[0], emitted * share, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sensor_in_free_space_receives_the_flux_of_the_closed_form),
        cmocka_unit_test(a_sensor_holds_nothing_back),
        cmocka_unit_test(a_sensor_stores_nothing_from_behind),
        cmocka_unit_test(light_over_a_mirror_is_of_the_global_and_the_caustic_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
