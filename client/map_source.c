#include "map_source.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Into a file that has no name, so that it goes with us. */
static pm_status fetch_kept(pm_map_source *source, const char *key, FILE *file, pm_error *err)
{
    char url[512];
    snprintf(url, sizeof url, "/v1/maps/%s/photons", key);
    pm_status st =
        source->session ? PM_OK : pm_session_open(source->options, &source->session, err);
    if (!st)
        st = pm_session_receive(source->session, url, file, err);
    if (!st && fflush(file))
        st = pm_error_set(err, PM_E_IO, "a temporary file: %s", strerror(errno));
    return st ? st : pm_file_bytes_map(&source->file, fileno(file), key, err);
}

static pm_status open_kept(pm_map_source *source, const char *key, pm_error *err)
{
    FILE *file = tmpfile();
    if (!file)
        return pm_error_set(err, PM_E_IO, "no temporary file for a map: %s", strerror(errno));
    pm_status st = fetch_kept(source, key, file, err);
    fclose(file);
    return st;
}

/* Keys are hexadecimal numbers joined by '-'. */
static bool is_key(const char *name)
{
    size_t length = strlen(name);
    return length >= 16 && length < 256 && strspn(name, "0123456789abcdef-") == length;
}

pm_status pm_map_source_open(pm_map_source *source, const char *name, pm_error *err)
{
    pm_file_bytes_close(&source->file);
    source->name = name;
    if (is_key(name) && access(name, F_OK))
        return open_kept(source, name, err);
    return pm_file_bytes_open(&source->file, name, err);
}

pm_status pm_map_source_visit(const pm_map_source *source, const pm_map_visitor *visitor,
                              char **command, pm_error *err)
{
    return pm_map_file_visit(source->file.data, source->file.size, source->name, visitor,
                             command, err);
}

void pm_map_source_close(pm_map_source *source)
{
    pm_file_bytes_close(&source->file);
    pm_session_close(source->session);
    source->session = NULL;
}
