#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "photons/map_internal.h"

/* Photons in the order in which they come. */

/* Large pages: sorting jumps about, and small ones are missed far more often. */
static void ask_for_large_pages(void *room, size_t size)
{
    enum { PAGE = 4096, WORTH_IT = 16 << 20 };
    uintptr_t first = ((uintptr_t)room + PAGE - 1) / PAGE * PAGE;
    uintptr_t end = ((uintptr_t)room + size) / PAGE * PAGE;
    if (size >= WORTH_IT)
        (void)madvise((void *)first, end - first, MADV_HUGEPAGE); /* or small ones */
}

static pm_photon *room_for(size_t blocks)
{
    size_t size = blocks * sizeof(pm_photon_block);
    void *room = aligned_alloc(64, size);
    if (room)
        ask_for_large_pages(room, size);
    return room;
}

pm_status pm_photon_list_reserve(pm_photon_list *list, uint64_t count, pm_error *err)
{
    if (count > PM_MAP_PHOTONS_MAX)
        return pm_error_set(err, PM_E_LIMIT, "more than %u photons in one map",
                            PM_MAP_PHOTONS_MAX);
    if (count <= list->capacity && list->photons)
        return PM_OK;
    size_t blocks = (size_t)(count + PM_BLOCK_SIZE - 1) / PM_BLOCK_SIZE;
    pm_photon *photons = room_for(blocks ? blocks : 1);
    if (!photons)
        return pm_error_set(err, PM_E_MEMORY,
                            "no memory for %llu photons: they take %.3g GB; ask for fewer",
                            (unsigned long long)count, 1e-9 * 24 * (double)count);
    if (list->count)
        memcpy(photons, list->photons, list->count * sizeof *photons);
    free(list->photons);
    list->photons = photons;
    list->capacity = (blocks ? blocks : 1) * PM_BLOCK_SIZE;
    return PM_OK;
}

pm_status pm_photon_list_append(pm_photon_list *list, const pm_photon *photons, size_t count,
                                pm_error *err)
{
    uint64_t wanted = (uint64_t)list->count + count;
    if (wanted > list->capacity || !list->photons) {
        uint64_t room = wanted < 2 * (uint64_t)list->capacity ? 2 * list->capacity : wanted;
        if (room > PM_MAP_PHOTONS_MAX && wanted <= PM_MAP_PHOTONS_MAX)
            room = PM_MAP_PHOTONS_MAX;
        pm_status st = pm_photon_list_reserve(list, room, err);
        if (st)
            return st;
    }
    if (count)
        memcpy(list->photons + list->count, photons, count * sizeof *photons);
    list->count += count;
    return PM_OK;
}

void pm_photon_list_clear(pm_photon_list *list)
{
    free(list->photons);
    *list = (pm_photon_list){0};
}
