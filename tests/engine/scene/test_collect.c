#include "scene_test.h"

#include <fcntl.h>
#include <ftw.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* A folder of its own, current while a test runs. */
static char folder[] = "/tmp/pm_collect_XXXXXX";

static void write_file(const char *name, const char *text)
{
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static int enter_folder(void **state)
{
    (void)state;
    return !mkdtemp(folder) || chdir(folder) || mkdir("room", 0700) ||
           mkdir("room/parts", 0700);
}

static int remove_one(const char *path, const struct stat *info, int kind, struct FTW *walk)
{
    (void)info, (void)kind, (void)walk;
    return remove(path);
}

static int leave_folder(void **state)
{
    (void)state;
    return chdir("/") || nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static void assert_refused(const char *path, pm_status expected, const char *message)
{
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    pm_error err = PM_ERROR_INIT;
    char text[1200];
    assert_int_equal(pm_bundle_collect(path, &bundle, &name, &err), expected);
    assert_null(bundle);
    pm_error_format(&err, text, sizeof text);
    assert_string_equal(text, message);
}

static void every_file_named_is_collected_once(void **state)
{
    (void)state;
    write_file("room/main.rad", "!xform -t 1 0 0 parts/desk.rad\n!xform -a 3 ./parts/desk.rad\n"
                                "void plastic p 0 0 5 0 0 0 0 0\n!xform top.rad\n");
    write_file("room/parts/desk.rad", "!xform leg.rad\n!xform top.rad\n");
    write_file("room/parts/leg.rad", "# leg\n");
    write_file("room/top.rad", "# top\n");
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    assert_int_equal(pm_bundle_collect("room/main.rad", &bundle, &name, NULL), PM_OK);
    assert_string_equal(name, "main.rad");
    static const char *const names[] = {"main.rad", "parts/desk.rad", "parts/leg.rad",
                                        "top.rad"};
    assert_int_equal(pm_bundle_count(bundle), 4);
    for (size_t i = 0; i < 4; i++)
        assert_string_equal(pm_bundle_at(bundle, i)->name, names[i]);
    assert_memory_equal(pm_bundle_at(bundle, 3)->data, "# top\n", 6);
    pm_bundle_free(bundle);
}

static void all_missing_files_are_listed(void **state)
{
    (void)state;
    write_file("room/holes.rad", "!xform a.rad\n!xform -m x parts/holes.rad b.rad\n");
    write_file("room/parts/holes.rad", "\n  !xform c.rad");
    assert_refused(
        "room/holes.rad", PM_E_MISSING,
        "3 files of the scene not found beside the file that names them nor in the main "
        "file's folder: 'a.rad' (holes.rad:1:8), 'b.rad' (holes.rad:2:29), 'c.rad' "
        "(parts/holes.rad:2:10)");
    assert_refused("room/nothing.rad", PM_E_MISSING,
                   "cannot read 'room/nothing.rad': No such file or directory");
    assert_refused("nowhere/a.rad", PM_E_MISSING,
                   "cannot read 'nowhere/a.rad': No such file or directory");
    assert_refused("room", PM_E_IO, "'room' is a folder; name a scene file");
}

static void nothing_outside_the_folder_is_read(void **state)
{
    (void)state;
    write_file("secret.rad", "# secret\n");
    write_file("room/climb.rad", "!xform ../secret.rad\n");
    assert_refused("room/climb.rad", PM_E_RANGE,
                   "climb.rad:1:8: '../secret.rad' lies outside the scene's folder; move it "
                   "beneath the folder of the main file and write its name relative to that");
    write_file("room/absolute.rad", "!xform /etc/hostname\n");
    assert_refused("room/absolute.rad", PM_E_RANGE,
                   "absolute.rad:1:8: '/etc/hostname' lies outside the scene's folder; move it "
                   "beneath the folder of the main file and write its name relative to that");
    write_file("room/link.rad", "!xform parts/out.rad\n");
    assert_int_equal(symlink("../../secret.rad", "room/parts/out.rad"), 0);
    assert_refused(
        "room/link.rad", PM_E_RANGE,
        "link.rad:1:8: 'parts/out.rad' is a link out of the scene's folder; copy the "
        "file into the folder of the main file");
}

static void a_link_within_the_folder_is_followed(void **state)
{
    (void)state;
    write_file("room/inner.rad", "!xform parts/in.rad\n");
    write_file("room/target.rad", "# target\n");
    assert_int_equal(symlink("../target.rad", "room/parts/in.rad"), 0);
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    assert_int_equal(pm_bundle_collect("room/inner.rad", &bundle, &name, NULL), PM_OK);
    assert_memory_equal(pm_bundle_find(bundle, "parts/in.rad", NULL)->data, "# target\n", 9);
    pm_bundle_free(bundle);
}

/* The parser says what is wrong with the text, so collecting goes on. */
static void wrong_text_is_left_to_the_parser(void **state)
{
    (void)state;
    write_file("room/wrong.rad", "!genbox a b 1 1 1\n!xform -t 1 part.rad\n!xform target.rad\n"
                                 "void plastic\n");
    write_file("room/target.rad", "# target\n");
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    pm_scene *scene = NULL;
    assert_int_equal(pm_bundle_collect("room/wrong.rad", &bundle, &name, NULL), PM_OK);
    assert_int_equal(pm_bundle_count(bundle), 2);
    assert_int_equal(pm_scene_parse(bundle, name, NULL, &scene, NULL), PM_E_UNSUPPORTED);
    pm_bundle_free(bundle);
}

static void a_dash_reads_standard_input(void **state)
{
    (void)state;
    write_file("input", "!xform room/top.rad\n");
    write_file("room/top.rad", "# top\n");
    int saved = dup(STDIN_FILENO), fd = open("input", O_RDONLY);
    assert_int_equal(dup2(fd, STDIN_FILENO), STDIN_FILENO);
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    pm_status st = pm_bundle_collect("-", &bundle, &name, NULL);
    dup2(saved, STDIN_FILENO);
    close(saved);
    close(fd);
    assert_int_equal(st, PM_OK);
    assert_string_equal(name, "stdin.rad");
    assert_non_null(pm_bundle_find(bundle, "room/top.rad", NULL));
    pm_bundle_free(bundle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_file_named_is_collected_once),
        cmocka_unit_test(all_missing_files_are_listed),
        cmocka_unit_test(nothing_outside_the_folder_is_read),
        cmocka_unit_test(a_link_within_the_folder_is_followed),
        cmocka_unit_test(wrong_text_is_left_to_the_parser),
        cmocka_unit_test(a_dash_reads_standard_input),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
