#include "world/cube.h"

#include <math.h>

/* Beyond these the squares of lengths leave the range of doubles on their way back to the
 * scene's units. */
#define SMALLEST 0x1p-500
#define LARGEST  0x1p+500

/* The coarsest tolerance to work with: surfaces a 4096th of the scene apart are told apart. */
#define COARSEST 0x1p-12

static double corner_of(double low, double step)
{
    return floor(low / step) * step;
}

static bool fits(const struct pm_body *body, double edge, pm_vec3 *corner)
{
    double step = edge / 4;
    *corner = pm_vec3_make(corner_of(body->low.x, step), corner_of(body->low.y, step),
                           corner_of(body->low.z, step));
    return corner->x + edge >= body->high.x && corner->y + edge >= body->high.y &&
           corner->z + edge >= body->high.z;
}

static pm_status set_cube(struct pm_body *body, pm_error *err)
{
    pm_vec3 size = pm_vec3_sub(body->high, body->low), corner;
    double most = fmax(size.x, fmax(size.y, size.z));
    if (!(most >= SMALLEST && most <= LARGEST))
        return pm_error_set(err, PM_E_RANGE,
                            "the scene is %g units wide; between %g and %g can be handled",
                            most, SMALLEST, LARGEST);
    int exponent;
    double edge = frexp(most, &exponent) == .5 ? most : ldexp(1, exponent);
    while (!fits(body, edge, &corner))
        edge *= 2;
    body->scale = edge / 2;
    body->center = pm_vec3_add(corner, pm_vec3_make(edge / 2, edge / 2, edge / 2));
    return PM_OK;
}

/* Numbers of the scene are rounded to 2^-53 of their size, and a few times more by its
 * transforms; 2^-46 covers the rounding of our own arithmetic within the cube. */
static pm_status set_tolerance(struct pm_body *body, pm_error *err)
{
    pm_vec3 c = body->center;
    double far = fmax(fabs(c.x), fmax(fabs(c.y), fabs(c.z))) / body->scale;
    body->tolerance = 0x1p-46 + 0x1p-50 * far;
    if (body->tolerance <= COARSEST)
        return PM_OK;
    return pm_error_set(
        err, PM_E_RANGE,
        "the scene lies %g times its size away from the origin, where its numbers "
        "hold no detail; move it nearer",
        far / 2);
}

pm_status pm_cube_choose(struct pm_body *body, pm_error *err)
{
    if (body->low.x <= body->high.x) {
        pm_status status = set_cube(body, err);
        return status ? status : set_tolerance(body, err);
    }
    body->low = body->high = pm_vec3_make(0, 0, 0);
    body->scale = 1;
    return set_tolerance(body, err);
}
