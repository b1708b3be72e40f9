#include "scene_test.h"

#include <math.h>
#include <stdlib.h>

#include "files/mesh.h"
#include "files/octree_file.h"

/* Octree files as scenes, and what instances and meshes place. */

/* A frozen octree of the records, its tree empty. */
static void put_frozen(pm_bytes *out, const pm_record *items, size_t count)
{
    const pm_octree_file head = {.size = 1, .objects = count};
    pm_error err = PM_ERROR_INIT;
    pm_octree_file_start(&head, "oconv -f", out);
    pm_bytes_u8(out, PM_NODE_EMPTY);
    assert_int_equal(pm_records_write(items, count, out, &err), PM_OK);
}

static void put_naming(pm_bytes *out, const char *const *files, uint32_t count,
                       uint64_t objects)
{
    const pm_octree_file head = {
        .size = 1, .files = files, .file_count = count, .objects = objects};
    pm_octree_file_start(&head, "oconv", out);
    pm_bytes_u8(out, PM_NODE_EMPTY);
}

static void add_bytes(pm_bundle *bundle, const char *name, pm_bytes *bytes)
{
    assert_int_equal(pm_bytes_status(bytes), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, name, bytes->data, bytes->size, NULL), PM_OK);
    pm_bytes_clear(bytes);
}

static void add_text(pm_bundle *bundle, const char *name, const char *text)
{
    assert_int_equal(pm_bundle_add(bundle, name, text, strlen(text), NULL), PM_OK);
}

static void add_frozen(pm_bundle *bundle, const char *name, const pm_record *items,
                       size_t count)
{
    pm_bytes bytes = {0};
    put_frozen(&bytes, items, count);
    add_bytes(bundle, name, &bytes);
}

static void add_naming(pm_bundle *bundle, const char *name, const char *file, uint64_t objects)
{
    pm_bytes bytes = {0};
    put_naming(&bytes, &file, 1, objects);
    add_bytes(bundle, name, &bytes);
}

/* Takes the bundle. */
static pm_scene *parsed(pm_bundle *bundle, const char *main_name)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    char text[1200];
    if (pm_scene_parse(bundle, main_name, NULL, &scene, &err)) {
        pm_error_format(&err, text, sizeof text);
        fail_msg("%s", text);
    }
    pm_bundle_free(bundle);
    return scene;
}

static void assert_refused(pm_bundle *bundle, const char *main_name, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    char text[1200];
    pm_status st = pm_scene_parse(bundle, main_name, NULL, &scene, &err);
    pm_error_format(&err, text, sizeof text);
    assert_string_equal(text, message);
    assert_true(st == err.status && !scene);
    pm_bundle_free(bundle);
}

static const double grey[] = {.5, .5, .5, 0, 0}, unit[] = {0, 0, 0, 1}, white[] = {1, 1, 1};
static const double square[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

#define PLASTIC(n)                                                                             \
    {                                                                                          \
        .type = "plastic", .name = n, .modifier = -1, .reals = grey, .real_count = 5           \
    }
#define SPHERE(n, m)                                                                           \
    {                                                                                          \
        .type = "sphere", .name = n, .modifier = m, .reals = unit, .real_count = 4             \
    }

static void records_are_primitives(void **state)
{
    (void)state;
    static const char *const alternate[] = {"wall"};
    const pm_record items[] = {
        PLASTIC("wall"),
        {.type = "illum",
         .name = "window",
         .modifier = -1,
         .strings = alternate,
         .string_count = 1,
         .reals = white,
         .real_count = 3},
        {.type = "polygon", .name = "p", .modifier = 1, .reals = square, .real_count = 12},
        {.type = "alias", .name = "paint", .modifier = 0},
        SPHERE("ball", 3),
        {.type = "alias",
         .name = "other",
         .modifier = -1,
         .strings = alternate,
         .string_count = 1},
        SPHERE("last", 5),
    };
    pm_bundle *bundle = pm_bundle_new();
    add_frozen(bundle, "any.name", items, 7);
    pm_scene *scene = parsed(bundle, "any.name");
    assert_int_equal(scene->count, 5);
    assert_int_equal(scene->main_count, 5);
    assert_int_equal(named(scene, "window")->references[0], 0);
    assert_int_equal(named(scene, "p")->modifier, 1);
    assert_int_equal(named(scene, "ball")->modifier, 0);
    assert_int_equal(named(scene, "last")->modifier, 0);
    ASSERT_REALS(named(scene, "ball"), 0, 0, 0, 1);
    assert_reals(named(scene, "wall"), grey, 5);
    pm_scene_free(scene);
}

/* A record says its modifier by number, whatever its name has come to mean since. */
static void modifiers_go_by_number(void **state)
{
    (void)state;
    const pm_record items[] = {PLASTIC("a"), PLASTIC("a"), SPHERE("first", 0),
                               SPHERE("second", 1)};
    pm_bundle *bundle = pm_bundle_new();
    add_frozen(bundle, "a.oct", items, 4);
    pm_scene *scene = parsed(bundle, "a.oct");
    assert_int_equal(named(scene, "first")->modifier, 0);
    assert_int_equal(named(scene, "second")->modifier, 1);
    pm_scene_free(scene);
}

static void records_are_checked_as_text(void **state)
{
    (void)state;
    static const double bright[] = {2, .5, .5, 0, 0};
    const pm_record items[] = {
        {.type = "plastic", .name = "w", .modifier = -1, .reals = bright, .real_count = 5},
        {.type = "plastic", .name = "w", .modifier = -1, .reals = bright, .real_count = 4},
        SPHERE("a", -1),
        SPHERE("b", 0),
    };
    pm_bundle *bundle = pm_bundle_new();
    add_frozen(bundle, "a.oct", items, 1);
    assert_refused(bundle, "a.oct",
                   "a.oct: primitive 1, plastic 'w': plastic's red is 2; a reflectance lies "
                   "between 0 and 1; above 1 the surface would create light");
    bundle = pm_bundle_new();
    add_frozen(bundle, "a.oct", items + 1, 1);
    assert_refused(bundle, "a.oct",
                   "a.oct: primitive 1, plastic 'w': plastic takes 5 reals: red green blue "
                   "specularity roughness; here are 4");
    bundle = pm_bundle_new();
    add_frozen(bundle, "a.oct", items + 2, 2);
    assert_refused(bundle, "a.oct",
                   "a.oct: primitive 2, sphere 'b': its modifier 'a' is a surface; the file is "
                   "damaged");
}

static const char room[] = "void plastic wall 0 0 5 .5 .5 .5 0 0\nvoid alias paint wall\n"
                           "paint sphere s 0 0 4 0 0 0 1\n";

static void named_files_are_read(void **state)
{
    (void)state;
    static const char *const files[] = {"a.rad", "b.rad"};
    pm_bytes bytes = {0};
    pm_bundle *bundle = pm_bundle_new();
    put_naming(&bytes, files, 2, 4);
    add_bytes(bundle, "sub/main.oct", &bytes);
    add_text(bundle, "sub/a.rad", room);
    add_text(bundle, "b.rad", "paint bubble b 0 0 4 1 1 1 1\n"); /* a.rad's names go on */
    pm_scene *scene = parsed(bundle, "sub/main.oct");
    assert_int_equal(scene->count, 3);
    assert_int_equal(named(scene, "b")->modifier, 0);
    pm_scene_free(scene);
}

static void stale_and_missing_files_are_refused(void **state)
{
    (void)state;
    pm_bundle *bundle = pm_bundle_new();
    add_naming(bundle, "a.oct", "a.rad", 4);
    add_text(bundle, "a.rad", room);
    assert_refused(bundle, "a.oct",
                   "a.oct: the octree was made of 4 primitives, and its scene files now hold "
                   "3; make it again (oconv)");
    bundle = pm_bundle_new();
    add_naming(bundle, "a.oct", "b.rad", 4);
    assert_refused(bundle, "a.oct",
                   "a.oct: there is no scene file 'b.rad', neither beside this octree nor "
                   "beside the main file; freeze the octree (oconv -f) to have all in one");
    bundle = pm_bundle_new();
    add_naming(bundle, "a.oct", "!genbox m b 1 1 1", 4);
    assert_refused(bundle, "a.oct",
                   "a.oct: it was made from the output of '!genbox m b 1 1 1', and commands "
                   "are not executed; put that line into a scene file, or freeze the octree "
                   "(oconv -f)");
    bundle = pm_bundle_new();
    add_naming(bundle, "a.oct", "a.oct", 4);
    assert_refused(bundle, "a.oct",
                   "a.oct: 'a.oct' is an octree itself; an octree names scene files");
}

static const char tree_and_main[] = "void instance i 1 tree.oct 0 0\n"
                                    "void instance k 5 tree.oct -t 5 0 0 0 0\n"
                                    "void instance l 1 other.oct 0 0\n";

static void instances_share_prototypes(void **state)
{
    (void)state;
    const pm_record items[] = {PLASTIC("leaf"), SPHERE("crown", 0)};
    pm_bundle *bundle = bundle_of(tree_and_main, NULL);
    add_frozen(bundle, "tree.oct", items, 2);
    add_naming(bundle, "other.oct", "room.rad", 3);
    add_text(bundle, "room.rad", room);
    pm_scene *scene = parsed(bundle, "main.rad");
    assert_int_equal(scene->main_count, 3);
    assert_int_equal(scene->count, 7);
    assert_int_equal(scene->prototype_count, 2);
    assert_int_equal(named(scene, "k")->assets[0], named(scene, "i")->assets[0]);
    assert_true(named(scene, "k")->transform->shift[0] == 5);
    const pm_prototype *tree = &scene->prototypes[named(scene, "i")->assets[0]];
    assert_int_equal(tree->count, 2);
    assert_string_equal(scene->primitives[tree->first + 1].name, "crown");
    assert_int_equal(scene->primitives[tree->first + 1].modifier, tree->first);
    pm_scene_free(scene);
}

/* What the main scene defines is unknown in an octree's files, and the other way round. */
static void names_of_prototypes_are_their_own(void **state)
{
    (void)state;
    pm_bundle *bundle =
        bundle_of("void plastic mine 0 0 5 1 1 1 0 0\nvoid instance i 1 a.oct 0 0\n", NULL);
    add_naming(bundle, "a.oct", "a.rad", 1);
    add_text(bundle, "a.rad", "mine sphere s 0 0 4 0 0 0 1\n");
    assert_refused(bundle, "main.rad",
                   "a.rad:1:1: 'mine' is not defined; define a material of that name above "
                   "this line");
}

static void circles_are_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"a.oct", "b.oct"};
    pm_bundle *bundle = pm_bundle_new();
    for (int i = 0; i < 2; i++) {
        const pm_record items[] = {{.type = "instance",
                                    .name = "i",
                                    .modifier = -1,
                                    .strings = &names[1 - i],
                                    .string_count = 1}};
        add_frozen(bundle, names[i], items, 1);
    }
    assert_refused(bundle, "a.oct",
                   "a.oct: instance 'i' would contain itself: 'b.oct' is placed in itself; "
                   "take it out");
}

static void depth_is_bounded(void **state)
{
    (void)state;
    pm_bundle *bundle = pm_bundle_new();
    for (int i = 0; i < 40; i++) {
        char name[16], next[16];
        const char *const strings[] = {next};
        snprintf(name, sizeof name, "%d.oct", i);
        snprintf(next, sizeof next, "%d.oct", i + 1);
        const pm_record items[] = {PLASTIC("m"),
                                   SPHERE("s", 0),
                                   {.type = "instance",
                                    .name = "i",
                                    .modifier = -1,
                                    .strings = strings,
                                    .string_count = 1}};
        add_frozen(bundle, name, items, i < 39 ? 3 : 2);
    }
    assert_refused(bundle, "0.oct",
                   "32.oct: octrees are nested more than 32 deep here; join some of them");
}

static void limits_hold_for_octrees(void **state)
{
    (void)state;
    const pm_record items[] = {PLASTIC("a"), SPHERE("b", 0), SPHERE("c", 0)};
    const pm_scene_limits limits = {.primitives = 2};
    pm_bundle *bundle = pm_bundle_new();
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    add_frozen(bundle, "a.oct", items, 3);
    assert_int_equal(pm_scene_parse(bundle, "a.oct", &limits, &scene, &err), PM_E_LIMIT);
    assert_string_equal(err.text, "it holds 3 primitives, more than 2; split it");
    pm_bundle_free(bundle);
}

static const char meshes[] = "void plastic red 0 0 5 .5 .1 .1 0 0\n"
                             "void mesh own 1 m.obj 0 0\nred mesh all 1 m.obj 0 0\n"
                             "void plastic red 0 0 5 .6 .1 .1 0 0\nvoid mesh new 1 m.obj 0 0\n"
                             "void mesh more 3 m.obj -s 2 0 0\n";

static void wavefront_slots_are_the_scenes_materials(void **state)
{
    (void)state;
    pm_bundle *bundle = bundle_of(meshes, NULL);
    add_text(bundle, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl red\nf 3 2 1\n");
    pm_scene *scene = parsed(bundle, "main.rad");
    assert_int_equal(scene->prototype_count, 3);
    const int32_t expected[] = {0, PM_VOID, 3};
    const char *const names[] = {"own", "all", "new"};
    for (int i = 0; i < 3; i++) {
        const pm_prototype *p = &scene->prototypes[named(scene, names[i])->assets[0]];
        assert_int_equal(p->mesh->triangle_count, 2);
        assert_int_equal(p->mesh->slot_count, 1);
        assert_int_equal(p->slots[0], expected[i]);
    }
    assert_int_equal(named(scene, "more")->assets[0], named(scene, "new")->assets[0]);
    pm_scene_free(scene);
}

static void an_unknown_slot_is_refused(void **state)
{
    (void)state;
    pm_bundle *bundle = bundle_of("void mesh m 1 m.obj 0 0\n", NULL);
    add_text(bundle, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\n");
    assert_refused(bundle, "main.rad",
                   "main.rad:1:15: 'blue' is not defined; define a material of that name "
                   "above this line");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_are_primitives),
        cmocka_unit_test(modifiers_go_by_number),
        cmocka_unit_test(records_are_checked_as_text),
        cmocka_unit_test(named_files_are_read),
        cmocka_unit_test(stale_and_missing_files_are_refused),
        cmocka_unit_test(instances_share_prototypes),
        cmocka_unit_test(names_of_prototypes_are_their_own),
        cmocka_unit_test(circles_are_refused),
        cmocka_unit_test(depth_is_bounded),
        cmocka_unit_test(limits_hold_for_octrees),
        cmocka_unit_test(wavefront_slots_are_the_scenes_materials),
        cmocka_unit_test(an_unknown_slot_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
