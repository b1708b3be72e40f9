#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "files/font.h"

/* A: a bar from 64 to 192, three quarters high; B: a narrow square with a hole, joined by a
 * seam; a blank; C wide. Mean width (128 + 100 + 250) / 3 = 159. */
static const char font_text[] = "65 4  64 0  192 0  192 192  64 192  # A\n"
                                "66 10  100 50 200 50 200 150 100 150 100 50\n"
                                "   125 75 125 125 175 125 175 75 125 75\n"
                                "32 0\n"
                                "67 4 5 10 255 10 255 250 5 250\n";

static pm_font *read_font(void)
{
    pm_error err = PM_ERROR_INIT;
    pm_font *font = NULL;
    if (pm_font_read(font_text, strlen(font_text), "f.fnt", &font, &err))
        fail_msg("%s", err.text);
    return font;
}

static pm_arena arena;

static const pm_text *set(const pm_font *font, const char *text, const double *spacing)
{
    pm_error err = PM_ERROR_INIT;
    const pm_text *set_text = NULL;
    if (pm_text_new(font, text, strlen(text), spacing, &arena, &set_text, &err))
        fail_msg("%s", err.text);
    return set_text;
}

static void refuses(const char *text, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_font *font = NULL;
    char said[1200];
    pm_status st = pm_font_read(text, strlen(text), "f.fnt", &font, &err);
    assert_true(st && st == err.status);
    assert_null(font);
    pm_error_format(&err, said, sizeof said);
    assert_string_equal(said, message);
}

/* Characters are 255 wide and high; the line's top is at 0. */
static void uniform_text_has_one_cell_a_character(void **state)
{
    (void)state;
    pm_font *font = read_font();
    const pm_text *text = set(font, "AB\nC", NULL);
    assert_true(pm_text_holds(text, 100. / 255, 1 - 100. / 255));
    assert_false(pm_text_holds(text, 50. / 255, 1 - 100. / 255));
    assert_false(pm_text_holds(text, 100. / 255, 1 - 200. / 255)); /* above the bar */
    assert_true(pm_text_holds(text, 1 + 110. / 255, 1 - 60. / 255));
    assert_false(pm_text_holds(text, 1 + 150. / 255, 1 - 100. / 255)); /* the hole */
    assert_true(pm_text_holds(text, 0.5, 1.5));
    assert_false(pm_text_holds(text, 1.5, 1.5)); /* right of the second line */
    assert_false(pm_text_holds(text, 0.5, 2.5));
    assert_false(pm_text_holds(text, -0.5, 0.5));
    assert_false(pm_text_holds(text, 0.5, -0.5));
    assert_false(pm_text_holds(text, NAN, 0.5));
    assert_false(pm_text_holds(text, 0.5, NAN));
    assert_false(pm_text_holds(text, INFINITY, 0.5));
    pm_font_free(font);
    pm_arena_clear(&arena);
}

/* Gap 0.4 * 255 = 102, half 51 on each side: A's left edge 64 comes to 51, B's 100 to 51 + 128
 * + 102. One unit of `right` is mean width + 102 = 261. */
static void squeezed_text_stands_close(void **state)
{
    (void)state;
    pm_font *font = read_font();
    const double spacing = -0.4;
    const pm_text *text = set(font, "AB", &spacing);
    double down = 1 - 60. / 255;
    assert_false(pm_text_holds(text, 101.9 / 261, down));
    assert_true(pm_text_holds(text, 102.1 / 261, down));
    assert_true(pm_text_holds(text, 229.9 / 261, down));
    assert_false(pm_text_holds(text, 230.1 / 261, down));
    assert_false(pm_text_holds(text, 331.9 / 261, down));
    assert_true(pm_text_holds(text, 332.1 / 261, down));
    assert_true(pm_text_holds(text, 431.9 / 261, down));
    assert_false(pm_text_holds(text, 432.1 / 261, down));
    pm_font_free(font);
    pm_arena_clear(&arena);
}

/* Gap 102: after four blanks the last glyph starts 5 cells of 159 + 102 after the first, which
 * starts 102 less its left edge into the line (font.c); its ink 64 later. */
static void proportional_text_aligns_columns(void **state)
{
    (void)state;
    pm_font *font = read_font();
    const double spacing = 0.4;
    const pm_text *text = set(font, "A    A\nB    A", &spacing);
    int first[2] = {0, 0};
    for (int row = 0; row < 2; row++)
        for (int i = 3 * 261; i < 9 * 261 && !first[row]; i++)
            if (pm_text_holds(text, (i + .5) / 261, row + 1 - 100. / 255))
                first[row] = i;
    assert_int_equal(first[0], 102 - 64 + 5 * 261 + 64);
    assert_int_equal(first[1], 102 - 100 + 5 * 261 + 64);
    pm_font_free(font);
    pm_arena_clear(&arena);
}

static void odd_texts_are_set(void **state)
{
    (void)state;
    pm_font *font = read_font();
    static const char *const texts[] = {"", "\n", "\n\nA\n", "xyz", "x A y", "    ", "A\r\n"};
    static const double spacings[] = {-1000, -0.1, 0, 0.001, 0.3, 1000};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        for (size_t k = 0; k < sizeof spacings / sizeof *spacings; k++) {
            const pm_text *text = set(font, texts[i], &spacings[k]);
            for (double x = 0; x < 9; x += 0.5)
                (void)pm_text_holds(text, x, 0.5);
        }
    char longest[600];
    memset(longest, 'A', sizeof longest);
    const pm_text *text = NULL;
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_text_new(font, longest, 512, NULL, &arena, &text, &err), PM_E_LIMIT);
    assert_string_equal(err.text, "a line of text has 512 characters; 511 are allowed");
    err = (pm_error)PM_ERROR_INIT;
    assert_int_equal(pm_text_new(font, "A", 1, (double[]){1001}, &arena, &text, &err),
                     PM_E_RANGE);
    assert_string_equal(err.text, "spacing 1001 is not from -1000 to 1000");
    assert_null(text);
    pm_font_free(font);
    pm_arena_clear(&arena);
}

static double share_of_ink(const pm_font *font, char c)
{
    enum { STEPS = 128 };
    const char line[2] = {c, '\0'};
    const pm_text *text = set(font, line, NULL);
    int ink = 0;
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS; k++)
            ink += pm_text_holds(text, (i + .5) / STEPS, (k + .5) / STEPS);
    return ink / (double)(STEPS * STEPS);
}

/* A bar of a pen of radius 20 from x = 50 to 200 at the grid's middle, and a ring of radii 60
 * +- 20: areas 150 * 40 + pi 400 and pi (80^2 - 40^2) of 255^2. 24 chords lie at most (1 -
 * cos 7.5 deg) 60 = 0.5 inside the circle, the raster is 2 wide: 3 percent is a bound. */
static void strokes_are_as_wide_as_their_pen(void **state)
{
    (void)state;
    static const char strokes[] = "strokes 20\n65 1 2 50 128 200 128\n"
                                  "66 1 0 128 128 60 60 0 360\n32 0\n";
    pm_error err = PM_ERROR_INIT;
    pm_font *font = NULL;
    assert_int_equal(pm_font_read(strokes, strlen(strokes), "s.fnt", &font, &err), PM_OK);
    double bar = (150 * 40 + 3.14159265 * 400) / (255. * 255);
    double ring = 3.14159265 * (80 * 80 - 40 * 40) / (255. * 255);
    assert_true(fabs(share_of_ink(font, 'A') / bar - 1) < 0.03);
    assert_true(fabs(share_of_ink(font, 'B') / ring - 1) < 0.03);
    assert_true(share_of_ink(font, ' ') == 0);
    pm_font_free(font);
    pm_arena_clear(&arena);
}

static void the_standard_font_has_every_printable_character(void **state)
{
    (void)state;
    size_t size = 0;
    pm_error err = PM_ERROR_INIT;
    pm_font *font = NULL;
    const char *bytes = pm_font_standard("helvet.fnt", &size);
    assert_int_equal(pm_font_read(bytes, size, "helvet.fnt", &font, &err), PM_OK);
    assert_null(pm_font_standard("times.fnt", &size));
    for (char c = '!'; c <= '~'; c++) {
        double ink = share_of_ink(font, c);
        if (!(ink > 0.01 && ink < 0.4))
            fail_msg("%c has %g of its cell black", c, ink);
    }
    assert_true(share_of_ink(font, ' ') == 0);
    pm_font_free(font);
    pm_arena_clear(&arena);
}

static void fonts_say_what_is_wrong(void **state)
{
    (void)state;
    refuses("0 0", "f.fnt:1:1: a glyph's character must be a whole number from 1 to 255, not "
                   "'0'");
    refuses("65 x", "f.fnt:1:4: a glyph's number of vertices must be a whole number from 0 to "
                    "32000, not 'x'");
    refuses("65 0 65 0", "f.fnt:1:8: character 65 has two glyphs");
    refuses("65 32000 1 2", "f.fnt:1:9: the file ends before the 32000 vertices of character "
                            "65");
    refuses("65 1 1 256", "f.fnt:1:8: y of a vertex must be a whole number from 0 to 255, not "
                          "'256'");
    refuses("strokes 0", "f.fnt:1:9: the pen's radius must be a whole number from 1 to 60, not "
                         "'0'");
    refuses("strokes 9 65 1 0 1 1 1 1 0 361",
            "f.fnt:1:28: a number of an arc must be a whole number from -360 to 360, not "
            "'361'");
    refuses("65", "f.fnt:1:3: the file ends before a glyph's number of vertices");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uniform_text_has_one_cell_a_character),
        cmocka_unit_test(squeezed_text_stands_close),
        cmocka_unit_test(proportional_text_aligns_columns),
        cmocka_unit_test(odd_texts_are_set),
        cmocka_unit_test(strokes_are_as_wide_as_their_pen),
        cmocka_unit_test(the_standard_font_has_every_printable_character),
        cmocka_unit_test(fonts_say_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
