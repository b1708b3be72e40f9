#include <math.h>
#include <string.h>

#include "base/maths.h"
#include "generate/generation.h"

/* genbox(1): a parallelepiped with a corner at the origin, its edges sharp, beveled or rounded.
 *
 * A vertex is a number: bits 0 to 2 choose the high end along x, y and z, bits 3 to 5 pull it
 * in by the bevel along that axis. Names of surfaces list their vertices as characters. */

static const char letters[] =
    "0123456789._ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

typedef uint8_t quad[4];

static const quad sharp_sides[6] = {{01, 05, 04, 00}, {04, 06, 02, 00}, {02, 03, 01, 00},
                                    {03, 02, 06, 07}, {05, 01, 03, 07}, {06, 04, 05, 07}};
static const quad inner_sides[6] = {{051, 055, 054, 050}, {064, 066, 062, 060},
                                    {032, 033, 031, 030}, {053, 052, 056, 057},
                                    {065, 061, 063, 067}, {036, 034, 035, 037}};
static const quad bevels[12] = {
    {031, 051, 050, 030}, {060, 062, 032, 030}, {050, 054, 064, 060}, {034, 036, 066, 064},
    {037, 057, 056, 036}, {052, 062, 066, 056}, {052, 053, 033, 032}, {057, 067, 063, 053},
    {061, 031, 033, 063}, {065, 067, 037, 035}, {055, 051, 061, 065}, {034, 054, 055, 035}};
static const uint8_t corners[8][3] = {{030, 050, 060}, {051, 031, 061}, {032, 062, 052},
                                      {064, 054, 034}, {036, 056, 066}, {065, 035, 055},
                                      {053, 063, 033}, {037, 067, 057}};
static const uint8_t edges[12][2] = {{070, 071}, {070, 074}, {070, 072}, {073, 071},
                                     {073, 072}, {073, 077}, {075, 071}, {075, 074},
                                     {075, 077}, {076, 072}, {076, 074}, {076, 077}};

struct box {
    pm_generation *g;
    const char *modifier, *name;
    double size[3], bevel;
    bool inverted, rounded, smooth;
    int64_t segments; /* of a quarter turn, as asked for */
    unsigned level;   /* 2^level segments; 0 for cylinders and spheres */
    uint64_t count;   /* faces made of segments, so far */
};

static void vertex(const struct box *b, unsigned v, double p[3])
{
    for (int i = 0; i < 3; i++, v >>= 1) {
        double inset = v & 010 ? b->bevel : 0;
        p[i] = (v & 01) != b->inverted ? b->size[i] - inset : inset;
    }
}

/* ---- sharp and beveled boxes, and those rounded by cylinders and spheres ---- */

static pm_status put_vertices(const struct box *b, const char *type, const uint8_t *v,
                              size_t count, bool radius)
{
    pm_generation *g = b->g;
    size_t reals = 3 * count + radius;
    pm_put(g, "%s %s %s.", b->modifier, type, b->name);
    for (size_t i = 0; i < count; i++)
        pm_put(g, "%c", letters[v[i]]);
    pm_put(g, "\n0\n0\n%zu\n", reals);
    for (size_t i = 0; i < count; i++) {
        double p[3];
        vertex(b, v[i], p);
        pm_put_point(g, p);
    }
    if (radius)
        pm_put_real(g, b->bevel);
    pm_put(g, "\n");
    return pm_generation_pass(g);
}

static pm_status put_quads(const struct box *b, const quad *quads, size_t count)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < count; i++)
        st = put_vertices(b, "polygon", quads[i], 4, false);
    return st;
}

static pm_status put_bevels(const struct box *b)
{
    pm_status st = put_quads(b, bevels, 12);
    for (size_t i = 0; !st && i < 8; i++)
        st = put_vertices(b, "polygon", corners[i], 3, false);
    return st;
}

static pm_status put_round(const struct box *b)
{
    pm_status st = PM_OK;
    for (size_t i = 0; !st && i < 12; i++)
        st = put_vertices(b, "cylinder", edges[i], 2, true);
    for (uint8_t v = 070; !st && v <= 077; v++)
        st = put_vertices(b, "sphere", &v, 1, true);
    return st;
}

/* ---- boxes whose rounding is cut into polygons ---- */

/* Normals in single precision, as Radiance's meshes have them. */
struct corner {
    double p[3];
    float normal[3];
};

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = a[j] * b[k] - a[k] * b[j];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double normalize(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; length > 0 && i < 3; i++)
        v[i] *= 1 / length;
    return length;
}

/* Twice the area; the unit normal, from a corner's two edges. */
static double face_normal(const struct corner *c, size_t count, double out[3])
{
    double sum[3] = {0};
    for (size_t i = 2; i < count; i++) {
        double a[3], b[3], n[3];
        for (int j = 0; j < 3; j++) {
            a[j] = c[i - 1].p[j] - c[0].p[j];
            b[j] = c[i].p[j] - c[0].p[j];
        }
        cross(a, b, n);
        for (int j = 0; j < 3; j++)
            sum[j] += n[j];
    }
    double area = normalize(sum);
    memcpy(out, sum, sizeof sum);
    return area;
}

/* Whether interpolated normals would differ from the face's own: Radiance smooths from 0.18
 * degrees. */
static bool is_curved(const struct corner *c, size_t count)
{
    static const double agreeing = 0.999995;
    double normal[3];
    bool curved = false;
    if (face_normal(c, count, normal) == 0)
        return false;
    for (size_t i = 0; i < count; i++)
        curved |= (double)c[i].normal[0] * normal[0] + (double)c[i].normal[1] * normal[1] +
                      (double)c[i].normal[2] * normal[2] <
                  agreeing;
    return curved;
}

static pm_status put_flat(struct box *b, const struct corner *c, size_t count)
{
    static const double degenerate = 2e-12; /* twice the area */
    double normal[3];
    if (face_normal(c, count, normal) <= degenerate)
        return PM_OK;
    pm_put(b->g, "%s polygon %s.%llu\n0\n0\n%zu\n", b->modifier, b->name,
           (unsigned long long)++b->count, 3 * count);
    for (size_t i = 0; i < count; i++)
        pm_put_point(b->g, c[i].p);
    return pm_generation_pass(b->g);
}

/* The linear function of two coordinates that takes the values n at three points, as
 * coefficients of u, v and 1. False if the points lie on a line. */
static bool interpolate(const struct corner c[3], int axis, int component, double out[3])
{
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double au = c[0].p[u] - c[2].p[u], av = c[0].p[v] - c[2].p[v];
    double bu = c[1].p[u] - c[2].p[u], bv = c[1].p[v] - c[2].p[v];
    double cn = (double)c[2].normal[component];
    double an = (double)c[0].normal[component] - cn;
    double bn = (double)c[1].normal[component] - cn;
    double det = au * bv - av * bu;
    if (fabs(det) <= 1e-12)
        return false;
    out[0] = (an * bv - bn * av) / det;
    out[1] = (bn * au - an * bu) / det;
    out[2] = cn - out[0] * c[2].p[u] - out[1] * c[2].p[v];
    return true;
}

static pm_status put_smooth(struct box *b, const struct corner c[3])
{
    /* From the middle vertex, as Radiance does: where two axes are equally good, rounding
     * decides. */
    double from[3], to[3], n[3], lines[3][3];
    for (int i = 0; i < 3; i++) {
        from[i] = c[0].p[i] - c[1].p[i];
        to[i] = c[2].p[i] - c[1].p[i];
    }
    cross(from, to, n);
    int axis = n[1] * n[1] > n[0] * n[0];
    axis = n[2] * n[2] > n[axis] * n[axis] ? 2 : axis;
    for (int i = 0; i < 3; i++)
        if (!interpolate(c, axis, i, lines[i]))
            return PM_OK;
    pm_put(b->g, "%s texfunc T-nor\n4 dx dy dz tmesh.cal\n0\n10 %d\n", b->modifier, axis);
    for (int i = 0; i < 3; i++)
        pm_put(b->g, "%.8f %.8f %.8f\n", lines[i][0], lines[i][1], lines[i][2]);
    pm_put(b->g, "T-nor polygon %s.%llu\n0\n0\n9\n", b->name, (unsigned long long)++b->count);
    for (int i = 0; i < 3; i++)
        pm_put_point(b->g, c[i].p);
    return pm_generation_pass(b->g);
}

/* The quarter cylinder about an edge, cut in 2^level strips: the ends of strip `index`. */
static void strip(const struct box *b, const uint8_t edge[2], uint64_t index,
                  struct corner out[4])
{
    /* The two axes across an edge, in the order in which the quarter turns from one to the
     * other. */
    static const int across[3][2] = {{2, 1}, {0, 2}, {1, 0}};
    int along = (edge[0] ^ edge[1]) == 01 ? 0 : (edge[0] ^ edge[1]) == 02 ? 1 : 2;
    double sign = b->inverted ? -1 : 1, ends[2][3];
    vertex(b, edge[0], ends[0]);
    vertex(b, edge[1], ends[1]);
    for (int i = 0; i < 4; i++) {
        int end = i == 1 || i == 2;
        double turn = 0.5 * PM_PI * (double)(index + (i >= 2)) / (double)(1ULL << b->level);
        double weight[2];
        pm_sincos(turn, &weight[1], &weight[0]);
        memcpy(out[i].p, ends[end], sizeof out[i].p);
        memset(out[i].normal, 0, sizeof out[i].normal);
        for (int j = 0; j < 2; j++) {
            int axis = across[along][j];
            double outward = ends[1][axis] < 0.5 * b->size[axis] ? -1 : 1;
            out[i].p[axis] += b->bevel * outward * weight[j];
            out[i].normal[axis] = (float)(sign * outward * weight[j]);
        }
    }
}

/* The eighth of a sphere about a vertex, as a triangle of directions. */
static void ball(const struct box *b, unsigned v, double directions[3][3])
{
    memset(directions, 0, 9 * sizeof(double));
    for (int i = 0; i < 3; i++)
        directions[i][i] = ((v >> i & 01) != b->inverted) ? 1 : -1;
    /* Its triangle must face outward at each of the eight corners. */
    if (v == 070 || v == 073 || v == 075 || v == 076) {
        double swap[3];
        memcpy(swap, directions[0], sizeof swap);
        memcpy(directions[0], directions[1], sizeof swap);
        memcpy(directions[1], swap, sizeof swap);
    }
}

typedef pm_status put_triangle(struct box *b, const struct corner c[3]);

static pm_status put_flat_triangle(struct box *b, const struct corner c[3])
{
    return b->smooth && is_curved(c, 3) ? PM_OK : put_flat(b, c, 3);
}

static pm_status put_smooth_triangle(struct box *b, const struct corner c[3])
{
    return is_curved(c, 3) ? put_smooth(b, c) : PM_OK;
}

/* Cuts a spherical triangle in four, `levels` times (at most 31 deep). */
static pm_status subdivide(struct box *b, const double center[3], const double d[3][3],
                           unsigned levels, bool backwards, put_triangle *put)
{
    if (!levels) {
        struct corner c[3];
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                c[i].p[j] = center[j] + b->bevel * d[i][j];
                c[i].normal[j] = (float)(b->inverted ? -d[i][j] : d[i][j]);
            }
        }
        return put(b, c);
    }
    double m[3][3]; /* between 0 and 1, 1 and 2, 2 and 0 */
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            m[i][j] = d[i][j] + d[(i + 1) % 3][j];
        normalize(m[i]);
    }
    pm_status st = PM_OK;
    for (int k = 0; !st && k < 4; k++) {
        int i = backwards ? 3 - k : k;
        double part[3][3];
        memcpy(part[0], i < 3 ? d[i] : m[0], sizeof part[0]);
        memcpy(part[1], i < 3 ? m[i] : m[1], sizeof part[1]);
        memcpy(part[2], i < 3 ? m[(i + 2) % 3] : m[2], sizeof part[2]);
        st = subdivide(b, center, (const double(*)[3])part, levels - 1, backwards, put);
    }
    return st;
}

static pm_status put_balls(struct box *b, bool backwards, put_triangle *put)
{
    pm_status st = PM_OK;
    for (unsigned i = 0; !st && i < 8; i++) {
        unsigned v = 070 + (backwards ? 7 - i : i);
        double center[3], directions[3][3];
        vertex(b, v, center);
        ball(b, v, directions);
        st = subdivide(b, center, (const double(*)[3])directions, b->level, backwards, put);
    }
    return st;
}

static pm_status put_strip(struct box *b, const struct corner c[4], bool smooth_ones)
{
    bool smooth = b->smooth && is_curved(c, 4);
    if (smooth != smooth_ones)
        return PM_OK;
    if (!smooth)
        return put_flat(b, c, 4);
    /* Radiance cuts along the diagonal that its projection to the main axis leads to. */
    double n[3];
    face_normal(c, 4, n);
    int axis = fabs(n[1]) > fabs(n[0]);
    axis = fabs(n[2]) > fabs(n[axis]) ? 2 : axis;
    int first = n[axis] > 0;
    const struct corner halves[2][3] = {{c[first], c[first + 1], c[first + 2]},
                                        {c[first + 2], c[(first + 3) % 4], c[first]}};
    pm_status st = put_smooth(b, halves[0]);
    return st ? st : put_smooth(b, halves[1]);
}

static pm_status put_strips(struct box *b, bool smooth_ones)
{
    pm_status st = PM_OK;
    for (unsigned i = 12; !st && i-- > 0;) {
        for (uint64_t k = 1ULL << b->level; !st && k-- > 0;) {
            struct corner c[4];
            strip(b, edges[i], k, c);
            st = put_strip(b, c, smooth_ones);
        }
    }
    return st;
}

/* In the order of Radiance's genbox, which makes the faces and then writes the last first, the
 * smooth ones before the flat. */
static pm_status put_segments(struct box *b)
{
    pm_status st = PM_OK;
    if (b->smooth)
        st = put_strips(b, true);
    if (!st && b->smooth)
        st = put_balls(b, false, put_smooth_triangle);
    if (!st)
        st = put_balls(b, true, put_flat_triangle);
    if (!st)
        st = put_strips(b, false);
    for (unsigned i = 6; !st && i-- > 0;) {
        struct corner c[4] = {0};
        for (int k = 0; k < 4; k++)
            vertex(b, inner_sides[i][k], c[k].p);
        st = put_flat(b, c, 4);
    }
    return st;
}

/* ---- the command ---- */

static pm_status take_bevel(struct box *b, bool rounded)
{
    b->rounded |= rounded;
    pm_status st = pm_take_real(b->g, rounded ? "-r's radius" : "-b's bevel", &b->bevel);
    if (!st && b->bevel <= 0)
        return pm_generation_fail(b->g, b->g->at - 1, PM_E_RANGE,
                                  "-%c takes a length above 0; leave it out for sharp edges",
                                  rounded ? 'r' : 'b');
    return st;
}

static pm_status take_option(struct box *b)
{
    const char *option = pm_generation_word(b->g);
    b->g->at++;
    if (strcmp(option, "-b") == 0 || strcmp(option, "-r") == 0)
        return take_bevel(b, option[1] == 'r');
    if (strcmp(option, "-n") == 0)
        return pm_take_integer(b->g, "-n's segments", 1, INT32_MAX, &b->segments);
    if (strcmp(option, "-i") == 0)
        b->inverted = true;
    else if (strcmp(option, "-s") == 0)
        b->smooth = true;
    else if (strcmp(option, "-o") == 0)
        return pm_generation_fail(b->g, b->g->at - 1, PM_E_UNSUPPORTED,
                                  "-o makes a Wavefront .obj, which cannot stand in a scene; "
                                  "leave it out, or make a mesh of it beforehand");
    else
        return pm_generation_fail(b->g, b->g->at - 1, PM_E_SYNTAX,
                                  "'%.60s' is no option; they are -i, -b bevel, -r radius, "
                                  "-n segments, -s",
                                  option);
    return PM_OK;
}

static pm_status read_box(struct box *b)
{
    static const char *const what[] = {"xsize", "ysize", "zsize"};
    pm_status st = pm_take_names(b->g, &b->modifier, &b->name);
    for (int i = 0; !st && i < 3; i++) {
        st = pm_take_real(b->g, what[i], &b->size[i]);
        if (!st && b->size[i] <= 0)
            st = pm_generation_fail(b->g, b->g->at - 1, PM_E_RANGE,
                                    "%s is %s; a box's sizes are above 0", what[i],
                                    b->g->request->words[b->g->at - 1]);
    }
    while (!st && pm_generation_word(b->g))
        st = take_option(b);
    /* A cylinder cannot face inward here, so an inverted box is cut in segments. */
    if (b->inverted && b->segments == 1)
        b->segments = 32;
    for (int64_t rest = b->segments - 1; b->rounded && rest > 0; rest >>= 1)
        b->level++;
    return st;
}

static bool begin(const struct box *b)
{
    uint64_t primitives = 6, reals = 6 * 12;
    if (b->bevel > 0 && !b->rounded) {
        primitives += 12 + 8;
        reals += 12 * 12 + 8 * 9;
    } else if (b->rounded && b->level < 2) {
        primitives += 12 + 8;
        reals += 12 * 7 + 8 * 4;
    } else if (b->rounded) {
        uint64_t triangles = 12 * 2 * (1ULL << b->level) + 8 * (1ULL << 2 * b->level);
        if (b->level >= 31)
            triangles = UINT64_MAX / 64;
        primitives += triangles * (b->smooth ? 2 : 1);
        reals += triangles * (b->smooth ? 19 : 9);
    }
    return pm_generation_begin(b->g, primitives, reals, strlen(b->modifier) + strlen(b->name));
}

pm_status pm_genbox(pm_generation *g)
{
    struct box box = {.g = g, .segments = 1}, *b = &box;
    pm_status st = read_box(b);
    if (st || !begin(b))
        return st;
    if (b->rounded && b->level >= 2)
        st = put_segments(b);
    else
        st = put_quads(b, b->bevel > 0 ? inner_sides : sharp_sides, 6);
    if (!st && b->bevel > 0 && !b->rounded)
        st = put_bevels(b);
    if (!st && b->rounded && b->level < 2)
        st = put_round(b);
    return st ? st : pm_generation_end(g);
}
