#include <math.h>

#include "photons/search.h"

/* Sums over photons. */

static void add_weighted(const pm_photon_map *map, size_t i, const pm_photon_weight *weight,
                         pm_flux_sum *out)
{
    pm_photon photon;
    pm_photon_map_photon(map, i, &photon);
    pm_rgb v = pm_photon_flux(&photon);
    if (weight)
        v = pm_rgb_mul(v, weight->of(weight->context, &photon));
    out->sum = pm_rgb_add(out->sum, v);
    out->square = pm_rgb_add(out->square, pm_rgb_mul(v, v));
    out->count++;
}

void pm_sum_begin(pm_running_sum *sum, const pm_photon_weight *weight)
{
    sum->plain.begun = false; /* part need not be cleared */
    sum->plain.blocks = sum->plain.count = 0;
    for (int i = 0; i < 6; i++)
        sum->plain.total[i] = 0;
    sum->others = (pm_flux_sum){.count = 0};
    sum->weight = weight;
}

void pm_sum_list(pm_running_sum *sum, pm_search *s, const pm_list *list)
{
    if (!sum->weight) {
        s->map->kernel->sum(list, s, &sum->plain);
        return;
    }
    pm_found found[PM_LIST_MAX];
    size_t count = s->map->kernel->find(list, s, found);
    for (size_t i = 0; i < count; i++)
        for (unsigned lanes = found[i].lanes; lanes; lanes &= lanes - 1)
            add_weighted(
                s->map, (size_t)found[i].block * PM_BLOCK_SIZE + (unsigned)__builtin_ctz(lanes),
                sum->weight, &sum->others);
}

uint32_t pm_sum_ties(pm_running_sum *sum, pm_search *s, const pm_list *list, uint32_t missing)
{
    pm_found found[PM_LIST_MAX];
    size_t count = s->map->kernel->find(list, s, found);
    for (size_t i = 0; i < count; i++)
        for (unsigned lanes = found[i].lanes; lanes && missing; lanes &= lanes - 1) {
            unsigned lane = (unsigned)__builtin_ctz(lanes);
            if (found[i].distance2[lane] < (float)s->bound)
                continue;
            add_weighted(s->map, (size_t)found[i].block * PM_BLOCK_SIZE + lane, sum->weight,
                         &sum->others);
            missing--;
        }
    return missing;
}

pm_flux_sum pm_sum_end(pm_running_sum *sum, const pm_photon_map *map)
{
    const double *t = sum->plain.total;
    double unit = map->flux_unit;
    pm_flux_sum out = sum->others;
    pm_rgb plain = pm_rgb_scale((pm_rgb){t[0], t[1], t[2]}, unit);
    pm_rgb square = pm_rgb_scale((pm_rgb){t[3], t[4], t[5]}, unit * unit);
    out.sum = pm_rgb_add(out.sum, plain);
    out.square = pm_rgb_add(out.square, square);
    out.count += sum->plain.count;
    return out;
}

/* ---- at many points ---- */

/* A group on its way. */
struct stage {
    pm_group group;
    bool listed;
    const pm_photon_weight *const *weights;
    pm_flux_sum *out;
    pm_list list;
};

static void take_sums(void *context, pm_group *group, pm_list *list)
{
    pm_running_sum *sums = context;
    for (size_t i = 0; i < group->count; i++)
        pm_sum_list(&sums[i], &group->searches[i], list);
}

static void finish_stage(struct stage *stage)
{
    pm_running_sum sums[PM_GROUP_MAX];
    pm_group *group = &stage->group;
    const pm_photon_map *map = group->searches[0].map;
    for (size_t i = 0; i < group->count; i++)
        pm_sum_begin(&sums[i], stage->weights[i]);
    if (stage->listed) {
        map->kernel->prepare(group, &stage->list);
        take_sums(sums, group, &stage->list);
    } else {
        pm_group_walk(group, &stage->list, take_sums, sums);
    }
    for (size_t i = 0; i < group->count; i++)
        stage->out[i] = pm_sum_end(&sums[i], map);
}

/* A group's blocks come from memory while the sums of the group before are made. */
void pm_sum_within(pm_search *searches, size_t count, const pm_photon_weight *const *weights,
                   pm_flux_sum *out)
{
    struct stage stages[2], *before = NULL;
    for (size_t i = 0; i < count;) {
        struct stage *stage = before == &stages[0] ? &stages[1] : &stages[0];
        stage->group = pm_group_make(searches + i, count - i, PM_SPREAD);
        stage->weights = weights + i;
        stage->out = out + i;
        stage->listed = pm_group_list(&stage->group, &stage->list);
        if (before)
            finish_stage(before);
        before = stage;
        i += stage->group.count;
    }
    if (before)
        finish_stage(before);
}
