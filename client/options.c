#include "options.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "option_words.h"
#include "refusals.h"

static pm_status take_passes(struct pm_words *words)
{
    return pm_word_u32(words, "passes", 1, 1U << 24, &words->out->passes);
}

static pm_status take_time(struct pm_words *words)
{
    const char *text = NULL;
    pm_status st = pm_word_text(words, "a time", &text);
    if (!st && pm_seconds_parse(text, &words->out->seconds))
        st = pm_word_bad(words, text, "a time such as 30s, 5m, 1h");
    return st;
}

static pm_status take_error(struct pm_words *words)
{
    const char *text = NULL;
    pm_status st = pm_word_text(words, "an error", &text);
    if (!st && pm_share_parse(text, &words->out->error))
        st = pm_word_bad(words, text, "a relative error such as 2% or .02, at most 1");
    return st;
}

static pm_status take_threads(struct pm_words *words)
{
    return pm_word_u32(words, "threads", 0, 256, &words->out->threads);
}

static pm_status take_interval(struct pm_words *words)
{
    const char *text = NULL;
    pm_status st = pm_word_text(words, "seconds", &text);
    double *out = &words->out->progress_seconds;
    if (!st && strcmp(text, "0") && pm_seconds_parse(text, out))
        st = pm_word_bad(words, text, "seconds between reports, 0 for none");
    return st;
}

static pm_status take_output(struct pm_words *words)
{
    const char *path = NULL;
    pm_status st = pm_word_text(words, "a file", &path);
    if (st)
        return st;
    if (words->out->output_count == PM_OUTPUTS_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "-o: at most %d files", PM_OUTPUTS_MAX);
    words->out->outputs[words->out->output_count++] = path;
    return PM_OK;
}

static pm_status take_messages(struct pm_words *words)
{
    return pm_word_text(words, "a file", &words->out->messages);
}

static pm_status take_allowed(struct pm_words *words)
{
    const char *folder = NULL;
    pm_status st = pm_word_text(words, "a folder", &folder);
    if (st)
        return st;
    if (words->out->allowed_count == PM_ALLOWED_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "--allow: at most %d folders",
                            PM_ALLOWED_MAX);
    words->out->allowed[words->out->allowed_count++] = folder;
    return PM_OK;
}

static pm_status take_dump_count(struct pm_words *words)
{
    return pm_word_count(words, "photons", 1, UINT64_C(1) << 53, &words->out->dump.count);
}

static pm_status take_dump_radius(struct pm_words *words)
{
    double *scale = &words->out->dump.radius_scale;
    pm_status st = pm_word_number(words, "a factor", scale);
    if (!st && !(*scale > 0))
        st = pm_word_bad(words, words->argv[words->at - 1], "a factor greater than 0");
    return st;
}

static pm_status take_dump_color(struct pm_words *words)
{
    pm_dump_option *dump = &words->out->dump;
    double *const channels[3] = {&dump->color.r, &dump->color.g, &dump->color.b};
    pm_status st = PM_OK;
    dump->colored = true;
    for (int i = 0; i < 3 && !st; i++) {
        st = pm_word_number(words, "a colour: r g b", channels[i]);
        if (!st && !(*channels[i] >= 0))
            st = pm_word_bad(words, words->argv[words->at - 1], "radiances of 0 or more");
    }
    return st;
}

static pm_status take_set_size(struct pm_words *words)
{
    return pm_word_u32(words, "surfaces", 1, 511, &words->out->oconv.set_size);
}

static pm_status take_resolution(struct pm_words *words)
{
    return pm_word_u32(words, "smallest cubes across the scene", 1, 1 << 20,
                       &words->out->oconv.resolution);
}

static pm_status take_bounds(struct pm_words *words)
{
    pm_oconv_option *o = &words->out->oconv;
    pm_status st = PM_OK;
    for (int i = 0; !st && i < 4; i++)
        st = pm_word_number(words, "four numbers: the lowest corner x y z and the width",
                            i < 3 ? &o->corner[i] : &o->edge);
    if (!st && !(o->edge > 0))
        return pm_word_bad(words, words->argv[words->at - 1], "a width greater than 0");
    o->bounded = true;
    return st;
}

static pm_status take_input_octree(struct pm_words *words)
{
    return pm_word_text(words, "an octree", &words->out->oconv.input);
}

static pm_status take_server(struct pm_words *words)
{
    return pm_word_text(words, "an address such as http://127.0.0.1:8080", &words->out->server);
}

static pm_status take_token_file(struct pm_words *words)
{
    return pm_word_text(words, "a file", &words->out->token_file);
}

#define SWITCH(member, to)     set_switch, offsetof(pm_options, member), to, NULL
#define DUMP(member, to)       set_switch, offsetof(pm_options, dump.member), to, NULL
#define TOGGLE(member)         toggle, offsetof(pm_options, member), false, NULL
#define TAKE(take)             take, 0, false, NULL
#define LETTERS(take, letters) take, 0, false, letters

static pm_status toggle(struct pm_words *words)
{
    pm_word_toggle(words, (bool *)((char *)words->out + words->entry->offset));
    return PM_OK;
}

static pm_status set_switch(struct pm_words *words)
{
    const struct pm_option *entry = words->entry;
    *(bool *)((char *)words->out + entry->offset) = entry->value;
    return PM_OK;
}

/* -f[adf][adfc]: of points, then of values; one letter says both. */
static pm_status take_formats(struct pm_words *words)
{
    const char *letters = words->option + 2;
    if (strlen(letters) > 2 || letters[0] == 'c')
        return pm_word_bad(
            words, words->option,
            "-f with one of a (text), f (float), d (double) for the points, and one of "
            "these or c (pixels) for the values");
    words->out->input_format = letters[0];
    words->out->output_format = letters[letters[1] ? 1 : 0];
    return PM_OK;
}

static pm_status take_fields(struct pm_words *words)
{
    const char *letters = words->option + 2;
    if (strlen(letters) >= sizeof words->out->fields)
        return pm_word_bad(words, words->option, "-o with 15 letters at most");
    snprintf(words->out->fields, sizeof words->out->fields, "%s", letters);
    return PM_OK;
}

static const struct pm_option options[] = {
    {"-apg", RENDERING, "N [K [K2]]",
     "global map of about N photons, K an estimate (40); K2: up to so many, see --bandwidth",
     TAKE(pm_take_map)},
    {"-apc", RENDERING, "N [K [K2]]", "caustic map, likewise", TAKE(pm_take_map)},
    {"-apv", RENDERING, "N [K [K2]]", "volume map, likewise", TAKE(pm_take_map)},
    {"-apg", PM_VERB_MKPMAP, "FILE N", "write a global map of about N photons",
     TAKE(pm_take_map)},
    {"-apc", PM_VERB_MKPMAP, "FILE N", "write a caustic map", TAKE(pm_take_map)},
    {"-apv", PM_VERB_MKPMAP, "FILE N", "write a volume map", TAKE(pm_take_map)},
    {"-apd", PM_VERB_MKPMAP, "FILE N", "write a direct map, to be looked at with pmapdump",
     TAKE(pm_take_map)},
    {"-apg", RADIANCE, "FILE [K [K2]]",
     "global map from a file, K photons an estimate (40); K2: up to so many, see --bandwidth",
     TAKE(pm_take_map)},
    {"-apc", RADIANCE, "FILE [K [K2]]", "caustic map from a file", TAKE(pm_take_map)},
    {"-apv", RADIANCE, "FILE [K [K2]]", "volume map from a file", TAKE(pm_take_map)},
    {"-app", RENDERING, "N BW",
     "instead of -apg: irradiance from BW photons, precomputed at some of N (see -apP)",
     TAKE(pm_take_precomputed)},
    {"-app", PM_VERB_MKPMAP, "FILE N BW",
     "write a global map of N photons with irradiance from BW of them precomputed (see -apP)",
     TAKE(pm_take_precomputed)},
    {"-app", RADIANCE, "FILE [1]", "a precomputed map from a file, in the place of -apg",
     TAKE(pm_take_precomputed)},
    {"-apP", RENDERING | PM_VERB_MKPMAP, "F",
     "of -app: the share of the photons that is kept (.25)", TAKE(pm_take_fraction)},
    {"-apf", RENDERING | PM_VERB_MKPMAP, "F", "the same", TAKE(pm_take_fraction)},
    {"-ap", RADIANCE, "FILE [K [K2]]", "a map from a file, of whatever kind it is",
     TAKE(pm_take_detected_map)},
    {"-apgb", RADIANCE, "FILE K K2", "the same as -apg FILE K K2", TAKE(pm_take_map)},
    {"-apcb", RADIANCE, "FILE K K2", "the same as -apc FILE K K2", TAKE(pm_take_map)},
    {"-apvb", RADIANCE, "FILE K K2", "the same as -apv FILE K K2", TAKE(pm_take_map)},
    {"--bandwidth", LOOKING, "RULE",
     "how K to K2 photons are chosen: bias (compensation; the default) or chi2 (while evenly "
     "spread)",
     TAKE(pm_take_bandwidth)},
    {"-ab", LOOKING, "N",
     "> 0: final gather into the global map; < 0: that map itself; 0: caustics alone",
     TAKE(pm_take_bounces)},
    {"--vf", PICTURES, "FILE", "view file", TAKE(pm_take_view_file)},
    {"-vf", PICTURES, "FILE", "the same", TAKE(pm_take_view_file)},
    {"-vp", PICTURES, "X Y Z", "view point (0 0 0)", TAKE(pm_take_vector)},
    {"-vd", PICTURES, "X Y Z", "view direction (0 1 0)", TAKE(pm_take_vector)},
    {"-vu", PICTURES, "X Y Z", "up (0 0 1)", TAKE(pm_take_vector)},
    {"-vh", PICTURES, "DEGREES", "horizontal angle of view (45); with -vtl the width seen",
     TAKE(pm_take_angle)},
    {"-vv", PICTURES, "DEGREES", "vertical angle of view (45); with -vtl the height seen",
     TAKE(pm_take_angle)},
    {"-vtv", PICTURES, "", "perspective view (the default)", TAKE(pm_take_other_view)},
    {"-vtl", PICTURES, "", "parallel view; plans and sections", TAKE(pm_take_other_view)},
    {"-vth", PICTURES, "", "hemispherical fisheye", TAKE(pm_take_other_view)},
    {"-vtc", PICTURES, "", "cylindrical panorama", TAKE(pm_take_other_view)},
    {"-vta", PICTURES, "", "angular fisheye, up to all around", TAKE(pm_take_other_view)},
    {"-vts", PICTURES, "", "stereographic fisheye", TAKE(pm_take_other_view)},
    {"-vs", PICTURES, "WIDTHS", "shift the picture to the right (0)", TAKE(pm_take_other_view)},
    {"-vl", PICTURES, "HEIGHTS", "lift the picture (0)", TAKE(pm_take_other_view)},
    {"-vo", PICTURES, "LENGTH", "leave out what is nearer (0)", TAKE(pm_take_other_view)},
    {"-va", PICTURES, "LENGTH", "leave out what is farther (0: nothing)",
     TAKE(pm_take_other_view)},
    {"-x", PICTURES, "N", "greatest width in pixels (512)", TAKE(pm_take_size)},
    {"-y", PICTURES, "N", "greatest height in pixels (512)", TAKE(pm_take_size)},
    {"-pa", PICTURES, "RATIO",
     "height of a pixel over its width, within -x by -y; 0: exactly -x by -y (1)",
     TAKE(pm_take_aspect)},
    {"--passes", LOOKING, "N", "stop after N passes", TAKE(take_passes)},
    {"--passes", PM_VERB_MKPMAP, "J",
     "sequences of J maps, each of as many photons and of paths of its own",
     TAKE(pm_take_sequence)},
    {"--pass", PM_VERB_MAP, "J", "fetch pass J alone of a sequence, counted from 0",
     TAKE(pm_take_pass)},
    {"--time", LOOKING, "TIME", "stop after so long, e.g. 30s, 5m", TAKE(take_time)},
    {"--error", LOOKING, "ERROR", "stop at this estimated relative error, e.g. 2%",
     TAKE(take_error)},
    {"-apr", WORKING, "SEED", "seed; equal seeds give equal bytes (0)", TAKE(pm_take_seed)},
    {"-apm", WORKING, "N", "most scatterings on a photon's path (5000)",
     TAKE(pm_take_max_events)},
    {"-lr", PM_VERB_MKPMAP, "N", "the same", TAKE(pm_take_max_events)},
    {"-ld", TRACING, "LENGTH", "greatest length of a photon's path [scene units]",
     TAKE(pm_take_max_length)},
    {"-apo", TRACING, "MOD",
     "surfaces of this modifier are ports: distant light enters through them alone, to their "
     "front",
     TAKE(pm_take_port)},
    {"-apo+", TRACING, "MOD", "the same", TAKE(pm_take_port)},
    {"-apo-", TRACING, "MOD", "ports from which light goes to their back", TAKE(pm_take_port)},
    {"-apo0", TRACING, "MOD", "ports from which light goes to both sides", TAKE(pm_take_port)},
    {"-apO", TRACING, "FILE", "ports for the modifiers in a file", TAKE(pm_take_port_file)},
    {"-apO+", TRACING, "FILE", "the same", TAKE(pm_take_port_file)},
    {"-apO-", TRACING, "FILE", "to their back", TAKE(pm_take_port_file)},
    {"-apO0", TRACING, "FILE", "to both sides", TAKE(pm_take_port_file)},
    {"-dp", TRACING, "N", "directions a steradian that a port's table tells apart (1000)",
     TAKE(pm_take_port_tables)},
    {"-ds", TRACING, "SIZE", "of a port's patches, relative to the scene's cube (.01)",
     TAKE(pm_take_port_tables)},
    {"-aps", PM_VERB_MKPMAP, "MOD", "surfaces of this modifier store photons on their front",
     TAKE(pm_take_name)},
    {"-apS", PM_VERB_MKPMAP, "FILE", "the same for the modifiers in a file",
     TAKE(pm_take_name_file)},
    {"-ae", PM_VERB_MKPMAP, "MOD", "surfaces of this modifier store no photons",
     TAKE(pm_take_name)},
    {"-aE", PM_VERB_MKPMAP, "FILE", "the same for the modifiers in a file",
     TAKE(pm_take_name_file)},
    {"-ai", PM_VERB_MKPMAP, "MOD", "surfaces of this modifier (and of other -ai) alone do",
     TAKE(pm_take_name)},
    {"-aI", PM_VERB_MKPMAP, "FILE", "the same for the modifiers in a file",
     TAKE(pm_take_name_file)},
    {"-api", PM_VERB_MKPMAP, "X Y Z X Y Z",
     "store photons in this box (and other regions) alone", TAKE(pm_take_region)},
    {"-apI", PM_VERB_MKPMAP, "X Y Z RADIUS", "store photons in this ball alone",
     TAKE(pm_take_region)},
    {"-n", WORKING, "N", "threads; the answer does not depend on it (0: one a processor)",
     TAKE(take_threads)},
    {"-t", WORKING, "SECONDS", "report progress as lines every so often", TAKE(take_interval)},
    {"-e", WORKING, "FILE", "append messages and progress to this file", TAKE(take_messages)},
    {"-fo", PM_VERB_MKPMAP, "", "-fo, -fo+: overwrite files that exist; -fo-: refuse to (-fo-)",
     TOGGLE(overwrite)},
    {"-me", WORKING, "R G B",
     "extinction of a medium that fills the scene [1 / scene unit] (0)", TAKE(pm_take_medium)},
    {"-ma", WORKING, "R G B", "its albedo (0)", TAKE(pm_take_medium)},
    {"-mg", WORKING, "G", "its eccentricity, -1 to 1 (0)", TAKE(pm_take_eccentricity)},
    {"-bv", WORKING, "", "-bv+: surfaces are there from behind; -bv-: they are not (-bv+)",
     TAKE(pm_take_back_faces)},
    {"-v", PM_VERB_MKPMAP, "", "-v, -v+: say what was planned and found; -v-: the least (-v-)",
     TOGGLE(verbose)},
    {"-I", PM_VERB_RTRACE, "", "irradiance at points, instead of radiance along rays",
     SWITCH(irradiance, true)},
    {"-I+", PM_VERB_RTRACE, "", "the same", SWITCH(irradiance, true)},
    {"-I-", PM_VERB_RTRACE, "", "radiance along rays (the default)", SWITCH(irradiance, false)},
    {"-h", PM_VERB_RTRACE, "", "no header before the values", SWITCH(no_header, true)},
    {"-h-", PM_VERB_RTRACE, "", "the same", SWITCH(no_header, true)},
    {"-h+", PM_VERB_RTRACE, "", "a header (the default)", SWITCH(no_header, false)},
    {"-w", RADIANCE, "", "no notes on standard error, errors only", SWITCH(quiet, true)},
    {"-w-", RADIANCE, "", "the same", SWITCH(quiet, true)},
    {"-w+", RADIANCE, "", "notes (the default)", SWITCH(quiet, false)},
    {"-o", PM_VERB_RTRACE, "odvLpnNcsmM",
     "print origin, direction, value; of what the ray meets first: distance, point, normal, "
     "that without textures, coordinates, surface, modifier, material (-ov)",
     LETTERS(take_fields, "odvLpnNcsmM")},
    {"-f", PM_VERB_RTRACE, "adf, adfc",
     "points and values as text, floats or doubles, values also as pixels (-faa)",
     LETTERS(take_formats, "adfc")},
    {"-x", PM_VERB_RTRACE, "N", "with -y: the values are a picture of that width",
     TAKE(pm_take_size)},
    {"-y", PM_VERB_RTRACE, "N", "and of that height", TAKE(pm_take_size)},
    {"--errors", POINTS, "", "three more columns: half-widths of the 95 % intervals",
     SWITCH(errors, true)},
    {"-o", PM_VERB_RENDER | PM_VERB_MAP, "FILE",
     "where to write: .exr, .hdr or .png by its ending; may be repeated", TAKE(take_output)},
    {"--allow", WORKING | PM_VERB_SCENE, "DIR",
     "files of this folder may be sent, too; without it those beside the scene and in RAYPATH",
     TAKE(take_allowed)},
    {"-n", PM_VERB_PMAPDUMP, "N", "photons of the next map at most (10k)",
     TAKE(take_dump_count)},
    {"-r", PM_VERB_PMAPDUMP, "SCALE", "of its spheres' radius (1)", TAKE(take_dump_radius)},
    {"-c", PM_VERB_PMAPDUMP, "R G B", "their colour", TAKE(take_dump_color)},
    {"-f", PM_VERB_PMAPDUMP, "", "coloured by each photon's flux", DUMP(by_flux, true)},
    {"-f+", PM_VERB_PMAPDUMP, "", "the same", DUMP(by_flux, true)},
    {"-f-", PM_VERB_PMAPDUMP, "", "one colour (the default)", DUMP(by_flux, false)},
    {"-a", PM_VERB_PMAPDUMP, "", "lines of `x y z r g b` instead of spheres",
     DUMP(points, true)},
    {"-a+", PM_VERB_PMAPDUMP, "", "the same", DUMP(points, true)},
    {"-a-", PM_VERB_PMAPDUMP, "", "spheres (the default)", DUMP(points, false)},
    {"-n", PM_VERB_OCONV, "N", "surfaces in a cube before it is divided (6)",
     TAKE(take_set_size)},
    {"-r", PM_VERB_OCONV, "N", "width of the scene in smallest cubes (16384)",
     TAKE(take_resolution)},
    {"-b", PM_VERB_OCONV, "X Y Z SIZE", "the cube; without it, the smallest that fits",
     TAKE(take_bounds)},
    {"-f", PM_VERB_OCONV, "", "freeze: put the primitives into the octree, not their files",
     SWITCH(oconv.frozen, true)},
    {"-i", PM_VERB_OCONV, "OCTREE", "start from an octree, and add the files to it",
     TAKE(take_input_octree)},
    {"-w", PM_VERB_OCONV, "", "no notes on standard error, errors only", SWITCH(quiet, true)},
    {"-o", PM_VERB_OCONV, "FILE", "where to write (standard output)", TAKE(take_output)},
    {"--server", ONLINE | MAPS, "URL",
     "a running server (PM_SERVER); without one, a private one", TAKE(take_server)},
    {"--token-file", ONLINE | MAPS, "FILE", "bearer token of the server (PM_TOKEN_FILE)",
     TAKE(take_token_file)},
    {"--json", PM_VERB_SCENE | PM_VERB_MAP | PM_VERB_JOB, "",
     "the server's document as it came", SWITCH(json, true)},
    {"-q", ALL, "", "errors only; lists without their headings", SWITCH(quiet, true)},
    {"-v", ALL & ~PM_VERB_MKPMAP, "", "say more", SWITCH(verbose, true)},
    {"--help", ALL, "", "this text", SWITCH(help, true)},
};

enum { OPTIONS = sizeof options / sizeof *options };

static const char *closest_option(const struct pm_words *words)
{
    const char *names[OPTIONS];
    size_t count = 0;
    for (size_t i = 0; i < OPTIONS; i++)
        if (options[i].verbs & words->out->verb)
            names[count++] = options[i].name;
    return pm_closest(words->option, names, count);
}

static pm_status refuse(struct pm_words *words)
{
    const char *option = words->option,
               *reason = pm_refusal_of(words->out->verb, words->option);
    if (reason)
        return pm_error_set(words->err, PM_E_UNSUPPORTED, "%s: %s", option, reason);
    for (size_t i = 0; i < OPTIONS; i++)
        if (!strcmp(option, options[i].name))
            return pm_error_set(words->err, PM_E_UNSUPPORTED,
                                "%s: has no meaning here; --help lists what has", option);
    const char *closest = closest_option(words);
    if (closest)
        return pm_error_set(words->err, PM_E_UNSUPPORTED,
                            "%s: unknown option; did you mean %s?", option, closest);
    return pm_error_set(words->err, PM_E_UNSUPPORTED, "%s: unknown option; --help lists them",
                        option);
}

/* --time=30s is --time 30s. */
static void split_at_equals(struct pm_words *words)
{
    const char *equals = strchr(words->option, '=');
    if (strncmp(words->option, "--", 2) || !equals ||
        (size_t)(equals - words->option) >= sizeof words->name)
        return;
    snprintf(words->name, sizeof words->name, "%.*s", (int)(equals - words->option),
             words->option);
    words->option = words->name;
    words->value = equals + 1;
}

/* A switch of Radiance's may have a letter behind it. */
static bool is_named(const struct pm_option *entry, const char *word)
{
    bool toggles = entry->take == toggle || entry->take == pm_take_back_faces;
    size_t length = strlen(entry->name);
    const char *tail = word + length;
    if (strncmp(word, entry->name, length) != 0)
        return false;
    if (entry->letters)
        return *tail && strspn(tail, entry->letters) == strlen(tail);
    return !*tail || (toggles && strchr(PM_SWITCH_TAILS, *tail) && !tail[1]);
}

static pm_status take_option(struct pm_words *words)
{
    split_at_equals(words);
    for (size_t i = 0; i < OPTIONS; i++) {
        if (!(options[i].verbs & words->out->verb) || !is_named(&options[i], words->option))
            continue;
        words->entry = &options[i];
        pm_status st = options[i].take(words);
        if (!st && words->value)
            return pm_error_set(words->err, PM_E_RANGE, "%s: takes no value", words->option);
        return st;
    }
    return refuse(words);
}

static const pm_dump_option default_dump = {.count = 10000, .radius_scale = 1};

static pm_status take_operand(struct pm_words *words)
{
    pm_options *out = words->out;
    if (words->option[0] == '@')
        return pm_error_set(words->err, PM_E_UNSUPPORTED,
                            "%s: options are not read from a file; say $(cat %s)",
                            words->option, words->option + 1);
    if (out->operand_count == PM_OPERANDS_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: too many files", words->option);
    out->dumps[out->operand_count] = out->dump;
    out->dump = default_dump;
    out->operands[out->operand_count++] = words->option;
    return PM_OK;
}

static bool is_option(const char *word)
{
    return word[0] == '-' && word[1];
}

static bool has_range(const pm_options *said)
{
    bool any = false;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        any = any || said->maps[kind].gather_max || said->detected[kind].gather_max;
    return any;
}

pm_status pm_options_parse(pm_verb verb, int argc, char **argv, pm_options *out, pm_error *err)
{
    pm_options result = {.verb = verb,
                         .server = getenv("PM_SERVER"),
                         .token_file = getenv("PM_TOKEN_FILE"),
                         .view = pm_view_default(),
                         .ambient_bounces = verb & RENDERING ? 1 : 0,
                         .x = verb & PICTURES ? 512 : 0,
                         .y = verb & PICTURES ? 512 : 0,
                         .input_format = 'a',
                         .output_format = 'a',
                         .fields = "v",
                         .pixel_aspect = 1,
                         .dump = default_dump};
    struct pm_words words = {.argc = argc, .argv = argv, .out = &result, .err = err};
    pm_status st = PM_OK;
    while (words.at < argc && !st) {
        words.option = argv[words.at++];
        st = is_option(words.option) ? take_option(&words) : take_operand(&words);
    }
    if (!st)
        st = pm_check_forward(&result, err);
    if (!st && result.bandwidth && !has_range(&result))
        st = pm_error_set(err, PM_E_MISSING,
                          "--bandwidth: there is nothing to choose: give a map two numbers of "
                          "photons an estimate, e.g. 50 500");
    if (st) {
        pm_options_clear(&result);
        return st;
    }
    if (result.sequence && result.maps[PM_MAP_GLOBAL].precomputed)
        return pm_error_set(err, PM_E_UNSUPPORTED,
                            "--passes: a precomputed map is one map; leave it out, or ask for "
                            "-apg");
    if (result.fraction > 0 && !result.maps[PM_MAP_GLOBAL].precomputed)
        return pm_error_set(err, PM_E_MISSING,
                            "-apP: there is no precomputed map; ask for one with -app");
    if (result.server && !*result.server)
        result.server = NULL;
    *out = result;
    return PM_OK;
}

void pm_options_clear(pm_options *read)
{
    for (size_t i = 0; i < read->name_file_count; i++)
        free(read->name_files[i]);
    read->name_file_count = 0;
}

void pm_options_print(pm_verb verb, FILE *to)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        if (!(options[i].verbs & verb))
            continue;
        char left[64];
        snprintf(left, sizeof left, "%s %s", options[i].name, options[i].arguments);
        fprintf(to, "  %-20s %s\n", left, options[i].doc);
    }
}
