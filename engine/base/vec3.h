#ifndef PM_BASE_VEC3_H
#define PM_BASE_VEC3_H

#include <math.h>

/* A point or a direction. */
typedef struct pm_vec3 {
    double x, y, z;
} pm_vec3;

static inline pm_vec3 pm_vec3_make(double x, double y, double z)
{
    return (pm_vec3){x, y, z};
}

static inline pm_vec3 pm_vec3_add(pm_vec3 a, pm_vec3 b)
{
    return (pm_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline pm_vec3 pm_vec3_sub(pm_vec3 a, pm_vec3 b)
{
    return (pm_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline pm_vec3 pm_vec3_scale(pm_vec3 a, double s)
{
    return (pm_vec3){a.x * s, a.y * s, a.z * s};
}

/* a + s b */
static inline pm_vec3 pm_vec3_madd(pm_vec3 a, double s, pm_vec3 b)
{
    return (pm_vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline pm_vec3 pm_vec3_negate(pm_vec3 a)
{
    return (pm_vec3){-a.x, -a.y, -a.z};
}

static inline double pm_vec3_dot(pm_vec3 a, pm_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline pm_vec3 pm_vec3_cross(pm_vec3 a, pm_vec3 b)
{
    return (pm_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double pm_vec3_length(pm_vec3 a)
{
    return sqrt(pm_vec3_dot(a, a));
}

/* The unit vector along `a`; zero for zero. */
static inline pm_vec3 pm_vec3_normalize(pm_vec3 a)
{
    double length = pm_vec3_length(a);
    return length > 0 ? pm_vec3_scale(a, 1 / length) : (pm_vec3){0, 0, 0};
}

static inline double pm_vec3_distance(pm_vec3 a, pm_vec3 b)
{
    return pm_vec3_length(pm_vec3_sub(a, b));
}

/* The mirror image of the outgoing direction `w` about the unit normal `n`; both point away. */
static inline pm_vec3 pm_vec3_reflect(pm_vec3 w, pm_vec3 n)
{
    return pm_vec3_sub(pm_vec3_scale(n, 2 * pm_vec3_dot(w, n)), w);
}

/* The lesser and the greater of each coordinate; inline, as fmin and fmax are not. */
static inline pm_vec3 pm_vec3_min(pm_vec3 a, pm_vec3 b)
{
    return (pm_vec3){a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z};
}

static inline pm_vec3 pm_vec3_max(pm_vec3 a, pm_vec3 b)
{
    return (pm_vec3){a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z};
}

static inline int pm_vec3_finite(pm_vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

#endif
