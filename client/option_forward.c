#include "option_words.h"

#include <stdio.h>
#include <string.h>

#include "name_file.h"

/* What bears on photons: the forward pass and what fills the scene. */

pm_status pm_take_seed(struct pm_words *words)
{
    return pm_word_count(words, "a seed", 0, UINT64_C(1) << 53, &words->out->seed);
}

pm_status pm_take_max_events(struct pm_words *words)
{
    return pm_word_u32(words, "scatterings", 1, 50000, &words->out->max_events);
}

pm_status pm_take_max_length(struct pm_words *words)
{
    double *length = &words->out->max_length;
    pm_status st = pm_word_number(words, "a length", length);
    if (!st && !(*length > 0 && *length <= PM_LENGTH_MAX))
        st = pm_word_bad(words, words->argv[words->at - 1],
                         "a length greater than 0 [scene units]");
    return st;
}

pm_status pm_take_medium(struct pm_words *words)
{
    pm_surroundings *s = &words->out->surroundings;
    pm_rgb *color = words->option[2] == 'e' ? &s->extinction : &s->albedo;
    double n[3] = {0};
    pm_status st = pm_word_numbers(words, "three numbers r g b", 3, n);
    *color = (pm_rgb){n[0], n[1], n[2]};
    return st;
}

pm_status pm_take_eccentricity(struct pm_words *words)
{
    return pm_word_number(words, "a number between -1 and 1",
                          &words->out->surroundings.eccentricity);
}

/* -bv shows back faces or hides them; the member says that they are hidden. */
pm_status pm_take_back_faces(struct pm_words *words)
{
    bool shown = !words->out->surroundings.no_back_faces;
    pm_word_toggle(words, &shown);
    words->out->surroundings.no_back_faces = !shown;
    return PM_OK;
}

/* The modifiers that the option is about: -aps, -ae, -ai, and capitals, which name files. */
static pm_names_option *names_of(const struct pm_words *words)
{
    char last = words->option[strlen(words->option) - 1] | 0x20;
    pm_options *out = words->out;
    return last == 's' ? &out->sensors : last == 'e' ? &out->exclude : &out->include;
}

pm_status pm_take_name(struct pm_words *words)
{
    pm_names_option *list = names_of(words);
    const char *name = NULL;
    pm_status st = pm_word_text(words, "a modifier", &name);
    if (st)
        return st;
    if (!*name)
        return pm_word_bad(words, "''", "the name of a modifier");
    if (list->count == PM_NAMES_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d modifiers", words->option,
                            PM_NAMES_MAX);
    list->names[list->count++] = name;
    return PM_OK;
}

pm_status pm_take_name_file(struct pm_words *words)
{
    pm_names_option *list = names_of(words);
    pm_options *out = words->out;
    const char *path = NULL;
    size_t count = 0;
    pm_status st = pm_word_text(words, "a file of modifiers", &path);
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
static unsigned sides_of(const struct pm_words *words)
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

pm_status pm_take_port(struct pm_words *words)
{
    pm_options *out = words->out;
    const char *name = NULL;
    pm_status st = pm_word_text(words, "a modifier", &name);
    if (st)
        return st;
    if (!*name)
        return pm_word_bad(words, "''", "the name of a modifier");
    if (out->port_count == PM_NAMES_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d modifiers", words->option,
                            PM_NAMES_MAX);
    out->ports[out->port_count++] = (pm_port_option){name, sides_of(words)};
    return PM_OK;
}

pm_status pm_take_port_file(struct pm_words *words)
{
    pm_options *out = words->out;
    const char *path = NULL, *names[PM_NAMES_MAX];
    size_t count = 0;
    pm_status st = pm_word_text(words, "a file of modifiers", &path);
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

pm_status pm_take_port_tables(struct pm_words *words)
{
    bool directions = words->option[2] == 'p';
    double *out = directions ? &words->out->direction_resolution : &words->out->partition;
    double low = directions ? 1 : PM_PARTITION_MIN, high = directions ? PM_DIRECTIONS_MAX : 1;
    pm_status st = pm_word_number(words, "a number", out);
    if (st || (*out >= low && *out <= high))
        return st;
    char right[80];
    snprintf(right, sizeof right, "%g to %g", low, high);
    return pm_word_bad(words, words->argv[words->at - 1], right);
}

/* -api x y z x y z | -apI x y z radius */
pm_status pm_take_region(struct pm_words *words)
{
    pm_options *out = words->out;
    bool ball = words->option[3] == 'I';
    double n[6] = {0};
    if (out->region_count == PM_REGIONS_MAX)
        return pm_error_set(words->err, PM_E_RANGE, "%s: at most %d regions", words->option,
                            PM_REGIONS_MAX);
    pm_status st = ball ? pm_word_numbers(words, "a ball: x y z radius", 4, n)
                        : pm_word_numbers(words, "a box: two corners x y z x y z", 6, n);
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
pm_status pm_check_forward(const pm_options *read, pm_error *err)
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
