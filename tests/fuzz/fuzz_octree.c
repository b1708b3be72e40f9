/* Parses the input as an octree, beside files that it can name and place, and checks what the
 * headers promise; what was parsed is written as an octree, frozen, which must be read again.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "files/octree_file.h"
#include "world/octree_write.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const pm_scene_limits limits = {
    .primitives = 2000, .reals = 20000, .bytes = 4 << 20, .nesting = 8};

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_primitive(const pm_scene *scene, size_t index)
{
    const pm_primitive *p = &scene->primitives[index];
    check(p->type < PM_PRIMITIVE_TYPES && p->file < scene->file_count && p->name);
    check(p->modifier == PM_VOID ||
          (p->modifier >= 0 && (size_t)p->modifier < index &&
           !pm_primitive_is_surface(scene->primitives[p->modifier].type)));
    for (uint32_t i = 0; i < p->string_count; i++)
        check(p->strings[i] && (!p->references || p->references[i] == PM_VOID ||
                                (p->references[i] >= 0 && (size_t)p->references[i] < index)));
    for (uint32_t i = 0; i < p->real_count; i++)
        check(isfinite(p->reals[i]));
    if (p->type == PM_INSTANCE || p->type == PM_MESH)
        check((size_t)p->assets[0] < scene->prototype_count);
}

static void check_scene(const pm_scene *scene)
{
    check(scene->main_count <= scene->count);
    for (size_t i = 0; i < scene->count; i++)
        check_primitive(scene, i);
    for (size_t i = 0; i < scene->prototype_count; i++) {
        const pm_prototype *p = &scene->prototypes[i];
        check(p->first + p->count <= scene->count);
    }
}

static void check_written(const pm_scene *scene, pm_bundle *bundle)
{
    const pm_octree_options options = {.frozen = true, .resolution = 64, .command = "oconv"};
    pm_bytes bytes = {0};
    pm_scene *again = NULL;
    if (!pm_octree_write(scene, bundle, &options, &bytes, NULL) &&
        !pm_bundle_add(bundle, "again.oct", bytes.data, bytes.size, NULL)) {
        pm_octree_file file;
        pm_arena arena = {0};
        check(!pm_octree_file_read(bytes.data, bytes.size, "again", 1 << 20, &arena, &file,
                                   NULL));
        check(file.records.count == scene->main_count);
        pm_arena_clear(&arena);
        if (!pm_scene_parse(bundle, "again.oct", &limits, &again, NULL))
            check_scene(again);
        pm_scene_free(again);
    }
    pm_bytes_clear(&bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char part[] = "void dielectric ice 0 0 5 .9 .9 .9 1.3 0\n"
                               "ice cone c 0 0 8 0 0 0 0 0 1 1 .5\nvoid alias snow ice\n";
    static const char mesh[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_bundle *bundle = pm_bundle_new();
    check(bundle && !pm_bundle_add(bundle, "main.oct", data, size, NULL) &&
          !pm_bundle_add(bundle, "part.rad", part, sizeof part - 1, NULL) &&
          !pm_bundle_add(bundle, "m.obj", mesh, sizeof mesh - 1, NULL));
    pm_status st = pm_scene_parse(bundle, "main.oct", &limits, &scene, &err);
    check(err.status == st && !st == !err.text[0]);
    if (!st) {
        check_scene(scene);
        check_written(scene, bundle);
    }
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return 0;
}
