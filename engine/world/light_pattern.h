#ifndef PM_WORLD_LIGHT_PATTERN_H
#define PM_WORLD_LIGHT_PATTERN_H

#include "world/light_table.h"
#include "world/world_internal.h"

/* Lights whose radiance is colour times pattern: where and whither to send their photons. The
 * tables follow the pattern at a bounded number of places and directions; weights are exact. */

struct pm_light;

/* NULL or without a table: drawn evenly, or by the cosine. */
struct pm_light_pattern {
    /* Distant sources: towards the source. Flat lamps and balls: of the light, for a typical
     * place (flat: times the cosine). */
    struct pm_light_beam beam;
    const struct pm_light_table *places; /* over pm_shape_sample's square; not for balls */
};

/* Tables and power of a patterned light.
 *   evaluations  of the pattern, about; few: no tables
 *   power        out: [W / scale^2], for distant sources onto the scene's bounding disc
 * Errors: PM_E_MEMORY. */
PM_MUST_USE pm_status pm_light_pattern_build(pm_world *world, struct pm_light *light,
                                             size_t evaluations, pm_rgb *power, pm_error *err);

/* A place on a lamp and a direction that its light takes. */
struct pm_light_draw {
    pm_hit hit; /* the place, as a ray from afar would meet it */
    pm_vec3 direction;
    double
        weight; /* cosine over density [scale^2 sr]: the mean of radiance * weight is power */
};

/* u[0..1] draw the place, u[2..3] the direction. */
void pm_light_draw_leaving(const pm_world *world, const struct pm_light *light,
                           const double u[4], struct pm_light_draw *out);

/* A place of a lamp, patterned or not, and the area that it stands for: one over its density.
 */
pm_hit pm_light_draw_place(const pm_world *world, const struct pm_light *light, double u,
                           double v, double *area);

/* A direction that a distant source, plain or not, covers, from the scene to it.
 *   solid_angle  out: that it stands for: one over its density [sr] */
pm_vec3 pm_light_draw_distant(const pm_world *world, const struct pm_light *light, double u,
                              double v, double *solid_angle);

#endif
