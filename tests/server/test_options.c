#include "cmocka_first.h"

#include <stdlib.h>
#include <string.h>

#include "options.h"

static pm_status parse(const char *words, pm_options *out, pm_error *err)
{
    static char copy[512]; /* options point into it */
    char *argv[32] = {(char *)"pmserver"};
    int argc = 1;
    strcpy(copy, words);
    for (char *word = strtok(copy, " "); word; word = strtok(NULL, " "))
        argv[argc++] = word;
    argv[argc] = NULL;
    return pm_options_parse(argc, argv, out, err);
}

static void options_have_defaults_and_units(void **state)
{
    (void)state;
    pm_options options;
    setenv("XDG_CACHE_HOME", "/tmp", 1);
    assert_int_equal(parse("", &options, NULL), PM_OK);
    assert_string_equal(options.store, "/tmp/pm/store.sqlite");
    assert_string_equal(options.listen, "127.0.0.1:8430");
    assert_int_equal(options.jobs, 1);
    assert_true(options.memory_limit > 0 && options.memory_limit < UINT64_MAX);
    assert_non_null(strstr(options.worker, "/pmworker"));
    pm_options_clear(&options);
    assert_int_equal(parse("--store a --unix b --jobs 3 --memory-limit 2G --blob-limit 10k -v",
                           &options, NULL),
                     PM_OK);
    assert_null(options.listen); /* the socket alone */
    assert_string_equal(options.unix_path, "b");
    assert_int_equal(options.jobs, 3);
    assert_int_equal(options.memory_limit, UINT64_C(2) << 30);
    assert_int_equal(options.blob_limit, 10240);
    assert_true(options.verbose);
    pm_options_clear(&options);
}

static void wrong_options_are_named(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "--jobs 0",         "--jobs 65", "--jobs -1",
        "--jobs 1x",        "--jobs",    "--jbos 1",
        "--patience 0",     "file",      "--store-limit 99999999999t",
        "--blob-limit 1.5m"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        pm_options options;
        pm_error err = PM_ERROR_INIT;
        char word[32] = "";
        strncpy(word, bad[i], strcspn(bad[i], " "));
        assert_int_not_equal(parse(bad[i], &options, &err), PM_OK);
        assert_non_null(strstr(err.text, word));
    }
}

/* Every option that --help names is known, and needs its value. */
static void help_and_parser_agree(void **state)
{
    (void)state;
    size_t found = 0;
    for (const char *at = pm_options_help; (at = strstr(at, "\n  --")); at++) {
        char word[32] = "";
        pm_options options;
        pm_error err = PM_ERROR_INIT;
        strncpy(word, at + 3, strcspn(at + 3, " "));
        assert_int_equal(parse(word, &options, &err), PM_E_MISSING);
        found++;
    }
    assert_int_equal(found, 13);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_have_defaults_and_units),
        cmocka_unit_test(wrong_options_are_named),
        cmocka_unit_test(help_and_parser_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
