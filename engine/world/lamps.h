#ifndef PM_WORLD_LAMPS_H
#define PM_WORLD_LAMPS_H

#include "world/light.h"
#include "world/selection.h"
#include "world/targets.h"

/* Lamps that stand outside of closed rooms and shine in: street lamps, floodlights, lamps in a
 * light well. Half of the photons of each go to balls about the ports that are named, or about
 * the openings that are found by looking; the others leave as ever, all weighed by the balance
 * heuristic (light_aim.h). So no light is lost and no mean changed, and lamps inside keep
 * their photons.
 *
 * A lamp stands outside if most places half way along its rays are no inside (sight.h). To a
 * port that lets light through to one side only, it is enough that it gets some to the other
 * side of it. Depends on the scene and the ports alone. */
typedef struct pm_lamps pm_lamps;

/* *out is NULL where no lamp gains by it; more than 2^14 lights are not looked at.
 *   ports  surfaces that let light go along their normal; against it. None: openings are found
 * Borrows the world. PM_E_LIMIT for more than 2^22 surfaces, PM_E_MEMORY. */
PM_MUST_USE pm_status pm_lamps_find(const pm_world *world, const pm_selection ports[2],
                                    pm_lamps **out, pm_error *err);
void pm_lamps_free(pm_lamps *lamps);

/* As pm_light_emit, which it is if `lamps` is NULL. Tests: test_lamps.c. */
bool pm_lamps_emit(const pm_lamps *lamps, const pm_world *world, const double u[5],
                   pm_emission *out);

/* What they shine in through. */
const pm_targets *pm_lamps_openings(const pm_lamps *lamps);

/* What was found, in words. */
const char *pm_lamps_note(const pm_lamps *lamps);

#endif
