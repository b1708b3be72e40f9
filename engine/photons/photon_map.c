#include "photons/photon_map.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "photons/map_internal.h"

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

enum { SUM_PIECE = 65536 };

struct piece {
    pm_rgb flux;
    int exponent; /* greatest */
};

struct sum {
    const pm_photon_list *list;
    struct piece *pieces;
};

/* Summed piece by piece, so that the threads do not change it. */
static void sum_piece(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    const struct sum *s = context;
    size_t first = piece * SUM_PIECE, end = first + SUM_PIECE;
    struct piece sum = {{0, 0, 0}, 0};
    for (size_t i = first; i < end && i < s->list->count; i++) {
        const pm_photon *photon = &s->list->photons[i];
        sum.flux = pm_rgb_add(sum.flux, pm_photon_flux(photon));
        sum.exponent = photon->exponent > sum.exponent ? photon->exponent : sum.exponent;
    }
    s->pieces[piece] = sum;
}

static pm_status sum_flux(const pm_photon_list *list, pm_pool *pool, pm_photon_map *map)
{
    enum { EXPONENT_BIAS = 200 };
    size_t pieces = list->count / SUM_PIECE + 1;
    struct sum s = {list, calloc(pieces, sizeof *s.pieces)};
    if (!s.pieces)
        return PM_E_MEMORY;
    pm_photons_run(pool, pieces, sum_piece, &s);
    for (size_t i = 0; i < pieces; i++) {
        int exponent = s.pieces[i].exponent;
        map->flux_sum = pm_rgb_add(map->flux_sum, s.pieces[i].flux);
        map->exponent = exponent > map->exponent ? exponent : map->exponent;
    }
    map->flux_unit = ldexp(1, map->exponent - EXPONENT_BIAS);
    free(s.pieces);
    return PM_OK;
}

/* The list's memory becomes the blocks, the last one filled up with zeros. */
static void make_all_blocks(pm_photon_map *map, pm_photon_list *list, pm_pool *pool)
{
    map->count = list->count;
    map->block_count = (list->count + PM_BLOCK_SIZE - 1) / PM_BLOCK_SIZE;
    if (list->count % PM_BLOCK_SIZE)
        memset(list->photons + list->count, 0,
               (map->block_count * PM_BLOCK_SIZE - list->count) * sizeof *list->photons);
    map->blocks = (pm_photon_block *)(void *)list->photons;
    *list = (pm_photon_list){0};
    pm_photons_run(pool, (map->block_count + PIECE - 1) / PIECE, make_blocks, map);
}

pm_status pm_photon_map_wrap(const pm_map_header *header, pm_photon_list *list, pm_pool *pool,
                             pm_photon_map **out, pm_error *err)
{
    pm_photon_map *map = calloc(1, sizeof *map);
    if (!map || sum_flux(list, pool, map)) {
        free(map);
        pm_photon_list_clear(list);
        return pm_error_set(err, PM_E_MEMORY, "no memory for a photon map");
    }
    map->header = *header;
    map->kernel = pm_kernel_best();
    make_all_blocks(map, list, pool);
    pm_status st = pm_nodes_build(map, pool, err);
    if (st) {
        pm_photon_map_free(map);
        return st;
    }
    *out = map;
    return PM_OK;
}

pm_status pm_photon_map_take(const pm_map_header *header, pm_photon_list *list, pm_pool *pool,
                             pm_photon_map **out, pm_error *err)
{
    pm_photons_sort(list->photons, list->count, pool);
    return pm_photon_map_wrap(header, list, pool, out, err);
}

pm_status pm_photon_map_build(const pm_map_header *header, const pm_batch *batches,
                              size_t count, pm_pool *pool, pm_photon_map **out, pm_error *err)
{
    pm_photon_list list = {0};
    uint64_t total = 0;
    for (size_t b = 0; b < count; b++) {
        assert(batches[b].kind == header->kind);
        total += batches[b].count;
    }
    pm_status st = pm_photon_list_reserve(&list, total, err);
    for (size_t b = 0; b < count && !st; b++)
        st = pm_photon_list_append(&list, batches[b].photons, batches[b].count, err);
    if (!st)
        return pm_photon_map_take(header, &list, pool, out, err);
    pm_photon_list_clear(&list);
    return st;
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
    double scale = map->header.flux_scale / (double)map->count;
    if (map->header.kind != PM_MAP_PRECOMPUTED)
        scale *= map->header.world_scale * map->header.world_scale / (double)map->header.paths;
    return pm_rgb_scale(map->flux_sum, scale);
}
