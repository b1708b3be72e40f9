#include "photons/ranked.h"

#include <assert.h>
#include <string.h>

/* Buckets by exponent and 6 bits of mantissa, so that photons crowded about the point spread
 * over as many of them as an even field does; what is nearer than 2^-16 of the farthest shares
 * the first. */
enum { BUCKETS = 1024, STEP_BITS = 17 };

static uint32_t step_of(double distance2)
{
    float value = (float)distance2;
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits >> STEP_BITS;
}

static double farthest(const pm_candidates *c)
{
    double most = 0;
    for (uint32_t i = 0; i < c->count; i++)
        most = c->distance2[i] > most ? c->distance2[i] : most;
    return most;
}

/* Steps counted back from that of the farthest. */
static uint32_t bucket_of(double distance2, uint32_t last)
{
    uint32_t back = last - step_of(distance2);
    return back < BUCKETS ? BUCKETS - 1 - back : 0;
}

/* Places of the buckets' first photons; place[BUCKETS] is the count. */
static void find_places(const pm_candidates *c, uint32_t last, uint16_t place[BUCKETS + 1])
{
    memset(place, 0, (BUCKETS + 1) * sizeof *place);
    for (uint32_t i = 0; i < c->count; i++)
        place[bucket_of(c->distance2[i], last) + 1]++;
    for (uint32_t b = 0; b < BUCKETS; b++)
        place[b + 1] = (uint16_t)(place[b + 1] + place[b]);
}

/* Insertion over falling gaps (Shell 1959; gaps of Ciura 2001): few in a bucket go straight to
 * gap 1, many take some n^(4/3) steps. */
static void sort_bucket(pm_ranked *r, uint32_t first, uint32_t end)
{
    static const uint32_t gaps[] = {3937, 1750, 701, 301, 132, 57, 23, 10, 4, 1};
    for (unsigned g = 0; g < sizeof gaps / sizeof *gaps; g++)
        for (uint32_t i = first + gaps[g]; i < end; i++) {
            double distance2 = r->distance2[i];
            uint32_t index = r->index[i], at = i;
            for (; at >= first + gaps[g] && r->distance2[at - gaps[g]] > distance2;
                 at -= gaps[g]) {
                r->distance2[at] = r->distance2[at - gaps[g]];
                r->index[at] = r->index[at - gaps[g]];
            }
            r->distance2[at] = distance2;
            r->index[at] = index;
        }
}

void pm_ranked_sort(const pm_candidates *candidates, double next2, pm_ranked *out)
{
    assert(candidates->count <= PM_GATHER_MAX);
    uint16_t place[BUCKETS + 1], used[BUCKETS];
    uint32_t last = step_of(farthest(candidates));
    find_places(candidates, last, place);
    memcpy(used, place, sizeof used);
    for (uint32_t i = 0; i < candidates->count; i++) {
        uint32_t at = used[bucket_of(candidates->distance2[i], last)]++;
        out->distance2[at] = candidates->distance2[i];
        out->index[at] = candidates->index[i];
    }
    for (uint32_t b = 0; b < BUCKETS; b++)
        if (place[b + 1] - place[b] > 1)
            sort_bucket(out, place[b], place[b + 1]);
    out->count = candidates->count;
    out->distance2[out->count] = next2;
}
