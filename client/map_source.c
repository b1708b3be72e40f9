#include "map_source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void drop(pm_map_source *source)
{
    pm_photon_map_free(source->map);
    free(source->command);
    source->map = NULL;
    source->command = NULL;
}

static pm_status read_file(pm_map_source *source, const char *path, pm_error *err)
{
    pm_file_bytes file;
    pm_status st = pm_file_bytes_open(&file, path, err);
    if (st)
        return st;
    st = pm_photon_map_read(file.data, file.size, path, &source->map, &source->command, err);
    pm_file_bytes_close(&file);
    return st;
}

static pm_status read_kept(pm_map_source *source, const char *key, pm_error *err)
{
    char url[512];
    pm_bytes bytes = {0};
    snprintf(url, sizeof url, "/v1/maps/%s/photons", key);
    pm_status st =
        source->session ? PM_OK : pm_session_open(source->options, &source->session, err);
    if (!st)
        st = pm_session_read(source->session, url, &bytes, err);
    if (!st)
        st = pm_photon_map_read(bytes.data, bytes.size, key, &source->map, &source->command,
                                err);
    pm_bytes_clear(&bytes);
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
    drop(source);
    if (is_key(name) && access(name, F_OK))
        return read_kept(source, name, err);
    return read_file(source, name, err);
}

void pm_map_source_close(pm_map_source *source)
{
    drop(source);
    pm_session_close(source->session);
    source->session = NULL;
}
