#ifndef PM_BASE_ERROR_H
#define PM_BASE_ERROR_H

#include <stddef.h>

#include "base/status.h"

/* What went wrong and where. The first error wins: setting an error that is set changes
 * nothing. Text says what is wrong and what would be right. */
typedef struct pm_error {
    pm_status status;
    int line;   /* from 1; 0 where no place is known */
    int column; /* from 1 */
    char file[256];
    char text[768];
} pm_error;

#define PM_ERROR_INIT                                                                          \
    {                                                                                          \
        .status = PM_OK                                                                        \
    }

/* Both return `status`, so that a caller can write `return pm_error_set(err, PM_E_..., ...)`.
 * `err` may be NULL. */
pm_status pm_error_set(pm_error *err, pm_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
pm_status pm_error_set_at(pm_error *err, pm_status status, const char *file, int line,
                          int column, const char *format, ...)
    __attribute__((format(printf, 6, 7)));

/* Writes `FILE:LINE:COLUMN: text`, or `FILE: text`, or the bare text. Always terminates. */
void pm_error_format(const pm_error *err, char *out, size_t size);

/* One word for a status, e.g. "syntax"; for logs and problem documents. */
const char *pm_status_name(pm_status status);

#endif
