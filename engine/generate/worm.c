#include <math.h>
#include <string.h>

#include "generate/functions.h"

/* genworm(1): a string of varying thickness along x(t), y(t), z(t) with radius r(t), t from 0
 * to 1: spheres, joined by the cones and cylinders that touch them. */

static const double tiny = 1e-6;

struct worm {
    pm_generation *g;
    const char *modifier, *name;
    pm_functions functions;
    int64_t segments;
};

struct bead {
    double p[3], r;
};

static pm_status read_worm(struct worm *w)
{
    pm_generation *g = w->g;
    pm_status st = pm_take_names(g, &w->modifier, &w->name);
    if (!st && g->request->count < 8)
        st = pm_generation_fail(g, g->request->count - 1, PM_E_SYNTAX,
                                "takes a modifier, a name, x(t), y(t), z(t), r(t) and the "
                                "number of segments");
    g->at = 8;
    if (!st)
        st = pm_functions_options(&w->functions, "", NULL, NULL);
    if (!st)
        st = pm_functions_compile(&w->functions, 3, 4, 0);
    return st ? st : pm_functions_count(&w->functions, 7, "segments", &w->segments);
}

static pm_status bead_at(const struct worm *w, int64_t index, struct bead *out)
{
    double values[4] = {0};
    pm_status st = pm_functions_along(&w->functions, index, w->segments, values);
    memcpy(out->p, values, sizeof out->p);
    out->r = values[3];
    return st;
}

static void start(const struct worm *w, const char *type, char part, int64_t index, int reals)
{
    pm_put(w->g, "%s %s %s.%c%lld\n0\n0\n%d\n", w->modifier, type, w->name, part,
           (long long)index, reals);
}

/* The cone touches both spheres where its side leaves them, so it is moved along the axis and
 * is narrower than they are. */
static void put_cone(const struct worm *w, int64_t index, const struct bead *a,
                     const struct bead *b)
{
    double along[3], square = 0, from[3], to[3];
    for (int i = 0; i < 3; i++) {
        along[i] = b->p[i] - a->p[i];
        square += along[i] * along[i];
    }
    double f = (a->r - b->r) / square, rest = 1 - (a->r - b->r) * f;
    double narrower = rest <= 0 ? 0 : sqrt(rest);
    for (int i = 0; i < 3; i++) {
        from[i] = a->p[i] + f * a->r * along[i];
        to[i] = b->p[i] + f * b->r * along[i];
    }
    start(w, "cone", 'c', index, 8);
    pm_put_point(w->g, from);
    pm_put_point(w->g, to);
    pm_put_real(w->g, narrower * a->r);
    pm_put_real(w->g, narrower * b->r);
    pm_put(w->g, "\n");
}

static void put_joint(const struct worm *w, int64_t index, const struct bead *a,
                      const struct bead *b)
{
    if (fabs(a->r - b->r) > tiny) {
        put_cone(w, index, a, b);
        return;
    }
    start(w, "cylinder", 'c', index, 7);
    pm_put_point(w->g, a->p);
    pm_put_point(w->g, b->p);
    pm_put_real(w->g, b->r);
    pm_put(w->g, "\n");
}

static pm_status put_worm(const struct worm *w)
{
    struct bead last = {0}, bead;
    pm_status st = PM_OK;
    for (int64_t i = 0; !st && i <= w->segments; i++) {
        st = bead_at(w, i, &bead);
        if (st)
            break;
        if (i)
            put_joint(w, i, &last, &bead);
        start(w, "sphere", 's', i, 4);
        for (int k = 0; k < 3; k++)
            pm_put_real(w->g, bead.p[k]);
        pm_put_real(w->g, bead.r);
        pm_put(w->g, "\n");
        last = bead;
        st = pm_generation_pass(w->g);
    }
    return st;
}

pm_status pm_genworm(pm_generation *g)
{
    struct worm w = {.g = g, .functions = {.g = g, .parameters = "t", .parameter_count = 1}};
    pm_status st = read_worm(&w);
    uint64_t count = (uint64_t)w.segments;
    if (!st && pm_generation_begin(g, 2 * count + 1, 12 * count + 4,
                                   strlen(w.modifier) + strlen(w.name))) {
        st = put_worm(&w);
        st = st ? st : pm_generation_end(g);
    }
    pm_functions_clear(&w.functions);
    return st;
}
