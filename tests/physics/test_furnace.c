/* Closed rooms whose radiance is known exactly: spheres closed by a lamp, and things that
 * vanish.
 *
 * In a sphere of radius R each point of the wall sees each other with the same form factor, dA
 * / (4 pi R^2). So light that the wall scatters lights all of it evenly, and so does a lamp
 * that covers a cap. */
#include "physics.h"

/* ---- the room with a lamp for a cap ---- */

/* A disc closes the sphere z < CAP_HEIGHT; from the wall it is seen as the cap that it
 * replaces, a share f of the sphere's area (Archimedes: (R - h) / 2R). So with radiance Le in
 * the lamp the wall has direct irradiance pi Le f, of each flux it scatters 1 - f falls on
 * itself again, and E = pi Le f + rho (1 - f) E,  radiance L = rho E / pi = rho Le f / (1 - rho
 * (1 - f)): the furnace Lo / (1 - a) with Lo = rho Le f, a = rho (1 - f). */
#define CAP_HEIGHT .8
#define CAP_RADIUS .6
#define CAP_SHARE  ((1 - CAP_HEIGHT) / 2)

static char *furnace(double albedo)
{
    return text_of("void light bright 0 0 3 1 1 1\n"
                   "bright ring cap 0 0 8 0 0 %.17g 0 0 -1 0 %.17g\n"
                   "void plastic grey 0 0 5 %.17g %.17g %.17g 0 0\n"
                   "grey sphere wall 0 0 4 0 0 0 1\n",
                   CAP_HEIGHT, CAP_RADIUS, albedo, albedo, albedo);
}

static double furnace_radiance(double albedo, double bounces_share)
{
    return albedo * CAP_SHARE / (1 - bounces_share * albedo * (1 - CAP_SHARE));
}

/* Directions from the middle, or points of the wall, evenly spread by the golden angle over
 * z < 1/2: out of reach of the cap's rim at
 * .8, for look-ups narrower than .3. */
enum { DIRECTIONS = 32 };

static void spread(pm_sensor sensors[DIRECTIONS], bool on_wall)
{
    for (int i = 0; i < DIRECTIONS; i++) {
        double z = .5 - 1.5 * (i + .5) / DIRECTIONS, phi = 2.399963229728653 * i;
        double r = sqrt(1 - z * z);
        pm_vec3 d = {r * cos(phi), r * sin(phi), z};
        sensors[i].point = on_wall ? d : (pm_vec3){0, 0, 0};
        sensors[i].normal = on_wall ? pm_vec3_negate(d) : d;
    }
}

static const double albedos[] = {.5, .9, .99};

/* Long paths are dear. Of 8 seeds 5 standard errors are exceeded with probability 1.6e-3. */
static const unsigned seeds[] = {SEEDS, SEEDS, SEEDS / 2};

/* The chord of radius r cuts a cap of area pi r^2 exactly from a sphere, so the flat kernel has
 * no bias on a curved wall. */
static void furnace_radiance_by_progressive_passes(void **state)
{
    (void)state;
    pm_sensor sensors[DIRECTIONS];
    spread(sensors, false);
    for (int i = 0; i < 3; i++) {
        char *text = furnace(albedos[i]);
        pm_job job = job_of(PM_JOB_TRACE, -1);
        look_at(&job, sensors, DIRECTIONS, PM_RADIANCE);
        struct stat got = run_mean(&job, text, seeds[i], GREY);
        expect_mean("progressive", &got, furnace_radiance(albedos[i], 1), 0);
        free(text);
    }
}

enum { PHOTONS = 60000, GATHER = 60 };

static pm_job map_job(int ambient_bounces, const pm_sensor *sensors)
{
    pm_job job = job_of(PM_JOB_TRACE, ambient_bounces);
    want_map(&job, PM_MAP_GLOBAL, PHOTONS, GATHER);
    look_at(&job, sensors, DIRECTIONS, PM_RADIANCE);
    job.passes = 4;
    return job;
}

/* A gather ray may end near the cap's rim, where no photons lie on one side. Within a distance
 * d < r of a straight edge the disc of radius r misses the share (acos x - x sqrt(1 - x^2)) /
 * pi of its area, x = d / r: 2 / (3 pi) = .2122 on average. N photons spread over 4 pi have K
 * in a disc of radius r = 2 sqrt(K / N); at the edge itself K + 1 photons need up to sqrt(2)
 * times as much. Of all gather rays the strip of that width along the rim gets (2 pi CAP_RADIUS
 * sqrt(2) r) / (4 pi), so the loss is less than .2122 CAP_RADIUS r / sqrt(2) of what photons
 * bring. */
static double rim_loss(void)
{
    double radius = 2 * sqrt((double)GATHER / PHOTONS);
    return 2 / (3 * PI) * CAP_RADIUS * radius / sqrt(2);
}

/* With the map at the eye and behind gather rays; both share each seed's photons. */
static void furnace_radiance_by_maps(void **state)
{
    (void)state;
    pm_sensor sensors[DIRECTIONS];
    spread(sensors, false);
    for (int i = 0; i < 3; i++) {
        char *text = furnace(albedos[i]);
        double want = furnace_radiance(albedos[i], 1);
        struct stat eye = {0}, gather = {0};
        for (unsigned seed = 1; seed <= seeds[i]; seed++) {
            struct store store = {0};
            pm_job_hooks hooks = store_hooks(&store);
            for (int bounces = -1; bounces <= 1; bounces += 2) {
                pm_job job = map_job(bounces, sensors);
                pm_answer answer;
                job.forward.seed = seed;
                run_job(&job, text, &hooks, &answer);
                stat_add(bounces < 0 ? &eye : &gather, sensor_mean(&answer, DIRECTIONS, GREY));
                pm_answer_clear(&answer);
            }
            store_clear(&store);
        }
        expect_mean("-ab -1", &eye, want, 0);
        expect_mean("-ab 1", &gather, want, rim_loss() * want);
        free(text);
    }
}

/* -ab 0 leaves out all light between diffuse surfaces: L = rho Le f. */
static void furnace_direct_radiance_without_ambient(void **state)
{
    (void)state;
    pm_sensor sensors[DIRECTIONS];
    spread(sensors, false);
    for (int i = 0; i < 3; i++) {
        char *text = furnace(albedos[i]);
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, sensors, DIRECTIONS, PM_RADIANCE);
        job.passes = 64;
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_mean("-ab 0", &got, furnace_radiance(albedos[i], 0), 0);
        free(text);
    }
}

/* Sensors that lie on the wall give its irradiance; one in free space sees the wall's even
 * radiance from all its hemisphere but for the lamp, if that is behind it. */
static void furnace_irradiance_on_the_wall_and_in_the_middle(void **state)
{
    (void)state;
    pm_sensor sensors[DIRECTIONS];
    char *text = furnace(.5);
    double radiance = furnace_radiance(.5, 1);
    spread(sensors, true);
    pm_job job = job_of(PM_JOB_TRACE, -1);
    look_at(&job, sensors, DIRECTIONS, PM_IRRADIANCE);
    struct stat wall = run_mean(&job, text, SEEDS, GREY);
    expect_mean("wall", &wall, PI * radiance / .5, 0);
    pm_sensor middle[16];
    for (int i = 0; i < 16; i++)
        middle[i] = (pm_sensor){{0, 0, 0}, {0, 0, -1}};
    look_at(&job, middle, 16, PM_IRRADIANCE);
    struct stat free_space = run_mean(&job, text, SEEDS, GREY);
    expect_mean("free space", &free_space, PI * radiance, 0);
    free(text);
}

/* ---- a wall by a function ---- */

#define CAL "\n#file f.cal\neven(x,y,z,w) = 1/PI;\n"

/* A function that says what a Lambertian wall does gives what that gives: photons are stored on
 * it, weighed by it, scattered and gathered by it. */
static void furnace_of_a_function_is_that_of_its_values(void **state)
{
    (void)state;
    pm_sensor sensors[DIRECTIONS];
    spread(sensors, false);
    char *text = text_of("void light bright 0 0 3 1 1 1\n"
                         "bright ring cap 0 0 8 0 0 %.17g 0 0 -1 0 %.17g\n"
                         "void metfunc grey 2 even f.cal 0 4 .5 .5 .5 .8\n"
                         "grey sphere wall 0 0 4 0 0 0 1" CAL,
                         CAP_HEIGHT, CAP_RADIUS);
    double want = furnace_radiance(.5, 1);
    pm_job job = job_of(PM_JOB_TRACE, -1);
    look_at(&job, sensors, DIRECTIONS, PM_RADIANCE);
    struct stat progressive = run_mean(&job, text, SEEDS, GREY);
    expect_mean("progressive", &progressive, want, 0);
    job = map_job(1, sensors);
    struct stat gathered = run_mean(&job, text, SEEDS, GREY);
    expect_mean("-ab 1", &gathered, want, rim_loss() * want);
    free(text);
}

/* ---- objects that vanish ---- */

/* Under an even sky of radiance 1 everything lossless has radiance 1, whatever its shape and
 * lobes. Alone, no photon is needed. */
static void lossless_objects_vanish_in_an_even_sky(void **state)
{
    (void)state;
    static const char *const objects[] = {
        "void mirror m 0 0 3 1 1 1  m sphere s 0 0 4 0 0 0 1\n",
        "void dielectric d 0 0 5 1 1 1 1.5 0  d sphere s 0 0 4 0 0 0 1\n",
        "void plastic p 0 0 5 1 1 1 0 0  p sphere s 0 0 4 0 0 0 1\n",
        "void metal p 0 0 5 1 1 1 1 0  p sphere s 0 0 4 0 0 0 1\n",
        "void glass g 0 0 3 1 1 1  g polygon s 0 0 9 -1 -1 0 1 -1 0 0 1 0\n",
        "void trans t 0 0 7 1 1 1 0 0 .5 .4  t ring s 0 0 8 0 0 0 0 0 1 0 1\n",
        "void interface i 0 0 8 1 1 1 1.5 1 1 1 1.33  i sphere s 0 0 4 0 0 0 1\n",
        "void prism2 p 9 .4 Dx -Dy -Dz .6 Dy -Dx Dz . 0 0  p ring s 0 0 8 0 0 0 0 0 1 0 1\n",
        "void BRTDfunc b 10 Rdot^2 .3 0 1-Rdot^2 .7 1 0 0 0 . 0 9 0 0 0 0 0 0 0 0 0\n"
        "b sphere s 0 0 4 0 0 0 1\n",
        "void transfunc t 2 even f.cal 0 6 1 1 1 .3 .5 .4  t ring s 0 0 8 0 0 0 0 0 1 0 1\n",
        "void texfunc w 4 .2*sin(9*Px) .1*Pz 0 . 0 0\n"
        "w dielectric d 0 0 5 1 1 1 1.5 0  d sphere s 0 0 4 0 0 0 1\n",
        "void metal m 0 0 5 1 1 1 1 0  void mixfunc x 4 m void .5+.5*sin(9*Px) . 0 0\n"
        "x sphere s 0 0 4 0 0 0 1\n",
    };
    pm_sensor sensors[32];
    for (int i = 0; i < 32; i++) {
        pm_vec3 from = {.3, 3 * sin(i), 3 * cos(i)};
        sensors[i] = (pm_sensor){from, pm_vec3_negate(from)};
        sensors[i].normal.x = .01 * i - .3;
    }
    for (size_t i = 0; i < sizeof objects / sizeof *objects; i++) {
        char *text = text_of("void light l 0 0 3 1 1 1  l source sky 0 0 4 0 0 1 360\n%s" CAL,
                             objects[i]);
        pm_job job = job_of(PM_JOB_TRACE, 0);
        look_at(&job, sensors, 32, PM_RADIANCE);
        job.passes = 256;
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_mean(objects[i], &got, 1, 0);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace_radiance_by_progressive_passes),
        cmocka_unit_test(furnace_radiance_by_maps),
        cmocka_unit_test(furnace_direct_radiance_without_ambient),
        cmocka_unit_test(furnace_irradiance_on_the_wall_and_in_the_middle),
        cmocka_unit_test(furnace_of_a_function_is_that_of_its_values),
        cmocka_unit_test(lossless_objects_vanish_in_an_even_sky),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
