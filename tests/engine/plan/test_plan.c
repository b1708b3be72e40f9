#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "plan/plan.h"

#define LAMP  "void light bright 0 0 3 1 1 1\nbright sphere lamp 0 0 4 0 0 0 .1\n"
#define FLOOR "void plastic grey 0 0 5 .5 .5 .5 0 0\ngrey ring floor 0 0 8 0 0 -1 0 0 1 0 2\n"
#define BALL  "void dielectric clear 0 0 5 1 1 1 1.5 0\nclear sphere ball 0 0 4 0 0 -.5 .2\n"
#define MIST  "void mist fog 0 0 7 1 1 1 .5 .5 .5 0\nfog sphere cloud 0 0 4 0 0 0 3\n"

static pm_wanted all_maps(void)
{
    pm_wanted wanted = {.estimator = PM_NEAREST, .ambient_bounces = 1};
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        wanted.maps[kind] = (pm_map_wanted){.wanted = true, .count = 1000};
    return wanted;
}

static pm_plan plan_of(const char *scene, const pm_wanted *wanted)
{
    pm_plan plan;
    pm_error err = PM_ERROR_INIT;
    pm_world *world = world_of(scene);
    assert_int_equal(pm_plan_make(world, wanted, &plan, &err), PM_OK);
    pm_world_free(world);
    return plan;
}

static void expect(const pm_plan *plan, int kind, bool needed, const char *reason)
{
    assert_int_equal(plan->pass[kind].needed, needed);
    assert_string_equal(plan->pass[kind].reason, reason);
}

static void a_diffuse_room_needs_the_global_pass_alone(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    pm_plan plan = plan_of(LAMP FLOOR, &wanted);
    expect(&plan, PM_MAP_GLOBAL, true,
           "global pass: light between surfaces, of which 1 scatters diffusely");
    expect(&plan, PM_MAP_CAUSTIC, false,
           "no caustic pass: no surface reflects or refracts specularly");
    expect(&plan, PM_MAP_VOLUME, false, "no volume pass: no mist");
}

static void glass_adds_the_caustic_pass_and_mist_the_volume_pass(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    pm_plan plan = plan_of(LAMP FLOOR BALL MIST, &wanted);
    expect(&plan, PM_MAP_CAUSTIC, true,
           "caustic pass: 1 surface reflects or refracts specularly");
    expect(&plan, PM_MAP_VOLUME, true, "volume pass: 1 surface bounds mist");
}

static void a_caustic_needs_a_surface_to_fall_on(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    pm_plan plan = plan_of(LAMP BALL, &wanted);
    expect(&plan, PM_MAP_GLOBAL, false, "no global pass: no surface scatters light diffusely");
    expect(&plan, PM_MAP_CAUSTIC, false,
           "no caustic pass: no diffuse surface that a caustic could fall on");
}

static void a_dark_scene_needs_no_pass(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    pm_plan plan = plan_of(FLOOR BALL MIST, &wanted);
    expect(&plan, PM_MAP_GLOBAL, false, "no global pass: nothing in the scene emits light");
    expect(&plan, PM_MAP_CAUSTIC, false, "no caustic pass: nothing in the scene emits light");
    expect(&plan, PM_MAP_VOLUME, false, "no volume pass: nothing in the scene emits light");
}

static void a_map_that_nobody_asked_for_is_left_out(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    wanted.maps[PM_MAP_CAUSTIC].wanted = false;
    pm_plan plan = plan_of(LAMP FLOOR BALL, &wanted);
    expect(&plan, PM_MAP_CAUSTIC, false, "no caustic pass: no caustic map was asked for");
}

static void counts_are_carried_with_the_default_gather_count(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    wanted.maps[PM_MAP_CAUSTIC].gather_count = 7;
    pm_plan plan = plan_of(LAMP FLOOR BALL, &wanted);
    assert_int_equal(plan.pass[PM_MAP_GLOBAL].count, 1000);
    assert_int_equal(plan.pass[PM_MAP_GLOBAL].gather_count, 40);
    assert_int_equal(plan.pass[PM_MAP_CAUSTIC].gather_count, 7);
}

static void progressive_jobs_take_what_the_scene_offers(void **state)
{
    (void)state;
    pm_wanted wanted = {.estimator = PM_PROGRESSIVE, .ambient_bounces = 1};
    pm_plan plan = plan_of(LAMP FLOOR BALL MIST, &wanted);
    for (int kind = 0; kind < PM_MAP_DIRECT; kind++)
        assert_true(plan.pass[kind].needed);
    expect(&plan, PM_MAP_DIRECT, false, "no direct pass: next events bring direct light");
    wanted.ambient_bounces = 0;
    plan = plan_of(LAMP FLOOR BALL MIST, &wanted);
    expect(&plan, PM_MAP_GLOBAL, false,
           "no global pass: -ab 0 asks for no light between diffuse surfaces");
    assert_true(plan.pass[PM_MAP_CAUSTIC].needed && plan.pass[PM_MAP_VOLUME].needed);
}

static void refuse(const pm_wanted *wanted, const char *text)
{
    pm_world *world = world_of(LAMP FLOOR);
    pm_plan plan, untouched;
    memset(&plan, 0x5A, sizeof plan);
    untouched = plan;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_plan_make(world, wanted, &plan, &err), PM_E_RANGE);
    assert_string_equal(err.text, text);
    assert_memory_equal(&plan, &untouched, sizeof plan);
    pm_world_free(world);
}

static void counts_out_of_range_are_refused(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    wanted.maps[PM_MAP_CAUSTIC].count = 0;
    refuse(&wanted, "a caustic map of 0 photons; it can have 1 to 2000000000");
    wanted.maps[PM_MAP_CAUSTIC].count = UINT64_C(2000000001);
    refuse(&wanted, "a caustic map of 2000000001 photons; it can have 1 to 2000000000");
    wanted = all_maps();
    wanted.maps[PM_MAP_GLOBAL].gather_count = 16385;
    refuse(&wanted, "16385 photons an estimate of the global map; at most 16384");
}

static void maps_from_files_need_no_count(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    wanted.maps[PM_MAP_GLOBAL] = (pm_map_wanted){.wanted = true, .from_file = true};
    pm_plan plan = plan_of(LAMP FLOOR, &wanted);
    assert_int_equal(plan.pass[PM_MAP_GLOBAL].gather_count, 40);
    wanted.maps[PM_MAP_GLOBAL].gather_count = 16385;
    refuse(&wanted, "16385 photons an estimate of the global map; at most 16384");
}

static void sensors_need_no_diffuse_surface(void **state)
{
    (void)state;
    pm_wanted wanted = all_maps();
    pm_plan plan = plan_of(LAMP BALL, &wanted);
    assert_false(plan.pass[PM_MAP_GLOBAL].needed || plan.pass[PM_MAP_CAUSTIC].needed ||
                 plan.pass[PM_MAP_DIRECT].needed);
    wanted.sensors = true;
    plan = plan_of(LAMP BALL, &wanted);
    assert_true(plan.pass[PM_MAP_GLOBAL].needed && plan.pass[PM_MAP_CAUSTIC].needed &&
                plan.pass[PM_MAP_DIRECT].needed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_diffuse_room_needs_the_global_pass_alone),
        cmocka_unit_test(glass_adds_the_caustic_pass_and_mist_the_volume_pass),
        cmocka_unit_test(a_caustic_needs_a_surface_to_fall_on),
        cmocka_unit_test(a_dark_scene_needs_no_pass),
        cmocka_unit_test(a_map_that_nobody_asked_for_is_left_out),
        cmocka_unit_test(counts_are_carried_with_the_default_gather_count),
        cmocka_unit_test(sensors_need_no_diffuse_surface),
        cmocka_unit_test(progressive_jobs_take_what_the_scene_offers),
        cmocka_unit_test(counts_out_of_range_are_refused),
        cmocka_unit_test(maps_from_files_need_no_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
