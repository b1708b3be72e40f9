#include "map_files.h"

#include "file_bytes.h"
#include "photons/photon_map.h"

static pm_status attach(pm_session *session, pm_map_kind kind, const char *path,
                        pm_attachments *attachments, pm_error *err)
{
    if (attachments->has_map[kind])
        return pm_error_set_at(err, PM_E_RANGE, path, 0, 0, "is a second %s map; give one",
                               pm_map_kind_name(kind));
    pm_status st = pm_session_upload_file(session, path, &attachments->map[kind], err);
    attachments->has_map[kind] = !st;
    return st;
}

static pm_status detect(const char *path, pm_map_kind *kind, pm_error *err)
{
    pm_file_bytes file;
    pm_map_header header;
    pm_status st = pm_file_bytes_open(&file, path, err);
    if (st)
        return st;
    st = pm_map_file_header(file.data, file.size, path, &header, err);
    if (!st)
        *kind = header.kind;
    if (!st && *kind == PM_MAP_DIRECT)
        st = pm_error_set_at(
            err, PM_E_MISMATCH, path, 0, 0,
            "is a direct map, to be looked at with pmapdump; direct light comes "
            "from next events");
    pm_file_bytes_close(&file);
    return st;
}

static pm_status check_single(const pm_map_option *map, pm_error *err)
{
    if (map->gather <= 1 && !map->gather_max)
        return PM_OK;
    return pm_error_set_at(err, PM_E_RANGE, map->file, 0, 0,
                           "is a precomputed map, of which the closest photon alone is looked "
                           "up; leave out the number behind it");
}

static pm_status attach_detected(pm_session *session, const pm_map_option *map,
                                 pm_attachments *attachments, pm_error *err)
{
    pm_map_kind kind;
    pm_status st = detect(map->file, &kind, err);
    if (!st && kind == PM_MAP_PRECOMPUTED) {
        st = check_single(map, err);
        attachments->precomputed = true;
        kind = PM_MAP_GLOBAL;
    }
    if (!st)
        st = attach(session, kind, map->file, attachments, err);
    if (!st)
        attachments->detected[kind] = map;
    return st;
}

pm_status pm_map_files_attach(pm_session *session, const pm_options *options,
                              pm_attachments *attachments, pm_error *err)
{
    pm_status st = PM_OK;
    for (int kind = 0; kind < PM_MAP_KINDS && !st; kind++)
        if (options->maps[kind].file)
            st = attach(session, (pm_map_kind)kind, options->maps[kind].file, attachments, err);
    for (unsigned i = 0; i < options->detected_count && !st; i++)
        st = attach_detected(session, &options->detected[i], attachments, err);
    return st;
}

const char *pm_map_files_name(const pm_options *options, pm_map_kind kind)
{
    if (options->maps[kind].file)
        return options->maps[kind].file;
    for (unsigned i = 0; i < options->detected_count; i++) {
        const char *file = options->detected[i].file;
        pm_map_kind found;
        if (detect(file, &found, NULL))
            continue;
        if (found == kind || (found == PM_MAP_PRECOMPUTED && kind == PM_MAP_GLOBAL))
            return file;
    }
    return NULL;
}
