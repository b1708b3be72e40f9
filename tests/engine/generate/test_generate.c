#include "generate_test.h"

static const char *const commands[] = {
    "genbox m b 1 2 3",
    "genbox m b 1 2 3 -b .1",
    "genbox m b 1 2 3 -r .1",
    "genbox some.long_modifier_name b 1 2 3 -r .01234567890123 -n 9 -s",
    "genprism m p 3 0 0 1.23456789012345 0 0 1.23456789012345 -l .1 .1 -1.1 -r .01",
    "genblinds m s .1 1 2 20 33 -r .12",
    "gensurf m s 1.1e-7*s -1.3e20*t sqrt(s+t)/3 20 20 -s",
    "genrev m r t sqrt(t)/3 30 -s",
    "genworm m w t/3 t/7 t/11 .1+t/13 30",
    "gensky 6 21 12",
    "gendaylit 6 21 12 -W 500 100",
};

enum { COMMANDS = sizeof commands / sizeof *commands };

static void measures_are_never_below_what_is_made(void **state)
{
    (void)state;
    for (size_t i = 0; i < COMMANDS; i++) {
        struct scene scene = make(commands[i]);
        size_t reals = 0;
        for (size_t k = 0; k < scene.count; k++)
            reals += scene.items[k].real_count;
        assert_true(scene.count && scene.count <= scene.size.primitives);
        assert_true(reals <= scene.size.reals);
        assert_true(scene.bytes <= scene.size.bytes);
        free_scene(&scene);
    }
}

static void sizes_beyond_64_bits_saturate(void **state)
{
    (void)state;
    struct command command;
    size_t wrong;
    pm_generate_size size;
    pm_generate_request request =
        request_of("gensurf m s s t 0 2000000000 2000000000 -s", &command);
    assert_int_equal(pm_generate_measure(&request, &size, &wrong, NULL), PM_OK);
    assert_true(size.primitives > 1000000000000000000U && size.reals > size.primitives);
    request = request_of("genbox m b 1 1 1 -r .1 -n 2147483647", &command);
    assert_int_equal(pm_generate_measure(&request, &size, &wrong, NULL), PM_OK);
    assert_true(size.primitives > 100000000000000000U);
}

static pm_status count_pieces(void *context, const void *text, size_t size)
{
    size_t *pieces = context;
    const char *end = (const char *)text + size;
    assert_true(size < 2 << 20 && end[-1] == '\n');
    ++*pieces;
    return PM_OK;
}

static void much_text_comes_in_pieces(void **state)
{
    (void)state;
    struct command command;
    size_t pieces = 0, wrong;
    pm_generate_request request = request_of("gensurf m s s t s*t/3 100 200", &command);
    assert_int_equal(pm_generate_run(&request, count_pieces, &pieces, &wrong, NULL), PM_OK);
    assert_in_range(pieces, 3, 20);
}

static pm_status stop(void *context, const void *text, size_t size)
{
    (void)context, (void)text, (void)size;
    return PM_E_CANCELLED;
}

static void the_sink_can_stop_a_generator(void **state)
{
    (void)state;
    for (size_t i = 0; i < COMMANDS; i++) {
        struct command command;
        size_t wrong;
        pm_generate_request request = request_of(commands[i], &command);
        assert_int_equal(pm_generate_run(&request, stop, NULL, &wrong, NULL), PM_E_CANCELLED);
    }
}

/* A million evaluations of a thousand steps would take minutes. */
static void functions_have_a_budget(void **state)
{
    (void)state;
    struct command command;
    size_t wrong;
    uint64_t work = 100000;
    pm_error err = PM_ERROR_INIT;
    pm_generate_request request = request_of("gensurf m p s t 'sum(0,500)' 999 999 -e "
                                             "'sum(a,n)=if(n-.5,sum(a+n,n-1),a);'",
                                             &command);
    request.work = &work;
    assert_int_equal(pm_generate_run(&request, count_pieces, &(size_t){0}, &wrong, &err),
                     PM_E_LIMIT);
    assert_string_equal(err.text, "gensurf: the functions of this scene's commands take too "
                                  "long; make fewer parts, or simpler functions");
}

static pm_generate_word word_is(const char *text, size_t index)
{
    struct command command;
    split(text, &command);
    return pm_generate_word_is(command.words, command.count, index);
}

static void words_that_name_files_are_known(void **state)
{
    (void)state;
    assert_int_equal(word_is("genprism m p corners", 3), PM_GENERATE_FILE);
    assert_int_equal(word_is("genprism m p 3 0 0 1 0 1 1", 3), PM_GENERATE_PLAIN);
    assert_int_equal(word_is("genprism m p -", 3), PM_GENERATE_PLAIN);
    assert_int_equal(word_is("gensurf m p s t heights 2 1", 5), PM_GENERATE_PERHAPS_FILE);
    assert_int_equal(word_is("gensurf m p s t 0 2 1 -s -f a.cal", 10),
                     PM_GENERATE_FUNCTION_FILE);
    assert_int_equal(word_is("genrev m p t 1 2 -f a.cal", 7), PM_GENERATE_FUNCTION_FILE);
    assert_int_equal(word_is("genworm m p t 1 2 1 3 -f a.cal", 9), PM_GENERATE_FUNCTION_FILE);
    assert_int_equal(word_is("genbox m b 1 1 1 -f a.cal", 7), PM_GENERATE_PLAIN);
}

static void names_cannot_bring_text_of_their_own(void **state)
{
    (void)state;
    assert_refused(
        "genbox '!xform' b 1 1 1", PM_E_SYNTAX, 1,
        "genbox: the modifier is '!xform'; it must be one word of at most 1000 bytes "
        "that does not start with ! # \" or '");
    assert_refused("genrev m 'a b' t 1 1", PM_E_SYNTAX, 2,
                   "genrev: the name is 'a b'; it must be one word of at most 1000 bytes that "
                   "does not start with ! # \" or '");
}

static void other_programs_are_refused(void **state)
{
    (void)state;
    assert_false(pm_generate_knows("genclock"));
    assert_refused(
        "genclock m c 3", PM_E_UNSUPPORTED, 0,
        "genclock: is not run here, only genbox, gensurf, genrev, genworm, genprism, "
        "genblinds, gensky, gendaylit are");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measures_are_never_below_what_is_made),
        cmocka_unit_test(sizes_beyond_64_bits_saturate),
        cmocka_unit_test(much_text_comes_in_pieces),
        cmocka_unit_test(the_sink_can_stop_a_generator),
        cmocka_unit_test(functions_have_a_budget),
        cmocka_unit_test(words_that_name_files_are_known),
        cmocka_unit_test(names_cannot_bring_text_of_their_own),
        cmocka_unit_test(other_programs_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
