#include "files/mesh_build.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "base/triangulate.h"

/* Wavefront .obj text. Source of what counts: Radiance, src/ot/wfconv.c and cvmesh.c. */

struct word {
    const char *text; /* NULL at the end of the statement */
    size_t length;
    int line, column;
};

/* A corner of a face: indices of its point, texture coordinates and normal; NONE without. */
struct corner {
    uint32_t point, uv, normal;
};
enum { NONE = UINT32_MAX };

/* Which vertices of the mesh a point has become, for different uv and normals. */
struct variant {
    struct corner corner;
    uint32_t next; /* another vertex of the same point, or NONE */
};

struct list {
    void *items;
    size_t count, capacity;
};

struct obj {
    const char *at, *end, *line_start;
    int line;
    const char *name;
    struct pm_mesh_memory *mesh;
    pm_error *err;
    struct list points;   /* pm_vec3 */
    struct list uvs;      /* double[2] */
    struct list normals;  /* float[3] */
    struct list newest;   /* uint32_t: by point, its newest vertex of the mesh */
    struct list variants; /* struct variant, by vertex of the mesh */
    struct list face;     /* struct corner */
    struct list vertices; /* uint32_t: of the face */
    struct word material, group;
    uint32_t slot; /* of what applies now; NONE: not looked up yet */
};

static pm_status fail(const struct obj *o, const struct word *word, pm_status status,
                      const char *format, ...) __attribute__((format(printf, 4, 5)));

static pm_status fail(const struct obj *o, const struct word *word, pm_status status,
                      const char *format, ...)
{
    char text[sizeof o->err->text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return pm_error_set_at(o->err, status, o->name, word->line, word->column, "%s", text);
}

#define SHOW(word) (int)((word)->length < 60 ? (word)->length : 60), (word)->text

static pm_status memory_error(const struct obj *o)
{
    return pm_error_set(o->err, PM_E_MEMORY, "not enough memory for the mesh");
}

/* Room for one more; NULL if memory is short. */
static void *append(struct list *list, size_t size)
{
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? 2 * list->capacity : 256;
        void *more = realloc(list->items, capacity * size);
        if (!more)
            return NULL;
        list->items = more;
        list->capacity = capacity;
    }
    return (char *)list->items + size * list->count++;
}

/* ---- words ---- */

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

/* Passes blanks and line ends that a backslash continues. */
static void skip_blanks(struct obj *o)
{
    while (o->at < o->end) {
        const char *next = o->at + 1;
        while (*o->at == '\\' && next < o->end && *next == '\r')
            next++;
        if (*o->at == '\\' && next < o->end && *next == '\n') {
            o->at = o->line_start = next + 1;
            o->line++;
        } else if (is_blank(*o->at)) {
            o->at++;
        } else {
            return;
        }
    }
}

static struct word next_word(struct obj *o)
{
    skip_blanks(o);
    struct word word = {.line = o->line, .column = (int)(o->at - o->line_start) + 1};
    if (o->at == o->end || *o->at == '\n')
        return word;
    word.text = o->at;
    while (o->at < o->end && *o->at != '\n' && !is_blank(*o->at))
        o->at++;
    word.length = (size_t)(o->at - word.text);
    return word;
}

static void skip_line(struct obj *o)
{
    while (next_word(o).text)
        ;
    if (o->at < o->end) {
        o->line_start = ++o->at;
        o->line++;
    }
}

static bool is(const struct word *word, const char *text)
{
    return word->length == strlen(text) && memcmp(word->text, text, word->length) == 0;
}

static pm_status read_real(struct obj *o, const char *what, double *value)
{
    struct word word = next_word(o);
    if (!word.text)
        return fail(o, &word, PM_E_SYNTAX, "the line ends, but %s should come here", what);
    pm_number number = pm_number_real(word.text, word.length, value);
    if (number == PM_NUMBER_MALFORMED)
        return fail(o, &word, PM_E_SYNTAX, "'%.*s' is no number; %s should come here",
                    SHOW(&word), what);
    if (number == PM_NUMBER_HUGE || !(fabs(*value) <= PM_MESH_LARGEST))
        return fail(o, &word, PM_E_RANGE, "%s is %.*s; at most %g can be handled", what,
                    SHOW(&word), PM_MESH_LARGEST);
    return PM_OK;
}

static pm_status read_reals(struct obj *o, const char *const *what, int count, double *out)
{
    pm_status st = PM_OK;
    for (int i = 0; !st && i < count; i++)
        st = read_real(o, what[i], &out[i]);
    return st;
}

/* ---- vertices ---- */

/* A weight or a colour may follow a point; they mean nothing for triangles. */
static pm_status read_point(struct obj *o)
{
    static const char *const what[] = {"a point's x", "a point's y", "a point's z"};
    double p[3];
    pm_status st = read_reals(o, what, 3, p);
    if (st)
        return st;
    pm_vec3 *point = append(&o->points, sizeof *point);
    uint32_t *newest = append(&o->newest, sizeof *newest);
    if (!point || !newest)
        return memory_error(o);
    *point = pm_vec3_make(p[0], p[1], p[2]);
    *newest = NONE;
    return PM_OK;
}

static pm_status read_normal(struct obj *o, const struct word *start)
{
    static const char *const what[] = {"a normal's x", "a normal's y", "a normal's z"};
    double n[3];
    pm_status st = read_reals(o, what, 3, n);
    if (st)
        return st;
    pm_vec3 unit = pm_vec3_normalize(pm_vec3_make(n[0], n[1], n[2]));
    if (!(pm_vec3_dot(unit, unit) > .5))
        return fail(o, start, PM_E_RANGE, "a normal has no length; write a direction");
    float *normal = append(&o->normals, 3 * sizeof *normal);
    if (!normal)
        return memory_error(o);
    normal[0] = (float)unit.x;
    normal[1] = (float)unit.y;
    normal[2] = (float)unit.z;
    return PM_OK;
}

static pm_status read_uv(struct obj *o)
{
    double uv[2] = {0, 0};
    pm_status st = read_real(o, "a texture coordinate's u", &uv[0]);
    skip_blanks(o);
    if (!st && o->at < o->end && *o->at != '\n')
        st = read_real(o, "a texture coordinate's v", &uv[1]);
    if (st)
        return st;
    double *out = append(&o->uvs, sizeof uv);
    if (!out)
        return memory_error(o);
    memcpy(out, uv, sizeof uv);
    return PM_OK;
}

/* ---- materials ---- */

/* Slots seen lately are searched; one that is found again later may get two. */
static pm_status find_slot(struct obj *o)
{
    enum { SEARCHED = 64 };
    const struct word *name = o->material.text ? &o->material : &o->group;
    uint32_t count = o->mesh->mesh.slot_count;
    o->slot = PM_MESH_NO_SLOT;
    if (!name->text || is(name, "void"))
        return PM_OK;
    for (uint32_t i = count; i > 0 && i + SEARCHED > count; i--) {
        if (is(name, o->mesh->slots[i - 1])) {
            o->slot = i - 1;
            return PM_OK;
        }
    }
    return pm_mesh_add_slot(o->mesh, name->text, name->length, &o->slot, o->err);
}

/* ---- faces ---- */

/* One index of a corner, from 1 or backwards from -1. */
static pm_status read_index(const struct obj *o, const struct word *word, const char *text,
                            size_t length, const char *what, size_t count, uint32_t *out)
{
    int64_t index;
    pm_number number = pm_number_integer(text, length, &index);
    if (number == PM_NUMBER_MALFORMED)
        return fail(o, word, PM_E_SYNTAX,
                    "'%.*s' is no corner of a face; write v, v/t, v//n or v/t/n", SHOW(word));
    if (number == PM_NUMBER_OK && index < 0 && index >= -(int64_t)count)
        index += (int64_t)count + 1;
    if (number == PM_NUMBER_HUGE || index < 1 || index > (int64_t)count)
        return fail(o, word, PM_E_RANGE, "there is no %s %.*s; %zu stand above this line", what,
                    (int)(length < 30 ? length : 30), text, count);
    *out = (uint32_t)(index - 1);
    return PM_OK;
}

static pm_status read_corner(struct obj *o, const struct word *word)
{
    const struct {
        const char *what;
        size_t count;
    } kinds[3] = {{"point", o->points.count},
                  {"texture coordinate", o->uvs.count},
                  {"normal", o->normals.count}};
    uint32_t index[3] = {NONE, NONE, NONE};
    const char *at = word->text, *end = at + word->length;
    pm_status st = PM_OK;
    for (int i = 0; !st && i < 3 && at <= end; i++) {
        const char *stop = at < end ? memchr(at, '/', (size_t)(end - at)) : NULL;
        stop = stop ? stop : end;
        if (stop > at || i == 0)
            st = read_index(o, word, at, (size_t)(stop - at), kinds[i].what, kinds[i].count,
                            &index[i]);
        at = stop + 1;
    }
    if (!st && at <= end)
        return fail(o, word, PM_E_SYNTAX,
                    "'%.*s' is no corner of a face; write v, v/t, v//n or v/t/n", SHOW(word));
    struct corner *corner = st ? NULL : append(&o->face, sizeof *corner);
    if (!corner)
        return st ? st : memory_error(o);
    *corner = (struct corner){index[0], index[1], index[2]};
    return PM_OK;
}

/* The mesh's vertex for a corner. Few are searched: sharing saves memory, nothing else. */
static pm_status find_vertex(struct obj *o, const struct corner *c, uint32_t *vertex)
{
    enum { SEARCHED = 32 };
    uint32_t *newest = (uint32_t *)o->newest.items + c->point;
    const struct variant *variants = o->variants.items;
    uint32_t v = *newest;
    for (int i = 0; v != NONE && i < SEARCHED; i++, v = variants[v].next) {
        if (variants[v].corner.uv == c->uv && variants[v].corner.normal == c->normal) {
            *vertex = v;
            return PM_OK;
        }
    }
    const float *normals = o->normals.items;
    const double *uvs = o->uvs.items;
    pm_status st =
        pm_mesh_add_vertex(o->mesh, ((const pm_vec3 *)o->points.items)[c->point],
                           c->normal == NONE ? NULL : normals + 3 * (size_t)c->normal,
                           c->uv == NONE ? NULL : uvs + 2 * (size_t)c->uv, vertex, o->err);
    struct variant *added = st ? NULL : append(&o->variants, sizeof *added);
    if (!added)
        return st ? st : memory_error(o);
    *added = (struct variant){.corner = *c, .next = *newest};
    *newest = *vertex;
    return PM_OK;
}

/* Turns a triangle whose normals all look back, and drops those that say what its plane does:
 * as flat_tri of Radiance's tmesh.c. */
static void settle_normals(const struct obj *o, pm_mesh_triangle *t, pm_vec3 front)
{
    const double flat = .999995; /* cos 0.18 degrees */
    int behind = 0, agree[2] = {0, 0};
    for (int i = 0; i < 3; i++) {
        const float *n = o->mesh->normals[t->corner[i]];
        double d = pm_vec3_dot(front, pm_vec3_make(n[0], n[1], n[2]));
        behind += d < 0;
        agree[0] += d >= flat;
        agree[1] += d <= -flat;
    }
    if (behind == 3) {
        uint32_t first = t->corner[0];
        t->corner[0] = t->corner[2];
        t->corner[2] = first;
    }
    if (agree[behind == 3] == 3)
        t->has_normals = 0;
}

static pm_status add_triangle(struct obj *o, uint32_t a, uint32_t b, uint32_t c)
{
    pm_mesh_triangle t = {.corner = {a, b, c}, .slot = o->slot & PM_MESH_NO_SLOT};
    pm_vec3 front = pm_vec3_normalize(pm_mesh_normal(o->mesh, t.corner));
    if (!(pm_vec3_dot(front, front) > .5))
        return PM_OK; /* no area */
    pm_mesh_set_presence(o->mesh, &t);
    if (t.has_normals)
        settle_normals(o, &t, front);
    return pm_mesh_add_triangle(o->mesh, t, o->err);
}

/* Twice the face's area along each axis (Newell); *extent is 0 if it lies on a line. */
static pm_vec3 face_normal(const struct obj *o, double *extent)
{
    const uint32_t *v = o->vertices.items;
    const pm_vec3 *p = o->mesh->positions;
    pm_vec3 sum = {0, 0, 0};
    *extent = 0;
    for (size_t i = 1; i + 1 < o->vertices.count; i++) {
        pm_vec3 part =
            pm_vec3_cross(pm_vec3_sub(p[v[i]], p[v[0]]), pm_vec3_sub(p[v[i + 1]], p[v[0]]));
        sum = pm_vec3_add(sum, part);
        *extent += pm_vec3_length(part);
    }
    return sum;
}

/* Drops the normal's largest component; what is left is counter-clockwise. */
static struct pm_point2 flatten(pm_vec3 p, pm_vec3 normal)
{
    double x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    if (x >= y && x >= z)
        return normal.x > 0 ? (struct pm_point2){p.y, p.z} : (struct pm_point2){p.z, p.y};
    if (y >= z)
        return normal.y > 0 ? (struct pm_point2){p.z, p.x} : (struct pm_point2){p.x, p.z};
    return normal.z > 0 ? (struct pm_point2){p.x, p.y} : (struct pm_point2){p.y, p.x};
}

static pm_status crossing_error(const struct obj *o, const struct word *start)
{
    return fail(o, start, PM_E_RANGE,
                "the edges of this face cross each other; divide it into triangles");
}

static pm_status add_pieces(struct obj *o, const struct word *start,
                            const struct pm_point2 *flat, struct pm_triangle *pieces)
{
    const uint32_t *v = o->vertices.items;
    uint32_t n = (uint32_t)o->vertices.count, made;
    double inverted, rim = 0;
    if (pm_triangulate(flat, n, pieces, &made, &inverted))
        return memory_error(o);
    for (uint32_t i = 0; i < n; i++) {
        struct pm_point2 a = flat[i], b = flat[(i + 1) % n];
        rim += (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
    }
    if (inverted > 0x1p-30 * rim)
        return crossing_error(o, start);
    pm_status st = PM_OK;
    for (uint32_t i = 0; !st && i < made; i++)
        st = add_triangle(o, v[pieces[i].corner[0]], v[pieces[i].corner[1]],
                          v[pieces[i].corner[2]]);
    return st;
}

static pm_status add_polygon(struct obj *o, const struct word *start)
{
    const uint32_t *v = o->vertices.items;
    size_t n = o->vertices.count;
    double extent;
    pm_vec3 normal = face_normal(o, &extent);
    if (!(extent > 0))
        return PM_OK; /* no area */
    if (!(pm_vec3_length(normal) > 0x1p-40 * extent))
        return crossing_error(o, start);
    struct pm_point2 *flat = malloc(n * sizeof *flat);
    struct pm_triangle *pieces = malloc(n * sizeof *pieces);
    for (size_t i = 0; flat && i < n; i++)
        flat[i] = flatten(o->mesh->positions[v[i]], normal);
    pm_status st = flat && pieces ? add_pieces(o, start, flat, pieces) : memory_error(o);
    free(flat);
    free(pieces);
    return st;
}

static pm_status place_corners(struct obj *o)
{
    pm_status st = PM_OK;
    o->vertices.count = 0;
    for (size_t i = 0; !st && i < o->face.count; i++) {
        uint32_t *vertex = append(&o->vertices, sizeof *vertex);
        st = vertex ? find_vertex(o, (const struct corner *)o->face.items + i, vertex)
                    : memory_error(o);
    }
    return st;
}

static pm_status read_face(struct obj *o, const struct word *start)
{
    pm_status st = PM_OK;
    struct word word;
    o->face.count = 0;
    while (!st && (word = next_word(o)).text)
        st = read_corner(o, &word);
    if (!st && o->face.count < 3)
        return fail(o, start, PM_E_SYNTAX, "a face has at least 3 corners; here are %zu",
                    o->face.count);
    if (!st && o->face.count >= UINT32_MAX)
        return fail(o, start, PM_E_LIMIT, "a face has 2^32 corners or more; divide it");
    if (!st && o->slot == NONE)
        st = find_slot(o);
    if (!st)
        st = place_corners(o);
    const uint32_t *v = o->vertices.items;
    if (!st)
        st = o->face.count == 3 ? add_triangle(o, v[0], v[1], v[2]) : add_polygon(o, start);
    return st;
}

/* ---- statements ---- */

static bool is_one_of(const struct word *word, const char *const *names)
{
    while (*names && !is(word, *names))
        names++;
    return *names != NULL;
}

static pm_status read_statement(struct obj *o, const struct word *word)
{
    /* without area, or what only other programs use */
    static const char *const passed[] = {
        "o",   "s",     "l",        "p",        "mtllib",     "usemap",    "maplib",
        "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", NULL};
    static const char *const curved[] = {
        "vp",   "cstype", "deg", "bmat", "step", "curv", "curv2", "surf",  "parm", "trim",
        "hole", "scrv",   "sp",  "end",  "con",  "mg",   "ctech", "stech", NULL};
    if (is(word, "v"))
        return read_point(o);
    if (is(word, "vn"))
        return read_normal(o, word);
    if (is(word, "vt"))
        return read_uv(o);
    if (is(word, "f") || is(word, "fo"))
        return read_face(o, word);
    if (is(word, "usemtl") || is(word, "g")) {
        *(is(word, "g") ? &o->group : &o->material) = next_word(o);
        o->slot = NONE;
        return PM_OK;
    }
    if (is_one_of(word, curved))
        return fail(o, word, PM_E_UNSUPPORTED,
                    "'%.*s' belongs to a curved surface; write the model as polygons",
                    SHOW(word));
    if (word->text[0] == '#' || is_one_of(word, passed))
        return PM_OK;
    return fail(o, word, PM_E_SYNTAX, "'%.*s' is no statement of a Wavefront .obj file",
                SHOW(word));
}

static pm_status read_all(struct obj *o)
{
    pm_status st = PM_OK;
    while (!st && o->at < o->end) {
        struct word word = next_word(o);
        if (word.text && memchr(word.text, '\0', word.length))
            st = fail(o, &word, PM_E_SYNTAX,
                      "byte 0x00 is not text; an .obj file is plain text, and this is no "
                      "compiled mesh either");
        else if (word.text)
            st = read_statement(o, &word);
        if (!st)
            skip_line(o);
    }
    return st;
}

pm_status pm_mesh_read_obj(const char *text, size_t size, const char *name,
                           struct pm_mesh_memory *m, pm_error *err)
{
    if (size >= INT_MAX)
        return pm_error_set(err, PM_E_LIMIT,
                            "the file has %zu bytes; a mesh must be smaller than 2 GiB: "
                            "split it",
                            size);
    struct obj o = {.at = text,
                    .end = text + size,
                    .line_start = text,
                    .line = 1,
                    .name = name,
                    .mesh = m,
                    .err = err,
                    .slot = NONE};
    pm_status st = read_all(&o);
    struct list *lists[] = {&o.points,   &o.uvs,  &o.normals, &o.newest,
                            &o.variants, &o.face, &o.vertices};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        free(lists[i]->items);
    return st;
}
