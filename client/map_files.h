#ifndef PM_CLIENT_MAP_FILES_H
#define PM_CLIENT_MAP_FILES_H

#include "job_request.h"
#include "session.h"

/* Uploads the map files that rpict's and rtrace's options name, -ap's by the kind that the file
 * says it is. */
PM_MUST_USE pm_status pm_map_files_attach(pm_session *session, const pm_options *options,
                                          pm_attachments *attachments, pm_error *err);

/* The file that was given as the map of a kind, by whichever option; NULL: none. */
const char *pm_map_files_name(const pm_options *options, pm_map_kind kind);

#endif
