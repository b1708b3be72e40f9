/* Where density estimates leave a flat, even, endless surface: steps of light, edges, corners,
 * thin walls, curved surfaces. */
#include "physics.h"

/* ---- a step of light ----
 *
 * A sun 1 at the zenith, a clear slab, above it a black screen over x < 0: the floor's
 * irradiance, all of it specular light, is a step at x = 0 that the sun's disc blurs to
 * +- .05 degrees times 1. */
#define STEP_IRRADIANCE (.96 / 1.04)
#define STEP                                                                                   \
    "void light sun 0 0 3 %.17g %.17g %.17g  sun source s 0 0 4 0 0 1 .1\n"                    \
    "void plastic black 0 0 5 0 0 0 0 0\n"                                                     \
    "black polygon screen 0 0 12 -2 -2 1 0 -2 1 0 2 1 -2 2 1\n"                                \
    "void dielectric clear 0 0 5 1 1 1 1.5 0\n"                                                \
    "clear polygon top 0 0 12 -1.5 -1.5 .6 1.5 -1.5 .6 1.5 1.5 .6 -1.5 1.5 .6\n"               \
    "clear polygon low 0 0 12 -1.5 -1.5 .5 -1.5 1.5 .5 1.5 1.5 .5 1.5 -1.5 .5\n"               \
    "clear polygon south 0 0 12 -1.5 -1.5 .5 1.5 -1.5 .5 1.5 -1.5 .6 -1.5 -1.5 .6\n"           \
    "clear polygon north 0 0 12 -1.5 1.5 .5 -1.5 1.5 .6 1.5 1.5 .6 1.5 1.5 .5\n"               \
    "clear polygon west 0 0 12 -1.5 -1.5 .5 -1.5 -1.5 .6 -1.5 1.5 .6 -1.5 1.5 .5\n"            \
    "clear polygon east 0 0 12 1.5 -1.5 .5 1.5 1.5 .5 1.5 1.5 .6 1.5 -1.5 .6\n"                \
    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"                                             \
    "dark polygon floor 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\n"

#define BLUR (PI / 3600) /* .05 degrees */

static char *step_scene(void)
{
    double radiance = sun_radiance();
    return text_of(STEP, radiance, radiance, radiance);
}

/* Share of a disc of radius r that lies in the light, its middle d from the edge on the lit
 * side: Schregle 2015's convolution of the field with the flat kernel. */
static double lit_share(double d, double r)
{
    double x = d / r;
    if (fabs(x) >= 1)
        return x > 0;
    return 1 - (acos(x) - x * sqrt(1 - x * x)) / PI;
}

enum { PLACES = 7 };
static const double places[PLACES] = {-.15, -.08, -.03, 0, .03, .08, .15};

/* The estimate at a fixed radius is the kernel-convolved field, exactly, whatever the photons'
 * pattern. Per place and seed the mean over a row of look-ups. */
static void estimate_of_a_fixed_radius_is_the_convolved_field(void **state)
{
    (void)state;
    enum { ROW = 9, PHOTONS = 20000 };
    const double radius = .1;
    struct stat got[PLACES] = {0};
    char *text = step_scene();
    pm_job job = job_of(PM_JOB_MAP, 0);
    want_map(&job, PM_MAP_CAUSTIC, PHOTONS, 50);
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        pm_answer answer;
        job.forward.seed = seed;
        run_job(&job, text, NULL, &answer);
        const pm_photon_map *map = answer.map[PM_MAP_CAUSTIC];
        const pm_map_header *h = pm_photon_map_header(map);
        for (int i = 0; i < PLACES; i++) {
            double sum = 0;
            for (int k = 0; k < ROW; k++) {
                pm_vec3 point =
                    pm_vec3_sub((pm_vec3){places[i], .2 * (k - 4), 0}, h->world_center);
                point = pm_vec3_scale(point, 1 / h->world_scale);
                sum += pm_photon_map_within(map, point, (pm_vec3){0, 0, 1},
                                            radius / h->world_scale, PM_PHOTONS_ALL, NULL)
                           .irradiance.r;
            }
            stat_add(&got[i], sum / ROW);
        }
        pm_answer_clear(&answer);
    }
    for (int i = 0; i < PLACES; i++) {
        /* the share's slope is 2 / pi r at most, and BLUR has no mean but for its square */
        double want = STEP_IRRADIANCE * lit_share(places[i], radius);
        double slack = STEP_IRRADIANCE * (1. / PHOTONS + .001 + pow(BLUR / radius, 2));
        expect_mean("fixed radius", &got[i], want, slack);
    }
    free(text);
}

/* The K nearest of photons of density D on the lit half: A = D times the lit part of the disc
 * out to the next photon is gamma distributed with K + 1, and the estimate is K over the whole
 * disc. */
struct nearest {
    double distance, density, count;
};

static double radius_with_lit_area(double distance, double area)
{
    double low = 0, high = 4;
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        if (PI * middle * middle * lit_share(distance, middle) < area)
            low = middle;
        else
            high = middle;
    }
    return high;
}

static double weighted_estimate(double a, const void *context)
{
    const struct nearest *n = context;
    double r = radius_with_lit_area(n->distance, a / n->density);
    double probability = exp(n->count * log(a) - a - lgamma(n->count + 1));
    return probability * n->count / (PI * r * r);
}

/* Photons more even than by chance are off by 1 / K of the estimate at most: test_density.c. */
static void estimate_of_the_nearest_is_that_of_its_quadrature(void **state)
{
    (void)state;
    enum { ROW = 9, PHOTONS = 20000, GATHER = 100 };
    char *text = step_scene();
    for (int i = 0; i < PLACES; i++) {
        pm_sensor sensors[ROW];
        for (int k = 0; k < ROW; k++)
            sensors[k] = (pm_sensor){{places[i], .2 * (k - 4), 0}, {0, 0, 1}};
        pm_job job = job_of(PM_JOB_TRACE, 0);
        want_map(&job, PM_MAP_CAUSTIC, PHOTONS, GATHER);
        look_at(&job, sensors, ROW, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS / 2, GREY);
        /* the lit floor [0, 1] x [-1, 1] has all photons */
        const struct nearest n = {places[i], PHOTONS / 2., GATHER};
        double spread = 8 * sqrt(GATHER);
        double want = STEP_IRRADIANCE / n.density *
                      integrate(weighted_estimate, &n, GATHER - spread, GATHER + spread, 400);
        char what[40];
        snprintf(what, sizeof what, "nearest at %g", places[i]);
        expect_mean(what, &got, want, (1. / GATHER + 1. / PHOTONS + .001) * want);
    }
    free(text);
}

/* ---- a wall without thickness ----
 *
 * Two rooms in one box, x < 0 without a lamp. Floor, ceiling and walls are one polygon for both
 * rooms. What lies behind the wall is dark, to the last photon. */
#define TWO_ROOMS                                                                              \
    "void plastic wall 0 0 5 .7 .6 .5 0 0\n" BOX(                                              \
        "wall") "wall polygon between 0 0 12 0 -1 -1 0 1 -1 0 1 1 0 -1 1\n"                    \
                "void light bright 0 0 3 9 9 9\n"                                              \
                "bright polygon lamp 0 0 12 .3 -.3 .9 .3 .3 .9 .7 .3 .9 .7 -.3 .9\n"

static void nothing_comes_through_a_wall_without_thickness(void **state)
{
    (void)state;
    static const pm_sensor sensors[] = {
        {{0, .1, .2}, {-1, 0, 0}},     {{0, 0, -.999}, {-1, 0, 0}},
        {{-.01, .2, -1}, {0, 0, 1}},   {{-.1, -.3, -1}, {0, 0, 1}},
        {{-.3, 0, -1}, {0, 0, 1}},     {{-.05, .1, 1}, {0, 0, -1}},
        {{-.02, -1, .3}, {0, 1, 0}},   {{-.02, 1, -.8}, {0, -1, 0}},
        {{-.01, -.99, -1}, {0, 0, 1}}, {{-.2, .4, .1}, {1, 0, 0}},
    };
    enum { COUNT = sizeof sensors / sizeof *sensors };
    for (int i = 0; i < 2 * MODES; i++) {
        const struct mode *mode = &modes[i % MODES];
        pm_job job = job_of_mode(mode, 20000, 50);
        pm_answer answer;
        if (i >= MODES && mode->progressive)
            continue;
        if (i >= MODES) { /* the same with the other estimates */
            job.wanted.maps[PM_MAP_GLOBAL].precomputed = mode->global;
            job.wanted.maps[PM_MAP_CAUSTIC].gather_max = mode->caustic ? 200 : 0;
        }
        look_at(&job, sensors, COUNT, PM_IRRADIANCE);
        run_job(&job, TWO_ROOMS, NULL, &answer);
        for (int k = 0; k < 3 * COUNT; k++)
            if (answer.values[k] != 0)
                fail_msg("%s%s: sensor %d in the dark room has %g", mode->name,
                         i < MODES ? "" : ", precomputed or adapted", k / 3,
                         (double)answer.values[k]);
        pm_answer_clear(&answer);
    }
}

/* ---- even light ----
 *
 * A sky of radiance 1 all around, and a shell of index 1, which bends nothing but makes all
 * light specular light. Convex things have irradiance pi everywhere. */
#define EVEN_SKY                                                                               \
    "void glow sky 0 0 4 1 1 1 0  sky source all 0 0 4 0 0 1 360\n"                            \
    "void dielectric air 0 0 5 1 1 1 1 0  air sphere shell 0 0 4 0 0 0 1.8\n"                  \
    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"

/* ---- a corner ----
 *
 * Floor [0, 1]^2, black walls of height 1 on two of its edges, even light. A wall at distance d
 * that reaches from `a` on one side to `b` on the other takes from an element of the floor
 *   F = (atan(a/d) + atan(b/d) - d/s (atan(a/s) + atan(b/s))) / 2 pi,  s^2 = d^2 + 1
 * of its view (integral of z d / pi (d^2 + y^2 + z^2)^2), so E = pi (1 - F1 - F2). */
static double wall_factor(double d, double a, double b)
{
    double s = sqrt(d * d + 1);
    return (atan(a / d) + atan(b / d) - d / s * (atan(a / s) + atan(b / s))) / (2 * PI);
}

static double corner_irradiance(double x, double y)
{
    return PI * (1 - wall_factor(x, y, 1 - y) - wall_factor(y, x, 1 - x));
}

#define CORNER                                                                                 \
    "void glow sky 0 0 4 1 1 1 0  sky source all 0 0 4 0 0 1 360\n"                            \
    "void dielectric air 0 0 5 1 1 1 1 0  air sphere shell 0 0 4 .5 .5 .5 .9\n"                \
    "void plastic dark 0 0 5 .001 .001 .001 0 0\n"                                             \
    "dark polygon floor 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n"                                      \
    "dark polygon west 0 0 12 0 0 0 0 1 0 0 1 1 0 0 1\n"                                       \
    "dark polygon south 0 0 12 0 0 0 0 0 1 1 0 1 1 0 0\n"

/* At the walls' feet, near them, in the corner: places that symmetry makes the same. */
enum { ROWS = 3, ROW = 16 };

static void corner_rows(pm_sensor sensors[ROWS * ROW])
{
    static const double distance[2] = {.001, .04};
    for (int i = 0; i < ROWS * ROW; i++) {
        int k = i % ROW, row = i / ROW;
        double along = row < 2 ? .2 + .08 * (k / 2) : .001;
        double across = row < 2 ? distance[row] : .001;
        bool swap = k % 2;
        sensors[i] = (pm_sensor){{swap ? along : across, swap ? across : along, 0}, {0, 0, 1}};
    }
}

/* Per seed the mean over a row of got / want. */
static void measure_rows(pm_job *job, const char *text, const pm_sensor *sensors, int rows,
                         int row_length, double (*want)(double, double), struct stat *got)
{
    look_at(job, sensors, (size_t)(rows * row_length), PM_IRRADIANCE);
    for (unsigned seed = 1; seed <= SEEDS / 2; seed++) {
        pm_answer answer;
        job->forward.seed = seed;
        run_job(job, text, NULL, &answer);
        for (int row = 0; row < rows; row++) {
            double sum = 0;
            for (int i = row * row_length; i < (row + 1) * row_length; i++)
                sum += (double)answer.values[3 * i] /
                       want(sensors[i].point.x, sensors[i].point.y) / row_length;
            stat_add(&got[row], sum);
        }
        pm_answer_clear(&answer);
    }
}

/* Photons are spread over the floor, both sides of two walls and its underside; so K of them
 * reach sqrt(5 K / N / pi) in the open, twice as far in the corner, where the light is a
 * quarter. The middle of what a half or quarter disc averages is 4 / 3 pi of its radius away
 * from each edge, where there is more light by the slope of E. */
static void the_floor_in_a_corner_is_right_but_for_the_kernel(void **state)
{
    (void)state;
    enum { PHOTONS = 100000, GATHER = 100 };
    pm_sensor sensors[ROWS * ROW];
    struct stat got[ROWS] = {0};
    corner_rows(sensors);
    pm_job job = job_of(PM_JOB_TRACE, -1);
    want_map(&job, PM_MAP_GLOBAL, PHOTONS, GATHER);
    job.passes = 16;
    measure_rows(&job, CORNER, sensors, ROWS, ROW, corner_irradiance, got);
    for (int row = 0; row < ROWS; row++) {
        double x = sensors[row * ROW].point.x, y = sensors[row * ROW].point.y;
        double share = corner_irradiance(x, y) / PI * (row == 2 ? .25 : .5);
        double radius = sqrt(5. * GATHER / PHOTONS / PI / share), off = 4 / (3 * PI) * radius;
        double far = corner_irradiance(x + off, row == 2 ? y + off : y);
        double bias = far / corner_irradiance(x, y) - 1;
        char what[80];
        snprintf(what, sizeof what, "row %d", row);
        expect_mean(what, &got[row], 1, bias);
    }
}

/* ---- edges and corners of a cube in even light: pi up to the very end ---- */

enum { CUBE_ROW = 24, CUBE_ROWS = 4 };

/* The same place on each of the three faces at all eight corners. */
static void around_corners(double x, double y, pm_sensor sensors[CUBE_ROW])
{
    for (int i = 0; i < CUBE_ROW; i++) {
        const double at[3] = {i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? 1 : -1};
        double p[3], n[3] = {0, 0, 0};
        for (int c = 0; c < 3; c++)
            p[(c + i / 8) % 3] = at[c];
        n[(2 + i / 8) % 3] = at[2];
        sensors[i] = (pm_sensor){{p[0], p[1], p[2]}, {n[0], n[1], n[2]}};
    }
}

static double even(double x, double y)
{
    (void)x, (void)y;
    return PI;
}

static void edges_and_corners_are_right_within_one_percent(void **state)
{
    (void)state;
    static const double places_on_face[CUBE_ROWS][2] = {
        {.999, .999}, {.95, .95}, {.999, .3}, {.95, .3}};
    pm_sensor sensors[CUBE_ROWS * CUBE_ROW];
    for (int row = 0; row < CUBE_ROWS; row++)
        around_corners(places_on_face[row][0], places_on_face[row][1],
                       &sensors[row * CUBE_ROW]);
    for (int i = 0; i < 2; i++) {
        struct stat got[CUBE_ROWS] = {0};
        pm_job job = job_of(PM_JOB_TRACE, -1);
        job.passes = i ? 64 : 16;
        if (i)
            want_map(&job, PM_MAP_GLOBAL, 50000, 1000);
        measure_rows(&job, EVEN_SKY BOX("dark"), sensors, CUBE_ROWS, CUBE_ROW, even, got);
        for (int row = 0; row < CUBE_ROWS; row++) {
            char what[80];
            snprintf(what, sizeof what, "%s, row %d", i ? "nearest" : "progressive", row);
            expect_mean(what, &got[row], 1, 0);
        }
    }
}

/* ---- curved surfaces ---- */

enum { AROUND = 24 };

static void expect_irradiance(const char *what, const char *text, const pm_sensor *sensors,
                              double want, double slack)
{
    for (int i = 0; i < 2; i++) {
        pm_job job = job_of(PM_JOB_TRACE, -1);
        if (i)
            want_map(&job, PM_MAP_GLOBAL, 20000, 50);
        job.passes = i ? 1 : 2;
        look_at(&job, sensors, AROUND, PM_IRRADIANCE);
        struct stat got = run_mean(&job, text, SEEDS / 2, GREY);
        char name[80];
        snprintf(name, sizeof name, "%s, %s", what, i ? "nearest" : "progressive");
        expect_mean(name, &got, want, slack * want);
    }
}

/* Points on a frustum about the z axis, `share` of its way up; side 1 outside, -1 inside. */
static void around_axis(double r0, double r1, double height, double share, double side,
                        pm_sensor sensors[AROUND])
{
    double r = r0 + share * (r1 - r0), slant = hypot(r1 - r0, height);
    for (int i = 0; i < AROUND; i++) {
        double angle = 2 * PI * (i + .3) / AROUND, c = cos(angle), s = sin(angle);
        double out = side * height / slant, up = side * (r0 - r1) / slant;
        sensors[i] = (pm_sensor){{r * c, r * s, share * height}, {out * c, out * s, up}};
    }
}

static void curved_surfaces_outside_have_no_bias(void **state)
{
    (void)state;
    pm_sensor sensors[AROUND];
    for (int i = 0; i < AROUND; i++) {
        sensors[i].normal = sphere_point(i, AROUND);
        sensors[i].point = pm_vec3_scale(sensors[i].normal, .5);
    }
    expect_irradiance("sphere", EVEN_SKY "dark sphere ball 0 0 4 0 0 0 .5\n", sensors, PI,
                      .002);
    around_axis(.1, .1, 1, .5, 1, sensors);
    expect_irradiance("cylinder", EVEN_SKY "dark cylinder rod 0 0 7 0 0 0 0 0 1 .1\n", sensors,
                      PI, .002);
    around_axis(.5, .2, .6, .5, 1, sensors);
    expect_irradiance("cone", EVEN_SKY "dark cone hat 0 0 8 0 0 0 0 0 .6 .5 .2\n", sensors, PI,
                      .002);
}

/* View factor from a place on the wall of a cylinder to its end, `z` diameters away (Howell, A
 * Catalog of Radiation Configuration Factors, B-30). */
static double end_factor(double z)
{
    return (z * z + .5) / sqrt(z * z + 1) - z;
}

static void a_tube_inside_has_no_bias(void **state)
{
    (void)state;
    pm_sensor sensors[AROUND];
    around_axis(.3, .3, 1, .5, -1, sensors);
    expect_irradiance("tube", EVEN_SKY "dark tube pipe 0 0 7 0 0 0 0 0 1 .3\n", sensors,
                      2 * PI * end_factor(.5 / .6), .01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(estimate_of_a_fixed_radius_is_the_convolved_field),
        cmocka_unit_test(estimate_of_the_nearest_is_that_of_its_quadrature),
        cmocka_unit_test(nothing_comes_through_a_wall_without_thickness),
        cmocka_unit_test(the_floor_in_a_corner_is_right_but_for_the_kernel),
        cmocka_unit_test(edges_and_corners_are_right_within_one_percent),
        cmocka_unit_test(curved_surfaces_outside_have_no_bias),
        cmocka_unit_test(a_tube_inside_has_no_bias),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
