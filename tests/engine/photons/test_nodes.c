#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fields.h"

/* A normal within 60 degrees of a search's normal sets the bit that the search asks for. */
static void sector_of_a_search_is_set_by_every_normal_within_60_degrees(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 1, PM_RNG_PATH, 0);
    for (int i = 0; i < 300000; i++) {
        pm_vec3 a = field_direction(&rng), b = field_direction(&rng);
        if (i % 3 == 0) { /* on axes and edges, and near them */
            a = (pm_vec3){floor(3 * a.x), floor(3 * a.y), floor(3 * a.z)};
            a = pm_vec3_normalize(pm_vec3_madd(a, i % 2 * 1e-9, b));
        }
        if (pm_vec3_dot(a, b) >= .5)
            assert_true(pm_content_of_normal(b) >> pm_content_sector(a) & 1);
    }
}

/* What the tree is for: floors do not make searches of facing ceilings or walls walk. */
static void sector_of_an_axis_leaves_out_walls_at_right_angles(void **state)
{
    (void)state;
    static const pm_vec3 axes[] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},
                                   {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 6; k++)
            assert_int_equal(pm_content_of_normal(axes[i]) >> pm_content_sector(axes[k]) & 1,
                             i == k);
}

static double axis_gap(int32_t origin, double step, uint8_t low, uint8_t high, int32_t p)
{
    double from = origin + low * step, to = origin + (high + 1) * step;
    return fmax(fmax(from - p, p - to), 0);
}

/* Photon i is in its block's box in level 0, that in its parent's, and so on. */
static void assert_in_boxes(const pm_photon_map *map, size_t i)
{
    const pm_photon_block *block = &map->blocks[i / PM_BLOCK_SIZE];
    size_t child = i / PM_BLOCK_SIZE;
    for (int level = 0; level < map->levels; level++, child /= PM_NODE_CHILDREN) {
        const pm_node *node = &map->nodes[map->level_start[level] + child / PM_NODE_CHILDREN];
        size_t c = child % PM_NODE_CHILDREN;
        for (int a = 0; a < 3; a++)
            assert_true(axis_gap(node->origin[a], 1 / (double)node->steps_per_unit,
                                 node->low[a][c], node->high[a][c],
                                 block->position[a][i % PM_BLOCK_SIZE]) == 0);
        assert_true(node->holds[PM_CONTENT_ANY] >> c & 1);
    }
    assert_int_equal(child, 0);
}

static void boxes_hold_their_photons(void **state)
{
    (void)state;
    field_make *fields[] = {field_room, field_ball, field_caustic, field_point};
    for (unsigned f = 0; f < sizeof fields / sizeof *fields; f++)
        for (size_t count = 1; count < 70000; count = count * 4 + 13) {
            pm_photon_map *map = field_map(fields[f], f, count);
            for (size_t i = 0; i < count; i++)
                assert_in_boxes(map, i);
            pm_photon_map_free(map);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sector_of_a_search_is_set_by_every_normal_within_60_degrees),
        cmocka_unit_test(sector_of_an_axis_leaves_out_walls_at_right_angles),
        cmocka_unit_test(boxes_hold_their_photons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
