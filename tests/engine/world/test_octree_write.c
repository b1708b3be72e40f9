#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "files/octree_file.h"
#include "numbers.h"
#include "world/octree_write.h"
#include "world/shape.h"

/* ---- scenes ---- */

static pm_bundle *bundle_of(const char *text)
{
    pm_bundle *bundle = pm_bundle_new();
    assert_non_null(bundle);
    assert_int_equal(pm_bundle_add(bundle, "a.rad", text, strlen(text), NULL), PM_OK);
    return bundle;
}

static pm_scene *scene_of(const pm_bundle *bundle, const char *name)
{
    char text[1200];
    pm_error err = PM_ERROR_INIT;
    pm_scene *scene = NULL;
    if (pm_scene_parse(bundle, name, NULL, &scene, &err)) {
        pm_error_format(&err, text, sizeof text);
        fail_msg("%s", text);
    }
    return scene;
}

static const char *const own_name[] = {"a.rad"};

static pm_octree_options options_of(bool frozen)
{
    return (pm_octree_options){
        .frozen = frozen, .files = own_name, .file_count = 1, .command = "oconv a.rad"};
}

static pm_status write(const char *text, const pm_octree_options *options, pm_bytes *out,
                       pm_error *err)
{
    pm_bundle *bundle = bundle_of(text);
    pm_scene *scene = scene_of(bundle, "a.rad");
    pm_status st = pm_octree_write(scene, bundle, options, out, err);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return st;
}

static pm_bytes written(const char *text, const pm_octree_options *options)
{
    char message[1200];
    pm_bytes bytes = {0};
    pm_error err = PM_ERROR_INIT;
    if (write(text, options, &bytes, &err)) {
        pm_error_format(&err, message, sizeof message);
        fail_msg("%s", message);
    }
    return bytes;
}

/* ---- reading the tree, apart from the engine's reader ---- */

struct leaf {
    double low[3], size;
    size_t count;
    uint32_t objects[600];
};

typedef void visitor(void *context, const struct leaf *leaf);

static uint32_t number(const uint8_t **at)
{
    const uint8_t *b = *at;
    *at += 4;
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

static void walk(const uint8_t **at, const double low[3], double size, visitor *visit,
                 void *context)
{
    struct leaf leaf = {.low = {low[0], low[1], low[2]}, .size = size};
    uint8_t kind = *(*at)++;
    if (kind == 2) {
        for (int i = 0; i < 8; i++) {
            double corner[3];
            for (int k = 0; k < 3; k++)
                corner[k] = low[k] + (i >> k & 1 ? size / 2 : 0);
            walk(at, corner, size / 2, visit, context);
        }
        return;
    }
    assert_true(kind < 2);
    if (kind == 1) {
        leaf.count = number(at);
        assert_in_range(leaf.count, 1, 511);
        for (size_t i = 0; i < leaf.count; i++) {
            leaf.objects[i] = number(at);
            assert_true(i == 0 || leaf.objects[i] > leaf.objects[i - 1]);
        }
    }
    visit(context, &leaf);
}

/* The bytes behind the header, the cube, the files and the number of objects. */
static const uint8_t *find_tree(const pm_bytes *bytes, double low[3], double *size)
{
    const char *at = strstr((const char *)bytes->data, "\n\n") + 4;
    for (int i = 0; i < 4; i++) {
        *(i < 3 ? &low[i] : size) = strtod(at, NULL);
        at += strlen(at) + 1;
    }
    while (*at)
        at += strlen(at) + 1;
    return (const uint8_t *)at + 1 + 4;
}

static void walk_file(const pm_bytes *bytes, visitor *visit, void *context)
{
    double low[3], size;
    const uint8_t *at = find_tree(bytes, low, &size);
    walk(&at, low, size, visit, context);
    assert_true(at <= bytes->data + bytes->size);
}

/* ---- tests ---- */

/* One sphere: its bounds and Radiance's margin of 1e-5 make the cube, one set the tree. */
static void the_bytes_are_these(void **state)
{
    (void)state;
    static const char expected[] = "#?RADIANCE\noconv a.rad\nFORMAT=Radiance_octree\n\n\x01\x1f"
                                   "-1.00001\0-1.00001\0-1.00001\0002.00002\0a.rad\0\0"
                                   "\0\0\0\3\1\0\0\0\1\0\0\0\2";
    const pm_octree_options options = options_of(false);
    pm_bytes bytes = written("void plastic m 0 0 5 1 1 1 0 0\nvoid alias n m\n"
                             "n sphere s 0 0 4 0 0 0 1\n",
                             &options);
    assert_int_equal(bytes.size, sizeof expected - 1);
    assert_memory_equal(bytes.data, expected, bytes.size);
    pm_bytes_clear(&bytes);
}

static const char shapes[] =
    "void plastic m 0 0 5 .5 .5 .5 0 0\nvoid alias n m\nvoid light l 0 0 3 1 1 1\n"
    "l source sun 0 0 4 0 0 1 1\n"
    "m polygon p 0 0 12 0 0 0 4 0 0 4 4 0 0 4 0\n"
    "m polygon star 0 0 18 1 1 2 2 1.5 2.1 3 1 2.2 2.5 2 2.15 3 3 2.2 1 3 2\n"
    "n sphere s 0 0 4 1 1 1 .7\nm bubble b 0 0 4 3 1 .5 .3\n"
    "m cone c 0 0 8 3 3 0 2.5 3 1.5 .6 .1\nm cup u 0 0 8 1 3 1 .5 3 2 .2 .5\n"
    "m cylinder y 0 0 7 .2 3 0 1 2 3 .15\nm tube t 0 0 7 3 .3 .3 3.7 .5 .4 .1\n"
    "m ring r 0 0 8 2 2 2.9 .3 .2 -1 .2 .7\n";

struct search {
    double point[3];
    uint32_t object;
    bool found;
};

static void look(void *context, const struct leaf *leaf)
{
    struct search *s = context;
    for (int k = 0; k < 3; k++)
        if (s->point[k] < leaf->low[k] || s->point[k] > leaf->low[k] + leaf->size)
            return;
    for (size_t i = 0; i < leaf->count; i++)
        s->found = s->found || leaf->objects[i] == s->object;
}

/* Points spread over each surface lie in a leaf that lists it. */
static void assert_holds_surfaces(const pm_bytes *bytes, const pm_scene *scene, bool frozen)
{
    const struct pm_shape_frame frame = {.scale = 1};
    for (size_t i = 0; i < scene->main_count; i++) {
        const pm_primitive *p = &scene->primitives[i];
        struct pm_shape shape;
        pm_arena arena = {0};
        if (!pm_primitive_is_surface(p->type) || p->type == PM_SOURCE)
            continue;
        assert_int_equal(pm_shape_make(scene, p, &frame, &arena, &shape, NULL), PM_OK);
        for (int n = 0; n < 200; n++) {
            pm_vec3 at, normal;
            struct search s = {.object = (uint32_t)(i + (frozen || i < 1 ? 0 : 1))};
            pm_shape_sample(&shape, (n + .5) / 200, fmod(n * .6180339887498949, 1), &at,
                            &normal);
            s.point[0] = at.x;
            s.point[1] = at.y;
            s.point[2] = at.z;
            walk_file(bytes, look, &s);
            if (!s.found)
                fail_msg("%s is not where its point %g %g %g is", p->name, at.x, at.y, at.z);
        }
        pm_arena_clear(&arena);
    }
}

static void every_surface_is_found_where_it_is(void **state)
{
    (void)state;
    pm_bundle *bundle = bundle_of(shapes);
    pm_scene *scene = scene_of(bundle, "a.rad");
    for (int frozen = 0; frozen < 2; frozen++) {
        pm_octree_options options = options_of(frozen);
        options.set_size = 1;
        options.resolution = 256;
        pm_bytes bytes = written(shapes, &options);
        assert_holds_surfaces(&bytes, scene, frozen);
        pm_bytes_clear(&bytes);
    }
    pm_scene_free(scene);
    pm_bundle_free(bundle);
}

struct sizes {
    double whole, smallest;
    size_t most_in_large; /* objects of a leaf that could be divided */
    size_t leaves;
};

static void measure(void *context, const struct leaf *leaf)
{
    struct sizes *s = context;
    s->leaves++;
    s->smallest = fmin(s->smallest, leaf->size);
    if (leaf->size > s->whole / 64 * 1.5 && leaf->count > s->most_in_large)
        s->most_in_large = leaf->count;
}

static void sets_and_cubes_are_as_small_as_asked(void **state)
{
    (void)state;
    for (uint32_t set_size = 1; set_size <= 4; set_size++) {
        pm_octree_options options = options_of(false);
        options.set_size = set_size;
        options.resolution = 64;
        pm_bytes bytes = written(shapes, &options);
        struct sizes sizes = {.smallest = INFINITY};
        double low[3];
        find_tree(&bytes, low, &sizes.whole);
        walk_file(&bytes, measure, &sizes);
        assert_in_range(sizes.most_in_large, 1, set_size);
        assert_true(sizes.smallest >= sizes.whole / 64 * .99);
        pm_bytes_clear(&bytes);
    }
}

/* Within rounding to 31 bits, frozen and read again the scene is the same. */
static void a_frozen_scene_comes_back(void **state)
{
    (void)state;
    const pm_octree_options options = options_of(true);
    pm_bytes bytes = written(shapes, &options);
    pm_bundle *bundle = bundle_of(shapes);
    assert_int_equal(pm_bundle_add(bundle, "a.oct", bytes.data, bytes.size, NULL), PM_OK);
    pm_scene *a = scene_of(bundle, "a.rad"), *b = scene_of(bundle, "a.oct");
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; i++) {
        const pm_primitive *p = &a->primitives[i], *q = &b->primitives[i];
        assert_true(p->type == q->type && p->modifier == q->modifier);
        assert_string_equal(p->name, q->name);
        assert_int_equal(p->real_count, q->real_count);
        for (uint32_t k = 0; k < p->real_count; k++)
            assert_near(q->reals[k], p->reals[k], ldexp(fabs(p->reals[k]), -30));
    }
    pm_scene_free(a);
    pm_scene_free(b);
    pm_bundle_free(bundle);
    pm_bytes_clear(&bytes);
}

static void an_octree_without_surfaces_is_empty(void **state)
{
    (void)state;
    static const char text[] = "void light l 0 0 3 1 1 1\nl source sun 0 0 4 0 0 1 1\n";
    static const char end[] = "0\0000\0000\0000\0a.rad\0\0\0\0\0\2";
    const pm_octree_options options = options_of(false);
    pm_bytes bytes = written(text, &options);
    assert_memory_equal(bytes.data + bytes.size - sizeof end, end, sizeof end);
    pm_bytes_clear(&bytes);
}

static void bounds_are_kept_or_refused(void **state)
{
    (void)state;
    static const char text[] = "void plastic m 0 0 5 1 1 1 0 0\nm sphere s 0 0 4 0 0 0 1\n";
    pm_octree_options options = options_of(false);
    pm_error err = PM_ERROR_INIT;
    pm_bytes bytes = {0};
    double low[3], size;
    options.bounded = true;
    options.edge = 4;
    options.corner[0] = options.corner[1] = options.corner[2] = -2;
    bytes = written(text, &options);
    find_tree(&bytes, low, &size);
    assert_true(low[1] == -2.00001 && size == 4.00002);
    pm_bytes_clear(&bytes);
    options.corner[2] = 0;
    assert_int_equal(write(text, &options, &bytes, &err), PM_E_RANGE);
    assert_string_equal(err.text, "-b: the cube does not hold the scene, which goes from -1 -1 "
                                  "-1 to 1 1 1");
    pm_bytes_clear(&bytes);
}

static char *copies(int count)
{
    char *text = malloc((size_t)count * 80 + 100), *at = text;
    assert_non_null(text);
    at += sprintf(at, "void plastic m 0 0 5 1 1 1 0 0\n");
    for (int i = 0; i < count; i++)
        at += sprintf(at, "m polygon p%d 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n", i);
    return text;
}

/* Surfaces in one place cannot be told apart by dividing: it ends, and soon. */
static void surfaces_in_one_place_end_the_division(void **state)
{
    (void)state;
    const pm_octree_options options = options_of(false);
    char *few = copies(100), *many = copies(600);
    pm_bytes bytes = written(few, &options);
    assert_in_range(bytes.size, 1000, (100 * 1024 + (1 << 21)) * 5);
    pm_bytes_clear(&bytes);
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(write(many, &options, &bytes, &err), PM_E_LIMIT);
    assert_non_null(strstr(err.text, "600 surfaces meet in a cube of "));
    pm_bytes_clear(&bytes);
    free(few);
    free(many);
}

/* ---- instances ---- */

static const char sphere[] = "void plastic m 0 0 5 1 1 1 0 0\nm sphere s 0 0 4 0 0 0 1\n";

/* A scene with instances of `sphere`, frozen. */
static pm_bundle *forest(const char *text, pm_scene **scene)
{
    const pm_octree_options options = options_of(true);
    pm_bytes bytes = written(sphere, &options);
    pm_bundle *bundle = bundle_of(text);
    assert_int_equal(pm_bundle_add(bundle, "s.oct", bytes.data, bytes.size, NULL), PM_OK);
    pm_bytes_clear(&bytes);
    *scene = scene_of(bundle, "a.rad");
    return bundle;
}

static void instances_lie_in_the_boxes_of_their_octrees(void **state)
{
    (void)state;
    pm_scene *scene;
    pm_bundle *bundle = forest("void instance i 7 s.oct -rz 45 -t 5 0 0 0 0\n"
                               "void instance k 5 s.oct -t 5 0 0 0 0\n",
                               &scene);
    pm_octree_options options = options_of(false);
    pm_bytes bytes = {0};
    options.set_size = 1;
    options.resolution = 64;
    assert_int_equal(pm_octree_write(scene, bundle, &options, &bytes, NULL), PM_OK);
    double low[3], size, half = sqrt(2) * 1.00001;
    find_tree(&bytes, low, &size);
    assert_near(size, 2 * half + 2e-5, 1e-6);
    const struct {
        double at[3];
        bool in;
    } cases[] = {{{5, half - 1e-4, .9}, true},
                 {{5 + half - .05, 0, 0}, true},
                 {{5.98, .98, 0}, false}, /* beside the turned box, in the other */
                 {{4.02, .98, -.9}, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct search s = {.object = 0};
        memcpy(s.point, cases[i].at, sizeof s.point);
        walk_file(&bytes, look, &s);
        assert_int_equal(s.found, cases[i].in);
    }
    pm_bytes_clear(&bytes);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
}

/* Cubes inside all of them are not divided for them (O_IN of Radiance's oconv.c). */
static void instances_in_one_place_are_not_divided(void **state)
{
    (void)state;
    char text[4000], *at = text;
    pm_scene *scene;
    for (int i = 0; i < 40; i++)
        at += sprintf(at, "void instance i%d 1 s.oct 0 0\n", i);
    pm_bundle *bundle = forest(text, &scene);
    const pm_octree_options options = options_of(false);
    pm_bytes bytes = {0};
    struct sizes sizes = {.smallest = INFINITY};
    assert_int_equal(pm_octree_write(scene, bundle, &options, &bytes, NULL), PM_OK);
    walk_file(&bytes, measure, &sizes);
    assert_in_range(sizes.leaves, 1, 200000);
    pm_bytes_clear(&bytes);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_bytes_are_these),
        cmocka_unit_test(every_surface_is_found_where_it_is),
        cmocka_unit_test(sets_and_cubes_are_as_small_as_asked),
        cmocka_unit_test(a_frozen_scene_comes_back),
        cmocka_unit_test(an_octree_without_surfaces_is_empty),
        cmocka_unit_test(bounds_are_kept_or_refused),
        cmocka_unit_test(surfaces_in_one_place_end_the_division),
        cmocka_unit_test(instances_lie_in_the_boxes_of_their_octrees),
        cmocka_unit_test(instances_in_one_place_are_not_divided),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
