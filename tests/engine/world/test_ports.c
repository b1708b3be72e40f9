/* The light that enters through ports is the integral of what the distant sources show there,
 * in closed form or by quadrature. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/maths.h"
#include "base/sobol.h"
#include "octrees.h"
#include "world/ports.h"

#define PI 3.14159265358979323846

/* Radiance 1 all around; over the horizon alone. */
#define ALL "void glow all 0 0 4 1 1 1 0 all source everywhere 0 0 4 0 0 1 360\n"
#define SKY "void glow sky 0 0 4 1 1 1 0 sky source dome 0 0 4 0 0 1 180\n"
/* Irradiance 1 at right angles, 60 degrees from the zenith. */
#define SUN_DEGREES .5
#define SUN                                                                                    \
    "void light sun 0 0 3 16720.49 16720.49 16720.49\n"                                        \
    "sun source disc 0 0 4 .8660254037844386 0 .5 .5\n"
#define PORT  "void antimatter port 1 void 0 0\n"
#define BLACK "void plastic black 0 0 5 0 0 0 0 0\n"
/* Normals up, and towards +x. */
#define FLAT  "port polygon flat 0 0 12 0 0 0 2 0 0 2 3 0 0 3 0\n"
#define STEEP "port polygon steep 0 0 12 0 0 0 0 2 0 0 2 3 0 0 3\n"
#define SQUARE(modifier, name, z)                                                              \
    modifier " polygon " name " 0 0 12 -1 -1 " z " 1 -1 " z " 1 1 " z " -1 1 " z "\n"

enum { SAMPLES = 1 << 15, FRONT = 1, BACK = 2 };

/* ---- estimates ---- */

struct flux {
    double mean, error; /* [W], first channel; standard error as of independent draws */
    double entered;     /* share of the draws that enter */
};

static struct pm_selection choice(const pm_world *world, bool any)
{
    pm_selection selection;
    const char *name = "port";
    assert_int_equal(pm_selection_make(world, &name, any, "-apo", &selection, NULL), PM_OK);
    return selection;
}

static struct flux flux_in(const pm_world *world, unsigned sides, double resolution,
                           double partition)
{
    pm_error err = PM_ERROR_INIT;
    pm_ports *ports = NULL;
    pm_selection front = choice(world, sides & FRONT), back = choice(world, sides & BACK);
    const pm_ports_options options = {{&front, &back}, resolution, partition};
    if (pm_ports_new(world, &options, &ports, &err))
        fail_msg("%s", err.text);
    assert_non_null(ports);
    double sum = 0, squares = 0, entered = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double u[5];
        pm_port_entry entry;
        for (unsigned d = 0; d < 5; d++)
            u[d] = pm_sobol(i, d, 7 + d);
        if (!pm_ports_emit(ports, u, &entry))
            continue;
        double flux = entry.emission.flux.r;
        assert_true(flux >= 0 && isfinite(flux));
        sum += flux;
        squares += flux * flux;
        entered += entry.enters;
    }
    pm_ports_free(ports);
    pm_selection_clear(&front);
    pm_selection_clear(&back);
    pm_world_info info;
    pm_world_info_get(world, &info);
    double area = info.scale * info.scale, mean = sum / SAMPLES;
    return (struct flux){area * mean, area * sqrt((squares / SAMPLES - mean * mean) / SAMPLES),
                         entered / SAMPLES};
}

static pm_world *compiled(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    if (compile_text(text, &world, &err))
        fail_msg("%s", err.text);
    return world;
}

static void expect(const char *what, const struct flux *got, double want)
{
    if (!(fabs(got->mean - want) <= 5 * got->error + 2e-6 * want))
        fail_msg("%s: %.7g W enter, want %.7g (%+.3f %%), error %.2g", what, got->mean, want,
                 100 * (got->mean / want - 1), got->error);
}

/* Whatever the tables and patches are, which steer alone. */
static void expect_flux(const char *text, unsigned sides, double want)
{
    pm_world *world = compiled(text);
    static const double settings[][2] = {{1000, .01}, {10, 1}, {4000, .2}};
    for (int i = 0; i < 3; i++) {
        struct flux got = flux_in(world, sides, settings[i][0], settings[i][1]);
        expect(text, &got, want);
    }
    pm_world_free(world);
}

/* ---- open ports ---- */

static void uniform_sky_through_a_rectangle(void **state)
{
    (void)state;
    expect_flux(PORT SKY FLAT, BACK, 6 * PI);
    expect_flux(PORT SKY STEEP, FRONT, 6 * PI / 2);
    expect_flux(PORT SKY STEEP, BACK, 6 * PI / 2);
    expect_flux(PORT SKY STEEP, FRONT | BACK, 6 * PI);
}

static void nothing_enters_from_the_other_side(void **state)
{
    (void)state;
    pm_world *world = compiled(PORT SKY FLAT);
    struct flux got = flux_in(world, FRONT, 1000, .01);
    assert_true(got.mean == 0);
    pm_world_free(world);
}

/* The disc is whole over the horizon of the port: radiance pi sin^2(.25 deg) cos. */
static void sun_enters_by_the_cosine(void **state)
{
    (void)state;
    double normal = 16720.49 * PI * pow(sin(SUN_DEGREES / 2 * PI / 180), 2);
    expect_flux(PORT SUN FLAT, BACK, 6 * normal * .5);
    expect_flux(PORT SUN STEEP, BACK, 6 * normal * .8660254037844386);
    expect_flux(PORT SUN SKY STEEP, BACK,
                6 * (normal * .8660254037844386 + PI / 2)); /* the disc hides 2e-5 of it */
}

/* The CIE overcast sky, (1 + 2 sin(altitude)) / 3 of the zenith, on a tilted plane. */
static double overcast_irradiance(double tilt)
{
    enum { STEPS = 400 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < 4 * STEPS; k++) {
            double z = (i + .5) / STEPS, turn = PI * (k + .5) / (2 * STEPS);
            double cosine = z * cos(tilt) + sqrt(1 - z * z) * cos(turn) * sin(tilt);
            sum += fmax(cosine, 0) * (1 + 2 * z) / 3;
        }
    return sum * 2 * PI / (4. * STEPS * STEPS);
}

#define OVERCAST                                                                               \
    "void brightfunc cie 2 (1+2*Dz)/3 . 0 0\n"                                                 \
    "cie glow sky 0 0 4 1 1 1 0 sky source dome 0 0 4 0 0 1 180\n"

static void overcast_sky_by_quadrature(void **state)
{
    (void)state;
    assert_true(fabs(overcast_irradiance(0) - 7 * PI / 9) < 1e-4);
    expect_flux(PORT OVERCAST FLAT, BACK, 6 * 7 * PI / 9);
    expect_flux(PORT OVERCAST STEEP, BACK, 6 * overcast_irradiance(PI / 2));
    expect_flux(PORT OVERCAST "port polygon slope 0 0 12 0 0 0 2 0 0 2 3 3 0 3 3\n", BACK,
                6 * sqrt(2) * overcast_irradiance(PI / 4));
}

/* A sky of many patches, each a source of its own, is one sky: here rows of discs. */
static void many_small_sources_add_up(void **state)
{
    (void)state;
    struct text t = {0};
    double want = 0, half = 2.5 * PI / 180;
    add(&t, PORT FLAT);
    for (int i = 0; i < 200; i++) {
        double z = .1 + .9 * (i + .5) / 200, r = sqrt(1 - z * z), turn = 2.399963 * i;
        double radiance = 1 + i % 7;
        add(&t, "void glow g%d 0 0 4 %g %g %g 0 g%d source s%d 0 0 4 %.17g %.17g %.17g 5\n", i,
            radiance, radiance, radiance, i, i, r * cos(turn), r * sin(turn), z);
        want += radiance * PI * sin(half) * sin(half) * z;
    }
    expect_flux(t.data, BACK, 6 * want);
    free(t.data);
}

/* Light passes a convex surface once on its way in: pi L per area, whatever the shape. */
static void closed_ports_let_each_line_in_once(void **state)
{
    (void)state;
    expect_flux(PORT ALL "port sphere ball 0 0 4 1 2 3 2\n", BACK, PI * 4 * PI * 4);
    expect_flux(PORT ALL "port sphere ball 0 0 4 1 2 3 2\n", FRONT | BACK, PI * 4 * PI * 4);
    static const char box[] = PORT ALL "port polygon a 0 0 12 0 0 0 0 2 0 1 2 0 1 0 0\n"
                                       "port polygon b 0 0 12 0 0 3 1 0 3 1 2 3 0 2 3\n"
                                       "port polygon c 0 0 12 0 0 0 1 0 0 1 0 3 0 0 3\n"
                                       "port polygon d 0 0 12 0 2 0 0 2 3 1 2 3 1 2 0\n"
                                       "port polygon e 0 0 12 0 0 0 0 0 3 0 2 3 0 2 0\n"
                                       "port polygon f 0 0 12 1 0 0 1 2 0 1 2 3 1 0 3\n"
                                       "port sphere within 0 0 4 .5 1 1.5 .4\n";
    expect_flux(box, BACK, PI * 22);
    expect_flux(box, FRONT | BACK, PI * 22);
}

/* Two squares of edge 2, one 1 over the other: what passes the upper one first is not counted
 * at the lower one. View factor of equal parallel squares, X = Y = 2 (Howell, C-11). */
static void lines_through_two_windows_count_once(void **state)
{
    (void)state;
    double x = 2, s = sqrt(1 + x * x);
    double f = 2 / (PI * x * x) *
               (log(s * s / sqrt(1 + 2 * x * x)) + 2 * x * s * atan(x / s) - 2 * x * atan(x));
    expect_flux(PORT SKY SQUARE("port", "lower", "0") SQUARE("port", "upper", "1"), BACK,
                4 * PI * (2 - f));
}

/* ---- what is before a port ---- */

/* A tiny port under the middle of a roof of edge 2, one below: four times Howell's B-3. */
static void a_roof_takes_its_view_factor(void **state)
{
    (void)state;
    double s = sqrt(2), corner = 2 * (1 / s) * atan(1 / s) / (2 * PI);
    static const char scene[] = PORT BLACK SKY SQUARE(
        "black", "roof",
        "1") "port polygon hole 0 0 12 -5e-4 -5e-4 0 5e-4 -5e-4 0 5e-4 5e-4 0 -5e-4 5e-4 0\n";
    expect_flux(scene, BACK, 1e-6 * PI * (1 - 4 * corner));
}

/* A third of a long port lies in the shade: patches in the shade get few photons. */
static void patches_in_the_shade_get_few_photons(void **state)
{
    (void)state;
    static const char scene[] = PORT BLACK
        "void light sun 0 0 3 16720.49 16720.49 16720.49 sun source disc 0 0 4 0 0 1 .5\n"
        "port polygon long 0 0 12 0 0 0 3 0 0 3 1 0 0 1 0\n"
        "black polygon shade 0 0 12 -1 -1 .01 2.4 -1 .01 2.4 2 .01 -1 2 .01\n";
    double normal = 16720.49 * PI * pow(sin(.25 * PI / 180), 2);
    expect_flux(scene, BACK, .6 * normal);
    pm_world *world = compiled(scene);
    struct flux fine = flux_in(world, BACK, 1000, .01), coarse = flux_in(world, BACK, 1000, 1);
    assert_true(fine.entered > .6);
    assert_true(coarse.entered < .25);
    pm_world_free(world);
}

/* Under a roof with a hole, all but the directions to the hole are left out. */
static void tables_look_where_light_comes_from(void **state)
{
    (void)state;
    static const char scene[] =
        PORT BLACK SKY "port polygon p 0 0 12 -.1 -.1 0 .1 -.1 0 .1 .1 0 -.1 .1 0\n"
                       "black ring roof 0 0 8 0 0 1 0 0 1 .3 40\n";
    pm_world *world = compiled(scene);
    struct flux fine = flux_in(world, BACK, 4000, .01), coarse = flux_in(world, BACK, 10, .01);
    assert_true(fine.entered > .4);
    assert_true(coarse.entered < .5 * fine.entered);
    expect("coarse", &coarse, fine.mean);
    pm_world_free(world);
}

/* A sixth of the port lies under both panes; each takes what a shadow ray finds. */
static void panes_take_what_they_take(void **state)
{
    (void)state;
    static const char scene[] = PORT
        "void glass pane 0 0 3 .96 .5 .2\n"
        "void light sun 0 0 3 16720.49 16720.49 16720.49 sun source disc 0 0 4 0 0 1 .5\n" FLAT
            SQUARE("pane", "one", "2") "pane polygon two 0 0 12 0 0 1 9 0 1 9 9 1 0 9 1\n";
    pm_world *world = compiled(scene);
    const pm_media none = {.count = 0};
    pm_ray ray = {pm_world_from_scene(world, pm_vec3_make(1.5, 2, 0)),
                  {0, 0, 1},
                  INFINITY,
                  PM_NO_PRIMITIVE};
    double one = pm_world_transmittance(world, &ray, &none, false).r;
    assert_true(one > .8 && one < .95);
    double normal = 16720.49 * PI * pow(sin(.25 * PI / 180), 2);
    pm_world_free(world);
    expect_flux(scene, BACK, normal * (5 * one + one * one));
}

/* Beer's law in a mist that holds the port. Of the sun's disc the mean way is longer than the
 * shortest one by (.25 degrees)^2 / 4 of it. */
static void mist_before_a_port_attenuates(void **state)
{
    (void)state;
    static const char scene[] =
        PORT "void mist fog 0 0 7 .5 .5 .5 0 0 0 0\n"
             "void light sun 0 0 3 16720.49 16720.49 16720.49 sun source disc 0 0 4 0 0 1 .5\n"
             "port polygon p 0 0 12 -.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0\n"
             "fog polygon a 0 0 12 -1 -1 -1 -1 1 -1 1 1 -1 1 -1 -1\n"
             "fog polygon b 0 0 12 -1 -1 2 1 -1 2 1 1 2 -1 1 2\n"
             "fog polygon c 0 0 12 -1 -1 -1 1 -1 -1 1 -1 2 -1 -1 2\n"
             "fog polygon d 0 0 12 -1 1 -1 -1 1 2 1 1 2 1 1 -1\n"
             "fog polygon e 0 0 12 -1 -1 -1 -1 -1 2 -1 1 2 -1 1 -1\n"
             "fog polygon f 0 0 12 1 -1 -1 1 1 -1 1 1 2 1 -1 2\n";
    double normal = 16720.49 * PI * pow(sin(.25 * PI / 180), 2);
    expect_flux(scene, BACK, normal * exp(-.5 * 2 * (1 + pow(.25 * PI / 180, 2) / 4)));
}

/* ---- with lamps, in instances, none ---- */

static void lamps_shine_as_ever(void **state)
{
    (void)state;
    expect_flux(PORT SKY FLAT "void light l 0 0 3 5 5 5 l sphere lamp 0 0 4 1 1 -1 .5\n", BACK,
                6 * PI + 5 * PI * 4 * PI * .25);
}

static void ports_in_instances(void **state)
{
    (void)state;
    const struct file window = {"window",
                                PORT "port polygon p 0 0 12 0 0 0 2 0 0 2 3 0 0 3 0\n"};
    pm_error err = PM_ERROR_INIT;
    pm_world *world = NULL;
    pm_scene *scene =
        scene_of_files(SKY "void instance one 1 window.oct 0 0\n"
                           "void instance two 9 window.oct -s 2 -rx 90 -t 9 0 0 0 0\n",
                       &window, 1);
    if (pm_world_compile(scene, &world, &err))
        fail_msg("%s", err.text);
    struct flux got = flux_in(world, BACK, 1000, .01);
    expect("instances", &got, 6 * PI + 24 * PI / 2);
    pm_scene_free(scene);
    pm_world_free(world);
}

static void no_distant_light_needs_no_ports(void **state)
{
    (void)state;
    pm_world *world =
        compiled(PORT FLAT "void light l 0 0 3 5 5 5 l sphere lamp 0 0 4 1 1 -1 .5\n");
    pm_ports *ports = NULL;
    pm_selection some = choice(world, true), none = choice(world, false);
    const pm_ports_options options = {{&some, &none}, 1000, .01};
    assert_int_equal(pm_ports_new(world, &options, &ports, NULL), PM_OK);
    assert_null(ports);
    pm_selection_clear(&some);
    pm_world_free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uniform_sky_through_a_rectangle),
        cmocka_unit_test(nothing_enters_from_the_other_side),
        cmocka_unit_test(sun_enters_by_the_cosine),
        cmocka_unit_test(overcast_sky_by_quadrature),
        cmocka_unit_test(many_small_sources_add_up),
        cmocka_unit_test(closed_ports_let_each_line_in_once),
        cmocka_unit_test(lines_through_two_windows_count_once),
        cmocka_unit_test(a_roof_takes_its_view_factor),
        cmocka_unit_test(patches_in_the_shade_get_few_photons),
        cmocka_unit_test(tables_look_where_light_comes_from),
        cmocka_unit_test(panes_take_what_they_take),
        cmocka_unit_test(mist_before_a_port_attenuates),
        cmocka_unit_test(lamps_shine_as_ever),
        cmocka_unit_test(ports_in_instances),
        cmocka_unit_test(no_distant_light_needs_no_ports),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
