#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "world/survey.h"

#define WALL "void plastic wall 0 0 5 .7 .7 .7 0 0\n"
#define LAMP "void light lamp 0 0 3 10 10 10\n"

/* A closed room 4 x 5 x 3 that faces inward, and a lamp under its ceiling. */
#define ROOM WALL "!genbox wall room 4 5 3 -i\n"
#define LIT  LAMP "lamp polygon panel 0 0 12 1.5 2 2.9 1.5 3 2.9 2.5 3 2.9 2.5 2 2.9\n"

static pm_survey *survey_of(const char *text)
{
    pm_bundle *bundle = pm_bundle_new();
    pm_scene *scene = NULL;
    pm_world *world = NULL;
    pm_survey *survey = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_bundle_add(bundle, "room.rad", text, strlen(text), NULL), PM_OK);
    pm_status st = pm_scene_parse(bundle, "room.rad", NULL, &scene, &err);
    if (!st)
        st = pm_world_compile(scene, &world, &err);
    if (!st)
        st = pm_survey_make(scene, world, &survey, &err);
    if (st)
        fail_msg("%s", err.text);
    pm_world_free(world);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return survey;
}

/* The scene brings one warning, of that kind at that line, with these words in it. */
static void assert_warning(const char *text, pm_warning_kind kind, int line, const char *words)
{
    pm_survey *survey = survey_of(text);
    if (survey->warning_count != 1)
        fail_msg("%zu warnings; the first: %s", survey->warning_count,
                 survey->warnings[0].text);
    assert_string_equal(pm_warning_kind_name(survey->warnings[0].kind),
                        pm_warning_kind_name(kind));
    if (line)
        assert_int_equal(survey->warnings[0].line, line);
    if (!strstr(survey->warnings[0].text, words))
        fail_msg("'%s' is not in: %s", words, survey->warnings[0].text);
    free(survey);
}

/* CAD programs write many; Radiance warns of them, too. */
static void a_polygon_without_area_is_left_out(void **state)
{
    (void)state;
    assert_warning(ROOM LIT "wall polygon thin 0 0 9 0 0 0 .1 .1 .1 .3 .3 .3\n",
                   PM_WARNING_NO_AREA, 0, "'thin' has no area");
    assert_warning(ROOM LIT "wall polygon point 0 0 9 .7 .1 .1 .7 .1 .1 .7 .1 .1\n",
                   PM_WARNING_NO_AREA, 0, "'point' has no area");
}

static void a_closed_room_brings_no_warning(void **state)
{
    (void)state;
    pm_survey *survey = survey_of(ROOM LIT);
    if (survey->warning_count)
        fail_msg("%s", survey->warnings[0].text);
    assert_true(survey->has_paths);
    assert_true(survey->escaping == 0);
    assert_int_equal(survey->counts[PM_POLYGON], 7);
    assert_int_equal(survey->counts[PM_PLASTIC], 1);
    free(survey);
}

/* Power of a Lambertian panel: pi times radiance times area. */
static void lights_are_listed_by_power(void **state)
{
    (void)state;
    pm_survey *survey = survey_of(ROOM LIT LAMP "lamp sphere bulb 0 0 4 1 1 1 .1\n");
    assert_int_equal(survey->light_count, 2);
    assert_string_equal(survey->lights[0].name, "panel");
    assert_string_equal(survey->lights[0].material, "lamp");
    assert_int_equal(survey->lights[1].type, PM_SPHERE);
    double pi = 3.14159265358979323846;
    assert_true(fabs(survey->lights[0].power - pi * 10) < 1e-9);
    assert_true(fabs(survey->lights[1].power - pi * 10 * 4 * pi * .01) < 1e-9);
    free(survey);
}

static void media_are_counted(void **state)
{
    (void)state;
    pm_survey *survey = survey_of(
        ROOM LIT "void mist fog 0 0 7 .1 .1 .1 .5 .5 .5 0\nfog sphere s 0 0 4 1 1 1 .5\n"
                 "void dielectric ink 0 0 5 .5 .5 .5 1.3 0\n"
                 "ink sphere d 0 0 4 3 4 1 .3\n");
    assert_int_equal(survey->media, 2);
    free(survey);
}

static void a_dark_scene_is_told(void **state)
{
    (void)state;
    assert_warning(ROOM, PM_WARNING_NO_LIGHT, 0, "nothing gives light");
}

/* Without a ceiling. */
static void an_open_room_is_told(void **state)
{
    (void)state;
    assert_warning(WALL "wall polygon floor 0 0 12 0 0 0 4 0 0 4 5 0 0 5 0\n"
                        "wall polygon south 0 0 12 0 0 0 0 0 3 4 0 3 4 0 0\n" LIT,
                   PM_WARNING_OPEN, 0, "paths leave the scene");
}

/* The ceiling is a centimetre short of a wall. */
static void a_gap_is_told(void **state)
{
    (void)state;
    assert_warning(WALL "wall polygon floor 0 0 12 0 0 0 4 0 0 4 5 0 0 5 0\n"
                        "wall polygon south 0 0 12 0 0 0 0 0 3 4 0 3 4 0 0\n"
                        "wall polygon north 0 0 12 0 5 0 4 5 0 4 5 3 0 5 3\n"
                        "wall polygon west 0 0 12 0 0 0 0 5 0 0 5 3 0 0 3\n"
                        "wall polygon east 0 0 12 4 0 0 4 0 3 4 5 3 4 5 0\n"
                        "wall polygon ceiling 0 0 12 0 0 3 0 4.99 3 4 4.99 3 4 0 3\n" LIT,
                   PM_WARNING_LEAK, 0, "through a gap");
}

static void a_room_under_a_sky_may_be_open(void **state)
{
    (void)state;
    pm_survey *survey =
        survey_of(WALL "wall polygon floor 0 0 12 0 0 0 4 0 0 4 5 0 0 5 0\n" LIT
                       "void glow sky 0 0 4 1 1 1 0\nsky source dome 0 0 4 0 0 1 180\n");
    assert_int_equal(survey->warning_count, 0);
    assert_true(survey->escaping > .5);
    free(survey);
}

static void a_lamp_that_faces_away_is_told(void **state)
{
    (void)state;
    pm_survey *survey = survey_of(ROOM LIT "lamp polygon sign 0 0 9 0 0 3.1 1 0 3.1 1 1 3.1\n");
    bool told = false;
    for (size_t i = 0; i < survey->warning_count; i++)
        told |= survey->warnings[i].kind == PM_WARNING_LIGHT_AWAY &&
                strstr(survey->warnings[i].text, "'sign'");
    assert_true(told);
    free(survey);
}

/* A panel that looks at the ceiling right above it. */
static void a_covered_lamp_is_told(void **state)
{
    (void)state;
    assert_warning(ROOM LAMP "lamp polygon panel 0 0 12 1.5 2 2.9999 2.5 2 2.9999 2.5 3 2.9999 "
                             "1.5 3 2.9999\n",
                   PM_WARNING_COVERED, 4, "right in front of it");
}

static void a_polygon_that_is_not_flat_is_told(void **state)
{
    (void)state;
    assert_warning(ROOM LIT "wall polygon warped 0 0 12 1 1 1 2 1 1 2 2 1.1 1 2 1\n",
                   PM_WARNING_NOT_FLAT, 5, "'warped' is not flat");
}

static void paint_that_is_too_white_is_told(void **state)
{
    (void)state;
    assert_warning(ROOM LIT "void plastic snow 0 0 5 .97 .97 .97 0 0\n"
                            "snow sphere ball 0 0 4 1 1 1 .5\n",
                   PM_WARNING_BRIGHT, 5, "'snow' reflects 97 %");
}

static void a_pattern_above_1_is_told(void **state)
{
    (void)state;
    assert_warning(ROOM LIT "void brightfunc loud 2 3*noise3(Px,Py,Pz)+3 . 0 0\n"
                            "loud plastic paint 0 0 5 .7 .7 .7 0 0\n"
                            "paint sphere ball 0 0 4 1 1 1 .5\n",
                   PM_WARNING_PATTERN, 6, "cut at 1");
}

static void millimetres_are_told(void **state)
{
    (void)state;
    assert_warning(WALL "!genbox wall room 4000 5000 3000 -i\n" LAMP
                        "lamp sphere bulb 0 0 4 2000 2500 2000 60\n",
                   PM_WARNING_UNIT, 0, "looks like millimetres");
}

/* Five of a kind are told; the last says how many more there are. */
static void many_warnings_of_a_kind_are_counted(void **state)
{
    (void)state;
    pm_survey *survey = survey_of(
        ROOM LIT
        "void plastic snow 0 0 5 .97 .97 .97 0 0\nvoid plastic s1 0 0 5 .97 .97 .97 0 0\n"
        "void plastic s2 0 0 5 .97 .97 .97 0 0\nvoid plastic s3 0 0 5 .97 .97 .97 0 0\n"
        "void plastic s4 0 0 5 .97 .97 .97 0 0\nvoid plastic s5 0 0 5 .97 .97 .97 0 0\n"
        "void plastic s6 0 0 5 .97 .97 .97 0 0\n");
    assert_int_equal(survey->warning_count, 5);
    assert_non_null(strstr(survey->warnings[4].text, "; and 2 more like this"));
    free(survey);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_closed_room_brings_no_warning),
        cmocka_unit_test(a_polygon_without_area_is_left_out),
        cmocka_unit_test(lights_are_listed_by_power),
        cmocka_unit_test(media_are_counted),
        cmocka_unit_test(a_dark_scene_is_told),
        cmocka_unit_test(an_open_room_is_told),
        cmocka_unit_test(a_gap_is_told),
        cmocka_unit_test(a_room_under_a_sky_may_be_open),
        cmocka_unit_test(a_lamp_that_faces_away_is_told),
        cmocka_unit_test(a_covered_lamp_is_told),
        cmocka_unit_test(a_polygon_that_is_not_flat_is_told),
        cmocka_unit_test(paint_that_is_too_white_is_told),
        cmocka_unit_test(a_pattern_above_1_is_told),
        cmocka_unit_test(millimetres_are_told),
        cmocka_unit_test(many_warnings_of_a_kind_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
