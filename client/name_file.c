#include "name_file.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FILE_MAX_BYTES = 1 << 20 };

/* Folders of RAYPATH, joined by ':'; the file's own path goes first. */
static FILE *open_along(const char *path)
{
    FILE *file = fopen(path, "rb");
    const char *folders = getenv("RAYPATH");
    while (!file && path[0] != '/' && folders && *folders) {
        char joined[4096];
        size_t length = strcspn(folders, ":");
        snprintf(joined, sizeof joined, "%.*s/%s", (int)length, folders, path);
        file = length ? fopen(joined, "rb") : NULL;
        folders += length;
        folders += *folders == ':';
    }
    return file;
}

static pm_status read_text(const char *path, char **out, pm_error *err)
{
    FILE *file = open_along(path);
    if (!file)
        return pm_error_set_at(err, PM_E_MISSING, path, 0, 0, "cannot be read: %s",
                               strerror(errno));
    char *text = malloc(FILE_MAX_BYTES + 1);
    size_t size = text ? fread(text, 1, FILE_MAX_BYTES, file) : 0;
    bool whole = text && !ferror(file) && fgetc(file) == EOF;
    fclose(file);
    if (whole && !memchr(text, 0, size)) {
        text[size] = '\0';
        *out = text;
        return PM_OK;
    }
    free(text);
    return pm_error_set_at(err, PM_E_SYNTAX, path, 0, 0,
                           "is no list of modifiers: words of text, at most %d bytes",
                           FILE_MAX_BYTES);
}

pm_status pm_name_file_read(const char *path, size_t most, const char **words, size_t *count,
                            char **text, pm_error *err)
{
    static const char space[] = " \t\r\n\f\v";
    char *all = NULL, *rest;
    size_t found = 0;
    pm_status st = read_text(path, &all, err);
    if (st)
        return st;
    for (char *word = strtok_r(all, space, &rest); word && !st;
         word = strtok_r(NULL, space, &rest)) {
        if (found < most)
            words[found++] = word;
        else
            st = pm_error_set_at(err, PM_E_LIMIT, path, 0, 0,
                                 "brings the modifiers of one option to more than are allowed");
    }
    if (!st && !found)
        st = pm_error_set_at(err, PM_E_SYNTAX, path, 0, 0, "names no modifier");
    if (st) {
        free(all);
        return st;
    }
    *count = found;
    *text = all;
    return PM_OK;
}
