#ifndef PM_WORLD_OPENINGS_H
#define PM_WORLD_OPENINGS_H

#include "world/lamps.h"
#include "world/light.h"
#include "world/targets.h"

/* Where distant light comes into rooms that are closed but for windows, holes or skylights,
 * found by looking.
 *
 * Inside is where nearly all lines of sight end on surfaces (what lets light through does not
 * end them). Lines that get out from there to a bright place of the sky mark an opening at the
 * place along them where that share falls. Balls about those places are aimed at with half of
 * the distant light; the other half falls on the whole scene as ever, weighed by the balance
 * heuristic (Veach and Guibas, SIGGRAPH 1995). So an opening that was missed costs noise,
 * never light, and facade and ground get theirs. Depends on the scene alone. */
typedef struct pm_openings pm_openings;

/* *out is NULL where aiming gains nothing: no distant light, no inside, no way in, or openings
 * that take up much of what the sky sees of the scene. Borrows the world. PM_E_MEMORY. */
PM_MUST_USE pm_status pm_openings_find(const pm_world *world, pm_openings **out, pm_error *err);
/* From then on lamps shine by pm_lamps_emit; borrows them. */
void pm_openings_aim_lamps(pm_openings *openings, const pm_lamps *lamps);

void pm_openings_free(pm_openings *openings);

/* Balls about the openings of closed rooms, whether the sky is bright there or not; none where
 * there is no inside or no way in. PM_E_MEMORY. Test: test_lamps.c. */
PM_MUST_USE pm_status pm_openings_to_dark(const pm_world *world, pm_targets *out,
                                          pm_error *err);

/* As pm_light_emit. Tests: openings_change_no_mean, a_closed_room_is_lit_by_its_window. */
bool pm_openings_emit(const pm_openings *openings, const double u[5], pm_emission *out);

/* What was found, in words. */
const char *pm_openings_note(const pm_openings *openings);

#endif
