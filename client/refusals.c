#include "refusals.h"

#include <stddef.h>
#include <string.h>

enum {
    PICTURES = PM_VERB_RPICT | PM_VERB_RENDER,
    POINTS = PM_VERB_RTRACE | PM_VERB_TRACE,
    LOOKING = PICTURES | POINTS,
    RADIANCE = PM_VERB_RPICT | PM_VERB_RTRACE,
    WORKING = LOOKING | PM_VERB_MKPMAP,
};

#define SWITCH "+-01yYnNtTfF" /* what may follow the name of a switch of Radiance */

static const char by_mkpmap[] = "photons come from map files; mkpmap says where they start";
static const char by_map[] =
    "a picture would be dark where no photons are stored; mkpmap makes such maps";
static const char no_sensors[] =
    "points in free space look all around and need no surface; mkpmap makes maps of sensors";
static const char by_map_file[] = "a map's file has what was kept; mkpmap decides how much";
static const char no_prepass[] =
    "there is no prepass to set: maps grow until they hold the number wanted";
static const char no_cache[] =
    "there is no irradiance cache here: gather rays are traced each time";
static const char by_stops[] = "samples are set by --passes, --time or --error";
static const char computed[] = "ambient light is computed here, not assumed; leave it out";
static const char one_sample[] =
    "lights are sampled a point a pass, so there is nothing to partition, jitter or skip";
static const char roulette[] = "walks end by roulette, without bias; there is no limit to set";
static const char all_pixels[] = "every pixel is sampled in every pass, jittered over its area";
static const char pinhole[] = "the camera is a pinhole that stands still";
static const char one_picture[] =
    "one picture a command, to standard output; run rpict once for each view";
static const char no_persistence[] =
    "scene and maps stay in the server's cache anyway; see pmserver(8)";
static const char no_ray_trees[] = "ray trees are not printed";

/* Options of Radiance's programs that have no meaning here: the name, and the letters that may
 * follow it. From the manual pages rpict(1), rtrace(1), mkpmap(1) and the programs' -defaults.
 */
static const struct {
    unsigned verbs;
    const char *name, *tail, *reason;
} refused[] = {
    {RADIANCE, "-apP", "", by_map_file},
    {RADIANCE, "-apf", "", by_map_file},
    {LOOKING, "-apd", "",
     "direct light comes from next events; mkpmap makes direct maps for pmapdump"},
    {WORKING, "-apC", "", "contribution maps are not offered"},
    {PM_VERB_MKPMAP, "-apD", "", no_prepass},
    {PM_VERB_MKPMAP, "-apM", "", no_prepass},
    {RADIANCE, "-apo", "+-0", by_mkpmap},
    {RADIANCE, "-apO", "+-0", by_mkpmap},
    {LOOKING, "-am", "", "the search radius needs no bound here"},
    {LOOKING, "-ac", "", "the whole map is in memory; there are no pages to set"},
    {LOOKING, "-aC", "", "the whole map is in memory; there is no cache to set"},
    {LOOKING, "-aa", "", no_cache},
    {LOOKING, "-ar", "", no_cache},
    {LOOKING, "-af", "", no_cache},
    {LOOKING, "-ad", "", by_stops},
    {LOOKING, "-as", "", by_stops},
    {LOOKING, "-av", "", computed},
    {LOOKING, "-aw", "", computed},
    {LOOKING, "-ae", "", by_map},
    {LOOKING, "-aE", "", by_map},
    {LOOKING, "-ai", "", by_map},
    {LOOKING, "-aI", "", by_map},
    {LOOKING, "-api", "", by_map},
    {LOOKING, "-apI", "", by_map},
    {LOOKING, "-aps", "", no_sensors},
    {LOOKING, "-apS", "", no_sensors},
    {LOOKING, "-dj", "", one_sample},
    {RADIANCE, "-ds", "", one_sample},
    {LOOKING, "-dt", "", one_sample},
    {LOOKING, "-dc", "", one_sample},
    {RADIANCE, "-dp", "", one_sample},
    {LOOKING, "-dr", "", "light over mirrors comes from virtual sources and photons, always"},
    {LOOKING, "-dv", SWITCH, "lamps are always visible here"},
    {LOOKING, "-ss", "", "specular light is sampled in every pass"},
    {LOOKING, "-st", "", "specular light is always sampled here, however weak"},
    {LOOKING, "-lr", "", roulette},
    {LOOKING, "-lw", "", roulette},
    {LOOKING, "-ms", "", "media are sampled without steps, so there is no step to set"},
    {LOOKING, "-i", SWITCH, "irradiance is offered at points: trace, or rtrace -I"},
    {LOOKING, "-u", SWITCH, "samples are stratified and depend on -apr alone"},
    {LOOKING, "-P", "P", no_persistence},
    {LOOKING, "-co", SWITCH, "contributions are not offered"},
    {LOOKING, "-cs", "", "colours are red, green and blue here"},
    {LOOKING, "-cw", "", "colours are red, green and blue here"},
    {LOOKING, "-pc", "", "colours are red, green and blue of the scene's own primaries"},
    {LOOKING, "-pXYZ", "", "colours are red, green and blue of the scene's own primaries"},
    {LOOKING, "-pRGB", "", "colours are red, green and blue of the scene's own primaries"},
    {PICTURES, "-ps", "", all_pixels},
    {PICTURES, "-pt", "", all_pixels},
    {PICTURES, "-pj", "", all_pixels},
    {PICTURES, "-pm", "", pinhole},
    {PICTURES, "-pd", "", pinhole},
    {PICTURES, "-S", "", one_picture},
    {PM_VERB_RPICT, "-o", "", "the picture goes to standard output: rpict ... > picture.hdr"},
    {PICTURES, "-r", "o", "a picture is not resumed: its photons are in the server's cache"},
    {PICTURES, "-z", "", "distances are not written"},
    {POINTS, "-f", "adfc0123456789",
     "formats are -f and a, d or f for points, then a, d, f or c for values, of rtrace"},
    {POINTS, "-o", "odvVwWlLcpnNsmMrRxXtT~",
     "columns are odvLpnNcsmM, of rtrace; a value is an estimate over many paths, so that "
     "there "
     "is no ray tree (t T ~) and no weight or length of it (V w W l r x R X)"},
    {POINTS, "-te", "", no_ray_trees},
    {POINTS, "-ti", "", no_ray_trees},
    {POINTS, "-tE", "", no_ray_trees},
    {POINTS, "-tI", "", no_ray_trees},
    {PICTURES, "-ld", "", "photons come from map files here; mkpmap has it"},
    {POINTS, "-ld", SWITCH, "rays go as far as the scene does"},
    {PM_VERB_TRACE, "-x", "", "a picture of values is written by rtrace"},
    {PM_VERB_TRACE, "-y", "", "a picture of values is written by rtrace"},
    {WORKING, "-defaults", "", "--help lists options and defaults"},
    {WORKING, "-version", "", "say pmclient --version"},
};

const char *pm_refusal_of(pm_verb verb, const char *option)
{
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        size_t length = strlen(refused[i].name);
        if (!(refused[i].verbs & verb) || strncmp(option, refused[i].name, length) != 0)
            continue;
        const char *rest = option + length;
        if (strspn(rest, refused[i].tail) == strlen(rest))
            return refused[i].reason;
    }
    return NULL;
}

enum { LETTERS_MAX = 31 };

/* Wagner and Fischer 1974, one row of the table at a time. Letters of either case are equal. */
static size_t edit_distance(const char *a, const char *b)
{
    size_t row[LETTERS_MAX + 1], columns = strlen(b);
    if (columns > LETTERS_MAX)
        return SIZE_MAX;
    for (size_t j = 0; j <= columns; j++)
        row[j] = j;
    for (size_t i = 0; a[i]; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < columns; j++) {
            size_t best = diagonal + ((a[i] | 0x20) != (b[j] | 0x20));
            best = row[j] + 1 < best ? row[j] + 1 : best;
            best = row[j + 1] + 1 < best ? row[j + 1] + 1 : best;
            diagonal = row[j + 1];
            row[j + 1] = best;
        }
    }
    return row[columns];
}

const char *pm_closest(const char *word, const char *const *names, size_t count)
{
    const char *letters = word + strspn(word, "-"), *closest = NULL;
    size_t length = strlen(letters), best = length < 4 ? length / 3 + 1 : 3;
    for (size_t i = 0; i < count; i++) {
        size_t distance = edit_distance(letters, names[i] + strspn(names[i], "-"));
        if (distance < best) {
            best = distance;
            closest = names[i];
        }
    }
    return closest;
}
