#ifndef PM_WORLD_MODIFIER_NAMES_H
#define PM_WORLD_MODIFIER_NAMES_H

#include "world/world_internal.h"

/* Collects the distinct modifiers of surfaces while a world is compiled. */
struct pm_modifier_collector {
    const pm_scene *scene;
    struct pm_modifier_key {
        int32_t modifier;
        const char *name;
    } * keys; /* [capacity], in the table's order */
    size_t count, capacity;
    uint32_t *slots; /* hash table over the keys: index + 1, or 0 */
    size_t slot_count;
};

/* The number of a modifier that a surface names so; PM_NO_PRIMITIVE if memory is short. */
uint32_t pm_modifier_number(struct pm_modifier_collector *collector, int32_t modifier,
                            const char *name);

/* Copies what was collected into the world. */
PM_MUST_USE pm_status pm_modifier_names_keep(const struct pm_modifier_collector *collector,
                                             pm_world *world, pm_error *err);
void pm_modifier_collector_clear(struct pm_modifier_collector *collector);

#endif
