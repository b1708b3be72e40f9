#include "plan/plan.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>

#include "base/rgb.h"

enum { DEFAULT_GATHER = 40 };
#define MAX_PHOTONS UINT64_C(2000000000) /* 48 GB */

__attribute__((format(printf, 3, 4))) static void decide(pm_plan_pass *pass, bool needed,
                                                         const char *format, ...)
{
    va_list args;
    va_start(args, format);
    pass->needed = needed;
    vsnprintf(pass->reason, sizeof pass->reason, format, args);
    va_end(args);
}

static uint32_t gather_of(const pm_map_wanted *map)
{
    return map->gather_count ? map->gather_count : DEFAULT_GATHER;
}

const char *pm_map_wanted_name(const pm_map_wanted *map, pm_map_kind kind)
{
    return pm_map_kind_name(map->precomputed ? PM_MAP_PRECOMPUTED : kind);
}

static double fraction_of(const pm_map_wanted *map)
{
    return map->fraction != 0 ? map->fraction : PM_PRECOMPUTE_FRACTION;
}

static pm_status check_precomputed(const pm_map_wanted *map, int kind, pm_error *err)
{
    double fraction = fraction_of(map);
    if (!map->precomputed)
        return PM_OK;
    if (kind != PM_MAP_GLOBAL)
        return pm_error_set(err, PM_E_RANGE, "a precomputed %s map; only global maps are",
                            pm_map_kind_name((pm_map_kind)kind));
    if (map->gather_max)
        return pm_error_set(err, PM_E_RANGE,
                            "a second number of photons an estimate of the precomputed map; "
                            "give one");
    if (map->passes)
        return pm_error_set(err, PM_E_RANGE, "a sequence of precomputed maps; give one pass");
    if (map->from_file)
        return PM_OK;
    if (gather_of(map) > map->count)
        return pm_error_set(err, PM_E_RANGE,
                            "irradiance precomputed from %" PRIu32
                            " photons of a map of %" PRIu64
                            "; give fewer photons an estimate, or more photons",
                            gather_of(map), map->count);
    if (!(fraction > 0 && fraction <= 1))
        return pm_error_set(err, PM_E_RANGE,
                            "irradiance precomputed for a fraction %g of the photons; must be "
                            "greater than 0, at most 1",
                            fraction);
    return PM_OK;
}

static pm_status check_wanted(const pm_wanted *wanted, int kind, pm_error *err)
{
    const pm_map_wanted *map = &wanted->maps[kind];
    const char *name = pm_map_kind_name((pm_map_kind)kind);
    if (wanted->estimator != PM_NEAREST || !map->wanted)
        return PM_OK;
    if (!map->from_file && (map->count < 1 || map->count > MAX_PHOTONS))
        return pm_error_set(err, PM_E_RANGE,
                            "a %s map of %" PRIu64 " photons; it can have 1 to %" PRIu64, name,
                            map->count, MAX_PHOTONS);
    if (map->gather_count > PM_GATHER_MAX || map->gather_max > PM_GATHER_MAX)
        return pm_error_set(
            err, PM_E_RANGE, "%" PRIu32 " photons an estimate of the %s map; at most %d",
            map->gather_count > PM_GATHER_MAX ? map->gather_count : map->gather_max, name,
            PM_GATHER_MAX);
    if (map->gather_max && map->gather_max <= gather_of(map))
        return pm_error_set(err, PM_E_RANGE,
                            "%" PRIu32 " to %" PRIu32 " photons an estimate of the %s map; the "
                            "second number must be the greater one",
                            gather_of(map), map->gather_max, name);
    return check_precomputed(map, kind, err);
}

/* Did the user ask for that kind of light at all? */
static bool is_asked(const pm_wanted *wanted, int kind, pm_plan_pass *pass)
{
    const char *name = pm_map_kind_name((pm_map_kind)kind);
    if (wanted->estimator == PM_NEAREST) {
        if (!wanted->maps[kind].wanted)
            decide(pass, false, "no %s pass: no %s map was asked for", name, name);
        return wanted->maps[kind].wanted;
    }
    if (kind == PM_MAP_DIRECT) {
        decide(pass, false, "no direct pass: next events bring direct light");
        return false;
    }
    if (kind == PM_MAP_GLOBAL && wanted->ambient_bounces == 0) {
        decide(pass, false, "no global pass: -ab 0 asks for no light between diffuse surfaces");
        return false;
    }
    return true;
}

/* "1 surface bounds", "2 surfaces bound" */
static const char *plural(size_t count)
{
    return count == 1 ? "" : "s";
}

static const char *verb_ending(size_t count)
{
    return count == 1 ? "s" : "";
}

static void decide_global(const pm_world_info *info, bool sensors, pm_plan_pass *pass)
{
    size_t n = info->diffuse_surfaces;
    if (!n && sensors)
        decide(pass, true, "global pass: light that comes to sensor surfaces");
    else if (!n)
        decide(pass, false, "no global pass: no surface scatters light diffusely");
    else
        decide(pass, true,
               "global pass: light between surfaces, of which %zu scatter%s diffusely", n,
               verb_ending(n));
}

static void decide_caustic(const pm_world_info *info, bool sensors, pm_plan_pass *pass)
{
    size_t n = info->specular_surfaces;
    if (!n)
        decide(pass, false, "no caustic pass: no surface reflects or refracts specularly");
    else if (!info->diffuse_surfaces && !sensors)
        decide(pass, false, "no caustic pass: no diffuse surface that a caustic could fall on");
    else
        decide(pass, true, "caustic pass: %zu surface%s reflect%s or refract%s specularly", n,
               plural(n), verb_ending(n), verb_ending(n));
}

static void decide_volume(const pm_world_info *info, bool sensors, pm_plan_pass *pass)
{
    (void)sensors;
    size_t n = info->mist_surfaces;
    if (!n)
        decide(pass, false, "no volume pass: no mist");
    else
        decide(pass, true, "volume pass: %zu surface%s bound%s mist", n, plural(n),
               verb_ending(n));
}

static void decide_direct(const pm_world_info *info, bool sensors, pm_plan_pass *pass)
{
    if (!info->diffuse_surfaces && !sensors)
        decide(pass, false, "no direct pass: no surface scatters light diffusely");
    else
        decide(pass, true, "direct pass: light on its first diffuse surface, to be looked at");
}

static void decide_pass(const pm_world_info *info, bool sensors, int kind, pm_plan_pass *pass)
{
    static void (*const decisions[PM_MAP_KINDS])(
        const pm_world_info *, bool, pm_plan_pass *) = {decide_global, decide_caustic,
                                                        decide_volume, decide_direct};
    if (!info->lights || pm_rgb_is_black(info->power))
        decide(pass, false, "no %s pass: nothing in the scene emits light",
               pm_map_kind_name((pm_map_kind)kind));
    else
        decisions[kind](info, sensors, pass);
}

pm_status pm_plan_make(const pm_world *world, const pm_wanted *wanted, pm_plan *out,
                       pm_error *err)
{
    pm_world_info info;
    pm_plan plan = {0};
    pm_world_info_get(world, &info);
    for (int kind = 0; kind < PM_MAP_KINDS; kind++) {
        pm_status st = check_wanted(wanted, kind, err);
        if (st)
            return st;
        pm_plan_pass *pass = &plan.pass[kind];
        if (!is_asked(wanted, kind, pass))
            continue;
        decide_pass(&info, wanted->sensors, kind, pass);
        if (wanted->estimator != PM_NEAREST)
            continue;
        pass->count = wanted->maps[kind].count;
        pass->gather_count = gather_of(&wanted->maps[kind]);
        pass->gather_max = wanted->maps[kind].gather_max;
        pass->bandwidth = wanted->maps[kind].bandwidth;
        if (wanted->maps[kind].precomputed && !wanted->maps[kind].from_file)
            pass->fraction = fraction_of(&wanted->maps[kind]);
    }
    *out = plan;
    return PM_OK;
}
