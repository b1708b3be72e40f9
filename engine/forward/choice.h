#ifndef PM_FORWARD_CHOICE_H
#define PM_FORWARD_CHOICE_H

#include "base/error.h"
#include "forward/options.h"
#include "world/selection.h"

/* What the options choose in a world: names become surfaces, lengths world units. */
struct pm_choice {
    pm_selection ports[2]; /* that emit to their front; to their back */
    bool filters;          /* some deposits are not stored */
    pm_selection sensors;  /* store what comes to their front */
    pm_selection exclude;  /* store nothing */
    pm_selection include;  /* these alone store */
    pm_region *regions;    /* [region_count] in world coordinates, low < high */
    size_t region_count;
    double max_length; /* [world] of a path; INFINITY without a bound */
    pm_digest digest;  /* of all options that change photons, whatever things are called */
};

/* Checks the options, then looks up what they name. PM_E_RANGE, PM_E_MISSING, PM_E_MEMORY.
 * Test: test_choice.c. */
PM_MUST_USE pm_status pm_choice_make(const pm_world *world, const pm_forward_options *options,
                                     struct pm_choice *out, pm_error *err);
void pm_choice_clear(struct pm_choice *choice);

/* Whether a photon that lands on the surface at that point is stored. PM_NO_PRIMITIVE: in a
 * medium, where regions alone count. */
bool pm_choice_stores(const struct pm_choice *choice, const pm_world *world, uint32_t surface,
                      pm_vec3 point);

#endif
