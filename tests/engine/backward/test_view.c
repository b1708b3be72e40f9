/* Views: Radiance's spellings in, the same view out. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "backward/view.h"

static void assert_view_equal(const pm_view *a, const pm_view *b)
{
    const double x[] = {a->point.x,     a->point.y,     a->point.z,  a->direction.x,
                        a->direction.y, a->direction.z, a->up.x,     a->up.y,
                        a->up.z,        a->horizontal,  a->vertical, (double)a->type,
                        a->shift,       a->lift,        a->fore,     a->aft};
    const double y[] = {b->point.x,     b->point.y,     b->point.z,  b->direction.x,
                        b->direction.y, b->direction.z, b->up.x,     b->up.y,
                        b->up.z,        b->horizontal,  b->vertical, (double)b->type,
                        b->shift,       b->lift,        b->fore,     b->aft};
    for (size_t i = 0; i < sizeof x / sizeof *x; i++)
        assert_true(x[i] == y[i]);
}

static pm_view parsed(const char *text)
{
    pm_view view = pm_view_default();
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_view_parse(text, "a.vf", &view, &err), PM_OK);
    return view;
}

static void all_spellings_of_one_view_are_read(void **state)
{
    (void)state;
    const pm_view want = {.point = {0, 1, -4},
                          .direction = {0, 0, 1},
                          .up = {0, 1, 0},
                          .horizontal = 40,
                          .vertical = 30};
    static const char *const texts[] = {
        "rvu -vtv -vp 0 1 -4 -vd 0 0 1 -vu 0 1 0 -vh 40 -vv 30\n",
        "VIEW= -vtv -vp 0 1 -4 -vd 0 0 1 -vu 0 1 0 -vh 40 -vv 30 -vo 0 -va 0 -vs 0 -vl 0",
        "VIEW=-vp 0 1 -4 -vd 0 0 1 -vu 0 1 0 -vh 40 -vv 30",
        "-vp 0 1 -4 -vd 0 0 1 -vu 0 1 0 -vh 4e1 -vv 30",
        "/usr/bin/rpict\t-vp 0 1 -4  -vd 0 0 1 -vu 0 1 0 -vh 40.0 -vv 30\r\n",
        "# a comment\n\nrvu -vp 9 9 9 -vh 3\nrpict -vp 0 1 -4 -vd 0 0 1 -vu 0 1 0 -vh 40 -vv "
        "30\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        pm_view view = parsed(texts[i]);
        assert_view_equal(&view, &want);
    }
}

/* viewfile() in Radiance's image.c reads every view line over the same view. */
static void later_lines_change_only_what_they_name(void **state)
{
    (void)state;
    pm_view view = parsed("rvu -vp 1 2 3 -vh 10\nrvu -vp 4 5 6\n");
    assert_true(view.point.x == 4 && view.point.y == 5 && view.point.z == 6);
    assert_true(view.horizontal == 10);
}

static void formatted_views_read_back_equal(void **state)
{
    (void)state;
    const pm_view view = {.point = {0.1, -1.0 / 3, 1e300},
                          .direction = {5e-324, 123456.789012345678, -0.3},
                          .up = {1e-9, 2.0 / 7, 1},
                          .horizontal = 44.99999999999999,
                          .vertical = 179.5};
    char text[PM_VIEW_TEXT];
    pm_view_format(&view, text);
    pm_view again = parsed(text);
    assert_view_equal(&view, &again);
    pm_view plain = pm_view_default();
    pm_view_format(&plain, text);
    assert_string_equal(text, "-vtv -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 45 -vv 45");
    for (int type = 0; type < PM_VIEW_TYPES; type++) {
        pm_view rare = view;
        rare.type = (pm_view_type)type;
        rare.shift = -.1;
        rare.lift = 1.0 / 3;
        rare.fore = 1e-300;
        rare.aft = 1.7976931348623157e308;
        pm_view_format(&rare, text);
        again = parsed(text);
        assert_view_equal(&rare, &again);
    }
}

static void wrong_views_are_refused_with_their_place(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        pm_status status;
        int line, column;
    } cases[] = {
        {"", PM_E_SYNTAX, 1, 1},
        {"rvu\n", PM_E_SYNTAX, 1, 1},
        {"rvu -vt", PM_E_SYNTAX, 1, 5},
        {"rvu -vtx", PM_E_SYNTAX, 1, 5},
        {"rvu -vtvl", PM_E_SYNTAX, 1, 5},
        {"rvu -vs", PM_E_SYNTAX, 1, 8},
        {"rvu -vp 0 1", PM_E_SYNTAX, 1, 12},
        {"rvu -vp 0 1 x", PM_E_SYNTAX, 1, 13},
        {"rvu -vp 0 1 nan", PM_E_SYNTAX, 1, 13},
        {"rvu -vp 0 1 0x10", PM_E_SYNTAX, 1, 13},
        {"rvu -vp 0 1 1e999", PM_E_RANGE, 1, 13},
        {"rvu -vp 0 1 1-2", PM_E_SYNTAX, 1, 13},
        {"rvu -vp 0 0 0\nrvu  -ab 3", PM_E_SYNTAX, 2, 6},
        {"rvu -vp 0 0 0\nmodels are not views", PM_E_SYNTAX, 2, 1},
        {"rvu -vp 0 0 0 -vhh 3", PM_E_SYNTAX, 1, 15},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const pm_view before = {.horizontal = 7, .up = {1, 2, 3}};
        pm_view view = before;
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_view_parse(cases[i].text, "bad.vf", &view, &err), cases[i].status);
        assert_view_equal(&view, &before);
        assert_string_equal(err.file, "bad.vf");
        assert_int_equal(err.line, cases[i].line);
        assert_int_equal(err.column, cases[i].column);
    }
}

static void views_that_show_nothing_are_refused(void **state)
{
    (void)state;
    pm_view good = pm_view_default();
    assert_int_equal(pm_view_check(&good, NULL), PM_OK);
    pm_view bad[8];
    for (int i = 0; i < 8; i++)
        bad[i] = good;
    bad[0].direction = (pm_vec3){0, 0, 0};
    bad[1].up = (pm_vec3){0, 0, 0};
    bad[2].up = (pm_vec3){0, -3, 0};
    bad[3].horizontal = 0;
    bad[4].vertical = 180;
    bad[5].horizontal = -1;
    bad[6].point.x = (double)NAN;
    bad[7].vertical = (double)NAN;
    for (int i = 0; i < 8; i++) {
        pm_error err = PM_ERROR_INIT;
        assert_int_equal(pm_view_check(&bad[i], &err), PM_E_RANGE);
        assert_true(strlen(err.text) > 0);
    }
}

/* What each type's projection bears. */
static void sizes_are_bounded_by_the_type(void **state)
{
    (void)state;
    static const double greatest[PM_VIEW_TYPES][2] = {{179.9, 179.9}, {1e9, 1e9}, {180, 180},
                                                      {360, 179.9},   {360, 360}, {359, 359}};
    static const double beyond[PM_VIEW_TYPES][2] = {{180, 180},   {0, -1},      {180.1, 180.1},
                                                    {360.1, 180}, {360.1, 361}, {360, 360}};
    for (int type = 0; type < PM_VIEW_TYPES; type++) {
        pm_view view = pm_view_default();
        view.type = (pm_view_type)type;
        view.horizontal = greatest[type][0];
        view.vertical = greatest[type][1];
        assert_int_equal(pm_view_check(&view, NULL), PM_OK);
        view.horizontal = beyond[type][0];
        assert_int_equal(pm_view_check(&view, NULL), PM_E_RANGE);
        view.horizontal = 10;
        view.vertical = beyond[type][1];
        assert_int_equal(pm_view_check(&view, NULL), PM_E_RANGE);
    }
}

static void clipping_that_leaves_nothing_is_refused(void **state)
{
    (void)state;
    pm_view view = pm_view_default();
    view.fore = 1;
    view.aft = 2;
    assert_int_equal(pm_view_check(&view, NULL), PM_OK);
    view.aft = 1;
    assert_int_equal(pm_view_check(&view, NULL), PM_E_RANGE);
    view.aft = 0;
    view.fore = -1;
    assert_int_equal(pm_view_check(&view, NULL), PM_E_RANGE);
}

/* Lengths do not matter, not even those whose squares overflow or vanish. */
static void direction_and_up_may_have_any_length(void **state)
{
    (void)state;
    pm_view view = pm_view_default();
    view.direction = (pm_vec3){0, 1e300, 0};
    view.up = (pm_vec3){0, 0, 1e-300};
    assert_int_equal(pm_view_check(&view, NULL), PM_OK);
}

/* tan(vv/2) / tan(vh/2) = height / width; normaspect() rounds to nearest. */
static void fitted_pictures_have_square_pixels(void **state)
{
    (void)state;
    pm_view view = pm_view_default();
    uint32_t x = 512, y = 512;
    pm_view_fit(&view, 1, &x, &y);
    assert_true(x == 512 && y == 512);
    view.horizontal = 90; /* tangents 1 and sqrt(1/3): aspect .57735 */
    view.vertical = 60;
    pm_view_fit(&view, 1, &x, &y);
    assert_true(x == 512 && y == 296); /* 295.6 */
    view.horizontal = 60;
    view.vertical = 90;
    x = y = 512;
    pm_view_fit(&view, 1, &x, &y);
    assert_true(x == 296 && y == 512);
    view.vertical = 1e-3;
    x = y = 4;
    pm_view_fit(&view, 1, &x, &y);
    assert_true(x == 4 && y == 1);
}

/* -pa 2: pixels twice as high as wide; 0: the shape is as asked. */
static void pixels_have_the_aspect_asked(void **state)
{
    (void)state;
    pm_view view = pm_view_default();
    uint32_t x = 512, y = 512;
    pm_view_fit(&view, 2, &x, &y);
    assert_true(x == 512 && y == 256);
    y = 100;
    pm_view_fit(&view, 0, &x, &y);
    assert_true(x == 512 && y == 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_spellings_of_one_view_are_read),
        cmocka_unit_test(later_lines_change_only_what_they_name),
        cmocka_unit_test(formatted_views_read_back_equal),
        cmocka_unit_test(wrong_views_are_refused_with_their_place),
        cmocka_unit_test(views_that_show_nothing_are_refused),
        cmocka_unit_test(sizes_are_bounded_by_the_type),
        cmocka_unit_test(clipping_that_leaves_nothing_is_refused),
        cmocka_unit_test(pixels_have_the_aspect_asked),
        cmocka_unit_test(direction_and_up_may_have_any_length),
        cmocka_unit_test(fitted_pictures_have_square_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
