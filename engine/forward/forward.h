#ifndef PM_FORWARD_FORWARD_H
#define PM_FORWARD_FORWARD_H

#include <stdbool.h>
#include <stdint.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/pool.h"
#include "forward/options.h"
#include "forward/photon.h"
#include "world/world.h"

/* The forward pass: photons from the lights to where they land.
 *
 * In: world and canonical parameters. Out: batches of photons. Next: photons/photon_map.h.
 *
 * Path i depends on (seed, i) and the world alone: emission takes Owen-scrambled Sobol points
 * (replicate b mod 16, its own sequence), everything after it Philox numbers. Caustic photons
 * have paths of their own, which are aimed (aim.h). So the same bytes
 * come out for any number of threads and in any order of batches. */

/* What is fixed for one world and one set of options, with the storage probabilities from a
 * pre-run of 2^14 paths (at most 4 photons a path and kind on average). Borrows the world,
 * which must outlive it. Nothing of the options is borrowed. PM_E_RANGE for one that is out of
 * range, PM_E_MISSING for a name that no surface has. */
typedef struct pm_forward pm_forward;

PM_MUST_USE pm_status pm_forward_new(const pm_world *world, const pm_forward_options *options,
                                     pm_pool *pool, pm_forward **out, pm_error *err);
void pm_forward_free(pm_forward *forward);

/* SHA-256 over (octree hash, kind, canonical options, format version, ray kernel). A family
 * owns batches; the number of photons wanted is no part of it. */
pm_digest pm_forward_family(const pm_forward *forward, pm_map_kind kind);

/* Photons a path of that kind that the pre-run found (after the storage probability). */
double pm_forward_rate(const pm_forward *forward, pm_map_kind kind);

/* Straight stretches of a path of that kind's, on average, by the pre-run: the same whatever a
 * store has. */
double pm_forward_stretches(const pm_forward *forward, pm_map_kind kind);

/* The scale of the packed fluxes of every batch of this forward pass [W / scale^2]. */
double pm_forward_flux_scale(const pm_forward *forward);

/* Power of the lights into the scene [W / scale^2]; with ports what enters through them, by the
 * pre-run, and the lamps'. */
pm_rgb pm_forward_emitted(const pm_forward *forward);

/* What a user should know about where its photons come from; "" for nothing. */
const char *pm_forward_note(const pm_forward *forward);

/* Probability with which a deposit is stored; stored fluxes are divided by it already. */
double pm_forward_storage_probability(const pm_forward *forward, pm_map_kind kind);

/* Traces one batch of PM_BATCH_PATHS paths and stores the kinds whose bit (1 << kind) is set in
 * `kinds`; out[kind] of the others is left alone. What is stored of a kind does not depend on
 * the other bits. `cancelled` (may be NULL) is asked between pieces, by the calling thread
 * alone: PM_E_CANCELLED. PM_E_RANGE from batch 2^20 on, where the Sobol sequences end. Tests:
 * forward_bytes_equal_for_1_2_and_7_threads, kinds_do_not_depend_on_each_other. */
PM_MUST_USE pm_status pm_forward_batch(const pm_forward *forward, uint64_t index,
                                       unsigned kinds, pm_pool *pool, bool (*cancelled)(void *),
                                       void *context, pm_batch out[PM_MAP_KINDS],
                                       pm_error *err);

/* Cuts a batch down to its first `paths` paths (needs `ends`). The flux balance is cleared. */
void pm_batch_truncate(pm_batch *batch, uint32_t paths);

/* Keeps each photon with that probability, steps of 2^-32, so that their fluxes are to be taken
 * over it; needs `ends`. The draws are told by seed, path and place within the path. Test:
 * thinning_keeps_a_share_of_each_paths_photons. */
void pm_batch_thin(pm_batch *batch, uint64_t seed, double probability);

/* Checks photons and flux for non-finite numbers met while tracing since pm_forward_new; 0 in a
 * healthy run, and a test fails otherwise. */
uint64_t pm_forward_nonfinite(const pm_forward *forward);

/* Straight stretches of paths traced since pm_forward_new, those of the pre-run included; for
 * benchmarks. */
uint64_t pm_forward_rays(const pm_forward *forward);

#endif
