#ifndef PM_CLIENT_MAP_SOURCE_H
#define PM_CLIENT_MAP_SOURCE_H

#include "file_bytes.h"
#include "options.h"
#include "photons/photon_map.h"
#include "session.h"

/* A photon map to look into: a file, or one that the server keeps. Photons are read a part at a
 * time, so it may be larger than memory. */
typedef struct pm_map_source {
    const pm_options *options;
    pm_session *session; /* opened when the first key comes */
    const char *name;
    pm_file_bytes file;
} pm_map_source;

/* Opens the next map, in place of the one before: `name` is a file, or, if there is none of
 * that name, the key of a map at the server. */
PM_MUST_USE pm_status pm_map_source_open(pm_map_source *source, const char *name,
                                         pm_error *err);
/* Reads it from its start, as pm_map_file_visit does. */
PM_MUST_USE pm_status pm_map_source_visit(const pm_map_source *source,
                                          const pm_map_visitor *visitor, char **command,
                                          pm_error *err);
void pm_map_source_close(pm_map_source *source);

#endif
