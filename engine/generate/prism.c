#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "base/number.h"
#include "generate/generation.h"

/* genprism(1): a polygon of the xy plane extruded along a vector, its edges sharp or rounded.
 *
 * Rounding: `u` is the unit vector back along the side that ends in a vertex; `trim` is the
 * tangent of half the angle by which the outline turns there, so that a circle of radius r that
 * touches both sides has its centre at v + r (trim * u + normal). Negative where the outline
 * turns the other way. */

static const double tiny = 1e-6;

struct corner {
    double x, y, u[2], trim;
};

struct prism {
    pm_generation *g;
    const char *modifier, *name;
    struct corner *corners;
    size_t count;
    double shift[3], length; /* the extrusion */
    double direction;        /* 1 up, -1 down */
    double radius;
    bool ends, open;
    pm_bytes memory; /* of the corners */
};

/* ---- the outline ---- */

static void add_corner(struct prism *p, double x, double y)
{
    const struct corner corner = {.x = x, .y = y};
    pm_bytes_append(&p->memory, &corner, sizeof corner);
}

static pm_status read_corners(struct prism *p)
{
    pm_generation *g = p->g;
    int64_t count;
    pm_status st = pm_take_integer(g, "the number of vertices", 3, INT32_MAX, &count);
    for (int64_t i = 0; !st && i < count; i++) {
        double x, y;
        st = pm_take_real(g, "a vertex's x", &x);
        if (!st)
            st = pm_take_real(g, "a vertex's y", &y);
        if (!st)
            add_corner(p, x, y);
    }
    return st;
}

static bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* The next word of a file of numbers. */
static const char *next_word(const char **at, const char *end, size_t *length)
{
    while (*at < end && is_space(**at))
        ++*at;
    const char *word = *at;
    while (*at < end && !is_space(**at))
        ++*at;
    *length = (size_t)(*at - word);
    return *length ? word : NULL;
}

static pm_status read_file(struct prism *p)
{
    pm_generation *g = p->g;
    const char *name = pm_generation_word(g);
    pm_generate_file file = {0};
    if (g->request->find)
        file = g->request->find(g->request->find_context, name);
    if (!file.data)
        return pm_generation_fail(g, g->at, PM_E_MISSING,
                                  "there is no file '%.60s' of vertices; write the number of "
                                  "vertices here, or the name of a file beside this one",
                                  name);
    const char *at = file.data, *end = at + file.size, *word;
    double xy[2];
    size_t length, count = 0;
    while ((word = next_word(&at, end, &length))) {
        if (pm_number_real(word, length, &xy[count++ % 2]))
            return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                      "number %zu of the file '%.60s' is '%.*s', which is none",
                                      count, name, (int)(length < 40 ? length : 40), word);
        if (count % 2 == 0)
            add_corner(p, xy[0], xy[1]);
    }
    if (count < 6 || count % 2)
        return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                  "the file '%.60s' holds %zu numbers; it should hold x and y "
                                  "of at least 3 vertices",
                                  name, count);
    g->at++;
    return PM_OK;
}

static pm_status read_outline(struct prism *p)
{
    const char *word = pm_generation_word(p->g);
    if (word && strcmp(word, "-") == 0)
        return pm_generation_fail(
            p->g, p->g->at, PM_E_UNSUPPORTED,
            "there is no standard input to read vertices from; write them "
            "in the command, or name a file");
    bool counted = !word || (word[0] >= '0' && word[0] <= '9');
    pm_status st = counted ? read_corners(p) : read_file(p);
    if (!st && pm_bytes_status(&p->memory))
        st = pm_error_set(p->g->err, PM_E_MEMORY, "not enough memory for a prism's vertices");
    /* malloc'd memory is aligned for any type. */
    p->corners = (void *)p->memory.data;
    p->count = p->memory.size / sizeof(struct corner);
    return st;
}

/* ---- options ---- */

static pm_status take_extrusion(struct prism *p)
{
    static const char *const what[] = {"-l's x", "-l's y", "-l's z"};
    pm_status st = PM_OK;
    for (int i = 0; !st && i < 3; i++)
        st = pm_take_real(p->g, what[i], &p->shift[i]);
    if (!st && fabs(p->shift[2]) <= tiny)
        st = pm_generation_fail(p->g, p->g->at - 1, PM_E_RANGE,
                                "-l's z is %s; a prism extends up or down by more than %g",
                                p->g->request->words[p->g->at - 1], tiny);
    const double *s = p->shift;
    p->direction = s[2] < 0 ? -1 : 1;
    p->length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    return st;
}

static pm_status take_option(struct prism *p)
{
    pm_generation *g = p->g;
    const char *option = pm_generation_word(g);
    g->at++;
    if (strcmp(option, "-l") == 0)
        return take_extrusion(p);
    if (strcmp(option, "-r") == 0)
        return pm_take_real(g, "-r's radius", &p->radius);
    if (strcmp(option, "-e") == 0)
        p->ends = !p->ends;
    else if (strcmp(option, "-c") == 0)
        p->open = !p->open;
    else
        return pm_generation_fail(g, g->at - 1, PM_E_SYNTAX,
                                  "'%.60s' is no option; they are -l x y z, -r radius, -e, -c",
                                  option);
    return PM_OK;
}

/* ---- rounding ---- */

static pm_status measure_sides(struct prism *p)
{
    const struct corner *before = &p->corners[p->count - 1];
    for (size_t i = 0; i < p->count; i++) {
        struct corner *c = &p->corners[i];
        double dx = before->x - c->x, dy = before->y - c->y, l = sqrt(dx * dx + dy * dy);
        if (!(l > tiny))
            return pm_generation_fail(p->g, 3, PM_E_RANGE,
                                      "vertices %zu and %zu are the same, and -r cannot round "
                                      "between them",
                                      i ? i : p->count, i + 1);
        c->u[0] = dx / l;
        c->u[1] = dy / l;
        before = c;
    }
    return PM_OK;
}

static pm_status measure_turns(struct prism *p)
{
    for (size_t i = 0; i < p->count; i++) {
        struct corner *c = &p->corners[i];
        const double *next = p->corners[(i + 1) % p->count].u;
        double cosine = c->u[0] * next[0] + c->u[1] * next[1];
        if (1 + cosine <= tiny)
            return pm_generation_fail(p->g, 3, PM_E_RANGE,
                                      "the sides at vertex %zu lie upon each other, and -r "
                                      "cannot round there",
                                      i + 1);
        c->trim = cosine < 1 ? sqrt((1 - cosine) / (1 + cosine)) : 0;
        if (next[0] * c->u[1] - next[1] * c->u[0] < 0)
            c->trim = -c->trim;
    }
    return PM_OK;
}

static pm_status prepare_rounding(struct prism *p)
{
    if (p->radius > p->direction * p->shift[2])
        return pm_generation_fail(p->g, 0, PM_E_RANGE,
                                  "-r's radius of %g is more than the height of %g", p->radius,
                                  p->direction * p->shift[2]);
    p->radius *= p->direction;
    pm_status st = measure_sides(p);
    return st ? st : measure_turns(p);
}

/* ---- writing ---- */

static void start(const struct prism *p, const char *type, const char *part, size_t number,
                  size_t reals)
{
    pm_put(p->g, "%s %s %s.%s", p->modifier, type, p->name, part);
    if (number)
        pm_put(p->g, "%zu", number);
    pm_put(p->g, "\n0\n0\n%zu\n", reals);
}

static void put_xyz(const struct prism *p, double x, double y, double z)
{
    const double point[3] = {x, y, z};
    pm_put_point(p->g, point);
}

/* The centre of the circle that rounds a corner, level with the floor. */
static void center(const struct prism *p, const struct corner *c, double out[2])
{
    out[0] = c->x + p->radius * (c->trim * c->u[0] - c->u[1]);
    out[1] = c->y + p->radius * (c->trim * c->u[1] + c->u[0]);
}

static pm_status put_end(const struct prism *p, bool top)
{
    bool round = p->radius != 0;
    start(p, "polygon", top ? "t" : "b", 0, 3 * p->count);
    for (size_t i = 0; i < p->count; i++) {
        const struct corner *c = &p->corners[top ? p->count - 1 - i : i];
        double at[2] = {c->x, c->y};
        if (round)
            center(p, c, at);
        put_xyz(p, at[0] + (top ? p->shift[0] : 0), at[1] + (top ? p->shift[1] : 0),
                top ? p->shift[2] : 0);
    }
    return pm_generation_pass(p->g);
}

/* The rounded edges of one end: a sphere at each corner that turns outward, a cylinder along
 * each side. */
static pm_status put_rim(const struct prism *p, bool top)
{
    const double *s = p->shift;
    double z = top ? s[2] - p->radius : p->radius, radius = p->direction * p->radius;
    double from[2];
    pm_status st = PM_OK;
    center(p, &p->corners[p->count - 1], from);
    for (size_t i = 0; !st && i < p->count; i++) {
        double to[2], dx = top ? s[0] : 0, dy = top ? s[1] : 0;
        center(p, &p->corners[i], to);
        if (p->direction * p->corners[i].trim > 0) {
            start(p, "sphere", top ? "tc" : "bc", i + 1, 4);
            put_xyz(p, to[0] + dx, to[1] + dy, z);
            pm_put(p->g, "%.12g\n", radius);
        }
        start(p, "cylinder", top ? "te" : "be", i + 1, 7);
        put_xyz(p, from[0] + dx, from[1] + dy, z);
        put_xyz(p, to[0] + dx, to[1] + dy, z);
        pm_put(p->g, "%.12g\n", radius);
        memcpy(from, to, sizeof from);
        st = pm_generation_pass(p->g);
    }
    return st;
}

static pm_status put_side(const struct prism *p, size_t from, size_t to)
{
    const struct corner *a = &p->corners[from], *b = &p->corners[to];
    const double *s = p->shift;
    start(p, "polygon", "", from + 1, 12);
    put_xyz(p, a->x, a->y, 0);
    put_xyz(p, a->x + s[0], a->y + s[1], s[2]);
    put_xyz(p, b->x + s[0], b->y + s[1], s[2]);
    put_xyz(p, b->x, b->y, 0);
    return pm_generation_pass(p->g);
}

/* A side between two rounded corners, set back where the extrusion leans over it. */
static pm_status put_round_side(const struct prism *p, size_t from, size_t to)
{
    const struct corner *a = &p->corners[from], *b = &p->corners[to];
    const double *u = b->u, *s = p->shift;
    double r = p->radius, t[3] = {0};
    double sine = p->direction * (s[1] * u[0] - s[0] * u[1]) / p->length;
    if (fabs(sine) > tiny) {
        double cosine = sqrt(1 - sine * sine);
        t[0] = (cosine - 1) * u[1];
        t[1] = (1 - cosine) * u[0];
        t[2] = sine;
    }
    double ax = a->x + r * (t[0] - a->trim * u[0]), ay = a->y + r * (t[1] - a->trim * u[1]);
    double bx = b->x + r * (t[0] + b->trim * u[0]), by = b->y + r * (t[1] + b->trim * u[1]);
    start(p, "polygon", "", from + 1, 12);
    put_xyz(p, ax, ay, r * (t[2] + 1));
    put_xyz(p, ax + s[0], ay + s[1], s[2] + r * (t[2] - 1));
    put_xyz(p, bx + s[0], by + s[1], s[2] + r * (t[2] - 1));
    put_xyz(p, bx, by, r * (t[2] + 1));
    if (p->direction * b->trim >= 0) {
        double at[2];
        center(p, b, at);
        start(p, "cylinder", "e", from + 1, 7);
        put_xyz(p, at[0], at[1], r);
        put_xyz(p, at[0] + s[0], at[1] + s[1], s[2] - r);
        pm_put(p->g, "%.12g\n", p->direction * r);
    }
    return pm_generation_pass(p->g);
}

static pm_status put_prism(const struct prism *p)
{
    bool round = p->radius != 0;
    pm_status st = PM_OK;
    for (int top = 0; !st && p->ends && top < 2; top++)
        st = put_end(p, top);
    for (int top = 0; !st && p->ends && round && top < 2; top++)
        st = put_rim(p, top);
    size_t sides = p->count - p->open;
    for (size_t i = 0; !st && i < sides; i++) {
        size_t to = (i + 1) % p->count;
        st = round ? put_round_side(p, i, to) : put_side(p, i, to);
    }
    return st;
}

static pm_status read_prism(struct prism *p)
{
    pm_status st = pm_take_names(p->g, &p->modifier, &p->name);
    if (!st)
        st = read_outline(p);
    while (!st && pm_generation_word(p->g))
        st = take_option(p);
    if (!st && p->radius > tiny)
        st = prepare_rounding(p);
    else
        p->radius = 0;
    return st;
}

pm_status pm_genprism(pm_generation *g)
{
    struct prism p = {.g = g, .shift = {0, 0, 1}, .length = 1, .direction = 1, .ends = true};
    pm_status st = read_prism(&p);
    uint64_t n = p.count; /* two ends; for each side a face, two rims of two, an edge */
    if (!st && pm_generation_begin(g, 2 + 6 * n, 6 * n + (12 + 2 * 11 + 7) * n,
                                   strlen(p.modifier) + strlen(p.name))) {
        st = put_prism(&p);
        st = st ? st : pm_generation_end(g);
    }
    pm_bytes_clear(&p.memory);
    return st;
}
