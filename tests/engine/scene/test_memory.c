#include "scene_test.h"

#include <stdlib.h>

#include "../../support/failing_malloc.h"
#include "files/octree_file.h"

/* Materials with long names fill several arena blocks, surfaces several growths of the array.
 */
static char *large_text(void)
{
    enum { LINES = 900, WIDTH = 200 };
    char *text = malloc(LINES * WIDTH), *at = text;
    for (int i = 0; i < LINES; i++)
        at += snprintf(at, WIDTH, "void plastic %0100d 0 0 5 .5 .5 .5 0 0\n", i);
    return text;
}

static const char main_text[] =
    "void plastic wall 0 0 5 .5 .5 .5 0 0\n"
    "void illum window 1 wall 0 3 1 1 1\n"
    "void mist fog 2 a m>b 0 3 1 1 1\nvoid alias paint wall\n"
    "void brightdata table 6 noop t.dat . Px -s 2 0 0\n"
    "table brighttext words 4 helvet.fnt . two words 0 11 0 0 0 1 0 0 0 1 0 1 0\n"
    "words colorpict picture 7 noop noop noop p.hdr . Px Py 0 0\n"
    "!xform -n row -n left -m paint -a 3 -t 1 0 0 part.rad large.rad\n"
    "!xform placed.rad\n"
    "!gensurf wall hill s t s*t 3 3 -s | xform -n hills -a 2 -t 1 0 0 | xform -rz 20\n"
    "!genbox wall box 1 1 1 | xform -f list.txt\n";
static const char placed_text[] = "void instance i 1 tree.oct 0 0\n"
                                  "void mesh m 3 m.obj -s 2 0 0\n";
static const char mesh_text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wall\nf 1 2 3\n";
static const char part_text[] = "wall polygon p 0 0 9 0 0 0 1 0 0 1 1 0\n!xform leaf.rad\n";

/* A frozen octree with an alias and an instance of the same mesh. */
static void put_tree(pm_bytes *out)
{
    static const double reals[] = {.5, .5, .5, 0, 1};
    static const char *const mesh[] = {"m.obj"};
    const pm_record items[] = {
        {.type = "plastic", .name = "leaf", .modifier = -1, .reals = reals, .real_count = 5},
        {.type = "alias", .name = "other", .modifier = 0},
        {.type = "sphere", .name = "s", .modifier = 1, .reals = reals + 1, .real_count = 4},
        {.type = "mesh", .name = "m", .modifier = 0, .strings = mesh, .string_count = 1}};
    const pm_octree_file head = {.size = 1, .objects = 4};
    pm_octree_file_start(&head, "oconv", out);
    pm_bytes_u8(out, PM_NODE_EMPTY);
    assert_int_equal(pm_records_write(items, 4, out, NULL), PM_OK);
}

static pm_bundle *make_bundle(void)
{
    char *large = large_text();
    pm_bundle *bundle = bundle_of(main_text, part_text);
    pm_bytes tree = {0};
    put_tree(&tree);
    assert_int_equal(pm_bundle_add(bundle, "tree.oct", tree.data, tree.size, NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "m.obj", mesh_text, strlen(mesh_text), NULL), PM_OK);
    assert_int_equal(
        pm_bundle_add(bundle, "placed.rad", placed_text, strlen(placed_text), NULL), PM_OK);
    pm_bytes_clear(&tree);
    assert_int_equal(pm_bundle_add(bundle, "large.rad", large, strlen(large), NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "t.dat", "1 0 1 2 3 4\n", 12, NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "p.hdr", "#?RADIANCE\n\n-Y 1 +X 1\nabcd", 27, NULL),
                     PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "leaf.rad", "# leaf\n", 7, NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "list.txt", "-n a -t 1 0 0\n-rz 9\n", 20, NULL),
                     PM_OK);
    free(large);
    return bundle;
}

typedef pm_status action(const pm_bundle *bundle, const pm_bytes *tar, pm_error *err);

static pm_status parse(const pm_bundle *bundle, const pm_bytes *tar, pm_error *err)
{
    (void)tar;
    pm_scene *scene = NULL;
    pm_status st = pm_scene_parse(bundle, "main.rad", NULL, &scene, err);
    pm_scene_free(scene);
    return st;
}

static pm_status write_tar(const pm_bundle *bundle, const pm_bytes *tar, pm_error *err)
{
    (void)tar;
    pm_bytes out = {0};
    pm_status st = pm_bundle_write_tar(bundle, &out, err);
    pm_bytes_clear(&out);
    return st;
}

static pm_status read_tar(const pm_bundle *bundle, const pm_bytes *tar, pm_error *err)
{
    (void)bundle;
    pm_bundle *back = NULL;
    pm_status st = pm_bundle_read_tar(tar->data, tar->size, 1 << 20, &back, err);
    pm_bundle_free(back);
    return st;
}

static pm_status collect(const pm_bundle *bundle, const pm_bytes *tar, pm_error *err)
{
    (void)bundle, (void)tar;
    pm_bundle *out = NULL;
    const char *name;
    pm_status st = pm_bundle_collect(PM_SOURCE_DIR "/tests/bad/xform_circle/input.rad", NULL,
                                     &out, &name, err);
    pm_bundle_free(out);
    return st;
}

/* Leaks show under the address sanitizer. */
static void sweep(action *act, long least)
{
    pm_bundle *bundle = make_bundle();
    pm_bytes tar = {0};
    assert_int_equal(pm_bundle_write_tar(bundle, &tar, NULL), PM_OK);
    long n = 0;
    for (pm_status st = PM_E_MEMORY; st; n++) {
        pm_error err = PM_ERROR_INIT;
        until_failure = n;
        st = act(bundle, &tar, &err);
        bool all_done = until_failure >= 0;
        until_failure = -1;
        assert_int_equal(st, all_done ? PM_OK : PM_E_MEMORY);
        assert_int_equal(err.status, st);
    }
    assert_in_range(n, least, 100000);
    pm_bytes_clear(&tar);
    pm_bundle_free(bundle);
}

static void parsing_reports_every_failed_allocation(void **state)
{
    (void)state;
    sweep(parse, 20);
}

static void writing_a_tar_reports_every_failed_allocation(void **state)
{
    (void)state;
    sweep(write_tar, 3);
}

static void reading_a_tar_reports_every_failed_allocation(void **state)
{
    (void)state;
    sweep(read_tar, 4);
}

static void collecting_reports_every_failed_allocation(void **state)
{
    (void)state;
    sweep(collect, 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parsing_reports_every_failed_allocation),
        cmocka_unit_test(writing_a_tar_reports_every_failed_allocation),
        cmocka_unit_test(reading_a_tar_reports_every_failed_allocation),
        cmocka_unit_test(collecting_reports_every_failed_allocation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
