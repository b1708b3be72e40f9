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
    assert_int_equal(pm_bundle_collect(path, NULL, &bundle, &name, &err), expected);
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
    assert_int_equal(pm_bundle_collect("room/main.rad", NULL, &bundle, &name, NULL), PM_OK);
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
        "3 files of the scene not found beside the file that names them, in the main file's "
        "folder, in the current one nor in RAYPATH: 'a.rad' (holes.rad:1:8), 'b.rad' "
        "(holes.rad:2:29), 'c.rad' (parts/holes.rad:2:10)");
    assert_refused("room/nothing.rad", PM_E_MISSING,
                   "cannot read 'room/nothing.rad': No such file or directory");
    assert_refused("nowhere/a.rad", PM_E_MISSING,
                   "cannot read 'nowhere/a.rad': No such file or directory");
    assert_refused("room", PM_E_IO, "'room' is a folder; name a file");
}

#define NOT_SENT(name, place)                                                                  \
    "1 file outside the scene's folder and RAYPATH, not sent; add --allow with its folder to " \
    "send it: '" name "' (" place ")"

static void nothing_outside_the_folder_is_taken(void **state)
{
    (void)state;
    write_file("secret.rad", "# secret\n");
    write_file("room/climb.rad", "!xform ../secret.rad\n");
    assert_refused("room/climb.rad", PM_E_MISSING, NOT_SENT("../secret.rad", "climb.rad:1:8"));
    write_file("room/absolute.rad", "!xform /etc/hostname\n");
    assert_refused("room/absolute.rad", PM_E_MISSING,
                   NOT_SENT("/etc/hostname", "absolute.rad:1:8"));
    write_file("room/link.rad", "!xform parts/out.rad\n");
    assert_int_equal(symlink("../../secret.rad", "room/parts/out.rad"), 0);
    assert_refused("room/link.rad", PM_E_MISSING, NOT_SENT("parts/out.rad", "link.rad:1:8"));
    write_file("room/data.rad", "void brightdata d 4 f ../secret.rad . x 0 0\n"
                                "!xform nowhere.rad\n");
    assert_refused("room/data.rad", PM_E_MISSING,
                   "1 file of the scene not found beside the file that names it, in the main "
                   "file's folder, in the current one nor in RAYPATH: 'nowhere.rad' "
                   "(data.rad:2:8); " NOT_SENT("../secret.rad", "data.rad:1:23"));
}

static void a_pipe_is_not_waited_for(void **state)
{
    (void)state;
    write_file("room/waits.rad", "!xform parts/pipe.rad\n");
    assert_int_equal(mkfifo("room/parts/pipe.rad", 0600), 0);
    assert_refused("room/waits.rad", PM_E_IO,
                   "'parts/pipe.rad' is a pipe or a device; a scene names files");
}

static void an_allowed_folder_is_taken_from(void **state)
{
    (void)state;
    mkdir("lib", 0700);
    write_file("room/allowed.rad", "!xform ../lib/chair.rad\n");
    write_file("lib/chair.rad", "!xform leg.rad\n!xform ../room/top.rad\n");
    write_file("lib/leg.rad", "# leg\n");
    write_file("room/top.rad", "# top\n");
    const char *const folders[] = {"lib"};
    const pm_collect_options options = {.allowed = folders, .allowed_count = 1};
    pm_bundle *bundle = NULL, *copy = NULL;
    const char *name = NULL;
    pm_bytes tar = {0};
    assert_int_equal(pm_bundle_collect("room/allowed.rad", &options, &bundle, &name, NULL),
                     PM_OK);
    assert_int_equal(pm_bundle_write_tar(bundle, &tar, NULL), PM_OK);
    assert_int_equal(pm_bundle_read_tar(tar.data, tar.size, 1 << 20, &copy, NULL), PM_OK);
    assert_int_equal(pm_bundle_count(copy), 4);
    const pm_file *chair = pm_bundle_find(copy, "../lib/chair.rad", "allowed.rad");
    assert_non_null(chair);
    assert_non_null(pm_bundle_find(copy, "leg.rad", chair->name));
    assert_non_null(pm_bundle_find(copy, "../room/top.rad", chair->name));
    pm_bytes_clear(&tar);
    pm_bundle_free(bundle);
    pm_bundle_free(copy);
}

static void every_kind_of_file_is_collected(void **state)
{
    (void)state;
    mkdir("shared", 0700);
    write_file("room/kinds.rad",
               "void colorpict p 7 red green blue p.hdr own.cal u v 0 0\n"
               "void brighttext t 2 a.fnt words.txt 0 11 0 0 0 1 0 0 0 1 0 1 0\n"
               "void brighttext w 3 a.fnt . words.txt 0 11 0 0 0 1 0 0 0 1 0 1 0\n"
               "void BSDF b 6 0 b.xml 0 0 1 . 0 0\n"
               "void texfunc f 6 x y z own.cal -s 2 0 0\n"
               "void mesh m 1 m.obj 0 0\n");
    static const char *const names[] = {"a.fnt",   "b.xml", "kinds.rad", "m.obj",
                                        "own.cal", "p.hdr", "words.txt"};
    write_file("shared/own.cal", "x=1;\n");
    for (size_t i = 0; i < 7; i++) {
        char path[64];
        snprintf(path, sizeof path, "room/%s", names[i]);
        if (i != 2 && i != 4)
            write_file(path, "# any\n");
    }
    const pm_collect_options options = {.search_path = "nowhere:shared"};
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    assert_int_equal(pm_bundle_collect("room/kinds.rad", &options, &bundle, &name, NULL),
                     PM_OK);
    assert_int_equal(pm_bundle_count(bundle), 7);
    for (size_t i = 0; i < 7; i++)
        assert_string_equal(pm_bundle_at(bundle, i)->name, names[i]);
    pm_bundle_free(bundle);
}

static void a_link_within_the_folder_is_followed(void **state)
{
    (void)state;
    write_file("room/inner.rad", "!xform parts/in.rad\n");
    write_file("room/target.rad", "# target\n");
    assert_int_equal(symlink("../target.rad", "room/parts/in.rad"), 0);
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    assert_int_equal(pm_bundle_collect("room/inner.rad", NULL, &bundle, &name, NULL), PM_OK);
    assert_memory_equal(pm_bundle_find(bundle, "parts/in.rad", NULL)->data, "# target\n", 9);
    pm_bundle_free(bundle);
}

static void files_that_commands_read_are_collected(void **state)
{
    (void)state;
    write_file("room/commands.rad",
               "!genprism m p corners.txt | xform -f places.txt\n!cat plain.rad | xform -rz 3\n"
               "!gensurf m s s t heights.txt 2 2 -f hills.cal | cat\n"
               "!gensurf m s s t s*t/2 2 2 -f rayinit.cal\n");
    static const char *const names[] = {"commands.rad", "corners.txt", "heights.txt",
                                        "hills.cal",    "places.txt",  "plain.rad"};
    for (size_t i = 1; i < 6; i++) {
        char path[40];
        snprintf(path, sizeof path, "room/%s", names[i]);
        write_file(path, "# a file\n");
    }
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    assert_int_equal(pm_bundle_collect("room/commands.rad", NULL, &bundle, &name, NULL), PM_OK);
    assert_int_equal(pm_bundle_count(bundle), 6);
    for (size_t i = 0; i < 6; i++)
        assert_string_equal(pm_bundle_at(bundle, i)->name, names[i]);
    pm_bundle_free(bundle);
}

/* The parser says what is wrong with the text, so collecting goes on. */
static void wrong_text_is_left_to_the_parser(void **state)
{
    (void)state;
    write_file("room/wrong.rad", "!genclock a b 1\n!xform -t 1 part.rad\n!xform target.rad\n"
                                 "void plastic\n");
    write_file("room/target.rad", "# target\n");
    pm_bundle *bundle = NULL;
    const char *name = NULL;
    pm_scene *scene = NULL;
    assert_int_equal(pm_bundle_collect("room/wrong.rad", NULL, &bundle, &name, NULL), PM_OK);
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
    pm_status st = pm_bundle_collect("-", NULL, &bundle, &name, NULL);
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
        cmocka_unit_test(nothing_outside_the_folder_is_taken),
        cmocka_unit_test(a_pipe_is_not_waited_for),
        cmocka_unit_test(an_allowed_folder_is_taken_from),
        cmocka_unit_test(every_kind_of_file_is_collected),
        cmocka_unit_test(a_link_within_the_folder_is_followed),
        cmocka_unit_test(files_that_commands_read_are_collected),
        cmocka_unit_test(wrong_text_is_left_to_the_parser),
        cmocka_unit_test(a_dash_reads_standard_input),
    };
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
