#include "base/pool.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <unistd.h>

struct worker {
    pm_pool *pool;
    unsigned number;
    pthread_t thread;
};

struct pm_pool {
    unsigned threads;
    struct worker *workers; /* threads - 1 of them; the caller is thread 0 */
    unsigned started;

    pthread_mutex_t lock; /* guards generation, busy, stopping */
    pthread_cond_t wake, done;
    unsigned long generation; /* counts calls of pm_pool_run */
    unsigned busy;            /* workers not yet finished with this generation */
    bool stopping;

    /* set before a generation starts, constant while it runs */
    void (*work)(void *, size_t, unsigned);
    void *context;
    size_t count;
    atomic_size_t next;
};

static void take_pieces(pm_pool *pool, unsigned thread)
{
    for (;;) {
        size_t i = atomic_fetch_add_explicit(&pool->next, 1, memory_order_relaxed);
        if (i >= pool->count)
            return;
        pool->work(pool->context, i, thread);
    }
}

static void *worker_main(void *argument)
{
    struct worker *worker = argument;
    pm_pool *pool = worker->pool;
    unsigned long seen = 0;
    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while (pool->generation == seen && !pool->stopping)
            pthread_cond_wait(&pool->wake, &pool->lock);
        if (pool->stopping)
            break;
        seen = pool->generation;
        pthread_mutex_unlock(&pool->lock);
        take_pieces(pool, worker->number);
        pthread_mutex_lock(&pool->lock);
        if (--pool->busy == 0)
            pthread_cond_signal(&pool->done);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static bool start_workers(pm_pool *pool)
{
    for (unsigned i = 0; i + 1 < pool->threads; i++) {
        struct worker *worker = &pool->workers[i];
        *worker = (struct worker){.pool = pool, .number = i + 1};
        if (pthread_create(&worker->thread, NULL, worker_main, worker))
            return false;
        pool->started++;
    }
    return true;
}

pm_pool *pm_pool_new(unsigned threads)
{
    if (!threads) {
        long online = sysconf(_SC_NPROCESSORS_ONLN);
        threads = online > 0 ? (unsigned)online : 1;
    }
    pm_pool *pool = calloc(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->threads = threads;
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->done, NULL);
    pool->workers = calloc(threads, sizeof *pool->workers);
    if (!pool->workers || !start_workers(pool)) {
        pm_pool_free(pool);
        return NULL;
    }
    return pool;
}

void pm_pool_free(pm_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stopping = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    for (unsigned i = 0; i < pool->started; i++)
        pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->lock);
    free(pool->workers);
    free(pool);
}

unsigned pm_pool_threads(const pm_pool *pool)
{
    return pool->threads;
}

void pm_pool_run(pm_pool *pool, size_t count, void (*work)(void *, size_t, unsigned),
                 void *context)
{
    pool->work = work;
    pool->context = context;
    pool->count = count;
    atomic_store_explicit(&pool->next, 0, memory_order_relaxed);
    pthread_mutex_lock(&pool->lock);
    pool->busy = pool->started;
    pool->generation++;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->lock);
    take_pieces(pool, 0);
    pthread_mutex_lock(&pool->lock);
    while (pool->busy)
        pthread_cond_wait(&pool->done, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}
