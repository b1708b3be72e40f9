#include "backward/backward_internal.h"

void pm_queue_start(struct pm_queue *queue, size_t values)
{
    queue->count = 0;
    for (size_t i = 0; i < values; i++)
        queue->values[i] = (struct pm_value){.radiance = {0, 0, 0}};
}

void pm_queue_add(const struct pm_pass *pass, struct pm_queue *queue,
                  const struct pm_waiting *waiting, uint32_t slot)
{
    if (queue->count == PM_QUEUE_MAX)
        pm_queue_finish(pass, queue);
    const struct pm_spot *spot = &waiting->spot;
    queue->waiting[queue->count] = *waiting;
    /* the surface will be gone by then */
    queue->waiting[queue->count].spot =
        (struct pm_spot){.point = spot->point, .from = spot->from};
    queue->slot[queue->count++] = slot;
}

/* One kind of question: those that may share a batch. */
struct kind {
    const struct pm_lookup *lookup;
    bool far;
};

static size_t put_queries(const struct pm_queue *queue, struct kind kind,
                          pm_photon_query queries[PM_QUEUE_MAX], uint32_t place[PM_QUEUE_MAX])
{
    size_t count = 0;
    for (size_t i = 0; i < queue->count; i++) {
        const struct pm_waiting *w = &queue->waiting[i];
        if (w->lookup != kind.lookup || w->far != kind.far)
            continue;
        queries[count] = (pm_photon_query){
            .point = w->spot.point,
            .normal = w->normal,
            .radius = kind.lookup->radius > 0 && !kind.lookup->precomputed ? kind.lookup->radius
                                                                           : INFINITY,
        };
        place[count++] = (uint32_t)i;
    }
    return count;
}

static void answer(const struct pm_pass *pass, const struct pm_queue *queue, struct kind kind,
                   pm_estimate answers[PM_QUEUE_MAX])
{
    const struct pm_lookup *lookup = kind.lookup;
    pm_photon_query queries[PM_QUEUE_MAX];
    pm_estimate estimates[PM_QUEUE_MAX];
    uint32_t place[PM_QUEUE_MAX];
    size_t index[PM_QUEUE_MAX];
    size_t count = put_queries(queue, kind, queries, place);
    if (!count)
        return;
    if (lookup->precomputed)
        pm_photon_map_closest_batch(lookup->map, queries, count, index);
    else if (lookup->radius > 0)
        pm_photon_map_within_batch(lookup->map, queries, count, lookup->filter, estimates);
    else
        pm_photon_map_nearest_batch(lookup->map, queries, count, lookup->gather_count,
                                    lookup->filter, estimates);
    for (size_t i = 0; i < count; i++)
        answers[place[i]] = lookup->precomputed
                                ? pm_lookup_closest(pass, &queue->waiting[place[i]], index[i])
                                : estimates[i];
}

void pm_queue_finish(const struct pm_pass *pass, struct pm_queue *queue)
{
    pm_estimate answers[PM_QUEUE_MAX];
    for (int v = 0; v < PM_VERTEX_KINDS; v++)
        for (int i = 0; i < pass->rules[v].lookup_count; i++)
            for (int far = 0; far < 2; far++)
                answer(pass, queue, (struct kind){&pass->rules[v].lookups[i], far}, answers);
    for (size_t i = 0; i < queue->count; i++)
        pm_lookup_add(pass, &queue->waiting[i], &answers[i], &queue->values[queue->slot[i]]);
    queue->count = 0;
}
