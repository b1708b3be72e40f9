#include "verbs.h"

#include <inttypes.h>
#include <stdlib.h>

#include "file_bytes.h"
#include "photons/photon_map.h"

static void print_info(const char *path, const pm_photon_map *map, const char *command)
{
    const pm_map_header *header = pm_photon_map_header(map);
    char scene[PM_DIGEST_HEX], family[PM_DIGEST_HEX];
    pm_rgb flux = pm_photon_map_mean_flux(map);
    pm_digest_hex(&header->scene, scene);
    pm_digest_hex(&header->family, family);
    printf("File:         %s\n", path);
    printf("Kind:         %s\n", pm_map_kind_name(header->kind));
    printf("Command:      %s\n", command && *command ? command : "(not recorded)");
    printf("Photons:      %zu\n", pm_photon_map_count(map));
    printf("Average flux: %.6g %.6g %.6g W a photon\n", flux.r, flux.g, flux.b);
    printf("Paths:        %" PRIu64 ", seed %" PRIu64 "\n", header->paths, header->seed);
    printf("Scene:        %s\n", scene);
    printf("Family:       %s\n", family);
    if (header->note[0])
        printf("Note:         %s\n", header->note);
}

static pm_status info(const char *path, pm_error *err)
{
    pm_file_bytes file;
    pm_photon_map *map = NULL;
    char *command = NULL;
    pm_status st = pm_file_bytes_open(&file, path, err);
    if (st)
        return st;
    st = pm_photon_map_read(file.data, file.size, path, &map, &command, err);
    if (!st)
        print_info(path, map, command);
    free(command);
    pm_photon_map_free(map);
    pm_file_bytes_close(&file);
    return st;
}

pm_status pm_check_pmapinfo(const pm_options *options, pm_error *err)
{
    if (options->operand_count)
        return PM_OK;
    return pm_error_set(err, PM_E_MISSING, "a map's file is missing: pmapinfo FILE...");
}

pm_status pm_verb_pmapinfo(const pm_options *options, pm_error *err)
{
    pm_status st = PM_OK;
    for (unsigned i = 0; i < options->operand_count && !st; i++) {
        if (i)
            putchar('\n');
        st = info(options->operands[i], err);
    }
    return st;
}
