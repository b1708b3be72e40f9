#include "columns.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *pm_number_format_name(char format)
{
    switch (format) {
    case 'f':
        return "float";
    case 'd':
        return "double";
    case 'c':
        return "32-bit_rle_rgbe";
    default:
        return "ascii";
    }
}

/* ---- points ---- */

enum { POINT_NUMBERS = 6 };

/* False at the end of the input; *got bytes of a point were there. */
static bool read_point(FILE *from, char format, double numbers[POINT_NUMBERS], size_t *got)
{
    float single[POINT_NUMBERS];
    if (format == 'd') {
        *got = fread(numbers, 1, sizeof(double) * POINT_NUMBERS, from);
        return *got == sizeof(double) * POINT_NUMBERS;
    }
    *got = fread(single, 1, sizeof single, from);
    for (int i = 0; i < POINT_NUMBERS && *got == sizeof single; i++)
        numbers[i] = (double)single[i];
    return *got == sizeof single;
}

static pm_status read_numbers(FILE *from, char format, pm_bytes *text, pm_error *err)
{
    double n[POINT_NUMBERS];
    size_t got;
    unsigned long long count = 0;
    while (read_point(from, format, n, &got)) {
        count++;
        pm_bytes_format(text, "%.17g %.17g %.17g %.17g %.17g %.17g\n", n[0], n[1], n[2], n[3],
                        n[4], n[5]);
    }
    if (got)
        return pm_error_set_at(err, PM_E_SYNTAX, "standard input", 0, 0,
                               "ends within point %llu; a point is six numbers of %zu bytes",
                               count + 1, format == 'd' ? sizeof(double) : sizeof(float));
    return PM_OK;
}

static void read_text(FILE *from, pm_bytes *text)
{
    char buffer[1 << 16];
    for (size_t got; (got = fread(buffer, 1, sizeof buffer, from)) > 0;)
        pm_bytes_append(text, buffer, got);
}

pm_status pm_points_read(FILE *from, char format, pm_bytes *text, pm_error *err)
{
    pm_status st = PM_OK;
    if (format == 'a')
        read_text(from, text);
    else
        st = read_numbers(from, format, text, err);
    if (ferror(from))
        return pm_error_set_at(err, PM_E_IO, "standard input", 0, 0, "cannot be read: %s",
                               strerror(errno));
    if (!st && pm_bytes_status(text))
        return pm_error_set(err, PM_E_MEMORY, "no memory for the points of stdin");
    return st;
}

/* ---- values ---- */

/* A line of the answer on its way out. */
struct line {
    const pm_options *options;
    char *rest; /* of the line, for strtok_r */
    FILE *to;
    bool started;
};

static const char *next_column(struct line *line)
{
    return strtok_r(NULL, "\t", &line->rest);
}

static void print_text(struct line *line, const char *text)
{
    bool radiance = line->options->verb == PM_VERB_RTRACE;
    fprintf(line->to, "%s%s%s", line->started && !radiance ? " " : "", text,
            radiance ? "\t" : "");
    line->started = true;
}

static void print_number(struct line *line, double value)
{
    char text[32];
    float single = (float)value;
    switch (line->options->output_format) {
    case 'f':
        fwrite(&single, sizeof single, 1, line->to);
        break;
    case 'd':
        fwrite(&value, sizeof value, 1, line->to);
        break;
    default:
        snprintf(text, sizeof text, line->options->verb == PM_VERB_RTRACE ? "%e" : "%.9g",
                 value);
        print_text(line, text);
    }
}

/* Radiance's pixel: mantissas of 8 bits and their exponent, truncated as its readers expect
 * (setcolr() in src/common/color.c). */
static void print_pixel(struct line *line, const double rgb[3])
{
    uint8_t pixel[4] = {0};
    int exponent;
    double largest = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    if (largest > 1e-32) {
        double scale = frexp(largest, &exponent) * 256 / largest;
        for (int i = 0; i < 3; i++)
            pixel[i] = (uint8_t)(fmax(rgb[i], 0) * scale);
        pixel[3] = (uint8_t)(exponent + 128);
    }
    fwrite(pixel, 1, sizeof pixel, line->to);
}

static void print_value(struct line *line, const double values[6])
{
    if (line->options->output_format == 'c') {
        print_pixel(line, values);
        return;
    }
    for (unsigned i = 0; i < (line->options->errors ? 6 : 3); i++)
        print_number(line, values[i]);
}

static bool is_word(char field)
{
    return strchr("smM", field);
}

static int columns_of(char field)
{
    return strchr("odpnN", field) ? 3 : field == 'c' ? 2 : 1;
}

int pm_values_numbers(const pm_options *options)
{
    int numbers = 0;
    for (const char *field = options->fields; *field; field++)
        numbers += *field == 'v'     ? options->errors ? 6 : 3
                   : is_word(*field) ? 0
                                     : columns_of(*field);
    return numbers;
}

/* False if the server's line ends early. */
static bool print_field(struct line *line, char field)
{
    for (int i = 0; i < columns_of(field); i++) {
        const char *column = next_column(line);
        if (!column)
            return false;
        if (is_word(field))
            print_text(line, column);
        else
            print_number(line, strtod(column, NULL));
    }
    return true;
}

static bool print_line(struct line *line, char *text)
{
    double values[6];
    bool whole = true;
    line->started = false;
    for (int i = 0; i < 6 && whole; i++) {
        const char *column = strtok_r(i ? NULL : text, "\t", &line->rest);
        whole = column;
        values[i] = whole ? strtod(column, NULL) : 0;
    }
    for (const char *field = line->options->fields; *field && whole; field++) {
        if (*field == 'v')
            print_value(line, values);
        else
            whole = print_field(line, *field);
    }
    if (line->options->output_format == 'a')
        putc('\n', line->to);
    return whole;
}

pm_status pm_values_check(const pm_options *options, const pm_bytes *text, pm_error *err)
{
    uint64_t lines = 0, pixels = (uint64_t)options->x * options->y;
    for (size_t i = 0; i < text->size; i++)
        lines += text->data[i] == '\n';
    if (!pixels || lines == pixels)
        return PM_OK;
    return pm_error_set(
        err, PM_E_RANGE, "-x %u -y %u: a picture of %llu values, but there are %llu points",
        options->x, options->y, (unsigned long long)pixels, (unsigned long long)lines);
}

pm_status pm_values_print(const pm_options *options, pm_bytes *text, FILE *to, pm_error *err)
{
    struct line line = {.options = options, .to = to};
    char *rest = NULL;
    bool whole = true;
    pm_bytes_u8(text, 0);
    if (pm_bytes_status(text))
        return pm_error_set(err, PM_E_MEMORY, "no memory for the values");
    for (char *at = strtok_r((char *)text->data, "\n", &rest); at && whole;
         at = strtok_r(NULL, "\n", &rest))
        whole = print_line(&line, at);
    return whole ? PM_OK
                 : pm_error_set(err, PM_E_CORRUPT, "the server's answer is no list of values");
}
