#include "request.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fields.h"
#include "request_forward.h"

const char *pm_format_name(pm_format format)
{
    static const char *const names[PM_FORMATS] = {"exr", "hdr", "png"};
    return names[format];
}

static pm_status refuse(pm_error *err, const char *member, const char *text)
{
    return pm_error_set_at(err, PM_E_RANGE, member, 0, 0, "%s", text);
}

static const char *default_text(const char *name)
{
    return pm_field_find(pm_fields_job, name)->otherwise;
}

static int64_t integer(const pm_json *json, const char *name)
{
    return pm_json_get_integer(json, name, strtoll(default_text(name), NULL, 10));
}

/* ---- maps ---- */

static pm_status read_bandwidth(const pm_json *map, const char *name, pm_map_wanted *wanted,
                                pm_error *err)
{
    const char *bandwidth = pm_json_get_text(map, "bandwidth", NULL);
    const pm_field *gather = pm_field_find(pm_fields_map, "gather");
    uint32_t least = wanted->gather_count ? wanted->gather_count
                                          : (uint32_t)strtoul(gather->otherwise, NULL, 10);
    wanted->gather_max = (uint32_t)pm_json_get_integer(map, "gather_max", 0);
    if (wanted->gather_max && wanted->gather_max <= least)
        return refuse(err, name,
                      "has a \"gather_max\" that is not greater than \"gather\" (40 if it is "
                      "not said)");
    if (bandwidth && !wanted->gather_max)
        return refuse(err, name,
                      "has \"bandwidth\", which has no meaning without \"gather_max\"");
    while (bandwidth && strcmp(bandwidth, pm_bandwidth_name(wanted->bandwidth)) != 0)
        wanted->bandwidth++;
    return PM_OK;
}

/* A precomputed map stands in for the global one. */
static pm_status read_precomputed(pm_map_kind kind, pm_request *out, pm_error *err)
{
    const pm_json *map = pm_json_get(out->json, pm_map_kind_name(PM_MAP_PRECOMPUTED));
    pm_map_wanted *wanted = &out->job.wanted.maps[kind];
    if (kind != PM_MAP_GLOBAL || !map)
        return PM_OK;
    if (pm_json_get(out->json, pm_map_kind_name(kind)))
        return refuse(err, pm_map_kind_name(PM_MAP_PRECOMPUTED),
                      "stands in for \"global\"; give one of them");
    if (pm_json_get(map, "map") && (pm_json_get(map, "gather") || pm_json_get(map, "fraction")))
        return refuse(err, pm_map_kind_name(PM_MAP_PRECOMPUTED),
                      "has \"map\", which is precomputed already, so \"gather\" and "
                      "\"fraction\" have no meaning");
    wanted->precomputed = true;
    wanted->fraction = pm_json_get_number(map, "fraction", 0);
    return PM_OK;
}

static pm_status check_gather(const pm_map_wanted *wanted, pm_error *err)
{
    const pm_field *gather = pm_field_find(pm_fields_precomputed, "gather");
    uint32_t count = wanted->gather_count ? wanted->gather_count
                                          : (uint32_t)strtoul(gather->otherwise, NULL, 10);
    if (!wanted->precomputed || !wanted->count || count <= wanted->count)
        return PM_OK;
    return refuse(err, pm_map_kind_name(PM_MAP_PRECOMPUTED),
                  "has a \"gather\" (40 if it is not said) that is greater than \"count\"");
}

static pm_status read_map(pm_map_kind kind, pm_request *out, pm_error *err)
{
    pm_map_wanted *wanted = &out->job.wanted.maps[kind];
    pm_status st = read_precomputed(kind, out, err);
    const char *name = pm_map_wanted_name(wanted, kind);
    const pm_json *map = pm_json_get(out->json, name);
    if (st || !map)
        return st;
    const char *file = pm_json_get_text(map, "map", NULL);
    int64_t count = pm_json_get_integer(map, "count", 0);
    if (!file == !count)
        return refuse(err, name,
                      "must have either \"count\" (photons to trace) or \"map\" "
                      "(digest of an uploaded map file)");
    wanted->wanted = true;
    wanted->count = (uint64_t)count;
    wanted->passes = (uint32_t)pm_json_get_integer(map, "passes", 0);
    wanted->gather_count = (uint32_t)pm_json_get_integer(map, "gather", 0);
    st = read_bandwidth(map, name, wanted, err);
    if (!st)
        st = check_gather(wanted, err);
    if (st)
        return st;
    if (file)
        out->has_map_file[kind] = pm_digest_parse(file, &out->map_file[kind]);
    return PM_OK;
}

static pm_status read_maps(pm_request *out, pm_error *err)
{
    bool any = false, counted = false;
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        pm_status st = read_map((pm_map_kind)kind, out, err);
        if (st)
            return st;
        any = any || out->job.wanted.maps[kind].wanted;
        counted = counted || out->job.wanted.maps[kind].count;
        if (out->job.kind == PM_JOB_MAP && out->has_map_file[kind])
            return refuse(err,
                          pm_map_wanted_name(&out->job.wanted.maps[kind], (pm_map_kind)kind),
                          "has \"map\": a job of kind map makes maps, so give \"count\"");
    }
    if (out->job.kind == PM_JOB_MAP && !counted)
        return refuse(
            err, "kind",
            "is map, so at least one of global, precomputed, caustic, volume and direct must "
            "be there with a count");
    out->job.wanted.estimator = any ? PM_NEAREST : PM_PROGRESSIVE;
    return PM_OK;
}

/* ---- view ---- */

static void read_vector(const pm_json *view, const char *name, pm_vec3 *out)
{
    const pm_json *list = pm_json_get(view, name);
    if (list)
        *out =
            (pm_vec3){pm_json_number(pm_json_at(list, 0)), pm_json_number(pm_json_at(list, 1)),
                      pm_json_number(pm_json_at(list, 2))};
}

static pm_status read_view(pm_request *out, pm_error *err)
{
    pm_view *view = &out->job.view;
    const pm_json *json = pm_json_get(out->json, "view");
    *view = pm_view_default();
    if (pm_json_type_of(json) == PM_JSON_TEXT) {
        pm_status st = pm_view_parse(pm_json_string(json), "view", view, err);
        if (st)
            return st;
    } else {
        read_vector(json, "vp", &view->point);
        read_vector(json, "vd", &view->direction);
        read_vector(json, "vu", &view->up);
        view->horizontal = pm_json_get_number(json, "vh", view->horizontal);
        view->vertical = pm_json_get_number(json, "vv", view->vertical);
        view->shift = pm_json_get_number(json, "vs", 0);
        view->lift = pm_json_get_number(json, "vl", 0);
        view->fore = pm_json_get_number(json, "vo", 0);
        view->aft = pm_json_get_number(json, "va", 0);
        view->type =
            (pm_view_type)(strchr(pm_view_letters, *pm_json_get_text(json, "vt", "v")) -
                           pm_view_letters);
    }
    pm_error why = PM_ERROR_INIT;
    pm_status st = pm_view_check(view, &why);
    return st ? pm_error_set_at(err, st, "view", 0, 0, "%s", why.text) : PM_OK;
}

static void read_formats(pm_request *out)
{
    const pm_json *list = pm_json_get(out->json, "formats");
    for (size_t i = 0; i < pm_json_length(list); i++)
        for (int format = 0; format < PM_FORMATS; format++)
            if (!strcmp(pm_json_string(pm_json_at(list, i)), pm_format_name((pm_format)format)))
                out->formats |= 1U << format;
    if (!list)
        out->formats = 1U << PM_FORMAT_EXR;
}

static pm_status read_picture(pm_request *out, pm_error *err)
{
    pm_job *job = &out->job;
    pm_status st = read_view(out, err);
    if (st)
        return st;
    job->width = (uint32_t)integer(out->json, "x");
    job->height = (uint32_t)integer(out->json, "y");
    pm_view_fit(&job->view, pm_json_get_number(out->json, "pa", 1), &job->width, &job->height);
    read_formats(out);
    return PM_OK;
}

/* ---- members that only some kinds of job have ---- */

enum { MAP = 1 << PM_JOB_MAP, RENDER = 1 << PM_JOB_RENDER, TRACE = 1 << PM_JOB_TRACE };

static const struct {
    const char *member;
    unsigned kinds;
} meanings[] = {
    {"ab", RENDER | TRACE},
    {"view", RENDER},
    {"x", RENDER},
    {"y", RENDER},
    {"pa", RENDER},
    {"points", TRACE},
    {"quantity", TRACE},
    {"fields", TRACE},
    {"passes", RENDER | TRACE},
    {"time", RENDER | TRACE},
    {"error", RENDER | TRACE},
    {"formats", RENDER},
    {"direct", MAP},
    {"sensors", MAP},
    {"exclude", MAP},
    {"include", MAP},
    {"regions", MAP},
};

/* A member without effect is refused, not ignored. */
static pm_status check_meanings(const pm_request *request, pm_error *err)
{
    for (size_t i = 0; i < sizeof meanings / sizeof *meanings; i++)
        if (pm_json_get(request->json, meanings[i].member) &&
            !(meanings[i].kinds & (1U << request->job.kind)))
            return refuse(err, meanings[i].member, "has no meaning in a job of this kind");
    for (int kind = 0; kind < PM_MAP_KINDS; kind++)
        if (request->job.kind != PM_JOB_MAP && request->job.wanted.maps[kind].passes)
            return refuse(err, pm_map_kind_name((pm_map_kind)kind),
                          "has \"passes\", which has a meaning in a job of kind map alone");
    if (request->job.kind == PM_JOB_MAP)
        for (int kind = 0; kind < PM_MAP_KINDS; kind++)
            if (!request->job.wanted.maps[kind].precomputed &&
                (request->job.wanted.maps[kind].gather_count ||
                 request->job.wanted.maps[kind].gather_max))
                return refuse(err, pm_map_kind_name((pm_map_kind)kind),
                              "has \"gather\" or \"gather_max\", which have no meaning in a "
                              "job of kind map");
    return PM_OK;
}

static pm_job_kind kind_of(const pm_json *json)
{
    const char *kind = pm_json_get_text(json, "kind", "");
    if (!strcmp(kind, "map"))
        return PM_JOB_MAP;
    return !strcmp(kind, "render") ? PM_JOB_RENDER : PM_JOB_TRACE;
}

static void read_stops(pm_request *out)
{
    out->job.passes = (uint32_t)pm_json_get_integer(out->json, "passes", 0);
    out->job.seconds = pm_json_get_number(out->json, "time", 0);
    out->job.error = pm_json_get_number(out->json, "error", 0);
}

static void read_common(pm_request *out)
{
    const pm_json *json = out->json;
    out->job.wanted.ambient_bounces = (int)integer(json, "ab");
    out->job.threads = (unsigned)integer(json, "threads");
    out->job.command = pm_json_get_text(json, "command", NULL);
    out->scene = pm_json_get_text(json, "scene", NULL);
    read_stops(out);
}

static pm_status read_trace(pm_request *out, pm_error *err)
{
    const char *points = pm_json_get_text(out->json, "points", NULL);
    if (!points)
        return pm_error_set_at(err, PM_E_MISSING, "points", 0, 0,
                               "is missing: a job of kind trace needs sensor points");
    out->has_points = pm_digest_parse(points, &out->points);
    const char *quantity = pm_json_get_text(out->json, "quantity", "irradiance");
    out->job.quantity = strcmp(quantity, "radiance") ? PM_IRRADIANCE : PM_RADIANCE;
    out->fields = pm_json_get_text(out->json, "fields", "");
    if (strspn(out->fields, PM_TRACE_FIELDS) != strlen(out->fields))
        return refuse(err, "fields", "has a letter that is none of " PM_TRACE_FIELDS);
    out->job.first_hits = *out->fields;
    return PM_OK;
}

static pm_status read_checked(pm_request *out, pm_error *err)
{
    out->job.kind = kind_of(out->json);
    read_common(out);
    pm_status st = read_maps(out, err);
    if (!st)
        st = pm_request_read_surroundings(out->json, &out->job.surroundings, err);
    if (!st)
        st = pm_request_read_forward(out->json, &out->arena, &out->job.forward, err);
    if (!st)
        st = check_meanings(out, err);
    if (!st && out->job.kind == PM_JOB_RENDER)
        st = read_picture(out, err);
    if (!st && out->job.kind == PM_JOB_TRACE)
        st = read_trace(out, err);
    return st;
}

pm_status pm_request_parse(const void *text, size_t size, pm_request *out, pm_error *err)
{
    pm_request request = {0};
    pm_status st = pm_json_parse(text, size, "body", &request.json, err);
    if (!st)
        st = pm_fields_check(pm_fields_job, request.json, err);
    if (!st)
        st = read_checked(&request, err);
    if (st)
        pm_request_clear(&request);
    else
        *out = request;
    return st;
}

void pm_request_clear(pm_request *request)
{
    pm_json_free(request->json);
    pm_arena_clear(&request->arena);
    *request = (pm_request){0};
}

/* ---- sensors ---- */

enum { NUMBERS = 6, LINE_MAX_BYTES = 1024 };

struct lines {
    const char *at, *end, *name;
    int number;
    pm_error *err;
};

/* The six numbers of a line that is terminated. Zero numbers: a blank line. */
static pm_status read_line(const struct lines *lines, const char *line, double *numbers,
                           int *found)
{
    const char *at = line;
    *found = 0;
    for (;;) {
        at += strspn(at, " \t\r,");
        int column = (int)(at - line) + 1;
        if (!*at)
            break;
        char *end;
        double value = strtod(at, &end);
        if (end == at || !strchr(" \t\r,", *end) || !isfinite(value))
            return pm_error_set_at(lines->err, PM_E_SYNTAX, lines->name, lines->number, column,
                                   "not a finite number; a sensor is `x y z nx ny nz`");
        if (*found == NUMBERS)
            return pm_error_set_at(lines->err, PM_E_SYNTAX, lines->name, lines->number, column,
                                   "a seventh number; a sensor is `x y z nx ny nz`");
        numbers[(*found)++] = value;
        at = end;
    }
    if (*found && *found < NUMBERS)
        return pm_error_set_at(lines->err, PM_E_SYNTAX, lines->name, lines->number,
                               (int)(at - line) + 1, "%d numbers; a sensor is `x y z nx ny nz`",
                               *found);
    if (*found && numbers[3] == 0 && numbers[4] == 0 && numbers[5] == 0)
        return pm_error_set_at(lines->err, PM_E_RANGE, lines->name, lines->number, 1,
                               "the normal is 0 0 0");
    return PM_OK;
}

/* Copies the next line, terminated. False at the end of the text. */
static bool next_line(struct lines *lines, char line[LINE_MAX_BYTES], pm_status *st)
{
    if (lines->at == lines->end)
        return false;
    const char *stop = memchr(lines->at, '\n', (size_t)(lines->end - lines->at));
    size_t length = (size_t)((stop ? stop : lines->end) - lines->at);
    lines->number++;
    if (length >= LINE_MAX_BYTES || memchr(lines->at, 0, length)) {
        *st = pm_error_set_at(lines->err, PM_E_SYNTAX, lines->name, lines->number, 1,
                              "not a line of text `x y z nx ny nz`");
        return false;
    }
    memcpy(line, lines->at, length);
    line[length] = '\0';
    lines->at += length + (stop ? 1 : 0);
    return true;
}

pm_status pm_sensors_parse(const char *text, size_t size, const char *name, pm_sensor **out,
                           size_t *count, pm_error *err)
{
    struct lines lines = {text, text + size, name, 0, err};
    char line[LINE_MAX_BYTES];
    pm_sensor *sensors = NULL;
    size_t used = 0, capacity = 0;
    pm_status st = PM_OK;
    while (!st && next_line(&lines, line, &st)) {
        double n[NUMBERS];
        int found = 0;
        st = read_line(&lines, line, n, &found);
        if (st || !found)
            continue;
        if (used == capacity) {
            capacity = capacity ? 2 * capacity : 64;
            pm_sensor *grown = realloc(sensors, capacity * sizeof *grown);
            if (!grown) {
                st = pm_error_set(err, PM_E_MEMORY, "no memory for %zu sensors", capacity);
                break;
            }
            sensors = grown;
        }
        sensors[used++] = (pm_sensor){{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
    }
    if (!st && !used)
        st = pm_error_set_at(err, PM_E_SYNTAX, name, 1, 1,
                             "no sensor; give lines `x y z nx ny nz`");
    if (st) {
        free(sensors);
        return st;
    }
    *out = sensors;
    *count = used;
    return PM_OK;
}
