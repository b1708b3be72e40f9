/* Density estimation where the irradiance is known, and how its error falls. */
#include "physics.h"

/* ---- a floor in even light ---- */

/* A sun 1 at the zenith above a clear slab: the floor has irradiance (1 - f) / (1 + f), f = .04
 * the reflectance of one face, all of it specular light. The floor reflects .001. */
#define FLOOR_IRRADIANCE (.96 / 1.04)

#define SLAB_OVER_FLOOR                                                                        \
    "void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"                    \
    "void dielectric clear 0 0 5 1 1 1 1.5 0\n"                                                \
    "clear polygon top 0 0 12 -1.1 -1.1 .04 1.1 -1.1 .04 1.1 1.1 .04 -1.1 1.1 .04\n"           \
    "clear polygon low 0 0 12 -1.1 -1.1 .02 -1.1 1.1 .02 1.1 1.1 .02 1.1 -1.1 .02\n"           \
    "clear polygon south 0 0 12 -1.1 -1.1 .02 1.1 -1.1 .02 1.1 -1.1 .04 -1.1 -1.1 .04\n"       \
    "clear polygon north 0 0 12 -1.1 1.1 .02 -1.1 1.1 .04 1.1 1.1 .04 1.1 1.1 .02\n"           \
    "clear polygon west 0 0 12 -1.1 -1.1 .02 -1.1 -1.1 .04 -1.1 1.1 .04 -1.1 1.1 .02\n"        \
    "clear polygon east 0 0 12 1.1 -1.1 .02 1.1 1.1 .02 1.1 1.1 .04 1.1 -1.1 .04\n"            \
    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"                                             \
    "dark polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"

static char *even_floor(void)
{
    double radiance = sun_radiance();
    return text_of(SLAB_OVER_FLOOR, radiance, radiance, radiance);
}

enum { GRID = 5, POINTS = GRID * GRID };

/* Within .5 of the middle: look-ups narrower than .5 do not see the edges. */
static void floor_grid(pm_sensor sensors[POINTS])
{
    for (int i = 0; i < POINTS; i++)
        sensors[i] = (pm_sensor){{.25 * (i % GRID - 2), .25 * (i / GRID - 2), 0}, {0, 0, 1}};
}

/* The K nearest, over the area A that reaches to the next one: K / A is unbiased for photons
 * that fell independently, since A is gamma distributed with K + 1 and E[1 / A] = density / K.
 * Photons that are spread more evenly than by chance, as those of the sun's Sobol points are,
 * have A times the density between K and K + 1: at most 1 / K of bias. */
static void nearest_photons_on_an_even_floor_give_its_irradiance(void **state)
{
    (void)state;
    static const uint32_t counts[] = {10, 50, 200, 1000};
    enum { PHOTONS = 20000 }; /* 1000 of them reach sqrt(4 / 20 / pi) = .25 */
    pm_sensor sensors[POINTS];
    floor_grid(sensors);
    char *text = even_floor();
    for (int i = 0; i < 4; i++) {
        pm_job job = job_of(PM_JOB_TRACE, 0);
        want_map(&job, PM_MAP_CAUSTIC, PHOTONS, counts[i]);
        look_at(&job, sensors, POINTS, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        double slack = 1. / counts[i] + 1. / PHOTONS + .001;
        char what[40];
        snprintf(what, sizeof what, "%u nearest", counts[i]);
        expect_mean(what, &got, FLOOR_IRRADIANCE, slack * FLOOR_IRRADIANCE);
    }
    free(text);
}

/* A fixed radius has no bias in even light, whatever the photons' pattern. */
static void photons_within_a_radius_on_an_even_floor_give_its_irradiance(void **state)
{
    (void)state;
    pm_sensor sensors[POINTS];
    floor_grid(sensors);
    char *text = even_floor();
    pm_job job = job_of(PM_JOB_TRACE, 0);
    look_at(&job, sensors, POINTS, PM_IRRADIANCE);
    job.passes = 4;
    struct stat got = run_mean(&job, text, SEEDS, GREY);
    expect_mean("progressive", &got, FLOOR_IRRADIANCE, .001 * FLOOR_IRRADIANCE);
    free(text);
}

/* ---- how errors fall ---- */

/* An integrating sphere of albedo 1/2 with a lamp in its middle: see test_sphere.c. Its
 * photons fall evenly and independently. */
#define LAMP_RADIUS .02
#define LAMP_SHARE  (LAMP_RADIUS * LAMP_RADIUS) /* of the wall's view */
#define AGAIN       (.5 * (1 - LAMP_SHARE))
#define DIRECT      (PI * LAMP_SHARE)
#define INDIRECT    (DIRECT * AGAIN / (1 - AGAIN))

enum { SPREAD = 32 };

static void expect_ratio(const char *what, double got, double want, double error)
{
    if (!(fabs(got / want - 1) <= K_SIGMA * error))
        fail_msg("%s: deviation %.4g, theory %.4g (%+.1f %%), allowed %.1f %%", what, got, want,
                 100 * (got / want - 1), 100 * K_SIGMA * error);
}

/* K / A with A gamma distributed with K + 1 has relative variance 1 / (K - 1). Its excess
 * kurtosis (inverse gamma, a = K + 1) is 6 (5 a - 11) / ((a - 3)(a - 4)), so that a deviation
 * measured from n values has the relative error sqrt((excess + 2) / (4 n)). */
static void error_of_nearest_photons_falls_with_the_root_of_their_number(void **state)
{
    (void)state;
    static const uint32_t counts[] = {16, 64, 256};
    pm_sensor sensors[SPREAD];
    for (int i = 0; i < SPREAD; i++) {
        sensors[i].point = sphere_point(i, SPREAD);
        sensors[i].normal = pm_vec3_negate(sensors[i].point);
    }
    for (int i = 0; i < 3; i++) {
        pm_job job = job_of(PM_JOB_TRACE, -1);
        want_map(&job, PM_MAP_GLOBAL, 50000, counts[i]);
        look_at(&job, sensors, SPREAD, PM_IRRADIANCE);
        struct stat got = {0};
        for (unsigned seed = 1; seed <= SEEDS; seed++) {
            pm_answer answer;
            job.forward.seed = seed;
            run_job(&job, EVEN_SPHERE, NULL, &answer);
            for (int k = 0; k < SPREAD; k++)
                stat_add(&got, (double)answer.values[3 * k] / INDIRECT - DIRECT / INDIRECT);
            pm_answer_clear(&answer);
        }
        double a = counts[i] + 1., excess = 6 * (5 * a - 11) / ((a - 3) * (a - 4));
        char what[40];
        snprintf(what, sizeof what, "%u nearest", counts[i]);
        expect_mean(what, &got, 1, 0);
        expect_ratio(what, stat_deviation(&got), 1 / sqrt(counts[i] - 1.),
                     sqrt((excess + 2) / (4 * got.count)));
    }
}

/* Flux in a fixed disc from N paths. A path hits the wall indirectly G times, geometric with
 * P(again) = AGAIN: mean m = a / (1 - a), variance v = a / (1 - a)^2; each hit falls on the
 * disc with chance c = r^2 / 4. So the relative variance is (m (1 - c) + c v) c / (c m)^2 / N.
 * Discs apart count as independent: their correlation is of order c. */
enum { DISCS = 12, RUNS = 40 };
#define DISC_RADIUS .4

static pm_world *compile(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_bundle *bundle = pm_bundle_new();
    pm_status st = pm_bundle_add(bundle, "test.rad", text, strlen(text), &err);
    if (!st)
        st = pm_scene_parse(bundle, "test.rad", NULL, &scene, &err);
    if (!st)
        st = pm_world_compile(scene, &world, &err);
    if (st)
        fail_msg("%s", err.text);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return world;
}

/* Photons of the first `paths` paths on each disc, times their flux over the expected flux. */
static void count_discs(const pm_world *world, const pm_batch *batch, double scale,
                        uint32_t paths, struct stat *got)
{
    double flux[DISCS] = {0}, expected = INDIRECT * PI * DISC_RADIUS * DISC_RADIUS;
    pm_world_info info;
    pm_world_info_get(world, &info);
    for (uint32_t i = 0; i < batch->ends[paths - 1]; i++) {
        pm_vec3 p = pm_world_to_scene(world, pm_photon_position(&batch->photons[i]));
        for (int k = 0; k < DISCS; k++)
            if (pm_vec3_distance(p, sphere_point(k, DISCS)) <= DISC_RADIUS)
                flux[k] += pm_photon_flux(&batch->photons[i]).r;
    }
    double unit = scale * info.scale * info.scale / paths / expected;
    for (int k = 0; k < DISCS; k++)
        stat_add(got, flux[k] * unit);
}

static void one_batch(const pm_world *world, pm_pool *pool, uint64_t seed, struct stat got[4])
{
    pm_forward_options options = pm_forward_defaults();
    pm_forward *forward = NULL;
    pm_batch out[PM_MAP_KINDS] = {0};
    options.seed = seed;
    assert_int_equal(pm_forward_new(world, &options, pool, &forward, NULL), PM_OK);
    assert_int_equal(
        pm_forward_batch(forward, 0, 1U << PM_MAP_GLOBAL, pool, NULL, NULL, out, NULL), PM_OK);
    for (int i = 0; i < 4; i++)
        count_discs(world, &out[PM_MAP_GLOBAL], pm_forward_flux_scale(forward),
                    (uint32_t)PM_BATCH_PATHS >> (2 * i), &got[i]);
    pm_batch_clear(&out[PM_MAP_GLOBAL]);
    pm_forward_free(forward);
}

static void error_of_a_disc_falls_with_the_root_of_the_paths(void **state)
{
    (void)state;
    struct stat got[4] = {0};
    pm_world *world = compile(EVEN_SPHERE);
    pm_pool *pool = pm_pool_new(1);
    for (uint64_t seed = 1; seed <= RUNS; seed++)
        one_batch(world, pool, seed, got);
    double m = AGAIN / (1 - AGAIN), v = m / (1 - AGAIN), c = DISC_RADIUS * DISC_RADIUS / 4;
    for (int i = 0; i < 4; i++) {
        double paths = PM_BATCH_PATHS >> (2 * i);
        double want = sqrt((m * (1 - c) + c * v) / (c * m * m * paths));
        char what[40];
        snprintf(what, sizeof what, "%g paths", paths);
        expect_mean(what, &got[i], 1, 0);
        expect_ratio(what, stat_deviation(&got[i]), want, sqrt(1 / (2 * got[i].count)));
    }
    pm_pool_free(pool);
    pm_world_free(world);
}

/* The error of a look-up is that of its K photons: with K fixed a larger map does not reduce
 * it, which is the peer's trap; with K a fixed share of N it falls like 1 / sqrt(N). */
static void error_falls_only_if_the_gather_count_grows_with_the_map(void **state)
{
    (void)state;
    static const uint64_t photons[] = {4000, 64000, 64000};
    static const uint32_t gather[] = {40, 40, 640};
    double deviation[3];
    pm_sensor sensors[SPREAD];
    for (int i = 0; i < SPREAD; i++) {
        sensors[i].point = sphere_point(i, SPREAD);
        sensors[i].normal = pm_vec3_negate(sensors[i].point);
    }
    for (int i = 0; i < 3; i++) {
        pm_job job = job_of(PM_JOB_TRACE, -1);
        want_map(&job, PM_MAP_GLOBAL, photons[i], gather[i]);
        look_at(&job, sensors, SPREAD, PM_IRRADIANCE);
        struct stat got = {0};
        for (unsigned seed = 1; seed <= SEEDS / 2; seed++) {
            pm_answer answer;
            job.forward.seed = seed;
            run_job(&job, EVEN_SPHERE, NULL, &answer);
            for (int k = 0; k < SPREAD; k++)
                stat_add(&got, (double)answer.values[3 * k]);
            pm_answer_clear(&answer);
        }
        deviation[i] = stat_deviation(&got);
    }
    /* each of 256 values: 1 / sqrt(2 * 256), two of them */
    double error = sqrt(2. / (2 * SEEDS / 2 * SPREAD));
    expect_ratio("fixed count", deviation[1], deviation[0], error);
    expect_ratio("fixed share", deviation[2], deviation[0] * sqrt(39. / 639), error);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_photons_on_an_even_floor_give_its_irradiance),
        cmocka_unit_test(photons_within_a_radius_on_an_even_floor_give_its_irradiance),
        cmocka_unit_test(error_of_nearest_photons_falls_with_the_root_of_their_number),
        cmocka_unit_test(error_of_a_disc_falls_with_the_root_of_the_paths),
        cmocka_unit_test(error_falls_only_if_the_gather_count_grows_with_the_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
