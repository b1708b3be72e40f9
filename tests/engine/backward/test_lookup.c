/* Photon maps and final gather in a closed shell whose answer is known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/maths.h"
#include "eye.h"

/* A shell of radius 1 and albedo rho around a black lamp of radius a and radiance L. Radiosity:
 * the shell sees the lamp with form factor a^2, itself with 1 - a^2, so its irradiance is even,
 * E = (Phi / A) / (1 - rho (1 - a^2)), Phi / A = pi L a^2. */
#define SHELL                                                                                  \
    "void light lamp 0 0 3 100 100 100\nlamp sphere ball 0 0 4 0 0 0 .1\n"                     \
    "void plastic wall 0 0 5 .5 .8 .2 0 0\nwall bubble shell 0 0 4 0 0 0 1\n"

static const double albedo[3] = {.5, .8, .2};
static const double direct = PM_PI * 100 * .01;

static double shell_irradiance(int channel)
{
    return direct / (1 - albedo[channel] * .99);
}

/* At the wall, along a line of sight that misses the lamp. */
static const pm_sensor at_wall = {{.5, 0, 0}, {.3, .4, .8}};

static void assert_wall_radiance(const struct measured *m, bool indirect, double sharpness)
{
    for (int c = 0; c < 3; c++)
        assert_measured(m, c, albedo[c] / PM_PI * (indirect ? shell_irradiance(c) : direct),
                        sharpness);
}

static void nearest_photons_give_the_radiosity_of_a_shell(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 4);
    pm_backward_maps maps = {.map = {map}, .gather_count = {2000}, .ambient_bounces = -1};
    struct measured m = sense(world, &maps, PM_RADIANCE, at_wall, 64);
    assert_wall_radiance(&m, true, .25);
    pm_photon_map_free(map);
    pm_world_free(world);
}

static void gather_rays_give_the_radiosity_of_a_shell(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 4);
    pm_backward_maps maps = {.map = {map}, .gather_count = {200}, .ambient_bounces = 1};
    struct measured m = sense(world, &maps, PM_RADIANCE, at_wall, 1024);
    assert_wall_radiance(&m, true, .1);
    pm_photon_map_free(map);
    pm_world_free(world);
}

/* -ab 0 is next event and caustics alone, and there are none. */
static void without_ambient_bounces_direct_light_is_all(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 1);
    pm_backward_maps maps = {.map = {map}, .gather_count = {50}};
    struct measured m = sense(world, &maps, PM_RADIANCE, at_wall, 256);
    assert_wall_radiance(&m, false, .01);
    pm_photon_map_free(map);
    pm_world_free(world);
}

/* 32 progressive passes with photons of their own: two a replicate. */
static pm_accumulation *progressive_passes(const pm_world *world, pm_sensor sensor,
                                           pm_quantity quantity)
{
    pm_accumulation *accumulation = NULL;
    assert_int_equal(
        pm_accumulation_for_sensors(world, &sensor, 1, quantity, 1, &accumulation, NULL),
        PM_OK);
    for (uint32_t pass = 0; pass < 32; pass++) {
        pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, pass, 1);
        double radius = pm_progressive_radius(.1, pass);
        pm_backward_maps maps = {.map = {map},
                                 .radius = {radius, radius, radius},
                                 .progressive = true,
                                 .ambient_bounces = 1};
        run_passes(accumulation, &maps, 1);
        pm_photon_map_free(map);
    }
    return accumulation;
}

static void progressive_passes_give_the_radiosity_of_a_shell(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_accumulation *accumulation = progressive_passes(world, at_wall, PM_RADIANCE);
    struct measured m = measure(accumulation);
    assert_wall_radiance(&m, true, .2);
    pm_accumulation_free(accumulation);
    pm_world_free(world);
}

/* Where one kind of photon is missing its radius is not known, and the other's is taken:
 * nothing fails, and no photon is lost. */
static void unknown_progressive_radius_is_that_of_the_other_kind(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 1);
    pm_backward_maps known = {
        .map = {map}, .radius = {.1, .1}, .progressive = true, .ambient_bounces = 1};
    pm_backward_maps plain = known, specular = known;
    plain.radius[PM_MAP_CAUSTIC] = 0;
    specular.radius[PM_MAP_GLOBAL] = 0;
    struct measured want = sense(world, &known, PM_RADIANCE, at_wall, 16);
    struct measured a = sense(world, &plain, PM_RADIANCE, at_wall, 16);
    struct measured b = sense(world, &specular, PM_RADIANCE, at_wall, 16);
    assert_true(want.value[0] > 1.5 * albedo[0] / PM_PI * direct);
    assert_true(a.value[0] == want.value[0] && b.value[0] == want.value[0]);
    pm_photon_map_free(map);
    pm_world_free(world);
}

/* In free space there is no photon to find: one ray a pass looks at the wall. Facing it, the
 * sensor sees even radiance rho E / pi; facing the lamp at distance d the lamp covers a^2 / d^2
 * of it. */
static void sensor_in_free_space_sees_what_the_walls_send(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 4);
    for (int ab = -1; ab <= 1; ab += 2) {
        pm_backward_maps maps = {.map = {map}, .gather_count = {200}, .ambient_bounces = ab};
        pm_sensor outward = {{.5, 0, 0}, {1, 0, 0}}, inward = {{.5, 0, 0}, {-1, 0, 0}};
        struct measured out = sense(world, &maps, PM_IRRADIANCE, outward, 1024);
        struct measured in = sense(world, &maps, PM_IRRADIANCE, inward, 1024);
        double covered = .01 / .25;
        for (int c = 0; c < 3; c++) {
            double sent = albedo[c] * shell_irradiance(c);
            assert_measured(&out, c, sent, .1);
            assert_measured(&in, c, direct / .25 + sent * (1 - covered), .1);
        }
    }
    pm_photon_map_free(map);
    pm_world_free(world);
}

/* On the wall the photons lie at the sensor itself: all of E. */
static void sensor_on_a_surface_sees_the_photons_there(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 4);
    pm_sensor sensor = {{0, .6, .8}, {0, -.6, -.8}};
    for (int ab = -1; ab <= 1; ab += 2) {
        pm_backward_maps maps = {.map = {map}, .gather_count = {2000}, .ambient_bounces = ab};
        struct measured m = sense(world, &maps, PM_IRRADIANCE, sensor, 512);
        for (int c = 0; c < 3; c++)
            assert_measured(&m, c, shell_irradiance(c), .25);
    }
    pm_photon_map_free(map);
    pm_world_free(world);
}

/* ---- specular paths are counted by one estimator each ---- */

/* A grey box with a lamp on the axis and one wall of metal: its image of the lamp lights the
 * floor as evenly as the lamp, so photon density has nothing to blur. */
#define HALL                                                                                   \
    "void light lamp 0 0 3 10 10 10\nlamp sphere ball 0 0 4 0 0 .2 .3\n"                       \
    "void plastic grey 0 0 5 .5 .5 .5 0 0\nvoid metal shiny 0 0 5 .9 .9 .9 1 0\n"              \
    "grey polygon floor 0 0 12 -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1\n"                           \
    "grey polygon roof 0 0 12 -1 -1 1  -1 1 1  1 1 1  1 -1 1\n"                                \
    "grey polygon left 0 0 12 -1 -1 -1  -1 1 -1  -1 1 1  -1 -1 1\n"                            \
    "shiny polygon right 0 0 12 1 -1 -1  1 -1 1  1 1 1  1 1 -1\n"                              \
    "grey polygon front 0 0 12 -1 -1 -1  -1 -1 1  1 -1 1  1 -1 -1\n"                           \
    "grey polygon back 0 0 12 -1 1 -1  1 1 -1  1 1 1  -1 1 1\n"

static void assert_agree(const struct measured *a, const struct measured *b, double sharpness)
{
    double error = sqrt(a->error[0] * a->error[0] + b->error[0] * b->error[0]);
    if (6 * error > sharpness * a->value[0])
        fail_msg("a blunt test: %g, %g +- %g", a->value[0], b->value[0], 6 * error);
    if (!(fabs(a->value[0] - b->value[0]) <= 6 * error))
        fail_msg("%g is not %g +- %g", a->value[0], b->value[0], 6 * error);
}

/* Every column of the table in plan/plan.h gives the same light on the floor and in free space.
 * A fifth of the floor's light comes by the mirror: to lose it or to count it twice would
 * show. */
static void all_partitions_give_the_same_light(void **state)
{
    (void)state;
    pm_world *world = world_of(HALL);
    pm_photon_map *global = map_of(world, PM_MAP_GLOBAL, 0, 4);
    pm_photon_map *caustic = map_of(world, PM_MAP_CAUSTIC, 0, 4);
    static const pm_sensor sensors[] = {{{.3, .2, -1}, {0, 0, 1}},
                                        {{.3, .2, -.6}, {.6, 0, .8}}};
    for (int i = 0; i < 2; i++) {
        pm_backward_maps base = {.map = {global}, .gather_count = {2000, 1000}};
        pm_backward_maps both = base;
        both.map[PM_MAP_CAUSTIC] = caustic;
        struct measured m[4];
        for (int j = 0; j < 4; j++) {
            pm_backward_maps maps = j & 1 ? both : base;
            maps.ambient_bounces = j & 2 ? 1 : -1;
            m[j] = sense(world, &maps, PM_IRRADIANCE, sensors[i], 2048);
        }
        for (int j = 1; j < 4; j++)
            assert_agree(&m[0], &m[j], .25);
    }
    pm_photon_map_free(global);
    pm_photon_map_free(caustic);
    pm_world_free(world);
}

/* A sensor over a mirror, facing it: only the image of the lamp, at its whole distance, dimmed.
 */
static void light_by_a_mirror_reaches_a_sensor_in_free_space(void **state)
{
    (void)state;
    pm_world *world =
        world_of("void light lamp 0 0 3 30 30 30\nlamp sphere ball 0 0 4 0 0 2 .5\n"
                 "void metal shiny 0 0 5 .9 .9 .9 1 0\n"
                 "shiny ring floor 0 0 8  0 0 0  0 0 1  0 9\n");
    /* 1 above the floor but aside of the lamp's axis, so that the sensor's way is free */
    pm_sensor sensor = {{2, 0, 1}, {0, 0, -1}};
    double square = 4 + 9, cosine = 3 / sqrt(square);
    for (int ab = -1; ab <= 1; ab++) {
        pm_backward_maps maps = {.ambient_bounces = ab};
        struct measured m = sense(world, &maps, PM_IRRADIANCE, sensor, 16384);
        assert_measured(&m, 0, .9 * 30 * PM_PI * .25 / square * cosine, .2);
    }
    pm_world_free(world);
}

static void maps_without_a_way_to_look_are_refused(void **state)
{
    (void)state;
    pm_world *world = world_of(SHELL);
    pm_photon_map *map = map_of(world, PM_MAP_GLOBAL, 0, 1);
    pm_accumulation *accumulation = NULL;
    pm_pool *pool = pm_pool_new(1);
    assert_int_equal(
        pm_accumulation_for_sensors(world, &at_wall, 1, PM_RADIANCE, 0, &accumulation, NULL),
        PM_OK);
    const pm_backward_maps bad[] = {
        {.map = {map}},
        {.map = {map}, .radius = {(double)NAN}, .gather_count = {50}},
        {.map = {map}, .radius = {-1}, .gather_count = {50}},
        {.map = {map}, .radius = {INFINITY}, .gather_count = {50}},
        {.map = {map}, .gather_count = {PM_GATHER_MAX + 1}},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(pm_backward_pass(accumulation, 0, &bad[i], pool, NULL, NULL, NULL),
                         PM_E_RANGE);
    assert_int_equal(pm_accumulation_passes(accumulation), 0);
    pm_pool_free(pool);
    pm_accumulation_free(accumulation);
    pm_photon_map_free(map);
    pm_world_free(world);
}

/* Photons on a floor with a smooth coat, all from directions at one angle. */
static double coated_radiance(double cosine)
{
    enum { SIDE = 64 };
    static pm_photon photons[SIDE * SIDE];
    pm_world *world =
        world_of("void plastic coat 0 0 5 .5 .5 .5 .05 0\ncoat polygon floor 0 0 12 "
                 "-1 -1 0  1 -1 0  1 1 0  -1 1 0\n");
    pm_vec3 from = {sqrt(1 - cosine * cosine), 0, cosine};
    for (int i = 0; i < SIDE * SIDE; i++) {
        pm_vec3 place = {(i % SIDE + .5) / SIDE - .5, (i / SIDE + .5) / SIDE - .5, 0};
        pm_photon_record record = {.position = pm_world_from_scene(world, place),
                                   .normal = {0, 0, 1},
                                   .direction = from,
                                   .flux = {1, 1, 1},
                                   .specular = true};
        pm_photon_pack(&record, 1, &photons[i]);
    }
    pm_map_header header = {.kind = PM_MAP_CAUSTIC,
                            .scene = pm_world_hash(world),
                            .paths = 1,
                            .flux_scale = 1,
                            .world_scale = 1,
                            .storage_probability = 1};
    pm_batch batch = {
        .kind = PM_MAP_CAUSTIC, .paths = 1, .count = SIDE * SIDE, .photons = photons};
    pm_photon_map *map = NULL;
    assert_int_equal(pm_photon_map_build(&header, &batch, 1, NULL, &map, NULL), PM_OK);
    pm_backward_maps maps = {.map = {[PM_MAP_CAUSTIC] = map}, .gather_count = {50, 50, 50}};
    const pm_sensor down = {{0, 0, 1}, {0, 0, -1}};
    struct measured m = sense(world, &maps, PM_RADIANCE, down, 2);
    pm_photon_map_free(map);
    pm_world_free(world);
    return m.value[0];
}

/* Below a smooth coat the diffuse part receives 1 - F(cos), F after Radiance's normal.c. The
 * same photons from two angles: their ratio is that of the shares, up to packed directions
 * (2^-15) and fluxes rounded by chance (2^-10 each, 50 of them). */
static void coats_weigh_photons_by_where_they_come_from(void **state)
{
    (void)state;
    const double grazing = .1, steep = .95;
    double want =
        (1 - (exp(-5.85 * grazing) - .00287989916)) / (1 - (exp(-5.85 * steep) - .00287989916));
    double ratio = coated_radiance(grazing) / coated_radiance(steep);
    assert_true(fabs(ratio / want - 1) < 2e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_photons_give_the_radiosity_of_a_shell),
        cmocka_unit_test(gather_rays_give_the_radiosity_of_a_shell),
        cmocka_unit_test(without_ambient_bounces_direct_light_is_all),
        cmocka_unit_test(progressive_passes_give_the_radiosity_of_a_shell),
        cmocka_unit_test(unknown_progressive_radius_is_that_of_the_other_kind),
        cmocka_unit_test(sensor_in_free_space_sees_what_the_walls_send),
        cmocka_unit_test(sensor_on_a_surface_sees_the_photons_there),
        cmocka_unit_test(all_partitions_give_the_same_light),
        cmocka_unit_test(light_by_a_mirror_reaches_a_sensor_in_free_space),
        cmocka_unit_test(maps_without_a_way_to_look_are_refused),
        cmocka_unit_test(coats_weigh_photons_by_where_they_come_from),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
