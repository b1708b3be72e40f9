#include "files_test.h"

#include <float.h>
#include <math.h>

/* Expected bytes follow from the description in files/portable.h. */

static void integers_are_big_endian(void **state)
{
    (void)state;
    static const struct {
        int64_t value;
        unsigned size;
        uint8_t bytes[8];
    } cases[] = {{1, 1, {1}},
                 {-1, 1, {0xff}},
                 {287, 2, {1, 0x1f}},
                 {-2, 4, {0xff, 0xff, 0xff, 0xfe}},
                 {0x01020304, 4, {1, 2, 3, 4}},
                 {INT32_MIN, 4, {0x80, 0, 0, 0}},
                 {-3, 3, {0xff, 0xff, 0xfd}},
                 {INT64_MIN + 5, 8, {0x80, 0, 0, 0, 0, 0, 0, 5}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pm_bytes b = {0};
        pm_portable_put_integer(&b, cases[i].value, cases[i].size);
        assert_int_equal(b.size, cases[i].size);
        assert_memory_equal(b.data, cases[i].bytes, b.size);
        pm_reader r = {.data = b.data, .size = b.size};
        assert_true(pm_portable_integer(&r, cases[i].size) == cases[i].value && !r.failed);
        pm_bytes_clear(&b);
    }
}

static double real_of(const uint8_t bytes[5])
{
    pm_reader r = {.data = bytes, .size = 5};
    return pm_portable_real(&r);
}

/* (m + 1/2) / (2^31 - 1) * 2^e by hand. */
static void reals_are_mantissa_and_exponent(void **state)
{
    (void)state;
    assert_true(real_of((const uint8_t[]){0x3f, 0xff, 0xff, 0xff, 1}) == 1);
    assert_true(real_of((const uint8_t[]){0xc0, 0, 0, 1, 1}) == -1);
    assert_true(real_of((const uint8_t[]){0x3f, 0xff, 0xff, 0xff, 0xff}) == .25);
    assert_true(real_of((const uint8_t[]){0, 0, 0, 0, 77}) == 0);
    double three = 1610612735.5 / 2147483647 * 4; /* 3/4 = 0x5fffffff and a half */
    assert_true(real_of((const uint8_t[]){0x5f, 0xff, 0xff, 0xff, 2}) == three);
    assert_true(isfinite(real_of((const uint8_t[]){0x80, 0, 0, 0, 127})));
    assert_true(real_of((const uint8_t[]){0, 0, 0, 1, 0x80}) > 0);
}

static double through(double value)
{
    pm_bytes b = {0};
    pm_portable_put_real(&b, value);
    assert_int_equal(b.size, 5);
    double result = real_of(b.data);
    pm_bytes_clear(&b);
    return result;
}

static void written_reals_come_back(void **state)
{
    (void)state;
    for (int e = -100; e <= 100; e++)
        assert_true(through(ldexp(1, e)) == ldexp(1, e));
    uint64_t bits = 1;
    for (int i = 0; i < 20000; i++) {
        bits = bits * 6364136223846793005U + 1442695040888963407U;
        double value = ldexp((double)(bits >> 11) + 1, (int)(bits % 120) - 110);
        value = bits & 64 ? -value : value;
        assert_true(fabs(through(value) - value) < ldexp(fabs(value), -30));
    }
    assert_true(through(0) == 0 && through(1e-60) == 0);
    assert_true(through(1) <= 1 && through(1 - DBL_EPSILON) <= 1); /* no albedo above 1 */
    assert_true(through(1e300) > 1e38 && through(-1e300) < -1e38);
}

static bool header_is(const char *text, size_t size, unsigned *index_size)
{
    pm_reader r = {.data = (const uint8_t *)text, .size = size};
    return pm_portable_header(&r, "Radiance_octree", PM_OCTREE_MAGIC, index_size) &&
           r.at == size;
}
#define HEADER_IS(text, size) header_is(text, sizeof(text) - 1, size)

static void headers_are_known(void **state)
{
    (void)state;
    unsigned size = 0;
    assert_true(HEADER_IS("#?RADIANCE\nFORMAT=Radiance_octree\n\n\x01\x1f", &size) &&
                size == 4);
    assert_true(HEADER_IS("#?RADIANCE\r\nFORMAT= Radiance_octree \r\n\r\n\x01\x1d", &size) &&
                size == 2);
    assert_true(HEADER_IS("oconv a b\n\n\x01\x23", &size) && size == 8);
    assert_false(HEADER_IS("#?RADIANCE\nFORMAT=Radiance_tmesh\n\n\x01\x1f", &size));
    assert_false(HEADER_IS("#?RADIANCE\nFORMAT=Radiance_octree\n\n\x01\x24", &size));
    assert_false(HEADER_IS("#?RADIANCE\nFORMAT=Radiance_octree\n\n\x01\x1b", &size));
    assert_false(HEADER_IS("#?RADIANCE\nFORMAT=Radiance_octree\n\n\x01", &size));
    assert_false(HEADER_IS("#?RADIANCE\nFORMAT=Radiance_octree\n", &size));
    assert_false(HEADER_IS("void plastic a\n0 0 5 1 1 1 0 0\n\nvoid", &size));
    assert_false(HEADER_IS("", &size));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integers_are_big_endian),
        cmocka_unit_test(reals_are_mantissa_and_exponent),
        cmocka_unit_test(written_reals_come_back),
        cmocka_unit_test(headers_are_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
