#ifndef PM_TESTS_WORLD_COMPILE_H
#define PM_TESTS_WORLD_COMPILE_H

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/bundle.h"
#include "scene/scene.h"
#include "world/world.h"

/* Include after <cmocka.h>. */

static inline pm_scene *scene_of(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_bundle *bundle = pm_bundle_new();
    pm_status st = pm_bundle_add(bundle, "test.rad", text, strlen(text), &err);
    if (!st)
        st = pm_scene_parse(bundle, "test.rad", NULL, &scene, &err);
    if (st)
        fail_msg("%s:%d:%d: %s", err.file, err.line, err.column, err.text);
    pm_bundle_free(bundle);
    return scene;
}

static inline pm_status compile_text(const char *text, pm_world **world, pm_error *err)
{
    pm_scene *scene = scene_of(text);
    pm_status st = pm_world_compile(scene, world, err);
    pm_scene_free(scene);
    return st;
}

/* Scene text that grows. */
struct text {
    char *data;
    size_t size, capacity;
};

__attribute__((format(printf, 2, 3))) static inline void add(struct text *t, const char *format,
                                                             ...)
{
    enum { MOST = 4096 };
    if (t->size + MOST > t->capacity) {
        t->capacity = 2 * t->capacity + MOST;
        t->data = realloc(t->data, t->capacity);
        assert_non_null(t->data);
    }
    va_list args;
    va_start(args, format);
    int wrote = vsnprintf(t->data + t->size, MOST, format, args);
    va_end(args);
    assert_in_range(wrote, 0, MOST - 1);
    t->size += (size_t)wrote;
}

#endif
