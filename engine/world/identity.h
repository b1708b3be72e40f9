#ifndef PM_WORLD_IDENTITY_H
#define PM_WORLD_IDENTITY_H

#include "world/body.h"
#include "world/world_internal.h"

/* What lies together: the main scene, or a prototype. Scene primitives, by digest. */
struct pm_content {
    uint32_t *surfaces; /* local ones; an octree's count if they cannot be seen, too: what
                           places it may replace its materials */
    pm_digest *digests;
    size_t surface_count;
    uint32_t *instances; /* instances and meshes */
    pm_digest *instance_digests;
    size_t instance_count;
    pm_digest digest; /* of all that; a prototype's */
};

/* Who is who, by content.
 *   material  SHA-256(type, modifier's digest, numbers, what its strings name, transform)
 *             and, if antimatters list it, SHA-256 of that and their sorted digests
 *   surface   SHA-256(type, material's digest, numbers)
 *   instance  SHA-256(type, material's digest, prototype's digest, transform)
 *   octree    SHA-256("octree", digests of its surfaces, "instances", those of its instances)
 *   mesh      SHA-256("mesh", digest of the file, digests of its materials in their order)
 * A mist's light names do not count, since every light scatters in every mist.
 * Numbers are little-endian doubles in scene units, -0 as 0. Names, comments, order and unused
 * materials do not count. A polygon written from another first vertex is another surface. A
 * surface without a material is not there, but for those of octrees; neither is an instance
 * whose modifier comes to none, nor a `source` in an octree, as in Radiance. */
struct pm_identity {
    struct pm_content main;
    uint32_t *sources; /* scene primitives, by digest */
    pm_digest *source_digests;
    size_t source_count;
    struct pm_content *prototypes; /* [scene->prototype_count] */
    uint32_t *order; /* prototypes that are placed, those within others before them */
    size_t order_count;
    struct pm_material_table materials;
    pm_arena arena; /* of all of that */
};

/* PM_E_RANGE for an octree that holds itself; PM_E_LIMIT for those that nest too deep. */
PM_MUST_USE pm_status pm_identity_make(const pm_scene *scene, struct pm_identity *out,
                                       pm_error *err);
void pm_identity_clear(struct pm_identity *identity);

#endif
