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
void pm_file_bytes_close(pm_file_bytes *file);

#endif
