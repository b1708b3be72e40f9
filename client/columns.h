#ifndef PM_CLIENT_COLUMNS_H
#define PM_CLIENT_COLUMNS_H

#include <stdio.h>

#include "base/bytes.h"
#include "options.h"

/* What trace and rtrace read and print: points and values, as text or as the machine's numbers
 * (rtrace's -f). */

/* Reads points from `from` into a text of lines `x y z nx ny nz`. PM_E_SYNTAX for an input of
 * numbers that ends within a point. */
PM_MUST_USE pm_status pm_points_read(FILE *from, char format, pm_bytes *text, pm_error *err);

/* Whether there are as many lines as a picture of the size asked for has pixels. */
PM_MUST_USE pm_status pm_values_check(const pm_options *options, const pm_bytes *text,
                                      pm_error *err);

/* Numbers that a line prints. */
int pm_values_numbers(const pm_options *options);

/* Prints the server's lines: r g b and their half-widths, then a column or more for each of
 * the options' fields but v. Changes `text`. */
PM_MUST_USE pm_status pm_values_print(const pm_options *options, pm_bytes *text, FILE *to,
                                      pm_error *err);

/* "ascii", "float", "double", or Radiance's name for its pixels: for headers. */
const char *pm_number_format_name(char format);

#endif
