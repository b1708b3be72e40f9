#ifndef PM_FORWARD_AIM_H
#define PM_FORWARD_AIM_H

#include "base/rng.h"
#include "world/light_aim.h"
#include "world/surface.h"

/* Paths of caustic maps go where specular surfaces are: from the lights, and from each diffuse
 * surface that they meet, where a second path leaves for the targets. In a room with one glass
 * ball a twentieth of the unaimed paths meets it.
 *
 * Everything is weighed by the balance heuristic over what is drawn there: so a target that is
 * missed or seen wrongly costs noise, never light. Depends on the scene alone, not on a view.
 */
typedef struct pm_aim pm_aim;

/* *out is NULL where aiming gains nothing: no specular surface, or one all around. Borrows the
 * world.
 *   ports  light enters by ports, which do not aim; diffuse surfaces alone do
 *   openings  that lamps outside shine in through; NULL: none. Light leaves for them, too
 * PM_E_MEMORY. */
PM_MUST_USE pm_status pm_aim_new(const pm_world *world, bool ports, const pm_targets *openings,
                                 pm_aim **out, pm_error *err);
void pm_aim_free(pm_aim *aim);

/* See pm_light_emit_aimed. */
bool pm_aim_emit(const pm_aim *aim, const double u[5], pm_emission *out, double *common);

/* A diffuse event, from where more paths may leave for the targets. */
typedef struct pm_aim_event {
    const pm_surface *surface;
    const pm_lobe *lobe; /* NULL: it is not plain enough, or nothing is in sight */
    pm_target_view view;
    double first;    /* density of the first path's direction by the lobe, */
    double second;   /* and of a second's */
    double value;    /* of the lobe for it */
    double seconds;  /* how many more paths leave, on average */
    double strength; /* flux that roulette may restore here, over that of an unaimed path */
} pm_aim_event;

/* Sets all but `seconds`. `scatter` is how the first path leaves. */
void pm_aim_look(const pm_aim *aim, pm_vec3 point, const pm_surface *surface,
                 const pm_scatter *scatter, pm_aim_event *out);

/* Sets `seconds`, and says how many there are this time and what the first path keeps of its
 * flux.
 *   strength  that path's flux over that of an unaimed path
 * Test: aimed_light_equals_unaimed_light. */
unsigned pm_aim_divide(const pm_aim *aim, double strength, pm_rng *rng, pm_aim_event *event,
                       double *kept);

/* Draws the direction of one of them; false if nothing goes there.
 *   weight  out: its flux over the first path's before the division */
bool pm_aim_second(const pm_aim_event *event, pm_rng *rng, pm_vec3 *wi, double *weight);

#endif
