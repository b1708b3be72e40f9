#include "language/standard.h"

#include <string.h>

#include "language/language.h"

const char *pm_language_standard(const char *name, size_t *size)
{
    for (const struct pm_standard_file *file = pm_standard_files; file->name; file++)
        if (strcmp(file->name, name) == 0) {
            *size = file->size;
            return file->text;
        }
    return NULL;
}
