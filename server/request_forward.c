#include "request_forward.h"

#include <stdlib.h>
#include <string.h>

#include "fields.h"

static pm_status refuse(pm_error *err, const char *member, const char *text)
{
    return pm_error_set_at(err, PM_E_RANGE, member, 0, 0, "%s", text);
}

static pm_status no_memory(pm_error *err)
{
    return pm_error_set(err, PM_E_MEMORY, "no memory for a request");
}

static int64_t integer(const pm_json *json, const char *name)
{
    const char *otherwise = pm_field_find(pm_fields_job, name)->otherwise;
    return pm_json_get_integer(json, name, strtoll(otherwise, NULL, 10));
}

static pm_status read_names(const pm_json *json, const char *name, pm_arena *arena,
                            pm_name_list *out, pm_error *err)
{
    const pm_json *list = pm_json_get(json, name);
    size_t count = pm_json_length(list);
    const char **names = pm_arena_array(arena, count + 1, sizeof *names);
    if (!names)
        return no_memory(err);
    for (size_t i = 0; i < count; i++)
        names[i] = pm_json_string(pm_json_at(list, i));
    *out = (pm_name_list){names, count};
    return PM_OK;
}

static unsigned sides_of(const pm_json *port)
{
    const char *side = pm_json_get_text(port, "side", "front");
    if (!strcmp(side, "both"))
        return PM_PORT_FRONT | PM_PORT_BACK;
    return strcmp(side, "back") ? PM_PORT_FRONT : PM_PORT_BACK;
}

static pm_status read_ports(const pm_json *json, pm_arena *arena, pm_forward_options *out,
                            pm_error *err)
{
    static const char *const tables[] = {"direction_resolution", "partition"};
    const pm_json *list = pm_json_get(json, "ports");
    size_t count = pm_json_length(list);
    pm_port_option *ports = pm_arena_array(arena, count + 1, sizeof *ports);
    if (!ports)
        return no_memory(err);
    for (size_t i = 0; i < 2; i++)
        if (!count && pm_json_get(json, tables[i]))
            return refuse(err, tables[i], "has no meaning without ports");
    for (size_t i = 0; i < count; i++) {
        const pm_json *port = pm_json_at(list, i);
        ports[i] = (pm_port_option){pm_json_get_text(port, "modifier", NULL), sides_of(port)};
    }
    out->ports = ports;
    out->port_count = count;
    out->direction_resolution = pm_json_get_number(json, tables[0], out->direction_resolution);
    out->partition = pm_json_get_number(json, tables[1], out->partition);
    return PM_OK;
}

static double number_at(const pm_json *list, size_t i)
{
    return pm_json_number(pm_json_at(list, i));
}

static pm_vec3 point_at(const pm_json *list, size_t i)
{
    return (pm_vec3){number_at(list, i), number_at(list, i + 1), number_at(list, i + 2)};
}

static pm_status read_region(const pm_json *json, pm_region *out, pm_error *err)
{
    const pm_json *box = pm_json_get(json, "box"), *ball = pm_json_get(json, "sphere");
    if (!box == !ball)
        return refuse(err, "regions", "must have either \"box\" or \"sphere\" in each entry");
    if (box)
        *out = (pm_region){.low = point_at(box, 0), .high = point_at(box, 3)};
    else
        *out = (pm_region){
            .is_ball = true, .center = point_at(ball, 0), .radius = number_at(ball, 3)};
    return PM_OK;
}

static pm_status read_regions(const pm_json *json, pm_arena *arena, pm_forward_options *out,
                              pm_error *err)
{
    const pm_json *list = pm_json_get(json, "regions");
    size_t count = pm_json_length(list);
    pm_region *regions = pm_arena_array(arena, count + 1, sizeof *regions);
    pm_status st = regions ? PM_OK : no_memory(err);
    for (size_t i = 0; i < count && !st; i++)
        st = read_region(pm_json_at(list, i), &regions[i], err);
    out->regions = regions;
    out->region_count = count;
    return st;
}

/* What the members say together, with the engine's own words. */
static pm_status check_together(const pm_forward_options *options, pm_error *err)
{
    if (options->exclude.count && options->include.count)
        return refuse(err, "exclude", "and include exclude each other; give one");
    pm_error why = PM_ERROR_INIT;
    pm_status st = pm_forward_options_check(options, &why);
    if (!st)
        return PM_OK;
    const char *member = options->region_count ? "regions" : "body";
    return pm_error_set_at(err, st, member, 0, 0, "%s", why.text);
}

pm_status pm_request_read_forward(const pm_json *json, pm_arena *arena, pm_forward_options *out,
                                  pm_error *err)
{
    pm_forward_options options = pm_forward_defaults();
    options.seed = (uint64_t)integer(json, "seed");
    options.max_events = (uint32_t)integer(json, "max_events");
    options.max_length = pm_json_get_number(json, "max_length", 0);
    pm_status st = read_ports(json, arena, &options, err);
    if (!st)
        st = read_names(json, "sensors", arena, &options.sensors, err);
    if (!st)
        st = read_names(json, "exclude", arena, &options.exclude, err);
    if (!st)
        st = read_names(json, "include", arena, &options.include, err);
    if (!st)
        st = read_regions(json, arena, &options, err);
    if (!st)
        st = check_together(&options, err);
    *out = options;
    return st;
}

static void read_color(const pm_json *json, const char *name, pm_rgb *out)
{
    const pm_json *list = pm_json_get(json, name);
    if (list)
        *out = (pm_rgb){number_at(list, 0), number_at(list, 1), number_at(list, 2)};
}

pm_status pm_request_read_surroundings(const pm_json *json, pm_surroundings *out, pm_error *err)
{
    const pm_json *medium = pm_json_get(json, "medium");
    pm_surroundings s = {.no_back_faces = !pm_json_get_bool(json, "back_faces", true)};
    read_color(medium, "extinction", &s.extinction);
    read_color(medium, "albedo", &s.albedo);
    s.eccentricity = pm_json_get_number(medium, "g", 0);
    if (medium && pm_rgb_is_black(s.extinction))
        return refuse(err, "medium", "has no extinction; leave it out");
    *out = s;
    return PM_OK;
}
