#include "job_request.h"

#include <string.h>
#include <strings.h>

unsigned pm_format_of(const char *path)
{
    const char *dot = strrchr(path, '.');
    if (!dot)
        return 0;
    if (!strcasecmp(dot, ".exr"))
        return PM_WANT_EXR;
    if (!strcasecmp(dot, ".hdr") || !strcasecmp(dot, ".pic"))
        return PM_WANT_HDR;
    return strcasecmp(dot, ".png") ? 0 : PM_WANT_PNG;
}

const char *pm_format_word(unsigned format)
{
    return format == PM_WANT_EXR ? "exr" : format == PM_WANT_HDR ? "hdr" : "png";
}

static bool put_view(pm_json *request, const pm_options *options)
{
    char view[PM_VIEW_TEXT];
    pm_view_format(&options->view, view);
    return pm_json_put(request, "view", pm_json_pack("s", view)) &&
           pm_json_put(request, "x", pm_json_pack("i", (int)options->x)) &&
           pm_json_put(request, "y", pm_json_pack("i", (int)options->y)) &&
           pm_json_put(request, "pa", pm_json_pack("f", options->pixel_aspect));
}

static bool put_map(pm_json *request, const pm_options *options, pm_map_kind kind,
                    const pm_attachments *attachments)
{
    const pm_map_option *map = &options->maps[kind];
    if (!map->given)
        map = attachments->detected[kind];
    if (!map)
        return true;
    pm_json *value = pm_json_pack("{}");
    bool made = value;
    if (attachments->has_map[kind]) {
        char hex[PM_DIGEST_HEX];
        pm_digest_hex(&attachments->map[kind], hex);
        made = made && pm_json_put(value, "map", pm_json_pack("s", hex));
    } else {
        made = made && pm_json_put(value, "count", pm_json_pack("I", (long long)map->count));
        if (options->sequence)
            made =
                made && pm_json_put(value, "passes", pm_json_pack("i", (int)options->sequence));
    }
    bool precomputed = kind == PM_MAP_GLOBAL && (map->precomputed || attachments->precomputed);
    if (precomputed && options->fraction > 0)
        made = made && pm_json_put(value, "fraction", pm_json_pack("f", options->fraction));
    if (map->gather)
        made = made && pm_json_put(value, "gather", pm_json_pack("i", (int)map->gather));
    if (map->gather_max)
        made =
            made && pm_json_put(value, "gather_max", pm_json_pack("i", (int)map->gather_max));
    if (map->gather_max && options->bandwidth)
        made = made && pm_json_put(value, "bandwidth", pm_json_pack("s", options->bandwidth));
    if (!made) {
        pm_json_free(value);
        return false;
    }
    return pm_json_put(request, pm_map_kind_name(precomputed ? PM_MAP_PRECOMPUTED : kind),
                       value);
}

static bool put_stops(pm_json *request, const pm_options *options)
{
    bool made = true;
    if (options->passes)
        made = made && pm_json_put(request, "passes", pm_json_pack("i", (int)options->passes));
    if (options->seconds > 0)
        made = made && pm_json_put(request, "time", pm_json_pack("f", options->seconds));
    if (options->error > 0)
        made = made && pm_json_put(request, "error", pm_json_pack("f", options->error));
    return made;
}

static bool put_formats(pm_json *request, unsigned formats)
{
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (unsigned format = 1; format <= PM_WANT_PNG; format *= 2)
        if (formats & format)
            made = made && pm_json_append(list, pm_json_pack("s", pm_format_word(format)));
    if (made)
        return pm_json_put(request, "formats", list);
    pm_json_free(list);
    return false;
}

/* All but the value, which comes in any case. */
static void fields_asked(const pm_options *options, char out[PM_FIELDS_MAX])
{
    for (const char *field = options->fields; *field; field++)
        if (*field != 'v')
            *out++ = *field;
    *out = '\0';
}

static bool put_points(pm_json *request, const pm_options *options,
                       const pm_attachments *attachments)
{
    char hex[PM_DIGEST_HEX];
    bool irradiance = options->verb == PM_VERB_TRACE || options->irradiance;
    pm_digest_hex(&attachments->points, hex);
    char fields[PM_FIELDS_MAX];
    fields_asked(options, fields);
    if (*fields && !pm_json_put(request, "fields", pm_json_pack("s", fields)))
        return false;
    return pm_json_put(request, "points", pm_json_pack("s", hex)) &&
           pm_json_put(request, "quantity",
                       pm_json_pack("s", irradiance ? "irradiance" : "radiance"));
}

static bool put_names(pm_json *request, const char *member, const pm_names_option *option)
{
    if (!option->count)
        return true;
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (size_t i = 0; i < option->count; i++)
        made = made && pm_json_append(list, pm_json_pack("s", option->names[i]));
    if (made)
        return pm_json_put(request, member, list);
    pm_json_free(list);
    return false;
}

static const char *side_word(unsigned sides)
{
    return sides == PM_PORT_FRONT ? "front" : sides == PM_PORT_BACK ? "back" : "both";
}

static bool put_ports(pm_json *request, const pm_options *options)
{
    if (!options->port_count)
        return true;
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (size_t i = 0; i < options->port_count; i++)
        made = made && pm_json_append(list, pm_json_pack("{s:s, s:s}", "modifier",
                                                         options->ports[i].modifier, "side",
                                                         side_word(options->ports[i].sides)));
    if (options->direction_resolution > 0)
        made = made && pm_json_put(request, "direction_resolution",
                                   pm_json_pack("f", options->direction_resolution));
    if (options->partition > 0)
        made = made && pm_json_put(request, "partition", pm_json_pack("f", options->partition));
    if (made)
        return pm_json_put(request, "ports", list);
    pm_json_free(list);
    return false;
}

static pm_json *region_json(const pm_region *region)
{
    const pm_vec3 *a = &region->low, *b = &region->high, *c = &region->center;
    if (region->is_ball)
        return pm_json_pack("{s:[f, f, f, f]}", "sphere", c->x, c->y, c->z, region->radius);
    return pm_json_pack("{s:[f, f, f, f, f, f]}", "box", a->x, a->y, a->z, b->x, b->y, b->z);
}

static bool put_regions(pm_json *request, const pm_options *options)
{
    if (!options->region_count)
        return true;
    pm_json *list = pm_json_pack("[]");
    bool made = list;
    for (size_t i = 0; i < options->region_count; i++)
        made = made && pm_json_append(list, region_json(&options->regions[i]));
    if (made)
        return pm_json_put(request, "regions", list);
    pm_json_free(list);
    return false;
}

static pm_json *color(pm_rgb c)
{
    return pm_json_pack("[f, f, f]", c.r, c.g, c.b);
}

static bool put_surroundings(pm_json *request, const pm_surroundings *s)
{
    bool made = true;
    if (!pm_rgb_is_black(s->extinction))
        made = pm_json_put(request, "medium",
                           pm_json_pack("{s:o, s:o, s:f}", "extinction", color(s->extinction),
                                        "albedo", color(s->albedo), "g", s->eccentricity));
    if (s->no_back_faces)
        made = made && pm_json_put(request, "back_faces", pm_json_pack("b", 0));
    return made;
}

/* What bears on the photons themselves; what was not said is left to the server. */
static bool put_forward(pm_json *request, const pm_options *options)
{
    bool made = true;
    if (options->max_events)
        made = pm_json_put(request, "max_events", pm_json_pack("i", (int)options->max_events));
    if (options->max_length > 0)
        made =
            made && pm_json_put(request, "max_length", pm_json_pack("f", options->max_length));
    return made && put_ports(request, options) &&
           put_names(request, "sensors", &options->sensors) &&
           put_names(request, "exclude", &options->exclude) &&
           put_names(request, "include", &options->include) && put_regions(request, options);
}

pm_json *pm_job_request(const pm_options *options, const char *kind,
                        const pm_attachments *attachments, unsigned formats,
                        const char *command)
{
    bool looks = strcmp(kind, "map") != 0;
    pm_json *request = pm_json_pack("{s:s, s:s, s:I, s:i, s:s}", "kind", kind, "scene",
                                    attachments->scene, "seed", (long long)options->seed,
                                    "threads", (int)options->threads, "command", command);
    bool made = request;
    for (int map = 0; map < PM_MAP_KINDS; map++)
        made = made && put_map(request, options, (pm_map_kind)map, attachments);
    made = made && put_surroundings(request, &options->surroundings) &&
           put_forward(request, options);
    if (looks)
        made = made && put_stops(request, options) &&
               pm_json_put(request, "ab", pm_json_pack("i", options->ambient_bounces));
    if (formats)
        made = made && put_view(request, options) && put_formats(request, formats);
    if (attachments->has_points)
        made = made && put_points(request, options, attachments);
    if (made)
        return request;
    pm_json_free(request);
    return NULL;
}
