#ifndef PM_SCENE_TRANSFORM_H
#define PM_SCENE_TRANSFORM_H

#include <stdbool.h>

#include "base/vec3.h"

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

pm_transform pm_transform_inverse(const pm_transform *transform);

/* Turned and scaled, as differences of points are. */
static inline pm_vec3 pm_transform_vector(const pm_transform *t, pm_vec3 v)
{
    return (pm_vec3){v.x * t->turn[0][0] + v.y * t->turn[1][0] + v.z * t->turn[2][0],
                     v.x * t->turn[0][1] + v.y * t->turn[1][1] + v.z * t->turn[2][1],
                     v.x * t->turn[0][2] + v.y * t->turn[1][2] + v.z * t->turn[2][2]};
}

static inline pm_vec3 pm_transform_point(const pm_transform *t, pm_vec3 p)
{
    pm_vec3 q = pm_transform_vector(t, p);
    return (pm_vec3){q.x + t->shift[0], q.y + t->shift[1], q.z + t->shift[2]};
}

#endif
