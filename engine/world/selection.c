#include "world/selection.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "world/body.h"
#include "world/mesh_body.h"
#include "world/world_internal.h"

/* ---- names ---- */

static bool is_in_chain(const struct pm_modifier_chain *chain, const char *name)
{
    bool found = !strcmp(chain->name, name);
    for (uint32_t i = 0; i < chain->length && !found; i++)
        found = !strcmp(chain->names[i], name);
    return found;
}

static pm_status unknown_name(const pm_world *world, const char *name, const char *option,
                              pm_error *err)
{
    char known[256] = "";
    size_t used = 0;
    for (size_t i = 0; i < world->modifiers.count && used < sizeof known - 1; i++) {
        int length = snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "",
                              world->modifiers.chains[i].name);
        used += length > 0 ? (size_t)length : 0;
    }
    const char *more = used >= sizeof known ? ", ..." : "";
    return pm_error_set(err, PM_E_MISSING,
                        "%s: no surface has the modifier '%.60s'; there are: %s%s", option,
                        name, known, more);
}

static pm_status choose(const pm_world *world, const char *name, const char *option,
                        pm_selection *out, pm_error *err)
{
    bool found = false;
    for (size_t i = 0; i < world->modifiers.count; i++)
        if (is_in_chain(&world->modifiers.chains[i], name))
            found = out->is_chosen[i] = true;
    return found ? PM_OK : unknown_name(world, name, option, err);
}

/* ---- the digest ---- */

static bool has_own(const pm_selection *selection, const struct pm_body *body, uint32_t local)
{
    uint32_t modifier = body->mesh.mesh ? pm_mesh_body_modifier(&body->mesh, local)
                                        : body->shapes[local].modifier;
    return modifier != PM_NO_PRIMITIVE && selection->is_chosen[modifier];
}

static void add_number(pm_hasher *hasher, uint32_t number)
{
    uint8_t bytes[4];
    for (int i = 0; i < 4; i++)
        bytes[i] = (uint8_t)(number >> 8 * i);
    pm_hasher_add(hasher, bytes, sizeof bytes);
}

/* What is chosen of a body: the numbers of its own surfaces, then each instance's choice. Equal
 * worlds number their surfaces and instances alike. Those of bodies placed within are known. */
static pm_digest digest_body(const pm_selection *selection, const pm_world *world,
                             const struct pm_body *body, const pm_digest *known,
                             pm_hasher *hasher)
{
    for (uint32_t i = 0; i < body->own_count; i++)
        if (has_own(selection, body, i))
            add_number(hasher, i);
    for (uint32_t i = 0; i < body->instance_count; i++) {
        const struct pm_instance *instance = &body->instances[i];
        bool replaced = instance->material != PM_NO_PRIMITIVE;
        add_number(hasher, PM_NO_PRIMITIVE);
        if (replaced)
            add_number(hasher, selection->is_chosen[instance->modifier]);
        else
            pm_hasher_add(hasher, known[instance->body - world->bodies].bytes,
                          sizeof known->bytes);
    }
    return pm_hasher_finish(hasher);
}

static pm_status make_digest(pm_selection *selection, const pm_world *world, pm_error *err)
{
    pm_digest *known = calloc(world->body_count, sizeof *known);
    pm_hasher *hasher = pm_hasher_new();
    bool complete = known && hasher;
    for (size_t i = 0; complete && i < world->body_count; i++)
        known[i] = digest_body(selection, world, &world->bodies[i], known, hasher);
    if (complete)
        selection->digest = known[world->body_count - 1];
    pm_hasher_free(hasher);
    free(known);
    return complete ? PM_OK
                    : pm_error_set(err, PM_E_MEMORY, "no memory for a choice of surfaces");
}

/* ---- selections ---- */

pm_status pm_selection_make(const pm_world *world, const char *const *names, size_t count,
                            const char *option, pm_selection *out, pm_error *err)
{
    *out = (pm_selection){.any = count > 0};
    if (!count)
        return PM_OK;
    out->is_chosen = calloc(world->modifiers.count + 1, sizeof *out->is_chosen);
    pm_status st = out->is_chosen
                       ? PM_OK
                       : pm_error_set(err, PM_E_MEMORY, "no memory for a choice of surfaces");
    for (size_t i = 0; i < count && !st; i++)
        st = choose(world, names[i], option, out, err);
    if (!st)
        st = make_digest(out, world, err);
    if (st)
        pm_selection_clear(out);
    return st;
}

void pm_selection_clear(pm_selection *selection)
{
    free(selection->is_chosen);
    *selection = (pm_selection){0};
}

/* ---- lists ---- */

struct listing {
    const pm_selection *selection;
    const pm_world *world;
    size_t *totals; /* [body_count] of surfaces that are chosen in each body */
    uint32_t *surfaces;
    size_t count;
};

static size_t total_in(const struct listing *l, const struct pm_instance *instance)
{
    if (instance->material == PM_NO_PRIMITIVE)
        return l->totals[instance->body - l->world->bodies];
    return l->selection->is_chosen[instance->modifier] ? instance->body->count : 0;
}

/* Each body lies behind those that it places. */
static void count_chosen(struct listing *l)
{
    for (size_t b = 0; b < l->world->body_count; b++) {
        const struct pm_body *body = &l->world->bodies[b];
        for (uint32_t i = 0; i < body->own_count; i++)
            l->totals[b] += has_own(l->selection, body, i);
        for (uint32_t i = 0; i < body->instance_count; i++)
            l->totals[b] += total_in(l, &body->instances[i]);
    }
}

/* Recursion is bounded by PM_INSTANCE_DEPTH. */
static void list_body(struct listing *l, const struct pm_body *body, uint32_t base, bool all)
{
    for (uint32_t i = 0; i < body->own_count; i++)
        if (all || has_own(l->selection, body, i))
            l->surfaces[l->count++] = base + i;
    for (uint32_t i = 0; i < body->instance_count; i++) {
        const struct pm_instance *instance = &body->instances[i];
        if (all || total_in(l, instance))
            list_body(l, instance->body, base + instance->first,
                      all || instance->material != PM_NO_PRIMITIVE);
    }
}

pm_status pm_selection_list(const pm_selection *selection, const pm_world *world, size_t most,
                            uint32_t **surfaces, size_t *count, pm_error *err)
{
    struct listing l = {.selection = selection, .world = world};
    *surfaces = NULL;
    *count = 0;
    if (!selection->any)
        return PM_OK;
    l.totals = calloc(world->body_count, sizeof *l.totals);
    size_t total = 0;
    if (l.totals) {
        count_chosen(&l);
        total = l.totals[world->body_count - 1];
    }
    if (total <= most)
        l.surfaces = malloc((total + 1) * sizeof *l.surfaces);
    bool complete = l.totals && l.surfaces;
    if (complete)
        list_body(&l, world->main, 0, false);
    free(l.totals);
    if (total > most)
        return pm_error_set(err, PM_E_LIMIT,
                            "an option chooses %zu surfaces; at most %zu can be", total, most);
    if (!complete) {
        free(l.surfaces);
        return pm_error_set(err, PM_E_MEMORY, "no memory for a choice of surfaces");
    }
    *surfaces = l.surfaces;
    *count = l.count;
    return PM_OK;
}

bool pm_selection_has(const pm_selection *selection, const pm_world *world, uint32_t surface)
{
    if (!selection->any)
        return false;
    if (surface < world->shape_count)
        return selection->is_chosen[world->shapes[surface].modifier];
    struct pm_place place;
    pm_place_find(world->main, surface, &place);
    return place.material == PM_NO_PRIMITIVE ? has_own(selection, place.body, place.local)
                                             : selection->is_chosen[place.modifier];
}

/* ---- what surfaces are called ---- */

static pm_surface_names names_of(const pm_world *world, uint32_t modifier, uint32_t primitive)
{
    if (modifier == PM_NO_PRIMITIVE)
        return (pm_surface_names){"void", "void", primitive};
    const struct pm_modifier_chain *chain = &world->modifiers.chains[modifier];
    const char *material = chain->length ? chain->names[chain->material] : "void";
    return (pm_surface_names){chain->name, material, primitive};
}

pm_surface_names pm_world_surface_names(const pm_world *world, uint32_t surface)
{
    struct pm_place place;
    pm_place_find(world->main, surface, &place);
    const struct pm_instance *innermost = place.depth ? place.chain[place.depth - 1] : NULL;
    if (place.material != PM_NO_PRIMITIVE) {
        int i = 0;
        while (place.chain[i]->material == PM_NO_PRIMITIVE)
            i++;
        return names_of(world, place.modifier, place.chain[i]->primitive);
    }
    if (place.body->mesh.mesh)
        return names_of(world, pm_mesh_body_modifier(&place.body->mesh, place.local),
                        innermost->primitive);
    const struct pm_shape *shape = &place.body->shapes[place.local];
    return names_of(world, shape->modifier, shape->primitive);
}
