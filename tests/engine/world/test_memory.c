#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compile.h"
#include "octrees.h"
#include "world/octree_write.h"

/* Linked with --wrap: the allocation with number `failing` (from 0) fails, all others work. */
static long allocations, failing = -1;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t align, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_aligned_alloc(size_t align, size_t size);

void *__wrap_malloc(size_t size)
{
    return allocations++ == failing ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return allocations++ == failing ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    return allocations++ == failing ? NULL : __real_realloc(old, size);
}

void *__wrap_aligned_alloc(size_t align, size_t size)
{
    return allocations++ == failing ? NULL : __real_aligned_alloc(align, size);
}

/* Of every kind, many enough for the octree's sets to grow, and a polygon of many corners. */
static char *make_text(void)
{
    struct text t = {0};
    add(&t, "void plastic grey 0 0 5 .5 .5 .5 0 0\nvoid light lamp 0 0 3 1 1 1\n"
            "void antimatter cut 1 grey 0 0\nvoid mist fog 0 0 7 .1 .1 .1 .5 .5 .5 0\n"
            "cut sphere c 0 0 4 3 3 3 1\nfog sphere f 0 0 4 0 0 0 9\n"
            "lamp source sun 0 0 4 0 0 1 1\nlamp ring r 0 0 8 0 0 9 0 0 -1 0 1\n"
            "void spectrum red 0 0 6 400 700 0 0 1 1\n"
            "red brighttext words 4 helvet.fnt . Some words 0 12 0 0 0 1 0 0 0 1 0 1 0 .1\n"
            "void texfunc bumps 6 sin(Px) 0 0 . -s 2 0 0\n"
            "void mixfunc both 4 words bumps Py . 0 0\nboth plastic paint 0 0 5 .5 .5 .5 0 0\n"
            "void mixfunc some 4 grey paint .5 . 0 0\nsome sphere m 0 0 4 7 0 9 .5\n"
            "paint sphere n 0 0 4 9 0 9 .5\n"
            "void BRTDfunc any 10 Rdot .1 .1 .2 0 0 0 0 0 . 0 9 0 0 0 0 0 0 0 0 0\n"
            "void interface both2 0 0 8 1 1 1 1.5 .9 1 1 1.3\n"
            "any sphere o 0 0 4 9 3 9 .5\nboth2 sphere p 0 0 4 9 6 9 .5\n"
            "void brightfunc shine 2 Dz+Px . 0 0\nshine glow sky 0 0 4 1 1 1 0\n"
            "sky source s 0 0 4 0 0 1 180\nshine light pane 0 0 3 1 1 1\n"
            "pane ring u 0 0 8 0 0 8 0 0 -1 0 1\n"
            "grey cone k 0 0 8 5 5 5 6 6 6 1 2\ngrey polygon p 0 0 120");
    for (int i = 0; i < 40; i++)
        add(&t, " %.9g %.9g 0", (3 + i % 2) * cos(i * .157), (3 + i % 2) * sin(i * .157));
    add(&t, "\n");
    for (int i = 0; i < 200; i++)
        add(&t, "grey polygon q 0 0 9 %d %d 0 %d 1 1 1 %d 1\n", i, i % 7, i % 3 + 2, i % 5 + 3);
    return t.data;
}

/* Nothing may be left behind either: the sanitizers watch. */
static void fail_each(const pm_scene *scene)
{
    pm_status st = PM_E_MEMORY;
    for (failing = 0; st; failing++) {
        pm_error err = PM_ERROR_INIT;
        pm_world *world = NULL;
        allocations = 0;
        st = pm_world_compile(scene, &world, &err);
        assert_int_equal(err.status, st);
        if (st) {
            assert_int_equal(st, PM_E_MEMORY);
            assert_null(world);
            assert_true(allocations > failing);
        } else {
            assert_true(allocations <= failing);
            pm_world_free(world);
        }
    }
    assert_in_range(failing, 20, 1000);
    failing = -1;
}

static void every_failed_allocation_is_reported(void **state)
{
    (void)state;
    char *text = make_text();
    pm_scene *scene = scene_of(text);
    fail_each(scene);
    pm_scene_free(scene);
    free(text);
}

/* The mesh is two-sided. */
static void also_in_instances_and_meshes(void **state)
{
    (void)state;
    const struct file files[] = {
        {"m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 .1 1\nvt 0 0\nvt 1 0\n"
                  "usemtl red\nf 1/1/1 2/2/2 3/1/1\nf 3 2 1\n"},
        {"leaf", "void plastic green 0 0 5 .1 .5 .1 0 0\ngreen sphere s 0 0 4 0 0 0 1\n"
                 "green polygon p 0 0 15 0 0 0 4 0 0 1 1 0 1 4 0 0 4 0\n"},
        {"tree", "void instance a 1 leaf.oct 0 0\nvoid instance b 5 leaf.oct -t 3 0 0 0 0\n"}};
    pm_scene *scene = scene_of_files("void plastic red 0 0 5 .5 .1 .1 0 0\n"
                                     "void mesh m 1 m.obj 0 0\nvoid instance t 1 tree.oct 0 0\n"
                                     "red instance u 3 tree.oct -rx 20 0 0\n"
                                     "red sphere s 0 0 4 9 9 9 1\n",
                                     files, 3);
    fail_each(scene);
    pm_scene_free(scene);
}

static pm_status write_octree(const pm_scene *scene, const pm_bundle *bundle, pm_error *err)
{
    const pm_octree_options options = {.frozen = true, .resolution = 64, .command = "oconv"};
    pm_bytes bytes = {0};
    pm_status st = pm_octree_write(scene, bundle, &options, &bytes, err);
    pm_bytes_clear(&bytes);
    return st;
}

static void writing_an_octree_reports_every_failed_allocation(void **state)
{
    (void)state;
    pm_scene *scene = scene_of("void brightfunc wave 4 sin(Px) . -rx 30 0 0\n"
                               "wave plastic grey 0 0 5 .5 .5 .5 0 0\n"
                               "void illum pane 1 grey 0 3 1 1 1\n"
                               "pane polygon p 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n"
                               "grey sphere s 0 0 4 1 1 1 .5\n!genbox grey box 1 1 1\n");
    pm_bundle *bundle = pm_bundle_new();
    pm_status st = PM_E_MEMORY;
    for (failing = 0; st; failing++) {
        pm_error err = PM_ERROR_INIT;
        allocations = 0;
        st = write_octree(scene, bundle, &err);
        assert_int_equal(err.status, st);
        assert_int_equal(st, allocations > failing ? PM_E_MEMORY : PM_OK);
    }
    assert_in_range(failing, 10, 1000);
    failing = -1;
    pm_bundle_free(bundle);
    pm_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_failed_allocation_is_reported),
        cmocka_unit_test(also_in_instances_and_meshes),
        cmocka_unit_test(writing_an_octree_reports_every_failed_allocation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
