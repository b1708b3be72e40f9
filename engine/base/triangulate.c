#include "base/triangulate.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

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

enum { MOST_FALLBACKS = 64 };

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

    /* reflex corners by cell: items[start[c] .. start[c + 1]) */
    struct pm_point2 low;
    double side, per_cell;
    uint32_t columns, rows;
    uint32_t *start, *items;

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

/* ---- the grid of reflex corners ---- */

static uint32_t cell_index(double value, double low, double per_cell, uint32_t cells)
{
    double i = (value - low) * per_cell;
    if (!(i > 0))
        return 0;
    return i < cells ? (uint32_t)i : cells - 1;
}

static uint32_t cell_of(const struct clipper *s, struct pm_point2 p)
{
    return cell_index(p.y, s->low.y, s->per_cell, s->rows) * s->columns +
           cell_index(p.x, s->low.x, s->per_cell, s->columns);
}

static uint32_t count_reflex(struct clipper *s, struct pm_point2 *high)
{
    uint32_t reflex = 0;
    s->low = *high = s->point[0];
    for (uint32_t i = 0; i < s->count; i++) {
        s->low.x = fmin(s->low.x, s->point[i].x);
        s->low.y = fmin(s->low.y, s->point[i].y);
        high->x = fmax(high->x, s->point[i].x);
        high->y = fmax(high->y, s->point[i].y);
        s->reflex[i] = turn(s, i) <= 0;
        reflex += s->reflex[i];
    }
    return reflex;
}

/* About one reflex corner a cell. */
static void choose_cells(struct clipper *s, uint32_t reflex, struct pm_point2 high)
{
    enum { MOST = 2048 };
    double width = high.x - s->low.x, height = high.y - s->low.y;
    double side = fmax(sqrt(width * height / (reflex + 1.0)), fmax(width, height) / MOST);
    s->side = side;
    s->per_cell = side > 0 ? 1 / side : 0;
    s->columns = (uint32_t)fmin(floor(width * s->per_cell) + 1, MOST);
    s->rows = (uint32_t)fmin(floor(height * s->per_cell) + 1, MOST);
}

static bool build_grid(struct clipper *s)
{
    struct pm_point2 high;
    uint32_t reflex = count_reflex(s, &high);
    choose_cells(s, reflex, high);
    size_t cells = (size_t)s->columns * s->rows;
    s->start = calloc(cells + 2, sizeof *s->start);
    s->items = malloc((reflex + 1) * sizeof *s->items);
    if (!s->start || !s->items)
        return false;
    for (uint32_t i = 0; i < s->count; i++)
        if (s->reflex[i])
            s->start[cell_of(s, s->point[i]) + 2]++;
    for (size_t c = 1; c <= cells; c++)
        s->start[c + 1] += s->start[c];
    for (uint32_t i = 0; i < s->count; i++)
        if (s->reflex[i])
            s->items[s->start[cell_of(s, s->point[i]) + 1]++] = i;
    return true;
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

static bool cell_blocks(const struct clipper *s, uint32_t cell, uint32_t b,
                        const struct pm_point2 abc[3], bool strict)
{
    for (uint32_t i = s->start[cell]; i < s->start[cell + 1]; i++) {
        uint32_t p = s->items[i];
        if (s->alive[p] && s->reflex[p] && p != b && p != s->prev[b] && p != s->next[b] &&
            blocks(s, p, abc, strict))
            return true;
    }
    return false;
}

/* Where the triangle lies between two heights; empty if it does not. */
static void range_between(const struct pm_point2 abc[3], double bottom, double top, double *low,
                          double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (int i = 0; i < 3; i++) {
        struct pm_point2 p = abc[i], q = abc[(i + 1) % 3];
        if (fmax(p.y, q.y) < bottom || fmin(p.y, q.y) > top)
            continue;
        double rise = q.y - p.y, at[2] = {p.x, q.x};
        if (rise != 0) {
            double start = fmin(fmax((bottom - p.y) / rise, 0), 1);
            double end = fmin(fmax((top - p.y) / rise, 0), 1);
            at[0] = p.x + start * (q.x - p.x);
            at[1] = p.x + end * (q.x - p.x);
        }
        *low = fmin(*low, fmin(at[0], at[1]));
        *high = fmax(*high, fmax(at[0], at[1]));
    }
}

/* Looks only at the cells that the triangle meets: long thin ears aslant would meet few of
 * those in their bounds. */
static bool is_blocked(const struct clipper *s, uint32_t b, bool strict)
{
    const struct pm_point2 abc[3] = {s->point[s->prev[b]], s->point[b], s->point[s->next[b]]};
    const double margin = 1e-6; /* [cells], against rounding */
    double lowest = fmin(abc[0].y, fmin(abc[1].y, abc[2].y));
    double highest = fmax(abc[0].y, fmax(abc[1].y, abc[2].y));
    uint32_t first = cell_index(lowest, s->low.y, s->per_cell, s->rows);
    uint32_t last = cell_index(highest, s->low.y, s->per_cell, s->rows);
    for (uint32_t row = first; row <= last; row++) {
        double low, high, bottom = s->low.y + (row - margin) * s->side;
        range_between(abc, bottom, bottom + (1 + 2 * margin) * s->side, &low, &high);
        low -= margin * s->side;
        high += margin * s->side;
        uint32_t left = cell_index(low, s->low.x, s->per_cell, s->columns);
        uint32_t right = cell_index(high, s->low.x, s->per_cell, s->columns);
        for (uint32_t column = left; column <= right; column++)
            if (cell_blocks(s, row * s->columns + column, b, abc, strict))
                return true;
    }
    return false;
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
    return push(s, b);
}

static bool cut(struct clipper *s, uint32_t b)
{
    uint32_t a = s->prev[b], c = s->next[b];
    emit(s, b);
    s->alive[b] = false;
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
    return build_grid(s);
}

static void clipper_clear(struct clipper *s)
{
    free(s->prev);
    free(s->next);
    free(s->stamp);
    free(s->alive);
    free(s->reflex);
    free(s->heap);
    free(s->start);
    free(s->items);
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
