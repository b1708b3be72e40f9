#ifndef PM_CLIENT_CARET_H
#define PM_CLIENT_CARET_H

#include "base/error.h"
#include "scene/bundle.h"

/* Appends to the message of an error the line of the file that it is about, and under it a
 * caret at its column; nothing if there is no such place, or no room.
 *   file    may be NULL
 *   column  in bytes, as errors have it; the caret stands under the character */
void pm_caret_append(pm_error *err, const pm_file *file, int line, int column);

#endif
