#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "compile.h"
#include "numbers.h"
#include "world/shape.h"

static const struct pm_shape_frame plain = {.scale = 1, .tolerance = 0x1p-46};

/* The first surface of a scene, in its own units. */
static struct pm_shape shape_of(const char *surface, pm_arena *arena)
{
    char text[1024];
    snprintf(text, sizeof text, "void plastic grey 0 0 5 .5 .5 .5 0 0\ngrey %s\n", surface);
    pm_scene *scene = scene_of(text);
    struct pm_shape shape;
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_shape_make(scene, &scene->primitives[1], &plain, arena, &shape, &err);
    pm_scene_free(scene);
    if (st)
        fail_msg("%s", err.text);
    return shape;
}

static void areas_are_those_of_elementary_geometry(void **state)
{
    (void)state;
    const struct {
        const char *surface;
        double area;
    } cases[] = {
        {"polygon s 0 0 9 0 0 0 3 0 0 0 4 0", 6},
        {"polygon s 0 0 30 0 0 0 4 0 0 4 4 0 0 4 0 0 0 0 1 1 0 1 3 0 3 3 0 3 1 0 1 1 0", 12},
        {"polygon s 0 0 12 1 1 1 1 3 1 1 3 4 1 1 4", 6},
        {"sphere s 0 0 4 1 2 3 2", 16 * PM_PI},
        {"ring s 0 0 8 1 2 3 0 0 1 1 3", 8 * PM_PI},
        {"cylinder s 0 0 7 0 0 0 0 0 5 2", 20 * PM_PI},
        {"cone s 0 0 8 0 0 0 0 0 4 3 0", 15 * PM_PI},
        {"cup s 0 0 8 0 0 0 0 0 4 4 1", 25 * PM_PI},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pm_arena arena = {0};
        struct pm_shape s = shape_of(cases[i].surface, &arena);
        assert_near(pm_shape_area(&s), cases[i].area, 1e-14 * cases[i].area);
        pm_arena_clear(&arena);
    }
}

/* Mean of a function over samples against its known mean over the surface, within 5 sigma. */
static void assert_sample_mean(const char *surface, double (*value)(pm_vec3), double mean,
                               double variance)
{
    enum { COUNT = 100000 };
    pm_arena arena = {0};
    struct pm_shape s = shape_of(surface, &arena);
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    double sum = 0;
    for (int i = 0; i < COUNT; i++) {
        double u[2];
        pm_vec3 p, n;
        draw(&rng, u, 2);
        pm_shape_sample(&s, u[0], u[1], &p, &n);
        assert_near(pm_vec3_length(n), 1, 1e-15);
        assert_at_most(pm_vec3_distance(p, pm_shape_project(&s, p)), 4e-15);
        assert_at_most(pm_vec3_distance(n, pm_shape_normal(&s, p)), 1e-15);
        sum += value(p);
    }
    assert_near(sum / COUNT, mean, 5 * sqrt(variance / COUNT));
    pm_arena_clear(&arena);
}

static double height(pm_vec3 p)
{
    return p.z;
}

static double radius_squared(pm_vec3 p)
{
    return p.x * p.x + p.y * p.y;
}

static double is_left_below(pm_vec3 p)
{
    return p.x < 1 && p.y < 1;
}

static double is_ahead(pm_vec3 p)
{
    return p.x > 0 && p.y > 0;
}

static void shape_samples_are_uniform_by_area(void **state)
{
    (void)state;
    /* an L of three unit squares: a third of it lies left below */
    assert_sample_mean("polygon s 0 0 18 0 0 0 2 0 0 2 1 0 1 1 0 1 2 0 0 2 0", is_left_below,
                       1. / 3, 2. / 9);
    /* z uniform in [-2, 2] (Archimedes): variance 4/3 */
    assert_sample_mean("sphere s 0 0 4 0 0 0 2", height, 0, 4. / 3);
    assert_sample_mean("bubble s 0 0 4 0 0 0 2", is_ahead, .25, 3. / 16);
    /* r^2 uniform in [1, 9] */
    assert_sample_mean("ring s 0 0 8 0 0 0 0 0 1 1 3", radius_squared, 5, 64. / 12);
    assert_sample_mean("cylinder s 0 0 7 0 0 0 0 0 6 1", height, 3, 3);
    /* r^2 uniform in [1, 16] on a cone too; height 4 - r: E = 4 - (2/3)(64 - 1)/15 */
    assert_sample_mean("cone s 0 0 8 0 0 0 0 0 3 4 1", radius_squared, 8.5, 225. / 12);
    assert_sample_mean("cup s 0 0 8 0 0 0 0 0 3 4 1", height, 1.2, 1);
    assert_sample_mean("tube s 0 0 7 0 0 0 0 0 6 1", is_ahead, .25, 3. / 16);
}

/* A point off the surface of a quadric by less than rounding: the implicit function in long
 * double, divided by its gradient. */
static double distance_from(const struct pm_shape *s, pm_vec3 p)
{
    long double x = (long double)p.x - s->center.x, y = (long double)p.y - s->center.y;
    long double z = (long double)p.z - s->center.z;
    if (pm_shape_is_ball(s))
        return (double)(sqrtl(x * x + y * y + z * z) - s->r0);
    long double i = s->axis.x, j = s->axis.y, k = s->axis.z;
    long double a = (x * i + y * j + z * k) / (i * i + j * j + k * k);
    x -= a * i;
    y -= a * j;
    z -= a * k;
    long double slope = ((long double)s->r1 - s->r0) / s->height;
    return (double)((sqrtl(x * x + y * y + z * z) - s->r0 - slope * a) /
                    sqrtl(1 + slope * slope));
}

/* Near its apex, at radius r, a cone's gradient is 2 r: the rounding of a quadratic of size 1,
 * a few 1e-16, moves the root by that over r. */
static double near_apex(const struct pm_shape *s, pm_vec3 p)
{
    pm_vec3 v = pm_vec3_sub(p, s->center);
    double along = pm_vec3_dot(v, s->axis);
    if (pm_shape_is_ball(s) || s->r0 == s->r1)
        return 0;
    return 1e-15 / pm_vec3_length(pm_vec3_madd(v, -along, s->axis));
}

static const char *const quadrics[] = {
    "sphere s 0 0 4 .3 -.2 .1 .5",
    "sphere s 0 0 4 .3 -.2 .1 1e-6",
    "cone s 0 0 8 -.5 -.4 -.3 .6 .5 .4 .3 .1",
    "cone s 0 0 8 -.5 -.4 -.3 .6 .5 .4 .3 0",
    "cone s 0 0 8 0 0 0 0 0 .3 .9 .1",
    "cylinder s 0 0 7 -.5 -.4 -.3 .6 .5 .4 .2",
    "cylinder s 0 0 7 -.9 -.8 -.7 .9 .8 .7 1e-6",
};

/* Every root lies on the surface between the ends, and a line through two points of it has them
 * both (if it does not graze). The bound is rounding of a point at distance 2, divided by the
 * cosine. */
static void quadrics_are_met_where_analysis_says(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    for (size_t k = 0; k < sizeof quadrics / sizeof *quadrics; k++) {
        struct pm_shape s = shape_of(quadrics[k], NULL);
        int twice = 0;
        for (int i = 0; i < 20000; i++) {
            double u[5], t[2];
            pm_vec3 p, q, n, m;
            draw(&rng, u, 5);
            pm_shape_sample(&s, u[0], u[1], &p, &n);
            /* every other chord at right angles to the axis: long thin shapes have no others */
            pm_shape_sample(&s, u[i % 2 ? 0 : 2], u[3], &q, &m);
            pm_vec3 d = pm_vec3_normalize(pm_vec3_sub(q, p));
            double cosine = fmin(fabs(pm_vec3_dot(d, n)), fabs(pm_vec3_dot(d, m)));
            if (cosine < .01 || pm_vec3_length(d) < .5)
                continue;
            double back = 2 * u[4], length = pm_vec3_distance(p, q);
            int count = pm_shape_roots(&s, pm_vec3_madd(p, -back, d), d, false, t);
            /* the ends themselves are lost or kept by rounding */
            assert_in_range(count, 1, 2);
            for (int r = 0; r < count; r++) {
                pm_vec3 hit = pm_vec3_madd(p, t[r] - back, d);
                assert_near(distance_from(&s, hit), 0, 4e-15 + near_apex(&s, hit));
            }
            twice += count == 2;
            if (count == 2) {
                assert_near(t[0], back, 2e-15 / cosine);
                assert_near(t[1], back + length, 4e-15 / cosine);
            }
            count = pm_shape_roots(&s, p, d, true, t);
            assert_int_equal(count, 2);
            assert_true(t[0] == 0);
            assert_near(t[1], length, 4e-15 / cosine);
        }
        assert_in_range(twice, 1000, 20000);
    }
}

/* The far root from the surface itself keeps its digits where the chord is short: 2 r cos. */
static void short_chords_are_not_cancelled_away(void **state)
{
    (void)state;
    struct pm_shape s = shape_of("sphere s 0 0 4 0 0 0 1", NULL);
    struct pm_shape c = shape_of("cylinder s 0 0 7 0 0 -9 0 0 9 1", NULL);
    for (int i = 1; i < 14; i++) {
        double cosine = pow(10, -i), t[2];
        pm_vec3 d = {-cosine, sqrt((1 - cosine) * (1 + cosine)), 0}, p = {1, 0, 0};
        assert_int_equal(pm_shape_roots(&s, p, d, true, t), 2);
        assert_near(t[1], 2 * cosine, 1e-15 * cosine);
        assert_int_equal(pm_shape_roots(&c, p, d, true, t), 2);
        assert_near(t[1], 2 * cosine, 1e-15 * cosine);
    }
}

/* Whatever holds a point of the surface meets it, and far cubes do not. */
static void cubes_that_hold_a_point_of_the_surface_meet_it(void **state)
{
    (void)state;
    const char *const surfaces[] = {
        "sphere s 0 0 4 .3 -.2 .1 .5",
        "cone s 0 0 8 -.5 -.4 -.3 .6 .5 .4 .3 .1",
        "cylinder s 0 0 7 -.5 -.4 -.3 .6 .5 .4 .2",
        "ring s 0 0 8 .1 .2 .3 .4 .5 .6 .2 .6",
        "polygon s 0 0 9 -.9 .2 .3 .4 .7 .1 .2 -.6 -.8",
        "polygon s 0 0 12 -.5 -.5 0 .5 -.5 .1 .5 .5 0 -.5 .5 .1",
    };
    pm_rng rng;
    pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
    for (size_t k = 0; k < sizeof surfaces / sizeof *surfaces; k++) {
        pm_arena arena = {0};
        struct pm_shape s = shape_of(surfaces[k], &arena);
        int far = 0;
        for (int i = 0; i < 20000; i++) {
            double u[6];
            pm_vec3 p, n;
            draw(&rng, u, 6);
            pm_shape_sample(&s, u[0], u[1], &p, &n);
            double half = pow(2, -12 * u[2]);
            pm_vec3 shift = {2 * u[3] - 1, 2 * u[4] - 1, 2 * u[5] - 1};
            assert_true(pm_shape_meets_cube(&s, pm_vec3_madd(p, half * .999999, shift), half));
            far += !pm_shape_meets_cube(&s, shift, .05);
        }
        /* a cube of .1 within [-1, 1]^3 seldom meets a surface of area below 4 */
        assert_in_range(far, 15000, 20000);
        pm_arena_clear(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_are_those_of_elementary_geometry),
        cmocka_unit_test(shape_samples_are_uniform_by_area),
        cmocka_unit_test(quadrics_are_met_where_analysis_says),
        cmocka_unit_test(short_chords_are_not_cancelled_away),
        cmocka_unit_test(cubes_that_hold_a_point_of_the_surface_meet_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
