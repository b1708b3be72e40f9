#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fields.h"

/* Bit 3 b + 2 - a of the code is bit b of coordinate a: compared bit by bit, from the top. */
static int slow_order(const void *a, const void *b)
{
    const pm_photon *p = a, *q = b;
    for (int bit = 31; bit >= 0; bit--)
        for (int axis = 0; axis < 3; axis++) {
            uint32_t x = p->position[axis] >> bit & 1, y = q->position[axis] >> bit & 1;
            if (x != y)
                return x < y ? -1 : 1;
        }
    return memcmp(p, q, sizeof *p);
}

static void assert_sorted(field_make *make, size_t count, pm_pool *pool)
{
    pm_photon *photons = field_photons(make, 1, count);
    pm_photon *sorted = malloc((count + 1) * sizeof *sorted);
    memcpy(sorted, photons, count * sizeof *photons);
    pm_photons_sort(sorted, count, pool);
    qsort(photons, count, sizeof *photons, slow_order);
    assert_memory_equal(sorted, photons, count * sizeof *photons);
    free(sorted);
    free(photons);
}

/* Places of few distinct bits, so that many photons share a code and differ in their other
 * bytes. */
static void field_coarse(pm_rng *rng, size_t i, pm_photon_record *out)
{
    (void)i;
    out->position.x = -1 + 0x1p-31 * (pm_rng_u32(rng) % 8);
    out->position.y = .5 * (pm_rng_u32(rng) % 4) - 1;
    out->position.z = 0x1p-30 * (pm_rng_u32(rng) % 4);
}

static void photons_are_sorted_by_morton_code_then_bytes(void **state)
{
    (void)state;
    field_make *fields[] = {field_room, field_ball, field_caustic, field_coarse, field_point};
    pm_pool *pool = pm_pool_new(3);
    for (unsigned f = 0; f < sizeof fields / sizeof *fields; f++) {
        assert_sorted(fields[f], 0, pool);
        assert_sorted(fields[f], 1, pool);
        assert_sorted(fields[f], 40, NULL); /* as few as are not worth a pass */
        assert_sorted(fields[f], 1000, NULL);
        assert_sorted(fields[f], 150000, pool); /* several tasks */
    }
    pm_pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photons_are_sorted_by_morton_code_then_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
