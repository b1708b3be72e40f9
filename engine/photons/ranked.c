#include "photons/ranked.h"

#include <assert.h>
#include <string.h>

/* Distances become steps of 2^-14 of a power of two, counted back from that of the farthest for
 * 16 octaves, so that photons crowded about the point spread over as many of them as an even
 * field does; what is nearer than 2^-16 of the farthest shares the first. Steps and places are
 * sorted as one word by two rounds of counting, 9 bits each; what equal steps leave out of
 * order is moved at the end. */
enum { STEP_BITS = 18, DIGIT_BITS = 9, DIGITS = 1 << DIGIT_BITS, PLACE_BITS = 14 };

_Static_assert(PM_GATHER_MAX <= 1 << PLACE_BITS, "a place fits");

struct sorting {
    uint32_t words[PM_GATHER_MAX], other[PM_GATHER_MAX];
    uint32_t counts[2][DIGITS];
    uint32_t crowded; /* in the first step */
};

static uint32_t bits_of(double distance2)
{
    float value = (float)distance2;
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits >> DIGIT_BITS;
}

static double farthest(const pm_candidates *c)
{
    double most = 0;
    for (uint32_t i = 0; i < c->count; i++)
        most = c->distance2[i] > most ? c->distance2[i] : most;
    return most;
}

static void make_words(const pm_candidates *c, struct sorting *s)
{
    const uint32_t last = bits_of(farthest(c)), steps = 1U << STEP_BITS;
    memset(s->counts, 0, sizeof s->counts);
    s->crowded = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        uint32_t back = last - bits_of(c->distance2[i]);
        uint32_t step = back < steps ? steps - 1 - back : 0;
        s->words[i] = step << PLACE_BITS | i;
        s->counts[0][step % DIGITS]++;
        s->counts[1][step / DIGITS]++;
        s->crowded += step == 0;
    }
}

static void sort_digit(const uint32_t *from, uint32_t *to, uint32_t count,
                       uint32_t counts[DIGITS], int shift)
{
    for (uint32_t digit = 0, sum = 0; digit < DIGITS; digit++) {
        uint32_t here = counts[digit];
        counts[digit] = sum;
        sum += here;
    }
    for (uint32_t i = 0; i < count; i++)
        to[counts[from[i] >> shift & (DIGITS - 1)]++] = from[i];
}

/* Insertion over falling gaps (Shell 1959; gaps of Ciura 2001): for the photons of one step, of
 * which there may be very many. */
static void sort_by_gap(pm_ranked *r, uint32_t end, uint32_t gap)
{
    for (uint32_t i = gap; i < end; i++) {
        double distance2 = r->distance2[i];
        uint32_t index = r->index[i], at = i;
        for (; at >= gap && r->distance2[at - gap] > distance2; at -= gap) {
            r->distance2[at] = r->distance2[at - gap];
            r->index[at] = r->index[at - gap];
        }
        r->distance2[at] = distance2;
        r->index[at] = index;
    }
}

static void finish(pm_ranked *r, uint32_t crowded)
{
    static const uint32_t gaps[] = {3937, 1750, 701, 301, 132, 57, 23, 10, 4};
    for (unsigned g = 0; g < sizeof gaps / sizeof *gaps && crowded > 8; g++)
        sort_by_gap(r, crowded, gaps[g]);
    sort_by_gap(r, r->count, 1);
}

void pm_ranked_sort(const pm_candidates *candidates, double next2, pm_ranked *out)
{
    assert(candidates->count <= PM_GATHER_MAX);
    struct sorting s;
    uint32_t count = candidates->count;
    make_words(candidates, &s);
    sort_digit(s.words, s.other, count, s.counts[0], PLACE_BITS);
    sort_digit(s.other, s.words, count, s.counts[1], PLACE_BITS + DIGIT_BITS);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t place = s.words[i] & ((1U << PLACE_BITS) - 1);
        out->distance2[i] = candidates->distance2[place];
        out->index[i] = candidates->index[place];
    }
    out->count = count;
    out->distance2[count] = next2;
    finish(out, s.crowded);
}
