#include "files_test.h"

#include "files/octree_file.h"

static pm_status read(const void *data, size_t size, pm_arena *arena, pm_octree_file *out,
                      pm_error *err)
{
    return pm_octree_file_read(data, size, "a.oct", 1000, arena, out, err);
}

static void a_frozen_octree_is_read(void **state)
{
    (void)state;
    pm_bytes b = {0};
    pm_arena arena = {0};
    pm_octree_file file;
    pm_error err = PM_ERROR_INIT;
    put_octree(&b);
    assert_true(pm_octree_file_is(b.data, b.size));
    assert_ok(read(b.data, b.size, &arena, &file, &err), &err);
    assert_int_equal(file.file_count, 0);
    assert_int_equal(file.objects, 3);
    assert_true(file.origin[2] == -1 && file.size == 2);
    const pm_record *red = &file.records.items[0], *ball = &file.records.items[2];
    assert_string_equal(red->name, "red");
    assert_true(red->reals[0] == .5 && red->reals[4] == 0);
    assert_string_equal(file.records.items[1].type, "alias");
    assert_int_equal(ball->modifier, 1);
    assert_true(ball->reals[3] == 1);
    pm_arena_clear(&arena);
    pm_bytes_clear(&b);
}

static void an_octree_that_names_its_files_is_read(void **state)
{
    (void)state;
    static const char bytes[] = "#?RADIANCE\noconv a.rad b/c.rad\nFORMAT=Radiance_octree\n\n"
                                "\x01\x1f"
                                "0\0.5\0-2e-3\0001e3\0a.rad\0b/c.rad\0\0\0\0\0\2\0";
    pm_arena arena = {0};
    pm_octree_file file;
    pm_error err = PM_ERROR_INIT;
    assert_ok(read(bytes, sizeof bytes - 1, &arena, &file, &err), &err);
    assert_int_equal(file.file_count, 2);
    assert_string_equal(file.files[1], "b/c.rad");
    assert_true(file.origin[1] == .5 && file.origin[2] == -.002 && file.size == 1000);
    assert_int_equal(file.objects, 2);
    assert_int_equal(file.records.count, 0);
    pm_arena_clear(&arena);
}

static void every_cut_is_refused(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_octree(&b);
    for (size_t size = 0; size < b.size; size++) {
        pm_arena arena = {0};
        pm_octree_file file;
        pm_error err = PM_ERROR_INIT;
        void *copy = malloc(size + 1);
        memcpy(copy, b.data, size);
        assert_int_equal(read(copy, size, &arena, &file, &err), PM_E_CORRUPT);
        assert_true(err.text[0] && strcmp(err.file, "a.oct") == 0);
        pm_arena_clear(&arena);
        free(copy);
    }
    pm_bytes_clear(&b);
}

/* Every byte changed in turn: read or refused, nothing else (the sanitizers watch). */
static void no_changed_byte_does_harm(void **state)
{
    (void)state;
    pm_bytes b = {0};
    put_octree(&b);
    for (size_t i = 0; i < b.size; i++) {
        for (int bit = 0; bit < 8; bit++) {
            pm_arena arena = {0};
            pm_octree_file file;
            pm_error err = PM_ERROR_INIT;
            b.data[i] ^= (uint8_t)(1 << bit);
            pm_status st = read(b.data, b.size, &arena, &file, &err);
            assert_int_equal(st, err.status);
            b.data[i] ^= (uint8_t)(1 << bit);
            pm_arena_clear(&arena);
        }
    }
    pm_bytes_clear(&b);
}

#define HEAD  "#?RADIANCE\nFORMAT=Radiance_octree\n\n\x01\x1f"
#define CUBE  "0\0000\0000\0001\0"
#define NODES "\2\0\0\0\0\0\0\0"

static void assert_refused(const char *bytes, size_t size, pm_status status,
                           const char *message)
{
    pm_arena arena = {0};
    pm_octree_file file;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(read(bytes, size, &arena, &file, &err), status);
    assert_message(&err, message);
    pm_arena_clear(&arena);
}
#define ASSERT_REFUSED(bytes, status, message)                                                 \
    assert_refused(bytes, sizeof(bytes) - 1, status, message)

static void damage_is_named(void **state)
{
    (void)state;
    ASSERT_REFUSED(HEAD "0\0nan\0", PM_E_CORRUPT,
                   "a.oct: the file is damaged: the bounding cube is wrong before byte 43");
    ASSERT_REFUSED(HEAD "0\0000\0000\0-1\0", PM_E_CORRUPT,
                   "a.oct: the file is damaged: the bounding cube is wrong before byte 46");
    ASSERT_REFUSED(HEAD CUBE "\0\x7f\xff\xff\xff", PM_E_LIMIT,
                   "a.oct: it holds 2147483647 primitives, more than 1000; split it");
    ASSERT_REFUSED(HEAD CUBE "\0\0\0\0\1\3", PM_E_CORRUPT,
                   "a.oct: the file is damaged: a node of the octree is wrong before byte 51");
    ASSERT_REFUSED(HEAD CUBE "\0\0\0\0\1\1\0\0\2\0", PM_E_CORRUPT,
                   "a.oct: the file is damaged: the size of a leaf is wrong before byte 55");
    ASSERT_REFUSED(HEAD CUBE "\0\0\0\0\1\1\0\0\0\1\0\0\0\1", PM_E_CORRUPT,
                   "a.oct: the file is damaged: an object of a leaf is wrong before byte 59");
    ASSERT_REFUSED(HEAD CUBE "\0\0\0\0\1\1\0\0\0\1\0\0\0\0metal\0\0\0\xff\xff\xff\xff"
                             "a\0\0\0\0\0\xff",
                   PM_E_CORRUPT,
                   "a.oct: the file is damaged: an object of a leaf, which is no surface, is "
                   "wrong before byte 59");
    ASSERT_REFUSED(HEAD CUBE "\0\0\0\0\2\0metal\0\0\0\xff\xff\xff\xff"
                             "a\0\0\0\0\0\xff",
                   PM_E_CORRUPT,
                   "a.oct: the file is damaged: it announces 2 primitives and holds 1");
    ASSERT_REFUSED(HEAD CUBE "a\0\0\0\0\0\0\0more", PM_E_CORRUPT,
                   "a.oct: the file is damaged: 4 bytes follow its end");
}

/* The depth of a tree is bounded by its size alone; nothing recurses. */
static void a_tree_of_a_million_levels_is_read(void **state)
{
    (void)state;
    enum { LEVELS = 1000000 };
    pm_bytes b = {0};
    pm_arena arena = {0};
    pm_octree_file file;
    pm_error err = PM_ERROR_INIT;
    pm_bytes_append(&b, HEAD CUBE "a\0\0\0\0\0\1", sizeof HEAD CUBE "a\0\0\0\0\0\1" - 1);
    for (int i = 0; i < LEVELS; i++)
        pm_bytes_append(&b, NODES, 8);
    pm_bytes_append(&b, "\0", 1);
    assert_ok(read(b.data, b.size, &arena, &file, &err), &err);
    pm_arena_clear(&arena);
    pm_bytes_clear(&b);
}

static void what_is_started_is_read(void **state)
{
    (void)state;
    static const char *const files[] = {"a.rad", "sub/b.rad"};
    const pm_octree_file written = {
        .origin = {-1, .1, 3}, .size = 8, .files = files, .file_count = 2, .objects = 9};
    pm_bytes b = {0};
    pm_arena arena = {0};
    pm_octree_file file;
    pm_error err = PM_ERROR_INIT;
    pm_octree_file_start(&written, "oconv a.rad sub/b.rad", &b);
    pm_bytes_u8(&b, PM_NODE_EMPTY);
    assert_ok(read(b.data, b.size, &arena, &file, &err), &err);
    assert_true(file.origin[1] == .1 && file.size == 8 && file.objects == 9);
    assert_int_equal(file.file_count, 2);
    assert_string_equal(file.files[0], "a.rad");
    pm_arena_clear(&arena);
    pm_bytes_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frozen_octree_is_read),
        cmocka_unit_test(an_octree_that_names_its_files_is_read),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(no_changed_byte_does_harm),
        cmocka_unit_test(damage_is_named),
        cmocka_unit_test(a_tree_of_a_million_levels_is_read),
        cmocka_unit_test(what_is_started_is_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
