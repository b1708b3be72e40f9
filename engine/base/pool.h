#ifndef PM_BASE_POOL_H
#define PM_BASE_POOL_H

#include <stddef.h>

/* A fixed set of threads that share out numbered pieces of work. The pieces run in any order
 * and on any thread, so a piece writes only what belongs to its number. */
typedef struct pm_pool pm_pool;

/* `threads` >= 1, the caller's own included; 0 means one a processor. NULL if memory or threads
 * are short. */
pm_pool *pm_pool_new(unsigned threads);
void pm_pool_free(pm_pool *pool);
unsigned pm_pool_threads(const pm_pool *pool);

/* Calls work(context, i, thread) once for each i in [0, count); `thread` < pm_pool_threads is
 * the number of the running thread, for scratch memory. Returns when all are done. Not
 * reentrant. */
void pm_pool_run(pm_pool *pool, size_t count,
                 void (*work)(void *context, size_t i, unsigned thread), void *context);

#endif
