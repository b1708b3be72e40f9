#ifndef PM_WORLD_PORTS_H
#define PM_WORLD_PORTS_H

#include "world/lamps.h"
#include "world/light.h"
#include "world/media.h"
#include "world/selection.h"

/* Photon ports: surfaces through which alone light of distant sources enters the scene.
 *
 * A line of light belongs to the first port that it crosses on an allowed side, and enters
 * there if nothing but straight passage lies before: so each line counts once, however many
 * ports it crosses, and panes, mists and roofs in front of a port take what they take. (Light
 * that is refracted or scattered before it comes to a port does not enter.) From the port on
 * the path is any other: it meets the port's own material first, and may leave and come back.
 *
 * A photon is drawn by port and source, patch of the port, place in the patch, and direction.
 * Broad sources are drawn from a table of directions as the ports see them, narrow ones by
 * themselves. Tables and patches follow what obstructs; they steer alone: weights are exact.
 * Local lamps shine as ever, in proportion of power, or are aimed (lamps.h).
 *
 * In: a world, the surfaces chosen. Next: forward/path.c. */
typedef struct pm_ports pm_ports;

typedef struct pm_ports_options {
    const pm_selection *sides[2]; /* that let light go along their normal; against it */
    double direction_resolution;  /* directions a steradian of the tables */
    double partition;             /* size of patches relative to the scene's cube */
} pm_ports_options;

/* *out is NULL if no surface is chosen, or if there is no distant light. Borrows the world and
 * the selections. PM_E_LIMIT for more than 2^22 surfaces, PM_E_MEMORY. */
PM_MUST_USE pm_status pm_ports_new(const pm_world *world, const pm_ports_options *options,
                                   pm_ports **out, pm_error *err);
/* From then on lamps shine by pm_lamps_emit; borrows them. */
void pm_ports_aim_lamps(pm_ports *ports, const pm_lamps *lamps);

void pm_ports_free(pm_ports *ports);

/* A photon on its way. */
typedef struct pm_port_entry {
    pm_emission emission; /* black: nothing comes that way */
    bool enters;          /* through a port, at `hit` where it meets that surface */
    pm_hit hit;
    pm_media media; /* before it */
} pm_port_entry;

/* As pm_light_emit: u[0] picks lamp or port and source, u[1..2] the place, u[3..4] the
 * direction. The mean flux is the light that enters, with what lamps emit. False if there is
 * none. Tests: test_ports.c, tests/physics/test_ports.c. */
bool pm_ports_emit(const pm_ports *ports, const double u[5], pm_port_entry *out);

#endif
