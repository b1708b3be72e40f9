#include "building.h"

#include <pthread.h>
#include <stdlib.h>

struct entry {
    pm_digest family;
    int64_t owner;
    struct entry *next;
};

/* A job that waits; lives on its thread's stack. */
struct waiter {
    int64_t job;
    const pm_digest *family;
    struct waiter *next;
};

struct pm_building {
    pthread_mutex_t lock; /* guards entries and waiters */
    pthread_cond_t changed;
    struct entry *entries;
    struct waiter *waiters;
};

pm_building *pm_building_new(void)
{
    pm_building *building = calloc(1, sizeof *building);
    if (!building)
        return NULL;
    pthread_mutex_init(&building->lock, NULL);
    pthread_cond_init(&building->changed, NULL);
    return building;
}

void pm_building_free(pm_building *building)
{
    if (!building)
        return;
    while (building->entries) {
        struct entry *next = building->entries->next;
        free(building->entries);
        building->entries = next;
    }
    pthread_cond_destroy(&building->changed);
    pthread_mutex_destroy(&building->lock);
    free(building);
}

/* The functions down to pm_building_begin are called with the lock held. */

static struct entry *find(pm_building *building, const pm_digest *family)
{
    for (struct entry *entry = building->entries; entry; entry = entry->next)
        if (pm_digest_equal(&entry->family, family))
            return entry;
    return NULL;
}

/* Whether `job` waits, through others or directly, for something that `owner` has. */
static bool waits_for(pm_building *building, int64_t job, int64_t owner)
{
    while (job != owner) {
        const struct waiter *waiter = building->waiters;
        while (waiter && waiter->job != job)
            waiter = waiter->next;
        const struct entry *entry = waiter ? find(building, waiter->family) : NULL;
        if (!entry)
            return false;
        job = entry->owner;
    }
    return true;
}

static bool wait_for(pm_building *building, const pm_digest *family, int64_t job,
                     const atomic_bool *stop)
{
    struct waiter self = {job, family, building->waiters};
    building->waiters = &self;
    bool waited = false;
    for (;;) {
        const struct entry *entry = find(building, family);
        if (!entry || atomic_load(stop) || waits_for(building, entry->owner, job))
            break;
        waited = true;
        pthread_cond_wait(&building->changed, &building->lock);
    }
    struct waiter **at = &building->waiters;
    while (*at != &self)
        at = &(*at)->next;
    *at = self.next;
    return waited;
}

bool pm_building_begin(pm_building *building, const pm_digest *family, int64_t job,
                       const atomic_bool *stop)
{
    pthread_mutex_lock(&building->lock);
    bool waited = wait_for(building, family, job, stop);
    struct entry *entry = find(building, family) ? NULL : malloc(sizeof *entry);
    if (entry) { /* without it the work may be done twice, nothing worse */
        *entry = (struct entry){*family, job, building->entries};
        building->entries = entry;
    }
    pthread_mutex_unlock(&building->lock);
    return waited;
}

static void end(pm_building *building, const pm_digest *family, int64_t job)
{
    pthread_mutex_lock(&building->lock);
    for (struct entry **at = &building->entries; *at;) {
        struct entry *entry = *at;
        if (entry->owner == job && (!family || pm_digest_equal(&entry->family, family))) {
            *at = entry->next;
            free(entry);
        } else {
            at = &entry->next;
        }
    }
    pthread_cond_broadcast(&building->changed);
    pthread_mutex_unlock(&building->lock);
}

void pm_building_end(pm_building *building, const pm_digest *family, int64_t job)
{
    end(building, family, job);
}

void pm_building_end_all(pm_building *building, int64_t job)
{
    end(building, NULL, job);
}

void pm_building_wake(pm_building *building)
{
    pthread_mutex_lock(&building->lock);
    pthread_cond_broadcast(&building->changed);
    pthread_mutex_unlock(&building->lock);
}

unsigned pm_building_waiting(pm_building *building)
{
    unsigned count = 0;
    pthread_mutex_lock(&building->lock);
    for (const struct waiter *waiter = building->waiters; waiter; waiter = waiter->next)
        count++;
    pthread_mutex_unlock(&building->lock);
    return count;
}
