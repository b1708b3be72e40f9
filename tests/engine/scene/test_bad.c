#include "scene_test.h"

#include <dirent.h>
#include <stdlib.h>
#include <sys/stat.h>

/* Each folder of tests/bad holds a scene that must be refused, `input.rad` and what it names,
 * and in `error` the message that must come. */

static char *read_text(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("cannot read %s", path);
    struct stat info;
    assert_int_equal(fstat(fileno(file), &info), 0);
    char *text = calloc(1, (size_t)info.st_size + 1);
    assert_non_null(text);
    *size = fread(text, 1, (size_t)info.st_size, file);
    fclose(file);
    return text;
}

static void add_scene_files(pm_bundle *bundle, const char *folder)
{
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));) {
        char path[1024];
        size_t size;
        if (entry->d_name[0] == '.' || strcmp(entry->d_name, "error") == 0)
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        char *text = read_text(path, &size);
        assert_int_equal(pm_bundle_add(bundle, entry->d_name, text, size, NULL), PM_OK);
        free(text);
    }
    closedir(dir);
}

/* True if the folder's scene gives the folder's message. */
static int gives_its_message(const char *folder)
{
    char path[1024], message[1200] = "(accepted)";
    size_t size;
    pm_error err = PM_ERROR_INIT;
    pm_bundle *bundle = pm_bundle_new();
    pm_scene *scene = NULL;
    add_scene_files(bundle, folder);
    pm_status st = pm_scene_parse(bundle, "input.rad", NULL, &scene, &err);
    if (st)
        pm_error_format(&err, message, sizeof message);
    snprintf(path, sizeof path, "%s/error", folder);
    char *expected = read_text(path, &size);
    expected[strcspn(expected, "\n")] = '\0';
    int right = st && st == err.status && strcmp(message, expected) == 0 && !scene;
    if (!right)
        print_error("%s\n  says %s\n  not  %s\n", folder, message, expected);
    free(expected);
    pm_scene_free(scene);
    pm_bundle_free(bundle);
    return right;
}

static void each_bad_scene_gives_its_message(void **state)
{
    (void)state;
    size_t folders = 0, wrong = 0;
    DIR *dir = opendir(PM_SOURCE_DIR "/tests/bad");
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));) {
        char folder[600];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(folder, sizeof folder, PM_SOURCE_DIR "/tests/bad/%s", entry->d_name);
        folders++;
        wrong += !gives_its_message(folder);
    }
    closedir(dir);
    assert_int_equal(wrong, 0);
    assert_in_range(folders, 110, 10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_bad_scene_gives_its_message),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
