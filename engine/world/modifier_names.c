#include "world/modifier_names.h"

#include <stdlib.h>
#include <string.h>

/* ---- collecting ---- */

/* Names are equal where their pointers are (scene/names.h). */
static size_t slot_of(const struct pm_modifier_collector *c, int32_t modifier, const char *name)
{
    uint64_t hash = ((uint64_t)(uintptr_t)name ^ (uint64_t)(uint32_t)modifier << 32) *
                    UINT64_C(0x9E3779B97F4A7C15);
    return (hash >> 32) & (c->slot_count - 1);
}

static uint32_t *find(const struct pm_modifier_collector *c, int32_t modifier, const char *name)
{
    size_t at = slot_of(c, modifier, name);
    while (c->slots[at]) {
        const struct pm_modifier_key *key = &c->keys[c->slots[at] - 1];
        if (key->modifier == modifier && key->name == name)
            break;
        at = (at + 1) & (c->slot_count - 1);
    }
    return &c->slots[at];
}

/* Room for one key more, the table half empty at least. */
static bool grow(struct pm_modifier_collector *c)
{
    if (c->count < c->capacity)
        return true;
    size_t capacity = c->capacity ? 2 * c->capacity : 64;
    struct pm_modifier_key *keys = realloc(c->keys, capacity * sizeof *keys);
    if (!keys)
        return false;
    c->keys = keys;
    uint32_t *slots = calloc(2 * capacity, sizeof *slots);
    if (!slots)
        return false;
    free(c->slots);
    c->slots = slots;
    c->slot_count = 2 * capacity;
    c->capacity = capacity;
    for (size_t i = 0; i < c->count; i++)
        *find(c, keys[i].modifier, keys[i].name) = (uint32_t)i + 1;
    return true;
}

uint32_t pm_modifier_number(struct pm_modifier_collector *c, int32_t modifier, const char *name)
{
    if (c->slots) {
        uint32_t known = *find(c, modifier, name);
        if (known)
            return known - 1;
    }
    if (!grow(c))
        return PM_NO_PRIMITIVE;
    c->keys[c->count++] = (struct pm_modifier_key){modifier, name};
    *find(c, modifier, name) = (uint32_t)c->count;
    return (uint32_t)c->count - 1;
}

void pm_modifier_collector_clear(struct pm_modifier_collector *c)
{
    free(c->keys);
    free(c->slots);
    *c = (struct pm_modifier_collector){0};
}

/* ---- keeping ---- */

/* A primitive's name in the world's own memory; once for each primitive. */
static const char *copy_name(pm_world *world, const char **copies, const pm_primitive *p,
                             int32_t index)
{
    if (!copies[index])
        copies[index] = pm_arena_text(&world->arena, p->name, strlen(p->name));
    return copies[index];
}

static bool keep_chain(pm_world *world, const pm_scene *scene, const char **copies,
                       const struct pm_modifier_key *key, struct pm_modifier_chain *out)
{
    const char *names[PM_MODIFIERS_MAX];
    uint32_t length = 0, material = 0;
    for (int32_t i = key->modifier; i != PM_VOID && length < PM_MODIFIERS_MAX;
         i = scene->primitives[i].modifier) {
        if (i == scene->primitives[key->modifier].material)
            material = length;
        names[length] = copy_name(world, copies, &scene->primitives[i], i);
        if (!names[length++])
            return false;
    }
    const char **kept = pm_arena_array(&world->arena, length, sizeof *kept);
    if (!kept)
        return false;
    memcpy(kept, names, length * sizeof *kept);
    bool alias = length == 0 || strcmp(key->name, names[0]) != 0;
    *out = (struct pm_modifier_chain){
        .name = alias ? pm_arena_text(&world->arena, key->name, strlen(key->name)) : names[0],
        .length = length,
        .material = material,
        .names = kept};
    return out->name;
}

pm_status pm_modifier_names_keep(const struct pm_modifier_collector *c, pm_world *world,
                                 pm_error *err)
{
    struct pm_modifier_names *table = &world->modifiers;
    table->chains = pm_arena_array(&world->arena, c->count, sizeof *table->chains);
    const char **copies = calloc(c->scene->count + 1, sizeof *copies);
    bool complete = table->chains && copies;
    for (size_t i = 0; complete && i < c->count; i++)
        complete = keep_chain(world, c->scene, copies, &c->keys[i], &table->chains[i]);
    free(copies);
    table->count = complete ? c->count : 0;
    return complete ? PM_OK
                    : pm_error_set(err, PM_E_MEMORY, "no memory for the names of modifiers");
}
