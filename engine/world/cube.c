#include "world/cube.h"

#include <math.h>

/* Beyond these the squares of lengths leave the range of doubles on their way back to the
 * scene's units. */
#define SMALLEST 0x1p-500
#define LARGEST  0x1p+500

/* The coarsest tolerance to work with: surfaces a 4096th of the scene apart are told apart. */
#define COARSEST 0x1p-12

static pm_status find_bounds(pm_world *world, const pm_scene *scene,
                             const struct pm_identity *identity, pm_error *err)
{
    world->low = pm_vec3_make(INFINITY, INFINITY, INFINITY);
    world->high = pm_vec3_negate(world->low);
    for (size_t i = 0; i < scene->count; i++) {
        const pm_primitive *p = &scene->primitives[i];
        if (!pm_primitive_is_surface(p->type) || p->type == PM_SOURCE)
            continue;
        pm_vec3 a, b, *low = &world->low, *high = &world->high;
        pm_status status = pm_shape_scene_bounds(scene, p, &a, &b, err);
        if (status)
            return status;
        *low = pm_vec3_make(fmin(low->x, a.x), fmin(low->y, a.y), fmin(low->z, a.z));
        *high = pm_vec3_make(fmax(high->x, b.x), fmax(high->y, b.y), fmax(high->z, b.z));
    }
    if (identity->local_count == 0)
        world->low = world->high = pm_vec3_make(0, 0, 0);
    return PM_OK;
}

static double corner_of(double low, double step)
{
    return floor(low / step) * step;
}

static bool fits(const pm_world *world, double edge, pm_vec3 *corner)
{
    double step = edge / 4;
    *corner = pm_vec3_make(corner_of(world->low.x, step), corner_of(world->low.y, step),
                           corner_of(world->low.z, step));
    return corner->x + edge >= world->high.x && corner->y + edge >= world->high.y &&
           corner->z + edge >= world->high.z;
}

static pm_status set_cube(pm_world *world, pm_error *err)
{
    pm_vec3 size = pm_vec3_sub(world->high, world->low), corner;
    double most = fmax(size.x, fmax(size.y, size.z));
    if (!(most >= SMALLEST && most <= LARGEST))
        return pm_error_set(err, PM_E_RANGE,
                            "the scene is %g units wide; between %g and %g can be handled",
                            most, SMALLEST, LARGEST);
    int exponent;
    double edge = frexp(most, &exponent) == .5 ? most : ldexp(1, exponent);
    while (!fits(world, edge, &corner))
        edge *= 2;
    world->scale = edge / 2;
    world->center = pm_vec3_add(corner, pm_vec3_make(edge / 2, edge / 2, edge / 2));
    return PM_OK;
}

/* Numbers of the scene are rounded to 2^-53 of their size, and a few times more by its
 * transforms; 2^-46 covers the rounding of our own arithmetic within the cube. */
static pm_status set_tolerance(pm_world *world, pm_error *err)
{
    pm_vec3 c = world->center;
    double far = fmax(fabs(c.x), fmax(fabs(c.y), fabs(c.z))) / world->scale;
    world->tolerance = 0x1p-46 + 0x1p-50 * far;
    if (world->tolerance <= COARSEST)
        return PM_OK;
    return pm_error_set(
        err, PM_E_RANGE,
        "the scene lies %g times its size away from the origin, where its numbers "
        "hold no detail; move it nearer",
        far / 2);
}

pm_status pm_cube_choose(pm_world *world, const pm_scene *scene,
                         const struct pm_identity *identity, pm_error *err)
{
    pm_status status = find_bounds(world, scene, identity, err);
    if (status)
        return status;
    if (identity->local_count == 0)
        world->scale = 1;
    else
        status = set_cube(world, err);
    return status ? status : set_tolerance(world, err);
}
