#ifndef PM_PHOTONS_RANKED_H
#define PM_PHOTONS_RANKED_H

#include "photons/search.h"

/* The photons that a search for the nearest found, by distance. */
typedef struct pm_ranked {
    uint32_t count;
    uint32_t index[PM_GATHER_MAX];       /* in the map */
    double distance2[PM_GATHER_MAX + 1]; /* [grid units^2]; at `count` that of the next one */
} pm_ranked;

/* Sorts at most PM_GATHER_MAX candidates; equal distances end in an order that depends on the
 * candidates alone. `next2` is the squared distance of the photon behind them. Takes a few
 * steps a photon unless very many lie in a thin shell. Test: ranked_photons_ascend. */
void pm_ranked_sort(const pm_candidates *candidates, double next2, pm_ranked *out);

#endif
