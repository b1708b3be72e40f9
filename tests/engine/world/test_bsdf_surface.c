#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../world_text.h"
#include "numbers.h"
#include "world/surface.h"

/* A basis of three rings of 1, 4 and 4 patches, whose azimuths are 0, 90, 180, 270 degrees. */
#define BASIS                                                                                  \
    "<AngleBasis><AngleBasisName>b</AngleBasisName>"                                           \
    "<AngleBasisBlock><nPhis>1</nPhis><ThetaBounds><UpperTheta>20</UpperTheta></ThetaBounds>"  \
    "</AngleBasisBlock><AngleBasisBlock><nPhis>4</nPhis><ThetaBounds><UpperTheta>50"           \
    "</UpperTheta></ThetaBounds></AngleBasisBlock><AngleBasisBlock><nPhis>4</nPhis>"           \
    "<ThetaBounds><UpperTheta>90</UpperTheta></ThetaBounds></AngleBasisBlock></AngleBasis>"
#define BEGIN(name)                                                                            \
    "\n#file " name "\n<WindowElement><Optical><Layer><DataDefinition>"                        \
    "<IncidentDataStructure>Rows</IncidentDataStructure>" BASIS "</DataDefinition>\n"
#define DATA(direction, values)                                                                \
    "<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>"                    \
    "<WavelengthDataDirection>" direction "</WavelengthDataDirection><ColumnAngleBasis>b"      \
    "</ColumnAngleBasis><RowAngleBasis>b</RowAngleBasis><ScatteringData>" values               \
    "</ScatteringData></WavelengthDataBlock></WavelengthData>\n"
#define END "</Layer></Optical></WindowElement>\n"

#define NINE(v) v " " v " " v " " v " " v " " v " " v " " v " " v "\n"
#define ALL(v)  NINE(v) NINE(v) NINE(v) NINE(v) NINE(v) NINE(v) NINE(v) NINE(v) NINE(v)

/* .1 reflects, .05 transmits: all of it Lambertian. */
#define MATT                                                                                   \
    BEGIN("matt.xml")                                                                          \
    DATA("Reflection Front", ALL(".1"))                                                        \
    DATA("Reflection Back", ALL(".1")) DATA("Transmission Front", ALL(".05")) END

/* Light that comes straight on, column 0, is reflected towards azimuth 90 (row 2), and
 * transmitted towards azimuth 0 (row 1). */
#define TURN                                                                                   \
    BEGIN("turn.xml")                                                                          \
    DATA("Reflection Back", "0 0 1 0 0 0 0 0 0\n" NINE("0") NINE("0") NINE("0") NINE("0")      \
                                NINE("0") NINE("0") NINE("0") NINE("0"))                       \
    DATA("Transmission Back", "0 .5 0 0 0 0 0 0 0\n" NINE("0") NINE("0") NINE("0") NINE("0")   \
                                  NINE("0") NINE("0") NINE("0") NINE("0"))                     \
    END

/* A pane that lets light through its own patch, a little around, and reflects a little. */
#define PANE                                                                                   \
    BEGIN("pane.xml")                                                                          \
    DATA("Transmission Front",                                                                 \
         "1.5 0 0 .1 0 0 0 0 0\n 0 1.6 0 .1 0 0 0 0 0\n 0 0 1.6 0 .1 0 0 0 0\n"                \
         ".1 .1 0 1.6 0 0 0 0 0\n 0 0 .1 0 1.6 0 0 0 0\n 0 0 0 0 0 1.6 0 0 .1\n"               \
         "0 0 0 0 0 0 1.6 .1 0\n 0 0 0 0 0 0 .1 1.6 0\n 0 0 0 0 0 .1 0 0 1.6\n")               \
    DATA("Reflection Front", "0 .1 " NINE(".02") NINE(".04") NINE("0") NINE("0") NINE(".1")    \
                                 NINE(".1") NINE(".05") NINE(".05") " 0 0 0 0 0 0 0 ")         \
    END

/* A square in z = 0 that faces up; `up` of its BSDF is world +y, so x is to the right. */
#define SQUARE " polygon s 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"

static const pm_vec3 above = {0, 0, 1}, below = {0, 0, -1};

static pm_hit hit_from(const pm_world *world, pm_vec3 wo)
{
    const pm_ray ray = {pm_world_from_scene(world, wo), pm_vec3_negate(wo), INFINITY,
                        PM_NO_PRIMITIVE};
    pm_hit hit;
    assert_true(pm_world_intersect(world, &ray, &hit));
    return hit;
}

static pm_surface surface_from(const pm_world *world, pm_vec3 wo)
{
    const pm_media none = {0};
    const pm_hit hit = hit_from(world, wo);
    pm_surface surface;
    pm_surface_at(world, &hit, wo, &none, &surface);
    return surface;
}

static pm_surface seen_from(const pm_world *world, pm_vec3 wo)
{
    const pm_media none = {0};
    const pm_hit hit = hit_from(world, wo);
    pm_surface surface;
    pm_surface_seen_at(world, &hit, wo, &none, &surface);
    return surface;
}

static double shadow_through(const pm_world *world, pm_vec3 from)
{
    const pm_media none = {0};
    const pm_ray ray = {pm_world_from_scene(world, from), pm_vec3_negate(from), INFINITY,
                        PM_NO_PRIMITIVE};
    return pm_world_transmittance(world, &ray, &none, false).g;
}

static double part(const pm_surface *surface, pm_event event, unsigned side)
{
    return pm_surface_part(surface, event, side).g;
}

/* ---- Lambertian parts, reals, patterns ---- */

static void lambertian_part_is_diffuse(void **state)
{
    (void)state;
    pm_world *world = world_of("void BSDF m 6 0 matt.xml 0 1 0 . 0 0 m" SQUARE MATT);
    for (int i = 0; i < 2; i++) {
        pm_surface s = surface_from(world, i ? below : above);
        assert_near(part(&s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR), .1 * PM_PI, 1e-6);
        assert_near(part(&s, PM_EVENT_DIFFUSE, PM_SIDE_FAR), .05 * PM_PI, 1e-6);
        assert_int_equal(s.count, 2);
    }
    assert_near(shadow_through(world, above), 0, 0);
    pm_world_free(world);
}

static void reals_add_to_the_file(void **state)
{
    (void)state;
    pm_world *world = world_of("void aBSDF m 5 matt.xml 0 1 0 . 0\n"
                               "9 .1 .2 .3  .2 .1 .05  .01 .02 .03 m" SQUARE MATT);
    pm_surface front = surface_from(world, above), back = surface_from(world, below);
    pm_rgb r = pm_surface_part(&front, PM_EVENT_DIFFUSE, PM_SIDE_NEAR);
    assert_near(r.r, .1 * PM_PI + .1, 1e-6);
    assert_near(r.b, .1 * PM_PI + .3, 1e-6);
    r = pm_surface_part(&back, PM_EVENT_DIFFUSE, PM_SIDE_NEAR);
    assert_near(r.r, .1 * PM_PI + .2, 1e-6);
    r = pm_surface_part(&back, PM_EVENT_DIFFUSE, PM_SIDE_FAR);
    assert_near(r.b, .05 * PM_PI + .03, 1e-6);
    pm_world_free(world);
}

static void reals_do_not_make_energy(void **state)
{
    (void)state;
    pm_world *world = world_of("void aBSDF m 5 matt.xml 0 1 0 . 0\n"
                               "9 .9 .2 .3  .2 .1 .05  .9 .02 .03 m" SQUARE MATT);
    pm_surface s = surface_from(world, above);
    pm_rgb sum = pm_rgb_add(pm_surface_part(&s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR),
                            pm_surface_part(&s, PM_EVENT_DIFFUSE, PM_SIDE_FAR));
    assert_at_most(pm_rgb_max(sum), 1 + 1e-12);
    pm_world_free(world);
}

/* Everything but what is reflected beside the Lambertian part. */
static void patterns_multiply(void **state)
{
    (void)state;
    pm_world *world = world_of("void colorfunc c 4 .5 .5 .5 . 0 0\n"
                               "c BSDF m 6 0 turn.xml 0 1 0 . 0\n3 .1 .1 .1 m" SQUARE TURN);
    pm_world *plain = world_of("void BSDF m 6 0 turn.xml 0 1 0 . 0 3 .1 .1 .1 m" SQUARE TURN);
    pm_surface s = surface_from(world, above), p = surface_from(plain, above);
    assert_near(part(&s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR), .05, 1e-12);
    assert_true(part(&p, PM_EVENT_GLOSSY, PM_SIDE_NEAR) > .1);
    assert_near(part(&s, PM_EVENT_GLOSSY, PM_SIDE_NEAR),
                part(&p, PM_EVENT_GLOSSY, PM_SIDE_NEAR), 1e-12);
    assert_near(part(&s, PM_EVENT_GLOSSY, PM_SIDE_FAR),
                .5 * part(&p, PM_EVENT_GLOSSY, PM_SIDE_FAR), 1e-12);
    pm_vec3 wi = {sin(.6), 0, -cos(.6)};
    assert_near(pm_surface_value(&p, PM_EVENT_GLOSSY, wi).g, .5 * cos(.6), 1e-9);
    assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, wi).g, .25 * cos(.6), 1e-9);
    pm_world_free(world);
    pm_world_free(plain);
}

/* ---- orientation ---- */

/* x = up x normal, y = up made orthogonal: from the front, with up upwards, x is to the right.
 */
static void up_turns_the_distribution(void **state)
{
    (void)state;
    static const struct {
        const char *material;
        pm_vec3 x, y;
    } cases[] = {
        {"6 0 turn.xml 0 1 0 . 0 0", {1, 0, 0}, {0, 1, 0}},
        {"6 0 turn.xml 1 0 0 . 0 0", {0, -1, 0}, {1, 0, 0}},
        {"6 0 turn.xml -2e9 0 1e9 . 0 0", {0, 1, 0}, {-1, 0, 0}},
        {"6 0 turn.xml 0 0 1 . 0 0", {0, 0, 0}, {0, 0, 0}}, /* along the normal: black */
        {"8 0 turn.xml 0 1 0 . -rz 90 0 0", {0, 1, 0}, {-1, 0, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[8192];
        snprintf(text, sizeof text, "void BSDF m %s m" SQUARE "%s", cases[i].material, TURN);
        pm_world *world = world_of(text);
        pm_surface s = surface_from(world, above);
        pm_vec3 reflected = pm_vec3_scale(cases[i].y, sin(.6));
        pm_vec3 passed = pm_vec3_scale(cases[i].x, sin(.6));
        bool black = pm_vec3_length(cases[i].x) == 0;
        reflected.z = cos(.6);
        passed.z = -cos(.6);
        assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, reflected).g, black ? 0 : cos(.6),
                    1e-9);
        assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, passed).g, black ? 0 : .5 * cos(.6),
                    1e-9);
        assert_int_equal(s.count, black ? 0 : 2);
        pm_world_free(world);
    }
}

/* The file's transmission is given for light from the front only. */
static void the_other_side_is_reciprocal(void **state)
{
    (void)state;
    pm_world *world = world_of("void BSDF m 6 0 turn.xml 0 1 0 . 0 0 m" SQUARE TURN);
    pm_vec3 wo = {sin(.6), 0, -cos(.6)};
    pm_surface s = surface_from(world, wo);
    assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, above).g, .5, 1e-9);
    assert_near(part(&s, PM_EVENT_GLOSSY, PM_SIDE_NEAR), 0, 0);
    pm_world_free(world);
}

/* ---- thickness ---- */

static void proxies_hide_from_sight_and_shadow(void **state)
{
    (void)state;
    static const char *const thick[4] = {".1", "-.1", "2*.05", "if(Px-9,0,.1)"};
    for (int i = 0; i < 4; i++) {
        char text[8192];
        snprintf(text, sizeof text, "void BSDF m 6 %s matt.xml 0 1 0 . 0 0 m" SQUARE "%s",
                 thick[i], MATT);
        pm_world *world = world_of(text);
        bool front = i != 1;
        pm_vec3 active = front ? above : below, passive = front ? below : above;
        assert_near(shadow_through(world, above), 1, 0);
        pm_surface s = seen_from(world, active);
        assert_near(part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR), 1, 0);
        assert_int_equal(s.count, 1);
        s = surface_from(world, passive);
        assert_near(part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR), 1, 0);
        s = surface_from(world, active);
        assert_near(part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR), 0, 0);
        assert_near(part(&s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR), .1 * PM_PI, 1e-6);
        assert_near(part(&s, PM_EVENT_DIFFUSE, PM_SIDE_FAR), 0, 0);
        assert_near(part(&s, PM_EVENT_GLOSSY, PM_SIDE_FAR), .05 * PM_PI, 1e-6);
        uint32_t from = 7;
        pm_vec3 start = pm_surface_exit(&s, (pm_vec3){0, 0, 0}, passive, &from);
        pm_world_info info;
        pm_world_info_get(world, &info);
        assert_near(pm_vec3_dot(start, passive) * info.scale, .1, 1e-12);
        assert_int_equal(from, PM_NO_PRIMITIVE);
        from = 7;
        start = pm_surface_exit(&s, (pm_vec3){0, 0, 0}, active, &from);
        assert_near(pm_vec3_length(start), 0, 0);
        assert_int_equal(from, 7);
        pm_world_free(world);
    }
}

static void without_thickness_both_sides_scatter(void **state)
{
    (void)state;
    pm_world *world = world_of("void BSDF m 6 1e-7 matt.xml 0 1 0 . 0 0 m" SQUARE MATT);
    pm_surface s = seen_from(world, below);
    assert_near(part(&s, PM_EVENT_DIFFUSE, PM_SIDE_NEAR), .1 * PM_PI, 1e-6);
    assert_near(shadow_through(world, above), 0, 0);
    assert_near(s.skip, 0, 0);
    pm_world_free(world);
}

/* ---- what goes straight on ---- */

static void peak_is_straight_passage(void **state)
{
    (void)state;
    pm_world *world = world_of("void aBSDF m 5 pane.xml 0 1 0 . 0 0 m" SQUARE PANE);
    pm_world *whole = world_of("void BSDF m 6 0 pane.xml 0 1 0 . 0 0 m" SQUARE PANE);
    double ohm = PM_PI * pow(sin(20 * PM_PI / 180), 2); /* of the central patch */
    for (int i = 0; i < 2; i++) {
        pm_vec3 wo = i ? below : above;
        pm_surface s = surface_from(world, wo), w = surface_from(whole, wo);
        assert_near(part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR), 1.5 * ohm, 1e-6);
        assert_near(part(&w, PM_EVENT_STRAIGHT, PM_SIDE_FAR), 0, 0);
        assert_near(shadow_through(world, wo), 1.5 * ohm, 1e-6);
        assert_near(shadow_through(whole, wo), 0, 0);
        assert_near(part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR) +
                        part(&s, PM_EVENT_GLOSSY, PM_SIDE_FAR),
                    part(&w, PM_EVENT_GLOSSY, PM_SIDE_FAR), 1e-6);
        assert_near(pm_surface_value(&s, PM_EVENT_GLOSSY, pm_vec3_negate(wo)).g, 0, 0);
        assert_near(pm_surface_value(&w, PM_EVENT_GLOSSY, pm_vec3_negate(wo)).g, 1.5, 1e-6);
    }
    pm_world_free(world);
    pm_world_free(whole);
}

/* ---- sampling ---- */

static double glossy_density(void *context, pm_vec3 wi)
{
    return pm_surface_glossy_pdf(context, pm_rgb_grey(1), wi);
}

static void frequencies_equal_the_density(void **state)
{
    (void)state;
    static const char *const materials[3] = {"BSDF m 6 0 pane.xml .3 1 .2 . 0 0 m",
                                             "aBSDF m 5 pane.xml .3 1 .2 . 0 0 m",
                                             "BSDF m 6 0 turn.xml 0 1 0 . 0 0 m"};
    for (int i = 0; i < 6; i++) {
        char text[16384];
        snprintf(text, sizeof text, "void %s" SQUARE "%s", materials[i / 2],
                 i < 4 ? PANE : TURN);
        pm_world *world = world_of(text);
        pm_vec3 wo = polar(i < 4 ? .8 : .99, 1);
        wo.z *= i % 2 && i < 4 ? -1 : 1;
        pm_surface s = surface_from(world, wo);
        struct histogram h = {.samples = 0};
        pm_rng rng;
        pm_rng_init(&rng, 3, PM_RNG_PATH, (uint64_t)i);
        pm_rgb sum = {0, 0, 0};
        enum { DRAWS = 100000 };
        for (int k = 0; k < DRAWS; k++) {
            double u[3];
            pm_scatter scatter;
            draw(&rng, u, 3);
            pm_surface_sample_specular(&s, pm_rgb_grey(1), u, &scatter);
            assert_true(scatter.event != PM_EVENT_NONE);
            sum = pm_rgb_madd(sum, 1. / DRAWS, scatter.weight);
            if (scatter.event != PM_EVENT_GLOSSY)
                continue;
            assert_near(scatter.pdf, glossy_density(&s, scatter.wi), 1e-9 * scatter.pdf);
            assert_int_equal(scatter.transmitted, (scatter.wi.z > 0) != (wo.z > 0));
            histogram_add(&h, scatter.wi);
            h.samples++;
        }
        double total = part(&s, PM_EVENT_GLOSSY, PM_SIDE_NEAR) +
                       part(&s, PM_EVENT_GLOSSY, PM_SIDE_FAR) +
                       part(&s, PM_EVENT_STRAIGHT, PM_SIDE_FAR);
        assert_near(sum.g, total, 1e-3); /* weights are constant */
        assert_at_most(total, 1 + 1e-6);
        histogram_expect(&h, glossy_density, &s);
        double wanted = 0; /* the density is of all draws; jumps upset the midpoint rule */
        for (int b = 0; b < BINS; b++)
            wanted += h.wanted[b];
        for (int b = 0; b < BINS; b++)
            h.wanted[b] *= h.samples / wanted;
        histogram_check(&h);
        pm_world_free(world);
    }
}

/* ---- what surfaces can do ---- */

static void plan_knows_what_it_meets(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        size_t specular, diffuse;
    } cases[] = {
        {"void BSDF m 6 0 matt.xml 0 1 0 . 0 0 m" SQUARE MATT, 0, 1},
        {"void BSDF m 6 0 turn.xml 0 1 0 . 0 0 m" SQUARE TURN, 1, 0},
        {"void BSDF m 6 0 turn.xml 0 1 0 . 0 3 .1 0 0 m" SQUARE TURN, 1, 1},
        {"void aBSDF m 5 pane.xml 0 1 0 . 0 0 m" SQUARE PANE, 1, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        pm_world *world = world_of(cases[i].text);
        pm_world_info info;
        pm_world_info_get(world, &info);
        assert_int_equal(info.specular_surfaces, cases[i].specular);
        assert_int_equal(info.diffuse_surfaces, cases[i].diffuse);
        pm_world_free(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lambertian_part_is_diffuse),
        cmocka_unit_test(reals_add_to_the_file),
        cmocka_unit_test(reals_do_not_make_energy),
        cmocka_unit_test(patterns_multiply),
        cmocka_unit_test(up_turns_the_distribution),
        cmocka_unit_test(the_other_side_is_reciprocal),
        cmocka_unit_test(proxies_hide_from_sight_and_shadow),
        cmocka_unit_test(without_thickness_both_sides_scatter),
        cmocka_unit_test(peak_is_straight_passage),
        cmocka_unit_test(frequencies_equal_the_density),
        cmocka_unit_test(plan_knows_what_it_meets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
