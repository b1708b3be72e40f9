#include "generate_test.h"

/* Twelve digits are written. */
static const double rounding = 1e-10;

static void a_box_has_its_corners_at_0_and_its_sizes(void **state)
{
    (void)state;
    struct scene box = make("genbox m b 1 2 3.5");
    assert_int_equal(box.count, 6);
    const struct made *floor = named(&box, "b.2310"), *roof = named(&box, "b.5137");
    assert_string_equal(floor->modifier, "m");
    static const double floor_reals[] = {0, 2, 0, 1, 2, 0, 1, 0, 0, 0, 0, 0};
    static const double wall_reals[] = {1, 0, 3.5, 1, 0, 0, 1, 2, 0, 1, 2, 3.5};
    for (int i = 0; i < 12; i++) {
        assert_near(floor->reals[i], floor_reals[i], 0);
        assert_near(roof->reals[i], wall_reals[i], 0);
    }
    free_scene(&box);
}

static void a_box_faces_outward_and_an_inverted_one_inward(void **state)
{
    (void)state;
    struct scene box = make("genbox m b 1 2 3.5"), inverted = make("genbox m b 1 2 3.5 -i");
    assert_near(enclosed_volume(&box), 7, rounding);
    assert_near(enclosed_volume(&inverted), -7, rounding);
    assert_near(total_area(&box), 2 * (2 + 7 + 3.5), rounding);
    free_scene(&box);
    free_scene(&inverted);
}

/* Of a beveled box remain its core, six slabs, half of each edge's bar and a sixth of each
 * corner's cube. */
static void a_beveled_box_is_closed(void **state)
{
    (void)state;
    struct scene box = make("genbox m b 1 2 3 -b .1");
    double b = .1, x = .8, y = 1.8, z = 2.8;
    double volume = x * y * z + 2 * b * (x * y + y * z + z * x) + 4 * b * b / 2 * (x + y + z) +
                    8 * b * b * b / 6;
    assert_int_equal(box.count, 6 + 12 + 8);
    assert_near(enclosed_volume(&box), volume, rounding);
    free_scene(&box);
}

static void a_rounded_box_has_cylinders_and_spheres_of_its_radius(void **state)
{
    (void)state;
    struct scene box = make("genbox m b 1 2 3 -r .1");
    assert_int_equal(box.count, 26);
    assert_int_equal(count_type(&box, "cylinder"), 12);
    assert_int_equal(count_type(&box, "sphere"), 8);
    for (size_t i = 0; i < box.count; i++) {
        const struct made *p = &box.items[i];
        if (strcmp(p->type, "polygon") == 0)
            continue;
        assert_near(p->reals[p->real_count - 1], .1, 0);
        static const double sizes[] = {1, 2, 3};
        for (size_t k = 0; k + 1 < p->real_count; k++) /* centres: inset by the radius */
            if (fabs(p->reals[k] - .1) > rounding)
                assert_near(p->reals[k], sizes[k % 3] - .1, rounding);
    }
    free_scene(&box);
}

/* The point of the core, the box without its rounding, that is nearest. */
static double from_core(const double p[3], double out[3])
{
    static const double sizes[] = {1, 2, 3};
    for (int i = 0; i < 3; i++) {
        double least = .1, most = sizes[i] - .1;
        out[i] = p[i] - (p[i] < least ? least : p[i] > most ? most : p[i]);
    }
    return length(out);
}

static void segments_lie_on_the_rounded_box(void **state)
{
    (void)state;
    struct scene box = make("genbox m b 1 2 3 -r .1 -n 16");
    double offset[3];
    for (size_t i = 0; i < box.count; i++)
        for (size_t k = 0; k < box.items[i].real_count; k += 3)
            assert_near(from_core(box.items[i].reals + k, offset), .1, rounding);
    /* 16 segments a quarter: polygons in an arc lack less than 1 - sin(a) / a of what a
     * rounded edge adds, a = pi / 32. */
    double r = .1, x = .8, y = 1.8, z = 2.8;
    double flat = x * y * z + 2 * r * (x * y + y * z + z * x);
    double round = PM_PI * r * r * (x + y + z) + 4 * PM_PI / 3 * r * r * r;
    double lack = 2 * (1 - sin(PM_PI / 32) / (PM_PI / 32));
    double volume = enclosed_volume(&box);
    assert_true(volume < flat + round && volume > flat + round * (1 - lack));
    free_scene(&box);
}

/* The texture of a triangle is three planes over two axes: here evaluated at its corners. */
static void assert_normals(const struct made *texture, const struct made *polygon)
{
    int axis = (int)texture->reals[0];
    for (size_t k = 0; k < 9; k += 3) {
        const double *p = polygon->reals + k;
        double want[3], u = p[(axis + 1) % 3], v = p[(axis + 2) % 3];
        double radius = from_core(p, want);
        for (int i = 0; i < 3; i++) {
            const double *plane = texture->reals + 1 + 3 * i;
            /* Eight decimals of each coefficient, of coordinates below 3. */
            assert_near(plane[0] * u + plane[1] * v + plane[2], want[i] / radius, 1e-6);
        }
    }
}

static void smooth_segments_have_the_normals_of_the_rounding(void **state)
{
    (void)state;
    struct scene box = make("genbox m b 1 2 3 -r .1 -n 4 -s");
    size_t textures = 0;
    for (size_t i = 0; i < box.count; i++) {
        if (strcmp(box.items[i].type, "texfunc") != 0)
            continue;
        textures++;
        assert_string_equal(box.items[i + 1].modifier, "T-nor");
        assert_normals(&box.items[i], &box.items[i + 1]);
    }
    /* Two for each of 12 x 4 strips, one for each of 8 x 16 triangles. */
    assert_int_equal(textures, 96 + 128);
    assert_int_equal(box.count, 2 * textures + 6);
    free_scene(&box);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    assert_refused("genbox m b 1 2", PM_E_SYNTAX, 4,
                   "genbox: zsize is missing; it should come after '2'");
    assert_refused("genbox m b 1 2 -3", PM_E_RANGE, 5,
                   "genbox: zsize is -3; a box's sizes are above 0");
    assert_refused("genbox m b 1 2 3 -r .1 -n 0", PM_E_RANGE, 9,
                   "genbox: '0' should be -n's segments, a whole number from 1 to 2147483647");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_has_its_corners_at_0_and_its_sizes),
        cmocka_unit_test(a_box_faces_outward_and_an_inverted_one_inward),
        cmocka_unit_test(a_beveled_box_is_closed),
        cmocka_unit_test(a_rounded_box_has_cylinders_and_spheres_of_its_radius),
        cmocka_unit_test(segments_lie_on_the_rounded_box),
        cmocka_unit_test(smooth_segments_have_the_normals_of_the_rounding),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
