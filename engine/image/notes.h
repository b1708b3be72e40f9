#ifndef PM_IMAGE_NOTES_H
#define PM_IMAGE_NOTES_H

#include <stdbool.h>

#include "image/image.h"

/* What the three writers share. */

/* A copy of `text` with control characters turned to spaces, to be freed; NULL if memory is
 * short. */
char *pm_image_note_text(const char *text);

/* Calls `put` with each note, the view and the command under their names, until it fails. */
PM_MUST_USE pm_status pm_image_notes_each(const pm_image_notes *notes,
                                          pm_status (*put)(void *context, const char *name,
                                                           const char *value),
                                          void *context);

/* PM_E_RANGE with the place of the first pixel that is not finite or, unless allowed, negative.
 */
PM_MUST_USE pm_status pm_image_check(const pm_image *image, bool negative_allowed,
                                     pm_error *err);

#endif
