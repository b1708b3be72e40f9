#include "file_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

pm_status pm_file_bytes_open(pm_file_bytes *file, const char *path, pm_error *err)
{
    struct stat about;
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0 || fstat(descriptor, &about)) {
        pm_status st =
            pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be read: %s", strerror(errno));
        if (descriptor >= 0)
            close(descriptor);
        return st;
    }
    pm_file_bytes result = {.data = "", .size = (size_t)about.st_size};
    bool mapped = false;
    if (S_ISREG(about.st_mode) && about.st_size > 0) {
        result.data = mmap(NULL, result.size, PROT_READ, MAP_PRIVATE, descriptor, 0);
        mapped = result.data != MAP_FAILED;
    }
    close(descriptor);
    if (!S_ISREG(about.st_mode))
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "is no regular file");
    if (about.st_size > 0 && !mapped)
        return pm_error_set_at(err, PM_E_IO, path, 0, 0, "cannot be read: %s", strerror(errno));
    *file = result;
    return PM_OK;
}

void pm_file_bytes_close(pm_file_bytes *file)
{
    if (file->size)
        munmap((void *)(uintptr_t)file->data, file->size);
    *file = (pm_file_bytes){0};
}
