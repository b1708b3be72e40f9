#include "scene/path.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const char up[] = "^", root[] = "^root";

static bool is_part(const char *part, size_t size, const char *text)
{
    return size == strlen(text) && memcmp(part, text, size) == 0;
}

/* The last part of `out`. */
static const char *last_part(const char *out, size_t length, size_t *size)
{
    size_t start = length;
    while (start > 0 && out[start - 1] != '/')
        start--;
    *size = length - start;
    return out + start;
}

static bool append(const char *part, size_t size, char *out, size_t *length)
{
    size_t slash = *length > 0;
    if (*length + slash + size >= PM_PATH_SIZE)
        return false;
    if (slash)
        out[(*length)++] = '/';
    memcpy(out + *length, part, size);
    *length += size;
    return true;
}

static bool climb(char *out, size_t *length)
{
    size_t size;
    const char *last = last_part(out, *length, &size);
    if (size == 0 || is_part(last, size, up))
        return append(up, strlen(up), out, length);
    if (is_part(last, size, root)) /* above the root is the root */
        return true;
    *length -= size;
    *length -= *length > 0; /* its slash */
    return true;
}

/* Appends one part of a path to `out`, whose length is *length. */
static bool add_part(const char *part, size_t size, char *out, size_t *length)
{
    if (size == 0 || is_part(part, size, "."))
        return true;
    return is_part(part, size, "..") ? climb(out, length) : append(part, size, out, length);
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
    bool absolute = name[0] == '/';
    const char *folder_end = from && !absolute ? strrchr(from, '/') : NULL;
    if (size == 0 || name[size - 1] == '/')
        return false;
    for (size_t i = 0; i < size; i++)
        if ((unsigned char)name[i] < ' ' || name[i] == 0x7F)
            return false;
    if (absolute && !append(root, strlen(root), out, &length))
        return false;
    if (folder_end && !add_parts(from, (size_t)(folder_end - from), out, &length))
        return false;
    if (!add_parts(name, size, out, &length) || length == 0)
        return false;
    out[length] = '\0';
    const char *last = last_part(out, length, &size);
    return !is_part(last, size, up) && !is_part(last, size, root);
}

bool pm_path_is_inside(const char *name)
{
    return name[0] != up[0];
}

bool pm_path_in_folder(const char *folder, const char *name, char *out, size_t size)
{
    size_t length = (size_t)snprintf(out, size, "%s", folder);
    const char *at = name;
    if (strncmp(at, root, strlen(root)) == 0 && at[strlen(root)] == '/') {
        at += strlen(root) + 1;
        length = 0;
    }
    while (length < size && at[0] == up[0] && at[1] == '/') {
        length += (size_t)snprintf(out + length, size - length, "/..");
        at += 2;
    }
    return length < size &&
           length + (size_t)snprintf(out + length, size - length, "/%s", at) < size;
}
