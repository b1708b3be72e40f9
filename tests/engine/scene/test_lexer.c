#include "scene_test.h"

#include <stdlib.h>

#include "base/rng.h"
#include "scene/lexer.h"

static pm_lexer lexer_of(const char *text)
{
    pm_lexer lexer;
    const pm_file file = {.name = "a.rad", .data = (const uint8_t *)text, .size = strlen(text)};
    assert_int_equal(pm_lexer_init(&lexer, &file, NULL), PM_OK);
    return lexer;
}

static pm_word word_of(const char *text)
{
    return (pm_word){.text = text, .length = strlen(text), .line = 1, .column = 1};
}

static void assert_word(pm_lexer *lexer, const char *text, int line, int column)
{
    pm_word word;
    assert_int_equal(pm_lexer_word(lexer, &word, NULL), PM_OK);
    assert_true(pm_word_is(&word, text));
    assert_int_equal(word.line, line);
    assert_int_equal(word.column, column);
}

static void words_carry_their_line_and_column(void **state)
{
    (void)state;
    pm_lexer lexer = lexer_of("void  plastic\r\n\n\tred\f0 \v-1");
    pm_word end;
    assert_word(&lexer, "void", 1, 1);
    assert_word(&lexer, "plastic", 1, 7);
    assert_word(&lexer, "red", 3, 2);
    assert_word(&lexer, "0", 3, 6);
    assert_word(&lexer, "-1", 3, 9);
    assert_int_equal(pm_lexer_word(&lexer, &end, NULL), PM_OK);
    assert_null(end.text);
    assert_int_equal(end.line, 3);
    assert_int_equal(end.column, 11);
}

static void quotes_hold_blanks_and_the_other_quote(void **state)
{
    (void)state;
    pm_lexer lexer = lexer_of("\"big ball\" 'a\"b' \"\" it's \"x\"y");
    assert_word(&lexer, "big ball", 1, 1);
    assert_word(&lexer, "a\"b", 1, 12);
    assert_word(&lexer, "", 1, 18);
    assert_word(&lexer, "it's", 1, 21); /* only a leading quote counts (fgetword.c) */
    assert_word(&lexer, "x", 1, 26);
    assert_word(&lexer, "y", 1, 29);
}

static void byte_order_mark_takes_no_column(void **state)
{
    (void)state;
    pm_lexer lexer = lexer_of("\xEF\xBB\xBFvoid");
    assert_word(&lexer, "void", 1, 1);
}

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void assert_real(const char *text)
{
    double value;
    pm_word word = word_of(text);
    assert_int_equal(pm_word_real(&word, &value), PM_NUMBER_OK);
    if (bits_of(value) != bits_of(strtod(text, NULL)))
        fail_msg("%s reads as %.17g, not %.17g", text, value, strtod(text, NULL));
}

/* 200,000 texts with 1 to 22 digits and exponents about the limits of the fast path. */
static void real_words_round_as_the_c_library(void **state)
{
    (void)state;
    pm_rng rng;
    pm_rng_init(&rng, 7, PM_RNG_PATH, 0);
    for (int i = 0; i < 200000; i++) {
        char text[64];
        int at = 0, digits = 1 + (int)(pm_rng_u32(&rng) % 22);
        int point = (int)(pm_rng_u32(&rng) % 24);
        if (pm_rng_u32(&rng) & 1)
            text[at++] = '-';
        text[at++] = (char)('1' + pm_rng_u32(&rng) % 9); /* -0 is another test */
        for (int d = 1; d < digits; d++) {
            if (d == point)
                text[at++] = '.';
            text[at++] = (char)('0' + pm_rng_u32(&rng) % 10);
        }
        text[at] = '\0';
        if (pm_rng_u32(&rng) & 1)
            snprintf(text + at, sizeof text - (size_t)at, "e%d",
                     (int)(pm_rng_u32(&rng) % 80) - 40);
        assert_real(text);
    }
}

static void reals_at_the_limits_are_read(void **state)
{
    (void)state;
    static const char *const texts[] = {"0",
                                        ".5",
                                        "5.",
                                        "+3",
                                        "1e0",
                                        "1E+5",
                                        "9007199254740993",
                                        "1e22",
                                        "1e23",
                                        "1e-22",
                                        "1e-23",
                                        "1.7976931348623157e308",
                                        "2.2250738585072014e-308",
                                        "4.9406564584124654e-324",
                                        "1e-400",
                                        "0e999999999999",
                                        "00000000000000000000000000001",
                                        "0.1000000000000000055511151231257827"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        assert_real(texts[i]);
}

static void minus_zero_is_zero(void **state)
{
    (void)state;
    static const char *const texts[] = {"-0", "-0.0", "-0e5", "-0.0000000000000000000000",
                                        "-1e-400"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        double value = 1;
        pm_word word = word_of(texts[i]);
        assert_int_equal(pm_word_real(&word, &value), PM_NUMBER_OK);
        assert_int_equal(bits_of(value), 0);
    }
}

static void what_is_no_real_is_refused(void **state)
{
    (void)state;
    static const char *const malformed[] = {
        "",    "-",  "+",   ".",   "-.",  "e5",  "1e",  "1e+",      "1e5.", "1.2.3",
        "--1", "1 ", "0x1", "nan", "inf", "1,5", "1d5", "infinity", "1e 5", "1_000"};
    for (size_t i = 0; i < sizeof malformed / sizeof *malformed; i++) {
        double value = 42;
        pm_word word = word_of(malformed[i]);
        assert_int_equal(pm_word_real(&word, &value), PM_NUMBER_MALFORMED);
        assert_true(value == 42);
    }
    static const char *const huge[] = {"1e309", "-1e309", "1.8e308", "1e999999999999999999999"};
    for (size_t i = 0; i < sizeof huge / sizeof *huge; i++) {
        double value = 42;
        pm_word word = word_of(huge[i]);
        assert_int_equal(pm_word_real(&word, &value), PM_NUMBER_HUGE);
        assert_true(value == 42);
    }
}

static void integers_are_digits_alone(void **state)
{
    (void)state;
    int64_t value;
    pm_word word = word_of("-120");
    assert_int_equal(pm_word_integer(&word, &value), PM_NUMBER_OK);
    assert_int_equal(value, -120);
    word = word_of("99999999999999999");
    assert_int_equal(pm_word_integer(&word, &value), PM_NUMBER_OK);
    assert_int_equal(value, 99999999999999999);
    word = word_of("9999999999999999999999");
    assert_int_equal(pm_word_integer(&word, &value), PM_NUMBER_HUGE);
    static const char *const malformed[] = {"", "1.0", "1e2", "x", "1x", "-"};
    for (size_t i = 0; i < sizeof malformed / sizeof *malformed; i++) {
        word = word_of(malformed[i]);
        assert_int_equal(pm_word_integer(&word, &value), PM_NUMBER_MALFORMED);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_carry_their_line_and_column),
        cmocka_unit_test(quotes_hold_blanks_and_the_other_quote),
        cmocka_unit_test(byte_order_mark_takes_no_column),
        cmocka_unit_test(real_words_round_as_the_c_library),
        cmocka_unit_test(reals_at_the_limits_are_read),
        cmocka_unit_test(minus_zero_is_zero),
        cmocka_unit_test(what_is_no_real_is_refused),
        cmocka_unit_test(integers_are_digits_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
