#include "forward/choice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"

/* ---- regions ---- */

/* Equal regions get equal bytes, whichever corners their box was given by. */
static pm_region normal_form(const pm_region *region)
{
    pm_region normal = {.is_ball = region->is_ball};
    if (region->is_ball) {
        normal.center = region->center;
        normal.radius = region->radius;
    } else {
        normal.low = pm_vec3_min(region->low, region->high);
        normal.high = pm_vec3_max(region->low, region->high);
    }
    return normal;
}

static pm_region in_world(const pm_world *world, const pm_region *region)
{
    pm_vec3 origin = pm_world_from_scene(world, (pm_vec3){0, 0, 0});
    pm_vec3 unit = pm_world_from_scene(world, (pm_vec3){1, 0, 0});
    pm_region normal = normal_form(region);
    return (pm_region){.is_ball = normal.is_ball,
                       .low = pm_world_from_scene(world, normal.low),
                       .high = pm_world_from_scene(world, normal.high),
                       .center = pm_world_from_scene(world, normal.center),
                       .radius = normal.radius * (unit.x - origin.x)};
}

static bool is_inside(const pm_region *region, pm_vec3 p)
{
    if (region->is_ball) {
        pm_vec3 v = pm_vec3_sub(p, region->center);
        return pm_vec3_dot(v, v) <= region->radius * region->radius;
    }
    return p.x >= region->low.x && p.x <= region->high.x && p.y >= region->low.y &&
           p.y <= region->high.y && p.z >= region->low.z && p.z <= region->high.z;
}

static bool is_in_any(const struct pm_choice *choice, pm_vec3 point)
{
    bool inside = !choice->region_count;
    for (size_t i = 0; i < choice->region_count && !inside; i++)
        inside = is_inside(&choice->regions[i], point);
    return inside;
}

bool pm_choice_stores(const struct pm_choice *choice, const pm_world *world, uint32_t surface,
                      pm_vec3 point)
{
    if (!choice->filters)
        return true;
    if (surface != PM_NO_PRIMITIVE) {
        if (pm_selection_has(&choice->exclude, world, surface))
            return false;
        if (choice->include.any && !pm_selection_has(&choice->include, world, surface))
            return false;
    }
    return is_in_any(choice, point);
}

/* ---- the digest ---- */

/* -0 is 0. */
static void add_number(pm_bytes *bytes, double value)
{
    pm_bytes_f64(bytes, value == 0 ? 0 : value);
}

static void add_point(pm_bytes *bytes, pm_vec3 p)
{
    add_number(bytes, p.x);
    add_number(bytes, p.y);
    add_number(bytes, p.z);
}

static void add_selection(pm_bytes *bytes, const char *option, const pm_selection *selection)
{
    if (!selection->any)
        return;
    pm_bytes_append(bytes, option, strlen(option) + 1);
    pm_bytes_append(bytes, selection->digest.bytes, sizeof selection->digest.bytes);
}

static pm_digest digest_region(const pm_region *region)
{
    pm_bytes bytes = {0};
    pm_region normal = normal_form(region);
    pm_bytes_u8(&bytes, normal.is_ball);
    if (normal.is_ball) {
        add_point(&bytes, normal.center);
        add_number(&bytes, normal.radius);
    } else {
        add_point(&bytes, normal.low);
        add_point(&bytes, normal.high);
    }
    pm_digest digest = pm_digest_of(bytes.data, bytes.size);
    pm_bytes_clear(&bytes);
    return digest;
}

static int by_digest(const void *a, const void *b)
{
    return pm_digest_compare(a, b);
}

/* Their order says nothing, nor does a region given twice. */
static bool add_regions(pm_bytes *bytes, const pm_forward_options *options)
{
    size_t count = options->region_count;
    pm_digest *digests = calloc(count + 1, sizeof *digests);
    if (!digests)
        return false;
    for (size_t i = 0; i < count; i++)
        digests[i] = digest_region(&options->regions[i]);
    qsort(digests, count, sizeof *digests, by_digest);
    if (count)
        pm_bytes_append(bytes, "regions", sizeof "regions");
    for (size_t i = 0; i < count; i++)
        if (!i || !pm_digest_equal(&digests[i - 1], &digests[i]))
            pm_bytes_append(bytes, digests[i].bytes, sizeof digests[i].bytes);
    free(digests);
    return true;
}

/* What is left at its default adds nothing: an option that is new to the engine leaves the
 * photons of old ones where they are. */
static pm_status make_digest(struct pm_choice *choice, const pm_forward_options *options,
                             pm_error *err)
{
    pm_bytes bytes = {0};
    pm_bytes_u64(&bytes, options->seed);
    pm_bytes_u32(&bytes, options->max_events);
    if (options->max_length > 0) {
        pm_bytes_append(&bytes, "length", sizeof "length");
        add_number(&bytes, options->max_length);
    }
    if (options->port_count) {
        add_selection(&bytes, "front", &choice->ports[0]);
        add_selection(&bytes, "back", &choice->ports[1]);
        add_number(&bytes, options->direction_resolution);
        add_number(&bytes, options->partition);
    }
    add_selection(&bytes, "sensors", &choice->sensors);
    add_selection(&bytes, "exclude", &choice->exclude);
    add_selection(&bytes, "include", &choice->include);
    bool complete = add_regions(&bytes, options) && !pm_bytes_status(&bytes);
    if (complete)
        choice->digest = pm_digest_of(bytes.data, bytes.size);
    pm_bytes_clear(&bytes);
    return complete
               ? PM_OK
               : pm_error_set(err, PM_E_MEMORY, "no memory for the forward pass's options");
}

/* ---- choices ---- */

static pm_status select_names(const pm_world *world, const pm_name_list *list,
                              const char *option, pm_selection *out, pm_error *err)
{
    return pm_selection_make(world, list->names, list->count, option, out, err);
}

/* The ports that emit to `side`. */
static pm_status select_ports(const pm_world *world, const pm_forward_options *options,
                              unsigned side, pm_selection *out, pm_error *err)
{
    const char **names = calloc(options->port_count + 1, sizeof *names);
    size_t count = 0;
    if (!names)
        return pm_error_set(err, PM_E_MEMORY, "no memory for %zu ports", options->port_count);
    for (size_t i = 0; i < options->port_count; i++)
        if (options->ports[i].sides & side)
            names[count++] = options->ports[i].modifier;
    pm_status st = pm_selection_make(world, names, count, "-apo", out, err);
    free(names);
    return st;
}

static pm_status take_regions(const pm_world *world, const pm_forward_options *options,
                              struct pm_choice *out, pm_error *err)
{
    if (!options->region_count)
        return PM_OK;
    out->regions = calloc(options->region_count, sizeof *out->regions);
    if (!out->regions)
        return pm_error_set(err, PM_E_MEMORY, "no memory for %zu regions",
                            options->region_count);
    for (size_t i = 0; i < options->region_count; i++)
        out->regions[i] = in_world(world, &options->regions[i]);
    out->region_count = options->region_count;
    return PM_OK;
}

static double world_length(const pm_world *world, double length)
{
    pm_world_info info;
    pm_world_info_get(world, &info);
    return length > 0 ? length / info.scale : INFINITY;
}

pm_status pm_choice_make(const pm_world *world, const pm_forward_options *options,
                         struct pm_choice *out, pm_error *err)
{
    struct pm_choice choice = {.max_length = world_length(world, options->max_length)};
    pm_status st = pm_forward_options_check(options, err);
    if (!st)
        st = select_ports(world, options, PM_PORT_FRONT, &choice.ports[0], err);
    if (!st)
        st = select_ports(world, options, PM_PORT_BACK, &choice.ports[1], err);
    if (!st)
        st = select_names(world, &options->sensors, "-aps", &choice.sensors, err);
    if (!st)
        st = select_names(world, &options->exclude, "-ae", &choice.exclude, err);
    if (!st)
        st = select_names(world, &options->include, "-ai", &choice.include, err);
    if (!st)
        st = take_regions(world, options, &choice, err);
    if (!st)
        st = make_digest(&choice, options, err);
    choice.filters = choice.exclude.any || choice.include.any || choice.region_count;
    if (st)
        pm_choice_clear(&choice);
    else
        *out = choice;
    return st;
}

void pm_choice_clear(struct pm_choice *choice)
{
    pm_selection_clear(&choice->ports[0]);
    pm_selection_clear(&choice->ports[1]);
    pm_selection_clear(&choice->sensors);
    pm_selection_clear(&choice->exclude);
    pm_selection_clear(&choice->include);
    free(choice->regions);
    *choice = (struct pm_choice){.max_length = INFINITY};
}
