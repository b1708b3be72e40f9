/* The same scene in another unit or another place: the same irradiance and radiance, and flux
 * in proportion to area. A mist's extinction is per unit of length. */
#include "physics.h"

struct place {
    const char *name;
    double scale;
    pm_vec3 offset; /* of the scaled scene */
};

static const struct place home = {"home", 1, {0, 0, 0}};
static const struct place places[] = {
    {"scale 1e-6", 1e-6, {0, 0, 0}},
    {"scale 1e6", 1e6, {0, 0, 0}},
    {"a million sizes away", 1, {1e6, -1e6, 1e6}},
    {"a million sizes away at scale 1e-6", 1e-6, {1, 1, -1}},
};

enum { PLACES = sizeof places / sizeof *places };

static pm_vec3 at(const struct place *place, double x, double y, double z)
{
    return pm_vec3_madd(place->offset, place->scale, (pm_vec3){x, y, z});
}

/* A glass ball in thin fog between a lamp, a floor and a wall. */
static char *scene_at(const struct place *place)
{
    double s = place->scale, extinction = .2 / s;
    pm_vec3 lamp = at(place, .2, 0, 1.9), ball = at(place, 0, 0, .6), fog = at(place, 0, 0, 1),
            floor = at(place, 0, 0, 0), a = at(place, -1, 1, 0), b = at(place, 1, 1, 0),
            c = at(place, 1, 1, 2), d = at(place, -1, 1, 2);
    return text_of("void light bright 0 0 3 9 8 7\n"
                   "bright ring lamp 0 0 8 %.17g %.17g %.17g 0 0 -1 0 %.17g\n"
                   "void dielectric clear 0 0 5 1 1 1 1.5 0\n"
                   "clear sphere ball 0 0 4 %.17g %.17g %.17g %.17g\n"
                   "void mist fog 0 0 7 %.17g %.17g %.17g .8 .5 .2 .3\n"
                   "fog sphere cloud 0 0 4 %.17g %.17g %.17g %.17g\n"
                   "void plastic grey 0 0 5 .5 .4 .3 0 0\n"
                   "grey ring floor 0 0 8 %.17g %.17g %.17g 0 0 1 0 %.17g\n"
                   "grey polygon wall 0 0 12 %.17g %.17g %.17g %.17g %.17g %.17g\n"
                   "%.17g %.17g %.17g %.17g %.17g %.17g\n",
                   lamp.x, lamp.y, lamp.z, .25 * s, ball.x, ball.y, ball.z, .4 * s, extinction,
                   extinction, extinction, fog.x, fog.y, fog.z, 2 * s, floor.x, floor.y,
                   floor.z, 1.5 * s, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y,
                   d.z);
}

/* ---- what is compared ---- */

enum {
    FLOOR_POINTS = 8,
    WALL_POINTS = 4,
    SENSORS = FLOOR_POINTS + WALL_POINTS,
    RAYS = 8,
    PHOTONS = 2000,
    RUNS = 12
};

struct measured {
    struct stat flux[3]; /* of the caustic's middle [W / scale^2] */
    struct stat irradiance[3 * SENSORS];
    struct stat radiance[3 * RAYS];
};

static void measure(const struct place *place, struct measured *out)
{
    double s = place->scale;
    char *text = scene_at(place);
    pm_sensor sensors[SENSORS], rays[RAYS];
    for (int i = 0; i < FLOOR_POINTS; i++) /* from the caustic's middle outwards */
        sensors[i] = (pm_sensor){at(place, .1 * i - .1, .03 * i, 0), {0, 0, 1}};
    for (int i = 0; i < WALL_POINTS; i++)
        sensors[FLOOR_POINTS + i] =
            (pm_sensor){at(place, .3 * i - .5, 1, .4 + .2 * i), {0, -1, 0}};
    for (int i = 0; i < RAYS; i++) /* past the ball and through it, to floor and wall */
        rays[i] = (pm_sensor){at(place, .2 * i - .7, -1.5, 1.4), {0, 1, -.1 * i}};
    memset(out, 0, sizeof *out);

    pm_job job = job_of(PM_JOB_MAP, -1);
    want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 40);
    run_flux(&job, text, PM_MAP_CAUSTIC, at(place, -.08, 0, 0), .3 * s, out->flux);
    for (int c = 0; c < 3; c++) {
        out->flux[c].mean /= s * s;
        out->flux[c].squares /= s * s * s * s;
    }
    job = job_of(PM_JOB_TRACE, -1);
    look_at(&job, sensors, SENSORS, PM_IRRADIANCE);
    run_seeds(&job, text, RUNS, out->irradiance);
    look_at(&job, rays, RAYS, PM_RADIANCE);
    run_seeds(&job, text, RUNS, out->radiance);
    free(text);
}

static void expect_same(const char *where, const char *what, const struct stat *got,
                        const struct stat *want, int count)
{
    for (int i = 0; i < count; i++) {
        char name[100];
        snprintf(name, sizeof name, "%s: %s %d, channel %d", where, what, i / 3, i % 3);
        assert_true(want[i].mean > 0);
        expect_equal_means(name, &got[i], want[i].mean, stat_error(&want[i]), 0);
    }
}

static void answers_do_not_depend_on_unit_and_place(void **state)
{
    (void)state;
    static struct measured want, got;
    measure(&home, &want);
    for (int i = 0; i < PLACES; i++) {
        measure(&places[i], &got);
        expect_same(places[i].name, "flux", got.flux, want.flux, 3);
        expect_same(places[i].name, "sensor", got.irradiance, want.irradiance, 3 * SENSORS);
        expect_same(places[i].name, "ray", got.radiance, want.radiance, 3 * RAYS);
    }
}

/* The comparison is with the truth, too: the reference's flux in the same disc. A map that ends
 * with photon N is off by 1 / N. */
static void caustic_of_the_unscaled_scene_is_the_references(void **state)
{
    (void)state;
    char *text = scene_at(&home);
    pm_sensor middle = {{-.08, 0, 0}, {0, 0, 1}};
    struct ref_result want = reference_irradiance(text, &middle, .3, 1 << 18);
    pm_job job = job_of(PM_JOB_MAP, -1);
    struct stat got[3];
    want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 40);
    run_flux(&job, text, PM_MAP_CAUSTIC, middle.point, .3, got);
    double area = PI * .3 * .3;
    for (int c = 0; c < 3; c++)
        expect_equal_means("flux", &got[c], area * want.mean[REF_CAUSTIC][c],
                           area * want.standard_error[REF_CAUSTIC][c],
                           area * want.mean[REF_CAUSTIC][c] / PHOTONS);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_do_not_depend_on_unit_and_place),
        cmocka_unit_test(caustic_of_the_unscaled_scene_is_the_references),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
