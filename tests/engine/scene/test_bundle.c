#include "scene_test.h"

#include <stdlib.h>

#include "scene/path.h"

static void assert_join(const char *from, const char *name, const char *expected)
{
    char out[PM_PATH_SIZE] = "?";
    assert_int_equal(pm_path_join(from, name, out), expected != NULL);
    if (expected)
        assert_string_equal(out, expected);
}

static void names_are_normalised(void **state)
{
    (void)state;
    assert_join(NULL, "a.rad", "a.rad");
    assert_join(NULL, "./x//y/../a.rad", "x/a.rad");
    assert_join("x/y/b.rad", "a.rad", "x/y/a.rad");
    assert_join("x/y/b.rad", "../../a.rad", "a.rad");
    assert_join("b.rad", "c d/a.rad", "c d/a.rad");
    assert_join("x/b.rad", "../../a.rad", "^/a.rad");
    assert_join("b.rad", "../../lib/a.rad", "^/^/lib/a.rad");
    assert_join("^/^/lib/a.rad", "../b.rad", "^/^/b.rad");
    assert_join("^/^/a.rad", "../b.rad", "^/^/^/b.rad");
    assert_join(NULL, "..", NULL);
    assert_join(NULL, ".", NULL);
    assert_join(NULL, "", NULL);
    assert_join("x/b.rad", "", NULL);
    assert_join(NULL, "/etc/passwd", "^root/etc/passwd");
    assert_join("x/b.rad", "/../etc/passwd", "^root/etc/passwd");
    assert_join("^root/usr/a.cal", "../../../b.cal", "^root/b.cal");
    assert_join(NULL, "/", NULL);
    assert_join(NULL, "a/", NULL);
    assert_join(NULL, "a\nb", NULL);
    char longest[300];
    memset(longest, 'a', sizeof longest);
    longest[PM_PATH_SIZE - 1] = '\0';
    assert_join(NULL, longest, longest);
    assert_join("x/b.rad", longest, NULL);
    longest[PM_PATH_SIZE - 1] = 'a';
    longest[PM_PATH_SIZE] = '\0';
    assert_join(NULL, longest, NULL);
}

static void add(pm_bundle *bundle, const char *name, const char *text)
{
    assert_int_equal(pm_bundle_add(bundle, name, text, strlen(text), NULL), PM_OK);
}

static pm_bundle *three_files(bool backwards)
{
    pm_bundle *bundle = pm_bundle_new();
    add(bundle, backwards ? "c.rad" : "a.rad", backwards ? "" : "one");
    add(bundle, "b/b.rad", "two");
    add(bundle, backwards ? "a.rad" : "c.rad", backwards ? "one" : "");
    return bundle;
}

static void a_file_is_found_beside_its_namer_then_at_the_top(void **state)
{
    (void)state;
    pm_bundle *bundle = three_files(false);
    add(bundle, "b/a.rad", "other");
    assert_string_equal(pm_bundle_find(bundle, "a.rad", "b/b.rad")->name, "b/a.rad");
    assert_string_equal(pm_bundle_find(bundle, "a.rad", "c.rad")->name, "a.rad");
    assert_string_equal(pm_bundle_find(bundle, "c.rad", "b/b.rad")->name, "c.rad");
    assert_string_equal(pm_bundle_find(bundle, "./b/../a.rad", NULL)->name, "a.rad");
    assert_null(pm_bundle_find(bundle, "b.rad", NULL));
    assert_null(pm_bundle_find(bundle, "../a.rad", NULL));
    pm_bundle_free(bundle);
    pm_bundle_free(NULL);
}

static void names_that_cannot_be_are_refused(void **state)
{
    (void)state;
    pm_bundle *bundle = three_files(false);
    static const char *const names[] = {"a.rad", "./a.rad", "/a.rad", "../a.rad", ""};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        assert_int_equal(pm_bundle_add(bundle, names[i], "x", 1, NULL), PM_E_RANGE);
    assert_int_equal(pm_bundle_count(bundle), 3);
    pm_bundle_free(bundle);
}

static void equal_bundles_give_equal_tars(void **state)
{
    (void)state;
    pm_bundle *a = three_files(false), *b = three_files(true);
    pm_bytes tar_a = {0}, tar_b = {0};
    assert_int_equal(pm_bundle_write_tar(a, &tar_a, NULL), PM_OK);
    assert_int_equal(pm_bundle_write_tar(b, &tar_b, NULL), PM_OK);
    assert_int_equal(tar_a.size, tar_b.size);
    assert_memory_equal(tar_a.data, tar_b.data, tar_a.size);
    pm_bytes_clear(&tar_a);
    pm_bytes_clear(&tar_b);
    pm_bundle_free(a);
    pm_bundle_free(b);
}

static void a_tar_brings_back_the_files(void **state)
{
    (void)state;
    pm_bundle *bundle = three_files(true), *back = NULL;
    pm_bytes tar = {0};
    assert_int_equal(pm_bundle_write_tar(bundle, &tar, NULL), PM_OK);
    assert_int_equal(pm_bundle_read_tar(tar.data, tar.size, 6, &back, NULL), PM_OK);
    assert_int_equal(pm_bundle_count(back), 3);
    for (size_t i = 0; i < 3; i++) {
        const pm_file *x = pm_bundle_at(bundle, i), *y = pm_bundle_at(back, i);
        assert_string_equal(x->name, y->name);
        assert_int_equal(x->size, y->size);
        assert_memory_equal(x->data, y->data, x->size);
    }
    pm_bundle_free(back);
    back = NULL;
    assert_int_equal(pm_bundle_read_tar(tar.data, tar.size, 5, &back, NULL), PM_E_LIMIT);
    assert_null(back);
    pm_bytes_clear(&tar);
    pm_bundle_free(bundle);
}

/* A POSIX ustar header, then the data in whole blocks. `said` is the size it claims. */
static void add_entry(pm_bytes *tar, const char *name, char kind, const char *link,
                      const char *data, unsigned long long said)
{
    char header[512] = "";
    memcpy(header, name, strlen(name));
    memcpy(header + 100, "0000644\0000000000\0000000000", 24);
    snprintf(header + 124, 12, "%011llo", said);
    memcpy(header + 136, "00000000000", 11);
    memset(header + 148, ' ', 8);
    header[156] = kind;
    memcpy(header + 157, link, strlen(link));
    memcpy(header + 257, "ustar\00000", 8);
    unsigned sum = 0;
    for (size_t i = 0; i < sizeof header; i++)
        sum += (unsigned char)header[i];
    snprintf(header + 148, 8, "%06o", sum);
    pm_bytes_append(tar, header, sizeof header);
    char block[512] = "";
    memcpy(block, data, strlen(data));
    if (*data)
        pm_bytes_append(tar, block, sizeof block);
}

static pm_status read_entry(const char *name, char kind, const char *link,
                            unsigned long long said)
{
    pm_bytes tar = {0};
    pm_bundle *bundle = NULL;
    static const char end[1024];
    add_entry(&tar, name, kind, link, kind == '0' ? "data" : "", said);
    pm_bytes_append(&tar, end, sizeof end);
    pm_status st = pm_bundle_read_tar(tar.data, tar.size, 1 << 20, &bundle, NULL);
    pm_bytes_clear(&tar);
    pm_bundle_free(bundle);
    return st;
}

static void only_plain_files_inside_are_taken(void **state)
{
    (void)state;
    assert_int_equal(read_entry("a.rad", '0', "", 4), PM_OK);
    assert_int_equal(read_entry("a.rad", '1', "b.rad", 0), PM_E_UNSUPPORTED);
    assert_int_equal(read_entry("a.rad", '2', "/etc/passwd", 0), PM_E_UNSUPPORTED);
    assert_int_equal(read_entry("a.rad", '3', "", 0), PM_E_UNSUPPORTED);
    assert_int_equal(read_entry("a.rad", '4', "", 0), PM_E_UNSUPPORTED);
    assert_int_equal(read_entry("a.rad", '6', "", 0), PM_E_UNSUPPORTED);
    assert_int_equal(read_entry("/a.rad", '0', "", 4), PM_E_RANGE);
    assert_int_equal(read_entry("b/../../a.rad", '0', "", 4), PM_E_RANGE);
    assert_int_equal(read_entry("a", '5', "", 0), PM_E_CORRUPT); /* a folder alone: no file */
}

static void a_size_larger_than_the_tar_is_refused(void **state)
{
    (void)state;
    assert_int_equal(read_entry("a.rad", '0', "", 077777777777ULL), PM_E_CORRUPT);
    assert_int_equal(read_entry("a.rad", '0', "", 1600), PM_E_CORRUPT);
}

static void a_name_given_twice_is_refused(void **state)
{
    (void)state;
    pm_bytes tar = {0};
    pm_bundle *bundle = NULL;
    static const char end[1024];
    add_entry(&tar, "a.rad", '0', "", "data", 4);
    add_entry(&tar, "x/../a.rad", '0', "", "data", 4);
    pm_bytes_append(&tar, end, sizeof end);
    assert_int_equal(pm_bundle_read_tar(tar.data, tar.size, 100, &bundle, NULL), PM_E_RANGE);
    assert_null(bundle);
    pm_bytes_clear(&tar);
}

/* Cut at every byte: an error or, once the last file is whole, the files; never a partial file.
 */
static void a_cut_tar_never_gives_a_part_of_a_file(void **state)
{
    (void)state;
    pm_bundle *bundle = three_files(false);
    pm_bytes tar = {0};
    assert_int_equal(pm_bundle_write_tar(bundle, &tar, NULL), PM_OK);
    pm_bundle_free(bundle);
    size_t read = 0;
    for (size_t size = 0; size < tar.size; size++) {
        pm_bundle *back = NULL;
        /* A copy of its own, so that the sanitizer sees reads past its end. */
        uint8_t *cut = malloc(size ? size : 1);
        memcpy(cut, tar.data, size);
        if (!pm_bundle_read_tar(cut, size, 100, &back, NULL)) {
            const pm_file *file = pm_bundle_find(back, "a.rad", NULL);
            assert_non_null(file);
            assert_int_equal(file->size, 3);
            assert_memory_equal(file->data, "one", 3);
            read++;
        }
        pm_bundle_free(back);
        free(cut);
    }
    assert_in_range(read, 1, tar.size - 1024);
    pm_bytes_clear(&tar);
}

static void what_is_no_tar_is_refused(void **state)
{
    (void)state;
    pm_bundle *bundle = NULL;
    static const char text[2048] = "void plastic wall 0 0 5 .7 .7 .7 0 0\n";
    static const uint8_t gzip[64] = {0x1F, 0x8B, 8};
    assert_int_equal(pm_bundle_read_tar(text, sizeof text, 1 << 20, &bundle, NULL),
                     PM_E_CORRUPT);
    assert_int_equal(pm_bundle_read_tar(gzip, sizeof gzip, 1 << 20, &bundle, NULL),
                     PM_E_CORRUPT);
    assert_int_equal(pm_bundle_read_tar("", 0, 1 << 20, &bundle, NULL), PM_E_CORRUPT);
    assert_null(bundle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_normalised),
        cmocka_unit_test(a_file_is_found_beside_its_namer_then_at_the_top),
        cmocka_unit_test(names_that_cannot_be_are_refused),
        cmocka_unit_test(equal_bundles_give_equal_tars),
        cmocka_unit_test(a_tar_brings_back_the_files),
        cmocka_unit_test(only_plain_files_inside_are_taken),
        cmocka_unit_test(a_size_larger_than_the_tar_is_refused),
        cmocka_unit_test(a_name_given_twice_is_refused),
        cmocka_unit_test(a_cut_tar_never_gives_a_part_of_a_file),
        cmocka_unit_test(what_is_no_tar_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
