/* Reads the Radiance subset: words, then primitives, then materials and shapes. */
#include "reference_internal.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct reader {
    const char *next;
    int line;
    int word_line; /* where the last word stood */
    char *error;   /* may be NULL */
    bool failed;
    struct ref_scene *scene;
    double extent; /* largest coordinate or size seen */
};

/* One primitive of the text: `modifier type name` and its real arguments. */
struct primitive {
    char modifier[REF_NAME_SIZE], type[REF_NAME_SIZE], name[REF_NAME_SIZE];
    long string_count;
    double *real;
    size_t real_count;
};

/* The first error wins. Returns false, so that callers can return it. */
__attribute__((format(printf, 2, 3))) static bool fail(struct reader *r, const char *format,
                                                       ...)
{
    if (!r->failed && r->error) {
        int n = snprintf(r->error, REF_ERROR_SIZE, "%d: ", r->word_line);
        va_list args;
        va_start(args, format);
        vsnprintf(r->error + n, REF_ERROR_SIZE - (size_t)n, format, args);
        va_end(args);
    }
    r->failed = true;
    return false;
}

/* ---- words ---- */

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

static void skip_blank(struct reader *r)
{
    while (is_space(*r->next) || *r->next == '#') {
        if (*r->next == '#')
            r->next += strcspn(r->next, "\n");
        if (*r->next == '\n')
            r->line++;
        if (*r->next)
            r->next++;
    }
    r->word_line = r->line;
}

static bool read_word(struct reader *r, char word[REF_NAME_SIZE])
{
    skip_blank(r);
    size_t n = 0;
    while (r->next[n] && !is_space(r->next[n]))
        n++;
    if (n == 0)
        return fail(r, "the text ends within a primitive");
    if (n >= REF_NAME_SIZE)
        return fail(r, "word longer than %d characters", REF_NAME_SIZE - 1);
    memcpy(word, r->next, n);
    word[n] = '\0';
    r->next += n;
    return true;
}

static bool read_real(struct reader *r, double *value)
{
    char word[REF_NAME_SIZE], *end;
    if (!read_word(r, word))
        return false;
    *value = strtod(word, &end);
    if (*end || !isfinite(*value))
        return fail(r, "'%s' is not a finite number", word);
    return true;
}

static bool read_count(struct reader *r, long *count)
{
    char word[REF_NAME_SIZE], *end;
    if (!read_word(r, word))
        return false;
    errno = 0;
    *count = strtol(word, &end, 10);
    if (*end || errno || *count < 0 || *count > 1000000)
        return fail(r, "'%s' is not an argument count", word);
    return true;
}

/* ---- primitives ---- */

static bool read_reals(struct reader *r, struct primitive *p)
{
    long count;
    if (!read_count(r, &count))
        return false;
    p->real_count = (size_t)count;
    p->real = calloc(p->real_count + 1, sizeof *p->real);
    if (!p->real)
        return fail(r, "out of memory");
    for (size_t i = 0; i < p->real_count; i++)
        if (!read_real(r, &p->real[i]))
            return false;
    return true;
}

static bool read_primitive(struct reader *r, struct primitive *p)
{
    if (!read_word(r, p->modifier) || !read_word(r, p->type) || !read_word(r, p->name))
        return false;
    if (!read_count(r, &p->string_count))
        return false;
    char skipped[REF_NAME_SIZE];
    for (long i = 0; i < p->string_count; i++)
        if (!read_word(r, skipped))
            return false;
    long integers;
    if (!read_count(r, &integers))
        return false;
    if (integers)
        return fail(r, "integer arguments are not supported");
    return read_reals(r, p);
}

/* Makes room for one more element; NULL if memory is out. */
static void *grow(struct reader *r, void *array, size_t count, size_t size)
{
    void *grown = realloc(array, (count + 1) * size);
    if (!grown)
        fail(r, "out of memory");
    return grown;
}

/* ---- materials ---- */

static bool check_range(struct reader *r, const char *what, double x, double low, double high)
{
    if (x < low || x > high)
        return fail(r, "%s %g is outside [%g, %g]", what, x, low, high);
    return true;
}

static bool check_colors(struct reader *r, const double color[3], double high)
{
    for (int c = 0; c < 3; c++)
        if (!check_range(r, "colour", color[c], 0, high))
            return false;
    return true;
}

static bool fill_normal(struct reader *r, const double *a, struct material *m)
{
    m->specularity = a[3];
    if (m->kind == MATERIAL_TRANS) {
        m->transmission = a[5];
        m->straight = a[6];
    }
    bool specular = m->specularity > 0 || m->transmission * m->straight > 0;
    if (a[4] != 0 && specular)
        return fail(r, "roughness is not supported");
    return check_colors(r, m->color, 1) && check_range(r, "specularity", a[3], 0, 1) &&
           check_range(r, "transmission", m->transmission, 0, 1) &&
           check_range(r, "specular transmission", m->straight, 0, 1);
}

static bool fill_dielectric(struct reader *r, const double *a, struct material *m)
{
    const double mean_wavelength = 500; /* nm, Radiance's */
    m->index = a[3] + a[4] / mean_wavelength;
    for (int c = 0; c < 3; c++) /* Radiance's floor on transmittance: exp(-100) */
        m->extinction[c] = a[c] < 1e-40 ? 100 : fmax(0, -log(a[c]));
    return check_range(r, "refractive index", m->index, 0.1, 10);
}

static bool fill_glass(struct reader *r, const struct primitive *p, struct material *m)
{
    m->index = p->real_count == 4 ? p->real[3] : 1.52;
    return check_colors(r, m->color, 1) && check_range(r, "refractive index", m->index, 1, 10);
}

static bool fill_spotlight(struct reader *r, const double *a, struct material *m)
{
    struct vec axis = vec_from(a + 4);
    if (vec_dot(axis, axis) == 0)
        return fail(r, "a spotlight needs a direction");
    m->spot_axis = vec_unit(axis);
    m->spot_cosine = cos(a[3] * REF_PI / 360);
    return check_colors(r, m->color, HUGE_VAL) && check_range(r, "angle", a[3], 1e-9, 360);
}

static bool fill_mist(struct reader *r, const struct primitive *p, struct material *m)
{
    size_t n = p->real_count;
    if (n != 0 && n != 3 && n != 6 && n != 7)
        return fail(r, "mist takes 0, 3, 6 or 7 real arguments");
    for (int c = 0; c < 3; c++) {
        m->extinction[c] = n >= 3 ? p->real[c] : 0;
        m->scattering[c] = n >= 6 ? p->real[c] * p->real[3 + c] : 0;
    }
    m->eccentricity = n == 7 ? p->real[6] : 0;
    return check_colors(r, m->extinction, HUGE_VAL) &&
           (n < 6 || check_colors(r, p->real + 3, 1)) &&
           check_range(r, "eccentricity", m->eccentricity, -0.999, 0.999);
}

static const struct {
    const char *name;
    enum material_kind kind;
    size_t least, most; /* real arguments */
} material_types[] = {
    {"plastic", MATERIAL_PLASTIC, 5, 5},       {"metal", MATERIAL_METAL, 5, 5},
    {"trans", MATERIAL_TRANS, 7, 7},           {"glass", MATERIAL_GLASS, 3, 4},
    {"dielectric", MATERIAL_DIELECTRIC, 5, 5}, {"mirror", MATERIAL_MIRROR, 3, 3},
    {"light", MATERIAL_LIGHT, 3, 3},           {"glow", MATERIAL_GLOW, 4, 4},
    {"spotlight", MATERIAL_SPOTLIGHT, 7, 7},   {"mist", MATERIAL_MIST, 0, 7},
};

#define MATERIAL_TYPES (sizeof material_types / sizeof *material_types)

static bool fill_material(struct reader *r, const struct primitive *p, struct material *m)
{
    if (p->real_count >= 3)
        memcpy(m->color, p->real, sizeof m->color);
    switch (m->kind) {
    case MATERIAL_PLASTIC:
    case MATERIAL_METAL:
    case MATERIAL_TRANS:
        return fill_normal(r, p->real, m);
    case MATERIAL_GLASS:
        return fill_glass(r, p, m);
    case MATERIAL_DIELECTRIC:
        return fill_dielectric(r, p->real, m);
    case MATERIAL_SPOTLIGHT:
        return fill_spotlight(r, p->real, m);
    case MATERIAL_MIST:
        return fill_mist(r, p, m);
    case MATERIAL_MIRROR:
        return check_colors(r, m->color, 1);
    case MATERIAL_LIGHT:
    case MATERIAL_GLOW:
        break;
    }
    return check_colors(r, m->color, HUGE_VAL);
}

static bool add_material(struct reader *r, const struct primitive *p, size_t type)
{
    struct ref_scene *s = r->scene;
    if (strcmp(p->modifier, "void") != 0)
        return fail(r, "material '%s' has a modifier", p->name);
    if (p->real_count < material_types[type].least || p->real_count > material_types[type].most)
        return fail(r, "wrong number of real arguments for %s", p->type);
    if (p->string_count && material_types[type].kind != MATERIAL_MIST)
        return fail(r, "string arguments of %s are not supported", p->type);
    struct material m = {.kind = material_types[type].kind};
    if (!fill_material(r, p, &m))
        return false;
    void *grown = grow(r, s->materials, s->material_count, sizeof *s->materials);
    if (!grown)
        return false;
    s->materials = grown;
    memcpy(m.name, p->name, sizeof m.name);
    s->has_media = s->has_media || material_bounds_medium(&m);
    s->materials[s->material_count++] = m;
    return true;
}

/* ---- shapes ---- */

/* Twice the area times the normal (Newell). */
static struct vec polygon_area_vector(const struct vec *v, size_t n)
{
    struct vec sum = {0, 0, 0};
    for (size_t i = 2; i < n; i++)
        sum = vec_add(sum, vec_cross(vec_sub(v[i - 1], v[0]), vec_sub(v[i], v[0])));
    return sum;
}

/* Axes in the plane and the extent along them, where light samples are drawn. */
static bool fill_polygon_plane(struct reader *r, struct shape *s)
{
    struct vec doubled = polygon_area_vector(s->vertices, s->vertex_count);
    struct vec edge = vec_sub(s->vertices[1], s->vertices[0]);
    if (vec_dot(doubled, doubled) == 0 || vec_dot(edge, edge) == 0)
        return fail(r, "polygon with zero area or first edge");
    s->area = vec_length(doubled) / 2;
    s->axis = vec_unit(doubled);
    s->u = vec_unit(vec_along(edge, -vec_dot(edge, s->axis), s->axis));
    s->v = vec_cross(s->axis, s->u);
    for (size_t i = 0; i < s->vertex_count; i++) {
        struct vec w = vec_sub(s->vertices[i], s->vertices[0]);
        if (fabs(vec_dot(w, s->axis)) > 1e-5 * sqrt(s->area))
            return fail(r, "polygon is not planar at vertex %zu", i + 1);
        s->u_min = fmin(s->u_min, vec_dot(w, s->u));
        s->u_max = fmax(s->u_max, vec_dot(w, s->u));
        s->v_min = fmin(s->v_min, vec_dot(w, s->v));
        s->v_max = fmax(s->v_max, vec_dot(w, s->v));
    }
    return true;
}

static bool fill_polygon(struct reader *r, const struct primitive *p, struct shape *s)
{
    s->kind = SHAPE_POLYGON;
    if (p->real_count < 9 || p->real_count % 3 != 0)
        return fail(r, "polygon takes three real arguments a vertex, at least nine");
    s->vertex_count = p->real_count / 3;
    s->vertices = calloc(s->vertex_count, sizeof *s->vertices);
    if (!s->vertices)
        return fail(r, "out of memory");
    for (size_t i = 0; i < s->vertex_count; i++)
        s->vertices[i] = vec_from(p->real + 3 * i);
    return fill_polygon_plane(r, s);
}

static bool fill_sphere(struct reader *r, const struct primitive *p, struct shape *s)
{
    s->kind = SHAPE_SPHERE;
    if (p->real_count != 4 || p->real[3] <= 0)
        return fail(r, "%s takes a centre and a radius > 0", p->type);
    s->center = vec_from(p->real);
    s->r0 = p->real[3];
    s->area = 4 * REF_PI * s->r0 * s->r0;
    return true;
}

static bool fill_ring(struct reader *r, const struct primitive *p, struct shape *s)
{
    s->kind = SHAPE_RING;
    if (p->real_count != 8)
        return fail(r, "ring takes 8 real arguments");
    s->center = vec_from(p->real);
    s->axis = vec_from(p->real + 3);
    s->r0 = fmin(p->real[6], p->real[7]);
    s->r1 = fmax(p->real[6], p->real[7]);
    if (vec_dot(s->axis, s->axis) == 0 || s->r0 < 0 || s->r1 <= s->r0)
        return fail(r, "ring needs a normal and two radii >= 0 that differ");
    s->axis = vec_unit(s->axis);
    s->area = REF_PI * (s->r1 - s->r0) * (s->r1 + s->r0);
    return true;
}

/* Cone, cup (8 reals), cylinder, tube (7 reals). */
static bool fill_cone(struct reader *r, const struct primitive *p, struct shape *s,
                      size_t reals)
{
    s->kind = SHAPE_CONE;
    if (p->real_count != reals)
        return fail(r, "%s takes %zu real arguments", p->type, reals);
    s->center = vec_from(p->real);
    s->axis = vec_sub(vec_from(p->real + 3), s->center);
    s->r0 = p->real[6];
    s->r1 = p->real[reals - 1];
    s->length = vec_length(s->axis);
    if (s->length <= 0 || s->r0 < 0 || s->r1 < 0 || s->r0 + s->r1 <= 0)
        return fail(r, "%s needs a length > 0 and radii >= 0", p->type);
    s->axis = vec_unit(s->axis);
    s->area = REF_PI * (s->r0 + s->r1) * hypot(s->length, s->r1 - s->r0);
    return true;
}

static bool fill_source(struct reader *r, const struct primitive *p, struct shape *s)
{
    s->kind = SHAPE_SOURCE;
    if (p->real_count != 4 || p->real[3] <= 0 || p->real[3] > 360)
        return fail(r, "source takes a direction and a full angle in (0, 360]");
    s->axis = vec_from(p->real);
    if (vec_dot(s->axis, s->axis) == 0)
        return fail(r, "source needs a direction");
    s->axis = vec_unit(s->axis);
    double quarter = sin(p->real[3] * REF_PI / 720);
    s->area = 4 * REF_PI * quarter * quarter; /* 2 pi (1 - cos(angle / 2)) */
    return true;
}

static bool fill_shape(struct reader *r, const struct primitive *p, struct shape *s)
{
    const char *type = p->type;
    s->inward = !strcmp(type, "bubble") || !strcmp(type, "tube") || !strcmp(type, "cup");
    if (!strcmp(type, "polygon"))
        return fill_polygon(r, p, s);
    if (!strcmp(type, "sphere") || !strcmp(type, "bubble"))
        return fill_sphere(r, p, s);
    if (!strcmp(type, "ring"))
        return fill_ring(r, p, s);
    if (!strcmp(type, "cylinder") || !strcmp(type, "tube"))
        return fill_cone(r, p, s, 7);
    if (!strcmp(type, "cone") || !strcmp(type, "cup"))
        return fill_cone(r, p, s, 8);
    if (!strcmp(type, "source"))
        return fill_source(r, p, s);
    return fail(r, "unsupported type '%s'", type);
}

/* The latest definition of a name counts, as in Radiance. */
static bool find_material(struct reader *r, const char *name, size_t *index)
{
    for (size_t i = r->scene->material_count; i-- > 0;)
        if (!strcmp(r->scene->materials[i].name, name)) {
            *index = i;
            return true;
        }
    return fail(r, "unknown material '%s'", name);
}

static bool check_source_material(struct reader *r, const struct material *m)
{
    if (m->kind != MATERIAL_LIGHT && m->kind != MATERIAL_GLOW)
        return fail(r, "a source must be made of light or glow");
    return true;
}

static void note_extent(struct reader *r, const struct primitive *p)
{
    for (size_t i = 0; i < p->real_count; i++)
        r->extent = fmax(r->extent, fabs(p->real[i]));
}

static bool add_shape(struct reader *r, const struct primitive *p)
{
    struct ref_scene *scene = r->scene;
    struct shape s = {0};
    bool ok = fill_shape(r, p, &s) && find_material(r, p->modifier, &s.material);
    if (ok && s.kind == SHAPE_SOURCE)
        ok = check_source_material(r, shape_material(scene, &s));
    void *grown = ok ? grow(r, scene->shapes, scene->shape_count, sizeof *scene->shapes) : NULL;
    if (!grown) {
        free(s.vertices);
        return false;
    }
    scene->shapes = grown;
    scene->shapes[scene->shape_count++] = s;
    if (s.kind != SHAPE_SOURCE)
        note_extent(r, p);
    return true;
}

static bool add_primitive(struct reader *r, const struct primitive *p)
{
    for (size_t i = 0; i < MATERIAL_TYPES; i++)
        if (!strcmp(p->type, material_types[i].name))
            return add_material(r, p, i);
    if (p->string_count)
        return fail(r, "string arguments of %s are not supported", p->type);
    return add_shape(r, p);
}

static bool read_scene(struct reader *r)
{
    for (skip_blank(r); *r->next; skip_blank(r)) {
        struct primitive p = {.real = NULL};
        bool ok = read_primitive(r, &p) && add_primitive(r, &p);
        free(p.real);
        if (!ok)
            return false;
    }
    return true;
}

struct ref_scene *ref_load_string(const char *text, char error[REF_ERROR_SIZE])
{
    struct reader r = {.next = text, .line = 1, .word_line = 1, .error = error};
    r.scene = calloc(1, sizeof *r.scene);
    if (!r.scene) {
        fail(&r, "out of memory");
        return NULL;
    }
    if (!read_scene(&r)) {
        ref_free(r.scene);
        return NULL;
    }
    r.scene->epsilon = 1e-12 * r.extent;
    return r.scene;
}

static char *read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    char *text = NULL;
    size_t size = 0, got = 1;
    while (got) {
        char *grown = realloc(text, size + 65536 + 1);
        if (!grown)
            break;
        text = grown;
        got = fread(text + size, 1, 65536, file);
        size += got;
    }
    bool whole = got == 0 && !ferror(file);
    fclose(file);
    if (!whole) {
        free(text);
        return NULL;
    }
    text[size] = '\0';
    return text;
}

struct ref_scene *ref_load_file(const char *path, char error[REF_ERROR_SIZE])
{
    char *text = read_file(path);
    if (!text) {
        if (error)
            snprintf(error, REF_ERROR_SIZE, "0: cannot read '%s'", path);
        return NULL;
    }
    struct ref_scene *scene = ref_load_string(text, error);
    free(text);
    return scene;
}

void ref_free(struct ref_scene *scene)
{
    if (!scene)
        return;
    for (size_t i = 0; i < scene->shape_count; i++)
        free(scene->shapes[i].vertices);
    free(scene->materials);
    free(scene->shapes);
    free(scene);
}
