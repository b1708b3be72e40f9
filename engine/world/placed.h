#ifndef PM_WORLD_PLACED_H
#define PM_WORLD_PLACED_H

#include "world/world.h"

/* Points of any surface of the world, wherever instances place it. */

/* Area of one side [scale^2]. */
double pm_placed_area(const pm_world *world, uint32_t surface);

/* A point spread evenly by area for u, v uniform in [0, 1), and the unit front normal there.
 * Tests:
 * closed_ports_let_each_line_in_once, ports_in_instances. */
void pm_placed_sample(const pm_world *world, uint32_t surface, double u, double v,
                      pm_vec3 *point, pm_vec3 *normal);

#endif
