#include "world/targets.h"

#include <math.h>
#include <stdlib.h>

#include "base/maths.h"
#include "base/warp.h"
#include "world/body.h"
#include "world/material.h"
#include "world/placed.h"

enum { BINS = 32, EDGE = 4 };

/* A group is divided if that takes away so much of the disc that it shows. */
#define WORTH_DIVIDING .9

/* Smaller cones would drown in rounding. */
#define LEAST_VERSINE 0x1p-40

struct item {
    pm_vec3 low, high;
    double radius; /* of a ball; 0: the box counts */
    double weight;
};

/* Items first .. first + count - 1, and how to divide them best. */
struct group {
    size_t first, count;
    pm_vec3 low, high;
    double cost; /* radius^2, times the weight */
    bool is_worth_dividing;
    double gain;
    int axis;
    double at; /* items whose middle lies below go to the first half */
};

struct builder {
    const pm_world *world;
    struct item *items;
    size_t count, capacity;
    struct group groups[PM_TARGETS_MAX];
    unsigned group_count;
};

/* ---- what is specular ---- */

static double plastic_weight(const struct pm_material *m, double color)
{
    double passed = (1 - m->specularity) * m->transmission * m->straight_fraction;
    return m->specularity + (m->roughness > 0 ? passed * color : 0);
}

/* About the albedo of what is no diffuse event. */
static double material_weight(const struct pm_material *m)
{
    double color = pm_rgb_mean(m->color), weight = .5;
    if (m->type == PM_DIELECTRIC || m->type == PM_INTERFACE || m->type == PM_PRISM1 ||
        m->type == PM_PRISM2)
        weight = 1;
    else if (m->type == PM_MIRROR)
        weight = color;
    else if (m->type == PM_GLASS)
        weight = .1;
    else if (m->type == PM_PLASTIC || m->type == PM_PLASTIC2 || m->type == PM_TRANS ||
             m->type == PM_TRANS2)
        weight = plastic_weight(m, color);
    else if (m->type == PM_METAL || m->type == PM_METAL2)
        weight = m->specularity * color;
    else if (m->type == PM_ASHIK2)
        weight = pm_rgb_mean(m->specular_color);
    return fmax(.01, fmin(weight, 1));
}

static pm_status add_item(struct builder *b, const struct item *item, pm_error *err)
{
    if (b->count == b->capacity) {
        size_t capacity = b->capacity ? 2 * b->capacity : 64;
        struct item *items = realloc(b->items, capacity * sizeof *items);
        if (!items)
            return pm_error_set(err, PM_E_MEMORY, "no memory to find specular surfaces");
        b->items = items;
        b->capacity = capacity;
    }
    b->items[b->count++] = *item;
    return PM_OK;
}

static pm_status collect_shapes(struct builder *b, pm_error *err)
{
    const pm_world *world = b->world;
    for (size_t i = 0; i < world->shape_count; i++) {
        const struct pm_shape *shape = &world->shapes[i];
        const struct pm_material *m = &world->materials[shape->material];
        bool ball = shape->type == PM_SPHERE || shape->type == PM_BUBBLE;
        struct item item = {shape->low, shape->high, ball ? shape->r0 : 0, material_weight(m)};
        pm_status st = m->specular ? add_item(b, &item, err) : PM_OK;
        if (st)
            return st;
    }
    return PM_OK;
}

static pm_status collect_instances(struct builder *b, pm_error *err)
{
    const pm_world *world = b->world;
    const struct pm_body *main = world->main;
    for (uint32_t i = 0; i < main->instance_count; i++) {
        const struct pm_instance *instance = &main->instances[i];
        bool own = instance->material == PM_NO_PRIMITIVE;
        if (own ? !instance->body->tally.specular
                : !world->materials[instance->material].specular)
            continue;
        struct item item = {.weight = .5};
        if (!own)
            item.weight = material_weight(&world->materials[instance->material]);
        pm_instance_bounds(instance, &item.low, &item.high);
        pm_status st = add_item(b, &item, err);
        if (st)
            return st;
    }
    return PM_OK;
}

/* ---- groups ---- */

static double part(pm_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static double middle_of(const struct item *item, int axis)
{
    return .5 * (part(item->low, axis) + part(item->high, axis));
}

struct bin {
    pm_vec3 low, high;
    double weight, radius;
    size_t count;
};

static const struct bin no_items = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 0, 0};

static void add_to_bin(struct bin *bin, const struct item *item)
{
    bin->low = pm_vec3_min(bin->low, item->low);
    bin->high = pm_vec3_max(bin->high, item->high);
    bin->weight = fmax(bin->weight, item->weight);
    bin->radius = item->radius;
    bin->count++;
}

static void add_bin(struct bin *sum, const struct bin *bin)
{
    if (!bin->count)
        return;
    sum->low = pm_vec3_min(sum->low, bin->low);
    sum->high = pm_vec3_max(sum->high, bin->high);
    sum->weight = fmax(sum->weight, bin->weight);
    sum->radius = bin->radius;
    sum->count += bin->count;
}

static double cost_of(const struct bin *bin)
{
    if (!bin->count)
        return 0;
    pm_vec3 size = pm_vec3_sub(bin->high, bin->low);
    double square = .25 * pm_vec3_dot(size, size);
    if (bin->count == 1 && bin->radius > 0)
        square = bin->radius * bin->radius;
    return square * bin->weight;
}

static void try_axis(const struct builder *b, struct group *g, int axis)
{
    struct bin bins[BINS], right[BINS + 1], left = no_items;
    double low = part(g->low, axis), size = part(g->high, axis) - low;
    if (!(size > 0))
        return;
    for (int i = 0; i < BINS; i++)
        bins[i] = no_items;
    for (size_t i = g->first; i < g->first + g->count; i++) {
        int bin = (int)((middle_of(&b->items[i], axis) - low) / size * BINS);
        add_to_bin(&bins[bin < 0 ? 0 : bin < BINS ? bin : BINS - 1], &b->items[i]);
    }
    right[BINS] = no_items;
    for (int i = BINS - 1; i >= 0; i--) {
        right[i] = right[i + 1];
        add_bin(&right[i], &bins[i]);
    }
    for (int i = 1; i < BINS; i++) {
        add_bin(&left, &bins[i - 1]);
        if (!left.count || !right[i].count)
            continue;
        double gain = g->cost - cost_of(&left) - cost_of(&right[i]);
        if (gain > g->gain) {
            g->gain = gain;
            g->axis = axis;
            g->at = low + size * i / BINS;
        }
    }
}

static struct group make_group(const struct builder *b, size_t first, size_t count)
{
    struct bin all = no_items;
    for (size_t i = first; i < first + count; i++)
        add_to_bin(&all, &b->items[i]);
    struct group g = {.first = first, .count = count, .low = all.low, .high = all.high};
    g.cost = cost_of(&all);
    for (int axis = 0; axis < 3 && count > 1; axis++)
        try_axis(b, &g, axis);
    g.is_worth_dividing = g.gain > (1 - WORTH_DIVIDING) * g.cost;
    return g;
}

static void divide(struct builder *b, unsigned index)
{
    struct group *g = &b->groups[index];
    size_t first = g->first, end = first + g->count, middle = first;
    double low = part(g->low, g->axis), size = part(g->high, g->axis) - low;
    int limit = (int)((g->at - low) / size * BINS + .5);
    for (size_t i = first; i < end; i++) {
        struct item item = b->items[i];
        int bin = (int)((middle_of(&item, g->axis) - low) / size * BINS);
        if ((bin < 0 ? 0 : bin < BINS ? bin : BINS - 1) >= limit)
            continue;
        b->items[i] = b->items[middle];
        b->items[middle++] = item;
    }
    *g = make_group(b, first, middle - first);
    b->groups[b->group_count++] = make_group(b, middle, end - middle);
}

/* The division that gains most comes first. */
static void divide_all(struct builder *b)
{
    while (b->group_count < PM_TARGETS_MAX) {
        unsigned best = PM_TARGETS_MAX;
        for (unsigned i = 0; i < b->group_count; i++)
            if (b->groups[i].is_worth_dividing &&
                (best == PM_TARGETS_MAX || b->groups[i].gain > b->groups[best].gain))
                best = i;
        if (best == PM_TARGETS_MAX)
            return;
        divide(b, best);
    }
}

/* ---- balls ---- */

static double reach_of(const struct item *item, pm_vec3 center)
{
    pm_vec3 middle = pm_vec3_scale(pm_vec3_add(item->low, item->high), .5);
    double half = .5 * pm_vec3_distance(item->low, item->high);
    return pm_vec3_distance(middle, center) + (item->radius > 0 ? item->radius : half);
}

static void add_ball(const struct builder *b, const struct group *g, pm_targets *out)
{
    pm_vec3 center = pm_vec3_scale(pm_vec3_add(g->low, g->high), .5);
    double reach = 0, weight = 0, sum = 0;
    for (size_t i = g->first; i < g->first + g->count; i++) {
        const struct item *item = &b->items[i];
        double square =
            pm_vec3_dot(pm_vec3_sub(item->high, item->low), pm_vec3_sub(item->high, item->low));
        reach = fmax(reach, reach_of(item, center));
        weight += square * item->weight;
        sum += square;
    }
    unsigned t = out->count++;
    out->x[t] = center.x;
    out->y[t] = center.y;
    out->z[t] = center.z;
    out->radius[t] = fmin(reach, .5 * pm_vec3_distance(g->low, g->high));
    if (g->count == 1)
        out->radius[t] = reach;
    out->radius[t] = out->radius[t] * (1 + 1e-9) + 1e-12;
    out->weight[t] = sum > 0 ? weight / sum : b->items[g->first].weight;
}

static void make_balls(struct builder *b, pm_targets *out)
{
    out->count = 0;
    if (!b->count)
        return;
    b->groups[b->group_count++] = make_group(b, 0, b->count);
    divide_all(b);
    for (unsigned i = 0; i < b->group_count; i++)
        add_ball(b, &b->groups[i], out);
}

pm_status pm_targets_find(const pm_world *world, pm_targets *out, pm_error *err)
{
    struct builder b = {.world = world};
    pm_status st = collect_shapes(&b, err);
    if (!st)
        st = collect_instances(&b, err);
    if (!st)
        make_balls(&b, out);
    free(b.items);
    return st;
}

/* Of an instance's surface, about. */
static struct item placed_item(const pm_world *world, uint32_t surface)
{
    struct item item = {.weight = 1};
    for (int i = 0; i < EDGE * EDGE; i++) {
        double u = i % EDGE * (1 - 0x1p-30) / (EDGE - 1);
        double v = i / EDGE * (1 - 0x1p-30) / (EDGE - 1);
        pm_vec3 point, normal;
        pm_placed_sample(world, surface, u, v, &point, &normal);
        item.low = i ? pm_vec3_min(item.low, point) : point;
        item.high = i ? pm_vec3_max(item.high, point) : point;
    }
    return item;
}

pm_status pm_targets_about(const pm_world *world, const uint32_t *surfaces, size_t count,
                           pm_targets *out, pm_error *err)
{
    struct builder b = {.world = world};
    pm_status st = PM_OK;
    for (size_t i = 0; i < count && !st; i++) {
        struct item item = placed_item(world, surfaces[i]);
        if (surfaces[i] < world->shape_count) {
            item.low = world->shapes[surfaces[i]].low;
            item.high = world->shapes[surfaces[i]].high;
        }
        st = add_item(&b, &item, err);
    }
    if (!st)
        make_balls(&b, out);
    free(b.items);
    return st;
}

void pm_targets_add(pm_targets *targets, pm_vec3 center, double radius, double weight)
{
    unsigned t = targets->count;
    if (t == PM_TARGETS_MAX)
        return;
    targets->x[t] = center.x;
    targets->y[t] = center.y;
    targets->z[t] = center.z;
    targets->radius[t] = radius;
    targets->weight[t] = weight;
    targets->count++;
}

/* ---- seen from a point ---- */

/* Of the light that leaves by the cosine, the share that goes to a ball of angular radius
 * asin(sine), `cosine` off the normal; an estimate where the horizon cuts it. */
static double cosine_share(double sine, double cosine)
{
    if (cosine <= -sine)
        return 0;
    if (cosine < sine)
        cosine = (cosine + sine) * (cosine + sine) / (4 * sine);
    return sine * sine * cosine;
}

/* Whether cones may overlap: chords obey the triangle's inequality. */
static double cone_share(const pm_target_lobe *lobe, double off_square, double versine)
{
    double reach = sqrt(2 * versine) + sqrt(2 * lobe->versine);
    return off_square < reach * reach ? fmin(1, versine / lobe->versine) : 0;
}

void pm_targets_look(const pm_targets *targets, pm_vec3 point, const pm_target_lobe *lobe,
                     pm_target_view *out)
{
    out->targets = targets;
    out->total = out->around = 0;
    double share = 0;
    for (unsigned t = 0; t < targets->count; t++) {
        pm_vec3 way = {targets->x[t] - point.x, targets->y[t] - point.y,
                       targets->z[t] - point.z};
        double square = pm_vec3_dot(way, way), radius = targets->radius[t];
        double sine2 = square > 0 ? radius * radius / square : 2;
        bool holds = !(sine2 < 1);
        out->versine[t] = holds ? 1 : fmax(sine2 / (1 + sqrt(1 - sine2)), LEAST_VERSINE);
        way = square > 0 ? pm_vec3_scale(way, 1 / sqrt(square)) : lobe->normal;
        pm_vec3 off = pm_vec3_sub(way, lobe->normal);
        double part_of_light = 1;
        if (!holds && lobe->is_cone)
            part_of_light = cone_share(lobe, pm_vec3_dot(off, off), out->versine[t]);
        else if (!holds)
            part_of_light = cosine_share(sqrt(sine2), pm_vec3_dot(way, lobe->normal));
        holds = holds || (lobe->is_cone && !(out->versine[t] < lobe->versine));
        double chance = part_of_light * targets->weight[t];
        out->x[t] = way.x;
        out->y[t] = way.y;
        out->z[t] = way.z;
        out->chance[t] = holds ? 0 : chance;
        out->density[t] = holds ? 0 : chance / (2 * PM_PI * out->versine[t]);
        out->total += out->chance[t];
        out->around += holds ? chance : 0;
        share += holds ? 0 : part_of_light;
    }
    out->share = fmin(share, 1);
}

static double density_but_of(const pm_target_view *view, pm_vec3 d, unsigned chosen)
{
    double sum = 0;
    for (unsigned t = 0; t < view->targets->count; t++) {
        double x = d.x - view->x[t], y = d.y - view->y[t], z = d.z - view->z[t];
        bool in = x * x + y * y + z * z <= 2 * view->versine[t]; /* |off|^2 = 2 (1 - cos) */
        sum += in || t == chosen ? view->density[t] : 0;
    }
    return sum / view->total;
}

pm_vec3 pm_targets_sample(const pm_target_view *view, double u, double v, double *pdf)
{
    unsigned chosen = 0, last = 0;
    double at = u * view->total;
    for (unsigned t = 0; t < view->targets->count; t++)
        if (view->chance[t] > 0)
            last = t;
    while (chosen < last && !(at < view->chance[chosen]))
        at -= view->chance[chosen++];
    double place = fmax(0, fmin(at / view->chance[chosen], 1 - 0x1p-53));
    pm_vec3 axis = {view->x[chosen], view->y[chosen], view->z[chosen]};
    pm_frame frame = pm_frame_make(axis);
    pm_vec3 direction =
        pm_frame_to_world(&frame, pm_warp_cone(place, v, view->versine[chosen]));
    *pdf = density_but_of(view, direction, chosen);
    return direction;
}

double pm_targets_pdf(const pm_target_view *view, pm_vec3 direction)
{
    return view->total > 0 ? density_but_of(view, direction, PM_TARGETS_MAX) : 0;
}
