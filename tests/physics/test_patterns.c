/* Patterns, textures and mixtures in the balance of light. */
#include "physics.h"

enum { DIRECTIONS = 32 };

/* A wall of a sphere lights all of it evenly, so what counts is the mean of its albedo: with s
 * = mean(rho) (1 - a^2), E = Phi / (A (1 - s)) everywhere (test_sphere.c). */
#define LAMP_RADIUS .2
#define LAMP        "void light bright 0 0 3 1 1 1\nbright sphere lamp 0 0 4 0 0 0 .2\n"

static double sphere_irradiance(double albedo)
{
    const double a = LAMP_RADIUS;
    return PI * a * a / (1 - albedo * (1 - a * a));
}

static void on_the_wall(pm_sensor *sensors)
{
    for (int i = 0; i < DIRECTIONS; i++) {
        sensors[i].point = sphere_point(i, DIRECTIONS);
        sensors[i].normal = pm_vec3_negate(sensors[i].point);
    }
}

struct wall {
    const char *what, *text;
    double mean; /* albedo */
};

/* Of what is computed twice, the halves x < 0 and x > 0 have equal areas, and z / 2 + 1 / 2 is
 * 1 / 2 in the mean (Archimedes). */
static const struct wall walls[] = {
    {"brightfunc",
     "void brightfunc half 2 if(Px,.9,.3) . 0 0\n"
     "half plastic grey 0 0 5 .8 .8 .8 0 0\n",
     .48},
    {"ramp of a table",
     "void brightdata ramp 4 noop ramp.dat . Pz 0 0\nramp plastic grey 0 0 5 .8 .8 .8 0 0\n",
     .4},
    {"mixture of materials",
     "void plastic light_grey 0 0 5 .72 .72 .72 0 0\nvoid plastic dark 0 0 5 .24 .24 .24 0 0\n"
     "void mixfunc grey 4 light_grey dark if(Px,1,0) . 0 0\n",
     .48},
    {"mixture by share",
     "void plastic light_grey 0 0 5 .72 .72 .72 0 0\nvoid plastic dark 0 0 5 .24 .24 .24 0 0\n"
     "void mixfunc grey 4 light_grey dark .25 . 0 0\n",
     .36},
    {"mixture of patterns",
     "void brightfunc up 2 .9 . 0 0\nvoid brightfunc down 2 .3 . 0 0\n"
     "void mixfunc mixed 4 up down if(Pz,1,0) . 0 0\nmixed plastic grey 0 0 5 .8 .8 .8 0 0\n",
     .48},
    {"above 1", /* cut to 1 on one half; where the wall is black no photons are stored */
     "void brightfunc half 2 if(Px,7,.1) . 0 0\nhalf plastic grey 0 0 5 .8 .8 .8 0 0\n", .54},
};

static void patterned_spheres_have_the_light_of_their_mean_albedo(void **state)
{
    (void)state;
    const double direct = sphere_irradiance(0);
    pm_sensor sensors[DIRECTIONS];
    on_the_wall(sensors);
    for (size_t i = 0; i < sizeof walls / sizeof *walls; i++) {
        char *text = text_of(LAMP "%sgrey bubble wall 0 0 4 0 0 0 1\n"
                                  "#file ramp.dat\n1\n-1 1 2\n0 1\n",
                             walls[i].text);
        pm_job job = job_of(PM_JOB_TRACE, -1);
        look_at(&job, sensors, DIRECTIONS, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        got.mean -= direct;
        expect_mean(walls[i].what, &got, sphere_irradiance(walls[i].mean) - direct, 0);
        free(text);
    }
}

/* Whatever a texture does to normals, no light is made: the wall absorbs what the lamp sends,
 * so that mean irradiance * (1 - rho) is at most Phi / A. The lamp takes a share of it too. */
static void textured_spheres_make_no_light(void **state)
{
    (void)state;
    static const char *const textures[] = {
        "void texfunc bumps 4 3*sin(40*Px) 3*sin(40*Py) 3*sin(40*Pz) . 0 0\n",
        "void texfunc bumps 4 noise3x(9*Px,9*Py,9*Pz) noise3y(9*Px,9*Py,9*Pz) "
        "noise3z(9*Px,9*Py,9*Pz) . 0 0\n",
    };
    static const char *const materials[] = {
        "bumps plastic grey 0 0 5 .8 .8 .8 0 0\n",
        "bumps metal grey 0 0 5 .8 .8 .8 .9 .1\n",
        "bumps plastic grey 0 0 5 .7 .7 .7 .1 0\n",
    };
    pm_sensor sensors[DIRECTIONS];
    on_the_wall(sensors);
    for (int i = 0; i < 6; i++) {
        char *text = text_of(LAMP "%s%sgrey bubble wall 0 0 4 0 0 0 1\n", textures[i % 2],
                             materials[i / 2]);
        pm_job job = job_of(PM_JOB_TRACE, -1);
        look_at(&job, sensors, DIRECTIONS, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS / 2, GREY);
        double most = sphere_irradiance(.8);
        if (!(got.mean < most + K_SIGMA * stat_error(&got)))
            fail_msg("%d: %g above %g", i, got.mean, most);
        free(text);
    }
}

/* A sun through a pane: its pattern multiplies what passes, whatever the pattern is made of. */
static void patterns_color_what_glass_lets_through(void **state)
{
    (void)state;
    static const char *const patterns[] = {
        "void brightfunc p 2 .5 . 0 0\n",
        "void colorfunc p 4 .5+Px-Px arg(1) .5 . 0 1 .5\n",
        "void brighttext p 3 helvet.fnt . X 0 11 9 9 9 1 0 0 0 1 0 0 .5\n",
    };
    const pm_sensor sensor = {.point = {0, 0, -1}, .normal = {0, 0, 1}};
    double plain = 0;
    for (int i = -1; i < 3; i++) {
        char *text = text_of("void light sun 0 0 3 %g %g %g\nsun source s 0 0 4 .3 0 1 .1\n"
                             "%s%s glass pane 0 0 3 .9 .9 .9\n"
                             "pane polygon g 0 0 12 -5 -5 0 5 -5 0 5 5 0 -5 5 0\n",
                             sun_radiance(), sun_radiance(), sun_radiance(),
                             i < 0 ? "" : patterns[i], i < 0 ? "void" : "p");
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, &sensor, 1, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, 2, GREY);
        if (i < 0)
            plain = got.mean;
        else
            expect_near("half", got.mean, plain / 2, 0);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patterned_spheres_have_the_light_of_their_mean_albedo),
        cmocka_unit_test(textured_spheres_make_no_light),
        cmocka_unit_test(patterns_color_what_glass_lets_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
