#ifndef PM_WORLD_LIGHT_AIM_H
#define PM_WORLD_LIGHT_AIM_H

#include "world/light.h"
#include "world/targets.h"

/* Emission towards targets, with unaimed emission beside it.
 *
 * A share of the photons leaves as by pm_light_emit, the others for the targets: the light by
 * what it sends there, the place as ever, the target by the light that it gets from that place,
 * the direction evenly within the cone that the target fills; of distant sources the direction
 * as ever and the place evenly over the disc that the target shows. Weights are the balance
 * heuristic over both ways (Veach and Guibas, "Optimally combining sampling techniques",
 * SIGGRAPH 1995), so that the mean is that of unaimed light. */
typedef struct pm_light_aim pm_light_aim;

/* Borrows world and targets. Depends on the scene alone. PM_E_MEMORY. */
PM_MUST_USE pm_status pm_light_aim_new(const pm_world *world, const pm_targets *targets,
                                       double unaimed, pm_light_aim **out, pm_error *err);
/* The same for some lamps alone, each of which aims that share of its photons.
 *   lamps  in and out, [lights]: which; those from which no light leaves for the targets, or
 *          most of it, are taken out */
PM_MUST_USE pm_status pm_light_aim_lamps(const pm_world *world, const pm_targets *targets,
                                         double unaimed, bool *lamps, pm_light_aim **out,
                                         pm_error *err);
void pm_light_aim_free(pm_light_aim *aim);

/* An estimate of the share of all light that leaves for the targets. */
double pm_light_aim_share(const pm_light_aim *aim);

/* As pm_light_emit; u[0] tells aimed from unaimed photons first, u[3] also picks the target.
 *   common  out: flux of an unaimed photon that flies elsewhere over this one's: what roulette
 *           may restore; 1 if there is no target
 * Test: aimed_light_equals_unaimed_light. */
bool pm_light_emit_aimed(const pm_light_aim *aim, const double u[5], pm_emission *out,
                         double *common);

/* As pm_light_emit, with an aim of pm_light_aim_lamps: other lights, and the choice of lights,
 * stay as they are. Tests: test_lamps.c. */
bool pm_light_emit_lamps(const pm_light_aim *aim, const double u[5], pm_emission *out);

#endif
