#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/corner_tree.h"
#include "base/rng.h"

enum { COUNT = 3000 };

struct seen {
    uint32_t times[COUNT];
};

static bool see(const void *context, uint32_t point)
{
    struct seen *seen = (struct seen *)context;
    seen->times[point]++;
    return false;
}

static bool is_inside(const struct pm_point2 *t, struct pm_point2 p)
{
    for (int i = 0; i < 3; i++) {
        struct pm_point2 a = t[i], b = t[(i + 1) % 3];
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) < 0)
            return false;
    }
    return true;
}

/* Half of the points in a cluster a millionth as large as the rest. */
static void all_points_in_a_triangle_are_found_once(void **state)
{
    (void)state;
    static struct pm_point2 p[COUNT];
    static uint32_t items[COUNT];
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (uint32_t i = 0; i < COUNT; i++) {
        double size = i % 2 ? 1 : 1e-6;
        p[i] = (struct pm_point2){size * pm_rng_uniform(&rng), size * pm_rng_uniform(&rng)};
        items[i] = i;
    }
    pm_corner_tree tree;
    assert_int_equal(pm_corner_tree_init(&tree, p, COUNT, items, COUNT - 10), PM_OK);
    size_t looked = 0, inside = 0;
    for (int round = 0; round < 600; round++) {
        static struct seen seen;
        struct pm_point2 t[3];
        seen = (struct seen){0};
        double size = round % 3 ? .1 : 2e-6;
        struct pm_point2 at = round % 3 ? p[2 * round + 1] : p[2 * round];
        for (int i = 0; i < 3; i++)
            t[i] = (struct pm_point2){at.x + size * (pm_rng_uniform(&rng) - .5),
                                      at.y + size * (pm_rng_uniform(&rng) - .5)};
        if ((t[1].x - t[0].x) * (t[2].y - t[0].y) < (t[1].y - t[0].y) * (t[2].x - t[0].x)) {
            struct pm_point2 swap = t[1];
            t[1] = t[2];
            t[2] = swap;
        }
        assert_false(pm_corner_tree_any(&tree, t, see, &seen));
        for (uint32_t i = 0; i < COUNT; i++) {
            bool there = i < COUNT - 10 && i >= (uint32_t)round;
            assert_in_range(seen.times[i], there && is_inside(t, p[i]), there);
            looked += seen.times[i];
            inside += there && is_inside(t, p[i]);
        }
        pm_corner_tree_remove(&tree, (uint32_t)round);
        pm_corner_tree_remove(&tree, (uint32_t)round);
    }
    assert_true(inside > 1000 && looked < 6 * inside + 600 * 40);
    pm_corner_tree_clear(&tree);
}

static void an_empty_tree_holds_nothing(void **state)
{
    (void)state;
    const struct pm_point2 t[3] = {{0, 0}, {1, 0}, {0, 1}};
    pm_corner_tree tree;
    struct seen seen = {0};
    assert_int_equal(pm_corner_tree_init(&tree, t, 3, NULL, 0), PM_OK);
    assert_false(pm_corner_tree_any(&tree, t, see, &seen));
    pm_corner_tree_remove(&tree, 1);
    pm_corner_tree_clear(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_points_in_a_triangle_are_found_once),
        cmocka_unit_test(an_empty_tree_holds_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
