#include "file_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static pm_status unreadable(const char *name, pm_error *err)
{
    return pm_error_set_at(err, PM_E_IO, name, 0, 0, "cannot be read: %s", strerror(errno));
}

pm_status pm_file_bytes_map(pm_file_bytes *file, int descriptor, const char *name,
                            pm_error *err)
{
    struct stat about;
    if (fstat(descriptor, &about))
        return unreadable(name, err);
    if (!S_ISREG(about.st_mode))
        return pm_error_set_at(err, PM_E_IO, name, 0, 0, "is no regular file");
    pm_file_bytes result = {.data = "", .size = (size_t)about.st_size};
    if (result.size)
        result.data = mmap(NULL, result.size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (result.data == MAP_FAILED)
        return unreadable(name, err);
    *file = result;
    return PM_OK;
}

pm_status pm_file_bytes_open(pm_file_bytes *file, const char *path, pm_error *err)
{
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return unreadable(path, err);
    pm_status st = pm_file_bytes_map(file, descriptor, path, err);
    close(descriptor);
    return st;
}

void pm_file_bytes_close(pm_file_bytes *file)
{
    if (file->size)
        munmap((void *)(uintptr_t)file->data, file->size);
    *file = (pm_file_bytes){0};
}
