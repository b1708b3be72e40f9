#include "scene/path.h"

#include <stddef.h>
#include <string.h>

/* Appends one part of a path to `out`, whose length is *length. */
static bool add_part(const char *part, size_t size, char *out, size_t *length)
{
    if (size == 0 || (size == 1 && part[0] == '.'))
        return true;
    if (size == 2 && part[0] == '.' && part[1] == '.') {
        if (*length == 0)
            return false;
        while (*length > 0 && out[--*length] != '/')
            ;
        return true;
    }
    size_t slash = *length > 0;
    if (*length + slash + size >= PM_PATH_SIZE)
        return false;
    if (slash)
        out[(*length)++] = '/';
    memcpy(out + *length, part, size);
    *length += size;
    return true;
}

static bool add_parts(const char *path, size_t size, char *out, size_t *length)
{
    size_t start = 0;
    for (size_t i = 0; i <= size; i++) {
        if (i < size && path[i] != '/')
            continue;
        if (!add_part(path + start, i - start, out, length))
            return false;
        start = i + 1;
    }
    return true;
}

bool pm_path_join(const char *from, const char *name, char out[PM_PATH_SIZE])
{
    size_t length = 0, size = strlen(name);
    const char *folder_end = from ? strrchr(from, '/') : NULL;
    if (size == 0 || name[0] == '/' || name[size - 1] == '/')
        return false;
    for (size_t i = 0; i < size; i++)
        if ((unsigned char)name[i] < ' ' || name[i] == 0x7F)
            return false;
    if (folder_end && !add_parts(from, (size_t)(folder_end - from), out, &length))
        return false;
    if (!add_parts(name, size, out, &length) || length == 0)
        return false;
    out[length] = '\0';
    return true;
}
