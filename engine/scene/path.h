#ifndef PM_SCENE_PATH_H
#define PM_SCENE_PATH_H

#include <stdbool.h>

/* Names of a bundle's files: relative, parts joined by '/', none of them "." or "..". */

enum { PM_PATH_SIZE = 256 };

/* Writes the name that `name` has when written in the file `from` (NULL: at the top) in normal
 * form. False for an absolute or empty name, one that leaves the top, one that is too long, and
 * control characters. Test: names_are_normalised. */
bool pm_path_join(const char *from, const char *name, char out[PM_PATH_SIZE]);

#endif
