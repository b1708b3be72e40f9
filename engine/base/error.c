#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>

static pm_status set(pm_error *err, pm_status status, const char *file, int line, int column,
                     const char *format, va_list args)
{
    if (!err || err->status)
        return status;
    err->status = status;
    err->line = line;
    err->column = column;
    snprintf(err->file, sizeof err->file, "%s", file ? file : "");
    vsnprintf(err->text, sizeof err->text, format, args);
    return status;
}

pm_status pm_error_set(pm_error *err, pm_status status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    set(err, status, NULL, 0, 0, format, args);
    va_end(args);
    return status;
}

pm_status pm_error_set_at(pm_error *err, pm_status status, const char *file, int line,
                          int column, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    set(err, status, file, line, column, format, args);
    va_end(args);
    return status;
}

void pm_error_format(const pm_error *err, char *out, size_t size)
{
    if (err->file[0] && err->line > 0)
        snprintf(out, size, "%s:%d:%d: %s", err->file, err->line, err->column, err->text);
    else if (err->file[0])
        snprintf(out, size, "%s: %s", err->file, err->text);
    else
        snprintf(out, size, "%s", err->text);
}

const char *pm_status_name(pm_status status)
{
    static const char *const names[] = {"ok",      "memory",      "io",        "syntax",
                                        "range",   "unsupported", "missing",   "mismatch",
                                        "corrupt", "limit",       "cancelled", "unreachable"};
    size_t index = (size_t)status;
    return index < sizeof names / sizeof *names ? names[index] : "unknown";
}
