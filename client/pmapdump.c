#include "verbs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "map_source.h"

/* Photons as a scene of spheres, as Radiance's pmapdump writes them; or as points. */

/* Of an average distance between spheres (Radiance's RADCOEFF). */
static const double radius_share = .05;

struct dump {
    const pm_dump_option *option;
    pm_map_header header; /* of the first pass of a sequence */
    uint64_t photons, taken, paths, at;
    pm_vec3 low, high; /* where the photons lie [world units] */
    double radius;
    double watts; /* that a photon of flux 1 stands for, those left out included */
    const char *kind;
};

static pm_vec3 position_of(const struct dump *dump, const pm_photon *photon)
{
    const pm_map_header *header = &dump->header;
    return pm_vec3_madd(header->world_center, header->world_scale, pm_photon_position(photon));
}

/* ---- which photons, how large ---- */

static pm_status begin(void *context, const pm_map_header *header, uint64_t count,
                       pm_error *err)
{
    (void)err;
    struct dump *dump = context;
    if (!dump->paths)
        dump->header = *header;
    dump->photons += count;
    dump->paths += header->paths;
    return PM_OK;
}

static pm_status measure(void *context, const pm_photon *photons, size_t count, pm_error *err)
{
    (void)err;
    struct dump *dump = context;
    pm_vec3 low = dump->low, high = dump->high;
    for (size_t i = 0; i < count; i++) {
        pm_vec3 p = pm_photon_position(&photons[i]);
        low = (pm_vec3){fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z)};
        high = (pm_vec3){fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z)};
    }
    dump->low = low;
    dump->high = high;
    return PM_OK;
}

/* Radius after the mean distance that so many spheres have along the line, over the plane or in
 * the volume that the photons fill. */
static double fitting_radius(const struct dump *dump)
{
    pm_vec3 low = dump->low, high = dump->high;
    double world_scale = dump->header.world_scale, extent = 1;
    const double edges[3] = {high.x - low.x, high.y - low.y, high.z - low.z};
    int dimensions = 0;
    for (int i = 0; i < 3; i++) {
        if (edges[i] > 0x1p-20) { /* beyond the rounding of photons on a plane */
            extent *= edges[i] * world_scale;
            dimensions++;
        }
    }
    double room =
        dimensions ? pow(extent / (double)dump->taken, 1.0 / dimensions) : world_scale;
    return dump->option->radius_scale * radius_share * room;
}

/* Every photon, or evenly `taken` of them along the stored order, which goes through space. */
static bool is_taken(const struct dump *dump, uint64_t i)
{
    return (i + 1) * dump->taken / dump->photons > i * dump->taken / dump->photons;
}

static void prepare(struct dump *dump)
{
    const pm_map_header *header = &dump->header;
    const pm_dump_option *option = dump->option;
    dump->kind = pm_map_kind_name(header->kind);
    dump->taken = option->count < dump->photons ? option->count : dump->photons;
    if (!dump->taken)
        return;
    dump->radius = option->radius > 0 ? option->radius : fitting_radius(dump);
    double left_out = (double)dump->photons / (double)dump->taken;
    if (header->kind == PM_MAP_PRECOMPUTED) {
        dump->watts = header->flux_scale; /* W/m^2, whatever is left out */
        return;
    }
    dump->watts = header->flux_scale * header->world_scale * header->world_scale * left_out /
                  (double)dump->paths;
}

/* ---- output ---- */

static void print_material(const struct dump *dump, pm_rgb color)
{
    printf("void glow mat.%s\n0\n0\n4 %g %g %g 0\n\n", dump->kind, color.r, color.g, color.b);
}

static void print_photon(const struct dump *dump, const pm_photon *photon)
{
    const pm_dump_option *option = dump->option;
    pm_vec3 p = position_of(dump, photon);
    pm_rgb color =
        option->by_flux ? pm_rgb_scale(pm_photon_flux(photon), dump->watts) : option->color;
    if (option->points) {
        printf("%.9g\t%.9g\t%.9g\t%g\t%g\t%g\n", p.x, p.y, p.z, color.r, color.g, color.b);
        return;
    }
    if (option->by_flux)
        print_material(dump, color);
    printf("mat.%s sphere obj.%s\n0\n0\n4 %.9g %.9g %.9g %g\n\n", dump->kind, dump->kind, p.x,
           p.y, p.z, dump->radius);
}

static void print_head(const struct dump *dump)
{
    if (!dump->option->points)
        printf("# %s\n", pm_command_line);
    if (!dump->option->points && !dump->option->by_flux)
        print_material(dump, dump->option->color);
}

static pm_status print_photons(void *context, const pm_photon *photons, size_t count,
                               pm_error *err)
{
    (void)err;
    struct dump *dump = context;
    for (size_t i = 0; i < count; i++)
        if (is_taken(dump, dump->at++))
            print_photon(dump, &photons[i]);
    return PM_OK;
}

/* Blue, red, green and purple for global, caustic, volume and direct photons, as Radiance has
 * them; a colder blue for precomputed ones. */
static pm_rgb kind_color(pm_map_kind kind)
{
    static const pm_rgb colors[PM_MAP_KINDS] = {[PM_MAP_GLOBAL] = {.25, .25, 2},
                                                [PM_MAP_CAUSTIC] = {1, .1, .1},
                                                [PM_MAP_VOLUME] = {.1, 1, .1},
                                                [PM_MAP_DIRECT] = {1, .1, 1}};
    static const pm_rgb precomputed = {.1, .25, 2};
    return kind == PM_MAP_PRECOMPUTED ? precomputed : colors[kind];
}

/* ---- the verb ---- */

/* The seed's form: a radius before the files, for every photon of each. */
static bool leading_radius(const pm_options *options, double *radius)
{
    char *end;
    if (!options->operand_count || !access(options->operands[0], F_OK))
        return false;
    *radius = strtod(options->operands[0], &end);
    return end != options->operands[0] && !*end && isfinite(*radius) && *radius > 0;
}

pm_status pm_check_pmapdump(const pm_options *options, pm_error *err)
{
    double radius;
    unsigned files = options->operand_count - leading_radius(options, &radius);
    for (unsigned i = 0; i < options->operand_count; i++)
        if (options->dumps[i].by_flux && options->dumps[i].colored)
            return pm_error_set(err, PM_E_RANGE, "-f and -c exclude each other; give one");
    if (files)
        return PM_OK;
    return pm_error_set(err, PM_E_MISSING,
                        "a map's file is missing: pmapdump [RADIUS] FILE...");
}

/* Once over the file to measure, once more to print. */
static pm_status print_map(pm_map_source *source, pm_dump_option *option, pm_error *err)
{
    struct dump dump = {.option = option,
                        .low = {INFINITY, INFINITY, INFINITY},
                        .high = {-INFINITY, -INFINITY, -INFINITY}};
    const pm_map_visitor measurer = {&dump, begin, measure},
                         printer = {&dump, NULL, print_photons};
    pm_status st = pm_map_source_visit(source, &measurer, NULL, err);
    if (st)
        return st;
    if (!option->colored)
        option->color = kind_color(dump.header.kind);
    prepare(&dump);
    print_head(&dump);
    return pm_map_source_visit(source, &printer, NULL, err);
}

pm_status pm_verb_pmapdump(const pm_options *options, pm_error *err)
{
    pm_map_source source = {.options = options};
    double radius = 0;
    pm_status st = PM_OK;
    for (unsigned i = leading_radius(options, &radius); i < options->operand_count && !st;
         i++) {
        pm_dump_option option = options->dumps[i];
        if (radius > 0) {
            option.radius = radius;
            option.count = UINT64_MAX;
        }
        st = pm_map_source_open(&source, options->operands[i], err);
        if (!st)
            st = print_map(&source, &option, err);
    }
    pm_map_source_close(&source);
    return st;
}
