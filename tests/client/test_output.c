#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "output.h"

static void output_appears_whole_or_not_at_all(void **state)
{
    (void)state;
    char folder[] = "/tmp/pm_output_XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/picture", folder);

    pm_output output;
    assert_int_equal(pm_output_open(&output, path, NULL), PM_OK);
    fputs("half", output.file);
    assert_int_equal(access(path, F_OK), -1);
    pm_output_abandon(&output);
    assert_int_equal(access(path, F_OK), -1);

    assert_int_equal(pm_output_open(&output, path, NULL), PM_OK);
    fputs("whole", output.file);
    assert_int_equal(pm_output_commit(&output, NULL), PM_OK);
    struct stat about;
    assert_int_equal(stat(path, &about), 0);
    assert_int_equal(about.st_size, 5);

    unlink(path);
    assert_int_equal(rmdir(folder), 0); /* nothing else is left in it */
}

static void output_on_a_full_disk_is_an_error(void **state)
{
    (void)state;
    pm_error err = PM_ERROR_INIT;
    pm_output output;
    assert_int_equal(pm_output_open(&output, "/dev/full", NULL), PM_OK);
    assert_string_equal(output.temporary, ""); /* or the device would be replaced */
    fputs("more than fits", output.file);
    assert_int_equal(pm_output_commit(&output, &err), PM_E_IO);
    assert_non_null(strstr(err.text, "No space left"));
}

static void write_whole(const char *path)
{
    pm_output output;
    assert_int_equal(pm_output_check(path, NULL), PM_OK);
    assert_int_equal(pm_output_open(&output, path, NULL), PM_OK);
    fputs("whole", output.file);
    assert_int_equal(pm_output_commit(&output, NULL), PM_OK);
}

static void devices_and_links_stay_what_they_are(void **state)
{
    (void)state;
    char folder[] = "/tmp/pm_output_XXXXXX", pipe[64], file[64], link[64], text[8] = "";
    assert_non_null(mkdtemp(folder));
    snprintf(pipe, sizeof pipe, "%s/pipe", folder);
    snprintf(file, sizeof file, "%s/file", folder);
    snprintf(link, sizeof link, "%s/link", folder);
    struct stat about;

    assert_int_equal(mkfifo(pipe, 0600), 0);
    int end = open(pipe, O_RDONLY | O_NONBLOCK);
    write_whole(pipe);
    assert_int_equal(read(end, text, sizeof text), 5);
    assert_string_equal(text, "whole");
    assert_int_equal(lstat(pipe, &about), 0);
    assert_true(S_ISFIFO(about.st_mode));
    close(end);

    fclose(fopen(file, "wb"));
    assert_int_equal(symlink("file", link), 0);
    write_whole(link);
    assert_int_equal(lstat(link, &about), 0);
    assert_true(S_ISLNK(about.st_mode));
    assert_int_equal(stat(file, &about), 0);
    assert_int_equal(about.st_size, 5);

    unlink(pipe);
    unlink(file);
    unlink(link);
    assert_int_equal(rmdir(folder), 0);
}

static void output_in_a_folder_that_is_not_there_is_an_error(void **state)
{
    (void)state;
    pm_output output;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_output_open(&output, "/nonexistent/a.exr", &err), PM_E_IO);
    assert_string_equal(err.file, "/nonexistent/a.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(output_appears_whole_or_not_at_all),
        cmocka_unit_test(output_on_a_full_disk_is_an_error),
        cmocka_unit_test(devices_and_links_stay_what_they_are),
        cmocka_unit_test(output_in_a_folder_that_is_not_there_is_an_error),
    };
    return cmocka_run_group_tests_name("client.output", tests, NULL, NULL);
}
