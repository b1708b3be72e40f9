#ifndef PM_CLIENT_FILE_BYTES_H
#define PM_CLIENT_FILE_BYTES_H

#include <stddef.h>

#include "base/error.h"

/* A whole file, mapped read-only. */
typedef struct pm_file_bytes {
    const void *data;
    size_t size;
} pm_file_bytes;

PM_MUST_USE pm_status pm_file_bytes_open(pm_file_bytes *file, const char *path, pm_error *err);
/* The same of an open file, which may be closed then. `name` is for messages. */
PM_MUST_USE pm_status pm_file_bytes_map(pm_file_bytes *file, int descriptor, const char *name,
                                        pm_error *err);
void pm_file_bytes_close(pm_file_bytes *file);

#endif
