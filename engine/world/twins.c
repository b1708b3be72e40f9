#include "world/twins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/radix.h"
#include "world/body.h"
#include "world/material.h"

/* ---- planar shapes: planes hashed by two numbers ---- */

#define CELL 0x1p-24

/* Hundreds of planes within a cell of each other, none the same: a scene made to waste time. */
enum { MOST_TRIED = 256 };

static const uint32_t NONE = UINT32_MAX;

struct finder {
    struct pm_body *body;
    pm_keyed *order;     /* planar shapes, the largest first */
    double (*number)[2]; /* of all shapes: plane_numbers */
    size_t count;
    uint32_t *bucket, *next; /* chains of the groups' first shapes */
    size_t mask;
};

/* Two numbers that agree for a plane and its reverse and move no faster than a few times the
 * plane does; the constants are in no special direction. */
static void plane_numbers(const struct pm_shape *s, double out[2])
{
    const pm_vec3 a = {.619, .283, .732}, b = {-.411, .857, .311};
    double u = pm_vec3_dot(s->axis, a), v = pm_vec3_dot(s->axis, b);
    out[0] = (u * u + v * s->offset) / 4;
    out[1] = (u * v + u * s->offset) / 4;
}

static size_t bucket_of(const struct finder *f, int64_t i, int64_t j)
{
    uint64_t h = (uint64_t)i * 0x9E3779B97F4A7C15U + (uint64_t)j * 0xC2B2AE3D27D4EB4FU;
    return (size_t)(h ^ h >> 29 ^ h >> 43) & f->mask;
}

static bool lies_in_plane(const struct pm_shape *s, const struct pm_shape *plane,
                          double tolerance)
{
    if (s->type == PM_RING) {
        double tilt = pm_vec3_length(pm_vec3_cross(s->axis, plane->axis)) * s->r1;
        double height = pm_vec3_dot(plane->axis, s->center) - plane->offset;
        return fabs(height) + tilt <= tolerance;
    }
    for (uint32_t i = 0; i < s->vertex_count; i++)
        if (!(fabs(pm_vec3_dot(plane->axis, s->vertices[i]) - plane->offset) <= tolerance))
            return false;
    return true;
}

/* Of this cell and its nearest neighbours: k = 0 .. 3. */
static size_t near_bucket(const struct finder *f, uint32_t index, int k)
{
    int64_t i = (int64_t)floor(f->number[index][0] / CELL - .5) + (k & 1);
    int64_t j = (int64_t)floor(f->number[index][1] / CELL - .5) + (k >> 1);
    return bucket_of(f, i, j);
}

/* Both lie anywhere in memory: ask for them before they are needed. */
static void prefetch(const struct finder *f, size_t k)
{
    enum { AHEAD = 8 };
    if (k + AHEAD >= f->count)
        return;
    uint32_t index = f->order[k + AHEAD].value;
    __builtin_prefetch(&f->body->shapes[index].axis);
    for (int near = 0; near < 4; near++)
        __builtin_prefetch(&f->bucket[near_bucket(f, index, near)]);
}

/* The first shape of a group whose plane holds this one, or NONE. */
static uint32_t find_group(const struct finder *f, uint32_t index)
{
    const struct pm_shape *s = &f->body->shapes[index];
    for (int k = 0; k < 4; k++) {
        uint32_t l = f->bucket[near_bucket(f, index, k)];
        for (int tried = 0; l != NONE && tried < MOST_TRIED; l = f->next[l], tried++)
            if (lies_in_plane(s, &f->body->shapes[l], f->body->tolerance))
                return l;
    }
    return NONE;
}

static void join(struct pm_shape *s, const struct pm_shape *first, uint32_t group)
{
    s->flipped = pm_vec3_dot(s->axis, first->axis) < 0;
    s->axis = s->flipped ? pm_vec3_negate(first->axis) : first->axis;
    s->offset = s->flipped ? -first->offset : first->offset;
    s->group = group;
}

static void start_group(struct finder *f, uint32_t index)
{
    const double *number = f->number[index];
    size_t b = bucket_of(f, (int64_t)floor(number[0] / CELL), (int64_t)floor(number[1] / CELL));
    f->next[index] = f->bucket[b];
    f->bucket[b] = index;
}

/* Descending: positive doubles are ordered as their bits are. */
static uint64_t area_key(double area)
{
    uint64_t bits;
    memcpy(&bits, &area, sizeof bits);
    return ~bits;
}

static bool finder_init(struct finder *f)
{
    const struct pm_body *body = f->body;
    size_t buckets = 16;
    while (buckets < 2 * body->shape_count)
        buckets *= 2;
    f->mask = buckets - 1;
    f->order = malloc(((size_t)body->shape_count + 1) * sizeof *f->order);
    f->next = malloc(((size_t)body->shape_count + 1) * sizeof *f->next);
    f->number = malloc(((size_t)body->shape_count + 1) * sizeof *f->number);
    f->bucket = malloc(buckets * sizeof *f->bucket);
    if (!f->order || !f->next || !f->number || !f->bucket)
        return false;
    memset(f->bucket, 0xFF, buckets * sizeof *f->bucket);
    for (uint32_t i = 0; i < body->shape_count; i++) {
        const struct pm_shape *s = &body->shapes[i];
        if (!pm_shape_is_planar(s) || s->deviation > body->tolerance)
            continue;
        plane_numbers(s, f->number[i]);
        f->order[f->count++] = (pm_keyed){area_key(s->area), i};
    }
    return !pm_radix_sort(f->order, f->count);
}

static pm_status find_planar(struct pm_body *body)
{
    struct finder f = {.body = body};
    bool ready = finder_init(&f);
    for (size_t k = 0; ready && k < f.count; k++) {
        prefetch(&f, k);
        uint32_t index = f.order[k].value, group = find_group(&f, index);
        if (group == NONE)
            start_group(&f, index);
        else
            join(&body->shapes[index], &body->shapes[group], group);
    }
    free(f.order);
    free(f.next);
    free(f.number);
    free(f.bucket);
    return ready ? PM_OK : PM_E_MEMORY;
}

/* ---- curved shapes: equal parameters ---- */

enum { PARAMETERS = 10 };

/* Zeros without a sign, so that equal numbers have equal bits. */
static void list_parameters(const struct pm_shape *s, double out[PARAMETERS])
{
    const double p[PARAMETERS] = {
        pm_shape_is_ball(s), s->center.x, s->center.y, s->center.z, s->axis.x,
        s->axis.y,           s->axis.z,   s->r0,       s->r1,       s->height};
    for (int i = 0; i < PARAMETERS; i++)
        out[i] = p[i] + 0.0;
}

static uint64_t parameter_key(const struct pm_shape *s)
{
    double p[PARAMETERS];
    uint64_t bits[PARAMETERS], h = 0;
    list_parameters(s, p);
    memcpy(bits, p, sizeof bits);
    for (int i = 0; i < PARAMETERS; i++) {
        h = (h ^ bits[i]) * 0x9E3779B97F4A7C15U;
        h ^= h >> 32;
    }
    return h;
}

static int compare_parameters(const struct pm_shape *a, const struct pm_shape *b)
{
    double p[PARAMETERS], q[PARAMETERS];
    list_parameters(a, p);
    list_parameters(b, q);
    return memcmp(p, q, sizeof p);
}

static int by_parameters(const void *a, const void *b, void *context)
{
    const struct pm_shape *shapes = context;
    uint32_t i = ((const pm_keyed *)a)->value, j = ((const pm_keyed *)b)->value;
    int order = compare_parameters(&shapes[i], &shapes[j]);
    return order ? order : (i > j) - (i < j);
}

/* Shapes whose keys are equal: nearly always twins. */
static void group_curved(struct pm_body *body, pm_keyed *run, size_t count)
{
    qsort_r(run, count, sizeof *run, by_parameters, body->shapes);
    for (size_t k = 1; k < count; k++) {
        const struct pm_shape *before = &body->shapes[run[k - 1].value];
        struct pm_shape *s = &body->shapes[run[k].value];
        if (compare_parameters(before, s) == 0)
            s->group = before->group;
    }
}

static pm_status find_curved(struct pm_body *body)
{
    pm_keyed *curved = malloc(((size_t)body->shape_count + 1) * sizeof *curved);
    size_t count = 0;
    if (!curved)
        return PM_E_MEMORY;
    for (uint32_t i = 0; i < body->shape_count; i++) {
        struct pm_shape *s = &body->shapes[i];
        if (pm_shape_is_planar(s))
            continue;
        s->flipped = s->inward; /* outward is a group's direction */
        curved[count++] = (pm_keyed){parameter_key(s), i};
    }
    pm_status status = pm_radix_sort(curved, count);
    for (size_t i = 0, end; !status && i < count; i = end) {
        for (end = i + 1; end < count && curved[end].key == curved[i].key;)
            end++;
        if (end - i > 1)
            group_curved(body, curved + i, end - i);
    }
    free(curved);
    return status;
}

/* ---- layers ---- */

/* How far to the front a surface comes. */
static int prominence(const pm_world *world, const struct pm_shape *s)
{
    if (s->material == PM_NO_PRIMITIVE)
        return 0;
    pm_primitive_type type = world->materials[s->material].type;
    if (type == PM_LIGHT || type == PM_SPOTLIGHT || type == PM_GLOW)
        return 2;
    return type == PM_ILLUM ? 1 : 0;
}

static pm_status set_layers(const pm_world *world, struct pm_body *body)
{
    const int64_t step = INT64_C(1) << 32; /* more than any index */
    /* in each group */
    uint32_t *lamps = calloc((size_t)body->shape_count + 1, sizeof *lamps);
    if (!lamps)
        return PM_E_MEMORY;
    for (uint32_t i = 0; i < body->shape_count; i++) {
        struct pm_shape *s = &body->shapes[i];
        int rank = prominence(world, s);
        s->layer = i + (s->flipped ? rank : -rank) * step;
        lamps[s->group] += rank > 0;
    }
    for (uint32_t i = 0; i < body->shape_count; i++) {
        struct pm_shape *s = &body->shapes[i];
        s->contested = lamps[s->group] > 1 && prominence(world, s) > 0;
    }
    free(lamps);
    return PM_OK;
}

static pm_status find_twins(const pm_world *world, struct pm_body *body)
{
    for (uint32_t i = 0; i < body->shape_count; i++)
        body->shapes[i].group = i;
    pm_status status = find_planar(body);
    if (!status)
        status = find_curved(body);
    return status ? status : set_layers(world, body);
}

pm_status pm_twins_find(pm_world *world, pm_error *err)
{
    pm_status status = PM_OK;
    for (size_t i = 0; !status && i < world->body_count; i++)
        if (world->bodies[i].shape_count)
            status = find_twins(world, &world->bodies[i]);
    return status ? pm_error_set(err, status, "no memory to compare surfaces") : PM_OK;
}
