#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "../world/numbers.h"
#include "base/triangulate.h"

/* An independent area: the shoelace formula about the first corner. */
static double shoelace(const struct pm_point2 *p, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 1; i + 1 < count; i++)
        sum += (p[i].x - p[0].x) * (p[i + 1].y - p[0].y) -
               (p[i].y - p[0].y) * (p[i + 1].x - p[0].x);
    return sum / 2;
}

static double triangle_area(const struct pm_point2 *p, const struct pm_triangle *t)
{
    const struct pm_point2 q[3] = {p[t->corner[0]], p[t->corner[1]], p[t->corner[2]]};
    return shoelace(q, 3);
}

/* All triangles counter-clockwise and their areas adding up to the polygon's: together they
 * bound what the polygon bounds, so they cover it once. */
static void assert_covers(const struct pm_point2 *p, uint32_t count, double tolerance)
{
    struct pm_triangle *out = malloc(count * sizeof *out);
    uint32_t made;
    double inverted, sum = 0;
    assert_int_equal(pm_triangulate(p, count, out, &made, &inverted), PM_OK);
    assert_in_range(made, 1, count - 2);
    for (uint32_t i = 0; i < made; i++) {
        double area = triangle_area(p, &out[i]);
        assert_at_most(-area, tolerance);
        sum += area;
    }
    assert_near(sum, shoelace(p, count), tolerance);
    assert_at_most(inverted, tolerance);
    free(out);
}

#define COVERS(p, tolerance) assert_covers(p, sizeof(p) / sizeof *(p), tolerance)

static void simple_polygons_are_covered(void **state)
{
    (void)state;
    const struct pm_point2 triangle[] = {{0, 0}, {1, 0}, {0, 1}};
    const struct pm_point2 dart[] = {{0, 0}, {2, -1}, {.5, 0}, {2, 1}};
    const struct pm_point2 comb[] = {{0, 0}, {7, 0}, {7, 5}, {6, 5}, {6, 1}, {5, 1}, {5, 5},
                                     {4, 5}, {4, 1}, {3, 1}, {3, 5}, {2, 5}, {2, 1}, {0, 1}};
    COVERS(triangle, 0);
    COVERS(dart, 1e-15);
    COVERS(comb, 0);
}

static void collinear_and_repeated_corners_are_no_trouble(void **state)
{
    (void)state;
    const struct pm_point2 collinear[] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1},
                                          {3, 2}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    const struct pm_point2 repeated[] = {{0, 0}, {1, 0}, {1, 0}, {1, 1},
                                         {1, 1}, {1, 1}, {0, 1}};
    const struct pm_point2 spike[] = {{0, 0}, {2, 0}, {1, 0}, {1, 1}, {0, 1}};
    COVERS(collinear, 0);
    COVERS(repeated, 0);
    COVERS(spike, 0);
}

/* Triangles of no area close gaps beside collinear corners: every edge of the outline is the
 * edge of a triangle. */
static void every_edge_of_the_outline_is_kept(void **state)
{
    (void)state;
    const struct pm_point2 p[] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 3}, {2, 2}, {1, 1}};
    enum { COUNT = sizeof p / sizeof *p };
    struct pm_triangle out[COUNT];
    uint32_t made;
    double inverted;
    assert_int_equal(pm_triangulate(p, COUNT, out, &made, &inverted), PM_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        int found = 0;
        for (uint32_t k = 0; k < 3 * made; k++)
            found += out[k / 3].corner[k % 3] == i &&
                     out[k / 3].corner[(k + 1) % 3] == (i + 1) % COUNT;
        assert_int_equal(found, 1);
    }
}

/* Radiance's convention: the seam to the hole is walked there and back. */
static void holes_by_seam_are_left_out(void **state)
{
    (void)state;
    const struct pm_point2 one[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0},
                                    {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    const struct pm_point2 two[] = {{0, 0}, {8, 0}, {8, 4}, {7, 3}, {7, 1}, {5, 1},
                                    {5, 3}, {7, 3}, {8, 4}, {0, 4}, {1, 3}, {3, 3},
                                    {3, 1}, {1, 1}, {1, 3}, {0, 4}};
    assert_near(shoelace(one, 10), 12, 0);
    assert_near(shoelace(two, 16), 24, 0);
    COVERS(one, 0);
    COVERS(two, 0);
}

/* Corners at increasing angles about the origin: never self-intersecting, any concavity. */
static void make_star(pm_rng *rng, struct pm_point2 *p, uint32_t count, double low, int turn)
{
    for (uint32_t i = 0; i < count; i++) {
        double angle = turn * 2 * PM_PI * (i + .9 * pm_rng_uniform(rng)) / count;
        double radius = low + (1 - low) * pm_rng_uniform(rng);
        p[i] = (struct pm_point2){radius * cos(angle), radius * sin(angle)};
    }
}

static void random_stars_are_covered(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    struct pm_point2 p[200];
    for (int i = 0; i < 3000; i++) {
        uint32_t count = 5 + pm_rng_u32(&rng) % 196;
        make_star(&rng, p, count, .01, 1);
        assert_covers(p, count, 1e-14);
    }
}

/* A star with a star-shaped hole, joined by a seam that crosses neither. */
static void random_holes_are_left_out(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 2, PM_RNG_PATH, 0);
    struct pm_point2 p[130];
    for (int i = 0; i < 1000; i++) {
        uint32_t outer = 8 + pm_rng_u32(&rng) % 50, inner = 5 + pm_rng_u32(&rng) % 50;
        make_star(&rng, p, outer, .9, 1);
        p[0] = p[outer] = (struct pm_point2){.95, 0};
        make_star(&rng, p + outer + 1, inner, .1, -1);
        for (uint32_t k = 0; k < inner; k++) {
            p[outer + 1 + k].x *= .5;
            p[outer + 1 + k].y *= .5;
        }
        p[outer + 1] = (struct pm_point2){.3, 0};
        p[outer + 1 + inner] = p[outer + 1];
        assert_covers(p, outer + inner + 2, 1e-14);
    }
}

static void a_hundred_thousand_corners_are_covered(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    struct pm_point2 *p = malloc(COUNT * sizeof *p);
    pm_rng rng;
    pm_rng_init(&rng, 3, PM_RNG_PATH, 0);
    make_star(&rng, p, COUNT, .5, 1);
    assert_covers(p, COUNT, 1e-12);
    free(p);
}

/* Long thin teeth aslant: every ear's bounds hold the whole comb. */
static void combs_of_a_hundred_thousand_corners_are_covered(void **state)
{
    (void)state;
    enum { TEETH = 50000, COUNT = 2 * TEETH + 2 };
    struct pm_point2 *p = malloc(COUNT * sizeof *p);
    for (int i = 0; i < COUNT; i++) {
        double x = 1 - (double)i / COUNT, y = i % 2 ? .9 : 0;
        p[i] = (struct pm_point2){x - y, x + y};
    }
    p[COUNT - 2] = (struct pm_point2){.1, -.1};
    p[COUNT - 1] = (struct pm_point2){1.1, .9};
    assert_covers(p, COUNT, 1e-11);
    free(p);
}

/* Needles a thousand times as long as the comb is wide: corners lie in two tight clusters. */
static void needles_between_two_clusters_are_covered(void **state)
{
    (void)state;
    enum { COUNT = 99999 };
    struct pm_point2 *p = malloc(COUNT * sizeof *p);
    p[0] = (struct pm_point2){0, -1};
    p[1] = (struct pm_point2){1, -1};
    for (int i = 0; i < COUNT - 2; i++) {
        double x = 1 - (double)i / (COUNT - 3), up = i % 2 ? 1000 : 0;
        p[i + 2] = (struct pm_point2){x + up, up};
    }
    assert_covers(p, COUNT, 1e-7);
    free(p);
}

/* Thirty thousand square holes in rows, a row on one seam. */
static void a_sieve_is_covered(void **state)
{
    (void)state;
    enum { SIDE = 170, COUNT = 4 + SIDE * (8 * SIDE + 2) };
    struct pm_point2 *p = malloc(COUNT * sizeof *p);
    const double c = 1. / SIDE;
    int n = 0;
    p[n++] = (struct pm_point2){0, 0};
    p[n++] = (struct pm_point2){1, 0};
    p[n++] = (struct pm_point2){1, 1};
    p[n++] = (struct pm_point2){0, 1};
    for (int row = SIDE - 1; row >= 0; row--) {
        double y = (row + .5) * c;
        p[n++] = (struct pm_point2){0, y};
        for (int j = 0; j < SIDE; j++) { /* there, over the holes */
            p[n++] = (struct pm_point2){(j + .25) * c, y};
            p[n++] = (struct pm_point2){(j + .25) * c, y + .25 * c};
            p[n++] = (struct pm_point2){(j + .75) * c, y + .25 * c};
            p[n++] = (struct pm_point2){(j + .75) * c, y};
        }
        for (int j = SIDE - 1; j >= 0; j--) { /* and back, below them */
            p[n++] = (struct pm_point2){(j + .75) * c, y};
            p[n++] = (struct pm_point2){(j + .75) * c, y - .25 * c};
            p[n++] = (struct pm_point2){(j + .25) * c, y - .25 * c};
            p[n++] = (struct pm_point2){(j + .25) * c, y};
        }
        p[n++] = (struct pm_point2){0, y};
    }
    assert_int_equal(n, COUNT);
    assert_near(shoelace(p, COUNT), .75, 1e-10);
    assert_covers(p, COUNT, 1e-10);
    free(p);
}

static void crossing_edges_are_reported(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    const struct pm_point2 bow[] = {{0, 0}, {2, 2}, {2, 0}, {0, 1}};
    struct pm_point2 *wild = malloc(COUNT * sizeof *wild);
    struct pm_triangle *out = malloc(COUNT * sizeof *out);
    uint32_t made;
    double inverted;
    assert_int_equal(pm_triangulate(bow, 4, out, &made, &inverted), PM_OK);
    assert_true(inverted > .1);
    pm_rng rng;
    pm_rng_init(&rng, 4, PM_RNG_PATH, 0);
    for (int i = 0; i < COUNT; i++) {
        wild[i].x = pm_rng_uniform(&rng);
        wild[i].y = pm_rng_uniform(&rng);
    }
    assert_int_equal(pm_triangulate(wild, COUNT, out, &made, &inverted), PM_OK);
    assert_true(inverted > .1);
    free(wild);
    free(out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(simple_polygons_are_covered),
        cmocka_unit_test(collinear_and_repeated_corners_are_no_trouble),
        cmocka_unit_test(every_edge_of_the_outline_is_kept),
        cmocka_unit_test(holes_by_seam_are_left_out),
        cmocka_unit_test(random_stars_are_covered),
        cmocka_unit_test(random_holes_are_left_out),
        cmocka_unit_test(a_hundred_thousand_corners_are_covered),
        cmocka_unit_test(combs_of_a_hundred_thousand_corners_are_covered),
        cmocka_unit_test(needles_between_two_clusters_are_covered),
        cmocka_unit_test(a_sieve_is_covered),
        cmocka_unit_test(crossing_edges_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
