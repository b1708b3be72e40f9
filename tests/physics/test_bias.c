/* Estimates that choose their number of photons, and precomputed ones, in scenes. */
#include "physics.h"

#include "photons/bias.h"
#include "photons/precompute.h"

/* ---- the caustic of a glass ball over a floor ---- */

static const char glass_ball[] =
    "void plastic grey 0 0 5 .5 .5 .5 0 0  grey ring floor 0 0 8 0 0 0 0 0 1 0 3\n"
    "void light bright 0 0 3 9 9 9  bright ring lamp 0 0 8 .2 0 1.9 0 0 -1 0 .25\n"
    "void dielectric clear 0 0 5 1 1 1 1.5 0  clear sphere ball 0 0 4 0 0 .6 .4\n";

enum { SIDE = 24, POINTS = SIDE * SIDE, LEAST = 50, MOST = 500 };

static pm_photon_map *caustic_map(unsigned seed, uint64_t photons)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    pm_answer answer;
    want_map(&job, PM_MAP_CAUSTIC, photons, 40);
    job.forward.seed = seed;
    run_job(&job, glass_ball, NULL, &answer);
    pm_photon_map *map = answer.map[PM_MAP_CAUSTIC];
    answer.map[PM_MAP_CAUSTIC] = NULL;
    pm_answer_clear(&answer);
    return map;
}

/* A square of the floor around the caustic, in world coordinates. */
static pm_vec3 point_of(const pm_photon_map *map, int i)
{
    const pm_map_header *h = pm_photon_map_header(map);
    pm_vec3 p = {1.1 * (i % SIDE + .5) / SIDE - .6, 1.1 * (i / SIDE + .5) / SIDE - .55, 0};
    return pm_vec3_scale(pm_vec3_sub(p, h->world_center), 1 / h->world_scale);
}

static double ask(const pm_photon_map *map, int i, const pm_gather_range *range)
{
    static const pm_vec3 up = {0, 0, 1};
    pm_vec3 p = point_of(map, i);
    pm_estimate e =
        range->least == range->most
            ? pm_photon_map_nearest(map, p, up, range->least, INFINITY, PM_PHOTONS_ALL, NULL)
            : pm_photon_map_adapted(map, p, up, range, PM_PHOTONS_ALL, NULL);
    return pm_rgb_mean(e.irradiance);
}

/* The mean of maps of far more photons, other seeds, in discs of a quarter of the area of 50
 * photons. */
static void find_truth(double truth[POINTS])
{
    enum { MAPS = 3, PHOTONS = 250000 };
    const pm_gather_range range = {60, 60, PM_BANDWIDTH_BIAS};
    memset(truth, 0, POINTS * sizeof *truth);
    for (unsigned seed = 100; seed < 100 + MAPS; seed++) {
        pm_photon_map *map = caustic_map(seed, PHOTONS);
        for (int i = 0; i < POINTS; i++)
            truth[i] += ask(map, i, &range) / MAPS;
        pm_photon_map_free(map);
    }
}

/* Over a few maps, so that a lucky one does not decide. The reference has its own error, about
 * 1 / sqrt(3 * 60) = 7 % of each value beside the 14 % of 50 photons; it adds to all alike. */
static void bias_compensation_beats_both_ends_on_a_caustic(void **state)
{
    (void)state;
    static double truth[POINTS];
    enum { RULES = 4, MAPS = 2, PHOTONS = 50000 };
    static const pm_gather_range ranges[RULES] = {{LEAST, LEAST, PM_BANDWIDTH_BIAS},
                                                  {MOST, MOST, PM_BANDWIDTH_BIAS},
                                                  {LEAST, MOST, PM_BANDWIDTH_BIAS},
                                                  {LEAST, MOST, PM_BANDWIDTH_CHI2}};
    double square[RULES] = {0};
    find_truth(truth);
    for (unsigned seed = 1; seed <= MAPS; seed++) {
        pm_photon_map *map = caustic_map(seed, PHOTONS);
        for (int r = 0; r < RULES; r++)
            for (int i = 0; i < POINTS; i++)
                square[r] += pow(ask(map, i, &ranges[r]) - truth[i], 2);
        pm_photon_map_free(map);
    }
    double better = fmin(square[0], square[1]);
    assert_true(square[2] < better);
    assert_true(square[3] < better);
}

/* ---- precomputed maps ---- */

/* A sun 1 at the zenith above a clear slab: see test_density.c. All indirect light of the floor
 * is specular, and even. */
#define FLOOR_IRRADIANCE (.96 / 1.04)

static const char slab_over_floor[] =
    "void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"
    "void dielectric clear 0 0 5 1 1 1 1.5 0\n"
    "clear polygon top 0 0 12 -1.1 -1.1 .04 1.1 -1.1 .04 1.1 1.1 .04 -1.1 1.1 .04\n"
    "clear polygon low 0 0 12 -1.1 -1.1 .02 -1.1 1.1 .02 1.1 1.1 .02 1.1 -1.1 .02\n"
    "clear polygon south 0 0 12 -1.1 -1.1 .02 1.1 -1.1 .02 1.1 -1.1 .04 -1.1 -1.1 .04\n"
    "clear polygon north 0 0 12 -1.1 1.1 .02 -1.1 1.1 .04 1.1 1.1 .04 1.1 1.1 .02\n"
    "clear polygon west 0 0 12 -1.1 -1.1 .02 -1.1 -1.1 .04 -1.1 1.1 .04 -1.1 1.1 .02\n"
    "clear polygon east 0 0 12 1.1 -1.1 .02 1.1 1.1 .02 1.1 1.1 .04 1.1 -1.1 .04\n"
    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"
    "dark polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n";

static pm_job precomputed_job(pm_job_kind kind, int ambient_bounces, uint64_t photons,
                              uint32_t gather_count, double fraction)
{
    pm_job job = job_of(kind, ambient_bounces);
    want_map(&job, PM_MAP_GLOBAL, photons, gather_count);
    job.wanted.maps[PM_MAP_GLOBAL].precomputed = true;
    job.wanted.maps[PM_MAP_GLOBAL].fraction = fraction;
    return job;
}

/* In the corner a quarter of each disc lies on the floor, at the edge a half; without regard to
 * that they would be dark. 1 / 50 + .01: as in test_density.c. */
static void precomputed_corners_are_as_bright_as_they_are(void **state)
{
    (void)state;
    double radiance = sun_radiance();
    char *text = text_of(slab_over_floor, radiance, radiance, radiance);
    static const char *const names[] = {"middle", "edge", "corner"};
    for (int place = 0; place < 3; place++) {
        pm_sensor sensors[16];
        for (int i = 0; i < 16; i++) {
            double x = place == 2 ? .995 : .1 * i - .75, y = place ? .995 : .1;
            sensors[i] = (pm_sensor){{i & 1 ? x : -x, i & 2 ? y : -y, 0}, {0, 0, 1}};
        }
        pm_job job = precomputed_job(PM_JOB_TRACE, -1, 20000, 50, .25);
        look_at(&job, sensors, place == 2 ? 4 : 16, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_mean(names[place], &got, FLOOR_IRRADIANCE, .03 * FLOOR_IRRADIANCE);
    }
    free(text);
}

/* Against the global map that it is made of, at the eye and behind a gather ray, over many
 * sensors of a room with a glass ball: means that differ by the noise of the seeds, and by 1 /
 * 49 at most, the bias of a precomputed estimate (photons/precompute.h). */
static void precomputed_maps_give_the_light_of_the_global_map(void **state)
{
    (void)state;
    char *text = text_of("void plastic grey 0 0 5 .6 .5 .4 0 0\n" BOX(
        "grey") "void light bright 0 0 3 9 8 7  bright ring lamp 0 0 8 0 0 .98 0 0 -1 0 .3\n"
                "void dielectric clear 0 0 5 1 1 1 1.5 0  clear sphere b 0 0 4 .3 .2 -.5 .3\n");
    pm_sensor sensors[64];
    for (int i = 0; i < 64; i++)
        sensors[i] = (pm_sensor){{.22 * (i % 8) - .77, .22 * (i / 8) - .77, -1}, {0, 0, 1}};
    for (int ab = -1; ab <= 1; ab += 2) {
        pm_job job = job_of(PM_JOB_TRACE, ab);
        want_map(&job, PM_MAP_GLOBAL, 15000, 50);
        look_at(&job, sensors, 64, PM_IRRADIANCE);
        struct stat want = run_mean(&job, text, SEEDS, GREY);
        job = precomputed_job(PM_JOB_TRACE, ab, 15000, 50, .25);
        look_at(&job, sensors, 64, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS, GREY);
        expect_equal_means(ab < 0 ? "-ab -1" : "-ab 1", &got, want.mean, stat_error(&want),
                           want.mean / 49);
    }
    free(text);
}

/* A caustic map beside a precomputed one is left alone with -ab < 0, which would count that
 * light twice. */
static void a_caustic_map_beside_a_precomputed_one_counts_once(void **state)
{
    (void)state;
    pm_sensor sensor = {{.1, .1, 0}, {0, 0, 1}};
    double radiance = sun_radiance();
    char *text = text_of(slab_over_floor, radiance, radiance, radiance);
    pm_job job = precomputed_job(PM_JOB_TRACE, -1, 20000, 50, .25);
    want_map(&job, PM_MAP_CAUSTIC, 20000, 50);
    look_at(&job, &sensor, 1, PM_IRRADIANCE);
    struct stat got = run_mean(&job, text, SEEDS, GREY);
    expect_mean("both maps", &got, FLOOR_IRRADIANCE, .03 * FLOOR_IRRADIANCE);
    free(text);
}

/* The second job finds the map in the store and traces nothing; another number, bandwidth or
 * fraction is another map. */
static void precomputed_maps_are_kept(void **state)
{
    (void)state;
    static const struct {
        uint64_t photons;
        uint32_t gather;
        double fraction;
        size_t kept; /* batches after it: photons', then the map's */
    } asked[] = {{3000, 50, .25, 2}, {3000, 50, .25, 2}, {3000, 50, 0, 2},
                 {3000, 40, .25, 3}, {3000, 50, .5, 4},  {2000, 50, .25, 5}};
    struct store store = {0};
    pm_job_hooks hooks = store_hooks(&store);
    pm_bytes first = {0};
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        pm_answer answer;
        pm_bytes bytes = {0};
        pm_job job = precomputed_job(PM_JOB_MAP, 1, asked[i].photons, asked[i].gather,
                                     asked[i].fraction);
        run_job(&job, EVEN_SPHERE, &hooks, &answer);
        const pm_map_summary *summary = &answer.maps[PM_MAP_GLOBAL];
        assert_int_equal(store.kept, asked[i].kept);
        assert_true(i == 0 ? summary->paths_traced > 0 : summary->paths_traced == 0);
        assert_true(i == 0 || summary->paths_cached > 0);
        assert_int_equal(pm_photon_map_write(answer.map[PM_MAP_GLOBAL], NULL, &bytes, NULL),
                         PM_OK);
        if (i == 0) {
            first = bytes;
        } else {
            bool same = bytes.size == first.size && !memcmp(bytes.data, first.data, first.size);
            assert_int_equal(same, i <= 2);
            pm_bytes_clear(&bytes);
        }
        pm_answer_clear(&answer);
    }
    pm_bytes_clear(&first);
    store_clear(&store);
}

static void expect_refusal(pm_job job, const char *words)
{
    pm_error err = PM_ERROR_INIT;
    pm_answer answer;
    pm_bundle *bundle = pm_bundle_new();
    assert_int_equal(pm_bundle_add(bundle, "test.rad", EVEN_SPHERE, strlen(EVEN_SPHERE), &err),
                     PM_OK);
    assert_int_not_equal(pm_job_run(&job, bundle, NULL, &answer, &err), PM_OK);
    if (!strstr(err.text, words))
        fail_msg("says: %s", err.text);
    pm_bundle_free(bundle);
}

static void wrong_precomputed_maps_are_refused(void **state)
{
    (void)state;
    expect_refusal(precomputed_job(PM_JOB_MAP, 1, 1000, 1001, .25),
                   "fewer photons an estimate");
    expect_refusal(precomputed_job(PM_JOB_MAP, 1, 1000, 50, -1), "greater than 0");
    expect_refusal(precomputed_job(PM_JOB_MAP, 1, 1000, 50, 1.5), "at most 1");
    expect_refusal(precomputed_job(PM_JOB_MAP, 1, 1000, 50, (double)NAN), "greater than 0");
    pm_job job = precomputed_job(PM_JOB_MAP, 1, 1000, 50, .25);
    job.wanted.maps[PM_MAP_GLOBAL].gather_max = 100;
    expect_refusal(job, "second number");
    job = precomputed_job(PM_JOB_MAP, 1, 1000, 50, .25);
    want_map(&job, PM_MAP_CAUSTIC, 1000, 50);
    job.wanted.maps[PM_MAP_CAUSTIC].precomputed = true;
    expect_refusal(job, "only global maps");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bias_compensation_beats_both_ends_on_a_caustic),
        cmocka_unit_test(precomputed_corners_are_as_bright_as_they_are),
        cmocka_unit_test(precomputed_maps_give_the_light_of_the_global_map),
        cmocka_unit_test(a_caustic_map_beside_a_precomputed_one_counts_once),
        cmocka_unit_test(precomputed_maps_are_kept),
        cmocka_unit_test(wrong_precomputed_maps_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
