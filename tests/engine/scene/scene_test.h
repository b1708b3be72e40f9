#ifndef SCENE_TEST_H
#define SCENE_TEST_H

/* What the tests of engine/scene share. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene.h"

/* A bundle of `main.rad` and, unless NULL, `part.rad`. */
static inline pm_bundle *bundle_of(const char *main_text, const char *part_text)
{
    pm_bundle *bundle = pm_bundle_new();
    assert_non_null(bundle);
    assert_int_equal(pm_bundle_add(bundle, "main.rad", main_text, strlen(main_text), NULL),
                     PM_OK);
    if (part_text)
        assert_int_equal(pm_bundle_add(bundle, "part.rad", part_text, strlen(part_text), NULL),
                         PM_OK);
    return bundle;
}

/* Parses texts that must be right. */
static inline pm_scene *scene_of(const char *main_text, const char *part_text)
{
    pm_bundle *bundle = bundle_of(main_text, part_text);
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_status st = pm_scene_parse(bundle, "main.rad", NULL, &scene, &err);
    if (st) {
        char text[1200];
        pm_error_format(&err, text, sizeof text);
        fail_msg("%s", text);
    }
    pm_bundle_free(bundle);
    return scene;
}

/* The first primitive of that name. */
static inline const pm_primitive *named(const pm_scene *scene, const char *name)
{
    for (size_t i = 0; i < scene->count; i++)
        if (strcmp(scene->primitives[i].name, name) == 0)
            return &scene->primitives[i];
    fail_msg("no primitive is named %s", name);
    return NULL;
}

static inline void assert_reals(const pm_primitive *primitive, const double *expected,
                                size_t count)
{
    assert_int_equal(primitive->real_count, count);
    for (size_t i = 0; i < count; i++)
        if (!(primitive->reals[i] == expected[i]))
            fail_msg("real %zu of %s is %.17g, not %.17g", i, primitive->name,
                     primitive->reals[i], expected[i]);
}

#define ASSERT_REALS(primitive, ...)                                                           \
    assert_reals(primitive, (const double[]){__VA_ARGS__},                                     \
                 sizeof((const double[]){__VA_ARGS__}) / sizeof(double))

#endif
