#include <immintrin.h>
#include <stdlib.h>
#include <string.h>

#include "photons/map_internal.h"

/* Photons in Morton order, sorted where they lie, most significant digits first: each photon is
 * carried to its digit's place, the one that lies there to its own, and so on. Source: McIlroy,
 * Bostic and McIlroy, "Engineering radix sort", Computing Systems 6(1), 1993, sec. 3 (American
 * flag sort).
 *
 * A digit is 2 or 3 bits of each coordinate; photons at one place are sorted further by their
 * other bytes. The order is total, so any number of threads gives the same bytes. */

enum {
    FEW = 48,           /* are sorted by whole codes */
    MANY = 4096,        /* have digits of 3 bits a coordinate, fewer ones of 2 */
    PLACE_BITS = 32,    /* of a coordinate */
    DIGITS = 1 << 9,    /* most of a pass */
    OTHER_DIGITS = 256, /* of the bytes behind the position */
    SHARES = 32,        /* the threads sort parts of less than one in so many photons */
    END = PLACE_BITS + sizeof(pm_photon) - sizeof((pm_photon){0}.position),
};

/* Photons that agree in everything above `digit`: a bit of the coordinates, counted from the
 * top, or PLACE_BITS and more: a byte. */
struct range {
    pm_photon *photons;
    size_t count;
    unsigned digit;
};

struct pass {
    unsigned digits, next; /* how many; the digit after it */
    size_t end[DIGITS];    /* where each digit's photons end */
};

uint64_t pm_photon_upper_code(const uint32_t p[3])
{
    const uint64_t every_third = 0x1249249249249249;
    return _pdep_u64(p[0] >> 11, every_third << 2) | _pdep_u64(p[1] >> 11, every_third << 1) |
           _pdep_u64(p[2] >> 11, every_third);
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

/* ---- one pass over one range ---- */

static const uint16_t spread_digit[8] = {0, 1, 8, 9, 64, 65, 72, 73};

/* The bits of the coordinates from `digit` on; below their lowest bit come zeros. */
static inline unsigned place_digit(const pm_photon *p, unsigned digit, unsigned mask)
{
    unsigned shift = PLACE_BITS + 1 - digit - (mask == 7 ? 3 : 2); /* of what is doubled */
    const uint64_t x = (uint64_t)p->position[0] << 1, y = (uint64_t)p->position[1] << 1,
                   z = (uint64_t)p->position[2] << 1;
    return (unsigned)spread_digit[x >> shift & mask] << 2 |
           (unsigned)spread_digit[y >> shift & mask] << 1 | spread_digit[z >> shift & mask];
}

static inline unsigned byte_digit(const pm_photon *p, unsigned digit)
{
    return ((const uint8_t *)p)[sizeof p->position + digit - PLACE_BITS];
}

/* How a pass looks at a photon: three or two bits of each coordinate, or a byte. */
enum look { BITS_3 = 7, BITS_2 = 3, BYTE = 0 };

static inline unsigned digit_of(const pm_photon *p, unsigned digit, enum look look)
{
    return look == BYTE ? byte_digit(p, digit) : place_digit(p, digit, look);
}

/* Where each digit's photons start. False if one digit has all, and nothing need move. */
static inline bool find_places(const struct range *r, enum look look, struct pass *pass,
                               size_t next[DIGITS])
{
    size_t count[DIGITS] = {0}, at = 0;
    bool several = true;
    for (size_t i = 0; i < r->count; i++)
        count[digit_of(&r->photons[i], r->digit, look)]++;
    for (unsigned d = 0; d < pass->digits; d++) {
        next[d] = at;
        pass->end[d] = at += count[d];
        several = several && count[d] < r->count;
    }
    return several;
}

static inline bool distribute(const struct range *r, enum look look, struct pass *pass)
{
    size_t next[DIGITS];
    if (!find_places(r, look, pass, next))
        return false;
    for (unsigned d = 0; d < pass->digits; d++)
        while (next[d] < pass->end[d]) {
            pm_photon carried = r->photons[next[d]];
            unsigned to;
            while ((to = digit_of(&carried, r->digit, look)) != d) {
                pm_photon *place = &r->photons[next[to]++], met = *place;
                *place = carried;
                carried = met;
            }
            r->photons[next[d]++] = carried;
        }
    return true;
}

/* One function a look, so that the compiler knows it. */
static bool run_pass(const struct range *r, struct pass *pass)
{
    if (r->digit >= PLACE_BITS) {
        *pass = (struct pass){.digits = OTHER_DIGITS, .next = r->digit + 1};
        return distribute(r, BYTE, pass);
    }
    bool many = r->count > MANY;
    pass->digits = many ? 512 : 64;
    pass->next = r->digit + (many ? 3 : 2);
    if (pass->next > PLACE_BITS)
        pass->next = PLACE_BITS;
    return many ? distribute(r, BITS_3, pass) : distribute(r, BITS_2, pass);
}

/* ---- few photons ---- */

/* Codes are compared, and where they agree whole photons. */
static void sort_few(pm_photon *photons, size_t count)
{
    uint64_t code[FEW];
    uint8_t from[FEW];
    pm_photon copy[FEW];
    memcpy(copy, photons, count * sizeof *photons);
    for (size_t i = 0; i < count; i++) {
        uint64_t own = pm_photon_upper_code(copy[i].position);
        size_t at = i;
        while (at > 0 &&
               (code[at - 1] > own ||
                (code[at - 1] == own && pm_photon_order(&copy[from[at - 1]], &copy[i]) > 0))) {
            code[at] = code[at - 1];
            from[at] = from[at - 1];
            at--;
        }
        code[at] = own;
        from[at] = (uint8_t)i;
    }
    for (size_t i = 0; i < count; i++)
        photons[i] = copy[from[i]];
}

/* ---- ranges within ranges ---- */

/* The photons of one digit, behind a pass. */
static struct range part_of(const struct range *r, const struct pass *pass, unsigned d)
{
    size_t start = d ? pass->end[d - 1] : 0;
    return (struct range){r->photons + start, pass->end[d] - start, pass->next};
}

/* At most 28 deep. */
static void sort_range(struct range r)
{
    struct pass pass;
    while (r.count > FEW && r.digit < END) {
        if (run_pass(&r, &pass)) {
            for (unsigned d = 0; d < pass.digits; d++)
                sort_range(part_of(&r, &pass, d));
            return;
        }
        r.digit = pass.next;
    }
    if (r.count > 1 && r.digit < END)
        sort_few(r.photons, r.count);
}

/* Ranges that the threads share out. */
struct tasks {
    struct range *list;
    size_t count, capacity;
    size_t most; /* photons of a task */
};

static bool add_task(struct tasks *tasks, struct range r)
{
    if (tasks->count == tasks->capacity) {
        size_t capacity = 2 * tasks->capacity + DIGITS;
        struct range *list = realloc(tasks->list, capacity * sizeof *list);
        if (!list)
            return false;
        tasks->list = list;
        tasks->capacity = capacity;
    }
    tasks->list[tasks->count++] = r;
    return true;
}

static void split(struct tasks *tasks, struct range r)
{
    struct pass pass;
    for (; r.count > tasks->most && r.digit < END; r.digit = pass.next)
        if (run_pass(&r, &pass)) {
            for (unsigned d = 0; d < pass.digits; d++)
                split(tasks, part_of(&r, &pass, d));
            return;
        }
    if (r.count > 1 && r.digit < END && !add_task(tasks, r))
        sort_range(r);
}

static void run_task(void *context, size_t i, unsigned thread)
{
    (void)thread;
    const struct tasks *tasks = context;
    sort_range(tasks->list[i]);
}

void pm_photons_sort(pm_photon *photons, size_t count, pm_pool *pool)
{
    struct tasks tasks = {.most = count / SHARES};
    struct range all = {photons, count, 0};
    if (!pool || pm_pool_threads(pool) < 2 || tasks.most < FEW) {
        sort_range(all);
        return;
    }
    split(&tasks, all);
    pm_pool_run(pool, tasks.count, run_task, &tasks);
    free(tasks.list);
}
