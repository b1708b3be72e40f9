#ifndef PM_BASE_NUMBER_H
#define PM_BASE_NUMBER_H

#include <stddef.h>
#include <stdint.h>

/* Decimal numbers as words of a file, which need not be terminated. */
typedef enum pm_number {
    PM_NUMBER_OK,
    PM_NUMBER_MALFORMED,
    PM_NUMBER_HUGE, /* larger than a double or an int64 holds */
} pm_number;

/* [+-] digits, and for a real also . digits and e[+-]digits as in Radiance's isflt (words.c):
 * no hexadecimal, nan or inf. Rounds to nearest, whatever the locale. Test: test_lexer.c,
 * real_words_round_as_the_c_library. */
pm_number pm_number_real(const char *text, size_t length, double *value);
pm_number pm_number_integer(const char *text, size_t length, int64_t *value);

#endif
