#include "scene_test.h"

#include <math.h>

#include "files/octree_file.h"
#include "scene/freeze.h"

/* What is frozen and read again is what it was: the scene, written and parsed back. */

static const char font[] = "65 4  0 0  255 0  255 255  0 255\n";

static pm_bundle *bundle_with_parts(const char *main_text, const char *part_text)
{
    pm_bundle *bundle = bundle_of(main_text, NULL);
    if (part_text)
        assert_int_equal(
            pm_bundle_add(bundle, "sub/part.rad", part_text, strlen(part_text), NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "sub/a.fnt", font, strlen(font), NULL), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "a.fnt", font, strlen(font), NULL), PM_OK);
    return bundle;
}

static pm_scene *parsed(const pm_bundle *bundle, const char *name)
{
    char text[1200];
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    if (pm_scene_parse(bundle, name, NULL, &scene, &err)) {
        pm_error_format(&err, text, sizeof text);
        fail_msg("%s", text);
    }
    return scene;
}

/* Adds the frozen scene to its bundle and parses that. */
static pm_scene *thawed(pm_bundle *bundle, const pm_scene *scene)
{
    const pm_octree_file head = {.size = 1, .objects = scene->main_count};
    pm_record *records;
    pm_arena arena = {0};
    pm_bytes bytes = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_scene_freeze(scene, bundle, &arena, &records, &err), PM_OK);
    pm_octree_file_start(&head, "oconv", &bytes);
    pm_bytes_u8(&bytes, PM_NODE_EMPTY);
    assert_int_equal(pm_records_write(records, scene->main_count, &bytes, &err), PM_OK);
    assert_int_equal(pm_bundle_add(bundle, "frozen.oct", bytes.data, bytes.size, NULL), PM_OK);
    pm_arena_clear(&arena);
    pm_bytes_clear(&bytes);
    return parsed(bundle, "frozen.oct");
}

static void assert_same_transform(const pm_transform *a, const pm_transform *b)
{
    assert_true(!a == !b);
    if (!a)
        return;
    assert_true(a->mirrored == b->mirrored);
    for (int i = 0; i < 9; i++)
        assert_true(fabs(a->turn[i / 3][i % 3] - b->turn[i / 3][i % 3]) <= 1e-14 * a->scale);
    for (int i = 0; i < 3; i++)
        assert_true(a->shift[i] == b->shift[i]);
}

static void assert_same(const pm_scene *a, const pm_scene *b)
{
    assert_int_equal(a->main_count, b->main_count);
    for (size_t i = 0; i < a->main_count; i++) {
        const pm_primitive *p = &a->primitives[i], *q = &b->primitives[i];
        assert_true(p->type == q->type && p->modifier == q->modifier &&
                    p->material == q->material);
        assert_string_equal(p->name, q->name);
        assert_int_equal(p->string_count, q->string_count);
        for (uint32_t k = 0; p->references && k < p->string_count; k++)
            assert_int_equal(p->references[k], q->references[k]);
        for (uint32_t k = 0; k < p->real_count; k++)
            assert_true(fabs(p->reals[k] - q->reals[k]) <= ldexp(fabs(p->reals[k]), -30));
        assert_same_transform(p->transform, q->transform);
    }
}

static void assert_survives(const char *main_text, const char *part_text)
{
    pm_bundle *bundle = bundle_with_parts(main_text, part_text);
    pm_scene *scene = parsed(bundle, "main.rad"), *back = thawed(bundle, scene);
    assert_same(scene, back);
    pm_scene_free(scene);
    pm_scene_free(back);
    pm_bundle_free(bundle);
}

static void aliases_and_modifiers_survive(void **state)
{
    (void)state;
    assert_survives("void plastic wall 0 0 5 .5 .5 .5 0 0\nvoid alias paint wall\n"
                    "void brightfunc dots 2 Px . 0 0\ndots alias spotted wall\n"
                    "paint sphere a 0 0 4 0 0 0 1\nspotted sphere b 0 0 4 0 0 0 1\n"
                    "void illum window 1 paint 0 3 1 1 1\nwindow ring r 0 0 8 0 0 5 0 0 1 0 1\n"
                    "void antimatter cut 2 wall spotted 0 0\ncut bubble c 0 0 4 0 0 0 -.5\n"
                    "void mixfunc both 4 wall paint .5 . 0 0\nboth sphere d 0 0 4 9 0 0 1\n"
                    "void sphere unseen 0 0 4 3 3 3 1\n",
                    NULL);
}

static void transforms_survive(void **state)
{
    (void)state;
    static const char *const words[] = {
        "-t 1 2 3",        "-rx 30",           "-ry 90",
        "-ry -90 -rz 20",  "-rx 90 -ry 90",    "-mx",
        "-my -s 2 -rz 10", "-mz -mx -t 0 0 1", "-s 1e-3 -rx 170 -ry 80 -rz -130 -t 5 6 7",
        "-ry 90.0001"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        char text[300];
        int count = 1;
        for (const char *at = words[i]; *at; at++)
            count += *at == ' ';
        snprintf(text, sizeof text,
                 "void brightfunc f %d Px . %s 0 0\n!xform -rz 40 sub/part.rad\n", count + 2,
                 words[i]);
        assert_survives(text, "void colorfunc g 6 Px Py Pz . -rx 12 0 0\n");
    }
}

static void texts_survive(void **state)
{
    (void)state;
    assert_survives("void brighttext t 5 sub/a.fnt . one \"two three\" four\n"
                    "0\n11 0 0 0 1 0 0 0 -1 0 1 0\n",
                    NULL);
}

/* Beside the part is not where the octree lies. */
static void files_are_named_from_the_top(void **state)
{
    (void)state;
    pm_bundle *bundle = bundle_with_parts(
        "!xform sub/part.rad\nvoid brighttext u 3 a.fnt . x 0 11 0 0 0 1 0 0 0 -1 0 1 0\n",
        "void brighttext t 3 a.fnt . x 0 11 0 0 0 1 0 0 0 -1 0 1 0\n");
    pm_scene *scene = parsed(bundle, "main.rad"), *back = thawed(bundle, scene);
    assert_string_equal(named(back, "t")->strings[0], "sub/a.fnt");
    assert_string_equal(named(back, "u")->strings[0], "a.fnt");
    pm_scene_free(scene);
    pm_scene_free(back);
    pm_bundle_free(bundle);
}

static void a_name_with_two_meanings_is_refused(void **state)
{
    (void)state;
    pm_scene *scene = scene_of("void plastic a 0 0 5 1 1 1 0 0\nvoid alias b a\n"
                               "void plastic a 0 0 5 0 0 0 0 0\nvoid illum i 1 b 0 3 1 1 1\n",
                               NULL);
    pm_arena arena = {0};
    pm_record *records;
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = bundle_of("", NULL);
    char text[1200];
    assert_int_equal(pm_scene_freeze(scene, bundle, &arena, &records, &err), PM_E_UNSUPPORTED);
    pm_error_format(&err, text, sizeof text);
    assert_string_equal(text, "main.rad:4:6: illum 'i' names 'a', which has been defined again "
                              "since; a frozen octree cannot tell them apart: give one another "
                              "name");
    pm_arena_clear(&arena);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(aliases_and_modifiers_survive),
        cmocka_unit_test(transforms_survive),
        cmocka_unit_test(texts_survive),
        cmocka_unit_test(files_are_named_from_the_top),
        cmocka_unit_test(a_name_with_two_meanings_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
