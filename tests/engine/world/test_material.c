#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"

/* ---- what is refused ---- */

static void check_refused(const char *text, int line, const char *words)
{
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_bundle *bundle = pm_bundle_new();
    assert_non_null(bundle);
    assert_int_equal(pm_bundle_add(bundle, "bad.rad", text, strlen(text), &err), PM_OK);
    assert_int_equal(pm_scene_parse(bundle, "bad.rad", NULL, &scene, &err), PM_OK);
    assert_int_equal(pm_world_compile(scene, &world, &err), PM_E_UNSUPPORTED);
    assert_string_equal(err.file, "bad.rad");
    assert_int_equal(err.line, line);
    if (!strstr(err.text, words))
        fail_msg("'%s' does not say '%s'", err.text, words);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
}

static void lights_cannot_be_cut_or_stand_in(void **state)
{
    (void)state;
    check_refused("void light l 0 0 3 1 1 1\nvoid antimatter a 2 void l 0 0\n"
                  "a sphere s 0 0 4 0 0 0 1",
                  2, "cannot be cut");
    check_refused("void antimatter b 1 void 0 0\nvoid antimatter a 2 void b 0 0\n"
                  "a sphere s 0 0 4 0 0 0 1",
                  2, "cannot be cut");
    check_refused("void light g 0 0 3 1 1 1\nvoid mirror i 1 g 0 3 1 1 1\n"
                  "i ring s 0 0 8 0 0 0 0 0 1 0 1",
                  2, "shown instead");
}

static void distant_spotlights_are_refused(void **state)
{
    (void)state;
    check_refused("void spotlight l 0 0 7 1 1 1 30 0 0 1\nl source s 0 0 4 0 0 1 .5", 2,
                  "distant source");
}

/* ---- what is found ---- */

static pm_world_info info_of(const char *text)
{
    pm_world *world = world_of(text);
    pm_world_info info;
    pm_world_info_get(world, &info);
    pm_world_free(world);
    return info;
}

/* The plan leaves passes out by these counts. */
static void abilities_are_those_of_the_lobes(void **state)
{
    (void)state;
    const struct {
        const char *material;
        size_t specular, diffuse, mists;
    } cases[] = {
        {"void plastic m 0 0 5 .5 .5 .5 0 0", 0, 1, 0},
        {"void plastic m 0 0 5 .5 .5 .5 .1 .2", 1, 1, 0},
        {"void plastic m 0 0 5 0 0 0 .1 .2", 1, 0, 0},
        {"void metal m 0 0 5 .5 .5 .5 1 0", 1, 0, 0},
        {"void metal m 0 0 5 0 0 0 .9 0", 0, 0, 0},
        {"void trans m 0 0 7 .5 .5 .5 0 0 .5 1", 0, 1, 0},
        {"void trans m 0 0 7 .5 .5 .5 0 0 1 1", 0, 0, 0},
        {"void trans m 0 0 7 .5 .5 .5 0 .1 1 1", 1, 0, 0},
        {"void glass m 0 0 3 .5 .5 .5", 1, 0, 0},
        {"void dielectric m 0 0 5 1 1 1 1.5 0", 1, 0, 0},
        {"void mirror m 0 0 3 .5 .5 .5", 1, 0, 0},
        {"void light m 0 0 3 1 1 1", 0, 0, 0},
        {"void illum m 0 0 3 1 1 1", 0, 0, 0},
        {"void plastic p 0 0 5 .5 .5 .5 0 0\nvoid illum m 1 p 0 3 1 1 1", 0, 1, 0},
        {"void mist m 0 0 6 1 1 1 .5 .5 .5", 0, 0, 1},
        {"void mist m 0 0 3 1 1 1", 0, 0, 0}, /* absorbs only */
        {"void antimatter m 1 void 0 0", 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[200];
        snprintf(text, sizeof text, "%s\nm sphere s 0 0 4 0 0 0 1", cases[i].material);
        pm_world_info info = info_of(text);
        if (info.specular_surfaces != cases[i].specular ||
            info.diffuse_surfaces != cases[i].diffuse || info.mist_surfaces != cases[i].mists)
            fail_msg("%s: specular %zu, diffuse %zu, mist %zu", cases[i].material,
                     info.specular_surfaces, info.diffuse_surfaces, info.mist_surfaces);
    }
}

static void lights_are_counted_that_light_something(void **state)
{
    (void)state;
    pm_world_info info = info_of("void light a 0 0 3 1 1 1 a sphere s 0 0 4 0 0 0 1\n"
                                 "void light b 0 0 3 0 0 0 b sphere t 0 0 4 3 0 0 1\n"
                                 "void glow c 0 0 4 1 1 1 -1 c sphere u 0 0 4 6 0 0 1\n"
                                 "void glow d 0 0 4 1 1 1 0 d source v 0 0 4 0 0 1 180\n"
                                 "void illum e 0 0 3 1 1 1 e sphere w 0 0 4 9 0 0 1");
    assert_int_equal(info.lights, 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_cannot_be_cut_or_stand_in),
        cmocka_unit_test(distant_spotlights_are_refused),
        cmocka_unit_test(abilities_are_those_of_the_lobes),
        cmocka_unit_test(lights_are_counted_that_light_something),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
