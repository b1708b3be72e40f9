#include <math.h>
#include <string.h>

#include "generate/functions.h"

/* genrev(1): a surface of revolution about z, from z(t) and r(t) for t from 0 to 1, in segments
 * that are cones, cylinders and rings. It faces outward where z rises. */

static const double tiny = 1e-9;

struct rev {
    pm_generation *g;
    const char *modifier, *name;
    pm_functions functions;
    int64_t segments;
    bool smooth;
};

/* A point of the profile, and the unit normal (of z and of r) of the segment behind it. */
struct point {
    double z, r, nz, nr;
};

static pm_status take_switch(void *context, const char *option, bool *known)
{
    struct rev *v = context;
    *known = strcmp(option, "-s") == 0;
    v->smooth |= *known;
    return PM_OK;
}

static pm_status read_rev(struct rev *v)
{
    pm_generation *g = v->g;
    pm_status st = pm_take_names(g, &v->modifier, &v->name);
    if (!st && g->request->count < 6)
        st = pm_generation_fail(g, g->request->count - 1, PM_E_SYNTAX,
                                "takes a modifier, a name, z(t), r(t) and the number of "
                                "segments");
    g->at = 6;
    if (!st)
        st = pm_functions_options(&v->functions, "-s, ", take_switch, v);
    if (!st)
        st = pm_functions_compile(&v->functions, 3, 2, 0);
    return st ? st : pm_functions_count(&v->functions, 5, "segments", &v->segments);
}

static pm_status point_at(const struct rev *v, int64_t index, struct point *out)
{
    double zr[2] = {0};
    pm_status st = pm_functions_along(&v->functions, index, v->segments, zr);
    *out = (struct point){.z = zr[0], .r = zr[1]};
    return st;
}

static void face(struct point *from, const struct point *to)
{
    double dz = from->r - to->r, dr = to->z - from->z, length = sqrt(dz * dz + dr * dr);
    from->nz = length > 0 ? dz / length : 0;
    from->nr = length > 0 ? dr / length : 0;
}

/* rev.cal turns the normal to what z and r give by these two lines. `before` is the segment in
 * front of this one, `after` the one behind, whose normals are 0 past the ends. */
static void put_texture(const struct rev *v, const struct point *before,
                        const struct point *from, const struct point *to)
{
    pm_generation *g = v->g;
    double dz = to->z - from->z, dr = to->r - from->r;
    double lines[4] = {0, dr < 0 ? 1 : -1, 0, dz > 0 ? 1 : -1};
    if (fabs(dz) > tiny) {
        lines[0] = (to->nz - before->nz) / dz;
        lines[1] = before->nz - lines[0] * from->z;
    }
    if (fabs(dr) > tiny) {
        lines[2] = (to->nr - before->nr) / dr;
        lines[3] = before->nr - lines[2] * from->r;
    }
    pm_put(g, "%s texfunc Phong\n4 rev_dx rev_dy rev_dz rev.cal\n0\n4", v->modifier);
    for (int i = 0; i < 4; i++)
        pm_put_real(g, lines[i]);
    pm_put(g, "\n");
}

static void put_surface(const struct rev *v, const char *type, int64_t index,
                        const double *reals, size_t count)
{
    pm_put(v->g, "%s %s %s.%lld\n0\n0\n%zu\n", v->smooth ? "Phong" : v->modifier, type, v->name,
           (long long)index, count);
    for (size_t i = 0; i < count; i++)
        pm_put_real(v->g, reals[i]);
    pm_put(v->g, "\n");
}

static pm_status put_segment(const struct rev *v, int64_t index, const struct point *before,
                             const struct point *from, const struct point *to)
{
    double dz = to->z - from->z, dr = to->r - from->r;
    bool rises = fabs(dz) > tiny, widens = fabs(dr) > tiny;
    if (!rises && !widens)
        return PM_OK;
    if (v->smooth)
        put_texture(v, before, from, to);
    if (!widens)
        put_surface(v, dz < 0 ? "tube" : "cylinder", index,
                    (double[]){0, 0, from->z, 0, 0, to->z, from->r}, 7);
    else if (!rises)
        put_surface(v, "ring", index,
                    (double[]){0, 0, to->z, 0, 0, dr < 0 ? 1 : -1, from->r, to->r}, 8);
    else
        put_surface(v, dz < 0 ? "cup" : "cone", index,
                    (double[]){0, 0, from->z, 0, 0, to->z, from->r, to->r}, 8);
    return pm_generation_pass(v->g);
}

static pm_status put_rev(const struct rev *v)
{
    struct point before = {0}, from, to, next = {0};
    pm_status st = point_at(v, 0, &from);
    if (!st)
        st = point_at(v, 1, &to);
    if (!st)
        face(&from, &to);
    for (int64_t i = 1; !st && i <= v->segments; i++) {
        if (i < v->segments) {
            st = point_at(v, i + 1, &next);
            face(&to, &next);
        }
        if (!st)
            st = put_segment(v, i, &before, &from, &to);
        before = from;
        from = to;
        to = next;
    }
    return st;
}

pm_status pm_genrev(pm_generation *g)
{
    struct rev v = {.g = g, .functions = {.g = g, .parameters = "t", .parameter_count = 1}};
    pm_status st = read_rev(&v);
    uint64_t count = (uint64_t)v.segments;
    if (!st &&
        pm_generation_begin(g, v.smooth ? 2 * count : count, v.smooth ? 12 * count : 8 * count,
                            strlen(v.modifier) + strlen(v.name))) {
        st = put_rev(&v);
        st = st ? st : pm_generation_end(g);
    }
    pm_functions_clear(&v.functions);
    return st;
}
