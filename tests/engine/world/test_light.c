#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"
#include "world/light.h"
#include "world/media.h"

/* The hit of a ray in scene coordinates, which are the world's up to the cube. */
static pm_hit hit_along(const pm_world *world, pm_vec3 scene_point, pm_vec3 direction)
{
    pm_ray ray = {pm_world_from_scene(world, scene_point), direction, INFINITY,
                  PM_NO_PRIMITIVE};
    pm_hit hit;
    assert_true(pm_world_intersect(world, &ray, &hit));
    return hit;
}

static pm_rgb scene_power(const pm_world *world)
{
    pm_world_info info;
    pm_world_info_get(world, &info);
    return info.power;
}

static void check_power(const char *text, double wanted)
{
    pm_world *world = world_of(text);
    assert_near(scene_power(world).r, wanted, 1e-12 * wanted);
    assert_near(scene_power(world).g, 2 * wanted, 2e-12 * wanted);
    pm_world_free(world);
}

/* pi A L; spotlights: A L times the projected solid angle, pi sin^2 of half the cone's angle
 * for a cone about the normal; a sphere shows pi r^2 to each direction of the cone. */
static void power_is_area_times_pi_times_radiance(void **state)
{
    (void)state;
    const double pi = PM_PI, spot = pow(sin(20 * PM_PI / 180), 2);
    check_power("void light m 0 0 3 3 6 0 m polygon a 0 0 12 0 0 0 2 0 0 2 5 0 0 5 0", 30 * pi);
    check_power("void glow m 0 0 4 3 6 0 0 m sphere a 0 0 4 7 8 9 2", 48 * pi * pi);
    check_power("void glow m 0 0 4 3 6 0 9 m bubble a 0 0 4 7 8 9 2", 48 * pi * pi);
    check_power("void illum m 0 0 3 3 6 0 m ring a 0 0 8 0 0 0 0 0 1 1 3", 24 * pi * pi);
    check_power("void light m 0 0 3 3 6 0 m cylinder a 0 0 7 0 0 0 0 0 5 2", 60 * pi * pi);
    check_power("void spotlight m 0 0 7 3 6 0 40 0 0 2 m ring a 0 0 8 0 0 0 0 0 1 0 2",
                12 * pi * pi * spot);
    check_power("void spotlight m 0 0 7 3 6 0 60 0 0 2 m sphere a 0 0 4 0 0 0 2",
                24 * pi * pi * (1 - cos(pi / 6)));
}

/* Across its axis a cylinder shows 2 r h to every direction of a narrow beam. */
static void spotlight_cylinder_shows_its_outline(void **state)
{
    (void)state;
    pm_world *world =
        world_of("void spotlight m 0 0 7 1 1 1 .2 1 0 0 m cylinder a 0 0 7 0 0 0 0 0 5 2");
    double solid_angle = 2 * PM_PI * (1 - cos(.1 * PM_PI / 180));
    assert_near(scene_power(world).r, 20 * solid_angle, 1e-4 * solid_angle);
    pm_world_free(world);
}

/* Irradiance 2 pi (1 - cos) L over the disc that the bounding sphere of the floor shows. */
static void distant_power_falls_on_the_bounding_disc(void **state)
{
    (void)state;
    pm_world *world = world_of("void light m 0 0 3 5 5 5 m source a 0 0 4 0 1 1 .5\n"
                               "void plastic p 0 0 5 .5 .5 .5 0 0\n"
                               "p polygon f 0 0 12 0 0 0 6 0 0 6 8 0 0 8 0");
    double solid_angle = 2 * PM_PI * 2 * pow(sin(.125 * PM_PI / 180), 2);
    assert_near(scene_power(world).r, 5 * solid_angle * PM_PI * 25, 1e-9 * solid_angle);
    pm_world_free(world);
}

static void glow_of_negative_radius_lights_nothing_but_is_seen(void **state)
{
    (void)state;
    pm_world *world = world_of("void glow m 0 0 4 1 2 3 -1\n"
                               "m ring a 0 0 8 0 0 0 0 0 1 0 1\n"
                               "m source b 0 0 4 0 0 1 20");
    pm_hit hit = hit_along(world, (pm_vec3){0, 0, 1}, (pm_vec3){0, 0, -1});
    pm_vec3 up = {0, 0, 1};
    double pdf;
    assert_true(pm_rgb_is_black(pm_light_radiance(world, &hit, up)));
    assert_true(pm_rgb_is_black(pm_light_distant(world, up, &pdf)));
    assert_near(pm_light_seen_radiance(world, &hit, up).g, 2, 0);
    assert_near(pm_light_seen_distant(world, up).b, 3, 0);
    assert_near(pm_light_pdf_surface(world, up, (pm_vec3){0, 0, -1}, &hit), 0, 0);
    pm_light_sample sample;
    pm_emission emission;
    assert_false(pm_light_sample_at(world, up, (double[3]){.5, .5, .5}, &sample));
    assert_false(pm_light_emit(world, (double[5]){.5, .5, .5, .5, .5}, &emission));
    pm_world_free(world);
}

static void lamps_shine_from_their_front_alone(void **state)
{
    (void)state;
    pm_world *world = world_of("void light m 0 0 3 4 4 4 m ring a 0 0 8 0 0 0 0 0 1 0 1");
    pm_hit hit = hit_along(world, (pm_vec3){0, 0, 1}, (pm_vec3){0, 0, -1});
    assert_near(pm_light_radiance(world, &hit, (pm_vec3){.6, 0, .8}).r, 4, 0);
    assert_near(pm_light_radiance(world, &hit, (pm_vec3){.6, 0, -.8}).r, 0, 0);
    assert_near(pm_light_seen_radiance(world, &hit, (pm_vec3){.6, 0, -.8}).r, 0, 0);
    pm_world_free(world);
}

/* Radiance's srcray: the lamp counts as if `focus` farther away. */
static void spotlight_has_a_cone_and_a_focus(void **state)
{
    (void)state;
    pm_world *world =
        world_of("void spotlight m 0 0 7 4 4 4 60 0 0 3 m ring a 0 0 8 0 0 0 0 0 1 0 1");
    pm_hit hit = hit_along(world, (pm_vec3){0, 0, 2}, (pm_vec3){0, 0, -1});
    double share = pow(2. / (2 + 3), 2);
    assert_near(pm_light_radiance(world, &hit, polar(1, 0)).r, 4 * share, 1e-14);
    assert_near(pm_light_seen_radiance(world, &hit, polar(1, 0)).r, 4, 0);
    double edge = 30 * PM_PI / 180;
    assert_near(pm_light_seen_radiance(world, &hit, polar(cos(edge - 1e-9), 2)).r, 4, 0);
    assert_near(pm_light_seen_radiance(world, &hit, polar(cos(edge + 1e-9), 2)).r, 0, 0);
    pm_world_free(world);
}

static void distant_glow_shows_only_where_no_light_does(void **state)
{
    (void)state;
    pm_world *world = world_of("void glow g 0 0 4 1 1 1 0 g source sky 0 0 4 0 0 1 180\n"
                               "void light s 0 0 3 9 9 9 s source sun 0 0 4 0 0 1 10\n"
                               "void light t 0 0 3 5 5 5 t source two 0 0 4 0 0 1 4");
    double pdf;
    assert_near(pm_light_distant(world, polar(.5, 0), &pdf).r, 1, 0);
    assert_near(pm_light_distant(world, polar(cos(.08), 0), &pdf).r, 9, 0);
    assert_near(pm_light_distant(world, polar(1, 0), &pdf).r, 14, 0);
    assert_near(pm_light_distant(world, polar(-.5, 0), &pdf).r, 0, 0);
    assert_near(pdf, 0, 0);
    pm_world_free(world);
}

static void illum_stands_in_for_light_that_leaves_its_front(void **state)
{
    (void)state;
    pm_world *world = world_of("void illum m 0 0 3 4 4 4 m ring a 0 0 8 0 0 0 0 0 1 0 1");
    pm_hit hit = hit_along(world, (pm_vec3){0, 0, 1}, (pm_vec3){0, 0, -1});
    assert_true(pm_light_stands_in(world, &hit, (pm_vec3){0, 0, 1}));
    assert_false(pm_light_stands_in(world, &hit, (pm_vec3){0, 0, -1}));
    assert_true(pm_rgb_is_black(pm_light_seen_radiance(world, &hit, (pm_vec3){0, 0, 1})));
    pm_ray down = {pm_world_from_scene(world, (pm_vec3){.1, .1, 1}),
                   {0, 0, -1},
                   INFINITY,
                   PM_NO_PRIMITIVE};
    pm_media media = {0};
    assert_near(pm_world_transmittance(world, &down, &media, false).r, 1, 0);
    assert_near(pm_world_transmittance(world, &down, &media, true).r, 0, 0);
    down = (pm_ray){pm_world_from_scene(world, (pm_vec3){.1, .1, -1}),
                    {0, 0, 1},
                    INFINITY,
                    PM_NO_PRIMITIVE};
    assert_near(pm_world_transmittance(world, &down, &media, true).r, 1, 0);
    pm_world_free(world);
}

/* It lights nothing: the illum is the source. */
static void lamp_behind_an_illum_is_seen(void **state)
{
    (void)state;
    pm_world *world =
        world_of("void brightfunc b 2 \"if(Px,3,5)\" . 0 0\nb glow g 0 0 4 2 2 2 0\n"
                 "void illum i 1 g 0 3 1 1 1\nvoid illum j 1 i 0 3 4 4 4\n"
                 "j ring a 0 0 8 0 0 0 0 0 1 0 1");
    const pm_vec3 up = {0, 0, 1}, down = {0, 0, -1};
    pm_hit hit = hit_along(world, (pm_vec3){.1, 0, 1}, down);
    assert_near(pm_light_seen_radiance(world, &hit, up).r, 6, 1e-14);
    assert_true(pm_rgb_is_black(pm_light_seen_radiance(world, &hit, down)));
    assert_true(pm_rgb_is_black(pm_light_radiance(world, &hit, up)));
    hit = hit_along(world, (pm_vec3){-.1, 0, 1}, down);
    assert_near(pm_light_seen_radiance(world, &hit, up).r, 10, 1e-14);
    pm_world_info info;
    pm_world_info_get(world, &info);
    assert_near(info.power.r, 4 * PM_PI * PM_PI, 1e-9);
    pm_world_free(world);
}

/* Radiance's findmaterial: a mixture is no source; its components show what they are. */
static void lamps_in_a_mixture_are_seen_and_light_nothing(void **state)
{
    (void)state;
    pm_world *world = world_of(
        "void light l 0 0 3 8 8 8\nvoid brightfunc b 2 \"2\" . 0 0\nb glow g 0 0 4 2 2 2 0\n"
        "void plastic p 0 0 5 .5 .5 .5 0 0\n"
        "void mixfunc n 4 g p \"if(Px,.5,1)\" . 0 0\n"
        "void mixfunc m 4 l n \".25\" . 0 0\n"
        "m ring a 0 0 8 0 0 0 0 0 1 0 1");
    const pm_vec3 up = {0, 0, 1}, down = {0, 0, -1};
    pm_hit hit = hit_along(world, (pm_vec3){.1, 0, 1}, down);
    assert_near(pm_light_seen_radiance(world, &hit, up).r, .25 * 8 + .75 * .5 * 4, 1e-14);
    assert_true(pm_rgb_is_black(pm_light_radiance(world, &hit, up)));
    assert_true(pm_rgb_is_black(pm_light_seen_radiance(world, &hit, down)));
    hit = hit_along(world, (pm_vec3){-.1, 0, 1}, down);
    assert_near(pm_light_seen_radiance(world, &hit, up).r, .25 * 8 + .75 * 4, 1e-14);
    pm_light_sample sample;
    assert_false(pm_light_sample_at(world, up, (double[3]){.5, .5, .5}, &sample));
    pm_world_free(world);
}

/* Order in the file must not steer photons. */
static void order_in_the_file_changes_no_photon(void **state)
{
    (void)state;
    const char *a = "void light m 0 0 3 1 2 3 m sphere a 0 0 4 0 0 0 1\n"
                    "void light n 0 0 3 4 4 4 n sphere b 0 0 4 5 0 0 2\n"
                    "m sphere c 0 0 4 0 7 0 1";
    const char *b = "void light x 0 0 3 4 4 4 void light y 0 0 3 1 2 3\n"
                    "y sphere 1 0 0 4 0 7 0 1\nx sphere 2 0 0 4 5 0 0 2\n"
                    "y sphere 3 0 0 4 0 0 0 1";
    pm_world *first = world_of(a), *second = world_of(b);
    for (int i = 0; i < 1000; i++) {
        double u[5] = {(i + .5) / 1000, .3, .6, .2, .9};
        pm_emission one, two;
        assert_true(pm_light_emit(first, u, &one) && pm_light_emit(second, u, &two));
        assert_memory_equal(&one.origin, &two.origin, sizeof one.origin);
        assert_memory_equal(&one.flux, &two.flux, sizeof one.flux);
    }
    pm_world_free(first);
    pm_world_free(second);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(power_is_area_times_pi_times_radiance),
        cmocka_unit_test(spotlight_cylinder_shows_its_outline),
        cmocka_unit_test(distant_power_falls_on_the_bounding_disc),
        cmocka_unit_test(glow_of_negative_radius_lights_nothing_but_is_seen),
        cmocka_unit_test(lamps_shine_from_their_front_alone),
        cmocka_unit_test(spotlight_has_a_cone_and_a_focus),
        cmocka_unit_test(distant_glow_shows_only_where_no_light_does),
        cmocka_unit_test(illum_stands_in_for_light_that_leaves_its_front),
        cmocka_unit_test(lamp_behind_an_illum_is_seen),
        cmocka_unit_test(lamps_in_a_mixture_are_seen_and_light_nothing),
        cmocka_unit_test(order_in_the_file_changes_no_photon),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
