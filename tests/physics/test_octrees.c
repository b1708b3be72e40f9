/* One scene in several forms: text, octrees that name it or hold it, instances, meshes. */
#include "physics.h"

#include "bundle_text.h"
#include "world/octree_write.h"

#define TREE                                                                                   \
    "void plastic bark 0 0 5 .3 .2 .1 0 0\nvoid plastic leaf 0 0 5 .1 .4 .1 0 0\n"             \
    "bark cylinder trunk 0 0 7 0 0 0 0 0 .5 .05\nleaf sphere crown 0 0 4 0 0 .7 .25\n"         \
    "bark polygon branch 0 0 9 0 0 .2 .4 0 .3 .4 .1 .3\n"
#define ROOM                                                                                   \
    "void plastic wall 0 0 5 .5 .4 .3 0 0\n" BOX(                                              \
        "wall") "void light bright 0 0 3 5 4 3  bright ring lamp 0 0 8 0 0 .9 0 0 -1 0 .3\n"   \
                "void glass pane 0 0 3 .8 .8 .9  pane polygon screen 0 0 12 -.5 0 -1 .5 0 -1 " \
                ".5 0 -.5 "                                                                    \
                "-.5 0 -.5\n"

enum { SENSORS = 5 };

static const pm_sensor sensors[SENSORS] = {{{-.7, -.6, -1}, {0, 0, 1}},
                                           {{.1, -.3, -1}, {0, 0, 1}},
                                           {{.6, .5, -1}, {0, 0, 1}},
                                           {{-1, .2, .1}, {1, 0, 0}},
                                           {{.3, 1, -.5}, {0, -1, 0}}};

/* ---- forms of a scene ---- */

static void add_octree(pm_bundle *bundle, const char *name, const char *from, bool frozen)
{
    const pm_octree_options options = {
        .frozen = frozen, .files = &from, .file_count = 1, .command = "oconv"};
    pm_bytes bytes = {0};
    pm_scene *scene = NULL;
    assert_int_equal(pm_scene_parse(bundle, from, NULL, &scene, NULL), PM_OK);
    assert_int_equal(pm_octree_write(scene, bundle, &options, &bytes, NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, name, bytes.data, bytes.size, NULL), PM_OK);
    pm_bytes_clear(&bytes);
    pm_scene_free(scene);
}

/* `main.rad`, a tree in three forms, and octrees of the main scene. */
static pm_bundle *bundle_of(const char *text)
{
    pm_bundle *bundle = pm_bundle_new();
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_bundle_add(bundle, "tree.rad", TREE, strlen(TREE), NULL), PM_OK);
    add_octree(bundle, "tree.oct", "tree.rad", true);
    add_octree(bundle, "named_tree.oct", "tree.rad", false);
    if (add_texts(bundle, "main.rad", text, &err))
        fail_msg("%s", err.text);
    add_octree(bundle, "frozen.oct", "main.rad", true);
    add_octree(bundle, "named.oct", "main.rad", false);
    return bundle;
}

static void run(const pm_bundle *bundle, const char *main_name, uint64_t seed,
                pm_answer *answer)
{
    pm_job job = job_of(PM_JOB_TRACE, 1);
    pm_error err = PM_ERROR_INIT;
    look_at(&job, sensors, SENSORS, PM_IRRADIANCE);
    job.main_name = main_name;
    job.forward.seed = seed;
    job.passes = 1;
    if (pm_job_run(&job, bundle, NULL, answer, &err))
        fail_msg("%s:%d: %s", err.file, err.line, err.text);
    assert_int_equal(answer->nonfinite, 0);
}

static void run_form(const pm_bundle *bundle, const char *main_name, struct stat *stats)
{
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        run(bundle, main_name, seed, &answer);
        for (size_t i = 0; i < 3 * SENSORS; i++)
            stat_add(&stats[i], (double)answer.values[i]);
        pm_answer_clear(&answer);
    }
}

static void expect_same(const pm_bundle *a, const char *a_name, const pm_bundle *b,
                        const char *b_name)
{
    struct stat x[3 * SENSORS] = {0}, y[3 * SENSORS] = {0};
    run_form(a, a_name, x);
    run_form(b, b_name, y);
    for (int i = 0; i < 3 * SENSORS; i++) {
        char what[64];
        snprintf(what, sizeof what, "%.20s, sensor %d, channel %d", b_name, i / 3, i % 3);
        assert_true(x[i].mean > 0);
        expect_equal_means(what, &y[i], x[i].mean, stat_error(&x[i]), 0);
    }
}

/* ---- claims ---- */

/* By content, so the same photons fly. */
static void an_octree_that_names_its_file_is_its_text(void **state)
{
    (void)state;
    pm_bundle *bundle = bundle_of(ROOM "!xform -t .4 -.4 -1 tree.rad\n");
    pm_answer a, b;
    run(bundle, "main.rad", 1, &a);
    run(bundle, "named.oct", 1, &b);
    assert_memory_equal(a.values, b.values, 3 * SENSORS * sizeof *a.values);
    pm_answer_clear(&a);
    pm_answer_clear(&b);
    pm_bundle_free(bundle);
}

static void a_frozen_octree_answers_as_its_text(void **state)
{
    (void)state;
    pm_bundle *bundle = bundle_of(ROOM "!xform -t .4 -.4 -1 tree.rad\n");
    expect_same(bundle, "main.rad", bundle, "frozen.oct");
    pm_bundle_free(bundle);
}

static void instances_answer_as_copies(void **state)
{
    (void)state;
    pm_bundle *copies = bundle_of(ROOM "!xform -rz 30 -t .4 -.4 -1 tree.rad\n"
                                       "!xform -mx -s .7 -t -.5 .5 -1 tree.rad\n");
    pm_bundle *instances =
        bundle_of(ROOM "void instance a 7 tree.oct -rz 30 -t .4 -.4 -1 0 0\n"
                       "void instance b 8 named_tree.oct -mx -s .7 -t -.5 .5 -1 0 0\n");
    expect_same(copies, "main.rad", instances, "main.rad");
    expect_same(copies, "main.rad", instances, "frozen.oct");
    pm_bundle_free(copies);
    pm_bundle_free(instances);
}

static void a_mesh_answers_as_its_polygons(void **state)
{
    (void)state;
    static const char polygons[] =
        ROOM "void plastic red 0 0 5 .6 .1 .1 0 0\n"
             "red polygon a 0 0 12 .2 .2 -1 .7 .2 -1 .7 .2 -.4 .2 .2 -.4\n"
             "red polygon b 0 0 12 .2 .2 -.4 .7 .2 -.4 .7 .7 -.4 .2 .7 -.4\n";
    static const char mesh[] =
        ROOM "void plastic red 0 0 5 .6 .1 .1 0 0\nvoid mesh m 5 m.obj -t 0 0 -1 0 0\n"
             "#file m.obj\n"
             "v .2 .2 0\nv .7 .2 0\nv .7 .2 .6\nv .2 .2 .6\nv .7 .7 .6\nv .2 .7 .6\n"
             "usemtl red\nf 1 2 3 4\nf 4 3 5 6\n";
    pm_bundle *a = bundle_of(polygons), *b = bundle_of(mesh);
    expect_same(a, "main.rad", b, "main.rad");
    expect_same(a, "main.rad", b, "frozen.oct");
    pm_bundle_free(a);
    pm_bundle_free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_octree_that_names_its_file_is_its_text),
        cmocka_unit_test(a_frozen_octree_answers_as_its_text),
        cmocka_unit_test(instances_answer_as_copies),
        cmocka_unit_test(a_mesh_answers_as_its_polygons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
