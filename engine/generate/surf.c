#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "generate/functions.h"

/* gensurf(1): a surface x(s,t), y(s,t), z(s,t) over the unit square in m by n patches, each two
 * triangles, or one quadrilateral where they are coplanar. Smoothed, each patch has a texture
 * that interpolates the normals at its corners (surf.cal). */

static const double tiny = 1e-6;

struct surf {
    pm_generation *g;
    const char *modifier, *name;
    pm_functions functions;
    int64_t m, n;
    bool smooth;
    /* Recorded points, s varying fastest, instead of z(s,t) or of all three. */
    double *data;
    bool triplets, border; /* border: the points lie on the square's edge, too */
    int64_t data_m, data_n;
    uint64_t count;
};

struct point {
    double p[3], normal[3];
    bool valid;
};

/* ---- recorded points ---- */

static bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* Reads at most `most` numbers; *count is how many there are. */
static pm_status read_numbers(struct surf *s, pm_generate_file file, double *out, uint64_t most,
                              uint64_t *count)
{
    const char *at = file.data, *end = at + file.size;
    double ignored;
    for (*count = 0;; ++*count) {
        while (at < end && is_space(*at))
            at++;
        const char *word = at;
        while (at < end && !is_space(*at))
            at++;
        if (at == word)
            return PM_OK;
        if (pm_number_real(word, (size_t)(at - word), *count < most ? &out[*count] : &ignored))
            return pm_generation_fail(
                s->g, 5, PM_E_SYNTAX, "number %llu of the file is '%.*s', which is none",
                (unsigned long long)*count + 1, (int)(at - word < 40 ? at - word : 40), word);
    }
}

static pm_status read_data(struct surf *s, pm_generate_file file)
{
    uint64_t size = s->triplets ? 3 : 1, count = 0;
    uint64_t inner = (uint64_t)s->m * (uint64_t)s->n * size;
    uint64_t whole = ((uint64_t)s->m + 1) * ((uint64_t)s->n + 1) * size;
    /* A number is a digit and a blank at least. */
    if (inner > file.size)
        return pm_generation_fail(s->g, 5, PM_E_SYNTAX,
                                  "the file is too short for %llu numbers",
                                  (unsigned long long)inner);
    s->data = calloc(whole, sizeof *s->data);
    if (!s->data)
        return pm_error_set(s->g->err, PM_E_MEMORY, "not enough memory for a surface's points");
    pm_status st = read_numbers(s, file, s->data, whole, &count);
    if (!st && count != inner && count != whole)
        st = pm_generation_fail(
            s->g, 5, PM_E_SYNTAX,
            "the file holds %llu numbers; for %lld by %lld patches it should "
            "hold %llu, or %llu without the border",
            (unsigned long long)count, (long long)s->m, (long long)s->n,
            (unsigned long long)whole, (unsigned long long)inner);
    s->border = count == whole;
    s->data_m = s->m + s->border;
    s->data_n = s->n + s->border;
    if (!st && (s->data_m < 2 || s->data_n < 2))
        st = pm_generation_fail(s->g, 5, PM_E_RANGE,
                                "recorded points need at least 2 in each direction");
    return st;
}

/* The cell of a coordinate, and the position in it, which leaves 0 .. 1 past the edges. */
static int64_t cell_of(const struct surf *s, double x, int64_t count, double *position)
{
    double at = s->border ? x * (double)(count - 1) : x * (double)count - 0.5;
    int64_t cell = (int64_t)at;
    cell = cell < 0 ? 0 : cell > count - 2 ? count - 2 : cell;
    *position = at - (double)cell;
    return cell;
}

/* Bilinear between the recorded points. */
static double data_value(const struct surf *s, const double st[2], int component)
{
    double u, v;
    int64_t i = cell_of(s, st[0], s->data_m, &u), j = cell_of(s, st[1], s->data_n, &v);
    int64_t size = s->triplets ? 3 : 1;
    const double *low = s->data + size * (j * s->data_m + i) + (s->triplets ? component : 0);
    const double *high = low + size * s->data_m;
    return (1 - v) * ((1 - u) * low[0] + u * low[size]) +
           v * ((1 - u) * high[0] + u * high[size]);
}

/* ---- arguments ---- */

static pm_status take_switch(void *context, const char *option, bool *known)
{
    struct surf *s = context;
    *known = strcmp(option, "-s") == 0 || strcmp(option, "-o") == 0;
    if (strcmp(option, "-o") == 0)
        return pm_generation_fail(s->g, s->g->at - 1, PM_E_UNSUPPORTED,
                                  "-o makes a Wavefront .obj, which cannot stand in a scene; "
                                  "leave it out, or make a mesh of it beforehand");
    s->smooth |= *known;
    return PM_OK;
}

/* The file of recorded points, if z names one. */
static pm_status find_data(struct surf *s, pm_generate_file *file)
{
    const pm_generate_request *request = s->g->request;
    const char *const *words = request->words;
    *file = (pm_generate_file){0};
    if (strcmp(words[5], "-") == 0)
        return pm_generation_fail(
            s->g, 5, PM_E_UNSUPPORTED,
            "there is no standard input to read points from; name a file");
    if (request->find)
        *file = request->find(request->find_context, words[5]);
    s->triplets =
        file->data && strcmp(words[5], words[3]) == 0 && strcmp(words[5], words[4]) == 0;
    return PM_OK;
}

static pm_status read_surf(struct surf *s)
{
    pm_generation *g = s->g;
    pm_generate_file file = {0};
    pm_status st = pm_take_names(g, &s->modifier, &s->name);
    if (!st && g->request->count < 8)
        st = pm_generation_fail(g, g->request->count - 1, PM_E_SYNTAX,
                                "takes a modifier, a name, x(s,t), y(s,t), z(s,t), m and n");
    g->at = 8;
    if (!st)
        st = pm_functions_options(&s->functions, "-s, ", take_switch, s);
    if (!st)
        st = pm_functions_count(&s->functions, 6, "patches", &s->m);
    if (!st)
        st = pm_functions_count(&s->functions, 7, "patches", &s->n);
    if (!st)
        st = find_data(s, &file);
    if (!st)
        st = pm_functions_compile(&s->functions, 3, 3, s->triplets ? 7 : file.data ? 4 : 0);
    return st || !file.data ? st : read_data(s, file);
}

/* ---- points ---- */

static pm_status evaluate(const struct surf *s, double u, double v, struct point *out)
{
    const double st[2] = {u, v};
    *out = (struct point){0};
    pm_status status = pm_functions_valid(&s->functions, st, &out->valid);
    if (status || !out->valid)
        return status;
    status = pm_functions_values(&s->functions, st, out->p);
    for (int i = 0; s->data && i < 3; i++)
        if (s->triplets || i == 2)
            out->p[i] = data_value(s, st, i);
    return status;
}

/* The points of one row; when smoothing also one past each end. `row` is that of t = 0. */
static pm_status evaluate_row(const struct surf *s, int64_t index, struct point *row)
{
    int64_t past = s->smooth;
    pm_status st = PM_OK;
    if (!s->smooth && (index < 0 || index > s->m))
        return PM_OK;
    for (int64_t j = -past; !st && j <= s->n + past; j++)
        st = evaluate(s, (double)index / (double)s->m, (double)j / (double)s->n, &row[j]);
    return st;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = a[j] * b[k] - a[k] * b[j];
    }
}

static double normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; length > 0 && i < 3; i++)
        v[i] /= length;
    return length;
}

static void subtract(const struct point *a, const struct point *b, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a->p[i] - b->p[i];
}

/* The derivative from the neighbours that are valid; false without any. */
static bool derivative(const struct point *before, const struct point *here,
                       const struct point *after, double out[3])
{
    subtract(after->valid ? after : here, before->valid ? before : here, out);
    return before->valid || after->valid;
}

static void average_normals(const struct surf *s, const struct point *before, struct point *row,
                            const struct point *after)
{
    for (int64_t j = 0; s->smooth && j <= s->n; j++) {
        double ds[3], dt[3];
        if (!row[j].valid || !derivative(&before[j], &row[j], &after[j], ds) ||
            !derivative(&row[j - 1], &row[j], &row[j + 1], dt))
            continue;
        cross(ds, dt, row[j].normal);
        normalize(row[j].normal);
    }
}

/* ---- interpolation of normals ---- */

/* Gauss and Jordan with row pivots, in place: rows of `a` beside those of the unit matrix.
 * False if it is singular. */
static bool invert(double a[4][8])
{
    for (int i = 0; i < 4; i++) {
        int pivot = -1;
        double best = tiny;
        for (int k = i; k < 4; k++) {
            if (fabs(a[k][i]) > best) {
                best = fabs(a[k][i]);
                pivot = k;
            }
        }
        if (pivot < 0)
            return false;
        for (int k = 0; k < 8; k++) {
            double swap = a[i][k];
            a[i][k] = a[pivot][k];
            a[pivot][k] = swap;
        }
        double divisor = a[i][i];
        for (int k = 0; k < 8; k++)
            a[i][k] /= divisor;
        for (int j = 0; j < 4; j++) {
            double factor = a[j][i];
            for (int k = 0; j != i && k < 8; k++)
                a[j][k] -= a[i][k] * factor;
        }
    }
    return true;
}

/* Coefficients of uv, u, v and 1 that give the normals at four points, u and v being the axes
 * across the main one, which is returned; -1 if there are none. */
static int interpolate(const struct point *const p[4], double out[4][3])
{
    double sum[3] = {0}, a[4][8] = {{0}};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 3; j++)
            sum[j] += p[i]->normal[j];
    int axis = fabs(sum[0]) > fabs(sum[1]) ? 0 : 1;
    axis = fabs(sum[axis]) > fabs(sum[2]) ? axis : 2;
    for (int i = 0; i < 4; i++) {
        double u = p[i]->p[(axis + 1) % 3], v = p[i]->p[(axis + 2) % 3];
        const double row[4] = {u * v, u, v, 1};
        memcpy(a[i], row, sizeof row);
        a[i][4 + i] = 1;
    }
    if (!invert(a))
        return -1;
    for (int k = 0; k < 4; k++) {
        for (int j = 0; j < 3; j++) {
            out[k][j] = 0;
            for (int i = 0; i < 4; i++)
                out[k][j] += a[k][4 + i] * p[i]->normal[j];
        }
    }
    return axis;
}

/* ---- patches ---- */

struct patch {
    const struct point *corners[4];
    int axis; /* of the interpolation; -1 without */
    double normals[4][3];
};

/* The texture is what the interpolated normal has more than the face's own. */
static void put_face(struct surf *s, const struct patch *patch, const double normal[3],
                     const int *corners, int count)
{
    pm_generation *g = s->g;
    if (patch->axis >= 0) {
        double constant[3];
        for (int i = 0; i < 3; i++)
            constant[i] = patch->normals[3][i] - normal[i];
        pm_put(g, "%s texfunc Phong\n4 surf_dx surf_dy surf_dz surf.cal\n0\n13 %d\n",
               s->modifier, patch->axis);
        for (int i = 0; i < 3; i++)
            pm_put_point(g, patch->normals[i]);
        pm_put_point(g, constant);
    }
    pm_put(g, "%s polygon %s.%llu\n0\n0\n%d\n", patch->axis >= 0 ? "Phong" : s->modifier,
           s->name, (unsigned long long)++s->count, 3 * count);
    for (int i = 0; i < count; i++)
        pm_put_point(g, patch->corners[corners[i]]->p);
}

/* The unit normal of the triangle at a, b and c; false if it has none. */
static bool triangle_normal(const struct point *a, const struct point *b, const struct point *c,
                            double out[3])
{
    double ab[3], ac[3];
    subtract(b, a, ab);
    subtract(c, a, ac);
    cross(ab, ac, out);
    return a->valid && b->valid && c->valid && normalize(out) > 0;
}

static void put_patch(struct surf *s, const struct point *p0, const struct point *p1,
                      const struct point *p2, const struct point *p3)
{
    static const double coplanar = 1 - 1e-12;
    struct patch patch = {.corners = {p0, p1, p2, p3}, .axis = -1};
    double n1[3], n2[3], mean[3];
    bool first = triangle_normal(p0, p1, p2, n1), second = triangle_normal(p3, p2, p1, n2);
    if (!first && !second)
        return;
    if (s->smooth)
        patch.axis = interpolate(patch.corners, patch.normals);
    if (first && second && n1[0] * n2[0] + n1[1] * n2[1] + n1[2] * n2[2] >= coplanar) {
        for (int i = 0; i < 3; i++)
            mean[i] = 0.5 * n1[i] + 0.5 * n2[i];
        put_face(s, &patch, mean, (const int[]){0, 1, 3, 2}, 4);
        return;
    }
    if (first)
        put_face(s, &patch, n1, (const int[]){0, 1, 2}, 3);
    if (second)
        put_face(s, &patch, n2, (const int[]){2, 1, 3}, 3);
}

/* Diagonals alternate, and avoid corners that are left out. */
static pm_status put_row(struct surf *s, const struct point *a, const struct point *b)
{
    pm_status st = PM_OK;
    for (int64_t j = 0; !st && j < s->n; j++) {
        bool other = j & 1;
        if (!(a[j].valid && b[j + 1].valid))
            other = true;
        else if (!(b[j].valid && a[j + 1].valid))
            other = false;
        if (other)
            put_patch(s, &a[j], &b[j], &a[j + 1], &b[j + 1]);
        else
            put_patch(s, &b[j], &b[j + 1], &a[j], &a[j + 1]);
        st = pm_generation_pass(s->g);
    }
    return st;
}

/* Three rows at a time: normals need the neighbours. */
static pm_status put_rows(struct surf *s, struct point *storage)
{
    struct point *rows[3];
    pm_status st = PM_OK;
    for (int i = 0; i < 3; i++)
        rows[i] = storage + (s->n + 3) * i + 1;
    for (int i = 0; !st && i < 3; i++)
        st = evaluate_row(s, i - 1, rows[i]);
    average_normals(s, rows[0], rows[1], rows[2]);
    for (int64_t i = 0; !st && i < s->m; i++) {
        struct point *oldest = rows[0];
        rows[0] = rows[1];
        rows[1] = rows[2];
        rows[2] = oldest;
        st = evaluate_row(s, i + 2, rows[2]);
        average_normals(s, rows[0], rows[1], rows[2]);
        if (!st)
            st = put_row(s, rows[0], rows[1]);
    }
    return st;
}

static pm_status put_surf(struct surf *s)
{
    struct point *storage = calloc(3 * ((size_t)s->n + 3), sizeof *storage);
    if (!storage)
        return pm_error_set(s->g->err, PM_E_MEMORY, "not enough memory for a row of points");
    pm_status st = put_rows(s, storage);
    free(storage);
    return st ? st : pm_generation_end(s->g);
}

pm_status pm_gensurf(pm_generation *g)
{
    struct surf s = {.g = g, .functions = {.g = g, .parameters = "s,t", .parameter_count = 2}};
    pm_status st = read_surf(&s);
    uint64_t patches = (uint64_t)s.m * (uint64_t)s.n; /* below 2^62 */
    if (!st && pm_generation_begin(g, (s.smooth ? 4 : 2) * patches,
                                   patches > UINT64_MAX / 44 ? UINT64_MAX
                                                             : (s.smooth ? 44 : 18) * patches,
                                   strlen(s.modifier) + strlen(s.name)))
        st = put_surf(&s);
    free(s.data);
    pm_functions_clear(&s.functions);
    return st;
}
