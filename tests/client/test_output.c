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
    pm_output output = {.file = fopen("/dev/full", "wb"), .path = "/dev/full"};
    assert_non_null(output.file);
    fputs("more than fits", output.file);
    FILE *file = output.file;
    assert_int_equal(pm_output_commit(&output, &err), PM_E_IO);
    assert_non_null(strstr(err.text, "No space left"));
    fclose(file);
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
        cmocka_unit_test(output_in_a_folder_that_is_not_there_is_an_error),
    };
    return cmocka_run_group_tests_name("client.output", tests, NULL, NULL);
}
