#ifndef PM_WORLD_CUBE_H
#define PM_WORLD_CUBE_H

#include "world/body.h"

/* Sets body->center, scale and tolerance from its bounds: the smallest cube whose edge is a
 * power of two and whose corner is a multiple of a quarter of it, so that a small edit seldom
 * moves it. Where low is above high: [-1, 1]^3.
 * Errors: PM_E_RANGE if the sizes or the distance from the origin leave no digits to work with.
 */
PM_MUST_USE pm_status pm_cube_choose(struct pm_body *body, pm_error *err);

#endif
