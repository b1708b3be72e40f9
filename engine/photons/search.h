#ifndef PM_PHOTONS_SEARCH_H
#define PM_PHOTONS_SEARCH_H

#include <math.h>
#include <string.h>

#include "photons/map_internal.h"

/* Finding the photons around points, in stored order.
 *
 * Reading order: search.c (a group of neighbouring points walks the tree once and lists the
 * blocks near any of them) -> kernel.h (a list's photons against each point, 16 at a time) ->
 * within.c, nearest.c (what is asked of them) -> density.c (estimates). */

/* Which photons belong to the surface asked, as photon_map.h says. */
#define PM_NORMAL_COSINE 0.5F
#define PM_TANGENT_SLOPE 0.25F
#define PM_TANGENT_SLACK                                                                       \
    2.0F /* [grid units]; points and stored positions are off by half a unit an axis           \
          */

/* A point and what is sought there. */
typedef struct pm_search {
    const pm_photon_map *map;
    int64_t point[3]; /* grid units, within 2^60 */
    float normal[3];
    int axis;     /* a + 1 or -a - 1: the normal is this axis of the world; else 0 */
    bool surface; /* test normals and tangent plane */
    bool careful; /* and leave out nodes off the plane: dear, but saves walking through them */
    pm_photon_filter filter;
    unsigned content[2];   /* which pm_contents a node must hold to be entered */
    double bound;          /* greatest squared distance, inclusive [grid units^2] */
    float reach;           /* its root, and what distances are rounded by */
    uint32_t known_normal; /* code of the last block with a single normal, or none */
    bool known_accepted;
    float known_mean[3]; /* of it and the search's own */
    float offset[3];     /* of the point from the origin of its group's list */
} pm_search;

pm_search pm_search_surface(const pm_photon_map *map, pm_vec3 point, pm_vec3 normal,
                            pm_photon_filter filter);
pm_search pm_search_volume(const pm_photon_map *map, pm_vec3 point);
/* The same as another, at another point. */
pm_search pm_search_beside(const pm_search *search, pm_vec3 point);

static inline void pm_search_set_bound(pm_search *search, double bound)
{
    search->bound = bound;
    search->reach = sqrtf((float)bound) * (1 + 0x1p-20F) + 1;
}

/* Greatest squared distance of a radius [world units]. */
double pm_search_bound(double radius);

/* ---- groups ---- */

enum {
    PM_GROUP_MAX = 16,
    PM_LIST_MAX = 128, /* blocks */
};

/* Neighbouring points that seek the same kinds of photons. */
typedef struct pm_group {
    pm_search *searches;
    size_t count;
    double low[3], high[3];             /* of all balls [grid units] */
    double point_low[3], point_high[3]; /* of the points */
    double least_radius;
    int axis;    /* of all normals, as of a search */
    bool fluxes; /* are wanted */
} pm_group;

/* Grid units a step, a power of two. */
static inline float pm_node_step(const pm_node *node)
{
    uint32_t bits;
    memcpy(&bits, &node->steps_per_unit, sizeof bits);
    bits = (2 * 127U << 23) - bits;
    float step;
    memcpy(&step, &bits, sizeof step);
    return step;
}

/* Takes as many of the searches as are worth walking together, at least the first: the group's
 * box may be wider than one search's by `spread` radii. */
pm_group pm_group_make(pm_search *searches, size_t count, double spread);

/* Measured; only speed depends on them. What is looked for in smaller balls is walked to
 * farther, for what is found. */
#define PM_SPREAD         6.0
#define PM_SPREAD_CLOSEST 16.0

/* What is to be tested of a block's photons. */
enum pm_test {
    PM_TEST_ALL,
    PM_TEST_DISTANCE, /* as all pass the rest */
    PM_TEST_FLAT,     /* the distance along the plane, of the lanes that are there */
};

/* A block made ready for many searches. */
typedef struct pm_ready {
    _Alignas(64) float flux[3][PM_BLOCK_SIZE]; /* in units of the map's greatest exponent */
    int32_t along[2][PM_BLOCK_SIZE];           /* positions in the plane, for PM_TEST_FLAT */
    const pm_photon_block *block;
    uint32_t index;
    uint16_t there; /* lanes with a photon that the filter takes */
    uint16_t code;  /* of all normals, or PM_NORMAL_MIXED */
    bool wide;      /* differences of positions may not fit 32 bits */
    enum pm_test test;
    int axis; /* as of a search; all photons lie in one plane across it, at: */
    int32_t plane;
} pm_ready;

typedef struct pm_normals {
    _Alignas(64) float axis[3][PM_BLOCK_SIZE]; /* [][0] alone if all are the same */
} pm_normals;

/* Blocks in stored order. */
typedef struct pm_list {
    size_t count;
    bool last; /* no other list follows */
    int plane; /* all points lie in one plane across this axis, as of a search; or 0 */
    /* their boxes, from the first point of the group; with room for a vector more */
    _Alignas(64) float low[3][PM_LIST_MAX + PM_BLOCK_SIZE];
    float high[3][PM_LIST_MAX + PM_BLOCK_SIZE];
    pm_ready ready[PM_LIST_MAX];
    pm_normals normals[PM_LIST_MAX];
} pm_list;

/* Called with lists that together hold all blocks that may hold photons within the bounds; the
 * last one may be empty. It may lower the bounds. */
typedef void pm_take_list(void *context, pm_group *group, pm_list *list);

void pm_group_walk(pm_group *group, pm_list *list, pm_take_list *take, void *context);

/* Lists all such blocks in one list, not made ready yet but on their way from memory; false,
 * with nothing of use in it, if one list does not hold them. */
PM_MUST_USE bool pm_group_list(pm_group *group, pm_list *list);

/* ---- kernels: the same functions for several instruction sets ---- */

/* Sums under way: 16 lanes of floats, handed to doubles after every 64 blocks with photons
 * found. What is in which lane and when it is handed over depends only on the photons found. */
typedef struct pm_sums {
    _Alignas(64) float part[6][PM_BLOCK_SIZE];
    bool begun;      /* part holds something */
    uint32_t blocks; /* in part */
    uint32_t count;  /* photons */
    double total[6];
} pm_sums;

/* A block with photons found, and their squared distances. */
typedef struct pm_found {
    _Alignas(64) float distance2[PM_BLOCK_SIZE];
    uint32_t block, lanes;
} pm_found;

/* The nearest photon of each lane. */
typedef struct pm_closest {
    _Alignas(64) float distance2[PM_BLOCK_SIZE]; /* INFINITY: none */
    float index[PM_BLOCK_SIZE];                  /* bits of the block's number */
} pm_closest;

/* What a node says of its neighbourhood, from those children that match a search. */
typedef struct pm_hint {
    float distance2; /* to the nearest [steps^2] */
    float density;   /* children per step^2 or ^3; 0 if none matches */
} pm_hint;

struct pm_kernel {
    const char *name;
    /* Puts the boxes of some children behind those of the list, and changes nothing else. */
    void (*list_boxes)(const pm_node *node, unsigned mask, const int64_t origin[3],
                       pm_list *list);
    void (*prepare)(const pm_group *group, pm_list *list);
    void (*sum)(const pm_list *list, pm_search *search, pm_sums *sums);
    /* Appends squared distances: up to list->count * 16, and writes 16 more. */
    size_t (*collect)(const pm_list *list, pm_search *search, float *out);
    /* Writes up to list->count. */
    size_t (*find)(const pm_list *list, pm_search *search, pm_found *out);
    /* Lowers search->bound while it looks. */
    void (*closest)(const pm_list *list, pm_search *search, pm_closest *out);
    /* The rank-th least of count >= rank values >= 0, none above high; `values` is aligned and
     * has room for 16 more. */
    float (*select)(float *values, size_t count, size_t rank, float high);
    pm_hint (*ask)(const pm_node *node, const pm_search *search, unsigned matching);
};

extern const pm_kernel pm_kernel_avx512, pm_kernel_avx2, pm_kernel_sse2;

/* ---- what is found ---- */

/* Sums of packed fluxes over photons found; squares for the variance. */
typedef struct pm_flux_sum {
    pm_rgb sum, square;
    uint32_t count;
} pm_flux_sum;

/* A sum under way. */
typedef struct pm_running_sum {
    pm_sums plain;
    pm_flux_sum others; /* weighted, and ties */
    const pm_photon_weight *weight;
} pm_running_sum;

void pm_sum_begin(pm_running_sum *sum, const pm_photon_weight *weight); /* NULL: 1 */
/* Adds the photons of a list within the bound. */
void pm_sum_list(pm_running_sum *sum, pm_search *search, const pm_list *list);
/* Adds up to `missing` of those exactly at the bound; returns how many are still missing. */
uint32_t pm_sum_ties(pm_running_sum *sum, pm_search *search, const pm_list *list,
                     uint32_t missing);
pm_flux_sum pm_sum_end(pm_running_sum *sum, const pm_photon_map *map);

/* Sums the photons within the bounds at any number of points; weights[i] may be NULL. */
void pm_sum_within(pm_search *searches, size_t count, const pm_photon_weight *const *weights,
                   pm_flux_sum *out);

/* A squared radius that probably holds somewhat more than the wanted photons, from the boxes
 * where the point would be stored; sets `careful` if they are far. Only speed depends on it. */
double pm_search_guess(pm_search *search, uint32_t wanted);

/* What was found at the last points, for a guess at the next. */
typedef struct pm_guess {
    double bound; /* 0: nothing */
    int64_t point[3];
} pm_guess;

enum { PM_DISTANCES = PM_GATHER_MAX + 1 + PM_LIST_MAX * PM_BLOCK_SIZE };

/* What nearest searches work in. */
typedef struct pm_nearest {
    _Alignas(64) float distance2[PM_DISTANCES + PM_BLOCK_SIZE];
    pm_list list;
} pm_nearest;

/* Sums the `wanted` photons nearest to each point within search->bound,
 * of equally distant ones those first in stored order. next2[i] is the squared distance of the
 * next one, or INFINITY if no more than `wanted` lie within the bound: then all of them are
 * summed. weights[i] may be NULL. */
void pm_nearest_sum(pm_search *searches, size_t count, uint32_t wanted,
                    const pm_photon_weight *const *weights, pm_guess *guess, pm_nearest *work,
                    pm_flux_sum *out, double *next2);

/* Finds the photon nearest to each point within search->bound, of equally
 * distant ones the first in stored order; SIZE_MAX if there is none. */
void pm_nearest_one(pm_search *searches, size_t count, pm_guess *guess, pm_list *list,
                    size_t *index);

/* Photons found. */
typedef struct pm_candidates {
    uint32_t wanted, count;
    double distance2[PM_GATHER_MAX]; /* [grid units^2] */
    uint32_t index[PM_GATHER_MAX];
} pm_candidates;

/* Finds the photons that pm_nearest_sum would sum, in stored order. Returns next2. */
double pm_search_nearest(pm_search *search, uint32_t wanted, pm_candidates *out);

#endif
