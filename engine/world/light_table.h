#ifndef PM_WORLD_LIGHT_TABLE_H
#define PM_WORLD_LIGHT_TABLE_H

#include <stdint.h>

#include "base/arena.h"
#include "base/error.h"
#include "base/vec3.h"
#include "base/warp.h"

/* Where a patterned light is bright: distributions over the unit square, and over cones of
 * directions by way of it, that follow a function known by evaluation alone.
 *
 * A quadtree over the square, deep where the function varies and has weight. Sampling warps
 * points down the tree, so that well spread points stay well spread (Clarberg et al., "Wavelet
 * importance sampling", SIGGRAPH 2005, section 4). The tree only steers: densities are exact
 * for what is drawn, whatever the tree knows, and never below PM_LIGHT_TABLE_FLOOR. */

#define PM_LIGHT_TABLE_FLOOR 0x1p-4

struct pm_light_table;

/* What is tabulated. Values that are negative or not finite count as 0. */
struct pm_light_function {
    double (*value)(const void *context, double u, double v);
    const void *context;
    uint32_t detail; /* what is as small as 1 / detail of the square is found */
};

/* Evaluates the function detail^2 times, and at most five times as often again where it looks
 * closer; detail is cut to [2, 2048] and to a power of two. At most 2^20 nodes of 16 bytes,
 * from the arena; the same table for the same values. Errors: PM_E_MEMORY.
 * Test: test_light_table.c. */
PM_MUST_USE pm_status pm_light_table_build(const struct pm_light_function *function,
                                           pm_arena *arena, struct pm_light_table **out,
                                           pm_error *err);

/* Moves a uniform point of [0, 1)^2 to one of the distribution; returns its density, 1 on
 * average over the square. */
double pm_light_table_warp(const struct pm_light_table *table, double *u, double *v);

/* The density with which pm_light_table_warp gives (u, v). */
double pm_light_table_density(const struct pm_light_table *table, double u, double v);

/* A distribution over the cone about frame.z. */
struct pm_light_beam {
    pm_frame frame;
    double versine; /* 1 - cos of half the cone's angle */
    const struct pm_light_table *table;
};

/* Radiance from (or towards) a unit direction; one number for it. */
struct pm_light_directions {
    double (*radiance)(const void *context, pm_vec3 direction);
    const void *context;
    uint32_t detail; /* as above, across the cone */
};

/* Follows the radiance over the cone about `axis`. */
PM_MUST_USE pm_status pm_light_beam_build(const struct pm_light_directions *directions,
                                          pm_vec3 axis, double versine, pm_arena *arena,
                                          struct pm_light_beam *out, pm_error *err);

/* A direction and its density [1/sr]. */
pm_vec3 pm_light_beam_sample(const struct pm_light_beam *beam, double u, double v, double *pdf);

/* For a direction within the cone. */
double pm_light_beam_pdf(const struct pm_light_beam *beam, pm_vec3 direction);

#endif
