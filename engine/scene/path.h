#ifndef PM_SCENE_PATH_H
#define PM_SCENE_PATH_H

#include <stdbool.h>
#include <stddef.h>

/* Names of a bundle's files: relative, parts joined by '/', none of them "." or "..". The
 * folder above the top is called "^", the one above that "^/^", and the root "^root": so scenes
 * may name `../lib/chair.rad` and `/usr/share/sky.cal`, and nothing leaves the bundle. */

enum { PM_PATH_SIZE = 256 };

/* Writes the name that `name` has when written in the file `from` (NULL: at the top) in normal
 * form. False for a folder, an empty name, one that is too long, and control characters.
 * Test: names_are_normalised. */
bool pm_path_join(const char *from, const char *name, char out[PM_PATH_SIZE]);

/* False for a name in normal form that climbs above the top. */
bool pm_path_is_inside(const char *name);

/* The path on a disk of a name in normal form, if the top is `folder`. False if it is longer
 * than `size` allows. */
bool pm_path_in_folder(const char *folder, const char *name, char *out, size_t size);

#endif
