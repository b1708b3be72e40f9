#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "job_request.h"
#include "options.h"

enum { WORDS_MAX = 16 };

/* Splits at spaces, in place. */
static int split(char *text, char *words[WORDS_MAX])
{
    int count = 0;
    for (char *word = strtok(text, " "); word; word = strtok(NULL, " "))
        words[count++] = word;
    return count;
}

static pm_status parse(pm_verb verb, const char *line, pm_options *out, pm_error *err)
{
    static char text[512];
    char *words[WORDS_MAX];
    snprintf(text, sizeof text, "%s", line);
    int count = split(text, words);
    return pm_options_parse(verb, count, words, out, err);
}

static const char *kind_of(pm_verb verb)
{
    if (verb == PM_VERB_MKPMAP)
        return "map";
    return verb & (PM_VERB_TRACE | PM_VERB_RTRACE) ? "trace" : "render";
}

/* The request that a command line makes; map files get the digest of their names. */
static char *request_of(pm_verb verb, const char *line)
{
    pm_options options;
    pm_error err = PM_ERROR_INIT;
    pm_attachments attachments = {.scene = "scene"};
    if (parse(verb, line, &options, &err))
        fail_msg("%s: %s", line, err.text);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        const char *file = verb == PM_VERB_MKPMAP ? NULL : options.maps[kind].file;
        attachments.has_map[kind] = file;
        if (file)
            attachments.map[kind] = pm_digest_of(file, strlen(file));
    }
    attachments.has_points = !strcmp(kind_of(verb), "trace");
    unsigned formats = strcmp(kind_of(verb), "render") ? 0 : PM_WANT_HDR;
    pm_json *json = pm_job_request(&options, kind_of(verb), &attachments, formats, "typed");
    assert_non_null(json);
    char *text = pm_json_text(json);
    pm_json_free(json);
    return text;
}

/* Each option that bears on the answer changes what the server is asked. */
static void accepted_options_change_the_request(void **state)
{
    (void)state;
    static const struct {
        pm_verb verb;
        const char *without, *with;
    } table[] = {
        {PM_VERB_RENDER, "a.rad", "a.rad -apg 10k"},
        {PM_VERB_RENDER, "a.rad -apg 10k", "a.rad -apg 20k"},
        {PM_VERB_RENDER, "a.rad -apg 10k", "a.rad -apg 10k 50"},
        {PM_VERB_RENDER, "a.rad", "a.rad -apc 10k"},
        {PM_VERB_RENDER, "a.rad", "a.rad -ld 3"},
        {PM_VERB_RENDER, "a.rad", "a.rad -me 1 1 1"},
        {PM_VERB_RENDER, "a.rad -me 1 1 1", "a.rad -me 1 1 1 -ma .5 .5 .5"},
        {PM_VERB_TRACE, "a.rad -me 1 1 1", "a.rad -me 1 1 1 -mg .5"},
        {PM_VERB_RPICT, "a.rad", "a.rad -me 1 1 1"},
        {PM_VERB_RTRACE, "a.rad", "a.rad -bv"},
        {PM_VERB_RPICT, "a.rad -bv+", "a.rad -bv-"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -bvf"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -me .1 .1 .1"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -ld 3"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -apd g 1k"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -aps wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -apo wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k -apo wall", "a.rad -apg f 1k -apo- wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k -apo wall", "a.rad -apg f 1k -apo0 wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k -apo wall", "a.rad -apg f 1k -apo wall -dp 9"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k -apo wall", "a.rad -apg f 1k -apo wall -ds .1"},
        {PM_VERB_TRACE, "a.rad", "a.rad -apo wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -ae wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k -ae wall", "a.rad -apg f 1k -ae wall -ae floor"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k -ae wall", "a.rad -apg f 1k -ai wall"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -api 0 0 0 1 1 1"},
        {PM_VERB_MKPMAP, "a.rad -apg f 1k", "a.rad -apg f 1k -apI 0 0 0 1"},
        {PM_VERB_RENDER, "a.rad", "a.rad -apv 10k"},
        {PM_VERB_RENDER, "a.rad", "a.rad -ab -1"},
        {PM_VERB_RENDER, "a.rad", "a.rad -vp 1 2 3"},
        {PM_VERB_RENDER, "a.rad", "a.rad -vd 1 2 3"},
        {PM_VERB_RENDER, "a.rad", "a.rad -vu 1 2 3"},
        {PM_VERB_RENDER, "a.rad", "a.rad -vh 30"},
        {PM_VERB_RENDER, "a.rad", "a.rad -vv 30"},
        {PM_VERB_RENDER, "a.rad", "a.rad -x 99"},
        {PM_VERB_RENDER, "a.rad", "a.rad -y 99"},
        {PM_VERB_RENDER, "a.rad -x 99", "a.rad -x 99 -pa 0"},
        {PM_VERB_RENDER, "a.rad", "a.rad --passes 3"},
        {PM_VERB_RENDER, "a.rad", "a.rad --time 3m"},
        {PM_VERB_RENDER, "a.rad", "a.rad --error 3%"},
        {PM_VERB_RENDER, "a.rad", "a.rad -apr 7"},
        {PM_VERB_RENDER, "a.rad", "a.rad -apm 7"},
        {PM_VERB_RENDER, "a.rad", "a.rad -n 2"},
        {PM_VERB_MKPMAP, "-apg f 10k a.rad", "-apg f 11k a.rad"},
        {PM_VERB_MKPMAP, "-apg f 10k a.rad", "-apg f 10k -apc g 10k a.rad"},
        {PM_VERB_MKPMAP, "-apg f 10k a.rad", "-apg f 10k -apv g 10k a.rad"},
        {PM_VERB_MKPMAP, "-apg f 10k a.rad", "-apg f 10k -lr 7 a.rad"},
        {PM_VERB_RPICT, "a.rad", "-apg f a.rad"},
        {PM_VERB_RPICT, "-apg f a.rad", "-apg g a.rad"},
        {PM_VERB_RPICT, "-apg f a.rad", "-apg f 50 a.rad"},
        {PM_VERB_RPICT, "-apg f 50 a.rad", "-apg f 50 500 a.rad"},
        {PM_VERB_RPICT, "-apc f 50 500 a.rad", "-apc f 50 500 --bandwidth chi2 a.rad"},
        {PM_VERB_RPICT, "-apcb f 50 500 a.rad", "-apcb f 50 400 a.rad"},
        {PM_VERB_RENDER, "a.rad -apc 10k 50", "a.rad -apc 10k 50 500"},
        {PM_VERB_RPICT, "a.rad", "-apc f 50 a.rad"},
        {PM_VERB_RPICT, "a.rad", "-apv f 50 a.rad"},
        {PM_VERB_MKPMAP, "-apg f 10k a.rad", "-app f 10k 50 a.rad"},
        {PM_VERB_MKPMAP, "-app f 10k 40 a.rad", "-app f 10k 50 a.rad"},
        {PM_VERB_MKPMAP, "-app f 10k 50 a.rad", "-app f 10k 50 -apP .5 a.rad"},
        {PM_VERB_MKPMAP, "-app f 10k 50 a.rad", "-app f 10k 50 -apf .5 a.rad"},
        {PM_VERB_RPICT, "-apg f a.rad", "-app f a.rad"},
        {PM_VERB_RENDER, "a.rad", "a.rad -app 10k 50"},
        {PM_VERB_RPICT, "a.rad", "-ab 1 a.rad"},
        {PM_VERB_RTRACE, "a.rad", "-I a.rad"},
        {PM_VERB_TRACE, "a.rad", "a.rad -apg 1k"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char *without = request_of(table[i].verb, table[i].without);
        char *with = request_of(table[i].verb, table[i].with);
        if (!strcmp(without, with))
            fail_msg("`%s` asks the same as `%s`", table[i].with, table[i].without);
        free(without);
        free(with);
    }
}

static void ambient_bounces_default_as_each_verb_promises(void **state)
{
    (void)state;
    pm_options options;
    assert_int_equal(parse(PM_VERB_RENDER, "a.rad", &options, NULL), PM_OK);
    assert_int_equal(options.ambient_bounces, 1);
    assert_int_equal(parse(PM_VERB_RTRACE, "a.rad", &options, NULL), PM_OK);
    assert_int_equal(options.ambient_bounces, 0);
}

static void refused_options_say_why(void **state)
{
    (void)state;
    static const struct {
        pm_verb verb;
        const char *line, *text;
    } table[] = {
        {PM_VERB_RPICT, "-apcb f 50 a.rad", "the fewest and the most photons"},
        {PM_VERB_RPICT, "-apc f 50 50 a.rad", "a whole number from 51"},
        {PM_VERB_RPICT, "-apc f 50 --bandwidth chi2 a.rad", "nothing to choose"},
        {PM_VERB_RPICT, "-apc f 50 500 --bandwidth wide a.rad", "bias or chi2"},
        {PM_VERB_MKPMAP, "-app f 10k a.rad", "-app a.rad: must be photons"},
        {PM_VERB_MKPMAP, "-app f 100 200 a.rad", "a whole number from 1 to 100"},
        {PM_VERB_MKPMAP, "-app f 10k 50 -apP 0 a.rad", "greater than 0, at most 1"},
        {PM_VERB_MKPMAP, "-app f 10k 50 -apf 1.5 a.rad", "greater than 0, at most 1"},
        {PM_VERB_MKPMAP, "-apg f 10k -apf .5 a.rad", "no precomputed map"},
        {PM_VERB_MKPMAP, "-app f 10k 50 -apg g 10k a.rad", "give one of -apg and -app"},
        {PM_VERB_MKPMAP, "-apg f 10k -apg g 10k a.rad", "-apg: is given twice"},
        {PM_VERB_RENDER, "-apc 10k -apc 20k a.rad", "-apc: is given twice"},
        {PM_VERB_RPICT, "-app f -app g a.rad", "-app: is given twice"},
        {PM_VERB_MKPMAP, "-app f 10k 50 --passes 3 a.rad", "a precomputed map is one map"},
        {PM_VERB_RPICT, "-app f 2 a.rad", "1 or nothing"},
        {PM_VERB_MKPMAP, "a.rad -apo", "-apo: a modifier is missing"},
        {PM_VERB_RENDER, "a.rad -apo0 pane -dp 0", "-dp 0: must be 1 to"},
        {PM_VERB_MKPMAP, "a.rad -apo- pane -ds 2", "-ds 2: must be"},
        {PM_VERB_MKPMAP, "a.rad -ds .1", "-ds: has no meaning without -apo"},
        {PM_VERB_TRACE, "a.rad -dp 10", "-dp: has no meaning without -apo"},
        {PM_VERB_MKPMAP, "a.rad -apO /nonexistent/names", "/nonexistent/names: cannot be read"},
        {PM_VERB_RPICT, "-ad 512 a.rad", "--passes"},
        {PM_VERB_RPICT, "-dj .5 a.rad", "sampled a point a pass"},
        {PM_VERB_RPICT, "-frobnicate a.rad", "unknown option"},
        {PM_VERB_MKPMAP, "-vp 0 0 1 a.rad", "has no meaning here"},
        {PM_VERB_RENDER, "a.rad -x 0", "-x 0: must be pixels"},
        {PM_VERB_RENDER, "a.rad -x 1.5", "-x 1.5"},
        {PM_VERB_RENDER, "a.rad -x nan", "-x nan"},
        {PM_VERB_RENDER, "a.rad -x", "-x: pixels is missing"},
        {PM_VERB_RENDER, "a.rad -vp 1 2", "-vp: three numbers"},
        {PM_VERB_RENDER, "a.rad -vp 1 2 inf", "-vp inf"},
        {PM_VERB_RENDER, "a.rad -apg 0", "-apg 0"},
        {PM_VERB_RPICT, "a.rad -apd f", "next events"},
        {PM_VERB_RENDER, "a.rad -ae wall", "dark where no photons are stored"},
        {PM_VERB_RENDER, "a.rad -ma .5 .5 .5", "give -me r g b"},
        {PM_VERB_RENDER, "a.rad -me 1 1", "-me: three numbers r g b is missing"},
        {PM_VERB_RENDER, "a.rad -me 1 1 -1", "-me 1 1 -1: an extinction must be"},
        {PM_VERB_RENDER, "a.rad -me 1 1 nan", "-me nan"},
        {PM_VERB_RENDER, "a.rad -me 1 1 1 -ma 0 0 1.1", "an albedo must be 0 to 1"},
        {PM_VERB_RENDER, "a.rad -me 1 1 1 -mg 1", "-mg 1: an eccentricity lies between"},
        {PM_VERB_RENDER, "a.rad -bvx", "unknown option"},
        {PM_VERB_MKPMAP, "a.rad -e", "-e: a file is missing"},
        {PM_VERB_MKPMAP, "a.rad -ld 0", "-ld 0: must be a length greater than 0"},
        {PM_VERB_MKPMAP, "a.rad -ld nan", "-ld nan"},
        {PM_VERB_MKPMAP, "a.rad -aps", "-aps: a modifier is missing"},
        {PM_VERB_MKPMAP, "a.rad -ae a -ai b", "-ae or -ai alone"},
        {PM_VERB_MKPMAP, "a.rad -api 0 0 0 1 1", "-api: a box: two corners"},
        {PM_VERB_MKPMAP, "a.rad -api 0 0 0 1 1 0", "box of size 1 1 0"},
        {PM_VERB_MKPMAP, "a.rad -api 0 0 0 1 1 nan", "-api nan"},
        {PM_VERB_MKPMAP, "a.rad -apI 0 0 0 -1", "ball of radius -1"},
        {PM_VERB_MKPMAP, "a.rad -apI 0 0 0 0", "ball of radius 0"},
        {PM_VERB_MKPMAP, "a.rad -aE /nonexistent/names", "/nonexistent/names: cannot be read"},
        {PM_VERB_MKPMAP, "a.rad -aE /dev/null", "/dev/null: names no modifier"},
        {PM_VERB_RENDER, "a.rad -apg 10q", "-apg 10q"},
        {PM_VERB_RENDER, "a.rad --time 0s", "--time 0s"},
        {PM_VERB_RENDER, "a.rad --error 200%", "--error 200%"},
        {PM_VERB_RENDER, "a.rad -ab 1.5", "-ab 1.5"},
        {PM_VERB_RENDER, "a.rad -vtx", "-vtx"},
        {PM_VERB_RTRACE, "a.rad -fc", "-fc"},
        {PM_VERB_RTRACE, "a.rad -fadd", "-fadd"},
        {PM_VERB_RTRACE, "a.rad -otV", "no ray tree"},
        {PM_VERB_RENDER, "a.rad --vf /nonexistent/view.vf", "/nonexistent/view.vf"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        pm_options options;
        pm_error err = PM_ERROR_INIT;
        char text[1200];
        assert_int_not_equal(parse(table[i].verb, table[i].line, &options, &err), PM_OK);
        pm_error_format(&err, text, sizeof text);
        if (!strstr(text, table[i].text))
            fail_msg("`%s` says: %s", table[i].line, text);
    }
}

/* The options of Radiance's manual pages that are not offered, each with what may follow it. */
static void every_option_of_radiance_is_refused_with_a_reason(void **state)
{
    (void)state;
    static const struct {
        pm_verb verb;
        const char *options;
    } table[] = {
        {PM_VERB_RPICT, "-ps -pt -pj -pm -pd -dj -ds -dt -dc -dr"},
        {PM_VERB_RPICT, "-dp -dv -dv- -ss -st -av -aw -ar -aa -ad -as -af"},
        {PM_VERB_RPICT, "-api -apI -aps -apS -ld -apo -apo+ -apo- -apo0 -apO"},
        {PM_VERB_RPICT, "-ae -ai -aE -aI -am -ac -aC -ms -i -i+ -u -u- -lr"},
        {PM_VERB_RPICT, "-lw -S -o -r -ro -z -P -PP -defaults -apd -apP -apf"},
        {PM_VERB_RTRACE, "-f -fa8 -o -oW -ov~TmW -te -ti -tE -tI -i -u"},
        {PM_VERB_TRACE, "-x -y -ff -op"},
        {PM_VERB_RTRACE, "-dj -ds -dt -dc -dr -dp -dv -ss -st -av -aw -ar -aa -ad"},
        {PM_VERB_RTRACE, "-as -af -ae -ai -aE -aI -am -ac -aC -ms -lr -lw"},
        {PM_VERB_RTRACE, "-ld -ld+ -ld- -P -PP"},
        {PM_VERB_MKPMAP, "-apC -apD -apM"},
        {PM_VERB_MKPMAP, "-defaults"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[512], *words[WORDS_MAX];
        snprintf(text, sizeof text, "%s", table[i].options);
        int count = split(text, words);
        for (int word = 0; word < count; word++) {
            pm_options options;
            pm_error err = PM_ERROR_INIT;
            assert_int_equal(pm_options_parse(table[i].verb, 1, &words[word], &options, &err),
                             PM_E_UNSUPPORTED);
            if (strstr(err.text, "unknown option") || strstr(err.text, "has no meaning"))
                fail_msg("%s", err.text);
        }
    }
}

static void long_options_take_their_value_behind_an_equals_sign(void **state)
{
    (void)state;
    pm_options options;
    assert_int_equal(parse(PM_VERB_RENDER, "a.rad --time=5m --error=2%", &options, NULL),
                     PM_OK);
    assert_true(options.seconds == 300);
    assert_true(options.error == .02);
}

static void counts_take_suffixes(void **state)
{
    (void)state;
    uint64_t count = 0;
    assert_int_equal(pm_count_parse("10k", &count), PM_OK);
    assert_int_equal(count, 10000);
    assert_int_equal(pm_count_parse("1.5M", &count), PM_OK);
    assert_int_equal(count, 1500000);
    assert_int_equal(pm_count_parse("2g", &count), PM_OK);
    assert_int_equal(count, 2000000000);
    static const char *const wrong[] = {"", "k", "-1", "1kk", "1x", "0.5", "nan", "1e30"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(pm_count_parse(wrong[i], &count), PM_E_RANGE);
}

static void times_and_shares_take_units(void **state)
{
    (void)state;
    double value = 0;
    assert_int_equal(pm_seconds_parse("90", &value), PM_OK);
    assert_true(value == 90);
    assert_int_equal(pm_seconds_parse("1.5m", &value), PM_OK);
    assert_true(value == 90);
    assert_int_equal(pm_seconds_parse("2h", &value), PM_OK);
    assert_true(value == 7200);
    assert_int_equal(pm_seconds_parse("2d", &value), PM_E_RANGE);
    assert_int_equal(pm_share_parse("2%", &value), PM_OK);
    assert_true(value == .02);
    assert_int_equal(pm_share_parse(".5", &value), PM_OK);
    assert_true(value == .5);
    assert_int_equal(pm_share_parse("0", &value), PM_E_RANGE);
    assert_int_equal(pm_share_parse("2 %", &value), PM_E_RANGE);
}

static void files_of_modifiers_are_read_as_the_options_themselves(void **state)
{
    (void)state;
    char path[] = "/tmp/pm_names_XXXXXX", line[256];
    static const char words[] = "  wall floor\n\n\tceiling\r\n";
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, words, sizeof words - 1), sizeof words - 1);
    close(file);
    pm_options options;
    snprintf(line, sizeof line, "a.rad -apg f 1k -ae door -aE %s -apS %s", path, path);
    assert_int_equal(parse(PM_VERB_MKPMAP, line, &options, NULL), PM_OK);
    assert_int_equal(options.exclude.count, 4);
    assert_string_equal(options.exclude.names[0], "door");
    assert_string_equal(options.exclude.names[1], "wall");
    assert_string_equal(options.exclude.names[3], "ceiling");
    assert_int_equal(options.sensors.count, 3);
    assert_int_equal(options.include.count, 0);
    pm_options_clear(&options);
    /* beside it: the folder comes from RAYPATH */
    setenv("RAYPATH", "/nonexistent:/tmp", 1);
    snprintf(line, sizeof line, "a.rad -apg f 1k -aI %s", path + strlen("/tmp/"));
    assert_int_equal(parse(PM_VERB_MKPMAP, line, &options, NULL), PM_OK);
    assert_int_equal(options.include.count, 3);
    pm_options_clear(&options);
    unsetenv("RAYPATH");
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accepted_options_change_the_request),
        cmocka_unit_test(ambient_bounces_default_as_each_verb_promises),
        cmocka_unit_test(refused_options_say_why),
        cmocka_unit_test(every_option_of_radiance_is_refused_with_a_reason),
        cmocka_unit_test(files_of_modifiers_are_read_as_the_options_themselves),
        cmocka_unit_test(long_options_take_their_value_behind_an_equals_sign),
        cmocka_unit_test(counts_take_suffixes),
        cmocka_unit_test(times_and_shares_take_units),
    };
    return cmocka_run_group_tests_name("client.options", tests, NULL, NULL);
}
