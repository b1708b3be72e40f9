#ifndef PM_WORLD_INTERNAL_H
#define PM_WORLD_INTERNAL_H

#include "base/arena.h"
#include "scene/assets.h"
#include "world/shape.h"
#include "world/world.h"

/* What the files of this folder share. Nothing outside it includes this header.
 *
 * Compile order (world.c): digests, sorted (identity.c) -> bounds and cubes (bodies.c, cube.c)
 * -> materials -> shapes in their body's coordinates (shape_make.c), meshes, instances
 * (bodies.c) -> octree.c -> coincident shapes (twins.c) -> rays.c -> lights. */

struct pm_material; /* material.h */
struct pm_lights;   /* light.c */
struct pm_rays;     /* rays.c */
struct pm_body;     /* body.h */

/* A `source`: radiance from a cone of directions, infinitely far away. */
struct pm_distant {
    pm_vec3 direction; /* unit, from the scene to the centre of the source */
    double half_angle; /* [rad], 0 < half_angle <= pi */
    double versine;    /* 1 - cos(half_angle), without cancellation */
    uint32_t material;
    uint32_t primitive; /* of the scene that it was made from: for messages alone */
};

/* Antimatter goes by modifier, not by content: of two equal plastics it may list only one. So
 * the digest of a material that antimatter lists also covers the sorted digests of the
 * antimatters that list it (whose own digests cover the bare contents of what they list).
 *
 * Which scene primitives the world's materials come from: modifiers of surfaces, and those that
 * materials and mixtures name, each with its chain. Those with equal digests (type, arguments,
 * files, chain and references by content) are one; they are sorted by digest. */
struct pm_material_table {
    size_t count;
    const uint32_t *primitive; /* [count]: the top of a chain with that content */
    const pm_digest *digest;   /* [count] */
    /* [scene->count]: the material that a chain from there became, PM_NO_PRIMITIVE if none. Use
     * it to translate pm_primitive.references. */
    const uint32_t *of_primitive;
};

/* The modifiers of surfaces, as selections name them. */
struct pm_modifier_names {
    size_t count;
    struct pm_modifier_chain {
        const char *name;         /* as the surface says it: that of an alias, too */
        uint32_t length;          /* of the chain from there on */
        uint32_t material;        /* where in it the material stands; 0 if there is none */
        const char *const *names; /* [length] of the primitives in it */
    } * chains;                   /* [count] */
};

struct pm_world {
    pm_arena arena; /* everything below that is not said to be elsewhere */

    /* Prototypes, each after those that it places, and the main scene last (body.h). */
    struct pm_body *bodies;
    size_t body_count;
    const struct pm_body *main;

    /* The main scene's. */
    pm_vec3 center;   /* of the cube [scene units] */
    double scale;     /* half its edge [scene units] */
    double tolerance; /* rounding of the scene's own numbers, seen from here: closer is
                         coincident */
    pm_vec3 low, high;
    pm_digest hash;
    size_t octree_nodes;

    /* Local surfaces of the main scene, without its instances, and distant sources,
     * each sorted by digest. */
    size_t shape_count;
    struct pm_shape *shapes;
    const pm_digest *shape_digests;
    size_t distant_count;
    struct pm_distant *distants;
    const pm_digest *distant_digests;

    struct pm_assets *assets; /* a share: files and functions of the modifiers */
    size_t text_size;         /* bytes of the texts that modifiers set; modifier.c */

    /* Filled by pm_materials_compile (material.c); freed with the arena. */
    size_t material_count;
    struct pm_material *materials;
    struct pm_modifier_names modifiers;
    bool passes_straight;  /* some used material has a straight part (glass, trans, antimatter,
                              illum with void) */
    bool hides_back_faces; /* surfaces are seen from the front alone */
    bool has_media; /* some used material is a mist, an absorbing dielectric or antimatter */

    struct pm_lights *lights; /* pm_lights_build (light.c); freed with the arena */
    struct pm_rays *rays;     /* rays.c */
};

/* material.c: fills `materials`, `passes_straight` and `has_media` from the table. Extinctions
 * are multiplied by world->scale (set before). world->materials[i] comes from
 * table->primitive[i]. */
PM_MUST_USE pm_status pm_materials_compile(pm_world *world, const pm_scene *scene,
                                           const struct pm_material_table *table,
                                           pm_error *err);

/* light.c: called last; shapes, materials and distants are complete. */
PM_MUST_USE pm_status pm_lights_build(pm_world *world, pm_error *err);
size_t pm_lights_count(const pm_world *world); /* surfaces and distant sources that emit */

/* surface.c: the part of the light that goes straight through the surface at a hit of a shadow
 * ray (from the receiver to the light) that `media` hold; black for what is opaque, refracting
 * or scattering. A ray that goes on crosses the media there (pm_media_cross). */
pm_rgb pm_material_straight(const pm_world *world, const pm_hit *hit, pm_vec3 direction,
                            const struct pm_media *media, bool weak);

/* material.c: for pm_world_info. */
bool pm_material_is_specular(const struct pm_material *material);
bool pm_material_is_diffuse(const struct pm_material *material);
bool pm_material_is_mist(const struct pm_material *material); /* one that scatters */

#endif
