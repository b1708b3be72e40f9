#ifndef PM_TESTS_WORLD_OCTREES_H
#define PM_TESTS_WORLD_OCTREES_H

#include "compile.h"
#include "files/octree_file.h"

/* Scenes of several files, with octrees for instances. Include after <cmocka.h>. */

struct file {
    const char *name, *text;
};

static inline pm_scene *parsed(const pm_bundle *bundle, const char *name)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    if (pm_scene_parse(bundle, name, NULL, &scene, &err))
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    return scene;
}

/* An octree file that names a scene file, as oconv without -f writes it. */
static inline void add_octree(pm_bundle *bundle, const char *name, const char *file)
{
    pm_scene *scene = parsed(bundle, file);
    const pm_octree_file head = {
        .size = 1, .files = &file, .file_count = 1, .objects = scene->main_count};
    pm_bytes bytes = {0};
    pm_scene_free(scene);
    pm_octree_file_start(&head, "oconv", &bytes);
    pm_bytes_u8(&bytes, PM_NODE_EMPTY);
    assert_int_equal(pm_bundle_add(bundle, name, bytes.data, bytes.size, NULL), PM_OK);
    pm_bytes_clear(&bytes);
}

/* main.rad, and for each other file X.rad an octree X.oct; a name with a dot is a file of
 * another kind. */
static inline pm_scene *scene_of_files(const char *main, const struct file *files, size_t count)
{
    pm_bundle *bundle = pm_bundle_new();
    assert_int_equal(pm_bundle_add(bundle, "main.rad", main, strlen(main), NULL), PM_OK);
    for (size_t i = 0; i < count; i++) {
        char name[64], octree[64];
        bool other = strchr(files[i].name, '.');
        snprintf(name, sizeof name, "%s%s", files[i].name, other ? "" : ".rad");
        assert_int_equal(
            pm_bundle_add(bundle, name, files[i].text, strlen(files[i].text), NULL), PM_OK);
        snprintf(octree, sizeof octree, "%s.oct", files[i].name);
        if (!other)
            add_octree(bundle, octree, name);
    }
    pm_scene *scene = parsed(bundle, "main.rad");
    pm_bundle_free(bundle);
    return scene;
}

#endif
