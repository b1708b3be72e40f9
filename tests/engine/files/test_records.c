#include "files_test.h"

#include "files/records.h"

static const char *const strings[] = {"dx", "wave.cal", ""};
static const double reals[] = {1, -.25, 0};
static const pm_record items[] = {
    {.type = "texfunc", .name = "wave", .strings = strings, .string_count = 3, .modifier = -1},
    {.type = "plastic", .name = "", .reals = reals, .real_count = 3, .modifier = 0},
    {.type = "alias", .name = "other", .modifier = 1},
};

static void assert_record(const pm_record *a, const pm_record *b)
{
    assert_string_equal(a->type, b->type);
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->modifier, b->modifier);
    assert_int_equal(a->string_count, b->string_count);
    assert_int_equal(a->real_count, b->real_count);
    for (uint32_t i = 0; i < b->string_count; i++)
        assert_string_equal(a->strings[i], b->strings[i]);
    for (uint32_t i = 0; i < b->real_count; i++)
        assert_true(a->reals[i] == b->reals[i]);
}

static pm_status read(const void *data, size_t size, unsigned index_size, pm_arena *arena,
                      pm_records *out, pm_error *err)
{
    pm_reader reader = {.data = data, .size = size};
    return pm_records_read(&reader, index_size, 100, "a.oct", arena, out, err);
}

static void what_is_written_is_read(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_arena arena = {0};
    pm_records records;
    pm_error err = PM_ERROR_INIT;
    assert_ok(pm_records_write(items, 3, &b, &err), &err);
    assert_ok(read(b.data, b.size, 4, &arena, &records, &err), &err);
    assert_int_equal(records.count, 3);
    for (int i = 0; i < 3; i++)
        assert_record(&records.items[i], &items[i]);
    pm_arena_clear(&arena);
    pm_bytes_clear(&b);
}

/* One plastic of one real, its index in 2 bytes. */
static void the_bytes_are_these(void **state)
{
    (void)state;
    static const uint8_t bytes[] = "metal\0plastic\0\0\1\xff\xff"
                                   "a\0\0\0\0\1\x40\0\0\0\2\xff";
    pm_arena arena = {0};
    pm_records records;
    pm_error err = PM_ERROR_INIT;
    assert_ok(read(bytes, sizeof bytes - 1, 2, &arena, &records, &err), &err);
    assert_int_equal(records.count, 1);
    const double value = 1073741824.5 / 2147483647 * 4;
    assert_record(&records.items[0],
                  &(pm_record){"plastic", "a", NULL, (const double[]){value}, 0, 1, -1});
    pm_arena_clear(&arena);
}

static void every_cut_is_refused(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_error written = PM_ERROR_INIT;
    assert_ok(pm_records_write(items, 3, &b, &written), &written);
    for (size_t size = 0; size < b.size; size++) {
        pm_arena arena = {0};
        pm_records records = {.count = 77};
        pm_error err = PM_ERROR_INIT;
        void *copy = malloc(size + 1);
        memcpy(copy, b.data, size);
        assert_int_equal(read(copy, size, 4, &arena, &records, &err), PM_E_CORRUPT);
        assert_int_equal(records.count, 77);
        assert_non_null(strstr(err.text, "cut off"));
        pm_arena_clear(&arena);
        free(copy);
    }
    pm_bytes_clear(&b);
}

static void assert_refused(const char *bytes, size_t size, const char *message)
{
    pm_arena arena = {0};
    pm_records records;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(read(bytes, size, 4, &arena, &records, &err), PM_E_CORRUPT);
    assert_message(&err, message);
    pm_arena_clear(&arena);
}
#define ASSERT_REFUSED(bytes, message) assert_refused(bytes, sizeof(bytes) - 1, message)

static void damage_is_named(void **state)
{
    (void)state;
    ASSERT_REFUSED("metal\0\0\1",
                   "a.oct: the file is damaged: the type of a primitive is wrong "
                   "before byte 8");
    ASSERT_REFUSED("metal\0\0\0\0\0\0\0", /* modified by itself */
                   "a.oct: the file is damaged: the modifier of a primitive is wrong before "
                   "byte 12");
    ASSERT_REFUSED("metal\0\0\0\xff\xff\xff\xff"
                   "a\0\xff\xff",
                   "a.oct: the file is damaged: the count of a primitive's strings is wrong "
                   "before byte 16");
    ASSERT_REFUSED("metal\0\0\0\xff\xff\xff\xff"
                   "a\0\0\0\x7f\xff",
                   "a.oct: the file is cut off; its 18 bytes end inside a primitive's reals");
}

static void what_the_format_cannot_hold_is_refused(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_error err = PM_ERROR_INIT, other = PM_ERROR_INIT, third = PM_ERROR_INIT;
    pm_record large = {.type = "polygon", .name = "p", .real_count = 32769, .modifier = -1};
    assert_int_equal(pm_records_write(&large, 1, &b, &err), PM_E_LIMIT);
    assert_message(&err, "polygon 'p' has 32769 arguments, and a frozen octree holds 32767 at "
                         "most; leave out -f, or divide it");
    pm_record odd = {.type = "spline", .name = "s", .modifier = -1};
    assert_int_equal(pm_records_write(&odd, 1, &b, &other), PM_E_UNSUPPORTED);
    assert_message(&other, "spline 's' cannot be written: Radiance 5.4 has no such type");
    char name[600];
    memset(name, 'n', sizeof name);
    name[599] = '\0';
    pm_record named = {.type = "light", .name = name, .modifier = -1};
    assert_int_equal(pm_records_write(&named, 1, &b, &third), PM_E_LIMIT);
    pm_bytes_clear(&b);
}

static void too_many_are_refused(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_arena arena = {0};
    pm_records records;
    pm_error err = PM_ERROR_INIT;
    assert_ok(pm_records_write(items, 3, &b, &err), &err);
    pm_reader reader = {.data = b.data, .size = b.size};
    assert_int_equal(pm_records_read(&reader, 4, 2, "a.oct", &arena, &records, &err),
                     PM_E_LIMIT);
    assert_message(&err, "a.oct: it holds more than 2 primitives; split it");
    pm_arena_clear(&arena);
    pm_bytes_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read),
        cmocka_unit_test(the_bytes_are_these),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(damage_is_named),
        cmocka_unit_test(what_the_format_cannot_hold_is_refused),
        cmocka_unit_test(too_many_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
