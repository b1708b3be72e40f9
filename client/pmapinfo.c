#include "verbs.h"

#include <inttypes.h>
#include <stdlib.h>

#include "map_source.h"

/* What is told of a file: of one map, or of the passes of a sequence together. */
struct info {
    pm_map_header header; /* of the first pass */
    uint64_t maps, photons, paths;
    pm_rgb flux;
    struct pass {
        uint64_t photons, first_path, paths;
    } * passes;
};

static pm_status begin(void *context, const pm_map_header *header, uint64_t count,
                       pm_error *err)
{
    struct info *info = context;
    struct pass *passes = realloc(info->passes, (info->maps + 1) * sizeof *passes);
    if (!passes)
        return pm_error_set(err, PM_E_MEMORY, "no memory");
    info->passes = passes;
    passes[info->maps] = (struct pass){count, header->first_path, header->paths};
    if (!info->maps++)
        info->header = *header;
    info->photons += count;
    info->paths += header->paths;
    return PM_OK;
}

static pm_status add(void *context, const pm_photon *photons, size_t count, pm_error *err)
{
    (void)err;
    struct info *info = context;
    pm_rgb sum = {0, 0, 0};
    for (size_t i = 0; i < count; i++)
        sum = pm_rgb_add(sum, pm_photon_flux(&photons[i]));
    info->flux = pm_rgb_add(info->flux, sum);
    return PM_OK;
}

/* Mean flux of a photon [W], or irradiance of a precomputed one [W/m^2]. */
static pm_rgb mean_flux(const struct info *info)
{
    const pm_map_header *header = &info->header;
    if (!info->photons)
        return (pm_rgb){0, 0, 0};
    double scale = header->flux_scale / (double)info->photons;
    if (header->kind != PM_MAP_PRECOMPUTED)
        scale *= header->world_scale * header->world_scale / (double)info->paths;
    return pm_rgb_scale(info->flux, scale);
}

static void print_passes(const struct info *info)
{
    printf("Passes:       %" PRIu64 "\n", info->maps);
    for (uint64_t i = 0; i < info->maps; i++) {
        const struct pass *pass = &info->passes[i];
        printf("  pass %-7" PRIu64 " %" PRIu64 " photons, paths %" PRIu64 " to %" PRIu64 "\n",
               i, pass->photons, pass->first_path, pass->first_path + pass->paths - 1);
    }
}

static void print_info(const char *path, const struct info *info, const char *command)
{
    const pm_map_header *header = &info->header;
    char scene[PM_DIGEST_HEX], family[PM_DIGEST_HEX];
    pm_rgb flux = mean_flux(info);
    pm_digest_hex(&header->scene, scene);
    pm_digest_hex(&header->family, family);
    printf("File:         %s\n", path);
    printf("Kind:         %s\n", pm_map_kind_name(header->kind));
    printf("Command:      %s\n", command && *command ? command : "(not recorded)");
    printf("Photons:      %" PRIu64 "\n", info->photons);
    if (header->kind == PM_MAP_PRECOMPUTED)
        printf("Average irradiance: %.4g %.4g %.4g W/m^2, at %g of the photons\n", flux.r,
               flux.g, flux.b, header->storage_probability);
    else
        printf("Average flux: %.6g %.6g %.6g W a photon\n", flux.r, flux.g, flux.b);
    printf("Paths:        %" PRIu64 ", seed %" PRIu64 "\n", info->paths, header->seed);
    printf("Scene:        %s\n", scene);
    printf("Family:       %s\n", family);
    if (header->note[0])
        printf("Note:         %s\n", header->note);
    if (info->maps > 1)
        print_passes(info);
}

pm_status pm_check_pmapinfo(const pm_options *options, pm_error *err)
{
    if (options->operand_count)
        return PM_OK;
    return pm_error_set(err, PM_E_MISSING, "a map's file is missing: pmapinfo FILE...");
}

static pm_status describe(pm_map_source *source, const char *name, pm_error *err)
{
    struct info info = {.maps = 0};
    const pm_map_visitor visitor = {&info, begin, add};
    char *command = NULL;
    pm_status st = pm_map_source_open(source, name, err);
    if (!st)
        st = pm_map_source_visit(source, &visitor, &command, err);
    if (!st)
        print_info(name, &info, command);
    free(info.passes);
    free(command);
    return st;
}

pm_status pm_verb_pmapinfo(const pm_options *options, pm_error *err)
{
    pm_map_source source = {.options = options};
    pm_status st = PM_OK;
    for (unsigned i = 0; i < options->operand_count && !st; i++) {
        if (i)
            putchar('\n');
        st = describe(&source, options->operands[i], err);
    }
    pm_map_source_close(&source);
    return st;
}
