#include "photons/photon_map.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "photons/map_internal.h"

pm_photon *pm_photons_alloc(size_t count)
{
    size_t blocks = (count + PM_BLOCK_SIZE - 1) / PM_BLOCK_SIZE;
    if (!blocks)
        blocks = 1;
    pm_photon *photons = aligned_alloc(64, blocks * sizeof(pm_photon_block));
    if (photons)
        memset(photons + count, 0, (blocks * PM_BLOCK_SIZE - count) * sizeof *photons);
    return photons;
}

/* ---- photons to blocks, in place ---- */

enum { PIECE = 1024 }; /* blocks */

static void make_block(pm_photon_block *block)
{
    pm_photon photons[PM_BLOCK_SIZE];
    memcpy(photons, block, sizeof photons);
    for (unsigned i = 0; i < PM_BLOCK_SIZE; i++) {
        const pm_photon *p = &photons[i];
        for (int a = 0; a < 3; a++)
            block->position[a][i] = (int32_t)(p->position[a] ^ 0x80000000U);
        block->flux[i] = p->flux;
        block->normal[i] = (uint16_t)(p->normal[0] | p->normal[1] << 8);
        block->direction[0][i] = p->direction[0];
        block->direction[1][i] = p->direction[1];
        block->exponent[i] = p->exponent;
        block->flags[i] = p->flags;
    }
}

static void make_blocks(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    pm_photon_map *map = context;
    for (size_t i = piece * PIECE; i < (piece + 1) * PIECE && i < map->block_count; i++)
        make_block(&map->blocks[i]);
}

void pm_photon_map_photon(const pm_photon_map *map, size_t i, pm_photon *out)
{
    assert(i < map->count);
    const pm_photon_block *block = &map->blocks[i / PM_BLOCK_SIZE];
    unsigned k = i % PM_BLOCK_SIZE;
    for (int a = 0; a < 3; a++)
        out->position[a] = (uint32_t)block->position[a][k] ^ 0x80000000U;
    out->flux = block->flux[k];
    out->normal[0] = (uint8_t)block->normal[k];
    out->normal[1] = (uint8_t)(block->normal[k] >> 8);
    out->direction[0] = block->direction[0][k];
    out->direction[1] = block->direction[1][k];
    out->exponent = block->exponent[k];
    out->flags = block->flags[k];
}

/* ---- building ---- */

static pm_rgb sum_flux(const pm_photon *photons, size_t count)
{
    pm_rgb sum = {0, 0, 0};
    for (size_t i = 0; i < count; i++)
        sum = pm_rgb_add(sum, pm_photon_flux(&photons[i]));
    return sum;
}

pm_status pm_photon_map_take(const pm_map_header *header, pm_photon *photons, size_t count,
                             pm_pool *pool, pm_photon_map **out, pm_error *err)
{
    pm_photon_map *map = calloc(1, sizeof *map);
    if (!map) {
        free(photons);
        return pm_error_set(err, PM_E_MEMORY, "no memory for a photon map");
    }
    map->header = *header;
    map->count = count;
    map->flux_sum = sum_flux(photons, count);
    map->block_count = (count + PM_BLOCK_SIZE - 1) / PM_BLOCK_SIZE;
    map->blocks = (pm_photon_block *)(void *)photons;
    pm_photons_run(pool, (map->block_count + PIECE - 1) / PIECE, make_blocks, map);
    pm_status st = pm_nodes_build(map, pool, err);
    if (st) {
        pm_photon_map_free(map);
        return st;
    }
    *out = map;
    return PM_OK;
}

pm_status pm_photon_map_build(const pm_map_header *header, const pm_batch *batches,
                              size_t count, pm_pool *pool, pm_photon_map **out, pm_error *err)
{
    pm_photon *photons;
    size_t total;
    for (size_t b = 0; b < count; b++)
        assert(batches[b].kind == header->kind);
    pm_status st = pm_photons_sort(batches, count, pool, &photons, &total, err);
    return st ? st : pm_photon_map_take(header, photons, total, pool, out, err);
}

void pm_photon_map_free(pm_photon_map *map)
{
    if (!map)
        return;
    free(map->blocks);
    free(map->nodes);
    free(map->first_code);
    free(map);
}

const pm_map_header *pm_photon_map_header(const pm_photon_map *map)
{
    return &map->header;
}

size_t pm_photon_map_count(const pm_photon_map *map)
{
    return map->count;
}

size_t pm_photon_map_bytes(const pm_photon_map *map)
{
    return sizeof *map + map->block_count * sizeof *map->blocks +
           map->node_count * sizeof *map->nodes + map->level_start[1] * sizeof *map->first_code;
}

pm_rgb pm_photon_map_mean_flux(const pm_photon_map *map)
{
    if (!map->count)
        return (pm_rgb){0, 0, 0};
    double area = map->header.world_scale * map->header.world_scale;
    double scale =
        map->header.flux_scale * area / (double)map->header.paths / (double)map->count;
    return pm_rgb_scale(map->flux_sum, scale);
}
