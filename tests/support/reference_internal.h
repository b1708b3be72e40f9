/* What the parts of the reference path tracer share: reference_scene.c reads,
 * reference_shapes.c intersects and samples shapes, reference.c traces paths. Nobody else
 * includes this. */
#ifndef PM_TESTS_SUPPORT_REFERENCE_INTERNAL_H
#define PM_TESTS_SUPPORT_REFERENCE_INTERNAL_H

#include "reference.h"

#include <math.h>
#include <stddef.h>

#define REF_PI        3.14159265358979323846
#define REF_NAME_SIZE 256 /* longest word, final 0 included */

struct vec {
    double x, y, z;
};

static inline struct vec vec_from(const double a[3])
{
    return (struct vec){a[0], a[1], a[2]};
}

static inline struct vec vec_add(struct vec a, struct vec b)
{
    return (struct vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct vec vec_sub(struct vec a, struct vec b)
{
    return (struct vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct vec vec_scale(struct vec a, double s)
{
    return (struct vec){a.x * s, a.y * s, a.z * s};
}

/* a + s b */
static inline struct vec vec_along(struct vec a, double s, struct vec b)
{
    return (struct vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline double vec_dot(struct vec a, struct vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec vec_cross(struct vec a, struct vec b)
{
    return (struct vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double vec_length(struct vec a)
{
    return sqrt(vec_dot(a, a));
}

static inline struct vec vec_unit(struct vec a)
{
    return vec_scale(a, 1 / vec_length(a));
}

/* Two unit vectors that make an orthonormal frame with unit w. */
static inline void vec_frame(struct vec w, struct vec *u, struct vec *v)
{
    struct vec axis = fabs(w.x) < 0.5 ? (struct vec){1, 0, 0} : (struct vec){0, 1, 0};
    *u = vec_unit(vec_cross(axis, w));
    *v = vec_cross(w, *u);
}

/* Unit vector at polar angle acos(cosine) and azimuth `phi` about unit w. */
static inline struct vec vec_polar(struct vec w, double cosine, double phi)
{
    struct vec u, v;
    vec_frame(w, &u, &v);
    double sine = sqrt(fmax(0, 1 - cosine * cosine));
    struct vec side = vec_along(vec_scale(u, sine * cos(phi)), sine * sin(phi), v);
    return vec_unit(vec_along(side, cosine, w));
}

/* xoshiro256++ (Blackman and Vigna 2019), seeded from (seed, path index). */
struct ref_rng {
    uint64_t s[4];
};

void ref_rng_init(struct ref_rng *rng, uint64_t seed, uint64_t index);
double ref_rng_uniform(struct ref_rng *rng); /* [0, 1) */

enum material_kind {
    MATERIAL_PLASTIC,
    MATERIAL_METAL,
    MATERIAL_TRANS,
    MATERIAL_GLASS,
    MATERIAL_DIELECTRIC,
    MATERIAL_MIRROR,
    MATERIAL_LIGHT,
    MATERIAL_GLOW,
    MATERIAL_SPOTLIGHT,
    MATERIAL_MIST
};

struct material {
    char name[REF_NAME_SIZE];
    enum material_kind kind;
    double color[3];      /* reflectance, transmissivity or emitted radiance */
    double specularity;   /* plastic, metal, trans */
    double transmission;  /* trans: transmitted part of what is not specularly reflected */
    double straight;      /* trans: straight part of what is transmitted */
    double index;         /* glass, dielectric: refractive index */
    double extinction[3]; /* dielectric, mist [1/unit] */
    double scattering[3]; /* mist: albedo * extinction [1/unit] */
    double eccentricity;  /* mist: Henyey-Greenstein g */
    struct vec spot_axis; /* spotlight */
    double spot_cosine;   /* spotlight: cosine of half the full angle */
};

static inline bool material_emits(const struct material *m)
{
    return m->kind == MATERIAL_LIGHT || m->kind == MATERIAL_GLOW ||
           m->kind == MATERIAL_SPOTLIGHT;
}

static inline bool material_bounds_medium(const struct material *m)
{
    return m->kind == MATERIAL_DIELECTRIC || m->kind == MATERIAL_MIST;
}

static inline bool material_is_transparent(const struct material *m)
{
    return material_bounds_medium(m) || m->kind == MATERIAL_GLASS;
}

enum shape_kind {
    SHAPE_POLYGON,
    SHAPE_SPHERE, /* and bubble */
    SHAPE_RING,
    SHAPE_CONE, /* and cup, cylinder, tube: side only, as in Radiance */
    SHAPE_SOURCE
};

struct shape {
    enum shape_kind kind;
    size_t material;      /* index into the scene's materials */
    bool inward;          /* bubble, cup, tube: front side is the inner one */
    double area;          /* local shapes [unit^2]; a source's solid angle [sr] */
    struct vec *vertices; /* polygon */
    size_t vertex_count;
    struct vec u, v;                   /* polygon: axes in its plane, u along the first edge */
    double u_min, u_max, v_min, v_max; /* polygon: extent along them, from the first vertex */
    struct vec center;                 /* sphere, ring; a cone's first end */
    struct vec
        axis;      /* normal of polygon and ring; unit axis of a cone; direction to a source */
    double r0, r1; /* ring: inner, outer; cone: at first, second end; sphere: r0 */
    double length; /* cone: along its axis */
    double cosine; /* source: of half its full angle */
};

struct ref_scene {
    struct material *materials;
    size_t material_count;
    struct shape *shapes; /* local ones and sources, in the order of the text */
    size_t shape_count;
    bool has_media;
    double epsilon; /* hits nearer than this belong to the ray's start: 1e-12 of the extent */
};

static inline const struct material *shape_material(const struct ref_scene *scene,
                                                    const struct shape *shape)
{
    return &scene->materials[shape->material];
}

/* Distances at which a ray meets a local shape, ascending, of either sign.
 *   starts_here  the ray starts on this shape: the root at its start is left out, exactly (none
 *                for planar shapes, the far one for curved ones), without an epsilon
 * Returns their number, 0 to 2. */
size_t ref_shape_roots(const struct shape *shape, struct vec origin, struct vec direction,
                       bool starts_here, double t[2]);

/* Unit normal on the front side at a point of the surface. */
struct vec ref_shape_normal(const struct shape *shape, struct vec point);

/* A direction from a point to a light. Spheres seen from outside and distant sources are
 * sampled uniformly in solid angle, the rest uniformly in area. */
struct light_sample {
    struct vec direction;
    double distance; /* INFINITY for a distant source */
    double pdf_solid_angle;
};

/* Returns false for a draw that shows the light's back and so carries no light. */
bool ref_shape_sample(const struct shape *shape, struct vec from, struct ref_rng *rng,
                      struct light_sample *sample);

#endif
