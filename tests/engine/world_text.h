#ifndef PM_TESTS_WORLD_TEXT_H
#define PM_TESTS_WORLD_TEXT_H

#include <string.h>

#include "../support/bundle_text.h"
#include "scene/bundle.h"
#include "scene/scene.h"
#include "world/world.h"

/* For tests that need a world: compiles a scene given as text, whose lines
 * `#file NAME` start the files that it names. Include after <cmocka.h>. */
static inline pm_world *world_of(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_bundle *bundle = pm_bundle_new();
    assert_non_null(bundle);
    pm_status st = add_texts(bundle, "test.rad", text, &err);
    if (!st)
        st = pm_scene_parse(bundle, "test.rad", NULL, &scene, &err);
    if (!st)
        st = pm_world_compile(scene, &world, &err);
    if (st)
        fail_msg("%s:%d: %s", err.file, err.line, err.text);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return world;
}

/* A closed box with the given modifier, [-1, 1]^3. */
#define TEST_BOX(modifier)                                                                     \
    modifier " polygon box1 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n" modifier                 \
             " polygon box2 0 0 12 -1 -1 1 1 -1 1 1 1 1 -1 1 1\n" modifier                     \
             " polygon box3 0 0 12 -1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1\n" modifier                 \
             " polygon box4 0 0 12 -1 1 -1 -1 1 1 1 1 1 1 1 -1\n" modifier                     \
             " polygon box5 0 0 12 -1 -1 -1 -1 -1 1 -1 1 1 -1 1 -1\n" modifier                 \
             " polygon box6 0 0 12 1 -1 -1 1 1 -1 1 1 1 1 -1 1\n"

#endif
