#include <stdlib.h>
#include <string.h>

#include "photons/map_internal.h"

/* Photons in Morton order.
 *
 * A radix sort over the upper 63 bits of the code moves small entries that point into the
 * batches; then the photons are fetched once, and the few that share those bits are sorted
 * among themselves. Pieces have a fixed size, so any number of threads gives the same bytes. */

enum {
    PIECE = 65536,
    DIGIT_BITS = 8,
    DIGITS = 1 << DIGIT_BITS,
    KEY_BITS = 63,
};

struct entry {
    uint64_t key;
    uint32_t batch, photon;
};

struct sort {
    const pm_batch *batches;
    size_t batch_count, total, pieces;
    size_t *batch_start;
    struct entry *from, *to;
    uint32_t (*histogram)[DIGITS]; /* a piece; then where the piece puts its next entry */
    int shift;
    pm_photon *photons;
};

/* The low 21 bits of v, two zeros between each and the next. */
static uint64_t spread(uint64_t v)
{
    v &= 0x1FFFFF;
    v = (v | v << 32) & 0x001F00000000FFFF;
    v = (v | v << 16) & 0x001F0000FF0000FF;
    v = (v | v << 8) & 0x100F00F00F00F00F;
    v = (v | v << 4) & 0x10C30C30C30C30C3;
    v = (v | v << 2) & 0x1249249249249249;
    return v;
}

uint64_t pm_photon_upper_code(const uint32_t p[3])
{
    return spread(p[0] >> 11) << 2 | spread(p[1] >> 11) << 1 | spread(p[2] >> 11);
}

/* True if the highest bit of a lies below the highest bit of b (Chan 2002). */
static bool below(uint32_t a, uint32_t b)
{
    return a < b && a < (a ^ b);
}

int pm_photon_order(const void *a, const void *b)
{
    const pm_photon *p = a, *q = b;
    int axis = 0;
    uint32_t differ = p->position[0] ^ q->position[0];
    for (int k = 1; k < 3; k++) {
        uint32_t d = p->position[k] ^ q->position[k];
        if (below(differ, d)) {
            axis = k;
            differ = d;
        }
    }
    if (differ)
        return p->position[axis] < q->position[axis] ? -1 : 1;
    return memcmp(p, q, sizeof *p);
}

void pm_photons_run(pm_pool *pool, size_t count, void (*work)(void *, size_t, unsigned),
                    void *context)
{
    if (pool)
        pm_pool_run(pool, count, work, context);
    else
        for (size_t i = 0; i < count; i++)
            work(context, i, 0);
}

static void make_entries(void *context, size_t b, unsigned thread)
{
    (void)thread;
    struct sort *s = context;
    struct entry *out = s->from + s->batch_start[b];
    for (size_t i = 0; i < s->batches[b].count; i++)
        out[i] = (struct entry){pm_photon_upper_code(s->batches[b].photons[i].position),
                                (uint32_t)b, (uint32_t)i};
}

static size_t piece_end(const struct sort *s, size_t piece)
{
    size_t end = (piece + 1) * PIECE;
    return end < s->total ? end : s->total;
}

static void count_digits(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    struct sort *s = context;
    uint32_t *histogram = s->histogram[piece];
    memset(histogram, 0, sizeof s->histogram[piece]);
    for (size_t i = piece * PIECE; i < piece_end(s, piece); i++)
        histogram[s->from[i].key >> s->shift & (DIGITS - 1)]++;
}

static void move_entries(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    struct sort *s = context;
    uint32_t *next = s->histogram[piece];
    for (size_t i = piece * PIECE; i < piece_end(s, piece); i++)
        s->to[next[s->from[i].key >> s->shift & (DIGITS - 1)]++] = s->from[i];
}

/* Turns counts into places; false if all entries have the same digit and may stay. */
static bool places(struct sort *s)
{
    uint32_t at = 0;
    for (unsigned d = 0; d < DIGITS; d++) {
        uint32_t before = at;
        for (size_t piece = 0; piece < s->pieces; piece++) {
            uint32_t here = s->histogram[piece][d];
            s->histogram[piece][d] = at;
            at += here;
        }
        if (at - before == s->total)
            return false;
    }
    return true;
}

static void sort_entries(struct sort *s, pm_pool *pool)
{
    for (s->shift = 0; s->shift < KEY_BITS; s->shift += DIGIT_BITS) {
        pm_photons_run(pool, s->pieces, count_digits, s);
        if (!places(s))
            continue;
        pm_photons_run(pool, s->pieces, move_entries, s);
        struct entry *swap = s->from;
        s->from = s->to;
        s->to = swap;
    }
}

static void fetch_photons(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    struct sort *s = context;
    for (size_t i = piece * PIECE; i < piece_end(s, piece); i++)
        s->photons[i] = s->batches[s->from[i].batch].photons[s->from[i].photon];
}

/* Sorts the runs of equal keys that start in this piece. */
static void sort_runs(void *context, size_t piece, unsigned thread)
{
    (void)thread;
    struct sort *s = context;
    size_t i = piece * PIECE;
    while (i && i < s->total && s->from[i].key == s->from[i - 1].key)
        i++;
    while (i < piece_end(s, piece)) {
        size_t end = i + 1;
        while (end < s->total && s->from[end].key == s->from[i].key)
            end++;
        if (end - i > 1)
            qsort(s->photons + i, end - i, sizeof *s->photons, pm_photon_order);
        i = end;
    }
}

static pm_status sort_all(struct sort *s, pm_pool *pool)
{
    s->from = malloc((s->total + 1) * sizeof *s->from);
    s->to = malloc((s->total + 1) * sizeof *s->to);
    s->histogram = malloc((s->pieces + 1) * sizeof *s->histogram);
    if (!s->from || !s->to || !s->histogram)
        return PM_E_MEMORY;
    pm_photons_run(pool, s->batch_count, make_entries, s);
    sort_entries(s, pool);
    free(s->to);
    s->to = NULL;
    s->photons = pm_photons_alloc(s->total);
    if (!s->photons)
        return PM_E_MEMORY;
    pm_photons_run(pool, s->pieces, fetch_photons, s);
    pm_photons_run(pool, s->pieces, sort_runs, s);
    return PM_OK;
}

static pm_status count_photons(struct sort *s, pm_error *err)
{
    s->batch_start = malloc((s->batch_count + 1) * sizeof *s->batch_start);
    if (!s->batch_start)
        return PM_E_MEMORY;
    for (size_t b = 0; b < s->batch_count; b++) {
        s->batch_start[b] = s->total;
        if (s->batches[b].count > PM_MAP_PHOTONS_MAX - s->total)
            return pm_error_set(err, PM_E_LIMIT, "more than %u photons in one map",
                                PM_MAP_PHOTONS_MAX);
        s->total += s->batches[b].count;
    }
    s->pieces = (s->total + PIECE - 1) / PIECE;
    return PM_OK;
}

pm_status pm_photons_sort(const pm_batch *batches, size_t count, pm_pool *pool, pm_photon **out,
                          size_t *total, pm_error *err)
{
    struct sort s = {.batches = batches, .batch_count = count};
    pm_status st = count_photons(&s, err);
    if (!st)
        st = sort_all(&s, pool);
    free(s.batch_start);
    free(s.from);
    free(s.to);
    free(s.histogram);
    if (st == PM_E_MEMORY)
        pm_error_set(err, st, "no memory to sort %zu photons", s.total);
    if (st)
        return st;
    *out = s.photons;
    *total = s.total;
    return PM_OK;
}
