/* Whole jobs: the same bytes however they are run, stored batches, maps that cannot be. */
#include "physics.h"

/* All kinds of events, so that all three maps have photons. */
#define SCENE                                                                                  \
    "void plastic wall 0 0 5 .5 .4 .3 .03 .1\n" BOX(                                           \
        "wall") "void light bright 0 0 3 5 4 3  bright polygon lamp 0 0 12 -.3 -.3 .9 -.3 .3 " \
                ".9"                                                                           \
                " .3 .3 .9 .3 -.3 .9\n"                                                        \
                "void dielectric clear 0 0 5 .9 .9 .9 1.5 0  clear sphere ball 0 0 4 -.4 0 "   \
                "-.4 .3\n"                                                                     \
                "void mist fog 0 0 7 .2 .3 .4 .5 .5 .5 .3  fog sphere cloud 0 0 4 .4 0 0 .5\n"

#define DIFFUSE                                                                                \
    "void plastic wall 0 0 5 .5 .4 .3 0 0\n" BOX(                                              \
        "wall") "void light bright 0 0 3 5 4 3  bright ring lamp 0 0 8 0 0 .9 0 0 -1 0 .3\n"

static pm_job map_job(uint64_t photons)
{
    pm_job job = job_of(PM_JOB_MAP, -1);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        want_map(&job, (pm_map_kind)kind, photons, 50);
    return job;
}

static pm_bytes bytes_of(const pm_photon_map *map)
{
    pm_bytes bytes = {0};
    assert_int_equal(pm_photon_map_write(map, "test", &bytes, NULL), PM_OK);
    return bytes;
}

static void expect_same_maps(const pm_answer *a, const pm_answer *b)
{
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        pm_bytes x = bytes_of(a->map[kind]), y = bytes_of(b->map[kind]);
        assert_int_equal(x.size, y.size);
        assert_memory_equal(x.data, y.data, x.size);
        pm_bytes_clear(&x);
        pm_bytes_clear(&y);
    }
}

/* ---- threads ---- */

static const unsigned threads[3] = {1, 2, 7};

static void maps_have_the_same_bytes_for_1_2_and_7_threads(void **state)
{
    (void)state;
    pm_answer answers[3];
    for (int i = 0; i < 3; i++) {
        pm_job job = map_job(30000);
        job.threads = threads[i];
        run_job(&job, SCENE, NULL, &answers[i]);
        assert_true(pm_photon_map_count(answers[i].map[PM_MAP_VOLUME]) > 29700);
        expect_same_maps(&answers[0], &answers[i]);
    }
    for (int i = 0; i < 3; i++)
        pm_answer_clear(&answers[i]);
}

enum { SENSORS = 100, SIDE = 24 };

static void looking_job(pm_job *job, pm_job_kind kind, bool progressive, pm_sensor *sensors)
{
    *job = job_of(kind, progressive ? -1 : 1);
    for (int m = 0; m < PM_MAP_KINDS && !progressive; m++)
        want_map(job, (pm_map_kind)m, 5000, 50);
    for (int i = 0; i < SENSORS; i++)
        sensors[i] = (pm_sensor){{.018 * i - .9, .5 - .01 * i, -1}, {0, 0, 1}};
    look_at(job, sensors, SENSORS, PM_IRRADIANCE);
    job->view = (pm_view){.point = {0, -.9, 0},
                          .direction = {0, 1, 0},
                          .up = {0, 0, 1},
                          .horizontal = 80,
                          .vertical = 80};
    job->width = job->height = SIDE;
    job->passes = 3;
}

static void expect_same_looks(const pm_answer *a, const pm_answer *b, pm_job_kind kind)
{
    if (kind == PM_JOB_RENDER) {
        assert_memory_equal(a->image.rgb, b->image.rgb, 3 * SIDE * SIDE * sizeof(float));
        return;
    }
    assert_memory_equal(a->values, b->values, 3 * SENSORS * sizeof(float));
    assert_memory_equal(a->half_widths, b->half_widths, 3 * SENSORS * sizeof(float));
}

static void answers_have_the_same_bytes_for_1_2_and_7_threads(void **state)
{
    (void)state;
    static const pm_job_kind kinds[2] = {PM_JOB_TRACE, PM_JOB_RENDER};
    for (int k = 0; k < 4; k++) {
        pm_answer answers[3];
        pm_sensor sensors[SENSORS];
        for (int i = 0; i < 3; i++) {
            pm_job job;
            looking_job(&job, kinds[k / 2], k % 2 == 0, sensors);
            job.threads = threads[i];
            run_job(&job, SCENE, NULL, &answers[i]);
            expect_same_looks(&answers[0], &answers[i], kinds[k / 2]);
            assert_true(answers[0].error == answers[i].error);
        }
        for (int i = 0; i < 3; i++)
            pm_answer_clear(&answers[i]);
    }
}

/* ---- stored batches ---- */

static void counts_are_within_one_percent_of_those_wanted(void **state)
{
    (void)state;
    pm_job job = map_job(10000);
    pm_answer answer;
    run_job(&job, SCENE, NULL, &answer);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        assert_in_range(pm_photon_map_count(answer.map[kind]), 9900, 10000);
        assert_int_equal(answer.maps[kind].photons, pm_photon_map_count(answer.map[kind]));
        assert_int_equal(answer.maps[kind].paths_cached, 0);
        assert_int_equal(answer.maps[kind].paths_traced % PM_BATCH_PATHS, 0);
    }
    pm_answer_clear(&answer);
}

/* The larger map fetches what the smaller one left, and traces the rest alone. */
static void topping_up_traces_only_what_is_missing(void **state)
{
    (void)state;
    struct store store = {0};
    pm_job_hooks hooks = store_hooks(&store);
    pm_answer first, topped, whole;
    pm_job small = map_job(10000), large = map_job(20000);
    run_job(&small, SCENE, &hooks, &first);
    size_t kept = store.kept;
    assert_int_equal(store.fetched, 0);
    assert_true(kept >= PM_MAP_KINDS);
    run_job(&large, SCENE, &hooks, &topped);
    run_job(&large, SCENE, NULL, &whole);
    expect_same_maps(&topped, &whole);
    assert_true(store.fetched == kept && store.kept > kept);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        const pm_map_summary *t = &topped.maps[kind], *w = &whole.maps[kind];
        assert_int_equal(t->paths_cached, first.maps[kind].paths_traced);
        assert_int_equal(t->paths_cached + t->paths_traced, w->paths_traced);
    }
    pm_answer_clear(&first);
    pm_answer_clear(&topped);
    pm_answer_clear(&whole);
    store_clear(&store);
}

static void another_view_of_a_stored_map_traces_nothing(void **state)
{
    (void)state;
    struct store store = {0};
    pm_job_hooks hooks = store_hooks(&store);
    pm_sensor sensors[SENSORS];
    pm_answer a, b;
    pm_job job;
    looking_job(&job, PM_JOB_RENDER, false, sensors);
    run_job(&job, SCENE, &hooks, &a);
    job.view.point.x = .3;
    run_job(&job, SCENE, &hooks, &b);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        assert_true(a.maps[kind].paths_traced > 0 && a.maps[kind].paths_cached == 0);
        assert_true(b.maps[kind].paths_traced == 0 && b.maps[kind].paths_cached > 0);
    }
    assert_memory_not_equal(a.image.rgb, b.image.rgb, 3 * SIDE * SIDE * sizeof(float));
    pm_answer_clear(&a);
    pm_answer_clear(&b);
    store_clear(&store);
}

/* A batch that does not check is as good as none. */
static void damaged_batches_are_traced_again(void **state)
{
    (void)state;
    struct store store = {0};
    pm_job_hooks hooks = store_hooks(&store);
    pm_answer first, second;
    pm_job job = map_job(5000);
    run_job(&job, SCENE, &hooks, &first);
    size_t count = store.count;
    for (size_t i = 0; i < count; i++)
        store.list[i].bytes.data[store.list[i].bytes.size / 2] ^= 1;
    hooks.keep = NULL;
    run_job(&job, SCENE, &hooks, &second);
    expect_same_maps(&first, &second);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        assert_int_equal(second.maps[kind].paths_cached, 0);
    pm_answer_clear(&first);
    pm_answer_clear(&second);
    store_clear(&store);
}

/* ---- maps from files ---- */

static pm_status trace_with_file(const char *text, const pm_bytes *file, pm_answer *answer,
                                 pm_error *err)
{
    pm_sensor sensor = {{0, 0, -1}, {0, 0, 1}};
    pm_job job = job_of(PM_JOB_TRACE, -1);
    want_map(&job, PM_MAP_GLOBAL, 1, 50);
    job.wanted.maps[PM_MAP_GLOBAL].from_file = true;
    job.files[PM_MAP_GLOBAL] = (pm_map_file){file->data, file->size, "scene.gpm"};
    look_at(&job, &sensor, 1, PM_IRRADIANCE);
    pm_bundle *bundle = pm_bundle_new();
    assert_int_equal(pm_bundle_add(bundle, "test.rad", text, strlen(text), NULL), PM_OK);
    pm_status st = pm_job_run(&job, bundle, NULL, answer, err);
    pm_bundle_free(bundle);
    return st;
}

static void map_of_another_scene_is_refused(void **state)
{
    (void)state;
    pm_answer made, used, traced;
    pm_error err = PM_ERROR_INIT;
    pm_job job = map_job(5000);
    run_job(&job, SCENE, NULL, &made);
    pm_bytes file = bytes_of(made.map[PM_MAP_GLOBAL]);
    assert_int_equal(trace_with_file(DIFFUSE, &file, &used, &err), PM_E_MISMATCH);
    assert_non_null(strstr(err.text, "another scene"));
    assert_string_equal(err.file, "scene.gpm");
    /* names, comments and order say nothing about a scene */
    err = (pm_error)PM_ERROR_INIT;
    assert_int_equal(trace_with_file("# the same\n" SCENE, &file, &used, &err), PM_OK);
    pm_sensor sensor = {{0, 0, -1}, {0, 0, 1}};
    job = job_of(PM_JOB_TRACE, -1);
    want_map(&job, PM_MAP_GLOBAL, 5000, 50);
    look_at(&job, &sensor, 1, PM_IRRADIANCE);
    run_job(&job, SCENE, NULL, &traced);
    assert_memory_equal(used.values, traced.values, 3 * sizeof(float));
    pm_bytes_clear(&file);
    pm_answer_clear(&made);
    pm_answer_clear(&used);
    pm_answer_clear(&traced);
}

/* ---- what a scene does not need ---- */

static void map_that_cannot_be_is_empty_and_says_why(void **state)
{
    (void)state;
    pm_job job = map_job(50000);
    pm_answer answer;
    run_job(&job, DIFFUSE, NULL, &answer);
    const pm_photon_map *caustic = answer.map[PM_MAP_CAUSTIC],
                        *volume = answer.map[PM_MAP_VOLUME];
    assert_true(pm_photon_map_count(answer.map[PM_MAP_GLOBAL]) > 49500);
    assert_true(pm_photon_map_count(caustic) == 0 && pm_photon_map_count(volume) == 0);
    assert_string_equal(pm_photon_map_header(caustic)->note,
                        "no caustic pass: no surface reflects or refracts specularly");
    assert_string_equal(pm_photon_map_header(volume)->note, "no volume pass: no mist");
    assert_int_equal(answer.maps[PM_MAP_CAUSTIC].paths_traced, 0);
    pm_bytes file = bytes_of(caustic);
    pm_photon_map *read = NULL;
    assert_int_equal(pm_photon_map_read(file.data, file.size, "c.gpm", &read, NULL, NULL),
                     PM_OK);
    assert_int_equal(pm_photon_map_count(read), 0);
    pm_photon_map_free(read);
    pm_bytes_clear(&file);
    pm_answer_clear(&answer);
}

/* ---- stopping ---- */

struct patience {
    int asked, most;
};

static bool run_out(void *context)
{
    struct patience *patience = context;
    return ++patience->asked > patience->most;
}

static void cancelled_jobs_leave_nothing(void **state)
{
    (void)state;
    pm_sensor sensors[SENSORS];
    for (int i = 0; i < 2; i++) {
        struct patience patience = {0, 3};
        pm_job_hooks hooks = {.context = &patience, .cancelled = run_out};
        pm_error err = PM_ERROR_INIT;
        pm_answer answer, before;
        pm_job job;
        memset(&answer, 0x55, sizeof answer);
        memset(&before, 0x55, sizeof before);
        looking_job(&job, PM_JOB_RENDER, i == 0, sensors);
        job.passes = 1000000;
        pm_bundle *bundle = pm_bundle_new();
        assert_int_equal(pm_bundle_add(bundle, "test.rad", SCENE, strlen(SCENE), NULL), PM_OK);
        assert_int_equal(pm_job_run(&job, bundle, &hooks, &answer, &err), PM_E_CANCELLED);
        assert_memory_equal(&answer, &before, sizeof answer);
        pm_bundle_free(bundle);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_have_the_same_bytes_for_1_2_and_7_threads),
        cmocka_unit_test(answers_have_the_same_bytes_for_1_2_and_7_threads),
        cmocka_unit_test(counts_are_within_one_percent_of_those_wanted),
        cmocka_unit_test(topping_up_traces_only_what_is_missing),
        cmocka_unit_test(another_view_of_a_stored_map_traces_nothing),
        cmocka_unit_test(damaged_batches_are_traced_again),
        cmocka_unit_test(map_of_another_scene_is_refused),
        cmocka_unit_test(map_that_cannot_be_is_empty_and_says_why),
        cmocka_unit_test(cancelled_jobs_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
