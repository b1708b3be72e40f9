#include "base/triangulate.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/corner_tree.h"

/* What makes a corner an ear. Each level is tried only when the one before finds nothing; a
 * polygon whose edges do not cross needs the first two. */
enum level {
    CLEAR,   /* convex, no other corner in the closed triangle */
    FLAT,    /* the corner lies on the line through its neighbours: nothing is cut off */
    TOUCHED, /* convex, no other corner strictly inside */
    CONVEX,  /* convex */
    ANY,     /* edges cross: cut anyway and report the inverted area */
    LEVELS
};

enum { MOST_FALLBACKS = 4 };

struct candidate {
    double key; /* squared length of the diagonal */
    uint32_t corner, stamp;
};

struct clipper {
    const struct pm_point2 *point;
    uint32_t count, left;
    uint32_t *prev, *next;
    uint32_t *stamp; /* raised when the neighbours change: older candidates are stale */
    bool *alive, *reflex;

    struct candidate *heap;
    size_t heap_count, heap_capacity;

    pm_corner_tree reflex_corners;

    struct pm_triangle *out;
    uint32_t made, fallbacks;
    double inverted;
};

/* Twice the signed area. */
static double orient(struct pm_point2 a, struct pm_point2 b, struct pm_point2 c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool equal(struct pm_point2 a, struct pm_point2 b)
{
    return a.x == b.x && a.y == b.y;
}

static double turn(const struct clipper *s, uint32_t b)
{
    return orient(s->point[s->prev[b]], s->point[b], s->point[s->next[b]]);
}

/* ---- the heap of candidates ---- */

static bool before(struct candidate a, struct candidate b)
{
    return a.key < b.key || (a.key == b.key && a.corner < b.corner);
}

static bool push(struct clipper *s, uint32_t b)
{
    if (s->heap_count == s->heap_capacity) {
        size_t capacity = s->heap_capacity ? 2 * s->heap_capacity : 64;
        struct candidate *grown = realloc(s->heap, capacity * sizeof *grown);
        if (!grown)
            return false;
        s->heap = grown;
        s->heap_capacity = capacity;
    }
    struct pm_point2 a = s->point[s->prev[b]], c = s->point[s->next[b]];
    struct candidate added = {(c.x - a.x) * (c.x - a.x) + (c.y - a.y) * (c.y - a.y), b,
                              s->stamp[b]};
    size_t i = s->heap_count++;
    for (; i > 0 && before(added, s->heap[(i - 1) / 2]); i = (i - 1) / 2)
        s->heap[i] = s->heap[(i - 1) / 2];
    s->heap[i] = added;
    return true;
}

static struct candidate pop(struct clipper *s)
{
    struct candidate top = s->heap[0], last = s->heap[--s->heap_count];
    size_t i = 0;
    for (;;) {
        size_t child = 2 * i + 1;
        if (child >= s->heap_count)
            break;
        if (child + 1 < s->heap_count && before(s->heap[child + 1], s->heap[child]))
            child++;
        if (!before(s->heap[child], last))
            break;
        s->heap[i] = s->heap[child];
        i = child;
    }
    s->heap[i] = last;
    return top;
}

/* ---- the reflex corners ---- */

static bool list_reflex(struct clipper *s)
{
    uint32_t *items = malloc(s->count * sizeof *items), reflex = 0;
    if (!items)
        return false;
    for (uint32_t i = 0; i < s->count; i++) {
        s->reflex[i] = turn(s, i) <= 0;
        if (s->reflex[i])
            items[reflex++] = i;
    }
    pm_status status =
        pm_corner_tree_init(&s->reflex_corners, s->point, s->count, items, reflex);
    free(items);
    return !status;
}

/* ---- ears ---- */

/* A corner at the same place as b: does one of its edges go into the angle at b? */
static bool enters_angle(const struct clipper *s, uint32_t p, struct pm_point2 a,
                         struct pm_point2 b, struct pm_point2 c)
{
    struct pm_point2 q = s->point[s->prev[p]], r = s->point[s->next[p]];
    return (orient(a, b, q) > 0 && orient(b, c, q) > 0) ||
           (orient(a, b, r) > 0 && orient(b, c, r) > 0);
}

static bool blocks(const struct clipper *s, uint32_t p, const struct pm_point2 abc[3],
                   bool strict)
{
    struct pm_point2 q = s->point[p], a = abc[0], b = abc[1], c = abc[2];
    if (equal(q, b))
        return enters_angle(s, p, a, b, c);
    if (equal(q, a) || equal(q, c))
        return false;
    double u = orient(a, b, q), v = orient(b, c, q), w = orient(c, a, q);
    return strict ? u > 0 && v > 0 && w > 0 : u >= 0 && v >= 0 && w >= 0;
}

struct ear {
    const struct clipper *clipper;
    uint32_t corner;
    struct pm_point2 abc[3];
    bool strict;
};

static bool blocks_ear(const void *context, uint32_t p)
{
    const struct ear *ear = context;
    const struct clipper *s = ear->clipper;
    uint32_t b = ear->corner;
    return p != b && p != s->prev[b] && p != s->next[b] && blocks(s, p, ear->abc, ear->strict);
}

static bool is_blocked(const struct clipper *s, uint32_t b, bool strict)
{
    const struct ear ear = {
        s, b, {s->point[s->prev[b]], s->point[b], s->point[s->next[b]]}, strict};
    return pm_corner_tree_any(&s->reflex_corners, ear.abc, blocks_ear, &ear);
}

static bool is_ear(const struct clipper *s, uint32_t b, enum level level)
{
    double area = turn(s, b);
    switch (level) {
    case CLEAR:
        return area > 0 && !is_blocked(s, b, false);
    case FLAT:
        return area == 0;
    case TOUCHED:
        return area > 0 && !is_blocked(s, b, true);
    case CONVEX:
        return area > 0;
    default:
        return true;
    }
}

static void emit(struct clipper *s, uint32_t b)
{
    uint32_t a = s->prev[b], c = s->next[b];
    double area = orient(s->point[a], s->point[b], s->point[c]);
    if (area < 0)
        s->inverted -= area / 2;
    if (equal(s->point[a], s->point[b]) || equal(s->point[b], s->point[c]) ||
        equal(s->point[c], s->point[a]))
        return;
    s->out[s->made++] = (struct pm_triangle){{a, b, c}};
}

/* The neighbours of a cut ear may have become ears. */
static bool renew(struct clipper *s, uint32_t b)
{
    s->stamp[b]++;
    s->reflex[b] = s->reflex[b] && turn(s, b) <= 0;
    if (!s->reflex[b])
        pm_corner_tree_remove(&s->reflex_corners, b);
    return push(s, b);
}

static bool cut(struct clipper *s, uint32_t b)
{
    uint32_t a = s->prev[b], c = s->next[b];
    emit(s, b);
    s->alive[b] = false;
    pm_corner_tree_remove(&s->reflex_corners, b);
    s->next[a] = c;
    s->prev[c] = a;
    s->left--;
    return renew(s, a) && renew(s, c);
}

/* Cuts the ears of one level; says whether there were any. */
static bool cut_level(struct clipper *s, enum level level, bool *any)
{
    *any = false;
    s->heap_count = 0;
    for (uint32_t i = 0; i < s->count; i++)
        if (s->alive[i] && !push(s, i))
            return false;
    while (s->left > 3 && s->heap_count > 0) {
        struct candidate best = pop(s);
        uint32_t b = best.corner;
        if (!s->alive[b] || s->stamp[b] != best.stamp || !is_ear(s, b, level))
            continue;
        *any = true;
        if (!cut(s, b))
            return false;
        /* after a fallback the strict levels may do again; but not for ever */
        if (level > FLAT && s->fallbacks++ < MOST_FALLBACKS)
            break;
    }
    return true;
}

static bool cut_all(struct clipper *s)
{
    for (enum level level = CLEAR; s->left > 3 && level < LEVELS;) {
        bool any;
        if (!cut_level(s, level, &any))
            return false;
        level = any ? CLEAR : level + 1;
    }
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->alive[i]) {
            emit(s, i);
            break;
        }
    }
    return true;
}

static bool clipper_init(struct clipper *s)
{
    s->prev = malloc(s->count * sizeof *s->prev);
    s->next = malloc(s->count * sizeof *s->next);
    s->stamp = calloc(s->count, sizeof *s->stamp);
    s->alive = malloc(s->count * sizeof *s->alive);
    s->reflex = malloc(s->count * sizeof *s->reflex);
    if (!s->prev || !s->next || !s->stamp || !s->alive || !s->reflex)
        return false;
    for (uint32_t i = 0; i < s->count; i++) {
        s->prev[i] = (i + s->count - 1) % s->count;
        s->next[i] = (i + 1) % s->count;
        s->alive[i] = true;
    }
    return list_reflex(s);
}

static void clipper_clear(struct clipper *s)
{
    free(s->prev);
    free(s->next);
    free(s->stamp);
    free(s->alive);
    free(s->reflex);
    free(s->heap);
    pm_corner_tree_clear(&s->reflex_corners);
}

/* Triangles and convex quads need no search. */
static bool is_simple_case(const struct pm_point2 *p, uint32_t count, struct pm_triangle *out)
{
    if (count == 3) {
        out[0] = (struct pm_triangle){{0, 1, 2}};
        return orient(p[0], p[1], p[2]) > 0;
    }
    if (count != 4)
        return false;
    out[0] = (struct pm_triangle){{0, 1, 2}};
    out[1] = (struct pm_triangle){{0, 2, 3}};
    return orient(p[0], p[1], p[2]) > 0 && orient(p[0], p[2], p[3]) > 0 &&
           orient(p[1], p[2], p[3]) > 0 && orient(p[1], p[3], p[0]) > 0;
}

pm_status pm_triangulate(const struct pm_point2 *points, uint32_t count,
                         struct pm_triangle *out, uint32_t *made, double *inverted)
{
    if (is_simple_case(points, count, out)) {
        *made = count - 2;
        *inverted = 0;
        return PM_OK;
    }
    struct clipper s = {.point = points, .count = count, .left = count, .out = out};
    bool done = clipper_init(&s) && cut_all(&s);
    clipper_clear(&s);
    if (!done)
        return PM_E_MEMORY;
    *made = s.made;
    *inverted = s.inverted;
    return PM_OK;
}
