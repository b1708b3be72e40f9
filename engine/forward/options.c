#include "forward/options.h"

#include <math.h>

enum {
    /* Keeps the photons of a batch within 32 bits. */
    MAX_EVENTS_LIMIT = 50000,
};

pm_forward_options pm_forward_defaults(void)
{
    return (pm_forward_options){
        .seed = 0, .max_events = 5000, .direction_resolution = 1000, .partition = .01};
}

/* ---- checks ---- */

/* The comparison is false for what is no number. */
static bool is_within(double value, double low, double high)
{
    return value >= low && value <= high;
}

static pm_status check_limits(const pm_forward_options *options, pm_error *err)
{
    if (options->max_events > MAX_EVENTS_LIMIT)
        return pm_error_set(err, PM_E_RANGE, "a bound of %u scatterings a path; at most %d",
                            options->max_events, MAX_EVENTS_LIMIT);
    if (!is_within(options->max_length, 0, PM_LENGTH_MAX))
        return pm_error_set(err, PM_E_RANGE,
                            "a bound of %g on the length of a path; it must be greater than 0 "
                            "and at most %g",
                            options->max_length, PM_LENGTH_MAX);
    return PM_OK;
}

static pm_status check_ports(const pm_forward_options *options, pm_error *err)
{
    for (size_t i = 0; i < options->port_count; i++)
        if (options->ports[i].sides < PM_PORT_FRONT ||
            options->ports[i].sides > (PM_PORT_FRONT | PM_PORT_BACK))
            return pm_error_set(err, PM_E_RANGE, "the port '%.60s' has no side to emit to",
                                options->ports[i].modifier);
    if (!options->port_count)
        return PM_OK;
    if (!is_within(options->direction_resolution, 1, PM_DIRECTIONS_MAX))
        return pm_error_set(err, PM_E_RANGE, "%g directions a steradian; it must be 1 to %g",
                            options->direction_resolution, PM_DIRECTIONS_MAX);
    if (!is_within(options->partition, PM_PARTITION_MIN, 1))
        return pm_error_set(err, PM_E_RANGE,
                            "patches of %g of the scene's cube; it must be %g to 1",
                            options->partition, PM_PARTITION_MIN);
    return PM_OK;
}

static bool is_finite(pm_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static pm_status check_region(const pm_region *region, pm_error *err)
{
    if (region->is_ball) {
        bool sound = is_finite(region->center) && is_within(region->radius, 0, PM_LENGTH_MAX) &&
                     region->radius > 0;
        return sound ? PM_OK
                     : pm_error_set(err, PM_E_RANGE,
                                    "a region is a ball of radius %g; it must be greater than "
                                    "0 and at most %g, about a point that is finite",
                                    region->radius, PM_LENGTH_MAX);
    }
    pm_vec3 size = pm_vec3_sub(region->high, region->low);
    bool sound = is_finite(region->low) && is_finite(region->high) && size.x != 0 &&
                 size.y != 0 && size.z != 0;
    return sound ? PM_OK
                 : pm_error_set(err, PM_E_RANGE,
                                "a region is a box of size %g %g %g; its two corners must be "
                                "finite and differ in x, y and z",
                                size.x, size.y, size.z);
}

pm_status pm_forward_options_check(const pm_forward_options *options, pm_error *err)
{
    pm_status st = check_limits(options, err);
    if (!st)
        st = check_ports(options, err);
    for (size_t i = 0; i < options->region_count && !st; i++)
        st = check_region(&options->regions[i], err);
    if (!st && options->exclude.count && options->include.count)
        st = pm_error_set(err, PM_E_RANGE,
                          "surfaces are both excluded and included; give -ae or -ai alone");
    return st;
}
