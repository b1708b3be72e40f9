#ifndef PM_SERVER_REQUEST_FORWARD_H
#define PM_SERVER_REQUEST_FORWARD_H

#include "base/arena.h"
#include "base/error.h"
#include "forward/options.h"
#include "json.h"
#include "surround.h"

/* The members of a job that say how photons are traced and stored. `json` was checked against
 * the table of fields, and lends its texts; lists lie in the arena. The error's `file` is the
 * member. */
PM_MUST_USE pm_status pm_request_read_forward(const pm_json *json, pm_arena *arena,
                                              pm_forward_options *out, pm_error *err);

/* What they say about all of the scene. */
PM_MUST_USE pm_status pm_request_read_surroundings(const pm_json *json, pm_surroundings *out,
                                                   pm_error *err);

#endif
