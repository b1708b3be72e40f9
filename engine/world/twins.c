#include "world/twins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world/material.h"

/* ---- planar shapes: planes hashed by two numbers ---- */

#define CELL 0x1p-24

/* Hundreds of planes within a cell of each other, none the same: a scene made to waste time. */
enum { MOST_TRIED = 256 };

static const uint32_t NONE = UINT32_MAX;

struct finder {
    pm_world *world;
    uint32_t *order; /* planar shapes, the largest first */
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

/* The first shape of a group whose plane holds `s`, or NONE. */
static uint32_t find_group(const struct finder *f, const struct pm_shape *s)
{
    double number[2];
    plane_numbers(s, number);
    for (int k = 0; k < 4; k++) {
        /* this cell and its nearest neighbours */
        int64_t i = (int64_t)floor(number[0] / CELL - .5) + (k & 1);
        int64_t j = (int64_t)floor(number[1] / CELL - .5) + (k >> 1);
        uint32_t l = f->bucket[bucket_of(f, i, j)];
        for (int tried = 0; l != NONE && tried < MOST_TRIED; l = f->next[l], tried++)
            if (lies_in_plane(s, &f->world->shapes[l], f->world->tolerance))
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
    double number[2];
    plane_numbers(&f->world->shapes[index], number);
    size_t b = bucket_of(f, (int64_t)floor(number[0] / CELL), (int64_t)floor(number[1] / CELL));
    f->next[index] = f->bucket[b];
    f->bucket[b] = index;
}

static int larger_first(const void *a, const void *b, void *context)
{
    const struct pm_shape *shapes = context;
    uint32_t i = *(const uint32_t *)a, j = *(const uint32_t *)b;
    if (shapes[i].area != shapes[j].area)
        return shapes[i].area > shapes[j].area ? -1 : 1;
    return (i > j) - (i < j);
}

static bool finder_init(struct finder *f)
{
    const struct pm_world *world = f->world;
    size_t buckets = 16;
    while (buckets < 2 * world->shape_count)
        buckets *= 2;
    f->mask = buckets - 1;
    f->order = malloc((world->shape_count + 1) * sizeof *f->order);
    f->next = malloc((world->shape_count + 1) * sizeof *f->next);
    f->bucket = malloc(buckets * sizeof *f->bucket);
    if (!f->order || !f->next || !f->bucket)
        return false;
    memset(f->bucket, 0xFF, buckets * sizeof *f->bucket);
    for (uint32_t i = 0; i < world->shape_count; i++) {
        const struct pm_shape *s = &world->shapes[i];
        if (pm_shape_is_planar(s) && s->deviation <= world->tolerance)
            f->order[f->count++] = i;
    }
    qsort_r(f->order, f->count, sizeof *f->order, larger_first, world->shapes);
    return true;
}

static pm_status find_planar(pm_world *world)
{
    struct finder f = {.world = world};
    bool ready = finder_init(&f);
    for (size_t k = 0; ready && k < f.count; k++) {
        struct pm_shape *s = &world->shapes[f.order[k]];
        uint32_t group = find_group(&f, s);
        if (group == NONE)
            start_group(&f, f.order[k]);
        else
            join(s, &world->shapes[group], group);
    }
    free(f.order);
    free(f.next);
    free(f.bucket);
    return ready ? PM_OK : PM_E_MEMORY;
}

/* ---- curved shapes: equal parameters ---- */

static int compare_numbers(const double *a, const double *b, int count)
{
    for (int i = 0; i < count; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_parameters(const struct pm_shape *a, const struct pm_shape *b)
{
    const double p[] = {pm_shape_is_ball(a), a->center.x, a->center.y, a->center.z, a->axis.x,
                        a->axis.y,           a->axis.z,   a->r0,       a->r1,       a->height};
    const double q[] = {pm_shape_is_ball(b), b->center.x, b->center.y, b->center.z, b->axis.x,
                        b->axis.y,           b->axis.z,   b->r0,       b->r1,       b->height};
    return compare_numbers(p, q, (int)(sizeof p / sizeof *p));
}

static int by_parameters(const void *a, const void *b, void *context)
{
    const struct pm_shape *shapes = context;
    uint32_t i = *(const uint32_t *)a, j = *(const uint32_t *)b;
    int order = compare_parameters(&shapes[i], &shapes[j]);
    return order ? order : (i > j) - (i < j);
}

static pm_status find_curved(pm_world *world)
{
    uint32_t *curved = malloc((world->shape_count + 1) * sizeof *curved);
    size_t count = 0;
    if (!curved)
        return PM_E_MEMORY;
    for (uint32_t i = 0; i < world->shape_count; i++)
        if (!pm_shape_is_planar(&world->shapes[i]))
            curved[count++] = i;
    qsort_r(curved, count, sizeof *curved, by_parameters, world->shapes);
    for (size_t k = 0; k < count; k++) {
        struct pm_shape *s = &world->shapes[curved[k]];
        s->flipped = s->inward; /* outward is a group's direction */
        if (k == 0 || compare_parameters(&world->shapes[curved[k - 1]], s) != 0)
            continue;
        s->group = world->shapes[curved[k - 1]].group;
    }
    free(curved);
    return PM_OK;
}

/* ---- layers ---- */

/* How far to the front a surface comes. */
static int prominence(const struct pm_material *m)
{
    if (m->type == PM_LIGHT || m->type == PM_SPOTLIGHT || m->type == PM_GLOW)
        return 2;
    return m->type == PM_ILLUM ? 1 : 0;
}

static pm_status set_layers(pm_world *world)
{
    const int64_t step = INT64_C(1) << 32; /* more than any index */
    /* in each group */
    uint32_t *lamps = calloc(world->shape_count + 1, sizeof *lamps);
    if (!lamps)
        return PM_E_MEMORY;
    for (uint32_t i = 0; i < world->shape_count; i++) {
        struct pm_shape *s = &world->shapes[i];
        int rank = prominence(&world->materials[s->material]);
        s->layer = i + (s->flipped ? rank : -rank) * step;
        lamps[s->group] += rank > 0;
    }
    for (uint32_t i = 0; i < world->shape_count; i++) {
        struct pm_shape *s = &world->shapes[i];
        s->contested = lamps[s->group] > 1 && prominence(&world->materials[s->material]) > 0;
    }
    free(lamps);
    return PM_OK;
}

pm_status pm_twins_find(pm_world *world, pm_error *err)
{
    for (uint32_t i = 0; i < world->shape_count; i++)
        world->shapes[i].group = i;
    pm_status status = find_planar(world);
    if (!status)
        status = find_curved(world);
    if (!status)
        status = set_layers(world);
    return status ? pm_error_set(err, status, "no memory to compare surfaces") : PM_OK;
}
