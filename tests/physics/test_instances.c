/* A room that is furnished by instances and a mesh answers as the same room with all of it
 * written out. Both start paths alike, so they differ by far less than their noise; what is
 * claimed is within noise. */
#include "physics.h"

#include "base/bytes.h"
#include "files/octree_file.h"

#define MATERIALS                                                                              \
    "void plastic grey 0 0 5 .5 .5 .5 0 0\nvoid plastic red 0 0 5 .6 .2 .1 .03 .1\n"           \
    "void metal tin 0 0 5 .8 .8 .7 .9 0\nvoid dielectric crystal 0 0 5 .9 .8 .9 1.5 0\n"       \
    "void light bright 0 0 3 20 20 20\n"

/* A table with a tin ball and a crystal one: primitives, and the same from two octrees. */
#define TOP                                                                                    \
    "red polygon top 0 0 12 -.3 -.3 .3 .3 -.3 .3 .3 .3 .3 -.3 .3 .3\n"                         \
    "red polygon below 0 0 12 -.3 -.3 .27 -.3 .3 .27 .3 .3 .27 .3 -.3 .27\n"                   \
    "red cylinder leg 0 0 7 0 0 0 0 0 .27 .05\n"
#define BALLS "tin sphere a 0 0 4 -.12 0 .42 .12\ncrystal sphere b 0 0 4 .15 .05 .41 .11\n"

#define PLACES 4
static const char *const places[PLACES] = {"-rz 20 -t -.5 -.4 -1", "-s .7 -mx -t .5 -.5 -1",
                                           "-rz 65 -t .45 .5 -1",
                                           "-s 1.3 -rz -10 -t -.5 .5 -1"};

static const char frame[] =
    MATERIALS BOX("grey") "bright ring lamp 0 0 8 0 0 .99 0 0 -1 0 .3\n";

static void add_text(pm_bundle *bundle, const char *name, const char *text)
{
    assert_int_equal(pm_bundle_add(bundle, name, text, strlen(text), NULL), PM_OK);
}

static void add_octree(pm_bundle *bundle, const char *name, const char *file, uint64_t objects)
{
    const pm_octree_file head = {
        .size = 1, .files = &file, .file_count = 1, .objects = objects};
    pm_bytes bytes = {0};
    pm_octree_file_start(&head, "oconv", &bytes);
    pm_bytes_u8(&bytes, PM_NODE_EMPTY);
    assert_int_equal(pm_bundle_add(bundle, name, bytes.data, bytes.size, NULL), PM_OK);
    pm_bytes_clear(&bytes);
}

/* The red top is a mesh in the furnished room. */
static const char top_obj[] = "v -.3 -.3 .3\nv .3 -.3 .3\nv .3 .3 .3\nv -.3 .3 .3\n"
                              "v -.3 -.3 .27\nv .3 -.3 .27\nv .3 .3 .27\nv -.3 .3 .27\n"
                              "usemtl red\nf 1 2 3 4\nf 5 8 7 6\n";

static pm_bundle *room(bool furnished)
{
    pm_bundle *bundle = pm_bundle_new();
    char text[4096];
    size_t size = (size_t)snprintf(text, sizeof text, "%s", frame);
    for (int i = 0; i < PLACES; i++)
        size += (size_t)snprintf(text + size, sizeof text - size, "!xform %s %s\n", places[i],
                                 furnished ? "place.rad" : "table.rad");
    add_text(bundle, "test.rad", text);
    add_text(bundle, "table.rad", MATERIALS TOP BALLS);
    if (!furnished)
        return bundle;
    add_text(bundle, "balls.rad", MATERIALS BALLS);
    add_octree(bundle, "balls.oct", "balls.rad", 7);
    add_text(bundle, "top.obj", top_obj);
    add_text(bundle, "whole.rad",
             MATERIALS "void mesh top 1 top.obj 0 0\nred cylinder leg 0 0 7 0 0 0 0 0 .27 .05\n"
                       "void instance balls 1 balls.oct 0 0\n");
    add_octree(bundle, "whole.oct", "whole.rad", 8);
    add_text(bundle, "place.rad", "void instance table 1 whole.oct 0 0\n");
    return bundle;
}

static void run_room(pm_job *job, bool furnished, struct stat *stats)
{
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = room(furnished);
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        job->forward.seed = seed;
        if (pm_job_run(job, bundle, NULL, &answer, &err))
            fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
        assert_int_equal(answer.nonfinite, 0);
        for (size_t i = 0; i < 3 * job->sensor_count; i++)
            stat_add(&stats[i], (double)answer.values[i]);
        pm_answer_clear(&answer);
    }
    pm_bundle_free(bundle);
}

enum { SENSORS = 24 };

/* On the floor and the walls, and from the middle in all directions. */
static void expect_same_room(pm_job *job, pm_quantity quantity)
{
    pm_sensor sensors[SENSORS];
    struct stat written[3 * SENSORS] = {0}, placed[3 * SENSORS] = {0};
    for (int i = 0; i < SENSORS; i++) {
        pm_vec3 d = sphere_point(i, SENSORS);
        sensors[i].point = pm_vec3_make(0, 0, quantity == PM_RADIANCE ? .3 : -.1);
        sensors[i].normal = d;
    }
    look_at(job, sensors, SENSORS, quantity);
    run_room(job, false, written);
    run_room(job, true, placed);
    for (int i = 0; i < 3 * SENSORS; i++) {
        assert_true(written[i].mean >= 0);
        expect_equal_means("sensor", &placed[i], written[i].mean, stat_error(&written[i]),
                           ROUNDING * written[i].mean);
    }
}

static void a_room_of_instances_answers_as_one_written_out(void **state)
{
    (void)state;
    pm_job job = job_of(PM_JOB_TRACE, -1);
    expect_same_room(&job, PM_IRRADIANCE);
    expect_same_room(&job, PM_RADIANCE);
}

static void also_by_maps_and_gather_rays(void **state)
{
    (void)state;
    for (int i = 0; i < MODES; i++) {
        if (modes[i].ambient_bounces <= 0 || !modes[i].global || !modes[i].caustic)
            continue;
        pm_job job = job_of_mode(&modes[i], 3000, 50);
        expect_same_room(&job, PM_IRRADIANCE);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_room_of_instances_answers_as_one_written_out),
        cmocka_unit_test(also_by_maps_and_gather_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
