/* The reference path tracer against closed forms.
 *
 * Tolerances: every estimate carries its standard error s, and must lie within K_SIGMA s of the
 * closed form, plus a stated relative slack where the form itself is rounded (a distant source
 * is treated as a point). Seeds are fixed, so a test that passes keeps passing. About 300
 * comparisons at 4 sigma fail by chance with probability 300 * 6.3e-5 = 2 %, once, when
 * written. */
#include "reference.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define PI       3.14159265358979323846
#define K_SIGMA  4.0
#define ROUNDING 1e-9 /* relative, for what has no variance */

static const double up[3] = {0, 0, 1}, down[3] = {0, 0, -1}, ahead[3] = {1, 0, 0};
static const double here[3] = {0, 0, 0};

static struct ref_scene *load(const char *text)
{
    char error[REF_ERROR_SIZE] = "";
    struct ref_scene *scene = ref_load_string(text, error);
    if (!scene)
        fail_msg("%s", error);
    return scene;
}

static struct ref_options options(uint64_t samples, bool next_event)
{
    struct ref_options o = REF_OPTIONS_DEFAULT;
    o.samples = samples;
    o.next_event = next_event;
    return o;
}

static void expect(double got, double error, double want, double slack)
{
    double allowed = K_SIGMA * error + (slack + ROUNDING) * fabs(want) + 1e-15;
    if (!(fabs(got - want) <= allowed))
        fail_msg("got %.9g, want %.9g, allowed difference %.3g (standard error %.3g)", got,
                 want, allowed, error);
}

static void expect_sound(const struct ref_result *r)
{
    assert_int_equal(r->nonfinite, 0);
    assert_int_equal(r->truncated, 0);
}

static void expect_total(const struct ref_result *r, const double want[3], double slack)
{
    expect_sound(r);
    for (int c = 0; c < 3; c++)
        expect(r->total[c], r->total_standard_error[c], want[c], slack);
}

static void expect_class(const struct ref_result *r, enum ref_class k, const double want[3],
                         double slack)
{
    expect_sound(r);
    for (int c = 0; c < 3; c++)
        expect(r->mean[k][c], r->standard_error[k][c], want[c], slack);
}

static void expect_same(const struct ref_result *a, const struct ref_result *b)
{
    expect_sound(a);
    expect_sound(b);
    for (int k = 0; k < REF_CLASSES; k++)
        for (int c = 0; c < 3; c++)
            expect(a->mean[k][c], hypot(a->standard_error[k][c], b->standard_error[k][c]),
                   b->mean[k][c], 0);
}

static void grey(double x, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = x;
}

/* Irradiance at the origin, facing up, of a polygon of radiance 1 wholly above the horizon, its
 * vertices counter-clockwise as seen from the origin's far side (Lambert 1760). */
static double lambert_polygon(const double (*v)[3], size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        const double *a = v[i], *b = v[(i + 1) % n];
        double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                           a[0] * b[1] - a[1] * b[0]};
        double size = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
        double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if (size > 0)
            sum += atan2(size, dot) * cross[2] / size;
    }
    return fabs(sum) / 2;
}

/* ---- furnaces ---- */

/* Everything inside is lossless: the radiance is 1 everywhere, along every ray. */
#define WHITE_FURNACE                                                                          \
    "void light l 0 0 3 1 1 1   l bubble wall 0 0 4 0 0 0 10\n"                                \
    "void plastic white 0 0 5 1 1 1 0 0   white sphere a 0 0 4 3 0 0 1\n"                      \
    "void mirror m 0 0 3 1 1 1   m sphere b 0 0 4 0 3 0 1\n"                                   \
    "void trans t 0 0 7 1 1 1 0 0 .5 .4   t ring c 0 0 8 0 0 -2 0 0 1 0 2\n"                   \
    "void glass g 0 0 3 1 1 1   g polygon d 0 0 9 -3 -2 -2 -3 2 -2 -3 0 2\n"                   \
    "void mist fog 0 0 7 %s 1 1 1 .6   fog sphere e 0 0 4 0 -4 0 2\n"                          \
    "void dielectric h 0 0 5 1 1 1 1.5 0   h sphere f 0 0 4 0 -4 0 1\n"                        \
    "h cylinder s 0 0 7 0 0 3 0 0 4 .5  h ring s0 0 0 8 0 0 3 0 0 -1 0 .5\n"                   \
    "h ring s1 0 0 8 0 0 4 0 0 1 0 .5\n"

static struct ref_scene *load_white_furnace(const char *extinction)
{
    char text[1000];
    snprintf(text, sizeof text, WHITE_FURNACE, extinction);
    return load(text);
}

static void check_white_furnace(const char *extinction, bool next_event, double largest_error)
{
    static const double normals[][3] = {{0, 0, 1}, {0, -1, 0}, {.6, .8, 0}};
    struct ref_scene *scene = load_white_furnace(extinction);
    struct ref_options o = options(20000, next_event);
    double pi[3];
    grey(PI, pi);
    for (int i = 0; i < 3; i++) {
        struct ref_result r;
        ref_irradiance(scene, here, normals[i], &o, &r);
        expect_total(&r, pi, 0);
        assert_true(r.total_standard_error[1] <= largest_error);
    }
    ref_free(scene);
}

static void white_furnace_has_radiance_1_everywhere(void **state)
{
    (void)state;
    check_white_furnace("1 1 1", false, 1e-9); /* on every single path, in fact */
    check_white_furnace("1 1 1", true, 1);
    check_white_furnace(".5 1 2", false, 1);
    check_white_furnace(".5 1 2", true, 1);
    check_white_furnace("5 50 0", false, 1);
}

/* Within glass the radiance is n^2 times that outside. */
static void radiance_inside_a_dielectric_is_n_squared(void **state)
{
    (void)state;
    struct ref_scene *scene = load_white_furnace("1 1 1");
    struct ref_options o = options(2000, false);
    struct ref_result r;
    double want[3];
    grey(2.25, want);
    ref_radiance(scene, (const double[3]){.1, -4.2, .3}, ahead, &o, &r);
    expect_total(&r, want, 0);
    ref_free(scene);
}

/* A sphere of albedo rho with a disc of radiance Le in place of a fraction f of it: E is
 * uniform, E = pi f Le + (1 - f) rho E. With f -> 1 this is the furnace's Le / (1 - rho)
 * series. */
#define SPHERE_F   .1
#define SPHERE_RHO .8
#define INTEGRATING_SPHERE                                                                     \
    "void plastic grey 0 0 5 .8 .8 .8 0 0   grey bubble wall 0 0 4 0 0 0 1\n"                  \
    "void light l 0 0 3 2 1 .5   l ring lamp 0 0 8 0 0 -.8 0 0 1 0 .6\n"

static void check_integrating_sphere(struct ref_scene *scene, bool next_event, int bounces)
{
    const double light[3] = {2, 1, .5}, wall[3] = {.8, 0, .6}, inward[3] = {-.8, 0, -.6};
    double direct[3], indirect[3];
    double q = (1 - SPHERE_F) * SPHERE_RHO;
    double series = bounces < 0 ? q / (1 - q) : bounces == 1 ? q : 0;
    for (int c = 0; c < 3; c++) {
        direct[c] = PI * SPHERE_F * light[c];
        indirect[c] = direct[c] * series;
    }
    struct ref_options o = options(40000, next_event);
    o.max_diffuse_bounces = bounces;
    struct ref_result r;
    ref_irradiance(scene, wall, inward, &o, &r);
    expect_class(&r, REF_DIRECT, direct, 0);
    expect_class(&r, REF_INDIRECT, indirect, 0);
    expect_class(&r, REF_CAUSTIC, here, 0);
}

static void integrating_sphere_is_a_geometric_series(void **state)
{
    (void)state;
    struct ref_scene *scene = load(INTEGRATING_SPHERE);
    for (int bounces = -1; bounces <= 1; bounces++) {
        check_integrating_sphere(scene, true, bounces);
        check_integrating_sphere(scene, false, bounces);
    }
    ref_free(scene);
}

/* Mean of 1 - F over the cosine-weighted hemisphere, F = exp(-a x) - exp(-a). */
static double mean_light_side_factor(void)
{
    double a = 5.85, floor = exp(-a);
    return 1 + floor - 2 * (1 / (a * a) - floor * (1 / a + 1 / (a * a)));
}

/* A smooth plastic or metal wall in a field of radiance 1, seen under 60 degrees. */
static void smooth_surfaces_follow_radiances_fresnel_estimate(void **state)
{
    (void)state;
    const double color[3] = {.2, .5, .8}, s = .1;
    const double estimate = exp(-5.85 * .5) - 0.00287989916;
    const double spec = s + estimate * (1 - s);
    for (int metal = 0; metal < 2; metal++) {
        char text[256];
        snprintf(text, sizeof text,
                 "void light l 0 0 3 1 1 1 l bubble w 0 0 4 0 0 0 10\n"
                 "void %s m 0 0 5 .2 .5 .8 .1 0 m ring f 0 0 8 0 0 0 0 0 1 0 5",
                 metal ? "metal" : "plastic");
        struct ref_scene *scene = load(text);
        double want[3];
        for (int c = 0; c < 3; c++)
            want[c] = (metal ? estimate + color[c] * s * (1 - estimate) : spec) +
                      color[c] * (1 - spec) * mean_light_side_factor();
        for (int nee = 0; nee < 2; nee++) {
            struct ref_options o = options(100000, nee);
            struct ref_result r;
            ref_radiance(scene, (const double[3]){0, 0, 1},
                         (const double[3]){sqrt(.75), 0, -.5}, &o, &r);
            expect_total(&r, want, 0);
        }
        ref_free(scene);
    }
}

/* ---- direct light ---- */

/* A sphere of radius r at distance d, above the horizon: E = pi L (r/d)^2 cos. */
static void sphere_light_obeys_inverse_square_and_cosine(void **state)
{
    (void)state;
    struct ref_scene *scene = load("void light l 0 0 3 3 2 1 l sphere s 0 0 4 0 0 0 .2");
    for (double d = .5; d < 10; d *= 2) {
        for (int tilt = 0; tilt <= 60; tilt += 30) {
            double angle = tilt * PI / 180;
            double e = PI * (.2 / d) * (.2 / d) * cos(angle);
            const double want[3] = {3 * e, 2 * e, e}, point[3] = {0, 0, -d};
            struct ref_options o = options(20000, true);
            struct ref_result r;
            ref_irradiance(scene, point, (const double[3]){sin(angle), 0, cos(angle)}, &o, &r);
            expect_class(&r, REF_DIRECT, want, 0);
        }
    }
    ref_free(scene);
}

/* A disc at infinity, full angle 2 a, at zenith angle z: E = pi L sin^2 a cos z = L omega cos.
 */
static void distant_source_irradiates_by_solid_angle_and_cosine(void **state)
{
    (void)state;
    struct ref_scene *scene = load("void light l 0 0 3 1e6 1 1e-3\n"
                                   "l source sun 0 0 4 3 0 4 .533\n");
    double sine = sin(.533 * PI / 360), e = PI * sine * sine * .8;
    const double want[3] = {1e6 * e, e, 1e-3 * e};
    struct ref_options o = options(10000, true);
    struct ref_result r;
    ref_irradiance(scene, here, up, &o, &r);
    expect_class(&r, REF_DIRECT, want, 0);
    ref_free(scene);
    scene = load("void glow sky 0 0 4 1 2 3 0 sky source s 0 0 4 0 0 1 180");
    o = options(10000, false);
    ref_irradiance(scene, here, up, &o, &r);
    expect_class(&r, REF_DIRECT, (const double[3]){PI, 2 * PI, 3 * PI}, 0);
    ref_free(scene);
}

/* An L of unit squares: the sample bounds are half empty, and the corner bends inward. */
static void concave_polygon_light_matches_lambert(void **state)
{
    (void)state;
    const double v[6][3] = {{0, 0, 1}, {0, 2, 1}, {1, 2, 1}, {1, 1, 1}, {2, 1, 1}, {2, 0, 1}};
    struct ref_scene *scene =
        load("void light l 0 0 3 1 1 1\n"
             "l polygon p 0 0 18 0 0 1  0 2 1  1 2 1  1 1 1  2 1 1  2 0 1");
    double want[3];
    grey(lambert_polygon(v, 6), want);
    for (int nee = 0; nee < 2; nee++) {
        struct ref_options o = options(100000, nee);
        struct ref_result r;
        ref_irradiance(scene, here, up, &o, &r);
        expect_class(&r, REF_DIRECT, want, 0);
        ref_irradiance(scene, (const double[3]){0, 0, 2}, down, &o, &r);
        expect_total(&r, here, 0); /* its back is dark */
    }
    ref_free(scene);
}

/* Each shape is found by rays and sampled as a light; both must see the same one. */
static void lights_of_every_shape_are_sampled_as_they_are_hit(void **state)
{
    (void)state;
    static const char *shapes[] = {
        "l cylinder s 0 0 7 -1 .5 2 1 .5 2.5 .4", "l tube s 0 0 7 0 0 1 0 .3 2 .8",
        "l cone s 0 0 8 0 .2 2.5 0 0 1 1 .3",     "l cup s 0 0 8 0 0 1 0 .1 2 .9 .4",
        "l cone s 0 0 8 0 0 1 0 0 2 0 1",         "l bubble s 0 0 4 0 .2 .3 1",
        "l ring s 0 0 8 .3 0 1 0 .1 -1 1.2 .4",   "l sphere s 0 0 4 0 .6 .3 .5",
    };
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        char text[200];
        snprintf(text, sizeof text, "void light l 0 0 3 1 1 1\n%s\n", shapes[i]);
        struct ref_scene *scene = load(text);
        struct ref_options hit = options(60000, false), sampled = options(60000, true);
        struct ref_result a, b;
        ref_irradiance(scene, here, up, &hit, &a);
        ref_irradiance(scene, here, up, &sampled, &b);
        assert_true(b.total[0] > .01);
        expect_same(&a, &b);
        ref_free(scene);
    }
}

/* On its axis a disc of radius R at height h gives pi L R^2 / (R^2 + h^2). */
static void spotlight_shines_within_its_cone_only(void **state)
{
    (void)state;
    struct ref_scene *scene = load("void spotlight l 0 0 7 1 1 1 40 0 0 -5\n"
                                   "l ring s 0 0 8 0 0 1 0 0 -1 0 .1");
    double want[3];
    struct ref_options o = options(20000, true);
    struct ref_result r;
    grey(PI * .01 / 1.01, want);
    ref_irradiance(scene, here, up, &o, &r);
    expect_class(&r, REF_DIRECT, want, 0);
    ref_irradiance(scene, (const double[3]){.5, 0, 0}, up, &o, &r); /* 21.8 degrees at least */
    expect_total(&r, here, 0);
    ref_free(scene);
}

/* Coaxial discs of radii a (sensor) and b at height h: E = pi L F, with the textbook's
 * F = (x - sqrt(x^2 - 4 (b/a)^2)) / 2, x = 1 + (h^2 + b^2) / a^2. */
static void disc_mean_is_the_view_factor(void **state)
{
    (void)state;
    struct ref_scene *scene = load("void light l 0 0 3 1 1 1 l ring s 0 0 8 0 0 1 0 0 -1 0 .5");
    double a = 2, b = .5, h = 1, x = 1 + (h * h + b * b) / (a * a), want[3];
    grey(PI * (x - sqrt(x * x - 4 * (b / a) * (b / a))) / 2, want);
    struct ref_options o = options(50000, true);
    struct ref_result r;
    ref_irradiance_disc(scene, here, up, a, &o, &r);
    expect_class(&r, REF_DIRECT, want, 0);
    ref_free(scene);
}

/* ---- mirrors, panes, slabs ---- */

/* A lamp that faces away from the sensor, seen in a mirror: its image's irradiance times rho.
 */
static void mirror_shows_the_image_as_caustic(void **state)
{
    (void)state;
    const double image[4][3] = {{2, -.5, 3}, {3, -.5, 3}, {3, .5, 3}, {2, .5, 3}};
    struct ref_scene *scene =
        load("void light l 0 0 3 1 1 1 l polygon p 0 0 12 2 -.5 1 3 -.5 1 3 .5 1 2 .5 1\n"
             "void mirror m 0 0 3 .9 .6 .3 m ring r 0 0 8 0 0 2 0 0 -1 0 9\n");
    double e = lambert_polygon(image, 4);
    const double want[3] = {.9 * e, .6 * e, .3 * e};
    for (int nee = 0; nee < 2; nee++) {
        struct ref_options o = options(200000, nee);
        struct ref_result r;
        ref_irradiance(scene, here, up, &o, &r);
        expect_class(&r, REF_CAUSTIC, want, 0);
        expect_class(&r, REF_DIRECT, here, 0);
    }
    ref_free(scene);
}

static void mirror_is_black_behind(void **state)
{
    (void)state;
    struct ref_scene *scene = load("void light l 0 0 3 1 1 1 l bubble b 0 0 4 0 0 0 9\n"
                                   "void mirror m 0 0 3 1 1 1 m ring r 0 0 8 0 0 0 0 0 1 0 1");
    const double white[3] = {1, 1, 1};
    struct ref_options o = options(100, true);
    struct ref_result r;
    ref_radiance(scene, (const double[3]){0, 0, 1}, down, &o, &r);
    expect_class(&r, REF_CAUSTIC, white, 0);
    ref_radiance(scene, (const double[3]){0, 0, -1}, up, &o, &r);
    expect_total(&r, here, 0);
    ref_free(scene);
}

/* Light through (or off) two faces of reflectance r with inner transmissivity a, added up order
 * by order. */
static double pane_orders(double r, double a, bool transmitted)
{
    double sum = transmitted ? 0 : r, ray = (1 - r) * a;
    for (int faces = 1; faces < 400; faces++) {
        if ((faces % 2 == 1) == transmitted)
            sum += ray * (1 - r);
        ray *= r * a;
    }
    return sum;
}

/* Reflectances after Fresnel, from angles: sin^2(i - t) / sin^2(i + t) and the tangents'. */
static void fresnel_by_angles(double i, double n, double *s, double *p)
{
    double t = asin(sin(i) / n);
    *s = *p = (n - 1) * (n - 1) / ((n + 1) * (n + 1));
    if (i > 0) {
        *s = pow(sin(i - t) / sin(i + t), 2);
        *p = pow(tan(i - t) / tan(i + t), 2);
    }
}

static const double test_angles_deg[] = {0, 45, 80};

/* Radiance's glass: polarisations apart; transmissivity per normal pass, path 1/cos(t) longer.
 */
static void glass_pane_sums_all_orders_of_both_polarisations(void **state)
{
    (void)state;
    const double color[3] = {.96, .7, .3}, n = 1.52;
    struct ref_scene *scene =
        load("void light l 0 0 3 1 1 1 l source s 0 0 4 0 0 1 180\n"
             "void glass g 0 0 3 .96 .7 .3 g ring p 0 0 8 0 0 0 0 0 1 0 99");
    for (int k = 0; k < 3; k++) {
        double i = test_angles_deg[k] * PI / 180, t = asin(sin(i) / n), s, p;
        double passed[3], reflected[3];
        fresnel_by_angles(i, n, &s, &p);
        for (int c = 0; c < 3; c++) {
            double a = pow(color[c], 1 / cos(t));
            passed[c] = (pane_orders(s, a, true) + pane_orders(p, a, true)) / 2;
            reflected[c] = (pane_orders(s, a, false) + pane_orders(p, a, false)) / 2;
        }
        struct ref_options o = options(200000, true);
        struct ref_result r;
        ref_radiance(scene, (const double[3]){0, 0, -1}, (const double[3]){sin(i), 0, cos(i)},
                     &o, &r);
        expect_class(&r, REF_DIRECT, passed, 0);
        ref_radiance(scene, (const double[3]){0, 0, 1}, (const double[3]){sin(i), 0, -cos(i)},
                     &o, &r);
        expect_class(&r, REF_CAUSTIC, reflected, 0);
    }
    ref_free(scene);
}

/* Next-event rays pass the pane: E = pi L sin^2 a cos z T(z). Slack: T varies over the source's
 * quarter degree only in second order, (0.0044)^2 < 1e-4. */
static void direct_light_passes_glass_and_smooth_trans(void **state)
{
    (void)state;
    struct ref_scene *scene =
        load("void light l 0 0 3 1e5 1e5 1e5 l source s 0 0 4 1 0 1 .5\n"
             "void glass g 0 0 4 .9 .9 .9 1.6 g ring p 0 0 8 0 0 1 0 0 1 0 99\n"
             "void trans t 0 0 7 .5 .6 .7 0 0 .8 .5 t ring q 0 0 8 0 0 2 0 0 1 0 99");
    double i = PI / 4, t = asin(sin(i) / 1.6), a = pow(.9, 1 / cos(t)), s, p, want[3];
    double sine = sin(.5 * PI / 360);
    fresnel_by_angles(i, 1.6, &s, &p);
    double e = 1e5 * PI * sine * sine * cos(i) * .4 *
               (pane_orders(s, a, true) + pane_orders(p, a, true)) / 2;
    for (int c = 0; c < 3; c++)
        want[c] = e * (.5 + .1 * c);
    struct ref_options o = options(10000, true);
    struct ref_result r;
    ref_irradiance(scene, here, up, &o, &r);
    expect_class(&r, REF_DIRECT, want, 1e-4);
    ref_free(scene);
}

/* Two faces 0.5 apart; Radiance tracks no polarisation, so each face has the mean reflectance.
 */
static void dielectric_slab_sums_all_orders(void **state)
{
    (void)state;
    const double clear[3] = {1, .5, .1}, n = 1.5, thick = .5;
    struct ref_scene *scene = load("void light l 0 0 3 1 1 1 l source s 0 0 4 0 0 1 180\n"
                                   "void dielectric d 0 0 5 1 .5 .1 1.49 5\n"
                                   "d ring top 0 0 8 0 0 .5 0 0 1 0 99\n"
                                   "d ring bottom 0 0 8 0 0 0 0 0 -1 0 99");
    for (int k = 0; k < 3; k++) {
        double i = test_angles_deg[k] * PI / 180, t = asin(sin(i) / n), s, p, passed[3],
               back[3];
        fresnel_by_angles(i, n, &s, &p);
        for (int c = 0; c < 3; c++) {
            passed[c] = pane_orders((s + p) / 2, pow(clear[c], thick / cos(t)), true);
            back[c] = pane_orders((s + p) / 2, pow(clear[c], thick / cos(t)), false);
        }
        struct ref_options o = options(200000, true);
        struct ref_result r;
        ref_radiance(scene, (const double[3]){0, 0, -1}, (const double[3]){sin(i), 0, cos(i)},
                     &o, &r);
        expect_class(&r, REF_CAUSTIC, passed, 0);
        ref_radiance(scene, (const double[3]){0, 0, 1}, (const double[3]){sin(i), 0, -cos(i)},
                     &o, &r);
        expect_class(&r, REF_CAUSTIC, back, 0);
    }
    ref_free(scene);
}

/* ---- mist ---- */

#define MIST_BOX                                                                               \
    "fog polygon x0 0 0 12 -1 -9 -9 -1 -9 9 -1 9 9 -1 9 -9\n"                                  \
    "fog polygon x1 0 0 12 1 -9 -9 1 9 -9 1 9 9 1 -9 9\n"                                      \
    "fog polygon y0 0 0 12 -1 -9 -9 1 -9 -9 1 -9 9 -1 -9 9\n"                                  \
    "fog polygon y1 0 0 12 -1 9 -9 -1 9 9 1 9 9 1 9 -9\n"                                      \
    "fog polygon z0 0 0 12 -1 -9 -9 -1 9 -9 1 9 -9 1 -9 -9\n"                                  \
    "fog polygon z1 0 0 12 -1 -9 9 1 -9 9 1 9 9 -1 9 9\n"

/* Unscattered light falls by exp(-extinction * distance), from outside and from within. The
 * source is seen whole through the mist, 60 degrees off: slack for its size. */
static void mist_attenuates_as_beer_and_lambert_say(void **state)
{
    (void)state;
    const double extinction[3] = {.1, .5, 2};
    struct ref_scene *scene =
        load("void light l 0 0 3 1e5 1e5 1e5 l source s 0 0 4 .5 .8660254037844386 0 .2\n"
             "void mist fog 0 0 7 .1 .5 2 .9 .5 .1 .3\n" MIST_BOX);
    double sine = sin(.2 * PI / 360), e = 1e5 * PI * sine * sine * .5;
    const double points[3] = {-1.5, -1, .5};
    for (int i = 0; i < 3; i++) {
        double length = fmin(2, 1 - points[i]) / .5, want[3];
        for (int c = 0; c < 3; c++)
            want[c] = e * exp(-extinction[c] * length);
        struct ref_options o = options(2000, true);
        struct ref_result r;
        ref_irradiance(scene, (const double[3]){points[i], 0, 0}, ahead, &o, &r);
        expect_class(&r, REF_DIRECT, want, 1e-3);
    }
    ref_free(scene);
}

/* Along the axis of a glass ball in the mist: none in the ball, all of it before and behind. */
static void mist_stops_at_a_dielectric_and_resumes_behind_it(void **state)
{
    (void)state;
    const double extinction[3] = {.1, .5, 2};
    struct ref_scene *scene = load("void light l 0 0 3 1 1 1 l source s 0 0 4 1 0 0 170\n"
                                   "void mist fog 0 0 6 .1 .5 2 0 0 0\n" MIST_BOX
                                   "void dielectric d 0 0 5 .8 .8 .8 1.5 0\n"
                                   "d sphere ball 0 0 4 0 0 0 .6\n");
    double outside[3], inside[3];
    for (int c = 0; c < 3; c++) {
        double all = pane_orders(.04, pow(.8, 1.2), true);
        outside[c] = exp(-extinction[c] * .8) * all;
        /* From the centre: every odd pass through the far face shows the source. */
        inside[c] = 2.25 * exp(-extinction[c] * .4) * pow(.8, .6) * .96 /
                    (1 - pow(.04 * pow(.8, 1.2), 2));
    }
    struct ref_options o = options(100000, true);
    struct ref_result r;
    ref_radiance(scene, (const double[3]){-3, 0, 0}, ahead, &o, &r);
    expect_class(&r, REF_CAUSTIC, outside, 0);
    ref_radiance(scene, here, ahead, &o, &r);
    expect_class(&r, REF_CAUSTIC, inside, 0);
    ref_free(scene);
}

/* A ray across the mist, lit from the side by a small source h = 2 deep: with E0 its
 * irradiance, L = albedo p(90 deg) E0 exp(-2 sigma) (1 - exp(-sigma D)). Slack for the source's
 * size. */
static void single_scattering_is_per_channel_and_henyey_greenstein(void **state)
{
    (void)state;
    const double extinction[3] = {.1, .5, 1.5}, albedo[3] = {.9, .5, .2};
    struct ref_scene *scene = load("void light l 0 0 3 1e6 1e6 1e6 l source s 0 0 4 0 0 1 .2\n"
                                   "void mist fog 0 0 7 .1 .5 1.5 .9 .5 .2 .6\n" MIST_BOX);
    double sine = sin(.2 * PI / 360), e0 = 1e6 * PI * sine * sine;
    double phase = (1 - .36) / (4 * PI * pow(1 + .36, 1.5));
    for (int inside = 0; inside < 2; inside++) {
        double want[3];
        for (int c = 0; c < 3; c++)
            want[c] = albedo[c] * phase * e0 * exp(-2 * extinction[c]) *
                      (1 - exp(-extinction[c] * (inside ? 1 : 2)));
        struct ref_options o = options(100000, true);
        o.max_diffuse_bounces = 1;
        struct ref_result r;
        ref_radiance(scene, (const double[3]){inside ? 0 : -2, 0, 7}, ahead, &o, &r);
        expect_class(&r, REF_INDIRECT, want, 1e-3);
    }
    ref_free(scene);
}

/* Phase function and its sampling agree: light seen after one scattering, sampled or hit. */
static void phase_sampling_matches_phase_value(void **state)
{
    (void)state;
    struct ref_scene *scene = load("void light l 0 0 3 1 1 1 l source s 0 0 4 1 1 0 60\n"
                                   "void mist fog 0 0 7 1 1 1 1 1 1 -.4\n"
                                   "fog sphere f 0 0 4 0 0 0 1");
    struct ref_options hit = options(200000, false), sampled = options(100000, true);
    hit.max_diffuse_bounces = sampled.max_diffuse_bounces = 1;
    struct ref_result a, b;
    ref_radiance(scene, (const double[3]){0, .3, -2}, up, &hit, &a);
    ref_radiance(scene, (const double[3]){0, .3, -2}, up, &sampled, &b);
    assert_true(b.mean[REF_INDIRECT][0] > 0);
    expect_same(&a, &b);
    ref_free(scene);
}

/* ---- everything at once ---- */

#define ROOM                                                                                   \
    "void plastic wall 0 0 5 .7 .6 .5 0 0   wall bubble room 0 0 4 0 0 0 3\n"                  \
    "void light l 0 0 3 10 10 8   l ring lamp 0 0 8 0 0 2 0 0 -1 0 1\n"                        \
    "void plastic shiny 0 0 5 .3 .5 .2 .05 0   shiny ring table 0 0 8 0 0 -1.5 0 0 1 0 1.5\n"  \
    "void mirror m 0 0 3 .9 .9 .8   m polygon mir 0 0 12 -2 -1 -1 -2 1 -1 -2 1 1 -2 -1 1\n"    \
    "void metal gold 0 0 5 .9 .7 .2 .8 0   gold cylinder can 0 0 7 1 1 -1 1 1 0 .3\n"          \
    "void glass g 0 0 3 .9 .95 .8   g polygon pane 0 0 12 -1 -1 1 1 -1 1 1 1 1.2 -1 1 1.2\n"   \
    "void trans t 0 0 7 .8 .7 .9 .03 0 .6 .4   t ring leaf 0 0 8 1 -1 .2 0 .3 1 0 .7\n"        \
    "void mist fog 0 0 7 .2 .4 .9 .9 .8 .6 .5   fog sphere cloud 0 0 4 0 0 0 1.3\n"            \
    "void dielectric d 0 0 5 .9 .95 1 1.5 0   d sphere ball 0 0 4 0 .1 -.3 .5\n"

static void next_event_estimation_does_not_change_any_class(void **state)
{
    (void)state;
    static const double points[][3] = {
        {0, 0, -1.5}, {0, .05, -.2}, {0, .1, -.9}, {-1.2, 0, .3}};
    struct ref_scene *scene = load(ROOM);
    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
        struct ref_options hit = options(150000, false), sampled = options(60000, true);
        struct ref_result a, b;
        ref_irradiance(scene, points[i], up, &hit, &a);
        ref_irradiance(scene, points[i], up, &sampled, &b);
        expect_same(&a, &b);
        hit.max_diffuse_bounces = sampled.max_diffuse_bounces = 1;
        ref_irradiance_disc(scene, points[i], up, .1, &hit, &a);
        ref_irradiance_disc(scene, points[i], up, .1, &sampled, &b);
        expect_same(&a, &b);
    }
    ref_free(scene);
}

static void equal_seeds_give_equal_bytes(void **state)
{
    (void)state;
    struct ref_scene *scene = load(ROOM);
    struct ref_options o = options(500, true);
    struct ref_result a, b;
    ref_irradiance(scene, here, up, &o, &a);
    ref_irradiance(scene, here, up, &o, &b);
    assert_memory_equal(&a, &b, sizeof a);
    o.seed = 2;
    ref_irradiance(scene, here, up, &o, &b);
    assert_memory_not_equal(&a, &b, sizeof a);
    ref_free(scene);
}

/* ---- reader ---- */

static void bad_text_is_refused_with_its_line(void **state)
{
    (void)state;
    static const struct {
        const char *text, *error;
    } cases[] = {
        {"void light l 0 0 3 1 1", "1: the text ends within a primitive"},
        {"# a\n\nvoid light l 0 0 3 1 one 1", "3: 'one' is not a finite number"},
        {"void light l 0 x", "1: 'x' is not an argument count"},
        {"void light l 0 1 1 3 1 1 1", "1: integer arguments are not supported"},
        {"void antimatter l 1 void 0 0", "1: string arguments of antimatter are not supported"},
        {"void colorpict p 0 0 0", "1: unsupported type 'colorpict'"},
        {"no sphere s 0 0 4 0 0 0 1", "1: unknown material 'no'"},
        {"void plastic p 0 0 5 .1 .1 .1 .1 .2", "1: roughness is not supported"},
        {"void plastic p 0 0 4 .1 .1 .1 .1", "1: wrong number of real arguments for plastic"},
        {"void mirror p 0 0 3 .1 2 .1", "1: colour 2 is outside [0, 1]"},
        {"void light l 0 0 3 1 1 1\nl sphere s 0 0 4 0 0 0 0",
         "2: sphere takes a centre and a radius > 0"},
        {"void light l 0 0 3 1 1 1\nl polygon p 0 0 12 0 0 0 1 0 0 1 1 0 0 1 1",
         "2: polygon is not planar at vertex 2"},
        {"void plastic p 0 0 5 1 1 1 0 0\np source s 0 0 4 0 0 1 1",
         "2: a source must be made of light or glow"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char error[REF_ERROR_SIZE] = "";
        assert_null(ref_load_string(cases[i].text, error));
        assert_string_equal(error, cases[i].error);
    }
    char error[REF_ERROR_SIZE] = "";
    assert_null(ref_load_file("/nonexistent/scene.rad", error));
    assert_string_equal(error, "0: cannot read '/nonexistent/scene.rad'");
    ref_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_furnace_has_radiance_1_everywhere),
        cmocka_unit_test(radiance_inside_a_dielectric_is_n_squared),
        cmocka_unit_test(integrating_sphere_is_a_geometric_series),
        cmocka_unit_test(smooth_surfaces_follow_radiances_fresnel_estimate),
        cmocka_unit_test(sphere_light_obeys_inverse_square_and_cosine),
        cmocka_unit_test(distant_source_irradiates_by_solid_angle_and_cosine),
        cmocka_unit_test(concave_polygon_light_matches_lambert),
        cmocka_unit_test(lights_of_every_shape_are_sampled_as_they_are_hit),
        cmocka_unit_test(spotlight_shines_within_its_cone_only),
        cmocka_unit_test(disc_mean_is_the_view_factor),
        cmocka_unit_test(mirror_shows_the_image_as_caustic),
        cmocka_unit_test(mirror_is_black_behind),
        cmocka_unit_test(glass_pane_sums_all_orders_of_both_polarisations),
        cmocka_unit_test(direct_light_passes_glass_and_smooth_trans),
        cmocka_unit_test(dielectric_slab_sums_all_orders),
        cmocka_unit_test(mist_attenuates_as_beer_and_lambert_say),
        cmocka_unit_test(mist_stops_at_a_dielectric_and_resumes_behind_it),
        cmocka_unit_test(single_scattering_is_per_channel_and_henyey_greenstein),
        cmocka_unit_test(phase_sampling_matches_phase_value),
        cmocka_unit_test(next_event_estimation_does_not_change_any_class),
        cmocka_unit_test(equal_seeds_give_equal_bytes),
        cmocka_unit_test(bad_text_is_refused_with_its_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
