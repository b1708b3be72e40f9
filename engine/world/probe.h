#ifndef PM_WORLD_PROBE_H
#define PM_WORLD_PROBE_H

#include <math.h>

#include "world/body.h"
#include "world/rays.h"

/* One ray on its way through a body: what the exact tests need, and the best that they found.
 * Keys, limit and tolerance are those of the world's ray, whatever the body. */
struct pm_probe {
    const struct pm_body *body;
    pm_vec3 origin, direction; /* in the body's coordinates, the origin moved into its cube */
    double entry; /* how far the origin was moved, in the body's units (not the main body's) */
    double unit, inverse_unit; /* the body's unit of length */
    bool sheared;              /* whether the next three are there: pm_probe_shear */
    double o[3];               /* origin */
    double shear[2];
    int axis[3]; /* the direction's greatest axis last; the other two span the sheared plane */
    uint32_t base;     /* number of the body's first surface */
    uint32_t material; /* that replaces those of its surfaces, or PM_NO_PRIMITIVE */
    double tolerance;

    double main_entry; /* how far the world's origin was moved into its cube */
    double limit;
    uint32_t from, from_group; /* of the surface that the ray starts from, or PM_NO_PRIMITIVE */
    bool foreign; /* that surface is another body's: what coincides with it is not known */
    struct pm_ray_key after, best; /* hits up to `after` are behind; best.t = INFINITY: none */
    uint32_t best_surface, best_piece; /* PM_NO_PRIMITIVE: no polygon */
};

/* The cube in which rays live is a little larger than [-1, 1]^3. */
#define PM_CUBE_MARGIN 0x1p-20

/* False for rays that can meet nothing: not finite, without direction, past the cube, or empty.
 */
bool pm_probe_init(struct pm_probe *probe, const pm_world *world, const pm_ray *ray);

/* The same ray in the coordinates of an instance's body. False if it passes the body's cube.
 * The rest of `inner` is as in `outer`. */
bool pm_probe_enter(struct pm_probe *inner, const struct pm_probe *outer,
                    const struct pm_instance *instance);

/* Sets what the watertight tests need, once they ask for it. */
void pm_probe_set_shear(struct pm_probe *probe);

static inline void pm_probe_shear(struct pm_probe *probe)
{
    if (!probe->sheared)
        pm_probe_set_shear(probe);
}

/* The exact test of a ring or a curved shape. True if it is the best so far. */
bool pm_probe_shape(struct pm_probe *probe, uint32_t index);

/* Sets `foreign` for the probe's body. */
static inline void pm_probe_set_foreign(struct pm_probe *probe)
{
    probe->foreign =
        probe->from != PM_NO_PRIMITIVE && probe->from - probe->base >= probe->body->own_count;
}

/* The distance along the world's ray. */
static inline double pm_probe_along(const struct pm_probe *probe, double t)
{
    return (probe->entry + t) * probe->unit;
}

/* And back. */
static inline double pm_probe_local(const struct pm_probe *probe, double along)
{
    return along / probe->unit - probe->entry;
}

/* Whether the ray starts from the group of the body's surface with that number. */
static inline bool pm_probe_starts_on(const struct pm_probe *probe, uint32_t group)
{
    return probe->base + group == probe->from_group;
}

/* A surface without a material is not there. */
static inline bool pm_probe_sees(const struct pm_probe *probe, uint32_t material)
{
    return material != PM_NO_PRIMITIVE || probe->material != PM_NO_PRIMITIVE;
}

static inline bool pm_ray_key_precedes(const struct pm_ray_key *a, const struct pm_ray_key *b)
{
    if (a->t != b->t)
        return a->t < b->t;
    return a->group != b->group ? a->group < b->group : a->order < b->order;
}

/* `cosine`: of the direction with the shape's front normal. */
static inline struct pm_ray_key pm_ray_key_make(double t, uint32_t group, int64_t layer,
                                                bool flipped, double cosine)
{
    int64_t order = (cosine < 0) != flipped ? layer : -layer;
    return (struct pm_ray_key){t, group, order};
}

/* A surface passes within rounding of the ray's end: it is what the ray was aimed at, or
 * coincides with it. */
static inline bool pm_probe_is_at_end(const struct pm_probe *probe, double t, double cosine)
{
    double gap = probe->limit - t;
    return !(gap > 0 && gap * fabs(cosine) > probe->tolerance);
}

/* A surface of another body than the one that the ray starts from passes within rounding of
 * the start: it coincides with that one, and to meet it or not would be chance. So of two
 * equal instances at one place neither shades the other. */
static inline bool pm_probe_is_at_start(const struct pm_probe *probe, double t, double cosine)
{
    return probe->foreign && t * fabs(cosine) <= probe->tolerance;
}

/* Whether a hit at t could be the best; before its place in the shape is known. */
static inline bool pm_probe_wants(const struct pm_probe *probe, double t, double cosine)
{
    return t >= probe->after.t && t <= probe->best.t && !pm_probe_is_at_end(probe, t, cosine) &&
           !pm_probe_is_at_start(probe, t, cosine);
}

/* Whether the hit is the best so far. At t = 0 only what coincides with the surface that the
 * ray starts from counts, and of that what lies ahead. */
static inline bool pm_probe_accepts(const struct pm_probe *probe, const struct pm_ray_key *key)
{
    if (!(key->t > 0 || (key->t == 0 && key->group == probe->from_group)))
        return false;
    return pm_ray_key_precedes(&probe->after, key) && pm_ray_key_precedes(key, &probe->best);
}

/* `local` is its surface's number in the body. */
static inline void pm_probe_take(struct pm_probe *probe, const struct pm_ray_key *key,
                                 uint32_t local, uint32_t piece)
{
    probe->best = *key;
    probe->best_surface = probe->base + local;
    probe->best_piece = piece;
}

/* Takes the hit if it is the best so far. */
static inline bool pm_probe_offer(struct pm_probe *probe, const struct pm_ray_key *key,
                                  uint32_t local, uint32_t piece)
{
    if (!pm_probe_accepts(probe, key))
        return false;
    pm_probe_take(probe, key, local, piece);
    return true;
}

#endif
