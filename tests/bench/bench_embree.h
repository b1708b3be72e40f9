#ifndef PM_TESTS_BENCH_EMBREE_H
#define PM_TESTS_BENCH_EMBREE_H

#include <stddef.h>

#include "base/vec3.h"

/* What Embree alone (float, ROBUST, one thread) makes of rays through triangles: the ceiling
 * that ours are measured against. */
typedef struct bench_embree bench_embree;

/* Corners of triangles, nine numbers each. */
bench_embree *bench_embree_new(const double (*triangles)[9], size_t count);
void bench_embree_free(bench_embree *embree);

/* The distance along the ray, negative if it meets nothing; the unit normal, on either side. */
double bench_embree_trace(bench_embree *embree, pm_vec3 origin, pm_vec3 direction,
                          pm_vec3 *normal);

#endif
