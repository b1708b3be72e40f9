#include "options.h"

#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "name_file.h"
#include "photons/bias.h"
#include "refusals.h"

enum {
    RENDERING = PM_VERB_RENDER | PM_VERB_TRACE,
    RADIANCE = PM_VERB_RPICT | PM_VERB_RTRACE,
    PICTURES = PM_VERB_RENDER | PM_VERB_RPICT,
    POINTS = PM_VERB_TRACE | PM_VERB_RTRACE,
    LOOKING = RENDERING | RADIANCE,
    WORKING = LOOKING | PM_VERB_MKPMAP,
    TRACING = RENDERING | PM_VERB_MKPMAP, /* verbs that trace photons */
    ONLINE = WORKING | PM_VERB_SCENE | PM_VERB_MAP | PM_VERB_JOB,
    MAPS = PM_VERB_PMAPINFO | PM_VERB_PMAPDUMP,
    ALL = ONLINE | MAPS | PM_VERB_OCONV,
};

struct words;

struct option {
    const char *name;
    unsigned verbs;
    const char *arguments;
    const char *doc;
    pm_status (*take)(struct words *words);
    size_t offset; /* of a switch: its place in pm_options and what it sets there */
    bool value;
    const char *letters; /* one or more of these follow the name; NULL: none do */
};

/* Where reading stands. */
struct words {
    const struct option *entry; /* the option being read, if it is in the table */
    int argc;
    char **argv;
    int at;             /* the next word */
    const char *option; /* the one being read */
    const char *value;  /* what stood behind its '=', until it is taken */
    char name[32];      /* its name then */
    pm_options *out;
    pm_error *err;
};

/* ---- numbers with suffixes ---- */

static bool read_number(const char *text, double *out, const char **end)
{
    char *stop;
    errno = 0;
    if (!strchr("0123456789+-.", *text) || !*text)
        return false;
    double value = strtod(text, &stop);
    if (stop == text || !isfinite(value))
        return false;
    *out = value;
    *end = stop;
    return true;
}

pm_status pm_count_parse(const char *text, uint64_t *out)
{
    static const char suffixes[] = "kmg";
    double value, factor = 1;
    const char *end;
    if (!read_number(text, &value, &end) || value < 0)
        return PM_E_RANGE;
    const char *suffix = *end ? strchr(suffixes, *end | 0x20) : NULL;
    if (*end && (!suffix || end[1]))
        return PM_E_RANGE;
    for (const char *s = suffixes; suffix && s <= suffix; s++)
        factor *= 1000;
    value *= factor;
    if (value != floor(value) || value > 0x1p53)
        return PM_E_RANGE;
    *out = (uint64_t)value;
    return PM_OK;
}

pm_status pm_seconds_parse(const char *text, double *out)
{
    double value;
    const char *end;
    if (!read_number(text, &value, &end) || !(value > 0) || (*end && end[1]))
        return PM_E_RANGE;
    if (*end && !strchr("smh", *end))
        return PM_E_RANGE;
    *out = value * (*end == 'm' ? 60 : *end == 'h' ? 3600 : 1);
    return PM_OK;
}

pm_status pm_share_parse(const char *text, double *out)
{
    double value;
    const char *end;
    if (!read_number(text, &value, &end))
        return PM_E_RANGE;
    if (!strcmp(end, "%"))
        value /= 100;
    else if (*end)
        return PM_E_RANGE;
    if (!(value > 0) || value > 1)
        return PM_E_RANGE;
    *out = value;
    return PM_OK;
}

/* ---- arguments of options ---- */

static pm_status bad(const struct words *words, const char *got, const char *right)
{
    return pm_error_set(words->err, PM_E_RANGE, "%s %s: must be %s", words->option, got, right);
}

#define TAILS "+1yYtT-0nNfF" /* of a switch of Radiance's: on, then off */

/* Without a tail it becomes the other. */
static void read_toggle(const struct words *words, bool *out)
{
    const char *tail = words->option + strlen(words->entry->name);
    *out = *tail ? strchr(TAILS, *tail) < strchr(TAILS, '-') : !*out;
}

static pm_status take_text(struct words *words, const char *what, const char **out)
{
    if (!words->value && words->at >= words->argc)
        return pm_error_set(words->err, PM_E_MISSING, "%s: %s is missing behind it",
                            words->option, what);
    *out = words->value ? words->value : words->argv[words->at++];
    words->value = NULL;
    return PM_OK;
}

static pm_status take_count(struct words *words, const char *what, uint64_t low, uint64_t high,
                            uint64_t *out)
{
    const char *text = NULL;
    pm_status st = take_text(words, what, &text);
    if (st)
        return st;
    if (!pm_count_parse(text, out) && *out >= low && *out <= high)
        return PM_OK;
    char right[160];
    snprintf(right, sizeof right,
             "%s, a whole number from %llu to %llu (10k, 1m are understood)", what,
             (unsigned long long)low, (unsigned long long)high);
    return bad(words, text, right);
}

static pm_status take_u32(struct words *words, const char *what, uint32_t low, uint32_t high,
                          uint32_t *out)
{
    uint64_t value = 0;
    pm_status st = take_count(words, what, low, high, &value);
    if (!st)
        *out = (uint32_t)value;
    return st;
}

static pm_status take_number(struct words *words, const char *what, double *out)
{
    const char *text = NULL, *end;
    pm_status st = take_text(words, what, &text);
    if (st)
        return st;
    return read_number(text, out, &end) && !*end ? PM_OK : bad(words, text, what);
}

static bool next_is_count(const struct words *words)
{
    uint64_t count;
    return words->at < words->argc && !pm_count_parse(words->argv[words->at], &count);
}

/* ---- options ---- */

static pm_map_kind kind_of(const char *option)
{
    switch (option[3]) {
    case 'c':
        return PM_MAP_CAUSTIC;
    case 'v':
        return PM_MAP_VOLUME;
    case 'd':
        return PM_MAP_DIRECT;
    default:
        return PM_MAP_GLOBAL;
    }
}

/* A gather count may follow; and a second one, which asks for bias compensation. */
static pm_status take_gather(struct words *words, uint32_t *least, uint32_t *most)
{
    if (!next_is_count(words))
        return PM_OK;
    pm_status st = take_u32(words, "photons an estimate", 1, PM_GATHER_MAX, least);
    if (!st && next_is_count(words))
        st = take_u32(words, "the most photons an estimate", *least + 1, PM_GATHER_MAX, most);
    return st;
}

/* -apcb: both are asked for. */
static pm_status require_range(const struct words *words, const pm_map_option *map)
{
    if (words->option[4] != 'b' || map->gather_max)
        return PM_OK;
    return pm_error_set(
        words->err, PM_E_MISSING,
        "%s: the fewest and the most photons an estimate are missing behind the "
        "file, e.g. 50 500",
        words->option);
}

/* A precomputed map stands in for the global one. */
static pm_status check_alone(const struct words *words, const pm_map_option *map,
                             bool precomputed)
{
    if (!map->given || map->precomputed == precomputed)
        return PM_OK;
    return pm_error_set(words->err, PM_E_RANGE,
                        "%s: a precomputed map stands in for the global one; give one of -apg "
                        "and -app",
                        words->option);
}

/* -app N BW | mkpmap -app FILE N BW | rpict -app FILE [1] */
static pm_status take_precomputed(struct words *words)
{
    pm_verb verb = words->out->verb;
    pm_map_option *map = &words->out->maps[PM_MAP_GLOBAL];
    pm_status st = check_alone(words, map, true);
    if (st)
        return st;
    *map = (pm_map_option){.given = true, .precomputed = true};
    if (!(verb & RENDERING))
        st = take_text(words, "a file", &map->file);
    if (st || verb & (PM_VERB_RPICT | PM_VERB_RTRACE)) {
        uint32_t one;
        return st || !next_is_count(words)
                   ? st
                   : take_u32(words, "1 or nothing, as the closest photon alone is looked up",
                              1, 1, &one);
    }
    st = take_count(words, "a number of photons", 1, 1000000000, &map->count);
    if (!st)
        st = take_u32(words, "photons that irradiance is precomputed from", 1,
                      map->count < PM_GATHER_MAX ? (uint32_t)map->count : PM_GATHER_MAX,
                      &map->gather);
    return st;
}

static pm_status take_fraction(struct words *words)
{
    double *fraction = &words->out->fraction;
    pm_status st = take_number(words, "a fraction", fraction);
    if (!st && !(*fraction >= 1e-9 && *fraction <= 1))
        st = bad(words, words->argv[words->at - 1], "greater than 0, at most 1");
    return st;
}

/* -apg N [K [K2]] | mkpmap -apg FILE N | rpict -apg FILE [K [K2]] | rpict -apgb FILE K K2 */
static pm_status take_map(struct words *words)
{
    pm_verb verb = words->out->verb;
    pm_map_option *map = &words->out->maps[kind_of(words->option)];
    pm_status st = check_alone(words, map, false);
    if (st)
        return st;
    *map = (pm_map_option){.given = true};
    if (!(verb & RENDERING))
        st = take_text(words, "a file", &map->file);
    if (!st && (verb & (RENDERING | PM_VERB_MKPMAP)))
        st = take_count(words, "a number of photons", 1, 1000000000, &map->count);
    if (!st && verb != PM_VERB_MKPMAP)
        st = take_gather(words, &map->gather, &map->gather_max);
    return st ? st : require_range(words, map);
}

static pm_status take_detected_map(struct words *words)
{
    pm_status st = take_text(words, "a file", &words->out->detected_map);
    return st ? st
              : take_gather(words, &words->out->detected_gather,
                            &words->out->detected_gather_max);
}

static pm_status take_bandwidth(struct words *words)
{
    const char *text = NULL;
    pm_status st = take_text(words, "bias or chi2", &text);
    if (st)
        return st;
    for (int b = 0; b < PM_BANDWIDTHS; b++)
        if (!strcmp(text, pm_bandwidth_name((pm_bandwidth)b)))
            words->out->bandwidth = text;
    return words->out->bandwidth ? PM_OK : bad(words, text, "bias or chi2");
}

static pm_status take_bounces(struct words *words)
{
    double value;
    pm_status st = take_number(words, "a whole number", &value);
    if (st)
        return st;
    if (value != floor(value) || fabs(value) > 100)
        return bad(words, words->argv[words->at - 1], "a whole number from -100 to 100");
    words->out->ambient_bounces = (int)value;
    return PM_OK;
}

static pm_status take_vector(struct words *words)
{
    pm_view *view = &words->out->view;
    pm_vec3 *v = words->option[2] == 'p'   ? &view->point
                 : words->option[2] == 'd' ? &view->direction
                                           : &view->up;
    pm_status st = take_number(words, "three numbers x y z", &v->x);
    if (!st)
        st = take_number(words, "three numbers x y z", &v->y);
    if (!st)
        st = take_number(words, "three numbers x y z", &v->z);
    return st;
}

static pm_status take_angle(struct words *words)
{
    pm_view *view = &words->out->view;
    return take_number(words, "an angle in degrees",
                       words->option[2] == 'h' ? &view->horizontal : &view->vertical);
}

/* What a view file says in the same words, e.g. -vta, -vs .5. */
static pm_status take_other_view(struct words *words)
{
    char text[128];
    const char *value = "";
    if (strncmp(words->option, "-vt", 3)) {
        pm_status st = take_text(words, "a number", &value);
        if (st)
            return st;
    }
    snprintf(text, sizeof text, "%s %s", words->option, value);
    pm_error err = PM_ERROR_INIT;
    pm_status st = pm_view_parse(text, "view", &words->out->view, &err);
    return st ? pm_error_set(words->err, st, "%s: %s", words->option, err.text) : PM_OK;
}

static pm_status take_view_file(struct words *words)
{
    const char *path = NULL;
    pm_status st = take_text(words, "a file", &path);
    if (st)
        return st;
    char text[65536];
    FILE *file = fopen(path, "rb");
    if (!file)
        return pm_error_set_at(words->err, PM_E_IO, path, 0, 0, "cannot be read: %s",
                               strerror(errno));
    size_t size = fread(text, 1, sizeof text - 1, file);
    bool whole = feof(file) && !ferror(file);
    fclose(file);
    text[size] = '\0';
    if (!whole || strlen(text) != size)
        return pm_error_set_at(words->err, PM_E_SYNTAX, path, 0, 0,
                               "is no view file: a line like `rvu -vtv -vp 0 0 1 -vd 0 1 0`");
    return pm_view_parse(text, path, &words->out->view, words->err);
}

static pm_status take_size(struct words *words)
{
    return take_u32(words, "pixels", 1, 16384,
                    words->option[1] == 'x' ? &words->out->x : &words->out->y);
}

static pm_status take_aspect(struct words *words)
{
    pm_status st = take_number(words, "a number", &words->out->pixel_aspect);
    if (st)
        return st;
    if (!(words->out->pixel_aspect >= 0 && words->out->pixel_aspect <= 1e6))
        return bad(
            words, words->argv[words->at - 1],
            "the height of a pixel over its width, at most 1e6, or 0 (exactly -x by -y)");
    return PM_OK;
}

static pm_status take_sequence(struct words *words)
{
    return take_u32(words, "passes", 1, PM_PASSES_MAX, &words->out->sequence);
}

static pm_status take_pass(struct words *words)
{
    words->out->one_pass = true;
    return take_u32(words, "a pass, counted from 0", 0, PM_PASSES_MAX - 1, &words->out->pass);
}

static pm_status take_passes(struct words *words)
{
    return take_u32(words, "passes", 1, 1U << 24, &words->out->passes);
}

static pm_status take_time(struct words *words)
{
    const char *text = NULL;
    pm_status st = take_text(words, "a time", &text);
    if (!st && pm_seconds_parse(text, &words->out->seconds))
        st = bad(words, text, "a time such as 30s, 5m, 1h");
    return st;
}

static pm_status take_error(struct words *words)
{
    const char *text = NULL;
    pm_status st = take_text(words, "an error", &text);
    if (!st && pm_share_parse(text, &words->out->error))
        st = bad(words, text, "a relative error such as 2% or .02, at most 1");
    return st;
}

static pm_status take_seed(struct words *words)
{
    return take_count(words, "a seed", 0, UINT64_C(1) << 53, &words->out->seed);
}

static pm_status take_max_events(struct words *words)
{
    return take_u32(words, "scatterings", 1, 50000, &words->out->max_events);
}

static pm_status take_max_length(struct words *words)
{
    double *length = &words->out->max_length;
    pm_status st = take_number(words, "a length", length);
    if (!st && !(*length > 0 && *length <= PM_LENGTH_MAX))
        st = bad(words, words->argv[words->at - 1], "a length greater than 0 [scene units]");
    return st;
}

/* ---- the medium that fills the scene ---- */

static pm_status take_numbers(struct words *words, const char *what, size_t count, double *out)
{
    pm_status st = PM_OK;
    for (size_t i = 0; i < count && !st; i++)
        st = take_number(words, what, &out[i]);
    return st;
}

static pm_status take_medium(struct words *words)
{
    pm_surroundings *s = &words->out->surroundings;
    pm_rgb *color = words->option[2] == 'e' ? &s->extinction : &s->albedo;
    double n[3] = {0};
    pm_status st = take_numbers(words, "three numbers r g b", 3, n);
    *color = (pm_rgb){n[0], n[1], n[2]};
    return st;
}

static pm_status take_eccentricity(struct words *words)
{
    return take_number(words, "a number between -1 and 1",
                       &words->out->surroundings.eccentricity);
}

/* -bv shows back faces or hides them; the member says that they are hidden. */
static pm_status take_back_faces(struct words *words)
{
    bool shown = !words->out->surroundings.no_back_faces;
    read_toggle(words, &shown);
    words->out->surroundings.no_back_faces = !shown;
    return PM_OK;
}

/* ---- surfaces and regions ---- */

/* The modifiers that the option is about: -aps, -ae, -ai, and capitals, which name files. */
static pm_names_option *names_of(const struct words *words)
{
    char last = words->option[strlen(words->option) - 1] | 0x20;
    pm_options *out = words->out;
    return last == 's' ? &out->sensors : last == 'e' ? &out->exclude : &out->include;
}

static pm_status take_name(struct words *words)
{
    pm_names_option *list = names_of(words);
    const char *name = NULL;
    pm_status st = take_text(words, "a modifier", &name);
    if (st)
        return st;
    if (!*name)
        return bad(words, "''", "the name of a modifier");
    if (list->count == PM_NAMES_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d modifiers", words->option,
                            PM_NAMES_MAX);
    list->names[list->count++] = name;
    return PM_OK;
}

static pm_status take_name_file(struct words *words)
{
    pm_names_option *list = names_of(words);
    pm_options *out = words->out;
    const char *path = NULL;
    size_t count = 0;
    pm_status st = take_text(words, "a file of modifiers", &path);
    if (st)
        return st;
    if (out->name_file_count == PM_NAME_FILES_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d files of modifiers",
                            words->option, PM_NAME_FILES_MAX);
    st = pm_name_file_read(path, PM_NAMES_MAX - list->count, list->names + list->count, &count,
                           &out->name_files[out->name_file_count], words->err);
    if (!st) {
        out->name_file_count++;
        list->count += count;
    }
    return st;
}

/* -apo or -apo+: to the front; -apo-: to the back; -apo0: to both. */
static unsigned sides_of(const struct words *words)
{
    switch (words->option[4]) {
    case '-':
        return PM_PORT_BACK;
    case '0':
        return PM_PORT_FRONT | PM_PORT_BACK;
    default:
        return PM_PORT_FRONT;
    }
}

static pm_status take_port(struct words *words)
{
    pm_options *out = words->out;
    const char *name = NULL;
    pm_status st = take_text(words, "a modifier", &name);
    if (st)
        return st;
    if (!*name)
        return bad(words, "''", "the name of a modifier");
    if (out->port_count == PM_NAMES_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d modifiers", words->option,
                            PM_NAMES_MAX);
    out->ports[out->port_count++] = (pm_port_option){name, sides_of(words)};
    return PM_OK;
}

static pm_status take_port_file(struct words *words)
{
    pm_options *out = words->out;
    const char *path = NULL, *names[PM_NAMES_MAX];
    size_t count = 0;
    pm_status st = take_text(words, "a file of modifiers", &path);
    if (st)
        return st;
    if (out->name_file_count == PM_NAME_FILES_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d files of modifiers",
                            words->option, PM_NAME_FILES_MAX);
    st = pm_name_file_read(path, PM_NAMES_MAX - out->port_count, names, &count,
                           &out->name_files[out->name_file_count], words->err);
    if (st)
        return st;
    out->name_file_count++;
    for (size_t i = 0; i < count; i++)
        out->ports[out->port_count++] = (pm_port_option){names[i], sides_of(words)};
    return PM_OK;
}

static pm_status take_port_tables(struct words *words)
{
    bool directions = words->option[2] == 'p';
    double *out = directions ? &words->out->direction_resolution : &words->out->partition;
    double low = directions ? 1 : PM_PARTITION_MIN, high = directions ? PM_DIRECTIONS_MAX : 1;
    pm_status st = take_number(words, "a number", out);
    if (st || (*out >= low && *out <= high))
        return st;
    char right[80];
    snprintf(right, sizeof right, "%g to %g", low, high);
    return bad(words, words->argv[words->at - 1], right);
}

/* -api x y z x y z | -apI x y z radius */
static pm_status take_region(struct words *words)
{
    pm_options *out = words->out;
    bool ball = words->option[3] == 'I';
    double n[6] = {0};
    if (out->region_count == PM_REGIONS_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d regions", words->option,
                            PM_REGIONS_MAX);
    pm_status st = ball ? take_numbers(words, "a ball: x y z radius", 4, n)
                        : take_numbers(words, "a box: two corners x y z x y z", 6, n);
    if (st)
        return st;
    pm_region *region = &out->regions[out->region_count++];
    if (ball)
        *region = (pm_region){.is_ball = true, .center = {n[0], n[1], n[2]}, .radius = n[3]};
    else
        *region = (pm_region){.low = {n[0], n[1], n[2]}, .high = {n[3], n[4], n[5]}};
    return PM_OK;
}

/* What the options of the forward pass and of the scene say together. */
static pm_status check_forward(const pm_options *read, pm_error *err)
{
    pm_forward_options forward = pm_forward_defaults();
    if (!read->port_count && (read->direction_resolution > 0 || read->partition > 0))
        return pm_error_set(err, PM_E_RANGE,
                            "%s: has no meaning without -apo: lamps are sampled exactly",
                            read->partition > 0 ? "-ds" : "-dp");
    forward.exclude = (pm_name_list){read->exclude.names, read->exclude.count};
    forward.include = (pm_name_list){read->include.names, read->include.count};
    forward.regions = read->regions;
    forward.region_count = read->region_count;
    pm_status st = pm_surroundings_check(&read->surroundings, err);
    return st ? st : pm_forward_options_check(&forward, err);
}

static pm_status take_threads(struct words *words)
{
    return take_u32(words, "threads", 0, 256, &words->out->threads);
}

static pm_status take_interval(struct words *words)
{
    const char *text = NULL;
    pm_status st = take_text(words, "seconds", &text);
    double *out = &words->out->progress_seconds;
    if (!st && strcmp(text, "0") && pm_seconds_parse(text, out))
        st = bad(words, text, "seconds between reports, 0 for none");
    return st;
}

static pm_status take_output(struct words *words)
{
    const char *path = NULL;
    pm_status st = take_text(words, "a file", &path);
    if (st)
        return st;
    if (words->out->output_count == PM_OUTPUTS_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "-o: at most %d files", PM_OUTPUTS_MAX);
    words->out->outputs[words->out->output_count++] = path;
    return PM_OK;
}

static pm_status take_messages(struct words *words)
{
    return take_text(words, "a file", &words->out->messages);
}

static pm_status take_allowed(struct words *words)
{
    const char *folder = NULL;
    pm_status st = take_text(words, "a folder", &folder);
    if (st)
        return st;
    if (words->out->allowed_count == PM_ALLOWED_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "--allow: at most %d folders",
                            PM_ALLOWED_MAX);
    words->out->allowed[words->out->allowed_count++] = folder;
    return PM_OK;
}

static pm_status take_dump_count(struct words *words)
{
    return take_count(words, "photons", 1, UINT64_C(1) << 53, &words->out->dump.count);
}

static pm_status take_dump_radius(struct words *words)
{
    double *scale = &words->out->dump.radius_scale;
    pm_status st = take_number(words, "a factor", scale);
    if (!st && !(*scale > 0))
        st = bad(words, words->argv[words->at - 1], "a factor greater than 0");
    return st;
}

static pm_status take_dump_color(struct words *words)
{
    pm_dump_option *dump = &words->out->dump;
    double *const channels[3] = {&dump->color.r, &dump->color.g, &dump->color.b};
    pm_status st = PM_OK;
    dump->colored = true;
    for (int i = 0; i < 3 && !st; i++) {
        st = take_number(words, "a colour: r g b", channels[i]);
        if (!st && !(*channels[i] >= 0))
            st = bad(words, words->argv[words->at - 1], "radiances of 0 or more");
    }
    return st;
}

static pm_status take_set_size(struct words *words)
{
    return take_u32(words, "surfaces", 1, 511, &words->out->oconv.set_size);
}

static pm_status take_resolution(struct words *words)
{
    return take_u32(words, "smallest cubes across the scene", 1, 1 << 20,
                    &words->out->oconv.resolution);
}

static pm_status take_bounds(struct words *words)
{
    pm_oconv_option *o = &words->out->oconv;
    pm_status st = PM_OK;
    for (int i = 0; !st && i < 4; i++)
        st = take_number(words, "four numbers: the lowest corner x y z and the width",
                         i < 3 ? &o->corner[i] : &o->edge);
    if (!st && !(o->edge > 0))
        return bad(words, words->argv[words->at - 1], "a width greater than 0");
    o->bounded = true;
    return st;
}

static pm_status take_input_octree(struct words *words)
{
    return take_text(words, "an octree", &words->out->oconv.input);
}

static pm_status take_server(struct words *words)
{
    return take_text(words, "an address such as http://127.0.0.1:8080", &words->out->server);
}

static pm_status take_token_file(struct words *words)
{
    return take_text(words, "a file", &words->out->token_file);
}

#define SWITCH(member, to)     set_switch, offsetof(pm_options, member), to, NULL
#define DUMP(member, to)       set_switch, offsetof(pm_options, dump.member), to, NULL
#define TOGGLE(member)         toggle, offsetof(pm_options, member), false, NULL
#define TAKE(take)             take, 0, false, NULL
#define LETTERS(take, letters) take, 0, false, letters

static pm_status toggle(struct words *words)
{
    read_toggle(words, (bool *)((char *)words->out + words->entry->offset));
    return PM_OK;
}

static pm_status set_switch(struct words *words)
{
    const struct option *entry = words->entry;
    *(bool *)((char *)words->out + entry->offset) = entry->value;
    return PM_OK;
}

/* -f[adf][adfc]: of points, then of values; one letter says both. */
static pm_status take_formats(struct words *words)
{
    const char *letters = words->option + 2;
    if (strlen(letters) > 2 || letters[0] == 'c')
        return bad(words, words->option,
                   "-f with one of a (text), f (float), d (double) for the points, and one of "
                   "these or c (pixels) for the values");
    words->out->input_format = letters[0];
    words->out->output_format = letters[letters[1] ? 1 : 0];
    return PM_OK;
}

static pm_status take_fields(struct words *words)
{
    const char *letters = words->option + 2;
    if (strlen(letters) >= sizeof words->out->fields)
        return bad(words, words->option, "-o with 15 letters at most");
    snprintf(words->out->fields, sizeof words->out->fields, "%s", letters);
    return PM_OK;
}

static const struct option options[] = {
    {"-apg", RENDERING, "N [K [K2]]",
     "global map of about N photons, K an estimate (40); K2: up to so many, see --bandwidth",
     TAKE(take_map)},
    {"-apc", RENDERING, "N [K [K2]]", "caustic map, likewise", TAKE(take_map)},
    {"-apv", RENDERING, "N [K [K2]]", "volume map, likewise", TAKE(take_map)},
    {"-apg", PM_VERB_MKPMAP, "FILE N", "write a global map of about N photons", TAKE(take_map)},
    {"-apc", PM_VERB_MKPMAP, "FILE N", "write a caustic map", TAKE(take_map)},
    {"-apv", PM_VERB_MKPMAP, "FILE N", "write a volume map", TAKE(take_map)},
    {"-apd", PM_VERB_MKPMAP, "FILE N", "write a direct map, to be looked at with pmapdump",
     TAKE(take_map)},
    {"-apg", RADIANCE, "FILE [K [K2]]",
     "global map from a file, K photons an estimate (40); K2: up to so many, see --bandwidth",
     TAKE(take_map)},
    {"-apc", RADIANCE, "FILE [K [K2]]", "caustic map from a file", TAKE(take_map)},
    {"-apv", RADIANCE, "FILE [K [K2]]", "volume map from a file", TAKE(take_map)},
    {"-app", RENDERING, "N BW",
     "instead of -apg: irradiance from BW photons, precomputed at some of N (see -apP)",
     TAKE(take_precomputed)},
    {"-app", PM_VERB_MKPMAP, "FILE N BW",
     "write a global map of N photons with irradiance from BW of them precomputed (see -apP)",
     TAKE(take_precomputed)},
    {"-app", RADIANCE, "FILE [1]", "a precomputed map from a file, in the place of -apg",
     TAKE(take_precomputed)},
    {"-apP", RENDERING | PM_VERB_MKPMAP, "F",
     "of -app: the share of the photons that is kept (.25)", TAKE(take_fraction)},
    {"-apf", RENDERING | PM_VERB_MKPMAP, "F", "the same", TAKE(take_fraction)},
    {"-ap", RADIANCE, "FILE [K [K2]]", "a map from a file, of whatever kind it is",
     TAKE(take_detected_map)},
    {"-apgb", RADIANCE, "FILE K K2", "the same as -apg FILE K K2", TAKE(take_map)},
    {"-apcb", RADIANCE, "FILE K K2", "the same as -apc FILE K K2", TAKE(take_map)},
    {"-apvb", RADIANCE, "FILE K K2", "the same as -apv FILE K K2", TAKE(take_map)},
    {"--bandwidth", LOOKING, "RULE",
     "how K to K2 photons are chosen: bias (compensation; the default) or chi2 (while evenly "
     "spread)",
     TAKE(take_bandwidth)},
    {"-ab", LOOKING, "N",
     "> 0: final gather into the global map; < 0: that map itself; 0: caustics alone",
     TAKE(take_bounces)},
    {"--vf", PICTURES, "FILE", "view file", TAKE(take_view_file)},
    {"-vf", PICTURES, "FILE", "the same", TAKE(take_view_file)},
    {"-vp", PICTURES, "X Y Z", "view point (0 0 0)", TAKE(take_vector)},
    {"-vd", PICTURES, "X Y Z", "view direction (0 1 0)", TAKE(take_vector)},
    {"-vu", PICTURES, "X Y Z", "up (0 0 1)", TAKE(take_vector)},
    {"-vh", PICTURES, "DEGREES", "horizontal angle of view (45); with -vtl the width seen",
     TAKE(take_angle)},
    {"-vv", PICTURES, "DEGREES", "vertical angle of view (45); with -vtl the height seen",
     TAKE(take_angle)},
    {"-vtv", PICTURES, "", "perspective view (the default)", TAKE(take_other_view)},
    {"-vtl", PICTURES, "", "parallel view; plans and sections", TAKE(take_other_view)},
    {"-vth", PICTURES, "", "hemispherical fisheye", TAKE(take_other_view)},
    {"-vtc", PICTURES, "", "cylindrical panorama", TAKE(take_other_view)},
    {"-vta", PICTURES, "", "angular fisheye, up to all around", TAKE(take_other_view)},
    {"-vts", PICTURES, "", "stereographic fisheye", TAKE(take_other_view)},
    {"-vs", PICTURES, "WIDTHS", "shift the picture to the right (0)", TAKE(take_other_view)},
    {"-vl", PICTURES, "HEIGHTS", "lift the picture (0)", TAKE(take_other_view)},
    {"-vo", PICTURES, "LENGTH", "leave out what is nearer (0)", TAKE(take_other_view)},
    {"-va", PICTURES, "LENGTH", "leave out what is farther (0: nothing)",
     TAKE(take_other_view)},
    {"-x", PICTURES, "N", "greatest width in pixels (512)", TAKE(take_size)},
    {"-y", PICTURES, "N", "greatest height in pixels (512)", TAKE(take_size)},
    {"-pa", PICTURES, "RATIO",
     "height of a pixel over its width, within -x by -y; 0: exactly -x by -y (1)",
     TAKE(take_aspect)},
    {"--passes", LOOKING, "N", "stop after N passes", TAKE(take_passes)},
    {"--passes", PM_VERB_MKPMAP, "J",
     "sequences of J maps, each of as many photons and of paths of its own",
     TAKE(take_sequence)},
    {"--pass", PM_VERB_MAP, "J", "fetch pass J alone of a sequence, counted from 0",
     TAKE(take_pass)},
    {"--time", LOOKING, "TIME", "stop after so long, e.g. 30s, 5m", TAKE(take_time)},
    {"--error", LOOKING, "ERROR", "stop at this estimated relative error, e.g. 2%",
     TAKE(take_error)},
    {"-apr", WORKING, "SEED", "seed; equal seeds give equal bytes (0)", TAKE(take_seed)},
    {"-apm", WORKING, "N", "most scatterings on a photon's path (5000)", TAKE(take_max_events)},
    {"-lr", PM_VERB_MKPMAP, "N", "the same", TAKE(take_max_events)},
    {"-ld", TRACING, "LENGTH", "greatest length of a photon's path [scene units]",
     TAKE(take_max_length)},
    {"-apo", TRACING, "MOD",
     "surfaces of this modifier are ports: distant light enters through them alone, to their "
     "front",
     TAKE(take_port)},
    {"-apo+", TRACING, "MOD", "the same", TAKE(take_port)},
    {"-apo-", TRACING, "MOD", "ports from which light goes to their back", TAKE(take_port)},
    {"-apo0", TRACING, "MOD", "ports from which light goes to both sides", TAKE(take_port)},
    {"-apO", TRACING, "FILE", "ports for the modifiers in a file", TAKE(take_port_file)},
    {"-apO+", TRACING, "FILE", "the same", TAKE(take_port_file)},
    {"-apO-", TRACING, "FILE", "to their back", TAKE(take_port_file)},
    {"-apO0", TRACING, "FILE", "to both sides", TAKE(take_port_file)},
    {"-dp", TRACING, "N", "directions a steradian that a port's table tells apart (1000)",
     TAKE(take_port_tables)},
    {"-ds", TRACING, "SIZE", "of a port's patches, relative to the scene's cube (.01)",
     TAKE(take_port_tables)},
    {"-aps", PM_VERB_MKPMAP, "MOD", "surfaces of this modifier store photons on their front",
     TAKE(take_name)},
    {"-apS", PM_VERB_MKPMAP, "FILE", "the same for the modifiers in a file",
     TAKE(take_name_file)},
    {"-ae", PM_VERB_MKPMAP, "MOD", "surfaces of this modifier store no photons",
     TAKE(take_name)},
    {"-aE", PM_VERB_MKPMAP, "FILE", "the same for the modifiers in a file",
     TAKE(take_name_file)},
    {"-ai", PM_VERB_MKPMAP, "MOD", "surfaces of this modifier (and of other -ai) alone do",
     TAKE(take_name)},
    {"-aI", PM_VERB_MKPMAP, "FILE", "the same for the modifiers in a file",
     TAKE(take_name_file)},
    {"-api", PM_VERB_MKPMAP, "X Y Z X Y Z",
     "store photons in this box (and other regions) alone", TAKE(take_region)},
    {"-apI", PM_VERB_MKPMAP, "X Y Z RADIUS", "store photons in this ball alone",
     TAKE(take_region)},
    {"-n", WORKING, "N", "threads; the answer does not depend on it (0: one a processor)",
     TAKE(take_threads)},
    {"-t", WORKING, "SECONDS", "report progress as lines every so often", TAKE(take_interval)},
    {"-e", WORKING, "FILE", "append messages and progress to this file", TAKE(take_messages)},
    {"-fo", PM_VERB_MKPMAP, "", "-fo, -fo+: overwrite files that exist; -fo-: refuse to (-fo-)",
     TOGGLE(overwrite)},
    {"-me", WORKING, "R G B",
     "extinction of a medium that fills the scene [1 / scene unit] (0)", TAKE(take_medium)},
    {"-ma", WORKING, "R G B", "its albedo (0)", TAKE(take_medium)},
    {"-mg", WORKING, "G", "its eccentricity, -1 to 1 (0)", TAKE(take_eccentricity)},
    {"-bv", WORKING, "", "-bv+: surfaces are there from behind; -bv-: they are not (-bv+)",
     TAKE(take_back_faces)},
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
     TAKE(take_size)},
    {"-y", PM_VERB_RTRACE, "N", "and of that height", TAKE(take_size)},
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

static const char *closest_option(const struct words *words)
{
    const char *names[OPTIONS];
    size_t count = 0;
    for (size_t i = 0; i < OPTIONS; i++)
        if (options[i].verbs & words->out->verb)
            names[count++] = options[i].name;
    return pm_closest(words->option, names, count);
}

static pm_status refuse(struct words *words)
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
static void split_at_equals(struct words *words)
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
static bool is_named(const struct option *entry, const char *word)
{
    bool toggles = entry->take == toggle || entry->take == take_back_faces;
    size_t length = strlen(entry->name);
    const char *tail = word + length;
    if (strncmp(word, entry->name, length) != 0)
        return false;
    if (entry->letters)
        return *tail && strspn(tail, entry->letters) == strlen(tail);
    return !*tail || (toggles && strchr(TAILS, *tail) && !tail[1]);
}

static pm_status take_option(struct words *words)
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

static pm_status take_operand(struct words *words)
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
    bool any = said->detected_gather_max;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        any = any || said->maps[kind].gather_max;
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
    struct words words = {.argc = argc, .argv = argv, .out = &result, .err = err};
    pm_status st = PM_OK;
    while (words.at < argc && !st) {
        words.option = argv[words.at++];
        st = is_option(words.option) ? take_option(&words) : take_operand(&words);
    }
    if (!st)
        st = check_forward(&result, err);
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
