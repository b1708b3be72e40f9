#include <inttypes.h>
#include <stdlib.h>

#include "backward/backward_internal.h"

/* What one pixel or sensor takes. */
enum { BYTES_EACH = (PM_REPLICATES + 1) * 3 * sizeof(double) + sizeof(struct pm_value) };

#define BYTES_MAX (UINT64_C(4) << 30)

static pm_status check_size(uint64_t count, pm_error *err)
{
    if (!count)
        return pm_error_set(err, PM_E_RANGE, "no pixel or sensor to compute");
    if (count > BYTES_MAX / BYTES_EACH)
        return pm_error_set(err, PM_E_LIMIT,
                            "%" PRIu64 " pixels or sensors are too many for one "
                            "job; at most %" PRIu64 " are",
                            count, BYTES_MAX / BYTES_EACH);
    return PM_OK;
}

static pm_status make(const pm_world *world, size_t count, uint64_t seed, pm_accumulation **out,
                      pm_error *err)
{
    pm_status st = check_size(count, err);
    if (st)
        return st;
    pm_accumulation *a = calloc(1, sizeof *a);
    if (!a)
        return pm_error_set(err, PM_E_MEMORY, "no memory for the sums");
    pm_world_info info;
    pm_world_info_get(world, &info);
    a->world = world;
    a->seed = seed;
    a->count = count;
    a->lit = info.lights > 0;
    a->sums = calloc(PM_REPLICATES * 3 * count, sizeof *a->sums);
    a->deviation = calloc(3 * count, sizeof *a->deviation);
    a->values = calloc(count, sizeof *a->values);
    if (!a->sums || !a->deviation || !a->values) {
        pm_accumulation_free(a);
        return pm_error_set(err, PM_E_MEMORY, "no memory for the sums of %zu values", count);
    }
    *out = a;
    return PM_OK;
}

pm_status pm_accumulation_for_picture(const pm_world *world, const pm_view *view,
                                      uint32_t width, uint32_t height, uint64_t seed,
                                      pm_accumulation **out, pm_error *err)
{
    pm_status st = pm_view_check(view, err);
    if (!st && (uint64_t)width * height > PM_IMAGE_PIXELS_MAX)
        st = pm_error_set(err, PM_E_LIMIT, "a picture of %u x %u is too large", width, height);
    if (!st)
        st = make(world, (size_t)width * height, seed, out, err);
    if (!st)
        pm_camera_init(&(*out)->camera, world, view, width, height);
    return st;
}

static pm_status take_sensors(pm_accumulation *a, const pm_sensor *sensors, pm_error *err)
{
    a->probes = calloc(a->count, sizeof *a->probes);
    if (!a->probes)
        return pm_error_set(err, PM_E_MEMORY, "no memory for %zu sensors", a->count);
    for (size_t i = 0; i < a->count; i++) {
        pm_vec3 point = pm_world_from_scene(a->world, sensors[i].point);
        pm_vec3 normal = pm_view_unit(sensors[i].normal);
        if (!pm_vec3_finite(point) || !pm_vec3_finite(normal))
            return pm_error_set(err, PM_E_RANGE, "sensor %zu has a number that is not finite",
                                i + 1);
        if (pm_vec3_length(normal) == 0)
            return pm_error_set(err, PM_E_RANGE, "sensor %zu has a zero direction", i + 1);
        a->probes[i] = (struct pm_probe){point, normal};
    }
    return PM_OK;
}

pm_status pm_accumulation_for_sensors(const pm_world *world, const pm_sensor *sensors,
                                      size_t count, pm_quantity quantity, uint64_t seed,
                                      pm_accumulation **out, pm_error *err)
{
    pm_accumulation *a = NULL;
    pm_status st = make(world, count, seed, &a, err);
    if (!st)
        st = take_sensors(a, sensors, err);
    if (st) {
        pm_accumulation_free(a);
        return st;
    }
    a->quantity = quantity;
    *out = a;
    return PM_OK;
}

void pm_accumulation_free(pm_accumulation *accumulation)
{
    if (!accumulation)
        return;
    free(accumulation->probes);
    free(accumulation->sums);
    free(accumulation->deviation);
    free(accumulation->values);
    free(accumulation);
}

static void add_value(const struct pm_value *value, double sum[3], double deviation[3])
{
    sum[0] += value->radiance.r;
    sum[1] += value->radiance.g;
    sum[2] += value->radiance.b;
    deviation[0] += sqrt(value->variance.r);
    deviation[1] += sqrt(value->variance.g);
    deviation[2] += sqrt(value->variance.b);
}

void pm_accumulation_add(pm_accumulation *accumulation, uint32_t pass)
{
    uint32_t replicate = pass % PM_REPLICATES;
    double *sums = accumulation->sums + replicate * 3 * accumulation->count;
    for (size_t i = 0; i < accumulation->count; i++) {
        const struct pm_value *value = &accumulation->values[i];
        if (pm_rgb_finite(value->radiance) && pm_rgb_finite(value->variance))
            add_value(value, sums + 3 * i, accumulation->deviation + 3 * i);
        else
            accumulation->nonfinite++;
    }
    accumulation->replicate_passes[replicate]++;
    accumulation->passes++;
    accumulation->next_pass = pass + 1;
}

uint32_t pm_accumulation_passes(const pm_accumulation *accumulation)
{
    return accumulation->passes;
}

size_t pm_accumulation_count(const pm_accumulation *accumulation)
{
    return accumulation->count;
}

uint64_t pm_accumulation_nonfinite(const pm_accumulation *accumulation)
{
    return accumulation->nonfinite;
}
