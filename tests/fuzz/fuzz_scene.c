/* Parses the input as a scene, beside a file that its `!xform` lines can name, and checks what
 * the header promises of the result. LLVM's libFuzzer calls it, and replay.c. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(bool promise)
{
    if (!promise)
        abort();
}

static void check_primitive(const pm_scene *scene, size_t index)
{
    const pm_primitive *p = &scene->primitives[index];
    check(p->type < PM_PRIMITIVE_TYPES && p->file < scene->file_count);
    check(p->name && p->line > 0 && p->column > 0);
    check(p->modifier >= PM_VOID && p->modifier < (int32_t)index);
    check(p->material >= PM_VOID && p->material <= (int32_t)index && p->depth > 0);
    for (uint32_t i = 0; i < p->string_count; i++) {
        check(p->strings[i] != NULL);
        check(!p->references ||
              (p->references[i] >= PM_VOID && p->references[i] < (int32_t)index));
    }
    for (uint32_t i = 0; i < p->real_count; i++)
        check(isfinite(p->reals[i]));
}

static void check_error(const pm_error *err, pm_status st)
{
    check(err->status == st && err->text[0]);
    check(memchr(err->text, '\0', sizeof err->text) != NULL);
    check(!err->file[0] || err->line > 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char part[] = "void dielectric ice 0 0 5 .9 .9 .9 1.3 0\n"
                               "ice cone c 0 0 8 0 0 0 0 0 1 1 .5\n"
                               "ice polygon p 0 0 9 0 0 0 1 0 0 1 1 0\n";
    static const char circle[] = "!xform -mx main.rad\n";
    static const char list[] = "-t 1 0 0\n# second\n!xform -n b -rz 20 -a 2 -s \\\n 2\n";
    const pm_scene_limits limits = {
        .primitives = 2000, .reals = 20000, .bytes = 4 << 20, .nesting = 8};
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_bundle *bundle = pm_bundle_new();
    check(bundle && !pm_bundle_add(bundle, "main.rad", data, size, NULL) &&
          !pm_bundle_add(bundle, "part.rad", part, sizeof part - 1, NULL) &&
          !pm_bundle_add(bundle, "circle.rad", circle, sizeof circle - 1, NULL) &&
          !pm_bundle_add(bundle, "list.txt", list, sizeof list - 1, NULL));
    pm_status st = pm_scene_parse(bundle, "main.rad", &limits, &scene, &err);
    if (st)
        check_error(&err, st);
    else
        for (size_t i = 0; i < scene->count; i++)
            check_primitive(scene, i);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return 0;
}
