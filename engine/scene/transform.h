#ifndef PM_SCENE_TRANSFORM_H
#define PM_SCENE_TRANSFORM_H

#include <stdbool.h>

/* p -> p * turn + shift, with row vectors; `turn` is a rotation times `scale`, mirrored or not.
 */
typedef struct pm_transform {
    double turn[3][3], shift[3];
    double scale; /* of lengths, > 0 */
    bool mirrored;
} pm_transform;

pm_transform pm_transform_identity(void);

/* First `a`, then `b`. */
pm_transform pm_transform_then(const pm_transform *a, const pm_transform *b);

#endif
