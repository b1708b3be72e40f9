#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "generate/generation.h"

/* genblinds(1): venetian blinds of flat or curved slats, the curved ones cut in facets of at
 * most 3 degrees. Slats rise along z, are wide along y and deep along x. */

struct blinds {
    pm_generation *g;
    const char *modifier, *name;
    double depth, width, height, angle; /* the angle in radians */
    double radius;                      /* of curvature; above 0 up, below 0 down, 0 flat */
    int64_t slats;
    size_t facets;
};

static pm_status read_curvature(struct blinds *b)
{
    pm_generation *g = b->g;
    const char *option = pm_generation_word(g);
    if (!option)
        return PM_OK;
    bool down = strcmp(option, "+r") == 0;
    if (!down && strcmp(option, "-r") != 0)
        return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                  "'%.60s' is no option; they are -r radius and +r radius",
                                  option);
    g->at++;
    pm_status st = pm_take_real(g, "the radius of curvature", &b->radius);
    if (st)
        return st;
    b->radius = down ? -b->radius : b->radius;
    if (b->radius != 0 && fabs(b->radius) < b->depth / 2)
        return pm_generation_fail(
            g, g->at - 1, PM_E_RANGE,
            "a slat %g deep cannot be curved with a radius of %g; it must "
            "be at least half the depth",
            b->depth, fabs(b->radius));
    if (pm_generation_word(g))
        return pm_generation_fail(g, g->at, PM_E_SYNTAX,
                                  "'%.60s' comes after the last argument; take it out",
                                  pm_generation_word(g));
    return PM_OK;
}

static pm_status read_blinds(struct blinds *b)
{
    pm_generation *g = b->g;
    pm_status st = pm_take_names(g, &b->modifier, &b->name);
    if (!st)
        st = pm_take_real(g, "the depth", &b->depth);
    if (!st && b->depth <= 0)
        st = pm_generation_fail(g, 3, PM_E_RANGE, "the depth of a slat must be above 0");
    if (!st)
        st = pm_take_real(g, "the width", &b->width);
    if (!st)
        st = pm_take_real(g, "the height", &b->height);
    if (!st)
        st = pm_take_integer(g, "the number of slats", 1, INT32_MAX, &b->slats);
    if (!st)
        st = pm_take_real(g, "the angle", &b->angle);
    b->angle *= PM_PI / 180;
    return st ? st : read_curvature(b);
}

/* An edge of a slat, along y. */
struct edge {
    double x, z;
};

/* The slat's profile: facets + 1 edges. */
static struct edge edge_at(const struct blinds *b, size_t index)
{
    if (b->radius == 0) {
        double s, c;
        pm_sincos(b->angle, &s, &c);
        return (struct edge){(double)index * b->depth * c, (double)index * b->depth * s};
    }
    /* Along the arc, whose middle is level when the angle is 0, from the edge at the origin. */
    double r = fabs(b->radius), theta = 2 * pm_asin(b->depth / (2 * r));
    double begin = (PM_PI - theta) / 2 - b->angle;
    double step = theta / (double)b->facets * (double)index;
    double s0, c0, s, c;
    if (b->radius < 0) {
        pm_sincos(begin, &s0, &c0);
        pm_sincos(begin + step, &s, &c);
        return (struct edge){r * (c0 - c), r * (s - s0)};
    }
    pm_sincos(begin + theta, &s0, &c0);
    pm_sincos(begin + theta - step, &s, &c);
    return (struct edge){r * (c - c0), r * (s0 - s)};
}

static size_t facet_count(const struct blinds *b)
{
    static const double most_degrees = 3;
    if (b->radius == 0)
        return 1;
    double theta = 2 * pm_asin(b->depth / (2 * fabs(b->radius)));
    size_t count = (size_t)(theta / (PM_PI / 180 * most_degrees) + 0.99999);
    return count ? count : 1;
}

static pm_status put_slat(const struct blinds *b, int64_t slat)
{
    double rise = b->height * ((double)slat - 0.5) / (double)b->slats;
    for (size_t k = 0; k < b->facets; k++) {
        struct edge from = edge_at(b, k), to = edge_at(b, k + 1);
        pm_put(b->g, "%s polygon %s.%lld.%zu\n0\n0\n12\n", b->modifier, b->name,
               (long long)slat, k);
        pm_put_point(b->g, (const double[]){from.x, 0, from.z + rise});
        pm_put_point(b->g, (const double[]){from.x, b->width, from.z + rise});
        pm_put_point(b->g, (const double[]){to.x, b->width, to.z + rise});
        pm_put_point(b->g, (const double[]){to.x, 0, to.z + rise});
        pm_status st = pm_generation_pass(b->g);
        if (st)
            return st;
    }
    return PM_OK;
}

pm_status pm_genblinds(pm_generation *g)
{
    struct blinds b = {.g = g};
    pm_status st = read_blinds(&b);
    if (st)
        return st;
    b.facets = facet_count(&b);
    uint64_t count = (uint64_t)b.slats * b.facets;
    if (!pm_generation_begin(g, count, 12 * count, strlen(b.modifier) + strlen(b.name)))
        return PM_OK;
    for (int64_t slat = 1; !st && slat <= b.slats; slat++)
        st = put_slat(&b, slat);
    return st ? st : pm_generation_end(g);
}
