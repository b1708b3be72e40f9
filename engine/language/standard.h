#ifndef PM_LANGUAGE_STANDARD_H
#define PM_LANGUAGE_STANDARD_H

#include <stddef.h>

/* The files of engine/language/standard, as embed.cmake writes them; ends with a NULL name. */
struct pm_standard_file {
    const char *name, *text;
    size_t size;
};

extern const struct pm_standard_file pm_standard_files[];

#endif
