#ifndef PM_FORWARD_OPTIONS_H
#define PM_FORWARD_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/vec3.h"

/* Everything that a user may choose about the forward pass, in scene units. Names are those of
 * modifiers (world/selection.h). */

/* Sides of a port from which light of distant sources enters the scene. */
enum { PM_PORT_FRONT = 1, PM_PORT_BACK = 2 };

typedef struct pm_port_option {
    const char *modifier;
    unsigned sides; /* to which photons leave: -apo+ FRONT, along the normal; -apo- BACK; -apo0
                       both; -apo alone is FRONT, as in Radiance */
} pm_port_option;

/* The most that may be asked for: a length [scene units], -dp; the least of -ds. */
#define PM_LENGTH_MAX     1e30
#define PM_DIRECTIONS_MAX 1e6
#define PM_PARTITION_MIN  1e-4

/* Where photons are stored: a box between two opposite corners, or a ball; its boundary is part
 * of it. */
typedef struct pm_region {
    bool is_ball;
    pm_vec3 low, high; /* of a box, in any order */
    pm_vec3 center;
    double radius; /* of a ball */
} pm_region;

typedef struct pm_name_list {
    const char *const *names;
    size_t count;
} pm_name_list;

typedef struct pm_forward_options {
    uint64_t seed;       /* -apr */
    uint32_t max_events; /* -apm / -lr: most scatterings of a path; from the default, 5000, on
                            those in media do not count, where roulette ends it, 2^17 of them
                            at the latest. What is left of a path at its bound counts as
                            absorbed */
    double max_length;   /* -ld: of a path; 0 = none */

    const pm_port_option *ports; /* -apo */
    size_t port_count;
    double direction_resolution; /* -dp: directions a steradian that a port's table of incident
                                    light tells apart; default 1000 */
    double partition;            /* -ds: size of a port's patches, relative to the scene's cube;
                                    default .01 */

    pm_name_list sensors;     /* -aps: surfaces that store what passes */
    pm_name_list exclude;     /* -ae: surfaces that store nothing */
    pm_name_list include;     /* -ai: these alone store; not both */
    const pm_region *regions; /* -api, -apI: photons outside all of them are not stored */
    size_t region_count;
} pm_forward_options;

/* Fills in the defaults. */
pm_forward_options pm_forward_defaults(void);

/* PM_E_RANGE for what is out of range or contradicts itself. Names are looked up later
 * (choice.h). Test: options_out_of_range_are_refused. */
PM_MUST_USE pm_status pm_forward_options_check(const pm_forward_options *options,
                                               pm_error *err);

#endif
