#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "../world_text.h"
#include "forward/forward.h"

/* What options do to the photons of a forward pass. */

#define LAMP "void light bright 0 0 3 5 4 3\nbright ring lamp 0 0 8 0 0 .9 0 0 -1 0 .3\n"

/* Less than four photons a path: all deposits are stored, whatever is left out. The table's
 * materials differ in name alone. */
static const char room[] = "void plastic grey 0 0 5 .5 .5 .5 0 0\n" TEST_BOX("grey") LAMP
    "void plastic oak 0 0 5 .5 .5 .5 0 0\nvoid alias board oak\n"
    "board polygon table 0 0 12 -.5 -.5 -.4 .5 -.5 -.4 .5 .5 -.4 -.5 .5 -.4\n"
    "void antimatter sheet 1 void 0 0\n"
    "sheet polygon plane 0 0 12 -.6 -.6 .2 -.6 .6 .2 .6 .6 .2 .6 -.6 .2\n";

struct fixture {
    pm_world *world;
    pm_pool *pool;
    pm_forward *forward;
};

static struct fixture open_scene(const char *scene, const pm_forward_options *options)
{
    struct fixture f = {.world = world_of(scene), .pool = pm_pool_new(1)};
    pm_error err = PM_ERROR_INIT;
    if (pm_forward_new(f.world, options, f.pool, &f.forward, &err))
        fail_msg("%s", err.text);
    return f;
}

static void close_scene(struct fixture *f)
{
    assert_int_equal(pm_forward_nonfinite(f->forward), 0);
    pm_forward_free(f->forward);
    pm_pool_free(f->pool);
    pm_world_free(f->world);
}

/* The first batch of a kind; to be cleared. */
static pm_batch batch_of(const char *scene, const pm_forward_options *options, pm_map_kind kind)
{
    struct fixture f = open_scene(scene, options);
    pm_batch out[PM_MAP_KINDS] = {0};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_forward_batch(f.forward, 0, 1U << kind, f.pool, NULL, NULL, out, &err),
                     PM_OK);
    assert_true(pm_forward_storage_probability(f.forward, kind) == 1);
    close_scene(&f);
    return out[kind];
}

static bool same_photon(const pm_photon *a, const pm_photon *b)
{
    return !memcmp(a, b, sizeof *a);
}

/* The photons of `all` that `keeps`, in their order, are those of `some`, byte for byte. */
static void assert_kept(const pm_batch *all, const pm_batch *some,
                        bool (*keeps)(const pm_photon *photon))
{
    size_t at = 0;
    for (size_t i = 0; i < all->count; i++) {
        if (!keeps(&all->photons[i]))
            continue;
        assert_true(at < some->count);
        assert_true(same_photon(&all->photons[i], &some->photons[at++]));
    }
    assert_int_equal(at, some->count);
    assert_true(at > 100 && at < all->count);
}

static void check_part(const pm_forward_options *options,
                       bool (*keeps)(const pm_photon *photon))
{
    pm_forward_options defaults = pm_forward_defaults();
    pm_batch all = batch_of(room, &defaults, PM_MAP_GLOBAL);
    pm_batch some = batch_of(room, options, PM_MAP_GLOBAL);
    assert_kept(&all, &some, keeps);
    assert_memory_equal(&all.escaped, &some.escaped, sizeof all.escaped);
    assert_memory_equal(&all.absorbed, &some.absorbed, sizeof all.absorbed);
    pm_batch_clear(&all);
    pm_batch_clear(&some);
}

/* ---- where photons are stored ---- */

static bool lies_on_table(const pm_photon *photon)
{
    pm_vec3 p = pm_photon_position(photon);
    return fabs(p.z + .4) < 1e-6 && fabs(p.x) <= .5 && fabs(p.y) <= .5;
}

static bool lies_elsewhere(const pm_photon *photon)
{
    return !lies_on_table(photon);
}

static void included_surfaces_alone_store(void **state)
{
    (void)state;
    static const char *const names[] = {"board"};
    pm_forward_options options = pm_forward_defaults();
    options.include = (pm_name_list){names, 1};
    check_part(&options, lies_on_table);
}

static void excluded_surfaces_store_nothing(void **state)
{
    (void)state;
    static const char *const names[] = {"board"};
    pm_forward_options options = pm_forward_defaults();
    options.exclude = (pm_name_list){names, 1};
    check_part(&options, lies_elsewhere);
}

static const pm_region two_regions[] = {{.low = {1, 1, 1}, .high = {.2, -1, -1}},
                                        {.is_ball = true, .center = {-1, 0, 0}, .radius = .7}};

/* World and scene coordinates are the same here. Photons within rounding of a boundary would
 * make the comparison unsure; there are none. */
static bool lies_in_regions(const pm_photon *photon)
{
    pm_vec3 p = pm_photon_position(photon);
    pm_vec3 v = pm_vec3_sub(p, two_regions[1].center);
    double length = sqrt(pm_vec3_dot(v, v));
    assert_true(fabs(p.x - .2) > 1e-8 && fabs(length - .7) > 1e-8);
    return p.x > .2 || length < .7;
}

static void photons_outside_all_regions_are_not_stored(void **state)
{
    (void)state;
    pm_forward_options options = pm_forward_defaults();
    options.regions = two_regions;
    options.region_count = 2;
    check_part(&options, lies_in_regions);
}

static void regions_are_in_scene_units(void **state)
{
    (void)state;
    static const char scene[] = "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
                                "!xform -s 100 -t 300 0 0 box.rad\n"
                                "#file box.rad\n" TEST_BOX("grey") LAMP;
    static const pm_region half = {.low = {200, -100, -100}, .high = {300, 100, 100}};
    pm_forward_options options = pm_forward_defaults();
    options.regions = &half;
    options.region_count = 1;
    pm_world *world = world_of(scene);
    pm_batch some = batch_of(scene, &options, PM_MAP_GLOBAL);
    assert_true(some.count > 1000);
    for (size_t i = 0; i < some.count; i++)
        assert_true(pm_world_to_scene(world, pm_photon_position(&some.photons[i])).x < 300.001);
    pm_batch_clear(&some);
    pm_world_free(world);
}

/* ---- sensors ---- */

static bool lies_in_sheet(const pm_photon *photon)
{
    return fabs(pm_photon_position(photon).z - .2) < 1e-6;
}

static bool lies_on_wall_or_table(const pm_photon *photon)
{
    return !lies_in_sheet(photon) || fabs(pm_photon_position(photon).x) > .9999 ||
           fabs(pm_photon_position(photon).y) > .9999;
}

/* The sheet's front faces down (its corners turn clockwise seen from above), so it stores what
 * comes from below; paths stay the same. */
static void a_sensor_stores_what_comes_to_its_front_and_lets_it_pass(void **state)
{
    (void)state;
    static const char *const names[] = {"sheet"};
    pm_forward_options defaults = pm_forward_defaults(), options = defaults;
    options.sensors = (pm_name_list){names, 1};
    pm_batch without = batch_of(room, &defaults, PM_MAP_GLOBAL);
    pm_batch with = batch_of(room, &options, PM_MAP_GLOBAL);
    assert_kept(&with, &without, lies_on_wall_or_table);
    size_t found = 0;
    for (size_t i = 0; i < with.count; i++) {
        if (lies_on_wall_or_table(&with.photons[i]))
            continue;
        assert_true(pm_photon_normal(&with.photons[i]).z < -.99);
        assert_true(pm_photon_direction(&with.photons[i]).z < 1e-4);
        found++;
    }
    assert_true(found > 1000);
    pm_batch_clear(&without);
    pm_batch_clear(&with);
}

/* ---- the length of paths ---- */

/* The lamp lies .9 above the centre and has a radius of .3. A photon's way is at least the
 * straight one from there. */
static void no_photon_lies_beyond_the_greatest_length(void **state)
{
    (void)state;
    pm_forward_options options = pm_forward_defaults();
    options.max_length = 2.2;
    pm_batch cut = batch_of(room, &options, PM_MAP_GLOBAL);
    assert_true(cut.count > 100);
    for (size_t i = 0; i < cut.count; i++) {
        pm_vec3 p = pm_photon_position(&cut.photons[i]);
        double low = fmax(0, hypot(p.x, p.y) - .3);
        assert_true(hypot(low, p.z - .9) <= 2.2 + 1e-6);
    }
    pm_rgb sum = pm_rgb_add(cut.absorbed, cut.escaped);
    assert_true(fabs(sum.g / cut.emitted.g - 1) < .02);
    pm_batch_clear(&cut);
}

static void a_length_that_no_path_reaches_changes_nothing(void **state)
{
    (void)state;
    pm_forward_options defaults = pm_forward_defaults(), options = defaults;
    options.max_length = 1e6;
    pm_batch a = batch_of(room, &defaults, PM_MAP_GLOBAL);
    pm_batch b = batch_of(room, &options, PM_MAP_GLOBAL);
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.photons, b.photons, a.count * sizeof *a.photons);
    pm_batch_clear(&a);
    pm_batch_clear(&b);
}

/* A parallel sun through nothing: to a floor .5 below the top of the cube and back to a
 * ceiling. What counts is the way within the cube, wherever the engine starts the rays. */
static void distant_light_starts_where_it_enters_the_cube(void **state)
{
    (void)state;
    static const char scene[] = "void light sun 0 0 3 1 1 1\nsun source s 0 0 4 0 0 1 .5\n"
                                "void mirror flat 0 0 3 1 1 1\n"
                                "void plastic grey 0 0 5 .5 .5 .5 0 0\n"
                                "void metal shiny 0 0 5 .9 .9 .9 1 0\n"
                                "shiny polygon floor 0 0 12 -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1\n"
                                "grey polygon roof 0 0 12 -1 -1 1 -1 0 1 1 0 1 1 -1 1\n";
    pm_forward_options options = pm_forward_defaults();
    options.max_length = 1.9;
    pm_batch near = batch_of(scene, &options, PM_MAP_CAUSTIC);
    options.max_length = 4.1;
    pm_batch far = batch_of(scene, &options, PM_MAP_CAUSTIC);
    assert_int_equal(near.count, 0);
    assert_true(far.count > 10);
    pm_batch_clear(&near);
    pm_batch_clear(&far);
}

/* ---- families ---- */

static pm_digest family_of(const char *scene, const pm_forward_options *options)
{
    struct fixture f = open_scene(scene, options);
    pm_digest family = pm_forward_family(f.forward, PM_MAP_GLOBAL);
    close_scene(&f);
    return family;
}

static const pm_region box = {.low = {0, 0, 0}, .high = {1, 1, 1}};
static const pm_region turned_box = {.low = {1, 0, 1}, .high = {-0., 1, 0}};
static const pm_region ball = {.is_ball = true, .radius = 1};
static const pm_region both[] = {{.is_ball = true, .radius = 1},
                                 {.low = {0, 0, 0}, .high = {1, 1, 1}},
                                 {.is_ball = true, .radius = 1}};
static const pm_region both_turned[] = {{.low = {1, 0, 1}, .high = {0, 1, 0}},
                                        {.is_ball = true, .radius = 1}};

enum {
    SEED,
    EVENTS,
    LENGTH,
    SENSORS,
    EXCLUDE,
    INCLUDE,
    BOX,
    BALL,
    BOTH,
    PORT,
    PORT_BACK,
    MANY
};

static pm_forward_options variant(int which)
{
    static const char *const grey[] = {"grey"};
    static const pm_port_option ports[] = {{"sheet", PM_PORT_FRONT}, {"sheet", PM_PORT_BACK}};
    pm_forward_options o = pm_forward_defaults();
    o.seed = which == SEED;
    o.max_events = which == EVENTS ? 7 : 5000;
    o.max_length = which == LENGTH ? 3 : 0;
    o.sensors = (pm_name_list){grey, which == SENSORS};
    o.exclude = (pm_name_list){grey, which == EXCLUDE};
    o.include = (pm_name_list){grey, which == INCLUDE};
    o.regions = which == BALL ? &ball : which == BOTH ? both : &box;
    o.region_count = which == BOX || which == BALL ? 1 : which == BOTH ? 3 : 0;
    o.ports = which == PORT ? ports : ports + 1;
    o.port_count = which == PORT || which == PORT_BACK;
    return o;
}

static void families_differ_for_each_option(void **state)
{
    (void)state;
    pm_digest families[MANY + 1];
    for (int i = 0; i <= MANY; i++) {
        pm_forward_options options = variant(i);
        families[i] = family_of(room, &options);
        for (int j = 0; j < i; j++)
            assert_false(pm_digest_equal(&families[i], &families[j]));
    }
}

static void assert_same_family(const pm_forward_options *a, const pm_forward_options *b)
{
    pm_digest x = family_of(room, a), y = family_of(room, b);
    assert_true(pm_digest_equal(&x, &y));
}

/* The table is board, oak by alias: either name chooses it. */
static void equal_choices_are_one_family_whatever_they_are_called(void **state)
{
    (void)state;
    static const char *const board[] = {"board"}, *const oak[] = {"oak", "board", "oak"};
    pm_forward_options a = pm_forward_defaults(), b = a;
    a.exclude = (pm_name_list){board, 1};
    b.exclude = (pm_name_list){oak, 3};
    assert_same_family(&a, &b);
    a = variant(BOX), b = a;
    b.regions = &turned_box;
    assert_same_family(&a, &b);
    a = variant(BOTH), b = a;
    b.regions = both_turned;
    b.region_count = 2;
    assert_same_family(&a, &b);
}

/* ---- refusals ---- */

static void assert_refused(const pm_forward_options *options, pm_status status,
                           const char *text)
{
    pm_world *world = world_of(room);
    pm_pool *pool = pm_pool_new(1);
    pm_forward *forward = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_forward_new(world, options, pool, &forward, &err), status);
    assert_null(forward);
    if (!strstr(err.text, text))
        fail_msg("%s", err.text);
    pm_pool_free(pool);
    pm_world_free(world);
}

static void options_out_of_range_are_refused(void **state)
{
    (void)state;
    static const double lengths[] = {-1, NAN, INFINITY, 1e31};
    for (int i = 0; i < 4; i++) {
        pm_forward_options options = pm_forward_defaults();
        options.max_length = lengths[i];
        assert_refused(&options, PM_E_RANGE, "on the length of a path");
    }
    static const pm_region bad[] = {{.is_ball = true, .radius = 0},
                                    {.is_ball = true, .radius = -1},
                                    {.is_ball = true, .radius = NAN},
                                    {.is_ball = true, .center = {NAN, 0, 0}, .radius = 1},
                                    {.low = {0, 0, 0}, .high = {1, 1, 0}},
                                    {.low = {0, 0, 0}, .high = {1, NAN, 1}},
                                    {.low = {0, 0, -INFINITY}, .high = {1, 1, 1}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        pm_forward_options options = pm_forward_defaults();
        options.regions = &bad[i];
        options.region_count = 1;
        assert_refused(&options, PM_E_RANGE, "a region is a");
    }
    pm_forward_options options = variant(EXCLUDE);
    options.include = options.exclude;
    assert_refused(&options, PM_E_RANGE, "-ae or -ai alone");
    options = pm_forward_defaults();
    options.max_events = 50001;
    assert_refused(&options, PM_E_RANGE, "at most 50000");
}

static void names_that_no_surface_has_are_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"grey", "gray"};
    pm_forward_options options = pm_forward_defaults();
    options.include = (pm_name_list){names, 2};
    assert_refused(&options, PM_E_MISSING, "-ai: no surface has the modifier 'gray'");
    options.sensors = options.include;
    options.include.count = 0;
    assert_refused(&options, PM_E_MISSING, "-aps: no surface has the modifier 'gray'");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(included_surfaces_alone_store),
        cmocka_unit_test(excluded_surfaces_store_nothing),
        cmocka_unit_test(photons_outside_all_regions_are_not_stored),
        cmocka_unit_test(regions_are_in_scene_units),
        cmocka_unit_test(a_sensor_stores_what_comes_to_its_front_and_lets_it_pass),
        cmocka_unit_test(no_photon_lies_beyond_the_greatest_length),
        cmocka_unit_test(a_length_that_no_path_reaches_changes_nothing),
        cmocka_unit_test(distant_light_starts_where_it_enters_the_cube),
        cmocka_unit_test(families_differ_for_each_option),
        cmocka_unit_test(equal_choices_are_one_family_whatever_they_are_called),
        cmocka_unit_test(options_out_of_range_are_refused),
        cmocka_unit_test(names_that_no_surface_has_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
