#include "world/bodies.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world/cube.h"
#include "world/material.h"
#include "world/mesh_body.h"
#include "world/modifier_names.h"

struct maker {
    pm_world *world;
    const pm_scene *scene;
    const struct pm_identity *identity;
    pm_error *err;
    uint32_t *of_prototype; /* [scene->prototype_count]: its body */
    uint32_t *place;        /* [scene->count]: of what a body holds, among its like */
    struct pm_modifier_collector *modifiers;
};

static pm_status no_memory(const struct maker *m)
{
    return pm_error_set(m->err, PM_E_MEMORY, "no memory for the scene's surfaces");
}

static pm_status refuse(const struct maker *m, const pm_primitive *p, pm_status status,
                        const char *what)
{
    return pm_error_set_at(m->err, status, m->scene->files[p->file], p->line, p->column,
                           "%s %s %s", pm_primitive_type_name(p->type), p->name, what);
}

static struct pm_body *body_of(const struct maker *m, const pm_primitive *instance)
{
    return &m->world->bodies[m->of_prototype[instance->assets[0]]];
}

/* What a body is made of. */
struct source {
    const struct pm_content *content;
    const pm_prototype *prototype; /* NULL: the main scene */
    size_t first, end;             /* its primitives */
};

static struct source source_of(const struct maker *m, size_t body)
{
    const struct pm_identity *identity = m->identity;
    if (body == identity->order_count)
        return (struct source){&identity->main, NULL, 0, m->scene->main_count};
    uint32_t index = identity->order[body];
    const pm_prototype *p = &m->scene->prototypes[index];
    return (struct source){&identity->prototypes[index], p, p->first, p->first + p->count};
}

/* ---- bounds ---- */

static void include(struct pm_body *b, pm_vec3 low, pm_vec3 high)
{
    b->low = pm_vec3_min(b->low, low);
    b->high = pm_vec3_max(b->high, high);
}

static pm_vec3 turned(const pm_transform *t, pm_vec3 v)
{
    double out[3];
    for (int k = 0; k < 3; k++)
        out[k] = v.x * t->turn[0][k] + v.y * t->turn[1][k] + v.z * t->turn[2][k];
    return pm_vec3_make(out[0], out[1], out[2]);
}

static pm_vec3 moved(const pm_transform *t, pm_vec3 p)
{
    return pm_vec3_add(turned(t, p), pm_vec3_make(t->shift[0], t->shift[1], t->shift[2]));
}

static pm_transform transform_of(const pm_primitive *p)
{
    return p->transform ? *p->transform : pm_transform_identity();
}

/* The box about the turned box. */
static void include_instance(struct pm_body *b, const pm_transform *t,
                             const struct pm_body *placed)
{
    for (int corner = 0; corner < 8; corner++) {
        pm_vec3 p = {corner & 1 ? placed->high.x : placed->low.x,
                     corner & 2 ? placed->high.y : placed->low.y,
                     corner & 4 ? placed->high.z : placed->low.z};
        p = moved(t, p);
        include(b, p, p);
    }
}

static bool is_instance(const pm_primitive *p)
{
    return p->type == PM_INSTANCE || p->type == PM_MESH;
}

static pm_status include_primitive(const struct maker *m, struct pm_body *b,
                                   const pm_primitive *p)
{
    pm_vec3 low, high;
    if (is_instance(p)) {
        pm_transform t = transform_of(p);
        if (!body_of(m, p)->empty)
            include_instance(b, &t, body_of(m, p));
        return PM_OK;
    }
    pm_status status = pm_shape_scene_bounds(m->scene, p, &low, &high, m->err);
    if (!status)
        include(b, low, high);
    return status;
}

/* In file order, so that the first bad primitive of the file is the one that is named. */
static pm_status find_bounds(const struct maker *m, struct pm_body *b,
                             const struct source *source)
{
    pm_status status = PM_OK;
    b->low = pm_vec3_make(INFINITY, INFINITY, INFINITY);
    b->high = pm_vec3_negate(b->low);
    if (source->prototype && source->prototype->mesh)
        include(b, source->prototype->mesh->low, source->prototype->mesh->high);
    for (size_t i = source->first; !status && i < source->end; i++)
        if (m->place[i] != PM_NO_PRIMITIVE)
            status = include_primitive(m, b, &m->scene->primitives[i]);
    b->empty = b->low.x > b->high.x;
    return status;
}

/* ---- what it holds ---- */

static uint32_t material_of(const struct maker *m, int32_t modifier)
{
    return modifier == PM_VOID ? PM_NO_PRIMITIVE
                               : m->identity->materials.of_primitive[modifier];
}

/* False if memory is short. */
static bool number_modifier(const struct maker *m, const pm_primitive *p, uint32_t *out)
{
    *out = pm_modifier_number(m->modifiers, p->modifier, p->modifier_name);
    return *out != PM_NO_PRIMITIVE;
}

/* Where the shapes of primitives soon to come are to be written: anywhere in memory. */
static void prefetch(const struct maker *m, const struct pm_body *b, size_t i, size_t end)
{
    enum { AHEAD = 8, LINE = 64 };
    if (i + AHEAD >= end || m->place[i + AHEAD] == PM_NO_PRIMITIVE ||
        is_instance(&m->scene->primitives[i + AHEAD]))
        return;
    const char *shape = (const char *)&b->shapes[m->place[i + AHEAD]];
    for (size_t at = 0; at < sizeof *b->shapes; at += LINE)
        __builtin_prefetch(shape + at, 1);
}

/* In file order, as above. */
static pm_status make_shapes(const struct maker *m, struct pm_body *b,
                             const struct source *source)
{
    const struct pm_shape_frame frame = {b->center, b->scale, b->tolerance};
    size_t count = source->content->surface_count;
    b->shapes = pm_arena_array(&m->world->arena, count, sizeof *b->shapes);
    if (!b->shapes)
        return no_memory(m);
    for (size_t i = source->first; count && i < source->end; i++) {
        const pm_primitive *p = &m->scene->primitives[i];
        if (m->place[i] == PM_NO_PRIMITIVE || is_instance(p))
            continue;
        struct pm_shape *shape = &b->shapes[m->place[i]];
        prefetch(m, b, i, source->end);
        pm_status status = pm_shape_make(m->scene, p, &frame, &m->world->arena, shape, m->err);
        if (status)
            return status;
        shape->material = material_of(m, p->modifier);
        shape->primitive = (uint32_t)i;
        if (!number_modifier(m, p, &shape->modifier))
            return no_memory(m);
    }
    b->shape_count = b->own_count = (uint32_t)count;
    return PM_OK;
}

static pm_status make_mesh(const struct maker *m, struct pm_body *b,
                           const pm_prototype *prototype)
{
    const pm_mesh *mesh = prototype->mesh;
    uint32_t *materials = pm_arena_array(&m->world->arena, mesh->slot_count, sizeof *materials);
    uint32_t *modifiers = pm_arena_array(&m->world->arena, mesh->slot_count, sizeof *modifiers);
    if (!materials || !modifiers)
        return no_memory(m);
    for (uint32_t i = 0; i < mesh->slot_count; i++) {
        int32_t slot = prototype->slots[i];
        const char *name = slot == PM_VOID ? "void" : m->scene->primitives[slot].name;
        materials[i] = material_of(m, slot);
        modifiers[i] = pm_modifier_number(m->modifiers, slot, name);
        if (modifiers[i] == PM_NO_PRIMITIVE)
            return no_memory(m);
    }
    b->own_count = mesh->triangle_count;
    pm_status status = pm_mesh_body_make(b, mesh, materials, &m->world->arena, m->err);
    b->mesh.modifiers = modifiers;
    return status;
}

static pm_status make_instance(const struct maker *m, const struct pm_body *b,
                               const pm_primitive *p, struct pm_instance *out)
{
    const struct pm_body *placed = body_of(m, p);
    pm_transform t = transform_of(p);
    pm_vec3 middle = pm_vec3_sub(moved(&t, placed->center), b->center);
    *out = (struct pm_instance){.origin = pm_vec3_scale(middle, 1 / b->scale),
                                .unit = t.scale * (placed->scale / b->scale),
                                .body = placed,
                                .material = material_of(m, p->modifier),
                                .primitive = (uint32_t)(p - m->scene->primitives)};
    for (int i = 0; i < 3; i++)
        out->axis[i] = pm_vec3_make(t.turn[i][0] / t.scale, t.turn[i][1] / t.scale,
                                    t.turn[i][2] / t.scale);
    if (!number_modifier(m, p, &out->modifier))
        return no_memory(m);
    if (!(out->unit > b->tolerance))
        return refuse(m, p, PM_E_RANGE, "is too small beside the size of the scene");
    if (out->material != PM_NO_PRIMITIVE &&
        pm_material_emits(&m->world->materials[out->material]))
        return refuse(m, p, PM_E_UNSUPPORTED,
                      "has a light as its modifier; only surfaces with an area of their own "
                      "shine: polygons, spheres, rings, cylinders, cones");
    return PM_OK;
}

static pm_status make_instances(const struct maker *m, struct pm_body *b,
                                const struct source *source)
{
    size_t count = source->content->instance_count;
    uint64_t total = b->own_count;
    pm_digest *digests = pm_arena_array(&m->world->arena, count, sizeof *digests);
    b->instances = pm_arena_array(&m->world->arena, count, sizeof *b->instances);
    if (!digests || !b->instances)
        return no_memory(m);
    b->instance_digests = digests;
    for (size_t i = 0; i < count; i++) {
        const pm_primitive *p = &m->scene->primitives[source->content->instances[i]];
        struct pm_instance *instance = &b->instances[b->instance_count];
        if (body_of(m, p)->empty)
            continue;
        pm_status status = make_instance(m, b, p, instance);
        if (status)
            return status;
        instance->first = (uint32_t)total;
        total += instance->body->count;
        if (total >= PM_NO_PRIMITIVE)
            return refuse(m, p, PM_E_LIMIT,
                          "brings the surfaces in all to more than 4294967294");
        digests[b->instance_count++] = source->content->instance_digests[i];
    }
    b->count = (uint32_t)total;
    return PM_OK;
}

/* ---- how many of what ---- */

static void count_kinds(struct pm_tally *t, const struct maker *m, uint32_t material,
                        uint32_t count)
{
    if (material == PM_NO_PRIMITIVE)
        return;
    const struct pm_material *kind = &m->world->materials[material];
    t->specular += pm_material_is_specular(kind) ? count : 0;
    t->diffuse += pm_material_is_diffuse(kind) ? count : 0;
    t->mist += pm_material_is_mist(kind) ? count : 0;
}

static void count_instance(struct pm_tally *t, const struct maker *m,
                           const struct pm_instance *instance)
{
    const struct pm_body *b = instance->body;
    if (instance->material != PM_NO_PRIMITIVE) {
        count_kinds(t, m, instance->material, b->count);
        return;
    }
    t->specular += b->tally.specular;
    t->diffuse += b->tally.diffuse;
    t->mist += b->tally.mist;
}

static void count_surfaces(const struct maker *m, struct pm_body *b)
{
    for (uint32_t i = 0; i < b->shape_count; i++)
        count_kinds(&b->tally, m, b->shapes[i].material, 1);
    for (uint32_t i = 0; b->mesh.mesh && i < b->own_count; i++)
        count_kinds(&b->tally, m, pm_mesh_body_material(&b->mesh, i), 1);
    for (uint32_t i = 0; i < b->instance_count; i++)
        count_instance(&b->tally, m, &b->instances[i]);
}

/* ---- all bodies ---- */

static void maker_clear(struct maker *m)
{
    free(m->of_prototype);
    free(m->place);
}

static void set_places(struct maker *m, const struct pm_content *content)
{
    for (uint32_t i = 0; i < content->surface_count; i++)
        m->place[content->surfaces[i]] = i;
    for (uint32_t i = 0; i < content->instance_count; i++)
        m->place[content->instances[i]] = i;
}

static bool maker_init(struct maker *m)
{
    const struct pm_identity *identity = m->identity;
    m->of_prototype = calloc(m->scene->prototype_count + 1, sizeof *m->of_prototype);
    m->place = malloc((m->scene->count + 1) * sizeof *m->place);
    if (!m->of_prototype || !m->place)
        return false;
    memset(m->place, 0xFF, m->scene->count * sizeof *m->place);
    set_places(m, &identity->main);
    for (uint32_t i = 0; i < identity->order_count; i++) {
        m->of_prototype[identity->order[i]] = i;
        set_places(m, &identity->prototypes[identity->order[i]]);
    }
    return true;
}

pm_status pm_bodies_place(pm_world *world, const pm_scene *scene,
                          const struct pm_identity *identity, pm_error *err)
{
    struct maker m = {.world = world, .scene = scene, .identity = identity, .err = err};
    size_t count = identity->order_count + 1;
    world->bodies = pm_arena_array(&world->arena, count, sizeof *world->bodies);
    pm_status status = maker_init(&m) && world->bodies ? PM_OK : no_memory(&m);
    for (size_t i = 0; !status && i < count; i++) {
        struct source source = source_of(&m, i);
        status = find_bounds(&m, &world->bodies[i], &source);
        if (!status)
            status = pm_cube_choose(&world->bodies[i], err);
    }
    maker_clear(&m);
    if (status)
        return status;
    world->body_count = count;
    world->main = &world->bodies[count - 1];
    world->center = world->main->center;
    world->scale = world->main->scale;
    world->tolerance = world->main->tolerance;
    world->low = world->main->low;
    world->high = world->main->high;
    return PM_OK;
}

static pm_status fill(const struct maker *m, struct pm_body *b, const struct source *source)
{
    pm_status status = source->prototype && source->prototype->mesh
                           ? make_mesh(m, b, source->prototype)
                           : make_shapes(m, b, source);
    if (!status)
        status = make_instances(m, b, source);
    if (!status)
        count_surfaces(m, b);
    return status;
}

pm_status pm_bodies_fill(pm_world *world, const pm_scene *scene,
                         const struct pm_identity *identity, pm_error *err)
{
    struct pm_modifier_collector modifiers = {.scene = scene};
    struct maker m = {.world = world,
                      .scene = scene,
                      .identity = identity,
                      .err = err,
                      .modifiers = &modifiers};
    pm_status status = maker_init(&m) ? PM_OK : no_memory(&m);
    for (size_t i = 0; !status && i < world->body_count; i++) {
        struct source source = source_of(&m, i);
        status = fill(&m, &world->bodies[i], &source);
    }
    if (!status)
        status = pm_modifier_names_keep(&modifiers, world, err);
    pm_modifier_collector_clear(&modifiers);
    maker_clear(&m);
    world->shapes = world->main->shapes;
    world->shape_count = world->main->shape_count;
    return status;
}
