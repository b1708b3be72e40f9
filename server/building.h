#ifndef PM_SERVER_BUILDING_H
#define PM_SERVER_BUILDING_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/digest.h"

/* Which job is making the batches of which family now, so that two jobs that need the same ones
 * make them once. */
typedef struct pm_building pm_building;

pm_building *pm_building_new(void); /* NULL if memory is short */
void pm_building_free(pm_building *building);

/* Takes the family for `job`, waiting while another job has it. Gives up waiting when *stop is
 * set (call pm_building_wake after setting it), and does not wait where that could never end: a
 * job that goes on without the family makes the same bytes again, which is harmless. True if it
 * waited for another job. */
bool pm_building_begin(pm_building *building, const pm_digest *family, int64_t job,
                       const atomic_bool *stop);
void pm_building_end(pm_building *building, const pm_digest *family, int64_t job);
void pm_building_end_all(pm_building *building, int64_t job); /* the job is over */
void pm_building_wake(pm_building *building);
unsigned pm_building_waiting(pm_building *building); /* jobs that wait now */

#endif
