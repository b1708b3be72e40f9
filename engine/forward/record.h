#ifndef PM_FORWARD_RECORD_H
#define PM_FORWARD_RECORD_H

#include "base/rng.h"
#include "forward/path.h"

/* Stores one deposit in the maps whose bits are set in `kinds`. `draws` is a stream of its own
 * for this deposit, of which map kind k takes number k: what one map stores does not depend on
 * which others are made. `photon` holds the incident flux; its replicate is filled in here. */
void pm_record_deposit(struct pm_recorder *recorder, unsigned kinds, pm_photon_record *photon,
                       const pm_rng *draws);

#endif
