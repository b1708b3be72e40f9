#ifndef PM_PHOTONS_MAP_INTERNAL_H
#define PM_PHOTONS_MAP_INTERNAL_H

#include "photons/photon_map.h"

/* What the files of this stage share.
 *
 * Photons lie in blocks of 16 along the Morton curve, each field of a block in an array of its
 * own, so that one block is tested with a few vector instructions. Above them stands a tree
 * that needs no pointers: node i of level l has the children 16 i .. 16 i + 15 of level l - 1,
 * those of level 0 are blocks. A node holds its children's boxes in 8 bits a coordinate
 * relative to its own box, and what kinds of photons they hold. Together 24 + 0.88 bytes a
 * photon.
 *
 * Lengths in here are grid units: 2^-31 of a world unit, so positions are signed 32-bit
 * integers. */

enum {
    PM_BLOCK_SIZE = 16,
    PM_NODE_CHILDREN = 16,
    PM_NODE_LEVELS = 7,  /* 16 * 16^7 photons exceed PM_MAP_PHOTONS_MAX */
    PM_NODE_STEPS = 256, /* of a coordinate in a node's box */
};

#define PM_GRID_PER_WORLD 0x1p31

typedef struct pm_photon_block {
    int32_t position[3][PM_BLOCK_SIZE];
    uint32_t flux[PM_BLOCK_SIZE];
    uint16_t normal[PM_BLOCK_SIZE]; /* normal[0] in the low byte */
    uint16_t direction[2][PM_BLOCK_SIZE];
    uint8_t exponent[PM_BLOCK_SIZE];
    uint8_t flags[PM_BLOCK_SIZE];
} pm_photon_block;

_Static_assert(sizeof(pm_photon_block) == PM_BLOCK_SIZE * sizeof(pm_photon),
               "a block takes what its photons take");

/* What photons there are, as bits: 0 .. 26 say whether some have a normal near one of 26
 * directions (see pm_content_sector). */
enum pm_content {
    PM_CONTENT_PLAIN = 27,    /* photons whose last event was not specular */
    PM_CONTENT_SPECULAR = 28, /* those whose last event was */
    PM_CONTENT_ANY = 29,
    PM_CONTENTS = 30,
};

enum { PM_NORMAL_MIXED = 0xFFFF }; /* no normal has this code */

/* Child c reaches from low to high + 1 steps above the origin. */
typedef struct pm_node {
    int32_t origin[3];
    float steps_per_unit; /* 2^-k */
    uint8_t low[3][PM_NODE_CHILDREN];
    uint8_t high[3][PM_NODE_CHILDREN];
    uint16_t holds[PM_CONTENTS];       /* bit c: child c has such photons */
    uint16_t normal[PM_NODE_CHILDREN]; /* of all photons of the child, or PM_NORMAL_MIXED */
} pm_node;

typedef struct pm_kernel pm_kernel; /* search.h */

struct pm_photon_map {
    pm_map_header header;
    size_t count, block_count;
    pm_photon_block *blocks; /* the last one is filled up with zeros */
    pm_node *nodes;          /* all levels, level 0 first */
    size_t node_count, level_start[PM_NODE_LEVELS + 1];
    uint64_t
        *first_code;  /* of each node of level 0: pm_photon_upper_code of its first photon */
    int levels;       /* 0 of an empty map */
    pm_rgb flux_sum;  /* of the packed fluxes */
    int exponent;     /* greatest of the packed fluxes */
    double flux_unit; /* that it stands for */
    const pm_kernel *kernel;
};

/* The order of stored photons: Morton code of the positions (x the most significant of each
 * triple of bits), then the bytes. As qsort wants it. */
int pm_photon_order(const void *a, const void *b);

/* The upper 63 bits of the Morton code of a position. */
uint64_t pm_photon_upper_code(const uint32_t position[3]);

/* Brings photons into stored order, in place. */
void pm_photons_sort(pm_photon *photons, size_t count, pm_pool *pool);

/* Runs pieces of work on the pool, or here without one. */
void pm_photons_run(pm_pool *pool, size_t count, void (*work)(void *, size_t, unsigned),
                    void *context);

/* Makes the tree over finished blocks. */
PM_MUST_USE pm_status pm_nodes_build(pm_photon_map *map, pm_pool *pool, pm_error *err);

/* The fastest search of this machine; all give the same bytes. */
const pm_kernel *pm_kernel_best(void);

/* The content that every photon with a normal within 60 degrees of `normal` has. */
unsigned pm_content_sector(pm_vec3 normal);

/* All sector bits that a photon with this normal sets. */
uint32_t pm_content_of_normal(pm_vec3 normal);

/* As pm_photon_map_take, of photons that are in stored order. */
PM_MUST_USE pm_status pm_photon_map_wrap(const pm_map_header *header, pm_photon_list *list,
                                         pm_pool *pool, pm_photon_map **out, pm_error *err);

#endif
