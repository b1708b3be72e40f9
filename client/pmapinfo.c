#include "verbs.h"

#include <inttypes.h>

#include "map_source.h"

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

pm_status pm_check_pmapinfo(const pm_options *options, pm_error *err)
{
    if (options->operand_count)
        return PM_OK;
    return pm_error_set(err, PM_E_MISSING, "a map's file is missing: pmapinfo FILE...");
}

pm_status pm_verb_pmapinfo(const pm_options *options, pm_error *err)
{
    pm_map_source source = {.options = options};
    pm_status st = PM_OK;
    for (unsigned i = 0; i < options->operand_count && !st; i++) {
        st = pm_map_source_open(&source, options->operands[i], err);
        if (i && !st)
            putchar('\n');
        if (!st)
            print_info(options->operands[i], source.map, source.command);
    }
    pm_map_source_close(&source);
    return st;
}
