#ifndef PM_CLIENT_NAME_FILE_H
#define PM_CLIENT_NAME_FILE_H

#include <stddef.h>

#include "base/error.h"

/* Reads words that white space parts, as in files of modifiers (-aE, -apS). A relative path is
 * also looked for in the folders of RAYPATH, as Radiance does.
 *   words  out: [most]; point into *text
 *   text   out: to be freed
 * PM_E_MISSING for no such file, PM_E_SYNTAX for one without a word, PM_E_LIMIT. */
PM_MUST_USE pm_status pm_name_file_read(const char *path, size_t most, const char **words,
                                        size_t *count, char **text, pm_error *err);

#endif
