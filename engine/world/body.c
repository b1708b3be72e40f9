#include "world/body.h"

#include <math.h>

#include "world/world_internal.h"

/* ---- where surfaces are ---- */

/* The last instance whose first surface is not beyond `number`; all of them hold some. */
static const struct pm_instance *instance_of(const struct pm_body *body, uint32_t number)
{
    uint32_t low = 0, high = body->instance_count - 1;
    while (low < high) {
        uint32_t middle = high - (high - low) / 2;
        if (body->instances[middle].first <= number)
            low = middle;
        else
            high = middle - 1;
    }
    return &body->instances[low];
}

void pm_place_find(const struct pm_body *main, uint32_t surface, struct pm_place *out)
{
    *out = (struct pm_place){.body = main, .local = surface, .material = PM_NO_PRIMITIVE};
    while (out->local >= out->body->own_count) {
        const struct pm_instance *instance = instance_of(out->body, out->local);
        out->chain[out->depth++] = instance;
        out->base += instance->first;
        out->local -= instance->first;
        out->body = instance->body;
        if (out->material == PM_NO_PRIMITIVE) {
            out->material = instance->material;
            out->modifier = instance->modifier;
        }
    }
}

/* ---- coordinates ---- */

pm_vec3 pm_instance_direction_in(const struct pm_instance *s, pm_vec3 d)
{
    return pm_vec3_make(pm_vec3_dot(s->axis[0], d), pm_vec3_dot(s->axis[1], d),
                        pm_vec3_dot(s->axis[2], d));
}

pm_vec3 pm_instance_direction_out(const struct pm_instance *s, pm_vec3 d)
{
    pm_vec3 sum = pm_vec3_scale(s->axis[0], d.x);
    return pm_vec3_madd(pm_vec3_madd(sum, d.y, s->axis[1]), d.z, s->axis[2]);
}

pm_vec3 pm_instance_point_in(const struct pm_instance *s, pm_vec3 p)
{
    pm_vec3 local = pm_instance_direction_in(s, pm_vec3_sub(p, s->origin));
    return pm_vec3_make(local.x / s->unit, local.y / s->unit, local.z / s->unit);
}

pm_vec3 pm_instance_point_out(const struct pm_instance *s, pm_vec3 p)
{
    return pm_vec3_madd(s->origin, s->unit, pm_instance_direction_out(s, p));
}

/* The box about the turned box; a rotation moves it by rounding, for which there is slack. */
void pm_instance_bounds(const struct pm_instance *s, pm_vec3 *low, pm_vec3 *high)
{
    const struct pm_body *b = s->body;
    double half[3] = {(b->high.x - b->low.x) / 2, (b->high.y - b->low.y) / 2,
                      (b->high.z - b->low.z) / 2};
    pm_vec3 middle = {b->low.x + half[0], b->low.y + half[1], b->low.z + half[2]};
    middle = pm_vec3_scale(pm_vec3_sub(middle, b->center), 1 / b->scale);
    pm_vec3 reach = {0x1p-40, 0x1p-40, 0x1p-40};
    for (int i = 0; i < 3; i++) {
        pm_vec3 a = s->axis[i];
        double size = half[i] / b->scale * (1 + 0x1p-40);
        reach = pm_vec3_madd(reach, size, pm_vec3_make(fabs(a.x), fabs(a.y), fabs(a.z)));
    }
    pm_vec3 at = pm_instance_point_out(s, middle);
    *low = pm_vec3_madd(at, -s->unit, reach);
    *high = pm_vec3_madd(at, s->unit, reach);
}

/* From its own scene units to those of the body that it lies in. */
static pm_transform transform_of(const struct pm_instance *s, const struct pm_body *parent)
{
    pm_transform t = {.scale = s->unit * (parent->scale / s->body->scale)};
    pm_vec3 turned = {0, 0, 0};
    const double center[3] = {s->body->center.x, s->body->center.y, s->body->center.z};
    for (int i = 0; i < 3; i++) {
        pm_vec3 row = pm_vec3_scale(s->axis[i], t.scale);
        t.turn[i][0] = row.x;
        t.turn[i][1] = row.y;
        t.turn[i][2] = row.z;
        turned = pm_vec3_madd(turned, center[i], row);
    }
    pm_vec3 at = pm_vec3_madd(parent->center, parent->scale, s->origin);
    pm_vec3 shift = pm_vec3_sub(at, turned);
    t.shift[0] = shift.x;
    t.shift[1] = shift.y;
    t.shift[2] = shift.z;
    t.mirrored = pm_vec3_dot(pm_vec3_cross(s->axis[0], s->axis[1]), s->axis[2]) < 0;
    return t;
}

/* The transposed rotation over the scale. */
static pm_transform inverse_of(const pm_transform *t)
{
    pm_transform inverse = {.scale = 1 / t->scale, .mirrored = t->mirrored};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            inverse.turn[i][k] = t->turn[k][i] / t->scale / t->scale;
    }
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            inverse.shift[k] -= t->shift[i] * inverse.turn[i][k];
    return inverse;
}

bool pm_world_instance_transform(const pm_world *world, uint32_t surface, pm_transform *from,
                                 pm_transform *to)
{
    if (surface < world->shape_count || surface >= world->main->count)
        return false;
    struct pm_place place;
    pm_place_find(world->main, surface, &place);
    const struct pm_body *parent = world->main;
    int count = 0;
    for (; count < place.depth && place.chain[count]->material == PM_NO_PRIMITIVE; count++) {
        pm_transform t = transform_of(place.chain[count], parent);
        *from = count ? pm_transform_then(&t, from) : t;
        parent = place.chain[count]->body;
    }
    if (count)
        *to = inverse_of(from);
    return count > 0;
}
