#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "files/data.h"

static pm_data *read_text(const char *text)
{
    pm_error err = PM_ERROR_INIT;
    pm_data *data = NULL;
    if (pm_data_read(text, strlen(text), "t.dat", &data, &err))
        fail_msg("%s", err.text);
    return data;
}

static void refuses(const char *text, const char *message)
{
    pm_error err = PM_ERROR_INIT;
    pm_data *data = NULL;
    char said[1200];
    pm_status st = pm_data_read(text, strlen(text), "t.dat", &data, &err);
    assert_true(st && st == err.status);
    assert_null(data);
    pm_error_format(&err, said, sizeof said);
    assert_string_equal(said, message);
}

static double value1(const pm_data *data, double x)
{
    return pm_data_value(data, &x);
}

static void near(double a, double b)
{
    if (!(fabs(a - b) <= 1e-12 * (1 + fabs(b))))
        fail_msg("%.17g is not %.17g", a, b);
}

static void data_between_points_is_linear(void **state)
{
    (void)state;
    pm_data *data = read_text("# rows\n1 # one\n 10 20 3\n1 2.5\n-4e0 #end");
    near(value1(data, 10), 1);
    near(value1(data, 12.5), 1.75);
    near(value1(data, 15), 2.5);
    near(value1(data, 20), -4);
    assert_int_equal(pm_data_dimensions(data), 1);
    pm_data_free(data);
}

/* At x intervals past the last point: 2 y1 - y0 at one, a third of it right beyond, then over
 * (x + 2). Before the first: 2 y0 - y1 at one, then over the distance. */
static void data_beyond_the_ends_tapers(void **state)
{
    (void)state;
    pm_data *data = read_text("1\n0 2 3\n1 2 4\n");
    near(value1(data, 3), 6);
    near(value1(data, 3 + 1e-9), 6 / (3 + 1e-9));
    near(value1(data, 5), 6. / 5);
    near(value1(data, 1e300), 6 / 1e300);
    near(value1(data, -1), 0);
    pm_data_free(data);
    data = read_text("1\n0 2 3\n5 2 4\n");
    near(value1(data, -1), 8);
    near(value1(data, -4), 2);
    near(value1(data, -INFINITY), 0);
    near(value1(data, INFINITY), 0);
    near(value1(data, NAN), 0);
    pm_data_free(data);
}

static void data_with_ordinates_is_linear_between_them(void **state)
{
    (void)state;
    pm_data *rising = read_text("1\n0 0 4  0 1 10 11\n0 1 100 50\n");
    near(value1(rising, 0.5), 0.5);
    near(value1(rising, 5.5), 50.5);
    near(value1(rising, 10), 100);
    near(value1(rising, 10.25), 87.5);
    near(value1(rising, 12), 0);
    pm_data *falling = read_text("1\n7 7 4  11 10 1 0\n50 100 1 0\n");
    for (double x = -0.9; x < 11.9; x += 0.1)
        near(value1(falling, x), value1(rising, x));
    pm_data_free(rising);
    pm_data_free(falling);
}

/* The last dimension changes fastest; a falling even dimension is one that rises, turned. */
static void data_of_more_dimensions_multiplies_weights(void **state)
{
    (void)state;
    pm_data *data = read_text("2\n0 1 2\n30 10 3\n1 2 3\n10 20 30\n");
    near(pm_data_value(data, (double[]){0, 30}), 1);
    near(pm_data_value(data, (double[]){1, 10}), 30);
    near(pm_data_value(data, (double[]){0.25, 25}), 0.75 * 1.5 + 0.25 * 15);
    near(pm_data_value(data, (double[]){2, 20}), 2 * 20 - 2);
    pm_data_free(data);
    data = read_text("5 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2\n0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1\n"
                     "0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1\n");
    near(pm_data_value(data, (double[]){0.3, 0.9, 0.1, 0.4, 0.7}), 0.7);
    pm_data_free(data);
}

static void data_says_what_is_wrong(void **state)
{
    (void)state;
    refuses("", "t.dat:1:1: the file ends before the number of dimensions");
    refuses("0\n", "t.dat:1:1: the number of dimensions must be a whole number from 1 to 5, "
                   "not '0'");
    refuses("6\n", "t.dat:1:1: the number of dimensions must be a whole number from 1 to 5, "
                   "not '6'");
    refuses("1\n0 1 1\n5\n", "t.dat:2:5: the number of points in a dimension must be a whole "
                             "number from 2 to 1073741824, not '1'");
    refuses("1\n0 1 2\n1 nan\n", "t.dat:3:3: a value must be a number, not 'nan'");
    refuses("1\n0 1 2\n1 1e999\n", "t.dat:3:3: a value is larger than a number can be");
    refuses("1\n0 1 2\n1\n", "t.dat:4:1: the file ends before a value");
    refuses("1\n0 1 9\n1\n",
            "t.dat:2:6: the dimensions announce more values than the file holds");
    refuses("1\n0 1 2\n1 2 3\n",
            "t.dat:3:5: the dimensions announce 2 values, but more follow");
    refuses("1\n0 0 3 1 2 2\n1 2 3\n",
            "t.dat:2:12: ordinates must all rise or all fall, but 2 follows 2");
    refuses("1\n0 0 3 3 2 4\n1 2 3\n",
            "t.dat:2:12: ordinates must all rise or all fall, but 4 follows 2");
    refuses("1\n-1e308 1e308 3\n1 2 3\n",
            "t.dat:2:15: a dimension from -1e+308 to 1e+308 is too wide");
    refuses("5\n0 1 1000000000\n0 1 1000000000\n0 1 1000000000\n0 1 2\n0 1 2\n1",
            "t.dat:6:6: the dimensions announce more values than the file holds");
    refuses("1\n0 0 1000000000 1 2",
            "t.dat:2:15: the file ends before its 1000000000 ordinates");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(data_between_points_is_linear),
        cmocka_unit_test(data_beyond_the_ends_tapers),
        cmocka_unit_test(data_with_ordinates_is_linear_between_them),
        cmocka_unit_test(data_of_more_dimensions_multiplies_weights),
        cmocka_unit_test(data_says_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
